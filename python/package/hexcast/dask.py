"""Meshes as arrays of Dask: each chunk is a window of the mesh, made where and when it is needed.

Needs dask, and xarray for :func:`dataset`. A chunk has the flags that the whole mesh has there, so that no chunk knows of another:
workers may end, and tasks be repeated.
"""

from __future__ import annotations

import json
import os
from functools import lru_cache
from threading import Lock
from typing import TYPE_CHECKING, Any, Optional

import numpy as np
from numpy.typing import NDArray

from . import _hexcast
from . import mesh as mesh_here
from ._error import Error
from ._job import JobLike, job_of
from ._mesh import Mesh
from ._options import JobOptions
from ._surface import Surface, surface
from ._xarray import dataset as dataset_of

if TYPE_CHECKING:
    import dask.array
    import xarray
    from typing_extensions import Unpack

#: Cells along each side of a chunk, unless the caller says.
CHUNK = 256
#: Surfaces that a worker keeps.
MAX_SURFACES = 16

#: A file, the time of its last change and its length.
Stamp = tuple[str, int, int]


def mesh(what: JobLike, *, chunks: Any = CHUNK, **options: Unpack[JobOptions]) -> dask.array.Array:
    """Meshes surfaces chunk by chunk.

    :param what: as for :func:`hexcast.mesh`; its surfaces are files that every worker can read, under the names that they have here.
        A worker reads each once.
    :param chunks: sizes of chunks along z, y, x, as ``dask.array`` takes them. Each chunk snaps all facets: few large chunks take less
        time than many small ones.
    :param options: those of :func:`hexcast.mesh`, without ``window`` and ``part``.
    :returns: flags of shape (nz, ny, nx), uint8.
    :raises hexcast.Error: those of :func:`hexcast.mesh`; ``job-conflict`` for surfaces in memory, and for what a window does not have
        (``close_gaps``, ``certify``).

    >>> import hexcast.dask
    >>> hexcast.dask.mesh("tests/fixtures/spot.stl", cells=1000, chunks=500)  # doctest: +SKIP
    dask.array<hexcast-mesh, shape=(1000, ...), dtype=uint8, chunksize=(500, 500, 500), chunktype=numpy.ndarray>
    """
    return chunked(what, chunks, options)[0]


def dataset(what: JobLike, *, chunks: Any = CHUNK, **options: Unpack[JobOptions]) -> xarray.Dataset:
    """The array of :func:`mesh` with the centres of the cells as coordinates, as :meth:`hexcast.Mesh.to_xarray` has them."""
    flags, first = chunked(what, chunks, options)
    return dataset_of(first._raw, flags.shape[::-1], flags)


def chunked(what: JobLike, chunks: Any, options: Any) -> tuple[dask.array.Array, Mesh]:
    """The array, and the mesh of the first cell."""
    import dask.array
    from dask.base import tokenize

    # dask has types for some of its functions only
    array: Any = dask.array
    text, surfaces = job_of(what, options)
    job = json.loads(text)
    if any(made is not None for made in surfaces):
        raise Error("a surface is in memory, where workers do not find it", "job-conflict", "give names of files")
    if any(job.get(key) is not None for key in ("window", "part", "halo")):
        raise Error("a window, part or halo is given, and each chunk is a window", "job-conflict", "slice the array in its place")
    files = [os.path.abspath(geometry["file"]) for geometry in job["geometries"]]
    # the memory of this machine says nothing about that of a worker
    limits = {key: value for key, value in job.items() if key != "max_memory" or "max_memory" in options}
    job = {**limits, "geometries": [{**entry, "file": file} for entry, file in zip(job["geometries"], files)]}
    first = mesh_here(job, window=(0, 0, 0, 1, 1, 1))
    shape = tuple(first.report["window"]["of"][::-1])
    sizes = array.core.normalize_chunks(chunks, shape, dtype=np.uint8)
    ends = [[0, *np.cumsum(axis).tolist()] for axis in sizes]
    stamps = [stamp_of(file) for file in files]
    flags = array.map_blocks(
        flags_of_chunk,
        job=json.dumps(job),
        stamps=stamps,
        ends=ends,
        chunks=sizes,
        dtype=np.uint8,
        meta=np.empty((0, 0, 0), np.uint8),
        name=f"hexcast-mesh-{tokenize(job, stamps, sizes)}",
    )
    return flags, first


def flags_of_chunk(
    job: str, stamps: list[Stamp], ends: list[list[int]], block_id: Optional[tuple[int, ...]] = None
) -> NDArray[np.uint8]:
    """Meshes a chunk, in a worker."""
    chunk = (0, 0, 0) if block_id is None else block_id
    low, high = ([ends[axis][chunk[axis] + end] for axis in (2, 1, 0)] for end in (0, 1))
    windowed = json.dumps({**json.loads(job), "window": [*low, *high]})
    return Mesh(_hexcast.mesh(windowed, [read_once(stamp) for stamp in stamps])).flags


def stamp_of(file: str) -> Stamp:
    """What a file is known by: workers read one anew that has changed."""
    facts = os.stat(file)
    return file, facts.st_mtime_ns, facts.st_size


READING = Lock()


def read_once(stamp: Stamp) -> Surface:
    """The surface of a file; of several threads the first reads it."""
    with READING:
        return kept(stamp)


@lru_cache(maxsize=MAX_SURFACES)
def kept(stamp: Stamp) -> Surface:
    return surface(stamp[0])
