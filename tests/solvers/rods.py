"""Modes of a square lattice of dielectric rods on a grid of Yee, by the permittivity that hexcast writes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import scipy.sparse as sparse
from conftest import rod, save
from scipy.sparse.linalg import eigsh

#: Permittivity of the rod, in vacuum, its radius, and where its axis is in a cell of the lattice of size 1: nowhere in particular.
EPS, RADIUS, CENTRE = 12.0, 0.2, (0.513, 0.488)
#: Bloch's vector.
VECTOR = 2 * np.pi * np.array([0.3, 0.1])
#: The first three modes with H along the rods, as frequencies by c / lattice, by finite elements (`elements.py`, triangles of 0.01).
MODES = np.array([0.28024031, 0.52891243, 0.67955477])


def matrices(tensors: np.ndarray) -> np.ndarray:
    """Tensors as matrices."""
    return tensors[..., [[0, 5, 4], [5, 1, 3], [4, 3, 2]]]


def save_rod(folder: Path) -> None:
    sides = 2000
    # as large as a circle of this radius
    radius = RADIUS * np.sqrt(2 * np.pi / (sides * np.sin(2 * np.pi / sides)))
    save(folder / "rod.stl", rod(radius, 4, sides)[..., [1, 2, 0]] + np.array([*CENTRE, -2]))


def rods_of(n: int) -> list[str]:
    """Arguments of the command for a cell of the lattice."""
    domain = f"--domain=0,0,{-0.5 / n!r},1,1,{0.5 / n!r}"
    return ["mesh", f"rod.stl:eps_r={EPS}", domain, "--dims", f"{n},{n},1", "--backend", "cpu"]


def modes(folder: Path, n: int, kind: str) -> np.ndarray:
    """The first modes on n x n cells, by tensors (eps.npz), what these have on their diagonals alone, or flags (yee.npz)."""
    size = 1 / n
    # x first; the last points are the first of the next cell of the lattice
    if kind == "flags":
        with np.load(folder / "yee.npz") as yee:
            flags = [yee["Ex"][0, :n].T, yee["Ey"][0, :, :n].T]
        along = [np.where(of == 1, 1 / EPS, 1.0) for of in flags]
    else:
        with np.load(folder / "eps.npz") as eps:
            tensors = [eps["Ex"][0, :n].swapaxes(0, 1), eps["Ey"][0, :, :n].swapaxes(0, 1)]
        inverse = [np.linalg.inv(matrices(of)) for of in tensors]
        along = [inverse[axis][..., axis, axis] for axis in range(2)]
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
