"""Flags as an xarray Dataset."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import xarray

    from ._hexcast import RawMesh


def dataset(mesh: RawMesh, dims: tuple[int, ...], flags: Any) -> xarray.Dataset:
    """Flags of shape (z, y, x) on so many cells along x, y, z, which begin where those of a mesh do."""
    import xarray

    units = {} if mesh.unit is None else {"units": mesh.unit}
    coordinates = {}
    for axis, name in enumerate("xyz"):
        centres = mesh.origin[axis] + (np.arange(dims[axis]) + 0.5) * mesh.spacing[axis]
        coordinates[name] = (name, centres, units)
    names = dict(mesh.names)
    meanings = ["background", *("_".join(name.split()) or "unnamed" for name in names.values())]
    attributes = {"flag_values": np.array([0, *names], np.uint8), "flag_meanings": " ".join(meanings)}
    return xarray.Dataset({"flag": (("z", "y", "x"), flags, attributes)}, coordinates)
