"""What a mesh has beside its cells, as arrays, and the files of these."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, Optional, Union

import numpy as np
from numpy.typing import NDArray

from . import _hexcast
from ._error import Error
from ._files import level_of, replace

if TYPE_CHECKING:
    import xarray

#: zlib level, or none.
Compress = Union[int, Literal["none"], None]


#: Dimensions of the arrays of fractions that have several numbers an entry.
OF_ENTRIES: dict[str, tuple[str, ...]] = {"faces": ("face",), "edges": ("edge",), "centroid": ("axis",), "face_centroid": ("face", "across")}


class Arrays:
    """Arrays that are written together, as a NumPy archive."""

    def _arrays(self) -> dict[str, NDArray[Any]]:
        """Those of the archive, in its order."""
        return {name: array for name, array in vars(self).items() if isinstance(array, np.ndarray)}

    def _save_archive(self, path: Union[str, os.PathLike[str]], compress: Compress) -> None:
        level = level_of(compress, os.fspath(path))
        flat = [
            (name, array.dtype.newbyteorder("<").str, list(array.shape), np.ascontiguousarray(array).reshape(-1).view(np.uint8))
            for name, array in self._arrays().items()
        ]
        with replace(path) as new:
            _hexcast.write_arrays(new, flat, level)

    def _save_npz(self, path: Union[str, os.PathLike[str]], named: str, compress: Compress) -> None:
        if not os.fspath(path).lower().endswith(".npz"):
            raise Error(f"{path}: {named} written as .npz", "job-value", "use .npz")
        self._save_archive(path, compress)


@dataclass(frozen=True, eq=False, repr=False)
class Links(Arrays):
    """The links that lead from cells of the fluid to a wall: ``docs/links.md``. Each array but the first four has an entry a link."""

    #: The directions of the stencil: int8 of shape (directions, 3).
    directions: NDArray[np.int8]
    #: Number of cells of the mesh on x, y, z.
    dims: NDArray[np.uint32]
    #: The first cell of the mesh, counted in the box: 0 but for windows.
    origin: NDArray[np.int32]
    #: Flags of the fluid.
    fluid: NDArray[np.uint8]
    #: The cell of the fluid on x.
    x: NDArray[np.uint32]
    #: The cell on y.
    y: NDArray[np.uint32]
    #: The cell on z.
    z: NDArray[np.uint32]
    #: The direction, as a row of ``directions``.
    direction: NDArray[np.uint8]
    #: Fraction of the link up to the wall, greater than 0, at most 1: float32.
    q: NDArray[np.float32]
    #: The facet of the wall, counted from 0 in its geometry; -1 where no facet crosses the link.
    facet: NDArray[np.int32]
    #: The geometry of the facet, counted from 0 in the job, or -1.
    geometry: NDArray[np.int16]
    #: Flag of the cell at the other end.
    flag: NDArray[np.uint8]

    def __len__(self) -> int:
        return len(self.q)

    def __repr__(self) -> str:
        return f"<hexcast.Links: {len(self)} links of {len(self.directions)} directions>"

    def save(self, path: Union[str, os.PathLike[str]], *, compress: Compress = None) -> None:
        """Writes the file of the command's ``--links``, byte for byte.

        :param path: ends in ``.npz``, or in ``.links`` for records of 24 bytes.
        :param compress: level of ``.npz``, 1 to 9 or ``"none"``; by default 6.
        """
        ending = os.path.splitext(path)[1].lower()
        if ending == ".npz":
            self._save_archive(path, compress)
        elif ending == ".links":
            with replace(path) as new:
                new.write_bytes(self._head() + self.records.tobytes())
        else:
            raise Error(f"{path}: no format of links has the ending {ending!r}", "job-value", "use .npz or .links")

    @property
    def records(self) -> NDArray[np.void]:
        """The links as records of 24 bytes: a structured array, a copy."""
        kinds = [(name, "<u4") for name in "xyz"]
        kinds += [("q", "<f4"), ("facet", "<i4"), ("geometry", "<i2"), ("direction", "u1"), ("flag", "u1")]
        records = np.empty(len(self), kinds)
        for name, _ in kinds:
            records[name] = getattr(self, name)
        return records

    def _head(self) -> bytes:
        """Magic, version, number of directions, dims, number of links; of a window its origin; then the directions, padded."""
        is_window = self.origin.any()
        numbers = np.array([2 if is_window else 1, len(self.directions), *self.dims, 0], "<u4").tobytes()
        head = b"HEXLINKS" + numbers + np.array(len(self), "<u8").tobytes()
        if is_window:
            head += np.array([*self.origin, 0], "<i4").tobytes()
        head += self.directions.tobytes()
        return head + bytes(-len(head) % 8)


@dataclass(frozen=True, eq=False, repr=False)
class Fractions(Arrays):
    """The fractions of flags in the cells that surfaces cut: ``docs/fractions.md``. An entry for each flag of each cell that is cut."""

    #: Number of cells of the mesh on x, y, z.
    dims: NDArray[np.uint32]
    #: The first cell of the mesh, counted in the box: 0 but for windows.
    origin: NDArray[np.int32]
    #: The cell: x + nx (y + ny z), uint64, in order.
    cell: NDArray[np.uint64]
    #: The flag.
    flag: NDArray[np.uint8]
    #: Its fraction of the cell, 0 to 1: float32.
    fraction: NDArray[np.float32]
    #: Its fraction of each face of the cell, below and above along x, then y, then z: shape (entries, 6). None unless ``faces`` was asked for.
    faces: Optional[NDArray[np.float32]] = None
    #: Its fraction of each edge of the cell, four along x, then y, then z: shape (entries, 12). None unless ``edges`` was asked for.
    edges: Optional[NDArray[np.float32]] = None
    #: The centre of what it has of the cell, in cells from the low corner: shape (entries, 3). None unless ``centroids`` was asked for.
    centroid: Optional[NDArray[np.float32]] = None
    #: The same of each face, along its two axes: shape (entries, 6, 2). None unless ``faces`` and ``centroids`` were asked for.
    face_centroid: Optional[NDArray[np.float32]] = None
    #: The cell of each surface within a cell. None, as all that follow, unless ``surfaces`` was asked for.
    surface_cell: Optional[NDArray[np.uint64]] = None
    #: The geometry of the surface, counted from 0 in the job.
    surface_geometry: Optional[NDArray[np.int16]] = None
    #: Its area.
    surface_area: Optional[NDArray[np.float32]] = None
    #: Its centre, in cells from the low corner of the cell: shape (surfaces, 3).
    surface_point: Optional[NDArray[np.float32]] = None
    #: Its mean normal: shape (surfaces, 3).
    surface_normal: Optional[NDArray[np.float32]] = None
    #: Rays along each axis of a cell; 0 where cells were measured exactly.
    rays: int = 4
    #: Cells of the halo of the mesh, which are not measured.
    halo: int = 0
    _raw: Optional[_hexcast.RawMesh] = None

    def __len__(self) -> int:
        return len(self.fraction)

    def __repr__(self) -> str:
        return f"<hexcast.Fractions: {len(self)} fractions>"

    def solid(self) -> NDArray[np.float32]:
        """The fraction of every cell that is not background: float32 of shape (nz, ny, nx), what the command writes to ``.npy``."""
        raw = self._of_mesh()
        flags = np.empty(raw.dims[::-1], np.uint8)
        raw.fill((0, 0, 0), raw.dims, flags.reshape(-1))
        solid: NDArray[np.float32] = (flags != 0).astype(np.float32)
        cells, first = np.unique(self.cell, return_index=True)
        if len(cells):
            sums = np.add.reduceat(np.where(self.flag == 0, 0.0, self.fraction.astype(np.float64)), first)
            solid.reshape(-1)[cells.astype(np.int64)] = np.minimum(sums, 1.0)
        return solid

    def _of_mesh(self) -> _hexcast.RawMesh:
        if self._raw is None or self.halo > 0:
            message = f"the mesh has a halo of {self.halo} cells, whose fractions are not measured"
            raise Error(message, "job-conflict", "leave out halo, or write .npz, which lists cut cells")
        return self._raw

    def save(self, path: Union[str, os.PathLike[str]], *, compress: Compress = None) -> None:
        """Writes the file of the command's ``--fractions``, byte for byte.

        :param path: ends in ``.npz`` for the fractions of each flag in cut cells; in ``.vti``, ``.vtr``, ``.npy``, ``.zarr`` or ``.zarr.zip`` for
            the fraction of every cell that is not background.
        :param compress: level, 1 to 9 or ``"none"``; by default 6; ``.npy`` is never compressed.
        """
        if os.fspath(path).lower().endswith(".npz"):
            self._save_archive(path, compress)
            return
        raw = self._of_mesh()
        cut = (self.rays, self.halo, self.cell, self.flag, self.fraction)
        level = level_of(compress, os.fspath(path))
        with replace(path) as new:
            _hexcast.write_solid(raw, os.fspath(path), new, level, cut)


@dataclass(frozen=True, eq=False, repr=False)
class Staggered(Arrays):
    """The flags at the points of a staggered (Yee) grid, and the faces of sheets: ``docs/staggered.md``."""

    #: Flags at the points of a component, of shape (z, y, x): along an axis where the points lie on lines, one more than cells.
    Ex: NDArray[np.uint8]
    Ey: NDArray[np.uint8]
    Ez: NDArray[np.uint8]
    Hx: NDArray[np.uint8]
    Hy: NDArray[np.uint8]
    Hz: NDArray[np.uint8]
    #: The flags of the cells.
    cell: NDArray[np.uint8]
    #: The lines on each axis.
    x: NDArray[np.float64]
    y: NDArray[np.float64]
    z: NDArray[np.float64]
    #: The first cell of the mesh, counted in the box: 0 but for windows.
    origin: NDArray[np.int32]
    #: The axis across each face of a sheet: 0, 1 or 2.
    sheet_axis: NDArray[np.uint8]
    #: The index of the face: that of a line along its axis, of a cell along the others.
    sheet_x: NDArray[np.uint32]
    sheet_y: NDArray[np.uint32]
    sheet_z: NDArray[np.uint32]
    #: Flag of the sheet.
    sheet_flag: NDArray[np.uint8]

    def __repr__(self) -> str:
        return f"<hexcast.Staggered: {len(self.sheet_axis)} faces of sheets>"

    def save(self, path: Union[str, os.PathLike[str]], *, compress: Compress = None) -> None:
        """Writes the file of the command's ``--staggered``, ``.npz``, byte for byte.

        :param compress: level, 1 to 9 or ``"none"``; by default 6.
        """
        self._save_npz(path, "a staggered grid is", compress)


@dataclass(frozen=True, eq=False, repr=False)
class Conformal(Arrays):
    """What of edges and faces lies outside metal, for conformal solvers of Maxwell's equations: ``docs/conformal.md``."""

    #: Fractions of the edges along an axis, 0 to 1, of shape (z, y, x): one more than cells along the others.
    Lx: NDArray[np.float64]
    Ly: NDArray[np.float64]
    Lz: NDArray[np.float64]
    #: Fractions of the faces across an axis: one more than cells along it.
    Ax: NDArray[np.float64]
    Ay: NDArray[np.float64]
    Az: NDArray[np.float64]
    #: The lines on each axis.
    x: NDArray[np.float64]
    y: NDArray[np.float64]
    z: NDArray[np.float64]
    #: The first cell of the mesh, counted in the box: 0 but for windows.
    origin: NDArray[np.int32]
    #: The longest stable step, one number (of shape ()): a part of that of the same lines without metal.
    dt_factor: NDArray[np.float64]

    def __repr__(self) -> str:
        return f"<hexcast.Conformal: steps up to {float(self.dt_factor):.3f} of those without metal>"

    def save(self, path: Union[str, os.PathLike[str]], *, compress: Compress = None) -> None:
        """Writes the file of the command's ``--conformal``, ``.npz``, byte for byte.

        :param compress: level, 1 to 9 or ``"none"``; by default 6.
        """
        self._save_npz(path, "edges and faces outside metal are", compress)


