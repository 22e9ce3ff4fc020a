"""The examples run."""

from __future__ import annotations

import re
import subprocess
import sys

import numpy as np
import pyvista
from places import ROOT


def run(name: str, *arguments: object) -> str:
    script = ROOT / "python" / "examples" / name
    return subprocess.run(
        [sys.executable, script, *map(str, arguments)], check=True, stdout=subprocess.PIPE, text=True, timeout=300
    ).stdout


def test_flow_round_a_body(spot):
    printed = run("lbmpy_flow.py", spot)
    speed, free = map(float, re.search(r"x: (\S+) in the fluid, (\S+) without", printed).groups())
    # the body slows the fluid down
    assert 0.05 * free < speed < 0.95 * free


def test_picture(spot, tmp_path):
    printed = run("pyvista_picture.py", spot, tmp_path / "cells.png")
    assert int(printed.split()[0]) > 10_000
    picture = pyvista.read(tmp_path / "cells.png")
    assert picture.dimensions[:2] == (800, 600)
    colours = np.unique(picture.active_scalars.reshape(-1, picture.active_scalars.shape[-1]), axis=0)
    assert len(colours) > 100


def test_slice(spot):
    printed = run("xarray_slice.py", spot)
    assert "#" in printed
    assert re.search(r"\d+\.\d% of the plane at z = -?0\.0\d+ m is inside", printed)
