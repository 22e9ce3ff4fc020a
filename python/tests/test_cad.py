"""STEP and IGES: volumes, names and units of bodies, by the package and by the command; and what cannot be read."""

from __future__ import annotations

import json
import math
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge
from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox, BRepPrimAPI_MakeCylinder
from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt
from OCP.STEPControl import STEPControl_AsIs, STEPControl_Writer
from places import FIXTURES

import hexcast

MACHINE, TUBE = FIXTURES / "machine.step", FIXTURES / "tube.igs"
#: Volume and area of each body of machine.step, in mm.
BODIES = {
    "machine/block rounded": (24 * 14 * 4 + 6 * (24 * 14 + 14 * 4 + 4 * 24) + 9 * math.pi * 42 + 36 * math.pi, 2200.0),
    "machine/tube": (math.pi * 20 * 20, 2 * math.pi * (200 + 20)),
    "machine/pair/ball": (math.pi * 500 / 3, 100 * math.pi),
    "machine/pair/ring": (math.pi**2 * 64, 64 * math.pi**2),
    "machine/pair/ball 2": (math.pi * 500 / 3, 100 * math.pi),
    "machine/pair/ring 2": (math.pi**2 * 64, 64 * math.pi**2),
}


def run(program, *words, **environment):
    """What the command prints as JSON; its environment has a Python with Open CASCADE."""
    of = {**os.environ, "HEXCAST_PYTHON": sys.executable, **environment}
    return subprocess.run([program, *map(str, words)], capture_output=True, text=True, timeout=300, env=of)


def report(program, *words):
    done = run(program, "mesh", *words, "--json", "--backend", "cpu")
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.mark.parametrize(
    ("options", "mm"),
    [(["--cells", 64], 1), (["--cell-size", 2], 1), (["--unit", "cm", "--cells", 100], 10), (["--deviation", 1], 1), (["--unit", "in"], 25.4)],
)
def test_bodies_have_the_volumes_that_they_were_made_with(program, options, mm):
    made = report(program, MACHINE, "--split", *options)
    [source] = made["inputs"]
    wanted = [word for word, next in zip(options[1:], options) if next == "--unit"] or ["mm"]
    assert (source["format"], source["unit"], made["unit"]) == ("STEP", *wanted, *wanted)
    assert source["bytes"] == MACHINE.stat().st_size
    assert source["converted_by"].startswith("Open CASCADE ")
    deviation = source["deviation"]
    if "--deviation" in options:
        assert deviation == 1
    elif "--cell-size" in options:
        assert deviation == pytest.approx(0.2)
    else:
        # of a box that may be larger than the bodies by some percent
        assert 0.99 * 0.1 < deviation / made["spacing"][0] < 1.05 * 0.1
    assert [flag["name"] for flag in made["flags"]] == list(BODIES)
    for flag, (name, (volume, area)) in zip(made["flags"], BODIES.items()):
        assert abs(flag["mesh_volume"] * mm**3 - volume) <= area * deviation * mm, name
    assert [finding["code"] for finding in made["findings"] if finding["code"] == "surface-open"] == []


def test_the_package_makes_the_mesh_of_the_command(program, tmp_path):
    out = tmp_path / "machine.npy"
    report(program, MACHINE, "--split", "--cells", 70, "-o", out)
    mesh = hexcast.mesh(MACHINE, split=True, cells=70, backend="cpu")
    np.testing.assert_array_equal(mesh.flags, np.load(out))
    assert mesh.report["inputs"][0]["format"] == "STEP"
    coarse, fine = (hexcast.surface(MACHINE, deviation=deviation).n_facets for deviation in (0.5, 0.01))
    assert 2 * coarse < fine
    with pytest.raises(hexcast.Error, match="deviation is -1") as refused:
        hexcast.surface(MACHINE, deviation=-1)
    assert refused.value.code == "job-value"
    # two readers of their own decide the same cells
    columns = tmp_path / "machine.hxc"
    report(program, MACHINE, "--cells", 40, "-o", columns)
    verified = run(program, "verify", columns, MACHINE, "--cells", 40)
    assert verified.returncode == 0, verified.stdout + verified.stderr
    assert "(STEP) are as the mesher reads them" in verified.stdout


def test_cut_bodies_of_many_sizes(program, tmp_path):
    writer, volumes = STEPControl_Writer(), []
    for at in range(30):
        a, b, c, radius = 10 + at, 8 + at % 7, 1 + at % 5, 1 + at % 3
        plate = BRepPrimAPI_MakeBox(gp_Pnt(45 * at, 0, 0), a, b, c).Shape()
        across = gp_Ax2(gp_Pnt(45 * at + a / 2, b / 2, -1), gp_Dir(0, 0, 1))
        hole = BRepPrimAPI_MakeCylinder(across, radius, c + 2).Shape()
        writer.Transfer(BRepAlgoAPI_Cut(plate, hole).Shape(), STEPControl_AsIs)
        volumes.append((a * b * c - math.pi * radius**2 * c, 2 * math.pi * radius * c))
    file = tmp_path / "plates.stp"
    writer.Write(str(file))
    made = report(program, file, "--split", "--cell-size", 1)
    for flag, (volume, curved) in zip(made["flags"], volumes, strict=True):
        # corners of f32 on planes; only the hole is not flat
        assert abs(flag["mesh_volume"] - volume) <= 0.1 * curved + 1e-5 * volume
    assert not any(finding["code"] == "surface-open" for finding in made["findings"])


