"""Meshes as arrays of Dask: each chunk is a window of the mesh, made where and when it is needed.

Needs dask, and xarray for :func:`dataset`. A chunk has the flags that the whole mesh has there, so that no chunk knows of another:
workers may end, and tasks be repeated.
"""

from __future__ import annotations

import json
import os
import uuid
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from threading import Lock
from typing import TYPE_CHECKING, Any, Literal, Optional, Union

import numpy as np
from numpy.typing import NDArray

from . import _hexcast
from . import mesh as mesh_here
from ._error import Error, missing
from ._files import level_of
from ._job import JobLike, job_of
from ._mesh import Mesh
from ._options import JobOptions
from ._signature import with_options
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

#: Where shards are in a store; all else in it is the same whoever writes it.
SHARDS = "flag/c/"

#: Options that each task has for itself.
OF_WORKERS = ("window", "part", "halo")
#: A file, the time of its last change and its length.
Stamp = tuple[str, int, int]


@with_options(JobOptions, without=OF_WORKERS)
def mesh(what: JobLike, *, chunks: Any = CHUNK, **options: Unpack[JobOptions]) -> dask.array.Array:
    """Meshes surfaces chunk by chunk.

    :param what: as for :func:`hexcast.mesh`; its surfaces are files that every worker can read, under the names that they have here.
        A worker reads each once.
    :param chunks: sizes of chunks along z, y, x, as ``dask.array`` takes them. Each chunk snaps all facets: few large chunks take less
        time than many small ones.
    :param options: those of :func:`hexcast.mesh`, without ``window`` and ``part``.
    :returns: flags of shape (nz, ny, nx), uint8.
    :raises hexcast.Error: those of :func:`hexcast.mesh`; ``job-conflict`` for surfaces in memory, and for ``close_gaps``,
        which a window does not have.

    >>> import hexcast.dask
    >>> hexcast.dask.mesh("tests/fixtures/spot.stl", cells=1000, chunks=500)  # doctest: +SKIP
    dask.array<hexcast-mesh, shape=(1000, ...), dtype=uint8, chunksize=(500, 500, 500), chunktype=numpy.ndarray>
    """
    return chunked(what, chunks, options)[0]


@with_options(JobOptions, without=OF_WORKERS)
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
    job, stamps = job_of_workers(what, options)
    first = mesh_here(job, window=(0, 0, 0, 1, 1, 1))
    shape = tuple(first.report["window"]["of"][::-1])
    sizes = array.core.normalize_chunks(chunks, shape, dtype=np.uint8)
    ends = [[0, *np.cumsum(axis).tolist()] for axis in sizes]
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


def job_of_workers(what: JobLike, options: Any) -> tuple[dict[str, Any], list[Stamp]]:
    """The job with the full names of its files, and what these are known by."""
    text, surfaces = job_of(what, options)
    job = json.loads(text)
    if any(made is not None for made in surfaces):
        raise Error("a surface is in memory, where workers do not find it", "job-conflict", "give names of files")
    for key in OF_WORKERS:
        if job.get(key) is not None:
            raise Error(f"{key} is given, and each task meshes a window", "job-conflict", "slice the array in its place")
    files = [os.path.abspath(geometry["file"]) for geometry in job["geometries"]]
    # the memory of this machine says nothing about that of a worker
    limits = {key: value for key, value in job.items() if key != "max_memory" or "max_memory" in options}
    entries = [{**entry, "file": file} for entry, file in zip(job["geometries"], files)]
    return {**limits, "geometries": entries}, [stamp_of(file) for file in files]


