"""Files of cells that differ in size, as VTK and NumPy read them: the cells of boxes that look different along every axis."""

from __future__ import annotations

import json

import numpy as np
import pytest
import pyvista
import trimesh

LINES = {
    "x": [-0.75, -0.5, 0.0, 0.25, 0.5, 1.0, 1.75, 2.0, 3.0],
    "y": [0.0, 0.125, 0.25, 0.75, 1.0, 1.5, 2.5],
    "z": [-1.0, 0.0, 0.5, 0.625, 0.75, 1.0, 1.25, 2.0, 2.5, 4.0],
}
BOXES = {3: ((-0.4, 0.2, -0.9), (2.1, 1.1, 1.3)), 7: ((0.3, 0.9, 0.55), (2.9, 2.4, 3.1))}


@pytest.fixture
def bodies(tmp_path):
    """The boxes as arguments, and a file of the lines."""
    (tmp_path / "lines.json").write_text(json.dumps(LINES))
    words = []
    for flag, bounds in BOXES.items():
        trimesh.creation.box(bounds=bounds).export(tmp_path / f"{flag}.stl")
        words.append(f"{tmp_path / str(flag)}.stl:flag={flag}")
    return [*words, "--lines", tmp_path / "lines.json", "--backend", "cpu"]


def middles(lines):
    return (np.array(lines[1:]) + lines[:-1]) / 2


def expected(x, y, z):
    """Flags of points, by their coordinates."""
    flags = np.zeros((len(z), len(y), len(x)), "u1")
    for flag, (low, high) in BOXES.items():
        inside = [(a < np.array(at)) & (np.array(at) <= b) for a, b, at in zip(low, high, (x, y, z))]
        flags[inside[2][:, None, None] & inside[1][:, None] & inside[0]] = flag
    return flags


@pytest.mark.parametrize("compress", ["none", "6"])
def test_vtk_reads_a_rectilinear_grid(command, bodies, tmp_path, compress):
    command("mesh", *bodies, f"--compress={compress}", "-o", tmp_path / "cells.vtr")
    grid = pyvista.read(tmp_path / "cells.vtr")
    assert isinstance(grid, pyvista.RectilinearGrid)
    for axis in "xyz":
        np.testing.assert_array_equal(getattr(grid, axis), LINES[axis])
    flags = np.asarray(grid.cell_data["flag"])
    assert flags.dtype == np.uint8
    shape = [len(LINES[axis]) - 1 for axis in "zyx"]
    np.testing.assert_array_equal(flags.reshape(shape), expected(*(middles(LINES[axis]) for axis in "xyz")))
    # by places, whatever the order of cells
    point = (1.3, 1.3, 0.9)
    assert flags[grid.find_containing_cell(point)] == 7


def test_numpy_reads_a_staggered_grid(command, bodies, tmp_path):
    a, b, c, d = (0.25, 0.1, 2.0), (1.9, 0.1, 2.0), (1.9, 1.4, 2.0), (0.25, 1.4, 2.0)
    trimesh.Trimesh([a, b, c, d], [[0, 1, 2], [0, 2, 3]]).export(tmp_path / "sheet.stl")
    sheet = f"{tmp_path / 'sheet.stl'}:flag=9,priority=-1"
    command("mesh", *bodies, sheet, "--staggered", tmp_path / "yee.npz", "-o", tmp_path / "cells.npz")
    yee, cells = np.load(tmp_path / "yee.npz"), np.load(tmp_path / "cells.npz")
    np.testing.assert_array_equal(yee["cell"], cells["flag"])
    at = {axis: (np.array(LINES[axis]), middles(LINES[axis])) for axis in "xyz"}
    for axis in "xyz":
        np.testing.assert_array_equal(yee[axis], LINES[axis])
    # faces of the sheet that are not within the boxes, whose priority is higher
    across_z = expected(at["x"][1], at["y"][1], at["z"][0])
    within = (0.25 < at["x"][1]) & (at["x"][1] <= 1.9) & ((0.1 < at["y"][1]) & (at["y"][1] <= 1.4))[:, None]
    line = LINES["z"].index(2.0)
    faces = within & (across_z[line] == 0)
    assert 0 < faces.sum() < within.sum()
    rows, columns = np.nonzero(faces)
    found = {name: yee[f"sheet_{name}"] for name in ("axis", "x", "y", "z", "flag")}
    np.testing.assert_array_equal(found["x"], columns)
    np.testing.assert_array_equal(found["y"], rows)
    assert (found["z"] == line).all() and (found["axis"] == 2).all() and (found["flag"] == 9).all()
    edges = {"Ex": np.zeros((len(LINES["y"]), faces.shape[1]), bool), "Ey": np.zeros((faces.shape[0], len(LINES["x"])), bool)}
    for side in (0, 1):
        edges["Ex"][rows + side, columns] = True
        edges["Ey"][rows, columns + side] = True
    for name in ("Ex", "Ey", "Ez", "Hx", "Hy", "Hz"):
        # E lies in the middle along its axis, H across
        is_middle = [(axis == name[1].lower()) == (name[0] == "E") for axis in "xyz"]
        flags = expected(*(at[axis][int(middle)] for axis, middle in zip("xyz", is_middle)))
        if name in edges:
            flags[line][edges[name] & (flags[line] == 0)] = 9
        np.testing.assert_array_equal(yee[name], flags, name)
