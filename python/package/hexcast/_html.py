"""A mesh as notebooks show it."""

from __future__ import annotations

import base64
from html import escape
from typing import TYPE_CHECKING

from ._error import Error

if TYPE_CHECKING:
    from ._mesh import Mesh

#: Pixels of the longest side of the mesh in the picture.
PIXELS = 240


def html_of(mesh: Mesh) -> str:
    """A table of the flags, and a slice across each axis."""
    unit = f" {mesh.unit}" if mesh.unit else ""
    rows = "".join(
        f"<tr><td>{flag['flag']}</td><td>{escape(flag['name'])}</td><td>{flag['cells']:,}</td></tr>" for flag in mesh.report["flags"]
    )
    size = "cells differ in size" if mesh.spacing is None else "cells of " + " x ".join(f"{length:g}" for length in mesh.spacing) + unit
    head = f"<b>hexcast.Mesh</b>: {' x '.join(map(str, mesh.dims))} cells, {escape(size)}"
    table = f"<table><tr><th>flag</th><th>name</th><th>cells</th></tr>{rows}</table>"
    try:
        picture = base64.b64encode(mesh.slice(size=PIXELS)).decode()
    except Error:
        # what memory does not hold is not shown
        return f"<div>{head}{table}</div>"
    return f'<div>{head}{table}<img alt="slices across z, y and x" src="data:image/png;base64,{picture}"></div>'
