"""The mesh: arrays, windows of it, files."""

from __future__ import annotations

import json
import warnings
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, Optional, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _hexcast
from ._error import Error, InvalidValue, MeshWarning
from ._files import save
from ._html import html_of
from ._measured import (
    Conformal,
    Distances,
    Fractions,
    Links,
    Staggered,
    Tensors,
    conformal_of,
    distances_of,
    fractions_of,
    in_dataset,
    links_of,
    staggered_of,
    tensors_of,
)
from ._pictures import Axis, Picture, Place, look_of, max_bytes, slices
from ._xarray import dataset

if TYPE_CHECKING:
    import os

    import xarray

    from ._surface import Surface

#: What a mesh may have beside its cells.
MEASURED = ("links", "fractions", "staggered", "conformal", "tensors", "distance", "doubt")
#: Bytes of the flags of a slab, unless the caller says.
SLAB_BYTES = 32 << 20


class Slab(NamedTuple):
    """Some of the cells of a mesh."""

    #: The first cell on x, y, z.
    first: tuple[int, int, int]
    #: The end, exclusive.
    end: tuple[int, int, int]
    #: Their flags, of shape (z, y, x).
    flags: NDArray[np.uint8]


class Columns(NamedTuple):
    """The runs of equal flags along all rays: what a mesh is stored as.

    Ray ``r`` has the runs ``offsets[r]`` to ``offsets[r + 1]``, exclusive. A run begins at its start and ends where the next begins,
    the last at the end of the ray; cells before the first are background.
    """

    #: Axis of the rays: 0, 1 or 2 for x, y or z. Rays are counted over the other two axes, the earlier one fastest.
    axis: int
    #: First run of each ray, and the number of runs: shape (rays + 1,), uint64.
    offsets: NDArray[np.uint64]
    #: First cell of each run: shape (runs,), uint32.
    starts: NDArray[np.uint32]
    #: Flag of each run: shape (runs,), uint8.
    flags: NDArray[np.uint8]


class FlagPair(NamedTuple):
    """Cells that have one flag in the first mesh and another in the second."""

    #: The flag in the first mesh.
    one: int
    #: The flag in the second.
    other: int
    #: Number of cells.
    cells: int
    #: The first of them along the rays of the first mesh.
    first: tuple[int, int, int]
    #: The box around them: its first cell, and its end, exclusive.
    bounds: tuple[tuple[int, int, int], tuple[int, int, int]]


class Difference(NamedTuple):
    """What differs between two meshes."""

    #: Number of cells that differ.
    cells: int
    #: Number of all cells.
    n_cells: int
    #: Whether the lines are the same; where they are not, cells were compared by their indices.
    are_lines_equal: bool
    #: The pairs of flags, most cells first.
    pairs: list[FlagPair]
    #: The lines of the first mesh, and flag 1 where the two differ.
    mask: Mesh


