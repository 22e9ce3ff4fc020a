"""gprMax 4 builds the cells that hexcast wrote, and a cavity resonates where theory says."""

from __future__ import annotations

import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
from cavity import RADIUS, mesh_cavity, resonance, theory
from conftest import Model, hexcast, plate, run, save

MATERIALS = ("base.stl:name=base,eps_r=2.5,mu_r=1.5,sigma=0.02,density=1200", "block.stl:name=block,pec=true", "bar.stl:flag=9,name=1 bar,eps_r=4")


def gprmax(folder: Path, *more: str) -> None:
    run(sys.executable, "-m", "gprMax", "run.in", *more, cwd=folder)


def test_the_same_cells(model: Model) -> None:
    arguments = ["mesh", *MATERIALS, *model.options, "-o", "m.in"]
    if model.is_graded:
        assert "cells differ in size" in hexcast(*arguments, cwd=model.folder, ok=False)
        return
    hexcast(*arguments, cwd=model.folder)
    # what gprMax has built it writes by itself
    nx, ny, nz = model.flags.shape
    high = " ".join(repr(n * 5e-4) for n in model.flags.shape)
    (model.folder / "run.in").write_text(
        f"#title: t\n#time_window: 1\n#pml_cells: 0\n#include_file: m.in\n#geometry_objects_write: 0 0 0 {high} built\n"
    )
    gprmax(model.folder, "--geometry-only")
    [built] = [path for path in model.folder.rglob("built*.h5")]
    with h5py.File(built) as file:
        data = file["data"][:]
        keys = [key.decode() for key in file["material_keys"][:]]
    assert data.shape == (nx, ny, nz)
    names = np.array(keys)[data]
    for flag, name in ((1, "base"), (2, "block"), (9, "f_1_bar")):
        assert (np.char.find(names, name) >= 0)[model.of(flag)].all(), keys
        assert not (np.char.find(names, name) >= 0)[~model.of(flag)].any(), keys


def test_the_files(model: Model) -> None:
    if model.is_graded:
        return
    hexcast("mesh", *MATERIALS, *model.options, "-o", "a model.in", "--compress=none", cwd=model.folder)
    with h5py.File(model.folder / "a_model_geo.h5") as file:
        assert file["data"].shape == model.flags.shape and file["data"].dtype == np.int16
        expected = np.select([model.of(1), model.of(2), model.of(9)], [0, 1, 2], -1)
        np.testing.assert_array_equal(file["data"][:], expected)
        np.testing.assert_array_equal(file.attrs["dx_dy_dz"], [5e-4] * 3)
        assert file.attrs["MaterialDatabase"] == "a_model_materials"
    said = hexcast("mesh", "base.stl:eps_r=0.5", *model.options, "-o", "b.in", cwd=model.folder, ok=False)
    assert "eps_r 0.5" in said


def test_a_spherical_cavity(tmp_path: Path) -> None:
    mesh_cavity(tmp_path, "c.in")
    (tmp_path / "run.in").write_text(
        """#title: cavity
#omp_threads: 1
#time_window: 4e-9
#pml_cells: 0
#include_file: c.in
#waveform: gaussiandot 1 13e9 w
#hertzian_dipole: z 0.011 0.011 0.011 w
#rx: 0.013 0.011 0.011
"""
    )
    gprmax(tmp_path)
    with h5py.File(tmp_path / "run.h5") as file:
        voltage = file["rxs/rx1/Ez"][:]
        time = np.arange(len(voltage)) * file.attrs["dt"]
    found = resonance(time, voltage)
    print("gprMax", found, "theory", theory(RADIUS))
    assert found == pytest.approx(theory(RADIUS), rel=0.01)


def test_a_plate_shields_what_is_behind_it(tmp_path: Path) -> None:
    """Metal walls around a box, which a plate of no thickness divides: wholly, or up to a hole."""
    fields = {}
    for name, edge in (("whole", 11), ("hole", 4)):
        folder = tmp_path / name
        folder.mkdir()
        save(folder / "plate.stl", plate((-11, -11, 0), (edge, 11, 0)))
        options = ["--domain", "-11,-11,-11,11,11,11", "--cell-size", "1", "--unit", "mm", "--backend", "cpu"]
        hexcast("mesh", "plate.stl:pec=true", *options, "-o", "p.in", cwd=folder)
        assert "#plate: 0.0 0.0 0.011" in (folder / "p.in").read_text()
        (folder / "run.in").write_text(
            """#title: plate
#omp_threads: 1
#time_window: 4e-10
#pml_cells: 0
#include_file: p.in
#waveform: gaussiandot 1 13e9 w
#hertzian_dipole: x 0.011 0.011 0.005 w
#rx: 0.011 0.011 0.017
"""
        )
        gprmax(folder)
        with h5py.File(folder / "run.h5") as file:
            fields[name] = abs(file["rxs/rx1/Ex"][:]).max()
    print("gprMax, field behind a plate", fields)
    assert fields["whole"] == 0
    assert fields["hole"] > 0
