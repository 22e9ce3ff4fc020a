"""Flags as an xarray Dataset."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ._error import Error

if TYPE_CHECKING:
    import xarray

    from ._hexcast import RawMesh


def dataset(mesh: RawMesh, dims: tuple[int, ...], flags: Any) -> xarray.Dataset:
    """Flags of shape (z, y, x) on so many cells along x, y, z, which begin where those of a mesh do."""
    import xarray

    units = {} if mesh.unit is None else {"units": mesh.unit}
    coordinates = {}
    for axis, name in enumerate("xyz"):
        coordinates[name] = (name, centres_of(mesh, axis, dims[axis]), units)
    names = dict(mesh.names)
    meanings = ["background", *("_".join(name.split()) or "unnamed" for name in names.values())]
    attributes = {"flag_values": np.array([0, *names], np.uint8), "flag_meanings": " ".join(meanings)}
    return xarray.Dataset({"flag": (("z", "y", "x"), flags, attributes)}, coordinates)


def centres_of(mesh: RawMesh, axis: int, n: int) -> NDArray[np.float64]:
    """The centres of the first cells of an axis."""
    if mesh.spacing is not None:
        return np.asarray(mesh.origin[axis] + (np.arange(n) + 0.5) * mesh.spacing[axis])
    lines = mesh.lines(axis)
    if n + 1 > len(lines):
        message = f"cells differ in size, and of {n} cells along an axis the lines of {len(lines) - 1} are known"
        raise Error(message, "lines-graded", "mesh the whole box at once, or use equal cells")
    return np.asarray(0.5 * (lines[:-1] + lines[1:])[:n])