@dataclass(frozen=True, eq=False, repr=False)
class Distances(Arrays):
    """Signed distances to the nearest surface: ``docs/distance.md``."""

    #: Distance of each cell, of shape (z, y, x), in the unit of the files, negative inside; at nodes one more along each axis.
    distance: NDArray[np.float64]
    #: The lines on each axis.
    x: NDArray[np.float64]
    y: NDArray[np.float64]
    z: NDArray[np.float64]
    #: The first cell of the mesh, counted in the box: 0 but for windows.
    origin: NDArray[np.int32]
    #: The largest distance that is known, one number (of shape ()): infinite where all are.
    width: NDArray[np.float64]

    def __repr__(self) -> str:
        return f"<hexcast.Distances: {' x '.join(map(str, self.distance.shape[::-1]))}, exact up to {float(self.width):g}>"

    def save(self, path: Union[str, os.PathLike[str]], *, compress: Compress = None) -> None:
        """Writes the file of the command's ``--distance``, ``.npz``, byte for byte.

        :param compress: level, 1 to 9 or ``"none"``; by default 6.
        """
        self._save_npz(path, "distances are", compress)


@dataclass(frozen=True, eq=False, repr=False)
class Tensors(Arrays):
    """The permittivity averaged in the cell around each point of E: ``docs/tensors.md``."""

    #: Relative permittivity at the points of a component, of shape (z, y, x, 6): xx, yy, zz, yz, xz, xy of a symmetric tensor. Points are one more than cells along the other axes.
    Ex: NDArray[np.float64]
    Ey: NDArray[np.float64]
    Ez: NDArray[np.float64]
    #: The lines on each axis.
    x: NDArray[np.float64]
    y: NDArray[np.float64]
    z: NDArray[np.float64]
    #: The first cell of the mesh, counted in the box: 0 but for windows.
    origin: NDArray[np.int32]

    def __repr__(self) -> str:
        n = sum(len(of.reshape(-1, 6)) for of in (self.Ex, self.Ey, self.Ez))
        return f"<hexcast.Tensors: {n} points>"

    def save(self, path: Union[str, os.PathLike[str]], *, compress: Compress = None) -> None:
        """Writes the file of the command's ``--tensors``, ``.npz``, byte for byte.

        :param compress: level, 1 to 9 or ``"none"``; by default 6.
        """
        self._save_npz(path, "smoothed permittivity is", compress)


