"""Programs that read a mesh or an image as such find the same cells."""

from __future__ import annotations

import json
import re

import h5py
import meshio
import nrrd
import numpy as np
import pytest
from conftest import Model, hexcast, rod, run, save_solids


@pytest.mark.parametrize("form", ["--ascii", "binary"])
@pytest.mark.parametrize("flags", [(1, 2, 9), (0, 2)])
def test_gmsh(model: Model, form: str, flags: tuple[int, ...]) -> None:
    text = ["--ascii"] if form == "--ascii" else []
    hexcast("convert", "m.hxc", "m.msh", "--export-flags", ",".join(map(str, flags)), *text, cwd=model.folder)
    said = run("gmsh", "-check", "m.msh", cwd=model.folder)
    assert not re.search(r"Warning|Error", said), said
    assert int(re.search(r"(\d+) elements", said)[1]) == model.of(*flags).sum()
    # Gmsh's own volumes of the groups, by its plugin
    plugin = "Plugin(MeshVolume).PhysicalGroup = {}; Plugin(MeshVolume).Run;"
    script = "\n".join(['Merge "m.msh";', "Plugin(MeshVolume).Dimension = 3;", *(plugin.format(flag or 256) for flag in flags), ""])
    (model.folder / "volume.geo").write_text(script)
    said = run("gmsh", "volume.geo", "-", cwd=model.folder)
    volumes = [float(text) for text in re.findall(r"Mesh volume .*: (\S+)", said)]
    assert volumes == pytest.approx([model.volumes[model.of(flag)].sum() for flag in flags], rel=1e-5), said
    read = meshio.read(model.folder / "m.msh")
    found = np.zeros_like(model.flags)
    seen = np.zeros(model.flags.shape, int)
    for block, physical in zip(read.cells, read.cell_data["gmsh:physical"]):
        middles = read.points[block.data].mean(axis=1)
        index = tuple(np.searchsorted(axis, middles[:, i]) - 1 for i, axis in enumerate(model.lines))
        found[index] = physical % 256
        np.add.at(seen, index, 1)
    assert (seen == model.of(*flags)).all()
    assert (found == np.where(model.of(*flags), model.flags, 0)).all()
    names = {0: "background", 1: "base", 2: "block", 9: "f_1_bar"}
    groups = {name: int(tag) % 256 for name, (tag, dimension) in read.field_data.items()}
    assert groups == {names[flag]: flag for flag in flags}


@pytest.mark.parametrize("form", ["--ascii", "binary"])
def test_gmsh_has_the_faces_of_solids(tmp_path, form: str) -> None:
    facets = rod(1.0, 2.0).reshape(-1, 4, 3, 3)
    save_solids(tmp_path / "pipe.stl", {"wall": facets[:, :2].reshape(-1, 3, 3), "inlet": facets[:, 2], "outlet": facets[:, 3]})
    text = ["--ascii"] if form == "--ascii" else []
    hexcast("mesh", "pipe.stl", "--cell-size", 0.25, "--backend", "cpu", "-o", "m.msh", "-o", "m.raw", "--patches", "solid", *text, cwd=tmp_path)
    said = run("gmsh", "-check", "m.msh", cwd=tmp_path)
    assert not re.search(r"Warning|Error", said), said
    read = meshio.read(tmp_path / "m.msh")
    names = {int(tag): name for name, (tag, dimension) in read.field_data.items() if dimension == 2}
    found: dict[str, list] = {}
    for block, physical in zip(read.cells, read.cell_data["gmsh:physical"]):
        for corners, tag in zip(block.data, physical):
            if block.type == "quad":
                found.setdefault(names[int(tag)], []).append(read.points[corners])
    flags = np.fromfile(tmp_path / "m.raw", np.uint8).reshape(8, 8, 8)
    across = int(flags[:, :, 0].sum())
    n_faces = sum(int((np.diff(np.pad(flags, 1).astype(int), axis=axis) != 0).sum()) for axis in range(3))
    assert {name: len(faces) for name, faces in found.items()} == {"inlet": across, "outlet": across, "wall": n_faces - 2 * across}
    assert (np.array(found["inlet"])[:, :, 0] == 0).all() and (np.array(found["outlet"])[:, :, 0] == 2).all()


@pytest.mark.parametrize("compress", ["none", "6"])
def test_nrrd(model: Model, compress: str) -> None:
    spacing = np.diff(model.lines[0])
    if not (spacing == spacing[0]).all():
        said = hexcast("convert", "m.hxc", "m.nrrd", cwd=model.folder, ok=False)
        assert "cells differ in size" in said
        return
    hexcast("convert", "m.hxc", "m.nrrd", f"--compress={compress}", cwd=model.folder)
    flags, header = nrrd.read(str(model.folder / "m.nrrd"))
    assert (flags == model.flags).all()
    np.testing.assert_allclose(header["space origin"], model.centres[0, 0, 0])
    np.testing.assert_allclose(header["space directions"], np.diag([0.5, 0.5, 0.5]))
    assert header["flag 9"] == "1 bar"


def test_arrays_with_x_slowest_and_other_numbers(model: Model) -> None:
    options = ["--axis-order", "xyz", "--map", "1=0,0=1"]
    for name in ("a.npy", "a.npz", "a.raw"):
        hexcast("convert", "m.hxc", name, *options, cwd=model.folder)
    expected = np.choose(np.minimum(model.flags, 2), [1, 0, model.flags])
    assert (np.load(model.folder / "a.npy") == expected).all()
    archive = np.load(model.folder / "a.npz")
    assert (archive["flag"] == expected).all()
    assert all((archive[name] == lines).all() for name, lines in zip("xyz", model.lines))
    raw = np.fromfile(model.folder / "a.raw", np.uint8)
    assert (raw.reshape(expected.shape) == expected).all()
    sidecar = json.loads((model.folder / "a.raw.json").read_text())
    assert sidecar["map"] == {"0": 1, "1": 0}
    assert sidecar["axis_order"].startswith("z fastest")
    assert {flag["flag"]: flag.get("material") for flag in sidecar["flags"]} == {1: None, 2: {"density": 8000, "E": 2e11, "nu": 0.3}, 9: None}
    for wrong in (["m.vti", "--axis-order", "xyz"], ["b.raw", "--map", "1=256"], ["b.raw", "--map", "1=2,1=3"]):
        hexcast("convert", "m.hxc", *wrong, cwd=model.folder, ok=False)


@pytest.mark.parametrize("compress", ["none", "6"])
def test_links_as_hdf5(model: Model, compress: str) -> None:
    """h5py finds the arrays of the archive; of a mesh without links, too."""
    fluids = {"0": 1, "200": 0}
    for fluid, least in fluids.items():
        options = [*model.options, "-q", "--stencil", "D3Q7", "--fluid", fluid, f"--compress={compress}"]
        mesh = ["mesh", "base.stl", "block.stl", "bar.stl", *options]
        hexcast(*mesh, "--links", "l.npz", cwd=model.folder)
        hexcast(*mesh, "--links", "l.h5", cwd=model.folder)
        expected = np.load(model.folder / "l.npz")
        assert len(expected["q"]) >= least
        with h5py.File(model.folder / "l.h5") as file:
            assert sorted(file) == sorted(expected.files)
            for name in expected.files:
                found = file[name]
                assert found.dtype == expected[name].dtype and found.shape == expected[name].shape, name
                assert (found[:] == expected[name]).all(), name
