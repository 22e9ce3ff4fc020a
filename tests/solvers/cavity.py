"""A sphere of vacuum in a block of metal: its lowest mode is TM011."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from conftest import cuboid, hexcast, save, sphere

#: In mm.
RADIUS = 10.0
#: First zero of the derivative of r j1(r), by which the mode fits the sphere.
ZERO = 2.743707


def theory(radius: float) -> float:
    """Frequency of TM011 in Hz."""
    return ZERO * 299792458 / (2 * np.pi * radius * 1e-3)


def mesh_cavity(folder: Path, output: str) -> None:
    """Cells of 0.5 mm; the box has its middle at 0, on lines."""
    save(folder / "metal.stl", cuboid((-11, -11, -11), (11, 11, 11)))
    save(folder / "sphere.stl", sphere(RADIUS, 5))
    arguments = ["metal.stl:pec=true", "sphere.stl:eps_r=1", "--cell-size", "0.5", "--unit", "mm", "--backend", "cpu"]
    hexcast("mesh", *arguments, "-o", output, cwd=folder)


def resonance(
    time: np.ndarray, voltage: np.ndarray, band: tuple[float, float] = (9e9, 20e9), after: float = 1.2e-9
) -> float:
    """Frequency of the highest peak of a spectrum in a band, after the excitation."""
    rings = time > after
    time, voltage = time[rings], voltage[rings]
    n = 1 << 20
    spectrum = abs(np.fft.rfft(voltage * np.hanning(len(voltage)), n))
    frequency = np.fft.rfftfreq(n, time[1] - time[0])
    peak = np.argmax(spectrum * ((frequency > band[0]) & (frequency < band[1])))
    below, at, above = np.log(spectrum[peak - 1 : peak + 2])
    return frequency[peak] + 0.5 * (below - above) / (below - 2 * at + above) * frequency[1]