@dataclass(frozen=True, eq=False, repr=False)
class Leaves(Arrays):
    """The cells of an octree that are not halved: ``docs/refine.md``. Those of a level follow each other, then those of a ``k`` and a ``j``."""

    #: The level of each, 0 for the cells of the job.
    level: NDArray[np.uint8]
    #: Its cell among all of its level, on x.
    i: NDArray[np.int32]
    #: The cell on y.
    j: NDArray[np.int32]
    #: The cell on z.
    k: NDArray[np.int32]
    #: Its flag.
    flag: NDArray[np.uint8]
    #: The lines of level 0 on each axis.
    x: NDArray[np.float64]
    y: NDArray[np.float64]
    z: NDArray[np.float64]
    #: Cells of each level on x, y and z, if all were there.
    dims: tuple[tuple[int, int, int], ...]
    #: Names of the flags in use.
    names: dict[int, str]
    #: The unit of every length, if the job or its files name one.
    unit: Optional[str]

    def __repr__(self) -> str:
        return f"<hexcast.Leaves: {len(self):,} leaves of {len(self.dims)} levels>"

    def __len__(self) -> int:
        return len(self.level)

    def boxes(self) -> NDArray[np.float64]:
        """The lower and the upper corner of each leaf: an array of shape (leaves, 2, 3), x first."""
        n = 1 << self.level.astype(np.int64)
        found = np.empty((len(self), 2, 3))
        for axis, (index, lines) in enumerate(((self.i, self.x), (self.j, self.y), (self.k, self.z))):
            cell, part = np.divmod(index, n)
            low, size = lines[cell], np.diff(lines)[cell]
            found[:, 0, axis] = low + size * part / n
            found[:, 1, axis] = np.where(part + 1 == n, lines[cell + 1], low + size * (part + 1) / n)
        return found

    def save(self, path: Union[str, os.PathLike[str]], *, compress: Compress = None) -> None:
        """Writes them as ``hexcast refine -o`` does.

        :param path: ends in ``.npz``. Replaced when all is written, not before.
        :param compress: zlib level, 1 (fast) to 9 (small), by default 6; or ``"none"``.
        :raises hexcast.Error: ``job-value`` for another ending; ``io``.
        """
        self._save_npz(path, "leaves are", compress)