@with_options(JobOptions, without=OF_WORKERS)
def to_zarr(
    what: JobLike,
    store: Any,
    *,
    n: Union[int, Sequence[int]],
    compress: Union[int, Literal["none"], None] = None,
    **options: Unpack[JobOptions],
) -> list[Any]:
    """Tasks that fill a Zarr store part by part, with the bytes that ``hexcast.mesh(...).save("mesh.zarr")`` writes.

    ``dask.compute(*tasks)`` runs them; each returns the report of its part. Tasks may run in any order and more than once: a worker that
    ends leaves nothing that its repetition does not replace.

    :param what: as for :func:`mesh`.
    :param store: a folder that every worker can write to, or a store of ``zarr.storage``, such as an ``ObjectStore`` on S3.
    :param n: number of parts: slabs across z, or three numbers of boxes along x, y, z. They are cut along the borders of shards.
    :param compress: 1 (fast) to 9 (small), by default 6; or ``"none"``.
    :param options: those of :func:`hexcast.mesh`, without ``window``, ``part`` and ``halo``; ``zarr`` has the shapes of shards.
    :raises hexcast.Error: ``job-value`` where there are more parts than shards along an axis; those of :func:`mesh`.
    """
    import dask

    # dask has types for some of its functions only
    delayed = getattr(dask, "delayed")
    job, stamps = job_of_workers(what, options)
    job.setdefault("zarr", {})
    of = [1, 1, n] if isinstance(n, int) else list(n)
    # refuses numbers of parts that cannot be, before a task begins
    windows = _hexcast.parts(json.dumps(job), [read_once(stamp) for stamp in stamps], of)
    place = os.path.abspath(store) if isinstance(store, (str, os.PathLike)) else store
    level = level_of(compress, "mesh.zarr")
    task = delayed(write_part, pure=False)
    jobs = [json.dumps({**job, "part": {"index": index, "of": of}}) for index in range(1, len(windows) + 1)]
    return [task(part, stamps, place, level) for part in jobs]


def write_part(job: str, stamps: list[Stamp], store: Any, level: Optional[int]) -> dict[str, Any]:
    """Meshes a part and puts its shards in a store, in a worker."""
    raw = _hexcast.mesh(job, [read_once(stamp) for stamp in stamps])
    put = put_file if isinstance(store, str) else put_value
    for key, value in raw.zarr_part(level):
        put(store, key, value)
    report: dict[str, Any] = json.loads(raw.report)
    return report


def put_file(folder: str, key: str, value: bytes) -> None:
    """Writes a file beside its name first: nobody reads a part of it."""
    target = Path(folder, key)
    if not key.startswith(SHARDS) and target.exists():
        check_same(folder, key, value, target.read_bytes())
        return
    target.parent.mkdir(parents=True, exist_ok=True)
    # what a worker left that ended, or what one is writing that repeats this part: it begins anew
    for left in target.parent.glob(f".hexcast-{target.name}-*.part"):
        left.unlink(missing_ok=True)
    while True:
        beside = target.with_name(f".hexcast-{target.name}-{uuid.uuid4().hex}.part")
        beside.write_bytes(value)
        try:
            beside.replace(target)
            return
        except FileNotFoundError:
            continue


def put_value(store: Any, key: str, value: bytes) -> None:
    """Puts a value in a store of zarr."""
    from zarr.core.buffer import default_buffer_prototype
    from zarr.core.sync import sync

    prototype = default_buffer_prototype()
    there = None if key.startswith(SHARDS) else sync(store.get(key, prototype))
    if there is not None:
        check_same(store, key, value, there.to_bytes())
    else:
        sync(store.set(key, prototype.buffer.from_bytes(value)))


def check_same(store: Any, key: str, value: bytes, there: bytes) -> None:
    if value != there:
        message = f"{store}: the store is that of another mesh: {key} differs"
        raise Error(message, "io", "name another store, remove this one, or use the job that it was begun with")


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
    try:
        facts = os.stat(file)
    except OSError as error:
        if not os.path.exists(file):
            raise missing(file) from None
        raise Error(f"{file}: {error.strerror}", "io", "check the permissions of the file") from None
    return file, facts.st_mtime_ns, facts.st_size


READING = Lock()


def read_once(stamp: Stamp) -> Surface:
    """The surface of a file; of several threads the first reads it."""
    with READING:
        return kept(stamp)


@lru_cache(maxsize=MAX_SURFACES)
def kept(stamp: Stamp) -> Surface:
    return surface(stamp[0])
