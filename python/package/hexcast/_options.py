"""The options of a mesh and of a geometry: those of a job file, with the same meaning. Made by ``npm run options`` of docs/job.schema.json."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, TypedDict, Union

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
    #: Name in reports and outputs; by default the file's without its extension.
    name: str
    #: Flag of its cells, 1 to 255; by default 1, 2, ... in the order of the job.
    flag: int
    #: Where geometries overlap, the higher priority wins; of equal ones a geometry that is closed or flat wins over one that is not, else
    #: the later. Default ``0``.
    priority: int
    #: How cells are decided where its surface is not closed, if not as the job says. ``winding``: by the rays of three axes where they
    #: agree, elsewhere by the generalised winding number. ``vote``: by most of the three axes whose rays cross it an even number of times:
    #: for surfaces that cannot be oriented. ``error``: not at all: an error. ``parity``: by the rays of one axis, up to the last matched
    #: pair of crossings of each.
    open: Literal["winding", "vote", "error", "parity"]
    #: Which cells along its surface it has as well, if not as the job says. ``centre``: No others. ``conservative``: every cell whose box
    #: the surface touches. ``separating``: the cells that separate the two sides of the surface: no path from face neighbour to face
    #: neighbour leads through it.
    fill: Literal["centre", "conservative", "separating"]
    #: Only the cells along its surface, and none for being inside; by default the ``separating`` ones.
    shell: bool
    #: The cells outside of it instead of those inside: the fluid around a body, or within a wall that fills the rest of the domain.
    invert: bool
    #: With ``graded``: largest size of a cell across it.
    max_size: float
    #: With ``graded``: fewest cells across it along every axis, at least 1.
    min_cells: int
    #: With ``graded``: whether it is metal, so that the lines nearest to its edges lie a third of a cell inside and two thirds outside.
    metal: bool
    #: What it is made of: passed on to every output, and not used otherwise. Keys: ``eps_r``, ``mu_r``, ``sigma``, ``pec``, ``density``,
    #: ``E``, ``nu``.
    material: Mapping[str, Any]
    #: Scales first: one factor, or one an axis.
    scale: PerAxis
    #: Then rotates about x, y and z, in degrees.
    rotate: Sequence[float]
    #: The point about which it rotates, where it is once scaled; by default the origin.
    about: Sequence[float]
    #: Then moves, in the unit of the result.
    translate: Sequence[float]


class JobOptions(TypedDict, total=False):
    """The options of a mesh: the keys of a job file. Lengths are in the unit of the surfaces."""

    #: Two corners of the box, x0 y0 z0 x1 y1 z1; by default the box around all geometries. Padding comes on top.
    domain: Sequence[float]
    #: Space added on both sides of every axis, to ``domain`` or to the box around the geometries: whole cells, or a length. Such as
    #: ``{"cells": 4}`` or ``{"length": 0.5}``.
    padding: Mapping[str, PerAxis]
    #: Cubic cells, so many along the longest axis; 128 where no size is given. At most one of ``cells``, ``dims``, ``cell_size``,
    #: ``max_cell_size``, ``lines`` and ``graded`` is given.
    cells: int
    #: Exactly so many cells on x, y and z, over the domain; padding by cells comes on top.
    dims: Sequence[int]
    #: Cell size on all axes or each.
    cell_size: PerAxis
    #: Upper limit of the cell size: the largest size per axis, at most this, that puts every end point of every bounding box on a mesh
    #: line.
    max_cell_size: float
    #: Largest distance of an end point from its mesh line, in cells, with ``max_cell_size``: 0 to 0.5, by default 0.05.
    tolerance: float
    #: All lines of each axis, ascending, in the unit of the files: cells + 1 numbers each, at most 262,143. The first and the last are the
    #: domain. Keys: ``x``, ``y``, ``z``. Such as ``{"x": [...], "y": [...], "z": [...]}``.
    lines: Mapping[str, Sequence[float]]
    #: Generates lines of cells that differ in size: one on every end of every geometry's box, close where geometries are small, far
    #: elsewhere. Keys: ``max_size``, ``min_size``, ``growth``, ``absorbing``.
    graded: Mapping[str, Any]
    #: Most cells, however they are chosen; without it only those of an axis are limited. A mesh of more is refused before it starts. By
    #: default 10^12.
    max_cells: int
    #: Meshes only some cells of the box, i0 j0 k0 i1 j1 k1: the first on each axis, and the end, exclusive. Lines, flags and all else are
    #: those of the whole box.
    window: Sequence[int]
    #: Meshes only one of the windows that the box is divided into: ``index`` from 1 on, x fastest, ``of`` so many along x, y and z. Keys:
    #: ``index``, ``of``. Also ``"3/64"`` of slabs across z, ``"3/4x4x4"`` of boxes.
    part: Union[str, Mapping[str, Any]]
    #: Cells around the window or the part that are also meshed, on both sides of every axis.
    halo: int
    #: What the halo has beyond the box: background, the default, or the flag of the nearest cell of the box. ``background``: background.
    #: ``clamp``: the flag of the nearest cell of the box.
    halo_edge: Literal["background", "clamp"]
    #: Shapes of the chunks and shards of a Zarr store, as cells on x, y, z, or most bytes of a shard. Where it is given, parts are cut
    #: along the borders of shards. Keys: ``chunks``, ``shards``, ``shard_bytes``, ``levels``, ``sparse``.
    zarr: Mapping[str, Any]
    #: What is inside a surface. ``parity``: inside is where a ray has crossed the surface an odd number of times. Facet orientation does
    #: not matter. ``nonzero``: inside is where the winding number is not zero. Overlapping shells unite; orientation matters. Default
    #: ``parity``.
    rule: Literal["parity", "nonzero"]
    #: How cells are decided where a surface is not closed; a geometry may say otherwise. ``winding``: by the rays of three axes where they
    #: agree, elsewhere by the generalised winding number. ``vote``: by most of the three axes whose rays cross it an even number of times:
    #: for surfaces that cannot be oriented. ``error``: not at all: an error. ``parity``: by the rays of one axis, up to the last matched
    #: pair of crossings of each. Default ``winding``.
    open: Literal["winding", "vote", "error", "parity"]
    #: Which cells geometries have besides those whose centres lie inside; a geometry may say otherwise. ``centre``: No others.
    #: ``conservative``: every cell whose box the surface touches. ``separating``: the cells that separate the two sides of the surface: no
    #: path from face neighbour to face neighbour leads through it. Default ``centre``.
    fill: Literal["centre", "conservative", "separating"]
    #: Makes every solid (part, node, item) of every file a geometry of its own.
    split: bool
    #: Gives every geometry the cells outside of it in place of those inside, such as the fluid around a body.
    invert: bool
    #: Closes openings narrower than this number of cells along x, y or z, at least 2, and no wider ones: background cells get ``gap_flag``
    #: if fewer than that many in a row lie between flagged cells. Dents and slits as narrow as that are filled, too.
    close_gaps: int
    #: Flag of the cells that ``close_gaps`` adds, 1 to 255; by default one more than the greatest flag of a geometry.
    gap_flag: int
    #: Looks for thin walls and for cells that two geometries claim; takes several times as long as a mesh on the CPU. What is found is in
    #: ``report["certificate"]``.
    certify: bool
    #: Leaves out the checks that are made of every mesh: whether shells have no cell, or another volume than their surface.
    quick: bool
    #: With ``certify``: walls of fewer cells are thin, at least 1; by default 2.
    thin_cells: int
    #: Measures the links from cells of a fluid to surfaces. Keys: ``stencil``, ``fluid``. Counted in ``report["links"]``.
    links: Mapping[str, Any]
    #: Axes along which the box continues with itself, so that links lead through its sides.
    periodic: Sequence[Literal["x", "y", "z"]]
    #: Measures the fraction of each flag in the cells that surfaces cut. Keys: ``method``, ``rays``, ``faces``, ``surfaces``, ``edges``,
    #: ``centroids``. Counted in ``report["fractions"]``.
    fractions: Mapping[str, Any]
    #: Finds the flags at the points of a staggered (Yee) grid. Counted in ``report["staggered"]``.
    staggered: bool
    #: Flags of perfect conductors on a staggered grid: all edges of their cells conduct, not only those within the surface.
    conductors: Sequence[int]
    #: Measures the fractions of edges and faces that lie outside metal. Keys: ``metal``, ``stable``. Counted in ``report["conformal"]``.
    conformal: Mapping[str, Any]
    #: Measures the signed distance of centres or nodes to the nearest surface. Keys: ``at``, ``band``, ``flags``. Described in
    #: ``report["distance"]``.
    distance: Mapping[str, Any]
    #: Averages the permittivity in the cell around each point of E, as tensors. Keys: ``anisotropic``. Counted in ``report["tensors"]``.
    tensors: Mapping[str, Sequence[Mapping[str, Any]]]
    #: Cuts the cells of one flag at its surface, for files that hold cut cells. Keys: ``fluid``, ``boundary``. Files that end in ``.foam``
    #: then have cut cells; ``.eb`` needs ``boundary``.
    cut_cells: Mapping[str, Any]
    #: What meshes: the GPU or the CPU; the cells do not depend on it. ``auto``: the GPU where there is an adapter, else the CPU. ``gpu``:
    #: the GPU; an error where there is none. ``cpu``: the CPU. Default ``auto``.
    backend: Literal["auto", "gpu", "cpu"]
    #: Along which axis the rays run; the cells do not depend on it. ``auto``: the axis with most cells; those with less than an eighth
    #: fewer count as equal, and of equals the first is taken. ``x``: along x. ``y``: along y. ``z``: along z. Default ``auto``.
    axis: Literal["auto", "x", "y", "z"]
    #: Most bytes of memory to take, as a number or as text such as "2GB"; what does not fit is refused before it starts, unless its
    #: columns may spill to disk. By default 3/4 of what is available.
    max_memory: Union[int, str]
    #: Unit of the files' lengths, such as "mm"; repeated in every output.
    unit: str
    #: Largest distance of the triangles of STEP and IGES files from their surfaces, in the unit of the job; by default a tenth of the
    #: smallest cell.
    deviation: float
    #: Name and substance of the cells of no geometry, flag 0. Keys: ``name``, ``material``. Such as ``{"name": "air", "material":
    #: {"eps_r": 1}}``.
    background: Mapping[str, Any]


#: Names of the options of a geometry, and of a job.
GEOMETRY_KEYS = tuple(GeometryOptions.__annotations__)
JOB_KEYS = tuple(JobOptions.__annotations__)
