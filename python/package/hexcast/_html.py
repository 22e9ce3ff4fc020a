"""A mesh as notebooks show it."""

from __future__ import annotations

import base64
from collections.abc import Callable, Mapping
from html import escape
from typing import Any

from ._error import Error

#: Pixels of the longest side of the mesh in the picture.
PIXELS = 240


def html_of(report: Mapping[str, Any], slices: Callable[[int], bytes]) -> str:
    """A table of the flags, and a slice across each axis: ``slices`` draws them with so many pixels."""
    dims, spacing, unit = report["dims"], report["spacing"], f" {report['unit']}" if report["unit"] else ""
    rows = "".join(
        f"<tr><td>{flag['flag']}</td><td>{escape(flag['name'])}</td><td>{flag['cells']:,}</td></tr>" for flag in report["flags"]
    )
    size = "cells differ in size" if spacing is None else "cells of " + " x ".join(f"{length:g}" for length in spacing) + unit
    head = f"<b>hexcast.Mesh</b>: {' x '.join(map(str, dims))} cells, {escape(size)}"
    table = f"<table><tr><th>flag</th><th>name</th><th>cells</th></tr>{rows}</table>"
    try:
        picture = base64.b64encode(slices(PIXELS)).decode()
    except Error:
        # what memory does not hold is not shown
        return f"<div>{head}{table}</div>"
    return f'<div>{head}{table}<img alt="slices across z, y and x" src="data:image/png;base64,{picture}"></div>'
