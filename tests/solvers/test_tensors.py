"""Smoothed permittivity: modes of a lattice of dielectric rods on a grid of Yee, and tensors around a ball."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from conftest import hexcast, save, sphere
from elements import modes_of_rods
from rods import CENTRE, EPS, MODES, RADIUS, VECTOR, matrices, modes, rods_of, save_rod


def test_modes_of_rods_are_those_of_finite_elements(tmp_path: Path) -> None:
    assert (abs(modes_of_rods(tmp_path, EPS, RADIUS, CENTRE, VECTOR, 0.02) / MODES - 1) < 1e-6).all()


def test_modes_of_rods_need_whole_tensors(tmp_path: Path) -> None:
    save_rod(tmp_path)
    cells = np.array([16, 32, 64, 128])
    kinds = ("full", "diagonal", "flags")
    off: dict[str, np.ndarray] = {kind: np.zeros((len(cells), len(MODES))) for kind in kinds}
    for at, n in enumerate(cells.tolist()):
        hexcast(*rods_of(n), "--tensors", "eps.npz", "--staggered", "yee.npz", cwd=tmp_path)
        for kind in kinds:
            off[kind][at] = abs(modes(tmp_path, n, kind) / MODES - 1)
    orders = {kind: -np.polyfit(np.log(cells), np.log(of), 1)[0] for kind, of in off.items()}
    for kind in off:
        print(kind, "off by", off[kind].T, "orders", orders[kind])
    # below those of Meep's own smoothing: 2.4e-3, 6.4e-4, 1.9e-4, 1.5e-4
    assert (off["full"][:, 0] < (1.45e-3, 4.0e-4, 1.52e-4, 7.4e-5)).all()
    assert (orders["full"] > 1.37).all()
    # by flags errors change their sign now and then
    assert (off["full"][-2:].max(axis=0) < off["flags"][-2:].max(axis=0)).all()
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
