"""What users of notebooks and other libraries get: completion, pictures, arrays, scenes, buckets."""

from __future__ import annotations

import inspect
import re

import numpy as np
import pytest

import hexcast
from hexcast.shapes import box, sphere

BODY = box((0, 0, 0), (4, 3, 2))
SIZE = {"domain": (0, 0, 0, 8, 7, 6), "cell_size": 1, "backend": "cpu"}


def test_options_complete():
    jedi = pytest.importorskip("jedi")
    for call in ("hexcast.mesh(cel", "hexcast.estimate('a.stl', cel", "hexcast.dask.mesh('a.stl', cel"):
        names = {of.name for of in jedi.Interpreter(call, [{"hexcast": __import__("hexcast.dask")}]).complete()}
        assert {"cells=", "cell_size="} <= names, call
    wanted = {"what", "progress", "threads", "spill", "doubt", *hexcast.JobOptions.__annotations__}
    assert wanted <= set(inspect.signature(hexcast.mesh).parameters)
    assert "window" not in inspect.signature(__import__("hexcast.dask").dask.mesh).parameters


def test_a_mesh_is_an_array():
    mesh = hexcast.mesh(BODY, **SIZE)
    assert np.asarray(mesh).dtype == np.uint8
    assert np.sum(mesh) == 24
    assert np.array(mesh, dtype=float).sum() == 24
    assert np.array(mesh).flags.writeable
    with pytest.raises(ValueError, match="copy"):
        mesh.__array__(float, copy=False)


def test_notebooks_show_a_table_and_a_picture():
    mesh = hexcast.mesh({"source": BODY, "name": "<b>body</b>"}, **SIZE, unit="mm")
    html = mesh._repr_html_()
    assert "&lt;b&gt;body&lt;/b&gt;" in html
    assert "<td>24</td>" in html
    assert "1 x 1 x 1 mm" in html
    assert re.search(r'src="data:image/png;base64,iVBOR', html)


def test_a_scene_of_trimesh_is_geometries():
    trimesh = pytest.importorskip("trimesh")
    scene = trimesh.Scene()
    scene.add_geometry(trimesh.creation.box((2, 2, 2)), node_name="low", transform=trimesh.transformations.translation_matrix((1, 1, 1)))
    scene.add_geometry(trimesh.creation.box((2, 2, 2)), node_name="high", transform=trimesh.transformations.translation_matrix((5, 4, 4)))
    mesh = hexcast.mesh(scene, **SIZE)
    assert mesh.names == {1: "low", 2: "high"}
    expected = np.zeros((6, 7, 8), np.uint8)
    expected[0:2, 0:2, 0:2], expected[3:5, 3:5, 4:6] = 1, 2
    assert (mesh.flags == expected).all()
    same = hexcast.mesh([{"source": scene, "flag": 9}, BODY], **SIZE)
    assert set(np.unique(same.flags)) == {0, 3, 9}
    with pytest.raises(hexcast.Error, match="hexcast.mesh takes it"):
        hexcast.surface(scene)


def test_blocks_of_pyvista_are_geometries():
    pyvista = pytest.importorskip("pyvista")
    inner = pyvista.MultiBlock({"grid": pyvista.ImageData(dimensions=(3, 3, 3), origin=(4, 4, 3))})
    blocks = pyvista.MultiBlock({"cube": pyvista.Cube(bounds=(0, 2, 0, 2, 0, 2)), "inner": inner, "none": None})
    mesh = hexcast.mesh(blocks, **SIZE)
    assert mesh.names == {1: "cube", 2: "inner/grid"}
    assert mesh.flags[0:2, 0:2, 0:2].all() and mesh.flags[3:5, 4:6, 4:6].all() and (mesh.flags != 0).sum() == 16


@pytest.mark.parametrize("pair", [tuple, list, lambda of: tuple(array.tolist() for array in of), lambda of: {"source": of}])
def test_vertices_and_faces_are_a_surface(pair):
    mesh = hexcast.mesh(pair(BODY), **SIZE)
    assert (mesh.flags != 0).sum() == 24
    assert (hexcast.mesh([BODY, box((5, 5, 5), (7, 6, 6))], **SIZE).flags == 2).sum() == 2


def test_threads_spill_and_map(tmp_path, spot, command):
    whole = hexcast.mesh(spot, cells=64, backend="cpu")
    assert (hexcast.mesh(spot, cells=64, backend="cpu", threads=1).flags == whole.flags).all()
    with pytest.raises(ValueError, match="threads is 0"):
        hexcast.mesh(spot, threads=0)
    small = {"cells": 900, "backend": "cpu", "max_memory": "4MB"}
    with pytest.raises(MemoryError):
        hexcast.mesh(spot, **small)
    spilled = hexcast.mesh(spot, **small, spill=tmp_path)
    assert spilled.report["peak_bytes"]["spilled"] > 0
    assert list(tmp_path.iterdir()) == []
    first, end = (200, 400, 400), (300, 440, 420)
    assert (spilled.box(first, end) == hexcast.mesh(spot, cells=900, backend="cpu").box(first, end)).all()

    whole.save(tmp_path / "ours.npy", map={0: 7, 1: 9})
    assert (np.load(tmp_path / "ours.npy") == np.where(whole.flags == 0, 7, 9)).all()
    command("mesh", spot, "--cells", 64, "--backend", "cpu", "-o", tmp_path / "theirs.npy", "--map", "0=7,1=9")
    assert (tmp_path / "ours.npy").read_bytes() == (tmp_path / "theirs.npy").read_bytes()
    with pytest.raises(ValueError, match="0 to 255"):
        whole.save(tmp_path / "a.npy", map={1: 256})


def test_files_go_to_buckets(tmp_path):
    """A file system in memory stands for the bucket."""
    fsspec = pytest.importorskip("fsspec")
    from fsspec.implementations.memory import MemoryFileSystem

    class Bucket(MemoryFileSystem):
        protocol, store, pseudo_dirs = "s3", {}, [""]

        @classmethod
        def _strip_protocol(cls, path):
            return super()._strip_protocol(path.removeprefix("s3://"))

    fsspec.register_implementation("s3", Bucket, clobber=True)
    mesh = hexcast.mesh(BODY, **SIZE, links={})
    bucket = fsspec.filesystem("s3")
    for name in ("a.vti", "a.raw"):
        mesh.save(tmp_path / name)
        mesh.save(f"s3://bucket/{name}")
        assert bucket.cat(f"/bucket/{name}") == (tmp_path / name).read_bytes()
    assert bucket.cat("/bucket/a.raw.json") == (tmp_path / "a.raw.json").read_bytes()
    mesh.links.save(tmp_path / "a.npz")
    mesh.links.save("s3://bucket/links.npz")
    assert bucket.cat("/bucket/links.npz") == (tmp_path / "a.npz").read_bytes()
    mesh.save(tmp_path / "a.zarr")
    for _ in range(2):
        mesh.save("s3://bucket/a.zarr")
    files = {str(file.relative_to(tmp_path / "a.zarr")): file.read_bytes() for file in (tmp_path / "a.zarr").rglob("*") if file.is_file()}
    there = bucket.find("/bucket/a.zarr")
    assert {name.split("a.zarr/")[1]: bucket.cat(name) for name in there} == files
    bucket.pipe_file("/bucket/other.zarr/mine", b"mine")
    with pytest.raises(OSError, match="not a Zarr store"):
        mesh.save("s3://bucket/other.zarr")
    with pytest.raises(OSError, match="fsspec"):
        mesh.save("nowhere://bucket/a.vti")
