"""Poiseuille's flow in a round pipe by lattice Boltzmann (D3Q19, two relaxation times), with walls where the links that hexcast writes have them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from conftest import rod, save

#: Where the axis of the pipe is, in cells from a line: nowhere in particular.
PLACE = (0.37, 0.21)
#: Force on the fluid.
FORCE = 1e-6


def save_pipe(folder: Path) -> None:
    """A pipe of radius 1 along x."""
    save(folder / "pipe.stl", rod(1, 4, 4000) - np.array([2, 0, 0]))


def pipe_of(cells: int) -> list[str]:
    """Arguments of the command for a slice of the pipe with so many cells across."""
    size, n = 2 / cells, cells + 3
    low = -size * n / 2 + size * np.array(PLACE)
    ends = ",".join(repr(float(end)) for end in (-size / 2, *low, size / 2, *(low + n * size)))
    return ["mesh", "pipe.stl", f"--domain={ends}", "--dims", f"1,{n},{n}", "--fluid", "1", "--periodic", "x", "--backend", "cpu"]


def flow(path: Path, cells: int, *, is_interpolated: bool) -> float:
    """How far the speeds of all cells are off, as a root mean square over that of theory: half-way bounce-back from flags, or Bouzidi's with the links."""
    with np.load(path) as links:
        steps = links["directions"].astype(int)
        _, n, _ = links["dims"]
        parts = np.zeros((len(steps), n, n))
        parts[links["direction"], links["y"], links["z"]] = links["q"]
    opposite = [int(np.flatnonzero((steps == -step).all(1))[0]) for step in steps]
    middle = 2 / cells * (np.arange(n) + 0.5 - n / 2)
    square = (middle[:, None] + 2 / cells * PLACE[0]) ** 2 + (middle + 2 / cells * PLACE[1]) ** 2
    is_fluid = square < 1
    weights = np.array([1 / 3, 1 / 18, 1 / 36])[(steps**2).sum(1)][:, None, None]
    # the second rate puts half-way walls where they are (Ginzburg), and flow does not depend on the first
    time, viscosity = 1.0, 1 / 6
    other_time = 0.5 + 3 / 16 / (time - 0.5)
    pushed = 3 * weights * FORCE * steps[:, 0, None, None] * (1 - 0.5 / other_time)
    radius = cells / 2

    def streamed(density: np.ndarray, along: int) -> np.ndarray:
        return np.roll(density, steps[along, 1:], (0, 1))

    density = np.tile(weights, (1, n, n))
    for _ in range(int(2 * radius**2 / viscosity)):
        momentum = [np.tensordot(steps[:, axis], density, 1) for axis in range(3)]
        momentum[0] += FORCE / 2
        expected = weights * (density.sum(0) + 3 * np.tensordot(steps, np.array(momentum), 1))
        rest = density - expected
        even, odd = (rest + rest[opposite]) / 2, (rest - rest[opposite]) / 2
        density = density - even / time - odd / other_time + pushed
        after = np.stack([streamed(density[along], along) for along in range(len(steps))])
        for along in range(1, len(steps)):
            is_wall = parts[along] > 0
            part, out = parts[along][is_wall], density[along][is_wall]
            if is_interpolated:
                before, back = streamed(density[along], along)[is_wall], density[opposite[along]][is_wall]
                out = np.where(part < 0.5, 2 * part * out + (1 - 2 * part) * before, (out + (2 * part - 1) * back) / (2 * part))
            after[opposite[along]][is_wall] = out
        density = np.where(is_fluid, after, weights)
    speed = (np.tensordot(steps[:, 0], density, 1) + FORCE / 2)[is_fluid]
    theory = FORCE * radius**2 * (1 - square[is_fluid]) / (4 * viscosity)
    return float(np.sqrt(((speed - theory) ** 2).sum() / (theory**2).sum()))
