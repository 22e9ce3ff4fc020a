"""Edges and faces outside metal: a mode of a spherical cavity in the time domain, at the step that hexcast reports, and one of a round waveguide."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sparse
from cavity import ZERO
from conftest import cuboid, hexcast, rod, save, sphere
from scipy.sparse.linalg import eigsh

#: Where the centre of the ball is, in cells from a line: nowhere in particular.
PLACE = (0.37, 0.21, 0.44)
#: First zero of the derivative of J1, by which TE11 fits a round waveguide of radius 1.
OF_WAVEGUIDE = 1.8411837813406593


def mode(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, ...]:
    """The electric field of TM011 in a ball of radius 1."""
    r, rho = np.sqrt(x * x + y * y + z * z) + 1e-9, np.hypot(x, y) + 1e-12
    kr = ZERO * r
    bessel = np.sin(kr) / kr**2 - np.cos(kr) / kr
    slope = np.sin(kr) * (kr**2 - 1) / kr**2 + np.cos(kr) / kr
    radial, polar = 2 * bessel / kr * z / r, -slope / kr * np.hypot(x, y) / r
    outwards = radial * np.hypot(x, y) / r + polar * z / r
    return outwards * x / rho, outwards * y / rho, radial * z / r - polar * np.hypot(x, y) / r


def cavity(folder: Path, cells: int, *options: str) -> tuple[float, float]:
    """How far the mode of a ball of so many cells is off, and the step as a part of Yee's."""
    size = 2 / cells
    n = cells + 4
    low = -size * n / 2 + size * np.array(PLACE)
    ends = [*low, *(low + n * size)]
    domain = ",".join(repr(float(end)) for end in ends)
    hexcast(
        *("mesh", "metal.stl:pec=true", "ball.stl:eps_r=1", f"--domain={domain}", "--dims", f"{n},{n},{n}"),
        *("--unit", "mm", "--backend", "cpu", "--conformal", "cavity.npz", "--report", "report.json", *options),
        cwd=folder,
    )
    report = json.loads((folder / "report.json").read_text())["conformal"]
    with np.load(folder / "cavity.npz") as yee:
        lengths = [yee[name] for name in ("Lx", "Ly", "Lz")]
        areas = [yee[name] for name in ("Ax", "Ay", "Az")]
        assert yee["dt_factor"] == report["dt_factor"]
    assert np.isclose(report["dt"], report["dt_factor"] * size * 1e-3 / np.sqrt(3) / 299792458, rtol=1e-12)
    step = report["dt_factor"] / np.sqrt(3)
    per_area = [np.divide(1, area, out=np.zeros_like(area), where=area > 0) for area in areas]
    is_free = [length > 0 for length in lengths]
    electric = []
    for axis in range(3):
        shape = lengths[axis].shape[::-1]
        places = (low[of] + size * (np.arange(shape[of]) + 0.5 * (of == axis)) for of in range(3))
        field = mode(*np.meshgrid(*places, indexing="ij"))[axis]
        electric.append(field.transpose(2, 1, 0) * is_free[axis])
    weights = [field * length for field, length in zip(electric, lengths)]
    magnetic = [np.zeros_like(area) for area in areas]
    inner = slice(1, -1)

    def faraday(step: float) -> None:
        x, y, z = (field * length for field, length in zip(electric, lengths))
        magnetic[0] -= step * per_area[0] * (np.diff(z, axis=1) - np.diff(y, axis=0))
        magnetic[1] -= step * per_area[1] * (np.diff(x, axis=0) - np.diff(z, axis=2))
        magnetic[2] -= step * per_area[2] * (np.diff(y, axis=2) - np.diff(x, axis=1))

    def ampere() -> None:
        x, y, z = magnetic
        electric[0][inner, inner] += step * (np.diff(z[inner], axis=1) - np.diff(y[:, inner], axis=0))
        electric[1][inner, :, inner] += step * (np.diff(x[:, :, inner], axis=0) - np.diff(z[inner], axis=2))
        electric[2][:, inner, inner] += step * (np.diff(y[:, inner], axis=2) - np.diff(x[:, :, inner], axis=1))
        for field, free in zip(electric, is_free):
            field *= free

    def amplitude() -> float:
        return float(sum((weight * field).sum() for weight, field in zip(weights, electric)))

    signal = [amplitude()]
    faraday(step / 2)
    # two periods
    for _ in range(int(4 * np.pi / (ZERO * step * size))):
        ampere()
        faraday(step)
        signal.append(amplitude())
    u = np.array(signal)
    # of a cosine: u(t - dt) + u(t + dt) = 2 cos(w dt) u(t)
    cosine = ((u[2:] + u[:-2]) * u[1:-1]).sum() / (2 * (u[1:-1] ** 2).sum())
    return np.arccos(cosine) / (step * size) / ZERO - 1, report["dt_factor"]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    save(tmp_path / "metal.stl", cuboid((-2, -2, -2), (2, 2, 2)))
    ball = sphere(1, 6)
    volume = np.einsum("ij,ij->i", ball[:, 0], np.cross(ball[:, 1], ball[:, 2])).sum() / 6
    # its corners lie on the ball, so that without this it is too small
    save(tmp_path / "ball.stl", ball * (4 * np.pi / 3 / abs(volume)) ** (1 / 3))
    return tmp_path