def leaves_of(raw: _hexcast.RawLeaves) -> Leaves:
    names, _, unit = raw.facts()
    of_flags = {flag: name for flag, name in json.loads(names)}
    dims = tuple((nx, ny, nz) for nx, ny, nz in raw.dims())
    return Leaves(**filled(raw.arrays(), raw.fill), dims=dims, names=of_flags, unit=unit)


def arrays_of(raw: _hexcast.RawMesh, kind: str) -> dict[str, NDArray[Any]]:
    """The arrays of links, fractions, a staggered grid, edges and faces outside metal, smoothed permittivity or distances."""
    return filled(_hexcast.arrays(raw, kind), lambda index, out: _hexcast.fill_array(raw, kind, index, out))


def filled(
    described: Sequence[tuple[str, str, list[int]]], fill: Callable[[int, NDArray[np.uint8]], None]
) -> dict[str, NDArray[Any]]:
    """Arrays by their names; nobody can write to them, as they stay what is saved."""
    arrays = {}
    for index, (name, dtype, shape) in enumerate(described):
        try:
            array: NDArray[Any] = np.empty(shape, dtype)
        except MemoryError as error:
            message = f"the array {name} of the shape {tuple(shape)} does not fit the memory: {error}"
            raise Error(message, "memory", "use larger cells, or mesh in windows") from error
        fill(index, array.reshape(-1).view(np.uint8))
        array.setflags(write=False)
        arrays[name] = array
    return arrays


