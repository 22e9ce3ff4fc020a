"""OpenFOAM reads the cells that hexcast wrote, and a flow through a tube is that of Poiseuille."""

from __future__ import annotations

import re

import numpy as np
import pytest
from conftest import Model, cuboid, hexcast, rod, run, save, save_solids, sphere

import foam


@pytest.mark.parametrize("form", ["--ascii", "binary"])
@pytest.mark.parametrize("flags", [(1, 2, 9), (0,), (2, 0)])
def test_the_same_cells(model: Model, form: str, flags: tuple[int, ...]) -> None:
    case = model.folder / "case"
    foam.system(case)
    text = ["--ascii"] if form == "--ascii" else []
    chosen = ["--export-flags", ",".join(map(str, flags)), *text]
    hexcast("convert", "m.hxc", "case/case.foam", *chosen, cwd=model.folder)
    assert (case / "case.foam").read_bytes() == b""
    said = run("checkMesh", "-allTopology", "-allGeometry", "-case", case, cwd=model.folder)
    assert "\nMesh OK." in said, said
    kept = model.of(*flags)
    assert int(re.search(r"\n\s+cells:\s+(\d+)", said)[1]) == kept.sum()
    zones = {name: (int(n), float(volume)) for name, n, volume in re.findall(r"\n\s+(\w+)\s+(\d+)\s+\d+\s+(\S+)\s+\(", said.split("CellZone")[1])}
    names = {0: "background", 1: "base", 2: "block", 9: "f_1_bar"}
    assert set(zones) == {names[flag] for flag in flags}
    for flag in flags:
        n, volume = zones[names[flag]]
        assert n == model.of(flag).sum()
        assert volume == pytest.approx(model.volumes[model.of(flag)].sum() * 1e-9, rel=1e-9)
    # each cell where it belongs: in OpenFOAM's own centres and volumes
    run("postProcess", "-func", "writeCellCentres", "-constant", "-case", case, cwd=model.folder)
    run("postProcess", "-func", "writeCellVolumes", "-constant", "-case", case, cwd=model.folder)
    order = np.argwhere(kept.transpose(2, 1, 0))[:, ::-1]
    index = tuple(order.T)
    found = {folder: next(path for path in case.rglob(folder)) for folder in ("C", "V")}
    np.testing.assert_allclose(foam.values(found["C"]), model.centres[index] * 1e-3, rtol=0, atol=1e-12)
    np.testing.assert_allclose(foam.values(found["V"])[:, 0], model.volumes[index] * 1e-9, rtol=1e-9)
    # patches: a face for every neighbour that is not kept
    patches = dict(re.findall(r"(\w+)\s*\{\s*type \w+;\s*nFaces (\d+);", (case / "constant/polyMesh/boundary").read_text()))
    padded = np.pad(np.where(kept, -1, model.flags.astype(int)), 1, constant_values=-2)
    inside = padded[1:-1, 1:-1, 1:-1] == -1
    expected: dict[str, int] = {}
    for axis, name in enumerate("xyz"):
        for shift, end in ((1, "Min"), (-1, "Max")):
            beside = np.roll(padded, shift, axis)[1:-1, 1:-1, 1:-1][inside]
            for flag, n in zip(*np.unique(beside[beside != -1], return_counts=True)):
                patch = name + end if flag == -2 else names[flag]
                expected[patch] = expected.get(patch, 0) + int(n)
    assert {name: int(n) for name, n in patches.items()} == expected


def test_a_mesh_of_another_run_is_not_mixed_in(model: Model) -> None:
    folder = model.folder / "case/constant/polyMesh"
    for _ in range(2):
        folder.mkdir(parents=True, exist_ok=True)
        hexcast("convert", "m.hxc", "case/constant/polyMesh", cwd=model.folder)
    (folder / "faceZones").write_text("")
    before = (folder / "faces").read_bytes()
    said = hexcast("convert", "m.hxc", "case/constant/polyMesh", "--export-flags", "0", cwd=model.folder, ok=False)
    assert "faceZones is in the folder of the new mesh" in said
    assert (folder / "faces").read_bytes() == before


