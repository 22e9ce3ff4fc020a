"""Flags at points: shapes, errors, and the example of the documentation."""

from __future__ import annotations

import pickle
import re
import shutil

import numpy as np
import pytest
from places import FIXTURES, ROOT

import hexcast
from hexcast.shapes import box, sphere


def centres(mesh: hexcast.Mesh) -> np.ndarray:
    """Of all cells, of shape (z, y, x, 3)."""
    x, y, z = ((lines[1:] + lines[:-1]) / 2 for lines in mesh.lines)
    return np.stack(np.meshgrid(z, y, x, indexing="ij")[::-1], axis=-1)


@pytest.mark.parametrize("model", ["spot.stl", "featuretype.stl"])
def test_centres_have_the_flags_of_their_cells(model):
    geometries = [{"file": str(FIXTURES / model), "flag": 7}]
    mesh = hexcast.mesh(geometries, cells=24, padding={"cells": 1}, backend="cpu")
    assert np.count_nonzero(mesh.flags == 7) > 100
    np.testing.assert_array_equal(mesh.at(centres(mesh)), mesh.flags)


def test_points_are_where_the_bodies_are_and_not_where_their_cells_are():
    ball = {"source": sphere((0, 0, 0), 1.0), "flag": 3}
    block = {"source": box((0, 0, 0), (2, 2, 2)), "flag": 9}
    # of cells as large as the bodies, a window of one
    mesh = hexcast.mesh([ball, block], cells=4, window=(0, 0, 0, 1, 1, 1), backend="cpu")
    points = np.random.default_rng(5).uniform(-1.2, 2.5, (20_000, 3))
    in_block = ((points > 0) & (points <= 2)).all(axis=1)
    radius = np.linalg.norm(points, axis=1)
    # the ball is made of facets
    is_sure = in_block | (radius < 0.97) | (radius > 1)
    wanted = np.where(in_block, 9, np.where(radius < 0.97, 3, 0))
    assert np.count_nonzero(is_sure) > 19_000
    np.testing.assert_array_equal(mesh.at(points)[is_sure], wanted[is_sure])


def test_any_shape_and_type_of_numbers():
    mesh = hexcast.mesh(box((0, 0, 0), (2, 2, 2)), cells=4, backend="cpu")
    assert mesh.at((1, 1, 1)).shape == ()
    assert mesh.at((1, 1, 1)) == 1
    assert mesh.at(np.zeros((0, 3))).shape == (0,)
    assert mesh.at(np.ones((4, 5, 3), np.float32)).tolist() == [[1] * 5] * 4
    # columns of a wider array, from the last to the first
    wide = np.arange(40, dtype=np.float64).reshape(10, 4)[::-1, 1:]
    assert mesh.at(wide).tolist() == [0] * 10
    assert mesh.at(wide / 20).dtype == np.uint8


@pytest.mark.parametrize(
    ("points", "code", "words"),
    [
        ([1, 2], "job-value", r"shape \(2,\)"),
        (3, "job-value", r"shape \(\)"),
        ([["a", 1, 2]], "job-value", "no array of numbers"),
        ([[0, 0, 0], [0, np.nan, 1]], "job-value", "point 1 is "),
    ],
)
def test_points_that_are_none(points, code, words):
    mesh = hexcast.mesh(box((0, 0, 0), (2, 2, 2)), cells=4, backend="cpu")
    with pytest.raises(hexcast.Error, match=words) as caught:
        mesh.at(points)
    assert caught.value.code == code
    assert isinstance(caught.value, ValueError)


def test_meshes_without_surfaces_say_so(tmp_path):
    mesh = hexcast.mesh(box((0, 0, 0), (2, 2, 2)), cells=4, backend="cpu")
    mesh.save(tmp_path / "a.hxc")
    for other in (hexcast.load(tmp_path / "a.hxc"), pickle.loads(pickle.dumps(mesh))):
        with pytest.raises(hexcast.Error, match="no surfaces") as caught:
            other.at([[1, 1, 1]])
        assert caught.value.code == "job-conflict"


def test_a_file_that_has_changed_is_refused(tmp_path):
    name = shutil.copy(FIXTURES / "spot.stl", tmp_path / "part.stl")
    mesh = hexcast.mesh(name, cells=16, backend="cpu")
    shutil.copy(FIXTURES / "featuretype.stl", name)
    with pytest.raises(hexcast.Error, match="has changed since") as caught:
        mesh.at([[0, 0, 0]])
    assert caught.value.code == "io"


def test_the_example_of_the_documentation(tmp_path, monkeypatch):
    shutil.copy(FIXTURES / "spot.stl", tmp_path / "part.stl")
    monkeypatch.chdir(tmp_path)
    text = (ROOT / "docs" / "points.md").read_text()
    [example] = re.findall(r"```py\n(.*?)```", text, re.DOTALL)
    found: dict[str, np.ndarray] = {}
    exec(compile(example, "points.md", "exec"), found)
    nodes, elements, share = found["nodes"], found["elements"], found["share"]
    a, b, c, d = (nodes[elements[:, k]] for k in range(4))
    volumes = np.abs(np.einsum("ek,ek->e", np.cross(b - a, c - a), d - a)) / 6
    sides = np.ptp(nodes, axis=0)
    # the five fill the box
    assert volumes.sum() == pytest.approx(sides.prod())
    assert found["block"].shape == (5,)
    assert found["at_nodes"].tolist() == [0] * 8
    mesh = found["mesh"]
    [volume] = [flag["volume"] for flag in mesh.report["flags"] if flag["flag"] == 1]
    assert (share * volumes).sum() == pytest.approx(volume, rel=0.1)
