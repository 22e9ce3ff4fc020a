"""Edges and faces outside metal: a mode of a spherical cavity in the time domain, at the step that hexcast reports, and one of a round waveguide."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from cavity import ZERO
from conftest import hexcast
from yee import Fields, ball_of, guide_of, mode_of_waveguide, save_ball, save_guide


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
    hexcast(*ball_of(cells), "--conformal", "cavity.npz", "--report", "report.json", *options, cwd=folder)
    report = json.loads((folder / "report.json").read_text())["conformal"]
    fields = Fields(folder / "cavity.npz")
    size, step, electric = fields.size, fields.step, fields.electric
    assert fields.dt_factor == report["dt_factor"]
    assert np.isclose(report["dt"], report["dt_factor"] * size * 1e-3 / np.sqrt(3) / 299792458, rtol=1e-12)
    for axis in range(3):
        shape = electric[axis].shape[::-1]
        places = (fields.low[of] + size * (np.arange(shape[of]) + 0.5 * (of == axis)) for of in range(3))
        field = mode(*np.meshgrid(*places, indexing="ij"))[axis]
        electric[axis][...] = field.transpose(2, 1, 0) * fields.is_free[axis]
    weights = [field * length for field, length in zip(electric, fields.lengths)]

    def amplitude() -> float:
        return float(sum((weight * field).sum() for weight, field in zip(weights, electric)))

    signal = [amplitude()]
    fields.faraday(step / 2)
    # two periods
    for _ in range(int(4 * np.pi / (ZERO * step * size))):
        fields.ampere(step)
        fields.faraday(step)
        signal.append(amplitude())
    u = np.array(signal)
    # of a cosine: u(t - dt) + u(t + dt) = 2 cos(w dt) u(t)
    cosine = ((u[2:] + u[:-2]) * u[1:-1]).sum() / (2 * (u[1:-1] ** 2).sum())
    return np.arccos(cosine) / (step * size) / ZERO - 1, fields.dt_factor


def test_walls_are_second_order(tmp_path: Path) -> None:
    save_ball(tmp_path)
    found = {cells: cavity(tmp_path, cells) for cells in (16, 32, 48)}
    off = np.array([abs(found[cells][0]) for cells in found])
    order = -np.polyfit(np.log(list(found)), np.log(off), 1)[0]
    print("off by", found, "order", order)
    assert order > 1.9
    assert (off < (2e-3, 4.1e-4, 2.2e-4)).all()
    assert min(factor for _, factor in found.values()) > 0.65


def test_larger_faces_allow_nearly_the_whole_step(tmp_path: Path) -> None:
    save_ball(tmp_path)
    found = {cells: cavity(tmp_path, cells, "--stable", "0.25") for cells in (16, 32, 48, 64)}
    print("off by", found)
    assert all(factor > 0.85 for _, factor in found.values())
    off = np.array([abs(of) for of, _ in found.values()])
    assert (off < (1.2e-3, 4.1e-4, 2.2e-4, 1.6e-4)).all()


@pytest.mark.parametrize("stable", ["0", "0.125", "0.25"])
def test_a_round_waveguide_is_second_order(tmp_path: Path, stable: str) -> None:
    save_guide(tmp_path)
    cells = np.array([14.5, 29, 58, 116, 233])
    off = []
    for n in cells.tolist():
        hexcast(*guide_of(n), "--conformal", "guide.npz", "--stable", stable, cwd=tmp_path)
        off.append(mode_of_waveguide(tmp_path / "guide.npz", n))
    order = -np.polyfit(np.log(cells), np.log(off), 1)[0]
    print("off by", off, "order", order)
    assert order > 1.94
    assert off[0] < 2.5e-3
    assert off[-1] < 1.2e-5