def test_without_a_unit_there_is_no_mesh(tmp_path) -> None:
    save(tmp_path / "rod.stl", rod(1, 4))
    (tmp_path / "case").mkdir()
    said = hexcast("mesh", "rod.stl", "--cells", "8", "-o", "case/a.foam", cwd=tmp_path, ok=False)
    assert "OpenFOAM needs metres" in said and "--unit mm" in said
    assert list((tmp_path / "case").iterdir()) == []


def test_flow_through_a_tube(tmp_path) -> None:
    """Q = pi r^4 dp / (8 mu L); cells of a sixteenth of the radius have an area within a percent."""
    size, radius, length = 1 / 16, 1.0, 20.0
    save(tmp_path / "rod.stl", rod(radius, length))
    case = tmp_path / "case"
    foam.system(case)
    domain = ["--domain", f"0,{-radius},{-radius},{length},{radius},{radius}", "--dims", "40,32,32"]
    hexcast("mesh", "rod.stl:name=fluid", *domain, "--unit", "mm", "--backend", "cpu", "-o", "case/tube.foam", "-o", "tube.raw", cwd=tmp_path)
    speed = '"x.*" {type zeroGradient;} "y.*|z.*|background" {type noSlip;}'
    pressure = 'xMin {type fixedValue; value uniform 1.6e-3;} xMax {type fixedValue; value uniform 0;} "y.*|z.*|background" {type zeroGradient;}'
    last = foam.flow(case, speed, pressure)
    flags = np.fromfile(tmp_path / "tube.raw", np.uint8).reshape(32, 32, 40).transpose(2, 1, 0)
    order = np.argwhere((flags == 1).transpose(2, 1, 0))[:, ::-1]
    speed = foam.values(last / "U")[:, 0]
    flow = [speed[order[:, 0] == x].sum() * (size * 1e-3) ** 2 for x in (5, 20, 35)]
    poiseuille = np.pi * 1e-12 * 1.6e-3 / (8 * 1e-6 * length * 1e-3)
    print("flow", flow, "Poiseuille", poiseuille)
    np.testing.assert_allclose(flow, poiseuille, rtol=0.015)


def test_a_pipe_has_the_patches_of_its_solids(tmp_path) -> None:
    size, radius, length = 1 / 16, 1.0, 4.0
    facets = rod(radius, length).reshape(-1, 4, 3, 3)
    solids = {"wall": facets[:, :2].reshape(-1, 3, 3), "inlet": facets[:, 2], "outlet": facets[:, 3]}
    save_solids(tmp_path / "pipe.stl", solids)
    case = tmp_path / "case"
    foam.system(case)
    # the box of the pipe, so that its ends lie at the sides
    arguments = ["pipe.stl:name=water", "--dims", "20,32,32", "--unit", "mm", "--backend", "cpu", "-o", "case/pipe.foam", "-o", "pipe.raw", "-o", "p.hxc"]
    hexcast("mesh", *arguments, "--patches", "solid", "--open-patches", "inlet,outlet", cwd=tmp_path)
    boundary = (case / "constant/polyMesh/boundary").read_text()
    patches = {name: (kind, int(n)) for name, kind, n in re.findall(r"(\w+)\s*\{\s*type (\w+);\s*nFaces (\d+);", boundary)}
    flags = np.fromfile(tmp_path / "pipe.raw", np.uint8).reshape(32, 32, 20)
    across = int(flags[:, :, 0].sum())
    padded = np.pad(flags, 1)
    n_faces = sum(int((np.diff(padded.astype(int), axis=axis) != 0).sum()) for axis in range(3))
    assert patches == {"inlet": ("patch", across), "outlet": ("patch", across), "wall": ("wall", n_faces - 2 * across)}
    said = run("checkMesh", "-allTopology", "-allGeometry", "-case", case, cwd=tmp_path)
    assert "\nMesh OK." in said, said
    speed = "inlet {type zeroGradient;} outlet {type zeroGradient;} wall {type noSlip;}"
    pressure = "inlet {type fixedValue; value uniform 3.2e-4;} outlet {type fixedValue; value uniform 0;} wall {type zeroGradient;}"
    last = foam.flow(case, speed, pressure)
    order = np.argwhere(flags == 1)[:, ::-1]
    speed = foam.values(last / "U")[:, 0]
    flow = speed[order[:, 0] == 10].sum() * (size * 1e-3) ** 2
    poiseuille = np.pi * 1e-12 * 3.2e-4 / (8 * 1e-6 * length * 1e-3)
    print("flow from inlet to outlet", flow, "Poiseuille", poiseuille)
    assert flow == pytest.approx(poiseuille, rel=0.015)
    # a column file does not know which facets made its faces, and says so; a solid that is not there is named
    other = ["convert", "p.hxc", "case2.foam", "--patches", "solid"]
    assert "does not know which facets" in hexcast(*other, cwd=tmp_path, ok=False)
    wrong = hexcast("mesh", *arguments[:-4], "-o", "x.inp", "--patches", "solid", "--open-patches", "intel", cwd=tmp_path, ok=False)
    assert '"intel"' in wrong and "inlet, outlet" in wrong.replace("wall, ", "")


