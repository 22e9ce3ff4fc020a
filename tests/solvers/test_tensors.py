"""Smoothed permittivity: modes of a lattice of dielectric rods on a grid of Yee, and tensors around a ball."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sparse
from conftest import hexcast, rod, save, sphere
from scipy.sparse.linalg import eigsh

#: Permittivity of the rod, in vacuum, its radius, and where its axis is in a cell of the lattice of size 1: nowhere in particular.
EPS, RADIUS, CENTRE = 12.0, 0.2, (0.513, 0.488)
#: Bloch's vector.
VECTOR = 2 * np.pi * np.array([0.3, 0.1])
#: The first three modes with H along the rods, as frequencies by c / lattice, by Richardson's extrapolation from 128 and 256 cells with tensors. Those of diagonals and flags
#: come from the other side, to 2e-3 at 128 cells.
MODES = np.array([0.28023493, 0.52887508, 0.67954202])


def matrices(tensors: np.ndarray) -> np.ndarray:
    """Tensors as matrices."""
    return tensors[..., [[0, 5, 4], [5, 1, 3], [4, 3, 2]]]


def save_rod(folder: Path) -> None:
    sides = 2000
    # as large as a circle of this radius
    radius = RADIUS * np.sqrt(2 * np.pi / (sides * np.sin(2 * np.pi / sides)))
    save(folder / "rod.stl", rod(radius, 4, sides)[..., [1, 2, 0]] + np.array([*CENTRE, -2]))


def modes(folder: Path, n: int, kind: str) -> np.ndarray:
    """The first modes on n x n cells, by tensors, what these have on their diagonals alone, or flags."""
    size = 1 / n
    domain = f"--domain=0,0,{-size / 2!r},1,1,{size / 2!r}"
    arguments = ["mesh", f"rod.stl:eps_r={EPS}", domain, "--dims", f"{n},{n},1", "--backend", "cpu"]
    hexcast(*arguments, "--tensors", "eps.npz", "--staggered", "yee.npz", cwd=folder)
    # x first; the last points are the first of the next cell of the lattice
    with np.load(folder / "eps.npz") as eps, np.load(folder / "yee.npz") as yee:
        tensors = [eps["Ex"][0, :n].swapaxes(0, 1), eps["Ey"][0, :, :n].swapaxes(0, 1)]
        flags = [yee["Ex"][0, :n].T, yee["Ey"][0, :, :n].T]
    inverse = [np.linalg.inv(matrices(of)) for of in tensors]
    along = [inverse[axis][..., axis, axis] for axis in range(2)]
    if kind == "flags":
        along = [np.where(of == 1, 1 / EPS, 1.0) for of in flags]
    number = np.arange(n * n).reshape(n, n)
    one = sparse.identity(n * n, format="csr", dtype=complex)

    def behind(axis: int, step: int) -> sparse.csr_matrix:
        """What a field has a step further along an axis."""
        phase = np.ones((n, n), complex)
        beyond = [slice(None)] * 2
        beyond[axis] = slice(n - 1, n) if step > 0 else slice(0, 1)
        phase[tuple(beyond)] = np.exp(1j * VECTOR[axis] * step)
        return sparse.csr_matrix((phase.ravel(), (number.ravel(), np.roll(number, -step, axis).ravel())), shape=(n * n,) * 2)

    # D = curl H, with H in the middle of cells
    flux = [(one - behind(1, -1)) / size, -(one - behind(0, -1)) / size]
    electric = [sparse.diags(of.ravel()) @ d for of, d in zip(along, flux)]
    if kind == "full":
        # the mean of the four points of Ey around one of Ex, and back
        to_x = (one + behind(0, 1)) / 2 @ (one + behind(1, -1)) / 2
        across = [sparse.diags(of[..., 0, 1].ravel()) for of in inverse]
        coupling = (across[0] @ to_x + to_x @ across[1]) / 2
        electric[0] = electric[0] + coupling @ flux[1]
        electric[1] = electric[1] + coupling.getH() @ flux[0]
    curl = flux[0].getH() @ electric[0] + flux[1].getH() @ electric[1]
    found = eigsh((curl + curl.getH()).tocsc() / 2, 3, sigma=1e-3, return_eigenvectors=False)
    return np.sort(np.sqrt(abs(found))) / (2 * np.pi)


def test_modes_of_rods_need_whole_tensors(tmp_path: Path) -> None:
    save_rod(tmp_path)
    cells = np.array([16, 32, 64])
    kinds = ("full", "diagonal", "flags")
    off = {kind: np.array([abs(modes(tmp_path, n, kind) / MODES - 1) for n in cells.tolist()]) for kind in kinds}
    orders = {kind: -np.polyfit(np.log(cells), np.log(of), 1)[0] for kind, of in off.items()}
    for kind in off:
        print(kind, "off by", off[kind].T, "orders", orders[kind])
    # those of Meep's own smoothing
    assert (off["full"][:, 0] < (2.4e-3, 6e-4, 1.5e-4)).all()
    assert (orders["full"] > 1.4).all()
    assert (off["full"][-1] < off["flags"][-1]).all()
    assert (off["full"][:, 0] < off["diagonal"][:, 0] / 3).all()


def test_tensors_around_a_ball_are_those_of_its_fractions_and_radii(tmp_path: Path) -> None:
    radius, low, n, fine = 1.0, np.array([-1.31, -1.22, -1.27]), 12, 16
    size = 2.6 / n
    save(tmp_path / "ball.stl", sphere(radius, 6))
    ends = [*low, *(low + n * size)]
    domain = ",".join(repr(float(end)) for end in ends)
    arguments = ["ball.stl:eps_r=9", f"--domain={domain}", "--dims", f"{n},{n},{n}", "--backend", "cpu"]
    hexcast("mesh", *arguments, "--tensors", "eps.npz", "--report", "report.json", cwd=tmp_path)
    report = json.loads((tmp_path / "report.json").read_text())["tensors"]
    assert report["without_normal"] == report["sampled_points"] == 0
    n_cut = 0
    with np.load(tmp_path / "eps.npz") as eps:
        for axis, name in enumerate(("Ex", "Ey", "Ez")):
            found = matrices(eps[name])
            points = [low[of] + size * (np.arange(found.shape[2 - of]) + 0.5 * (of == axis)) for of in range(3)]
            middles = [(at[:, None] + size * ((np.arange(fine) + 0.5) / fine - 0.5)).ravel() for at in points]
            z, y, x = np.meshgrid(*middles[::-1], indexing="ij", sparse=True)
            shape = [length for points in found.shape[:3] for length in (points, fine)]
            part = (x * x + y * y + z * z < radius**2).reshape(shape).mean(axis=(1, 3, 5))
            normal = np.stack(np.meshgrid(*points[::-1], indexing="ij")[::-1], axis=-1)
            normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
            mean, across = 1 + 8 * part, 1 / (1 - part + part / 9)
            expected = mean[..., None, None] * np.eye(3) + (across - mean)[..., None, None] * normal[..., None] * normal[..., None, :]
            is_cut = (part > 0) & (part < 1)
            off = np.abs(found - expected).max(axis=(-2, -1))
            assert off[~is_cut].max() < 0.1
            # what samples and the bend of the ball in a cell leave
            assert off[is_cut].mean() < 0.1
            assert off[is_cut].max() < 0.6
            n_cut += is_cut.sum()
    # samples miss slivers, and see nothing that is not there
    assert 0.9 * report["cut_points"] < n_cut <= report["cut_points"]
