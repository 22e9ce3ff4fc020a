"""A scene: a mesh that follows the edits of its job."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any, NamedTuple, Optional

import numpy as np
from numpy.typing import NDArray

from . import _hexcast
from ._job import JobLike, job_of
from ._mesh import Mesh
from ._progress import follow

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._options import JobOptions


class ChangedRuns(NamedTuple):
    """Cells whose flags changed, as runs along rays: run ``r`` is the cells ``starts[r]`` to ``ends[r]``, exclusive, of ray ``rays[r]``."""

    #: Axis of the rays: 0, 1 or 2 for x, y or z. Rays are counted over the other two axes, the earlier one fastest.
    axis: int
    #: Number of cells on these two axes.
    counts: tuple[int, int]
    #: Ray of each run, ascending: shape (runs,), uint64.
    rays: NDArray[np.uint64]
    #: First cell of each run: shape (runs,), uint32.
    starts: NDArray[np.uint32]
    #: The cell after the last: shape (runs,), uint32.
    ends: NDArray[np.uint32]
    #: The flag that these cells had: shape (runs,), uint8.
    before: NDArray[np.uint8]
    #: The flag that they have: shape (runs,), uint8.
    after: NDArray[np.uint8]

    def cells(self) -> tuple[NDArray[np.uint32], NDArray[np.uint8], NDArray[np.uint8]]:
        """Every cell: x, y, z of shape (cells, 3), and its flags before and after, each of shape (cells,)."""
        lengths = self.ends - self.starts
        run = np.repeat(np.arange(len(lengths)), lengths)
        first = np.cumsum(lengths) - lengths
        rays = self.rays[run]
        index = np.empty((len(run), 3), np.uint32)
        index[:, self.axis] = self.starts[run] + (np.arange(len(run)) - first[run])
        across = [axis for axis in range(3) if axis != self.axis]
        index[:, across[0]] = rays % self.counts[0]
        index[:, across[1]] = rays // self.counts[0]
        return index, self.before[run], self.after[run]


class Update(NamedTuple):
    """What an update did."""

    #: The cells whose flags changed; None where the box has other lines or rays, so that all may have.
    changed: Optional[ChangedRuns]
    #: Why the whole was meshed, None where some rays were enough. "box": the lines are other ones, or the axis of the rays, the rule, the
    #: unit or the precision. "surface": rays of one axis do not decide a geometry: it is open, flat, inverted, a shell or has cells along its
    #: surface. "asked": the job asks for more than cells, such as links, for closed gaps, or for a window or part. "memory": the
    #: crossings exceed ``max_memory``. Each may be that of the job before, too.
    whole: Optional[str]
    #: Rays whose runs were made again.
    rays: int
    #: What to know, as in a report; where some rays were enough, geometries without cells and facts of the lines alone.
    findings: list[dict[str, Any]]


class Scene:
    """A job whose geometries move, and its mesh, of which each update makes what changed: see :func:`hexcast.scene`."""

    def __init__(self, raw: _hexcast.RawScene, options: dict[str, Any]) -> None:
        self._raw = raw
        self._options = options
        self._mesh: Optional[Mesh] = None

    @property
    def mesh(self) -> Mesh:
        """The mesh of the last update. It stays as it is when the scene goes on, and shares with it what does not change. Where some rays were
        enough for that update, its report has what the columns say, as that of a loaded column file."""
        if self._mesh is None:
            self._mesh = Mesh(self._raw.mesh())
        return self._mesh

    def update(self, what: JobLike, *, progress: Any = None, **options: Unpack[JobOptions]) -> Update:
        """Gives the scene another job, and meshes what that changes.

        :param what: what :func:`hexcast.scene` takes. A surface that :func:`hexcast.surface` made is known again; any other is read again,
            and counts as changed.
        :param progress: as for :func:`hexcast.mesh`.
        :param options: keys of a job file, which replace those that the scene has from then on.
        :returns: what changed. After an error the mesh is as before.
        :raises hexcast.Error: as :func:`hexcast.mesh`.
        """
        given = {**self._options, **options}
        with follow(progress) as function:
            facts, changed = self._raw.update(*job_of(what, given), function)
        self._options, self._mesh = given, None
        update = json.loads(facts)
        runs = None if changed is None else ChangedRuns(*changed)
        return Update(runs, update["whole"], update["rays"], update["findings"])
