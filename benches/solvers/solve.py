"""The solvers in NumPy and SciPy that take what hexcast measures, each as a process, so that it can be measured.

usage: solve.py ball FILE.npz UNIT | guide FILE.npz CELLS | rods FOLDER CELLS KIND | pipe FILE.npz CELLS (flags | links); prints a number
"""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests/solvers"))
from pipe import flow
from ringing import SECONDS, frequency_of, pulse
from rods import modes
from yee import Fields, mode_of_waveguide


def ball(path: Path) -> float:
    """Frequency at which a ball of radius 1 cm rings."""
    fields = Fields(path)
    metres = fields.size * 1e-2
    dt = fields.step * metres / 299792458
    x, y, z = np.rint(-fields.low / fields.size).astype(int)
    probe = x + round(0.2 / fields.size)
    voltage = []
    for at in range(int(SECONDS / dt)):
        fields.faraday(fields.step)
        fields.ampere(fields.step)
        fields.electric[2][z, y, x] += pulse(at * dt)
        voltage.append(fields.electric[2][z, y, probe])
    return frequency_of(np.arange(len(voltage)) * dt, np.array(voltage))


what, path, *more = sys.argv[1:]
if what == "ball":
    print(ball(Path(path)))
elif what == "guide":
    print(mode_of_waveguide(Path(path), float(more[0])))
elif what == "rods":
    print(modes(Path(path), int(more[0]), more[1])[0])
else:
    print(flow(Path(path), int(more[0]), is_interpolated=more[1] == "links"))