class Mesh:
    """A Cartesian mesh: cells between lines, each with a flag.

    :func:`hexcast.mesh` and :func:`hexcast.load` make it. It holds runs of equal flags; :attr:`flags`, :meth:`box` and :meth:`slabs`
    expand them.

    >>> import hexcast
    >>> from hexcast.shapes import box
    >>> mesh = hexcast.mesh(box((0, 0, 0), (4, 3, 2)), cell_size=1, padding={"cells": 1}, backend="cpu")
    >>> mesh
    <hexcast.Mesh of 6 x 5 x 4 cells>
    >>> int(mesh.flags.sum())
    24
    """

    def __init__(self, raw: _hexcast.RawMesh, made_of: Optional[tuple[str, list[Optional[Surface]]]] = None) -> None:
        self._raw = raw
        #: The job, and its surfaces that are in memory.
        self._made_of = made_of

    def __repr__(self) -> str:
        return f"<hexcast.Mesh of {' x '.join(map(str, self.dims))} cells>"

    def _repr_html_(self) -> str:
        """Notebooks show a table of the flags, and slices."""
        return html_of(self.report, lambda size: self.slice(size=size))

    def __getstate__(self) -> dict[str, Any]:
        # flags and runs are made anew
        return {"_raw": self._raw, "_made_of": None, **self._measured()}

    def __array__(self, dtype: Any = None, copy: Optional[bool] = None) -> NDArray[Any]:
        """The flags, as NumPy's functions take them."""
        flags = self.flags
        if dtype is not None and np.dtype(dtype) != flags.dtype:
            if copy is False:
                raise InvalidValue(f"the flags are uint8, and {np.dtype(dtype)} needs a copy", "job-value", "leave out copy=False")
            return flags.astype(dtype)
        return flags.copy() if copy else flags

    def _measured(self) -> dict[str, Any]:
        """What was measured, by its names."""
        made = {name for name in MEASURED if name in self.__dict__}
        return {name: getattr(self, name) for name in MEASURED if name in made or name in _hexcast.measured_kinds(self._raw)}

    @cached_property
    def links(self) -> Links:
        """The links from cells of the fluid to walls, which the option ``links`` asks for.

        >>> import hexcast
        >>> from hexcast.shapes import box
        >>> body = box((2, 2, 2), (4, 4, 4))
        >>> mesh = hexcast.mesh(body, cell_size=1, padding={"cells": 2}, links={"stencil": "D3Q7"}, backend="cpu")
        >>> len(mesh.links), mesh.links.q.dtype, set(mesh.links.q.tolist())
        (24, dtype('float32'), {0.5})
        """
        return links_of(self._raw)

    @cached_property
    def fractions(self) -> Fractions:
        """The fractions of flags in cut cells, which the option ``fractions`` asks for."""
        return fractions_of(self._raw)

    @cached_property
    def staggered(self) -> Staggered:
        """The flags at the points of a staggered grid, which the option ``staggered`` asks for. Seven bytes a cell."""
        return staggered_of(self._raw)

    @cached_property
    def conformal(self) -> Conformal:
        """What of edges and faces lies outside metal, which the option ``conformal`` asks for. 48 bytes a cell."""
        return conformal_of(self._raw)

    @cached_property
    def distance(self) -> Distances:
        """Signed distances to the nearest surface, which the option ``distance`` asks for. 8 bytes a cell."""
        return distances_of(self._raw)

    @cached_property
    def tensors(self) -> Tensors:
        """The permittivity averaged around each point of E, which the option ``tensors`` asks for. 144 bytes a cell."""
        return tensors_of(self._raw)

    @cached_property
    def doubt(self) -> Mesh:
        """The cells that the rays of open surfaces do not decide, which ``doubt=True`` asks for: a mesh with flag 1 there."""
        found = _hexcast.doubt(self._raw)
        if found is None:
            raise Error("the mesh has no mask of doubtful cells", "job-conflict", "mesh with doubt=True")
        return Mesh(found)

    @property
    def dims(self) -> tuple[int, int, int]:
        """Number of cells on x, y and z."""
        return self._raw.dims

    @property
    def origin(self) -> tuple[float, float, float]:
        """First corner of the box, in the unit of the surfaces."""
        return self._raw.origin

    @property
    def spacing(self) -> Optional[tuple[float, float, float]]:
        """Size of a cell on x, y and z, in the unit of the surfaces; None where cells differ in size, see :attr:`lines`."""
        return self._raw.spacing

    @property
    def unit(self) -> Optional[str]:
        """Unit of all lengths, if the caller named one."""
        return self._raw.unit

    @property
    def names(self) -> dict[int, str]:
        """The name of each flag."""
        return dict(self._raw.names)

    @cached_property
    def lines(self) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """The boundaries of the cells on x, y and z: three ascending arrays of shape (cells + 1,), in the unit of the surfaces."""
        return (self._raw.lines(0), self._raw.lines(1), self._raw.lines(2))

    @cached_property
    def report(self) -> dict[str, Any]:
        """What was meshed, how, and what came out: the report of the command, key by key in ``docs/report.schema.json``."""
        report: dict[str, Any] = json.loads(self._raw.report)
        return report

    @cached_property
    def flags(self) -> NDArray[np.uint8]:
        """The flags of all cells: uint8 of shape (nz, ny, nx), so that ``flags[k, j, i]`` is that of cell (i, j, k).

        Made when it is first asked for, a byte a cell, written once into the memory of the array. It cannot be written to, so that it
        stays what :meth:`save` writes: change a ``flags.copy()``. ``flags.T`` has the axes x, y, z, without a copy.

        :raises hexcast.Error: ``memory`` where they do not fit.
        """
        flags = self.box((0, 0, 0), self.dims)
        flags.setflags(write=False)
        return flags

    def box(self, first: Sequence[int], end: Sequence[int]) -> NDArray[np.uint8]:
        """The flags of some cells.

        :param first: the first cell on x, y, z, counted from 0.
        :param end: the end on x, y, z, exclusive.
        :returns: a new array, uint8 of shape (z, y, x).
        :raises hexcast.Error: ``job-value`` where the box is not inside the mesh; ``memory`` where the flags do not fit.
        """
        low, high = cell_of(first, "first"), cell_of(end, "end")
        self._check_box(low, high)
        shape = tuple(b - a for a, b in zip(low[::-1], high[::-1]))
        try:
            flags: NDArray[np.uint8] = np.empty(shape, np.uint8)
        except MemoryError as error:
            hint = "expand it in parts: box(...), slabs(); files are written without it"
            raise Error(f"the flags of {shape} cells do not fit the memory: {error}", "memory", hint) from error
        self._raw.fill(low, high, flags.reshape(-1))
        return flags

    def _check_box(self, low: tuple[int, int, int], high: tuple[int, int, int]) -> None:
        """Refuses a box that is not inside the mesh."""
        if any(not 0 <= a <= b <= n for a, b, n in zip(low, high, self.dims)):
            message = f"the box from {low} to {high} is not inside the mesh of {' x '.join(map(str, self.dims))} cells"
            raise Error(message, "job-value", "give the first cell on x, y, z, and the end, exclusive")

    def at(self, points: ArrayLike) -> NDArray[np.uint8]:
        """The flags at any points: of each the flag of the geometry that holds it, which is not always that of its cell.

        A point has the flag that a cell with its centre there would have: it is rounded to the grid that corners are rounded to, by at most
        ``report["snap_in_cells"]`` cells along each axis, and then decided exactly. A point on a surface counts as a little nearer to the start of x, then of
        y, then of z; where geometries overlap the higher priority wins, and of equal ones the later. Points beyond the box are decided, too.
        Cells that only a rule for cells gives, such as ``fill`` and ``close_gaps``, give points no flag.

        The first call reads files again, which may not have changed, and keeps the facets for later calls. Points near each other are fastest
        one after the other.

        :param points: x, y, z in the unit of the surfaces: an array of shape (..., 3), such as the nodes or the middles of elements.
        :returns: uint8 of shape (...): a flag a point, 0 for the background.
        :raises hexcast.Error: ``job-value`` for other shapes, or where a coordinate is not a number; ``job-conflict`` where the mesh was loaded, pickled or is a
            scene's, so that it has no surfaces; ``surface-open`` where ``open="parity"`` leaves an open surface to the rays of a mesh; ``io`` where
            a file has changed since; ``memory``.

        >>> import hexcast
        >>> from hexcast.shapes import sphere
        >>> mesh = hexcast.mesh(sphere((0, 0, 0), 1.0), cells=8, backend="cpu")
        >>> mesh.at([(0, 0, 0), (0.5, 0.5, 0.5), (0.7, 0.7, 0.7), (9, 0, 0)])
        array([1, 1, 0, 0], dtype=uint8)
        """
        try:
            places = np.asarray(points, np.float64)
        except (TypeError, ValueError) as error:
            raise InvalidValue(f"points are no array of numbers: {error}", "job-value", "give an array of shape (..., 3)") from error
        if places.ndim == 0 or places.shape[-1] != 3:
            raise InvalidValue(f"points have the shape {places.shape}", "job-value", "give an array of shape (..., 3): x, y, z of each")
        return self._points.at(np.ascontiguousarray(places).reshape(-1)).reshape(places.shape[:-1])

    @cached_property
    def _points(self) -> _hexcast.RawPoints:
        """The surfaces, ready to be asked."""
        if self._made_of is None:
            message = "a mesh that was loaded, pickled or made by a scene has cells, and no surfaces that hold points"
            raise Error(message, "job-conflict", "mesh the surfaces again in this process: hexcast.mesh(...)")
        digests = [given["blake3"] for given in self.report["inputs"]]
        return _hexcast.points(*self._made_of, digests)

    def slabs(self, max_bytes: int = SLAB_BYTES) -> Iterator[Slab]:
        """Goes through all cells in slabs of whole planes across z.

        :param max_bytes: most bytes of the flags of a slab; it has at least one plane.
        """
        nx, ny, nz = self.dims
        planes = max(1, max_bytes // (nx * ny))
        for start in range(0, nz, planes):
            first, end = (0, 0, start), (nx, ny, min(start + planes, nz))
            yield Slab(first, end, self.box(first, end))

    @cached_property
    def columns(self) -> Columns:
        """The runs along all rays, copied to arrays: 5 bytes a run and 8 a ray."""
        return Columns(*self._raw.columns())

    def save(
        self,
        path: Union[str, os.PathLike[str]],
        *,
        compress: Union[int, Literal["none"], None] = None,
        bits: bool = False,
        map: Optional[Mapping[int, int]] = None,
        export_flags: Optional[Sequence[int]] = None,
        ascii: bool = False,
        patches: Optional[Literal["side", "neighbour", "solid"]] = None,
        open_patches: Sequence[str] = (),
    ) -> None:
        """Writes a file, or the files of a solver, with the bytes that the command ``hexcast`` writes. The flags are not expanded as a whole.

        :param path: ends in ``.vti``, ``.vtr``, ``.npy``, ``.npz``, ``.raw`` (with a ``.raw.json`` beside it), ``.hxc``, ``.zarr``, a folder, or
            ``.zarr.zip``, the files of that folder in an archive; or as the files of a solver do: ``.foam``, ``.eb``, ``.inp``, ``.msh``, ``.xdmf``,
            ``.csx.xml``, ``.in``, ``geometry.xml``, ``.nrrd``, ``.vox``, ``.glb``, ``.stl``, ``.binvox`` and others of ``docs/export``. What has this name is replaced when all is written. It may be an
            address of fsspec's, such as ``s3://bucket/mesh.zarr``, which needs s3fs; the file is then made in a temporary folder first.
        :param compress: level of what is compressed, 1 (fast) to 9 (small), or ``"none"``; by default 6.
        :param bits: eight cells a byte, for ``.raw`` and ``.npy`` of meshes with one flag.
        :param map: numbers that ``.raw``, ``.npy`` and ``.npz`` have in place of flags, such as ``{0: 255}``.
        :param export_flags: flags whose cells a solver gets, also 0; by default all but 0, or the one whose cells are cut (``cut_cells``).
        :param ascii: text in place of numbers in binary, for ``.foam`` and ``.msh``.
        :param patches: by what patches of ``.foam``, surfaces of ``.inp`` and tags of faces in ``.msh`` and ``.xdmf`` are named: by the side of the box, else
            the neighbour; by the neighbour; or by the solid, for which the mesh needs ``walls=True``.
        :param open_patches: solids whose patches a fluid flows through.
        :raises hexcast.Error: ``output-name`` for another ending; ``job-value`` for another level; ``job-conflict`` where format and options contradict each
            other; ``export-unit``, ``export-material``, ``export-too-large`` and ``lines-graded`` where a solver's files cannot hold the mesh; ``io``.
        """
        numbers = {str(flag): int(number) for flag, number in (map or {}).items()}
        if any(not (0 <= int(flag) <= 255 and 0 <= number <= 255) for flag, number in numbers.items()):
            raise Error(f"map has {map}", "job-value", "flags and what is written for them are 0 to 255")
        of_cells: dict[str, Any] = {"bits": bits, "map": numbers}
        of_solver = {"export_flags": None if export_flags is None else list(export_flags), "ascii": ascii, "patches": patches, "open_patches": list(open_patches)}
        save(self._raw, path, compress, {**of_cells, **of_solver})

    def slice(
        self,
        axis: Union[Axis, Sequence[Axis], None] = None,
        at: Union[Place, Sequence[Place], None] = None,
        *,
        lines: bool = True,
        size: Optional[int] = None,
        flags: Optional[Sequence[int]] = None,
        colours: Optional[Mapping[int, str]] = None,
    ) -> Picture:
        """Draws slices side by side, with a legend of the flags: the PNG of the command ``hexcast slice``, byte for byte.

        :param axis: axes across the slices, such as ``"z"`` or ``["x", "z"]``; by default all three.
        :param at: places along each axis, in the unit of the mesh, or in percent of its length such as ``"25%"``; by default the middle.
        :param lines: whether lines between cells are drawn, where cells have 6 pixels or more.
        :param size: pixels of the longest side of the mesh, 1 to 32768; by default 600.
        :param flags: flags that are shown, by default all; cells of others are white.
        :param colours: colours of flags, such as ``{1: "#d98324"}``.
        :returns: the bytes of the file, which notebooks show.
        :raises hexcast.Error: ``job-value`` where a place is not within the mesh, or the picture is too large; ``memory``.

        >>> import hexcast
        >>> from hexcast.shapes import sphere
        >>> mesh = hexcast.mesh(sphere((0, 0, 0), 1.0), cells=20, backend="cpu")
        >>> mesh.slice("z", at=[0, "75%"], size=200)[1:4]
        b'PNG'
        """
        return slices(self._raw, axis, at, lines, look_of(size, flags, colours))

    def view(
        self,
        direction: Optional[Sequence[float]] = None,
        *,
        window: Optional[Sequence[int]] = None,
        size: Optional[int] = None,
        flags: Optional[Sequence[int]] = None,
        colours: Optional[Mapping[int, str]] = None,
    ) -> Picture:
        """Draws the stair-step surface, without a display: the PNG of the command ``hexcast view``, byte for byte.

        :param direction: direction to the eye in degrees: around z from the x axis, and up; by default -60 and 25.
        :param window: the cells that are shown, ``(i0, j0, k0, i1, j1, k1)``: the first, and the end, exclusive; by default all.
        :param size: pixels of the longer side, 1 to 32768; by default 1000.
        :param flags: as for :meth:`slice`.
        :param colours: as for :meth:`slice`.
        :returns: the bytes of the file, which notebooks show.
        :raises hexcast.Error: ``job-value`` where no cell that is shown has a flag, or the box is not inside the mesh; ``memory``.
        """
        angles = None if direction is None else [float(angle) for angle in direction]
        if angles is not None and len(angles) != 2:
            raise Error(f"direction is {direction!r}", "job-value", "give two angles, around z and up")
        cells = None
        if window is not None:
            low, high = cell_of(window[:3], "the start of window"), cell_of(window[3:], "the end of window")
            self._check_box(low, high)
            cells = [low, high]
        return Picture(_hexcast.draw_view(self._raw, angles, cells, look_of(size, flags, colours)))

    def diff(self, other: Mesh) -> Difference:
        """Compares two meshes cell by cell, as the command ``hexcast diff`` does.

        :param other: a mesh of as many cells on each axis.
        :raises hexcast.Error: ``job-conflict`` where the numbers of cells differ; ``memory``.

        >>> import hexcast
        >>> from hexcast.shapes import box
        >>> size = {"domain": (0, 0, 0, 4, 4, 4), "cells": 4, "backend": "cpu"}
        >>> one = hexcast.mesh(box((0, 0, 0), (2, 4, 4)), **size)
        >>> other = hexcast.mesh(box((0, 0, 0), (3, 4, 4)), **size)
        >>> found = one.diff(other)
        >>> found.cells, found.pairs[0].bounds, int(found.mask.flags.sum())
        (16, ((2, 0, 0), (3, 4, 4)), 16)
        """
        if not isinstance(other, Mesh):
            raise Error(f"a mesh is compared with {type(other).__qualname__}", "job-value", "give a mesh; hexcast.load reads one")
        text, mask = _hexcast.diff(self._raw, other._raw, max_bytes())
        found = json.loads(text)
        pairs = [
            FlagPair(
                pair["one"],
                pair["other"],
                pair["cells"],
                cell_of(pair["first"], "first"),
                (cell_of(pair["bounds"][0], "first"), cell_of(pair["bounds"][1], "end")),
            )
            for pair in found["pairs"]
        ]
        return Difference(found["cells"], found["n_cells"], found["are_lines_equal"], pairs, Mesh(mask))

    def to_xarray(self) -> xarray.Dataset:
        """The flags as an xarray Dataset, without a copy: ``flag`` over (z, y, x), with the centres of the cells as coordinates.

        ``flag`` has the attributes ``flag_values`` and ``flag_meanings`` of the CF conventions. What was measured is there, too: ``link_q`` and
        others along ``link``, ``cut_fraction`` and others along ``cut``, ``doubtful``, and ``Ex`` to ``Hz`` at lines and centres. Needs xarray.
        """
        data = dataset(self._raw, self.dims, self.flags)
        measured = self._measured()
        return in_dataset(data, measured, self.lines) if measured else data


def cell_of(cell: Sequence[int], name: str) -> tuple[int, int, int]:
    """Three whole numbers."""
    try:
        x, y, z = (int(number) for number in cell)
    except (TypeError, ValueError) as error:
        raise Error(f"{name} is {cell!r}, not three whole numbers", "job-value", "give x, y and z") from error
    return x, y, z


def warn(mesh: Mesh) -> Mesh:
    """Passes the report's findings on."""
    warn_of(mesh.report["findings"], stacklevel=4)
    return mesh


def warn_of(findings: list[dict[str, Any]], stacklevel: int) -> None:
    """Issues findings as warnings of the caller of a function of hexcast."""
    for finding in findings:
        warnings.warn(MeshWarning(finding), stacklevel=stacklevel)