@pytest.mark.parametrize("form", ["--ascii", "binary"])
@pytest.mark.parametrize("fluid", [1, 0])
def test_cut_cells_around_and_in_a_sphere(tmp_path, form: str, fluid: int) -> None:
    facets = sphere(1.0, 5)
    save(tmp_path / "ball.stl", facets)
    case = tmp_path / "case"
    foam.system(case)
    arguments = ["ball.stl:name=ball", "--domain", "-2,-2,-2,2,2,2", "--dims", "24,24,24", "--unit", "mm", "--backend", "cpu", "--cut"]
    text = ["--ascii"] if form == "--ascii" else []
    warned = hexcast("mesh", *arguments, "--export-flags", fluid, *text, "-o", "case/ball.foam", cwd=tmp_path)
    said = run("checkMesh", "-allTopology", "-case", case, cwd=tmp_path)
    assert "\nMesh OK." in said, said
    inside = np.linalg.det(facets).sum() / 6
    expected = inside if fluid else 64 - inside
    volume = float(re.search(r"Total volume = (\S+?)\. ", said)[1]) * 1e9
    print("volume", volume, "of", expected)
    # chords lie within a ball: that is off by the square of a sixth, a cell in radii
    assert volume == pytest.approx(expected, rel=0.02 if fluid else 0.0015)
    percent, more, exact = re.search(r"the cells have (\S+) % (\w+) volume than the fluid, (\S+),", warned).groups()
    assert float(percent) == pytest.approx(100 * abs(volume / expected - 1), abs=0.006)
    assert (more == "more") == (volume > expected)
    assert float(exact) == pytest.approx(expected, rel=1e-6)
    patches = dict(re.findall(r"(\w+)\s*\{\s*type (\w+);", (case / "constant/polyMesh/boundary").read_text()))
    sides = {f"{axis}{end}": "patch" for axis in "xyz" for end in ("Min", "Max")}
    assert patches == ({"background": "wall"} if fluid else {**sides, "ball": "wall"})


