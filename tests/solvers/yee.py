"""Solvers of Maxwell's equations with the edges and faces outside metal that hexcast measures: in time around a ball, and for modes of a round waveguide."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import scipy.sparse as sparse
from conftest import cuboid, rod, save, sphere
from scipy.sparse.linalg import eigsh

#: Where the centre of the ball or of the waveguide is, in cells from a line: nowhere in particular.
PLACE = (0.37, 0.21, 0.44)
#: First zero of the derivative of J1, by which TE11 fits a round waveguide of radius 1.
OF_WAVEGUIDE = 1.8411837813406593


def save_ball(folder: Path) -> None:
    """A ball of radius 1 in metal."""
    save(folder / "metal.stl", cuboid((-2, -2, -2), (2, 2, 2)))
    save(folder / "ball.stl", sphere(1, 6))


def save_guide(folder: Path) -> None:
    """A round waveguide along z, of radius 1, in metal."""
    save(folder / "metal.stl", cuboid((-2, -2, -2), (2, 2, 2)))
    sides = 4000
    # as large as a circle of radius 1
    radius = np.sqrt(2 * np.pi / (sides * np.sin(2 * np.pi / sides)))
    save(folder / "guide.stl", rod(radius, 4, sides)[..., [1, 2, 0]] - np.array([0, 0, 2]))


def box(cells: float, axes: int = 3) -> tuple[float, int, np.ndarray]:
    """Size of the cells, their number along an axis, and where the first is, of a box around a diameter of so many cells."""
    size, n = 2 / cells, int(np.ceil(cells)) + 4
    return size, n, -size * n / 2 + size * np.array(PLACE[:axes])


def ball_of(cells: int, *, unit: str = "mm") -> list[str]:
    """Arguments of the command for the ball."""
    size, n, low = box(cells)
    ends = ",".join(repr(float(end)) for end in (*low, *(low + n * size)))
    bodies = ["metal.stl:pec=true", "ball.stl:eps_r=1"]
    return ["mesh", *bodies, f"--domain={ends}", "--dims", f"{n},{n},{n}", "--unit", unit, "--backend", "cpu"]


def guide_of(cells: float) -> list[str]:
    """Arguments of the command for one layer of the waveguide."""
    size, n, low = box(cells, 2)
    ends = ",".join(repr(float(end)) for end in (*low, -size / 2, *(low + n * size), size / 2))
    bodies = ["metal.stl:pec=true", "guide.stl:eps_r=1"]
    return ["mesh", *bodies, f"--domain={ends}", "--dims", f"{n},{n},1", "--backend", "cpu"]


class Fields:
    """The fields of a `.npz` with cells of one size, where c = 1: E on edges, H on faces."""

    def __init__(self, path: Path) -> None:
        with np.load(path) as yee:
            self.lengths = [yee[name] for name in ("Lx", "Ly", "Lz")]
            areas = [yee[name] for name in ("Ax", "Ay", "Az")]
            self.low = np.array([yee[name][0] for name in "xyz"])
            self.size = float(yee["x"][1] - yee["x"][0])
            self.dt_factor = float(yee["dt_factor"])
        #: In cells.
        self.step = self.dt_factor / np.sqrt(3)
        self.per_area = [np.divide(1, area, out=np.zeros_like(area), where=area > 0) for area in areas]
        self.is_free = [length > 0 for length in self.lengths]
        self.electric = [np.zeros_like(length) for length in self.lengths]
        self.magnetic = [np.zeros_like(area) for area in areas]

    def faraday(self, step: float) -> None:
        x, y, z = (field * length for field, length in zip(self.electric, self.lengths))
        magnetic, per_area = self.magnetic, self.per_area
        magnetic[0] -= step * per_area[0] * (np.diff(z, axis=1) - np.diff(y, axis=0))
        magnetic[1] -= step * per_area[1] * (np.diff(x, axis=0) - np.diff(z, axis=2))
        magnetic[2] -= step * per_area[2] * (np.diff(y, axis=2) - np.diff(x, axis=1))

    def ampere(self, step: float) -> None:
        inner = slice(1, -1)
        x, y, z = self.magnetic
        electric = self.electric
        electric[0][inner, inner] += step * (np.diff(z[inner], axis=1) - np.diff(y[:, inner], axis=0))
        electric[1][inner, :, inner] += step * (np.diff(x[:, :, inner], axis=0) - np.diff(z[inner], axis=2))
        electric[2][:, inner, inner] += step * (np.diff(y[:, inner], axis=2) - np.diff(x[:, :, inner], axis=1))
        for field, free in zip(electric, self.is_free):
            field *= free


def mode_of_waveguide(path: Path, cells: float) -> float:
    """How far TE11 is off: by Faraday's and Ampere's laws on one layer of cells."""
    with np.load(path) as yee:
        lengths, areas = [yee["Lx"][0], yee["Ly"][0]], yee["Az"][0]
    is_open = areas > 0
    number = np.full(areas.shape, -1)
    number[is_open] = np.arange(is_open.sum())
    # the edges between neighbours along x are those along y
    along_x = (number[:, :-1], number[:, 1:], lengths[1][:, 1:-1])
    along_y = (number[:-1], number[1:], lengths[0][1:-1])
    before, behind, weight = (np.concatenate([one.ravel(), other.ravel()]) for one, other in zip(along_x, along_y))
    are_open = (before >= 0) & (behind >= 0)
    before, behind, weight = before[are_open], behind[are_open], weight[are_open]
    rows, columns = np.concatenate([before, behind, before, behind]), np.concatenate([before, behind, behind, before])
    values = np.concatenate([weight, weight, -weight, -weight]) * (cells / 2) ** 2
    curls = sparse.csc_matrix((values, (rows, columns)), shape=(is_open.sum(),) * 2)
    found = eigsh(curls, 6, sparse.diags(areas[is_open]).tocsc(), sigma=OF_WAVEGUIDE**2, return_eigenvectors=False)
    found = np.sqrt(abs(found))
    # of both polarisations
    return float(np.sort(abs(found / OF_WAVEGUIDE - 1))[:2].mean())
