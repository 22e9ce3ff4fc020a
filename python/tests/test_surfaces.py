"""Surfaces from arrays are those of files."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import pyvista
import trimesh

import hexcast
from hexcast.shapes import box, sphere


def flags(source, **options):
    return hexcast.mesh(source, **{"cells": 40, "backend": "cpu", **options}).flags


@pytest.fixture(scope="module")
def expected(spot):
    return flags(spot)


def test_bytes_and_surfaces_that_were_read(spot, expected):
    np.testing.assert_array_equal(flags(Path(spot)), expected)
    np.testing.assert_array_equal(flags(Path(spot).read_bytes()), expected)
    surface = hexcast.surface(spot)
    assert (surface.name, surface.n_facets) == (spot, 5856)
    for _ in range(2):
        np.testing.assert_array_equal(flags(surface), expected)
    assert repr(surface) == f'<hexcast.Surface "{spot}" of 5856 facets>'


def test_trimesh(spot, expected):
    np.testing.assert_array_equal(flags(trimesh.load_mesh(spot)), expected)


def test_pyvista(spot, expected):
    surface = pyvista.read(spot)
    np.testing.assert_array_equal(flags(surface), expected)
    # what is no triangle becomes some
    cube = pyvista.Cube(x_length=2, y_length=2, z_length=2)
    np.testing.assert_array_equal(flags(cube), flags(box((-1, -1, -1), (1, 1, 1))))


def test_the_attributes_of_open3d_and_numpy_stl(spot, expected):
    mesh = trimesh.load_mesh(spot)
    legacy = SimpleNamespace(vertices=np.asarray(mesh.vertices), triangles=np.asarray(mesh.faces, np.int32))
    np.testing.assert_array_equal(flags(legacy), expected)
    np.testing.assert_array_equal(flags(SimpleNamespace(vectors=np.asarray(mesh.triangles))), expected)
    np.testing.assert_array_equal(flags(np.asarray(mesh.triangles)), expected)


def test_arrays_of_any_type_and_layout(spot, expected):
    mesh = trimesh.load_mesh(spot)
    vertices, faces = np.asarray(mesh.vertices), np.asarray(mesh.faces)
    shapes = [
        (np.asfortranarray(vertices), np.asfortranarray(faces)),
        (vertices.astype(np.float32), faces.astype(np.uint16)),
        (vertices.tolist(), faces.tolist()),
        (np.repeat(vertices, 2, axis=0)[::2], faces[:, [1, 2, 0]]),
    ]
    for shape in shapes:
        np.testing.assert_array_equal(flags(shape), expected)


def test_several_geometries_with_options():
    case, core = box((-2, -2, -2), (2, 2, 2)), sphere((0, 0, 0), 1.0)
    named = [{"source": case, "name": "case", "flag": 3, "priority": 1}, {"source": core, "name": "core", "flag": 5}]
    with pytest.warns(hexcast.MeshWarning, match='"core" .* got no cell'):
        mesh = hexcast.mesh(named, cells=40, backend="cpu")
    assert mesh.names == {3: "case", 5: "core"}
    assert not (mesh.flags == 5).any()
    moved = {"source": core, "scale": 0.5, "translate": [1, 0, 0], "rotate": (0, 0, 90), "invert": True}
    mesh = hexcast.mesh([case, moved], cells=40, backend="cpu")
    assert set(np.unique(mesh.flags)) == {1, 2}
    assert mesh.report["inputs"][1]["format"] == "facets"
    assert [facts["file"] for facts in mesh.report["inputs"]] == ["surface 1", "surface 2"]


def test_a_sphere_has_its_volume():
    vertices, faces = sphere((1, 2, 3), 0.75, steps=64)
    mesh = hexcast.mesh((vertices, faces), cells=100, backend="cpu")
    report = mesh.report["geometries"][0]
    assert report["mesh_volume"] > 0
    volume = 4 / 3 * np.pi * 0.75**3
    assert abs(report["mesh_volume"] - volume) < 0.005 * volume
    assert abs(mesh.flags.sum() * np.prod(mesh.spacing) - volume) < 0.01 * volume
    assert not mesh.report["geometries"][0]["bad_edges"].get("open")


WRONG = [
    (([[0, 0, 0]], [[0, 0, 1]]), "job-value", r"face 0 has vertices \[0, 0, 1\] of 1"),
    (([[0, 0, 0]], [[0, 0, -1]]), "job-value", r"face 0 has vertices \[0, 0, -1\] of 1"),
    (([[0, 0]], [[0, 0, 0]]), "job-value", r"vertices are numbers of shape \(n, 3\)"),
    (([["a", "b", "c"]], [[0, 0, 0]]), "job-value", "vertices are numbers"),
    (([[0, 0, 0]], [[0.0, 0.0, 0.0]]), "job-value", "faces are whole numbers"),
    (([[0, 0, 0]], np.zeros((0, 3), int)), "stl-empty", "there are no facets"),
    (([[0, 0, np.nan], [0, 1, 0], [1, 0, 0]], [[0, 1, 2]]), "stl-not-finite", "number 2 of facet 0 is NaN"),
    (([[0, 0, 1e300], [0, 1, 0], [1, 0, 0]], [[0, 1, 2]]), "stl-not-finite", "number 2 of facet 0 is inf"),
    (np.zeros((4, 3)), "job-value", r"shape \(4, 3\)"),
    (object(), "job-value", "builtins.object has no vertices and faces"),
    (b"no STL", "stl-not-stl", "surface"),
]


@pytest.mark.parametrize(("source", "code", "message"), WRONG)
def test_what_is_no_surface_is_an_error(source, code, message):
    with pytest.raises(hexcast.Error, match=message) as caught:
        hexcast.surface(source)
    assert caught.value.code == code
    assert caught.value.hint