@pytest.mark.parametrize("fluid", [1, 0])
def test_cut_cells_keep_the_edges_of_a_box(tmp_path, fluid: int) -> None:
    """Some of its sides lie in lines of the mesh."""
    low, high = np.array([-1.0, -0.9, -1.0]), np.array([1.0, 0.5, 0.8])
    save(tmp_path / "box.stl", cuboid(low, high))
    case = tmp_path / "case"
    foam.system(case)
    arguments = ["box.stl", "--domain", "-2,-2,-2,2,2,2", "--dims", "16,16,16", "--unit", "mm", "--backend", "cpu", "--cut"]
    said = hexcast("mesh", *arguments, "--export-flags", fluid, "-o", "case/box.foam", cwd=tmp_path)
    assert ("volume than the fluid" in said) == (fluid == 0)
    said = run("checkMesh", "-allTopology", "-case", case, cwd=tmp_path)
    assert "\nMesh OK." in said, said
    inside = np.prod(high - low)
    volume = float(re.search(r"Total volume = (\S+?)\. ", said)[1]) * 1e9
    # around it some cells would be of a wrong shape
    assert volume == pytest.approx(inside if fluid else 64 - inside, rel=1e-5 if fluid else 2e-3)


@pytest.mark.parametrize("cells", [8, 16])
def test_flow_through_a_pipe_of_cut_cells(tmp_path, cells: int) -> None:
    """Q = pi r^4 dp / (8 mu L)."""
    radius, length = 5.0, 20.0
    save(tmp_path / "rod.stl", rod(radius, 30.0, 720) - np.array([5.0, 0, 0]))
    case = tmp_path / "case"
    foam.system(case)
    domain = ["--domain", f"0,{-radius},{-radius},{length},{radius},{radius}", "--dims", f"8,{cells},{cells}"]
    hexcast("mesh", "rod.stl:name=fluid", *domain, "--unit", "mm", "--backend", "cpu", "--cut", "-o", "case/tube.foam", cwd=tmp_path)
    said = run("checkMesh", "-allTopology", "-case", case, cwd=tmp_path)
    assert "\nMesh OK." in said, said
    speed = '"y.*|z.*|background" {type noSlip;} "x.*" {type zeroGradient;}'
    pressure = 'xMin {type fixedValue; value uniform 1.6e-5;} xMax {type fixedValue; value uniform 0;} "y.*|z.*|background" {type zeroGradient;}'
    last = foam.flow(case, speed, pressure)
    flow = foam.flow_out(last, "xMax")
    poiseuille = np.pi * (radius * 1e-3) ** 4 * 1.6e-5 / (8 * 1e-6 * length * 1e-3)
    print("flow", flow, "Poiseuille", poiseuille)
    assert flow == pytest.approx(poiseuille, rel=0.006)


def test_cut_cells_that_cannot_be_made_are_refused(tmp_path) -> None:
    save(tmp_path / "ball.stl", sphere(1.0, 2))
    save(tmp_path / "open.stl", sphere(1.0, 2)[:-1])
    (tmp_path / "case").mkdir()
    common = ["--cells", "8", "--unit", "mm", "--backend", "cpu", "--cut", "-o", "case/a.foam"]

    def failed(*arguments: str) -> str:
        said = hexcast("mesh", *arguments, cwd=tmp_path, ok=False)
        assert list((tmp_path / "case").iterdir()) == []
        return said

    assert "is not closed: it has no volume to measure cut cells of" in failed("open.stl", *common)
    assert "cut cells are those of one fluid, and geometries have the flags 1, 2" in failed("ball.stl:flag=1", "ball.stl:flag=2", *common)
    assert "and no geometry has it" in failed("ball.stl", *common, "--export-flags", "9")
    assert "2 flags are to be exported, and cells are cut at the surface of one" in failed("ball.stl", *common, "--export-flags", "0,1")
    small = ["--cells", "128", *common[2:], "--max-memory", "100MB"]
    assert "cut cells take up to" in failed("ball.stl", *small)
    assert "no output can have cut cells" in failed("ball.stl", *common[:-1], "a.msh")
    hexcast("mesh", "ball.stl", *common[:6], "-o", "m.hxc", cwd=tmp_path)
    assert "column files do not hold where surfaces" in hexcast("convert", "m.hxc", "case/a.foam", "--cut", cwd=tmp_path, ok=False)