def test_walls_are_second_order(folder: Path) -> None:
    found = {cells: cavity(folder, cells) for cells in (16, 32, 48)}
    off = np.array([abs(found[cells][0]) for cells in found])
    order = -np.polyfit(np.log(list(found)), np.log(off), 1)[0]
    print("off by", found, "order", order)
    assert order > 1.9
    assert (off < (2e-3, 4.1e-4, 2.2e-4)).all()
    assert min(factor for _, factor in found.values()) > 0.65


def test_larger_faces_allow_nearly_the_whole_step(folder: Path) -> None:
    found = {cells: cavity(folder, cells, "--stable", "0.25") for cells in (16, 32)}
    print("off by", found)
    assert all(factor > 0.85 for _, factor in found.values())
    assert abs(found[16][0]) < 1.2e-3
    assert abs(found[32][0]) < 4.1e-4


def waveguide(folder: Path, cells: int, *options: str) -> float:
    """How far TE11 of a round waveguide of so many cells is off: by Faraday's and Ampere's laws on one layer of cells."""
    size = 2 / cells
    n = cells + 4
    low = -size * n / 2 + size * np.array(PLACE[:2])
    ends = [*low, -size / 2, *(low + n * size), size / 2]
    domain = ",".join(repr(float(end)) for end in ends)
    arguments = ["metal.stl:pec=true", "guide.stl:eps_r=1", f"--domain={domain}", "--dims", f"{n},{n},1"]
    hexcast("mesh", *arguments, "--backend", "cpu", "--conformal", "guide.npz", *options, cwd=folder)
    with np.load(folder / "guide.npz") as yee:
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
    values = np.concatenate([weight, weight, -weight, -weight]) / size**2
    curls = sparse.csc_matrix((values, (rows, columns)), shape=(is_open.sum(),) * 2)
    found = eigsh(curls, 6, sparse.diags(areas[is_open]).tocsc(), sigma=OF_WAVEGUIDE**2, return_eigenvectors=False)
    found = np.sqrt(abs(found))
    # of both polarisations
    return np.sort(abs(found / OF_WAVEGUIDE - 1))[:2].mean()


@pytest.mark.parametrize("stable", ["0", "0.125", "0.25"])
def test_a_round_waveguide_is_second_order(folder: Path, stable: str) -> None:
    sides = 4000
    # as large as a circle of radius 1
    radius = np.sqrt(2 * np.pi / (sides * np.sin(2 * np.pi / sides)))
    along_z = rod(radius, 4, sides)[..., [1, 2, 0]]
    save(folder / "guide.stl", along_z - np.array([0, 0, 2]))
    cells = np.array([16, 32, 64, 128])
    off = np.array([waveguide(folder, n, "--stable", stable) for n in cells.tolist()])
    order = -np.polyfit(np.log(cells), np.log(off), 1)[0]
    print("off by", off, "order", order)
    assert order > 1.94
    assert off[-1] < 4e-5
