"""Flags on a staggered grid: the lowest mode of a spherical cavity, by the equations of Yee's grid themselves."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import scipy.sparse as sparse
from cavity import RADIUS, ZERO
from conftest import cuboid, hexcast, save, sphere
from scipy.sparse.linalg import eigsh

#: Cells of the diameter.
CELLS = 16


def wave_number(conducts: list[np.ndarray], size: float) -> float:
    """The mode nearest to the theory's, of edges that do not conduct, [x, y, z]; edges of the components have their own arrays."""
    shapes = [array.shape for array in conducts]
    starts = np.cumsum([0, *(array.size for array in conducts)])
    number = [np.arange(array.size).reshape(array.shape) + start for array, start in zip(conducts, starts)]
    rows = []
    for axis in range(3):
        first, second = (axis + 1) % 3, (axis + 2) % 3

        def ends(component: int, along: int) -> list[np.ndarray]:
            n = shapes[component][along]
            return [np.take(number[component], range(start, n - 1 + start), along).ravel() for start in (0, 1)]

        before, behind = ends(second, first)
        below, above = ends(first, second)
        at = np.arange(before.size)
        values = np.repeat([-1.0, 1.0, 1.0, -1.0], before.size) / size
        columns = np.concatenate([before, behind, below, above])
        rows.append(sparse.csr_matrix((values, (np.tile(at, 4), columns)), shape=(before.size, starts[-1])))
    is_free = np.concatenate([~array.ravel() for array in conducts])
    curl = sparse.vstack(rows).tocsc()[:, is_free]
    theory = (ZERO / RADIUS) ** 2
    found = eigsh((curl.T @ curl).tocsc(), k=3, sigma=theory, return_eigenvectors=False)
    return float(np.sqrt(found[np.argmin(abs(found - theory))]))


def test_a_spherical_cavity_is_as_large_as_its_cells(tmp_path: Path) -> None:
    save(tmp_path / "metal.stl", cuboid((-12.5, -12.5, -12.5), (12.5, 12.5, 12.5)))
    save(tmp_path / "sphere.stl", sphere(RADIUS, 4))
    size = 2 * RADIUS / CELLS
    off = {}
    for name, options in (("points", []), ("cells", ["--conductors", "1"])):
        arguments = ["metal.stl", "sphere.stl", "--cell-size", size, "--backend", "cpu", "--staggered", f"{name}.npz"]
        hexcast("mesh", *arguments, *options, cwd=tmp_path)
        with np.load(tmp_path / f"{name}.npz") as yee:
            conducts = [yee[component].transpose(2, 1, 0) == 1 for component in ("Ex", "Ey", "Ez")]
        off[name] = wave_number(conducts, size) / (ZERO / RADIUS) - 1
    print("mode of a sphere of", CELLS, "cells: off by", off)
    # the metal of points alone is too thin, so that the sphere is too large
    assert off["points"] < -0.05
    assert abs(off["cells"]) < 0.025