def test_finer_cells_have_finer_triangles(program):
    def deviation(*options):
        return report(program, MACHINE, *options)["inputs"][0]["deviation"]

    assert deviation("--domain", "0,0,0,100,50,50", "--cells", 200) == pytest.approx(0.05)
    assert deviation("--domain", "0,0,0,100,50,50", "--dims", "100,100,25") == pytest.approx(0.05)
    assert deviation("--graded", 3) == pytest.approx(0.3)
    scaled = report(program, f"{MACHINE}:scale=4", "--cell-size", 2)
    assert scaled["inputs"][0]["deviation"] == pytest.approx(0.05)


def test_surfaces_of_iges_are_filled_by_the_winding_number(program):
    made = report(program, TUBE, "--cell-size", 0.25)
    [flag] = made["flags"]
    assert (flag["name"], made["inputs"][0]["format"]) == ("tube", "IGES")
    cells = flag["cells"] * 0.25**3
    assert abs(cells - math.pi * 20 * 20) < 0.02 * cells
    assert "surface-open" in {finding["code"] for finding in made["findings"]}


def test_what_cannot_be_converted_is_said(program, tmp_path):
    def refused(file, code, *parts, **environment):
        done = run(program, "mesh", file, "-o", tmp_path / "x.vti", **environment)
        assert done.returncode not in (0, 101), done.stdout
        assert f"error[{code}]" in done.stderr, done.stderr
        for part in parts:
            assert part in done.stderr
        assert not (tmp_path / "x.vti").exists()

    refused(MACHINE, "cad-program", "/nowhere", "pip install cadquery-ocp-novtk", HEXCAST_PYTHON="/nowhere")
    # a Python without it
    without = tmp_path / "python"
    without.write_text(f'#!/bin/sh\nexec "{sys.executable}" -S "$@"\n')
    without.chmod(0o755)
    refused(MACHINE, "cad-program", "No module named 'OCP'", HEXCAST_PYTHON=str(without))
    cut = tmp_path / "cut.step"
    cut.write_bytes(MACHINE.read_bytes()[:5000])
    refused(cut, "file-syntax", "Open CASCADE cannot read this STEP file")
    wires = STEPControl_Writer()
    wires.Transfer(BRepBuilderAPI_MakeEdge(gp_Pnt(0, 0, 0), gp_Pnt(1, 0, 0)).Shape(), STEPControl_AsIs)
    wires.Write(str(tmp_path / "wires.step"))
    refused(tmp_path / "wires.step", "stl-empty", "has no surface")
    refused(f"{MACHINE}:flag=1", "cad-program", HEXCAST_PYTHON="/nowhere")
    done = run(program, "mesh", MACHINE, "--deviation", 0, "-o", tmp_path / "x.vti")
    assert "deviation" in done.stderr and "error[job-value]" in done.stderr
    with pytest.raises(hexcast.Error, match="this is STEP, a file of CAD") as bytes_refused:
        hexcast.surface(MACHINE.read_bytes())
    assert "name the file itself" in bytes_refused.value.hint


def test_a_name_may_have_any_letters(program, tmp_path):
    file = tmp_path / 'we ird "n\\ame $(x).STEP'
    file.write_bytes(MACHINE.read_bytes())
    # modules of the folder are not those of the program
    (tmp_path / "json.py").write_text("raise SystemExit(9)")
    of = {**os.environ, "HEXCAST_PYTHON": sys.executable}
    done = subprocess.run([program, "info", file.name], capture_output=True, text=True, timeout=300, env=of, cwd=tmp_path)
    assert "by Open CASCADE" in done.stdout, done.stderr


def test_a_cancelled_conversion_ends_the_program(program, tmp_path):
    note = tmp_path / "process"
    slow = tmp_path / "python"
    slow.write_text(f'#!/bin/sh\necho $$ > "{note}"\nexec sleep 600\n')
    slow.chmod(0o755)
    of = {**os.environ, "HEXCAST_PYTHON": str(slow)}
    running = subprocess.Popen([program, "mesh", MACHINE, "-o", tmp_path / "x.vti"], stderr=subprocess.PIPE, env=of)
    while not note.exists() or not note.read_text().strip():
        time.sleep(0.02)
    running.send_signal(signal.SIGINT)
    _, said = running.communicate(timeout=60)
    assert running.returncode != 0, said
    assert not Path(f"/proc/{note.read_text().strip()}").exists()