def links_of(raw: _hexcast.RawMesh) -> Links:
    return Links(**arrays_of(raw, "links"))


def fractions_of(raw: _hexcast.RawMesh) -> Fractions:
    rays, halo = _hexcast.fraction_facts(raw)
    return Fractions(**arrays_of(raw, "fractions"), rays=rays, halo=halo, _raw=raw)


def staggered_of(raw: _hexcast.RawMesh) -> Staggered:
    return Staggered(**arrays_of(raw, "staggered"))


def conformal_of(raw: _hexcast.RawMesh) -> Conformal:
    return Conformal(**arrays_of(raw, "conformal"))


def distances_of(raw: _hexcast.RawMesh) -> Distances:
    return Distances(**arrays_of(raw, "distance"))


def tensors_of(raw: _hexcast.RawMesh) -> Tensors:
    return Tensors(**arrays_of(raw, "tensors"))


def in_dataset(
    data: xarray.Dataset, measured: Mapping[str, Any], lines: tuple[NDArray[np.float64], ...]
) -> xarray.Dataset:
    """The dataset with what was measured: a dimension each for links, for cut cells and for the surfaces in these; and the lines."""
    variables: dict[str, Any] = {}
    if "links" in measured:
        links = measured["links"]
        variables["link_directions"] = (("direction", "axis"), links.directions)
        for name in ("x", "y", "z", "direction", "q", "facet", "geometry", "flag"):
            variables[f"link_{name}"] = ("link", getattr(links, name))
    if "fractions" in measured:
        for name, array in measured["fractions"]._arrays().items():
            if name not in ("dims", "origin"):
                is_surface = name.startswith("surface")
                dimensions = ("surface", "axis") if is_surface else ("cut", *OF_ENTRIES.get(name, ()))
                variables[name if is_surface else f"cut_{name}"] = (dimensions[: array.ndim], array)
    if "doubt" in measured:
        variables["doubtful"] = (("z", "y", "x"), measured["doubt"].flags)
    on_lines = {
        "staggered": ["Ex", "Ey", "Ez", "Hx", "Hy", "Hz"],
        "conformal": ["Lx", "Ly", "Lz", "Ax", "Ay", "Az"],
        "tensors": ["Ex", "Ey", "Ez"],
        "distance": ["distance"],
    }
    for kind in [kind for kind in on_lines if kind in measured]:
        data = data.assign_coords({f"{axis}_line": of for axis, of in zip("xyz", lines)})
        for name in on_lines[kind]:
            array = getattr(measured[kind], name)
            along = [f"{axis}_line" if n == len(of) else axis for axis, n, of in zip("zyx", array.shape, lines[::-1])]
            is_tensor = kind == "tensors"
            variables[f"eps_{name}" if is_tensor else name] = ([*along, "tensor"] if is_tensor else along, array)
    return data.assign(variables)
