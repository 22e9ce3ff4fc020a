"""hexcast: exact Cartesian meshing of closed surfaces by parallel ray casting, on the GPU or the processor.

>>> import hexcast
>>> from hexcast.shapes import sphere
>>> mesh = hexcast.mesh(sphere((0, 0, 0), 1.0), cells=64, backend="cpu")
>>> mesh.flags.shape
(64, 64, 64)
>>> float(abs(mesh.flags.mean() - 3.14159265 / 6)) < 0.005
True
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Optional, Union

from . import _hexcast
from ._driver import disable_layer_without_session
from ._error import Error, MeshWarning, missing
from ._job import SIZES, Geometry, JobLike, job_of
from ._measured import Conformal, Distances, Fractions, Leaves, Links, Staggered, Tensors, leaves_of
from ._mesh import Columns, Difference, FlagPair, Mesh, Slab, warn, warn_of
from ._options import GeometryOptions, JobOptions
from ._pictures import Picture
from ._progress import follow
from ._scene import ChangedRuns, Scene, Update
from ._signature import with_options
from ._surface import Surface, SurfaceLike, surface

if TYPE_CHECKING:
    from typing_extensions import Unpack

__version__ = _hexcast.__version__
__all__ = [
    "ChangedRuns",
    "Columns",
    "Conformal",
    "Distances",
    "Difference",
    "Error",
    "FlagPair",
    "Fractions",
    "Geometry",
    "GeometryOptions",
    "JobLike",
    "JobOptions",
    "Leaves",
    "Links",
    "Mesh",
    "MeshWarning",
    "Picture",
    "Scene",
    "Slab",
    "Staggered",
    "Surface",
    "SurfaceLike",
    "Tensors",
    "Update",
    "converge",
    "estimate",
    "load",
    "mesh",
    "parts",
    "refine",
    "scene",
    "surface",
]


# the Vulkan loader reads this when a GPU is first looked for
disable_layer_without_session()


@with_options(JobOptions)
def mesh(
    what: JobLike,
    *,
    progress: Union[Callable[[int, int], object], bool, Any, None] = None,
    adapter: Optional[str] = None,
    threads: Optional[int] = None,
    spill: Union[str, os.PathLike[str], None] = None,
    doubt: bool = False,
    walls: bool = False,
    **options: Unpack[JobOptions],
) -> Mesh:
    """Meshes surfaces: a box of cells, each with the flag of the geometry that it is in, or 0.

    :param what: one of

        - a surface: the name of a file (STL, OBJ, PLY, OFF, 3MF, GLB, STEP or IGES), or whatever :func:`surface` takes, such as
          ``(vertices, faces)``;
        - a scene of trimesh or a MultiBlock of PyVista: each of its meshes is a geometry, named as there;
        - a dict with the key ``file`` or ``source`` for the surface, and others of :class:`GeometryOptions`;
        - a list of these: where two overlap, the later one wins;
        - a job: a dict with the key ``geometries``, or the name of a job file that ends in ``.toml`` or ``.json``.

    :param progress: a function that is called with the numbers of rays done and of all rays, some 20 times a second, from the
        thread that called; or a bar of tqdm; or True for a new one. What it raises ends the mesh.
    :param adapter: a part of the name of the GPU to use.
    :param threads: number of threads of the processor; by default all, or what the environment variable ``RAYON_NUM_THREADS`` says.
    :param spill: a folder for a file without a name that holds what exceeds ``max_memory``, and is gone with the mesh.
    :param doubt: whether the mesh has a mask of the cells that the rays of open surfaces do not decide: :attr:`Mesh.doubt`.
    :param walls: whether faces between flags remember whose facets they are, for ``patches="solid"`` of :meth:`Mesh.save`.
    :param options: the keys of a job file: see :class:`JobOptions`. They replace those of the job.
    :returns: the mesh. The warnings of its report are issued as :class:`MeshWarning`.
    :raises hexcast.Error: with a ``code``, a sentence and a ``hint``.
    :raises KeyboardInterrupt: at Ctrl-C, within moments.

    Other threads of Python run meanwhile. A mesh can be pickled and copied, so that it comes back from workers of Dask.

    >>> import hexcast
    >>> from hexcast.shapes import box, sphere
    >>> case = {"source": box((-2, -2, -2), (2, 2, 2)), "name": "case"}
    >>> core = {"source": sphere((0, 0, 0), 1.5), "name": "core", "flag": 7}
    >>> mesh = hexcast.mesh([case, core], cells=40, window=(0, 0, 20, 40, 40, 21), backend="cpu")
    >>> mesh.dims, mesh.names, [flag["cells"] for flag in mesh.report["flags"]]
    ((40, 40, 1), {1: 'case', 7: 'core'}, [892, 708])
    """
    job, surfaces = job_of(what, options)
    how = (adapter, threads_of(threads), None if spill is None else os.fspath(spill), (doubt, walls))
    with follow(progress) as function:
        return warn(Mesh(_hexcast.mesh(job, surfaces, how, function), (job, surfaces)))


@with_options(JobOptions)
def scene(
    what: JobLike,
    *,
    progress: Union[Callable[[int, int], object], bool, Any, None] = None,
    adapter: Optional[str] = None,
    threads: Optional[int] = None,
    **options: Unpack[JobOptions],
) -> Scene:
    """Meshes a job whose geometries will move, turn or be replaced: :meth:`Scene.update` makes what changed, and lists it.

    Takes what :func:`mesh` takes; the columns stay in memory. Give it a ``domain``: without one the box follows the geometries, and every
    edit that moves its sides is a whole mesh.

    >>> import hexcast
    >>> from hexcast.shapes import sphere
    >>> ball = hexcast.surface(sphere((0, 0, 0), 1.0))
    >>> scene = hexcast.scene(ball, domain=(-2, -2, -2, 2, 2, 2), cells=64, backend="cpu")
    >>> update = scene.update({"source": ball, "translate": (0.25, 0, 0)})
    >>> update.whole is None, update.rays < 64 * 64
    (True, True)
    >>> index, before, after = update.changed.cells()
    >>> flags = scene.mesh.flags
    >>> bool((flags[index[:, 2], index[:, 1], index[:, 0]] == after).all())
    True
    """
    given = dict(options)
    job, surfaces = job_of(what, given)
    with follow(progress) as function:
        made = Scene(_hexcast.scene(job, surfaces, adapter, threads_of(threads), function), given)
    warn(made.mesh)
    return made


def threads_of(threads: Optional[int]) -> Optional[int]:
    if threads is not None and (not isinstance(threads, int) or threads < 1):
        raise Error(f"threads is {threads!r}", "job-value", "give a whole number from 1")
    return threads


@with_options(JobOptions)
def estimate(what: JobLike, **options: Unpack[JobOptions]) -> dict[str, Any]:
    """What a mesh would cost, before a ray is cast: cells, runs, bytes of memory and of files.

    Takes what :func:`mesh` takes.

    >>> import hexcast
    >>> from hexcast.shapes import box
    >>> hexcast.estimate(box((0, 0, 0), (1, 1, 1)), cells=1000)["cells"]
    1000000000
    """
    made: dict[str, Any] = json.loads(_hexcast.estimate(*job_of(what, options)))
    return made


@with_options(JobOptions)
def parts(what: JobLike, n: Union[int, Sequence[int]], **options: Unpack[JobOptions]) -> list[tuple[int, ...]]:
    """Divides a mesh into windows that take about as long as each other; every process finds the same.

    :param what: as for :func:`mesh`.
    :param n: number of slabs across z, or of boxes along x, y and z.
    :returns: for each window ``(i0, j0, k0, i1, j1, k1)``, which :func:`mesh` takes as ``window``.

    >>> import hexcast
    >>> from hexcast.shapes import box
    >>> hexcast.parts(box((0, 0, 0), (1, 1, 1)), 2, cells=10)
    [(0, 0, 0, 10, 10, 5), (0, 0, 5, 10, 10, 10)]
    """
    of = [1, 1, n] if isinstance(n, int) else list(n)
    if len(of) != 3 or any(number < 1 for number in of):
        raise Error(f"n is {n!r}", "job-value", "give a number of slabs, or three numbers of boxes along x, y and z")
    return [(*first, *end) for first, end in _hexcast.parts(*job_of(what, options), of)]


@with_options(JobOptions)
def converge(
    what: JobLike,
    sizes: Sequence[int] = (32, 64, 128, 256),
    *,
    adapter: Optional[str] = None,
    **options: Unpack[JobOptions],
) -> list[dict[str, Any]]:
    """Meshes at several sizes of cells, to choose one: errors of volume and of the area seen along the axes, time and bytes.

    :param what: as for :func:`mesh`. Cells that a job file chooses give way to ``sizes``.
    :param sizes: cells along the longest side of the box, of each mesh.
    :returns: for each size what the command ``hexcast converge --json`` prints, such as ``dims`` and ``flags[0]["volume_error"]``, which
        is None where a surface is open.

    >>> import hexcast
    >>> from hexcast.shapes import sphere
    >>> levels = hexcast.converge(sphere((0, 0, 0), 1.0), [8, 32], backend="cpu")
    >>> [level["dims"] for level in levels]
    [[8, 8, 8], [32, 32, 32]]
    """
    job, surfaces = job_of(what, options)
    kept = {key: value for key, value in json.loads(job).items() if key in options or key not in SIZES}
    levels: list[dict[str, Any]] = json.loads(_hexcast.converge(json.dumps(kept), surfaces, list(sizes), adapter))
    return levels


@with_options(JobOptions)
def refine(
    what: JobLike,
    levels: int,
    *,
    level_of_flags: Optional[Mapping[int, int]] = None,
    boxes: Sequence[tuple[Sequence[float], int]] = (),
    progress: Union[Callable[[int, int], object], bool, Any, None] = None,
    adapter: Optional[str] = None,
    threads: Optional[int] = None,
    **options: Unpack[JobOptions],
) -> Leaves:
    """Halves the cells of a job where surfaces are, again and again: the leaves of an octree, ``docs/refine.md``.

    :param what: as for :func:`mesh`. Its cells are those of level 0.
    :param levels: how often cells are halved along each axis at surfaces, 0 to 16.
    :param level_of_flags: flags at whose surfaces they are halved less often; 0 for not at all.
    :param boxes: places where they are halved so often at least, wherever surfaces are: ``((x0, y0, z0, x1, y1, z1), level)``.
    :param progress: as for :func:`mesh`, of each level.
    :param adapter: a part of the name of the GPU to use.
    :param threads: number of threads of the processor.
    :param options: the keys of a job file, without ``window``, ``part``, ``close_gaps`` and what is measured.
    :returns: the leaves, by levels. Warnings about the finest mesh are issued as :class:`MeshWarning`.
    :raises hexcast.Error: ``job-conflict``, ``job-value``, ``memory``; those of :func:`mesh`.

    >>> import hexcast
    >>> from hexcast.shapes import sphere
    >>> leaves = hexcast.refine(sphere((0, 0, 0), 1.0), 3, cells=8, backend="cpu")
    >>> leaves.dims[-1], bool(len(leaves) < 64**3 / 4)
    ((64, 64, 64), True)
    """
    job, surfaces = job_of(what, options)
    if not isinstance(levels, int) or not 0 <= levels <= 255:
        raise Error(f"levels is {levels!r}", "job-value", "give a whole number, 0 to 16")
    of_flags = list((level_of_flags or {}).items())
    of_boxes = [(list(map(float, box)), level) for box, level in boxes]
    for box, _ in of_boxes:
        if len(box) != 6:
            raise Error(f"a box has {len(box)} numbers", "job-value", "give six: x0, y0, z0, x1, y1, z1")
    with follow(progress) as function:
        raw = _hexcast.refine(job, surfaces, levels, of_flags, of_boxes, adapter, threads_of(threads), function)
    warn_of(json.loads(raw.facts()[1]), stacklevel=3)
    return leaves_of(raw)


def load(path: Union[str, os.PathLike[str]]) -> Mesh:
    """Reads a column file (``.hxc``) that :meth:`Mesh.save` or the command wrote.

    :raises hexcast.Error: ``io``; ``columns-corrupt`` where it is damaged; ``columns-version`` where a newer hexcast wrote it.
    """
    if not os.path.exists(path):
        raise missing(path)
    return Mesh(_hexcast.load(os.fspath(path)))
