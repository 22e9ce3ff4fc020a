"""Links, fractions, staggered points and doubtful cells: arrays whose numbers are known, and the files of the command."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest

import hexcast
from hexcast.shapes import box, sphere

#: A box of 4 x 3 x 2.5 cells in one of 8 x 7 x 6.
BODY = box((2, 2, 2), (6, 5, 4.5))
SIZE = {"domain": (0, 0, 0, 8, 7, 6), "cell_size": 1, "backend": "cpu"}
ASKED = {
    "links": {"stencil": "D3Q7"},
    "fractions": {"faces": True, "surfaces": True},
    "staggered": True,
    "conformal": {"metal": [1], "stable": 0},
    "tensors": {"anisotropic": [{"flag": 1, "eps_r": [4, 4, 4, 0, 0, 0]}]},
}


@pytest.fixture(scope="module")
def mesh():
    return hexcast.mesh(BODY, **SIZE, **ASKED)


def test_links_are_those_that_arithmetic_finds(mesh):
    """A centre at the top itself lies inside: 3 cells along z, and links from above go the whole way."""
    links = mesh.links
    flags = np.pad(mesh.flags, 1)
    assert mesh.flags.sum() == 4 * 3 * 3
    expected = set()
    for z, y, x in np.argwhere(mesh.flags == 0):
        for number, (dx, dy, dz) in enumerate(links.directions):
            if flags[z + 1 + dz, y + 1 + dy, x + 1 + dx]:
                expected.add((x, y, z, number, 1.0 if dz == -1 else 0.5))
    found = zip(links.x, links.y, links.z, links.direction, links.q)
    assert {tuple(map(float, link)) for link in found} == {tuple(map(float, link)) for link in expected}
    assert len(links) == len(expected) == 2 * (4 * 3 + 3 * 3 + 4 * 3)
    assert links.records.dtype.itemsize == 24
    assert (links.records["q"] == links.q).all()
    with pytest.raises(ValueError, match="read-only"):
        links.q[0] = 1


def test_fractions_are_those_that_arithmetic_finds(mesh):
    fractions = mesh.fractions
    solid = fractions.solid()
    expected = np.zeros((6, 7, 8), np.float32)
    expected[2:4, 2:5, 2:6] = 1
    expected[4, 2:5, 2:6] = 0.5
    assert (solid == expected).all()
    half = (fractions.fraction == 0.5) & (fractions.flag == 1)
    assert half.sum() == 12
    assert (fractions.faces[half][:, 4:] == (1, 0)).all()
    assert np.isclose(fractions.surface_area.sum(), 2 * (4 * 3 + 3 * 2.5 + 4 * 2.5))
    assert fractions.surface_point.shape == fractions.surface_normal.shape == (len(fractions.surface_cell), 3)
    assert hexcast.mesh(BODY, **SIZE, fractions={}).fractions.faces is None


def test_staggered_points_are_those_that_arithmetic_finds(mesh):
    """An edge along x has its point at a centre along x and on lines along y and z; those on a face above the body are inside."""
    z, y, x = np.mgrid[0:7, 0:8, 0:8]
    inside = (x + 0.5 > 2) & (x + 0.5 <= 6) & (y > 2) & (y <= 5) & (z > 2) & (z <= 4.5)
    assert (mesh.staggered.Ex == inside).all()
    assert mesh.staggered.Hz.shape == (7, 7, 8)
    assert (mesh.staggered.cell == mesh.flags).all()
    assert len(mesh.staggered.sheet_axis) == 0


def test_edges_and_faces_outside_metal_are_those_that_arithmetic_finds(mesh):
    """The body ends in the middle of a cell along z, and on lines along x and y, in which edges and faces are metal."""
    conformal = mesh.conformal
    z, y, x = np.mgrid[0:6, 0:8, 0:9]
    holds = (x >= 2) & (x <= 6) & (y >= 2) & (y <= 5)
    along_z = np.where(holds & (z >= 2), np.where(z < 4, 0, np.where(z == 4, 0.5, 1)), 1)
    assert (conformal.Lz == along_z).all()
    z, y, x = np.mgrid[0:6, 0:7, 0:9]
    holds = (x >= 2) & (x <= 6) & (y >= 2) & (y < 5)
    assert (conformal.Ax == np.where(holds & (z >= 2), np.where(z < 4, 0, np.where(z == 4, 0.5, 1)), 1)).all()
    assert conformal.Ly.shape == (7, 7, 9)
    assert conformal.dt_factor.shape == ()
    assert mesh.report["conformal"]["dt_factor"] == conformal.dt_factor
    with pytest.raises(hexcast.Error, match="no flag is metal") as caught:
        hexcast.mesh(BODY, **SIZE, conformal={})
    assert caught.value.code == "no-metal"


def test_distances_are_those_of_a_ball():
    ball = {"source": sphere((0, 0, 0), 1, 60), "flag": 2}
    mesh = hexcast.mesh(ball, cells=24, padding={"cells": 3}, backend="cpu", distance={"band": "all"})
    numbers = mesh.distance.distance
    assert numbers.shape == mesh.flags.shape and numbers.dtype == np.float64
    assert np.array_equal(numbers < 0, mesh.flags == 2)
    x, y, z = [0.5 * (lines[1:] + lines[:-1]) for lines in mesh.lines]
    radius = np.sqrt(x**2 + y[:, None] ** 2 + z[:, None, None] ** 2)
    assert np.abs(numbers - (radius - 1)).max() < 0.005
    assert np.isinf(mesh.distance.width) and mesh.report["distance"]["width"] is None
    assert np.array_equal(mesh.to_xarray()["distance"].values, numbers)
    nodes = hexcast.mesh(ball, cells=24, backend="cpu", distance={"at": "nodes", "band": 2}).distance
    assert nodes.distance.shape == tuple(n + 1 for n in (24, 24, 24))
    assert nodes.distance.max() == nodes.width and nodes.distance.min() == -nodes.width


def test_tensors_are_those_that_arithmetic_finds():
    """The body ends in the middle of a cell along z, so that the cell around a point of Ez is half full."""
    glass = {"anisotropic": [{"flag": 1, "eps_r": [4, 4, 4, 0, 0, 0]}]}
    tensors = hexcast.mesh(BODY, **SIZE, tensors=glass).tensors
    assert tensors.Ex.shape == (7, 8, 8, 6)
    assert tensors.Ez.shape == (6, 8, 9, 6)
    inside, half, outside = tensors.Ez[3, 3, 4], tensors.Ez[4, 3, 4], tensors.Ez[5, 3, 4]
    assert inside.tolist() == [4, 4, 4, 0, 0, 0]
    assert np.allclose(half, [2.5, 2.5, 1.6, 0, 0, 0], rtol=0, atol=1e-12)
    assert outside.tolist() == [1, 1, 1, 0, 0, 0]
    with pytest.raises(hexcast.Error, match="no permittivity") as caught:
        hexcast.mesh(BODY, **SIZE, tensors={})
    assert caught.value.code == "no-permittivity"


def test_doubtful_cells_are_a_mesh():
    vertices, faces = sphere((0, 0, 0), 1)
    with pytest.warns(hexcast.MeshWarning, match="not closed"):
        mesh = hexcast.mesh((vertices, faces[: len(faces) // 3]), cells=20, backend="cpu", doubt=True)
    assert mesh.doubt.flags.sum() == mesh.report["doubtful"]["cells"] > 0
    assert mesh.doubt.lines[0].tolist() == mesh.lines[0].tolist()


@pytest.mark.parametrize("kind", ["links", "fractions", "staggered", "conformal", "tensors", "distance", "doubt"])
def test_what_was_not_asked_for_is_an_error(kind):
    with pytest.raises(hexcast.Error, match=f"{kind}") as caught:
        getattr(hexcast.mesh(BODY, **SIZE), kind)
    assert caught.value.code == "job-conflict"
    assert isinstance(caught.value, ValueError)


NAMES = ["links.npz", "links.links", "fractions.npz", *(f"fractions.{of}" for of in ("vti", "vtr", "npy", "zarr", "zarr.zip")), "staggered.npz", "conformal.npz", "tensors.npz", "distance.npz"]


@pytest.mark.parametrize("size", [{}, {"window": (3, 2, 4, 20, 25, 28)}], ids=["whole", "window"])
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("is_pickled", [False, True], ids=["made", "pickled"])
def test_files_are_those_of_the_command(spot, tmp_path, command, name, size, is_pickled):
    kind = name.split(".")[0]
    of_fractions = {"faces": True, "surfaces": True}
    words = ["--fraction-faces", "--fraction-surfaces"] if kind == "fractions" else []
    if kind == "fractions" and size:
        of_fractions |= {"method": "exact", "edges": True, "centroids": True}
        words += ["--fraction-method", "exact", "--fraction-edges", "--fraction-centroids"]
    words += {"conformal": ["--metal", "1"], "distance": ["--distance-at", "nodes"]}.get(kind, [])
    asked = {"links": {}, "fractions": of_fractions, "staggered": True, "conformal": {"metal": [1]}, "tensors": {}, "distance": {"at": "nodes"}}[kind]
    body = {"file": spot, "material": {"eps_r": 4.5}} if kind == "tensors" else spot
    mesh = hexcast.mesh(body, cells=32, padding={"cells": 2}, backend="cpu", **size, **{kind: asked})
    if is_pickled:
        mesh = pickle.loads(pickle.dumps(mesh))
    ours, theirs = tmp_path / f"ours.{name.split('.', 1)[1]}", tmp_path / f"theirs.{name.split('.', 1)[1]}"
    getattr(mesh, kind).save(ours)
    words += ["--window", ",".join(map(str, size["window"]))] if size else []
    body = f"{spot}:eps_r=4.5" if kind == "tensors" else spot
    command("mesh", body, "--cells", 32, "--padding-cells", 2, "--backend", "cpu", f"--{kind}", theirs, *words)
    assert bytes_of(ours) == bytes_of(theirs)


def bytes_of(path):
    """The bytes of a file, or of all files in a folder by their names."""
    if path.is_file():
        return path.read_bytes()
    return {str(file.relative_to(path)): file.read_bytes() for file in path.rglob("*") if file.is_file()}


def test_the_mask_of_doubtful_cells_is_that_of_the_command(tmp_path, command):
    vertices, faces = sphere((0, 0, 0), 1)
    part = tmp_path / "cap.off"
    rows = [f"{len(vertices)} {len(faces) // 3} 0", *(f"{x!r} {y!r} {z!r}" for x, y, z in vertices.tolist())]
    part.write_text("OFF\n" + "\n".join([*rows, *(f"3 {a} {b} {c}" for a, b, c in faces[: len(faces) // 3])]) + "\n")
    with pytest.warns(hexcast.MeshWarning, match="not closed"):
        mesh = hexcast.mesh(str(part), cells=40, backend="cpu", doubt=True)
    mesh.doubt.save(tmp_path / "ours.vti")
    command("mesh", part, "--cells", 40, "--backend", "cpu", "--doubt", tmp_path / "theirs.vti")
    assert (tmp_path / "ours.vti").read_bytes() == (tmp_path / "theirs.vti").read_bytes()


def test_xarray_has_what_was_measured(mesh):
    data = mesh.to_xarray()
    assert data.sizes["link"] == len(mesh.links)
    assert data.sizes["cut"] == len(mesh.fractions)
    near = data.isel(x=data.link_x, y=data.link_y, z=data.link_z)
    assert (near.flag == 0).all()
    assert data.Ex.dims == ("z_line", "y_line", "x")
    assert data.Hz.dims == ("z_line", "y", "x")
    assert (data.Ex.sel(z_line=4, y_line=5, x=2.5) == 1).all()
    assert data.Lz.dims == ("z", "y_line", "x_line")
    assert data.Ax.dims == ("z", "y", "x_line")
    assert data.eps_Ez.dims == ("z", "y_line", "x_line", "tensor")
    assert data.cut_faces.dims == ("cut", "face")
    assert data.surface_normal.dims == ("surface", "axis")
    assert "doubtful" not in data


def test_exact_fractions_have_edges_and_centroids(spot):
    asked = {"method": "exact", "faces": True, "edges": True, "centroids": True}
    mesh = hexcast.mesh(spot, cells=24, backend="cpu", fractions=asked)
    cut, data = mesh.fractions, mesh.to_xarray()
    assert cut.edges.shape == (len(cut), 12)
    assert cut.face_centroid.shape == (len(cut), 6, 2)
    assert data.cut_edges.dims == ("cut", "edge")
    assert data.cut_centroid.dims == ("cut", "axis")
    assert data.cut_face_centroid.dims == ("cut", "face", "across")
    of_cells = np.add.reduceat(cut.edges.astype(float), np.unique(cut.cell, return_index=True)[1])
    assert np.allclose(of_cells, 1, atol=1e-6)
    with pytest.raises(hexcast.Error, match="which rays do not measure") as caught:
        hexcast.mesh(spot, cells=24, backend="cpu", fractions={"rays": 4, "edges": True})
    assert caught.value.code == "job-conflict"


@pytest.mark.parametrize("again", [copy.copy, copy.deepcopy, lambda mesh: pickle.loads(pickle.dumps(mesh))], ids=["copy", "deepcopy", "pickle"])
def test_a_mesh_survives_copies(mesh, again, tmp_path):
    other = again(mesh)
    assert (other.flags == mesh.flags).all()
    assert other.report == mesh.report
    assert other.names == mesh.names
    for kind in ("links", "fractions", "staggered", "conformal", "tensors"):
        of_one, of_other = getattr(mesh, kind)._arrays(), getattr(other, kind)._arrays()
        assert list(of_one) == list(of_other)
        assert all((of_one[name] == of_other[name]).all() for name in of_one)
    for name in ("a.vti", "a.hxc", "a.npz"):
        mesh.save(tmp_path / name)
        other.save(tmp_path / f"other {name}")
        assert (tmp_path / name).read_bytes() == (tmp_path / f"other {name}").read_bytes()


def test_graded_lines_and_parts_survive_pickle(spot):
    job = {"graded": {"max_size": 0.1, "min_size": 0.02}, "part": "2/2", "zarr": {"chunks": (4, 4, 4), "shards": (4, 4, 4)}, "backend": "cpu"}
    mesh = hexcast.mesh(spot, **job)
    other = pickle.loads(pickle.dumps(mesh))
    assert [line.tolist() for line in other.lines] == [line.tolist() for line in mesh.lines]
    assert other._raw.zarr_part(6) == mesh._raw.zarr_part(6)


def test_dask_workers_hand_meshes_back(spot):
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster, distributed.Client(cluster) as client:
        futures = [client.submit(hexcast.mesh, spot, cells=n, backend="cpu", links={}) for n in (16, 24)]
        for n, future in zip((16, 24), futures):
            made, here = future.result(), hexcast.mesh(spot, cells=n, backend="cpu", links={})
            assert (made.flags == here.flags).all()
            assert (made.links.q == here.links.q).all()
