"""The names of all options: those of a job file, with the same meaning."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, TypedDict, Union

from ._error import InvalidType

if TYPE_CHECKING:
    from ._surface import SurfaceLike

PerAxis = Union[float, Sequence[float]]


class GeometryOptions(TypedDict, total=False):
    """A surface and what its cells shall be: ``file`` or ``source``, and the keys of ``[[geometries]]`` in a job file."""

    #: Name of a file: STL, OBJ, PLY, OFF, 3MF or GLB, also packed by gzip.
    file: str
    #: A surface in memory, in place of ``file``: see :func:`hexcast.surface`.
    source: SurfaceLike
    #: Takes only the solid of this name from an ASCII file of several.
    solid: str
    #: Makes every solid of the file a geometry of its own, named like the solid, flags counting up.
    split: bool
    #: With ``split`` and ``flag`` every solid has this flag, in place of flags that count up.
    same_flag: bool
    #: Name in reports and outputs.
    name: str
    #: Flag of its cells, 1 to 255; by default 1, 2, ... in the order of the geometries.
    flag: int
    #: Where geometries overlap the higher priority wins; of equal ones a closed over an open geometry, else the later.
    priority: int
    #: How cells are decided where the surface is not closed.
    open: Literal["winding", "vote", "error", "parity"]
    #: Which cells it has besides those whose centres lie inside.
    fill: Literal["centre", "conservative", "separating"]
    #: Only the cells along the surface, none for being inside.
    shell: bool
    #: The cells outside of it in place of those inside, such as the fluid around a body.
    invert: bool
    #: Largest size of a cell across it, where lines are generated (``graded``).
    max_size: float
    #: Fewest cells across it along every axis, where lines are generated.
    min_cells: int
    #: Whether it is metal: generated lines lie a third of a cell inside of its edges and two thirds outside.
    metal: bool
    #: What it is made of, passed on to every output: ``eps_r``, ``mu_r``, ``sigma`` (S/m), ``pec``, ``density`` (kg/m3), ``E`` (Pa), ``nu``.
    material: Mapping[str, Any]
    #: Scales first: a number, or three for x, y, z.
    scale: PerAxis
    #: Then rotates about x, y and z, in degrees.
    rotate: Sequence[float]
    #: The point about which it rotates, where it is once scaled; by default the origin.
    about: Sequence[float]
    #: Then moves, in the unit of the result.
    translate: Sequence[float]


class JobOptions(TypedDict, total=False):
    """The options of a mesh: the keys of a job file. Lengths are in the unit of the surfaces."""

    #: Two corners of the box, ``(x0, y0, z0, x1, y1, z1)``; by default the box around all geometries.
    domain: Sequence[float]
    #: Space around the geometries on both sides: ``{"cells": 4}`` or ``{"length": 0.5}``, a number or three for x, y, z.
    padding: Mapping[str, PerAxis]
    #: Cubic cells, so many along the longest axis; 128 where no size is given.
    cells: int
    #: Exactly so many cells on x, y and z.
    dims: Sequence[int]
    #: Cell size, a number or three for x, y, z.
    cell_size: PerAxis
    #: The largest size per axis, at most this, that puts every end point of every bounding box on a mesh line.
    max_cell_size: float
    #: How far from a mesh line, in cells, ``max_cell_size`` lets an end point lie, 0 to 0.5; by default 0.05.
    tolerance: float
    #: All lines of each axis, ascending: ``{"x": [...], "y": [...], "z": [...]}``; cells may differ in size.
    lines: Mapping[str, Sequence[float]]
    #: Generates lines of cells that differ in size: ``max_size``, and ``min_size``, ``growth``, ``absorbing`` if not as by default.
    graded: Mapping[str, Any]
    #: Most cells, by default 10^12; a mesh of more is refused before it starts.
    max_cells: int
    #: Meshes only some cells of the box, ``(i0, j0, k0, i1, j1, k1)``: the first, and the end, exclusive.
    window: Sequence[int]
    #: Meshes one of the windows that the box is divided into: ``"3/64"`` of slabs across z, ``"3/4x4x4"`` of boxes.
    part: Union[str, Mapping[str, Any]]
    #: Cells beyond the window or the part, on both sides of every axis.
    halo: int
    #: What the halo has beyond the box: background, the default, or the flag of the nearest cell of the box.
    halo_edge: Literal["background", "clamp"]
    #: Shapes of Zarr stores: ``chunks`` and ``shards`` as cells on x, y, z, or ``shard_bytes``. Where it is given, parts are cut along
    #: the borders of shards.
    zarr: Mapping[str, Any]
    #: What is inside: an odd number of crossings, or a winding number other than 0, which unites shells that overlap.
    rule: Literal["parity", "nonzero"]
    #: As for a geometry, for all that do not say.
    open: Literal["winding", "vote", "error", "parity"]
    #: As for a geometry, for all that do not say.
    fill: Literal["centre", "conservative", "separating"]
    #: As for a geometry, for all.
    split: bool
    #: As for a geometry, for all.
    invert: bool
    #: Closes openings narrower than so many cells, at least 2.
    close_gaps: int
    #: Flag of the cells that this adds, 1 to 255.
    gap_flag: int
    #: Looks for thin walls and for cells that two geometries claim: ``report["certificate"]``.
    certify: bool
    #: Leaves out the checks that are made of every mesh: whether shells have no cell, or another volume than their surface.
    quick: bool
    #: Walls of fewer cells are thin.
    thin_cells: int
    #: Links from cells of a fluid to surfaces, counted in ``report["links"]``: ``stencil``, such as ``"D3Q19"``, and ``fluid``, a list of flags.
    links: Mapping[str, Any]
    #: Axes along which the box continues with itself, so that links lead through its sides.
    periodic: Sequence[Literal["x", "y", "z"]]
    #: Cells that surfaces cut, and the volumes of flags, in ``report["fractions"]``: ``rays``, those of a cell along each axis;
    #: ``surfaces``, whether to add the areas of geometries.
    fractions: Mapping[str, Any]
    #: Points of a staggered grid, counted in ``report["staggered"]``.
    staggered: bool
    #: Flags of perfect conductors on a staggered grid: all edges of their cells conduct, not only those within the surface.
    conductors: Sequence[int]
    #: Who meshes; ``"auto"`` takes a GPU where there is one. The cells do not depend on it.
    backend: Literal["auto", "gpu", "cpu"]
    #: Along which axis the rays run; the cells do not depend on it.
    axis: Literal["auto", "x", "y", "z"]
    #: Most bytes of memory to take, as a number or text such as ``"2GB"``; by default 3/4 of what is available.
    max_memory: Union[int, str]
    #: Unit of lengths, such as ``"mm"``; repeated in every output.
    unit: str
    #: Name and material of the cells of no geometry, flag 0: ``{"name": "air", "material": {"eps_r": 1}}``.
    background: Mapping[str, Any]


#: Names of the options of a geometry, and of a job.
GEOMETRY_KEYS = tuple(GeometryOptions.__annotations__)
JOB_KEYS = tuple(JobOptions.__annotations__)


def check_names(given: Iterable[object], names: Sequence[str], what: str) -> None:
    """Refuses a name that is not one of these, and names the nearest."""
    for name in given:
        if name in names:
            continue
        near = difflib.get_close_matches(str(name), names, n=1, cutoff=0.0)
        message = f'there is no {what} "{name}"; the nearest is "{near[0]}"'
        raise InvalidType(message, "job-value", f"{what}s are {', '.join(names)}")
