"""Pictures and comparisons are those of the native command."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import numpy as np
import pytest

import hexcast
from hexcast.shapes import box, sphere

SIZE = {"cells": 24, "backend": "cpu", "unit": "mm"}


@pytest.fixture(scope="module")
def cow(spot: str) -> hexcast.Mesh:
    return hexcast.mesh({"file": spot, "flag": 3, "name": "cow"}, **SIZE)


@pytest.mark.parametrize(
    ("words", "options"),
    [
        ([], {}),
        (["--axis", "z", "--at", "0.1"], {"axis": "z", "at": 0.1}),
        (["--axis", "x,z", "--at=-0.2,25%"], {"axis": ["x", "z"], "at": [np.float32(-0.25) + 0.05, "25%"]}),
        (["--axis", "y", "--no-lines", "--size", "90"], {"axis": ("y",), "lines": False, "size": 90}),
        (["--flags", "0", "--colours", "0=00ff7f"], {"flags": [0], "colours": {0: "#00ff7f"}}),
    ],
)
def test_slices_are_those_of_the_command(cow, words, options, command, tmp_path):
    mesh, png = tmp_path / "mesh.hxc", tmp_path / "slice.png"
    cow.save(mesh)
    command("slice", mesh, "-o", png, *words)
    drawn = cow.slice(**options)
    assert drawn == png.read_bytes()
    assert drawn._repr_png_() == drawn
    # a mesh that was read draws the same
    assert hexcast.load(mesh).slice(**options) == drawn


@pytest.mark.parametrize(
    ("words", "options"),
    [
        ([], {}),
        (["--direction=30,-20", "--size", "200"], {"direction": (30, -20), "size": 200}),
        (["--window", "2,3,4,9,20,21", "--colours", "3=d98324"], {"window": (2, 3, 4, 9, 20, 21), "colours": {3: "d98324"}}),
    ],
)
def test_views_are_those_of_the_command(cow, words, options, command, tmp_path):
    mesh, png = tmp_path / "mesh.hxc", tmp_path / "view.png"
    cow.save(mesh)
    command("view", mesh, "-o", png, *words)
    assert cow.view(**options) == png.read_bytes()


def test_wrong_pictures_are_refused(cow):
    for draw, says in [
        (lambda: cow.slice("w"), "axis is 'w'"),
        (lambda: cow.slice("z", at=9), "is not within the mesh"),
        (lambda: cow.slice("z", at="120%"), "0% to 100%"),
        (lambda: cow.slice(size=0), "a side has 1 to 32768"),
        (lambda: cow.slice(size=-1), "size is -1"),
        (lambda: cow.slice(flags=[300]), "flag 300"),
        (lambda: cow.slice(colours={3: "red"}), "the colour of flag 3 is 'red'"),
        (lambda: cow.view((1, 2, 3)), "direction is (1, 2, 3)"),
        (lambda: cow.view(flags=[7]), "no cell has one of the flags [7]"),
        (lambda: cow.view(window=(0, 0, 0, 99, 1, 1)), "is not inside the mesh"),
    ]:
        with pytest.raises(hexcast.Error) as caught:
            draw()
        assert caught.value.code == "job-value"
        assert says in caught.value.message


def test_differences_are_those_of_the_command_and_of_the_flags(spot, cow, program, tmp_path):
    other = hexcast.mesh([{"file": spot, "flag": 3}, sphere((0.2, 0.1, 0.3), 0.3)], **SIZE)
    found = cow.diff(other)
    mask = cow.flags != other.flags
    assert found.cells == int(mask.sum()) > 10
    assert found.n_cells == mask.size
    assert found.are_lines_equal
    assert (found.mask.flags == mask).all()
    for pair in found.pairs:
        cells = np.argwhere((cow.flags == pair.one) & (other.flags == pair.other))[:, ::-1]
        assert pair.cells == len(cells)
        assert pair.bounds == (tuple(cells.min(axis=0)), tuple(cells.max(axis=0) + 1))
        assert pair.first in {tuple(cell) for cell in cells}
    names = [tmp_path / "one.hxc", tmp_path / "other.hxc"]
    for mesh, name in zip((cow, other), names):
        mesh.save(name)
    printed = subprocess.run(
        [program, "diff", *names, "--json"], capture_output=True, check=False, timeout=300
    )
    assert printed.returncode == 1
    expected = json.loads(printed.stdout)
    assert [list(pair[:3]) for pair in found.pairs] == [[p["one"], p["other"], p["cells"]] for p in expected["pairs"]]
    same = cow.diff(cow)
    assert (same.cells, same.pairs, int(same.mask.flags.sum())) == (0, [], 0)
    with pytest.raises(hexcast.Error) as caught:
        cow.diff(hexcast.mesh(spot, cells=9, backend="cpu"))
    assert caught.value.code == "job-conflict"
    with pytest.raises(hexcast.Error):
        cow.diff("mesh.hxc")


def test_sizes_are_compared_also_of_a_job_with_cells(spot, tmp_path):
    job = tmp_path / "job.toml"
    text = f"cells = 99\noutput = 'a.vti'\nslice = {{ output = 'a.png' }}\nbackend = 'cpu'\n[[geometries]]\nfile = '{Path(spot).resolve()}'\n"
    job.write_text(text, encoding="utf-8")
    levels = hexcast.converge(job, [8, 16])
    assert [max(level["dims"]) for level in levels] == [8, 16]
    # what a job file asks of the command is left to it
    mesh = hexcast.mesh(job, cells=16)
    assert levels[1]["flags"][0]["cells"] == int((mesh.flags == 1).sum())
    assert sorted(path.name for path in tmp_path.iterdir()) == ["job.toml"]
    with pytest.raises(hexcast.Error) as caught:
        hexcast.converge(box((0, 0, 0), (1, 1, 1)), [8], cells=9, backend="cpu")
    assert caught.value.code == "job-conflict"
