"""Names that no program would take as they are, the background alone, a single cell: real programs read the files all the same."""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path

import h5py
import nrrd
import numpy as np
import pytest
from conftest import DEBIAN_PYTHON, Model, cuboid, hexcast, run, save
from test_calculix import table
from test_openmc import OPENMC, write_inputs
from vtkmodules.vtkIOXML import vtkXMLImageDataReader

import foam

#: Of flags 0, 1, 2 and 9: markup, quotes, umlauts, code, a leading digit, and one that becomes the same as another.
NAMES = ["Luft < Öl & Co", "Fuß <1> \"zwei\" 'drei'", "7 arms; */ // { $x", "Fu _1_  zwei_ _drei_"]
PLAIN = ["Luft____l___Co", "Fu___1___zwei___drei_", "f_7_arms___________x", "Fu__1___zwei___drei_"]
SUBSTANCE = {"eps_r": 2.5, "E": 1e9, "nu": 0.2}


def job(folder: Path, flags: tuple[int, ...], **more: object) -> None:
    files = {1: "base.stl", 2: "block.stl", 9: "bar.stl"}
    names = dict(zip((0, 1, 2, 9), NAMES))
    geometries = [{"file": files[flag], "flag": flag, "name": names[flag], "material": SUBSTANCE} for flag in flags]
    background = {"name": NAMES[0], "material": {"eps_r": 1.0006}}
    (folder / "job.json").write_text(json.dumps({"geometries": geometries, "background": background, "unit": "mm", **more}))


def check(folder: Path, output: str, *more: object) -> None:
    hexcast("mesh", "--job", "job.json", "--backend", "cpu", "-q", "-o", output, *more, cwd=folder)


def read_by_all(folder: Path, counts: dict[str, int], *more: object) -> None:
    """OpenFOAM, CalculiX, Gmsh, openEMS, gprMax and OpenMC take the files, and those with zones find so many cells of each name."""
    n_cells = sum(counts.values())
    foam.system(folder / "case")
    check(folder, "case/a.foam", *more)
    said = run("checkMesh", "-allTopology", "-case", "case", cwd=folder)
    assert "\nMesh OK." in said, said
    zones = re.findall(r"\n\s+(\w+)\s+(\d+)\s+\d+\s+\S+\s+\(", said.split("CellZone")[1])
    assert {name: int(n) for name, n in zones} == counts
    check(folder, "m.inp", *more)
    prints = "\n".join(f"*EL PRINT, ELSET={name}, TOTALS=YES\nEVOL" for name in counts)
    unknown = [name for name in counts if f"*SOLID SECTION, ELSET={name}," not in (folder / "m.inp").read_text()]
    sections = ["*MATERIAL, NAME=M", "*ELASTIC", "1e9, 0.2", *(f"*SOLID SECTION, ELSET={name}, MATERIAL=M" for name in unknown)]
    lines = ["*INCLUDE, INPUT=m.inp", *sections, "*BOUNDARY", "NALL, 1, 3", "*STEP", "*STATIC", prints, "*END STEP", ""]
    (folder / "run.inp").write_text("\n".join(lines))
    run("ccx", "run", cwd=folder)
    text = (folder / "run.dat").read_text()
    assert {name: len(table(text, f"volume (element, volume) for set {name.upper()} and time")) for name in counts} == counts
    check(folder, "m.msh", *more)
    said = run("gmsh", "-check", "m.msh", cwd=folder)
    assert not re.search(r"Warning|Error", said), said
    assert int(re.search(r"(\d+) elements", said)[1]) == n_cells
    for name in counts:
        assert f' "{name}"\n'.encode() in (folder / "m.msh").read_bytes()
    check(folder, "m.csx.xml", *more)
    names = "print(sorted(one.GetName() for one in structure.GetAllProperties()))"
    code = f"from CSXCAD import ContinuousStructure\nstructure = ContinuousStructure()\nstructure.ReadFromXML('m.csx.xml')\n{names}"
    assert run(DEBIAN_PYTHON, "-c", code, cwd=folder).split("\n")[-2] == str(sorted(counts))
    check(folder, "geometry.xml", *more)
    write_inputs(folder, [1, 2, 9, 256], "<run_mode>plot</run_mode>")
    plot = '<plot id="1" type="voxel" filename="cells"><origin>0 0 0</origin><width>1 1 1</width><pixels>2 2 2</pixels></plot>'
    (folder / "plots.xml").write_text(f"<plots>{plot}</plots>")
    run(OPENMC, "--plot", cwd=folder)
    check(folder, "m.in", *more)
    high = re.search(r"#domain: (.*)", (folder / "m.in").read_text())[1]
    (folder / "run.in").write_text(f"#title: t\n#time_window: 1\n#pml_cells: 0\n#include_file: m.in\n#geometry_objects_write: 0 0 0 {high} built\n")
    said = run(sys.executable, "-m", "gprMax", "run.in", "--geometry-only", cwd=folder, ok=n_cells > 1)
    if n_cells == 1:
        assert "more than one axis with only 1 cell" in said
        return
    with h5py.File(next(iter(folder.rglob("built*.h5")))) as file:
        keys = [key.decode() for key in file["material_keys"][:]]
        for name, n in counts.items():
            of_name = [place for place, key in enumerate(keys) if name in key]
            assert np.isin(file["data"][:], of_name).sum() == n, keys


@pytest.mark.parametrize("model", [False], indirect=True)
def test_names_of_any_characters(model: Model) -> None:
    counts = {name: int(model.of(flag).sum()) for flag, name in zip((0, 1, 2, 9), PLAIN)}
    lines = {axis: list(values) for axis, values in zip("xyz", model.lines)}
    job(model.folder, (1, 2, 9), lines=lines)
    read_by_all(model.folder, counts, "--export-flags", "0,1,2,9")
    # where names may be anything they are what the job says
    check(model.folder, "m.xdmf")
    with h5py.File(model.folder / "m.h5") as file:
        assert [file.attrs[f"flag {flag}"] for flag in (0, 1, 2, 9)] == NAMES
    check(model.folder, "m.raw")
    sidecar = json.loads((model.folder / "m.raw.json").read_text())
    assert [flag["name"] for flag in sidecar["flags"]] == NAMES


def test_the_background_alone(tmp_path: Path) -> None:
    save(tmp_path / "base.stl", cuboid((0, 0, 0), (8, 3, 2)))
    job(tmp_path, (1,), domain=[10, 0, 0, 12, 1.5, 1], cell_size=0.5)
    said = hexcast("mesh", "--job", "job.json", "-o", "m.inp", cwd=tmp_path, ok=False)
    assert "every cell has flag 0" in said and not (tmp_path / "m.inp").exists()
    read_by_all(tmp_path, {PLAIN[0]: 4 * 3 * 2}, "--export-flags", "0")


def test_a_single_cell(tmp_path: Path) -> None:
    save(tmp_path / "base.stl", cuboid((0, 0, 0), (8, 3, 2)))
    job(tmp_path, (1,), dims=[1, 1, 1])
    read_by_all(tmp_path, {PLAIN[1]: 1})


def test_300_geometries(tmp_path: Path) -> None:
    """Of ten substances; each solver finds those of its cells."""
    spheres = [{"file": "one.stl", "flag": 1 + i % 10, "translate": [i % 20, i // 20, 0], "name": f"b {i}"} for i in range(300)]
    save(tmp_path / "one.stl", cuboid((0, 0, 0), (1, 1, 1)))
    (tmp_path / "job.json").write_text(json.dumps({"geometries": spheres, "cell_size": 1, "unit": "mm"}))
    foam.system(tmp_path / "case")
    check(tmp_path, "case/a.foam")
    said = run("checkMesh", "-case", "case", cwd=tmp_path)
    assert "\nMesh OK." in said and int(re.search(r"\n\s+cells:\s+(\d+)", said)[1]) == 300
    names = [name for name, _ in re.findall(r"\n\s+(\w+)\s+(30)\s+\d+\s+\S+\s+\(", said.split("CellZone")[1])]
    assert len(set(names)) == 10
    check(tmp_path, "m.inp")
    text = (tmp_path / "m.inp").read_text()
    assert all(len(line) <= 256 for line in text.splitlines())


def test_missing_materials_are_refused_before_the_mesh_is_made(tmp_path: Path) -> None:
    # a surface that is not closed: its refusal comes with the mesh
    save(tmp_path / "open.stl", cuboid((0, 0, 0), (4, 3, 2))[1:])
    save(tmp_path / "far.stl", cuboid((50, 0, 0), (51, 1, 1)))
    box = ["--domain", "-1,-1,-1,5,4,3", "--cell-size", "0.5", "--unit", "mm", "--backend", "cpu", "--open", "error"]
    asked = {"m.csx.xml": ("eps_r=2", "is made of"), "m.in": ("eps_r=2", "is made of"), "m.inp": ("E=1e9,nu=0.3", "has E and no nu")}
    for output, (enough, words) in asked.items():
        lacks = "open.stl:E=1e9,name=a" if output == "m.inp" else "open.stl:density=5,name=a"
        assert words in hexcast("mesh", lacks, *box, "-o", output, cwd=tmp_path, ok=False)
        for known in ([f"open.stl:{enough}"], [f"open.stl:{enough}", "far.stl"]):
            said = hexcast("mesh", *known, *box, "-o", output, cwd=tmp_path, ok=False)
            assert words not in said and "not closed" in said, said
    # of flags that are exported alone
    said = hexcast("mesh", "open.stl:eps_r=2", *box, "-o", "m.csx.xml", "--export-flags", "0,1", cwd=tmp_path, ok=False)
    assert "flag 0 is made of" in said


def test_materials_are_in_every_output_that_has_texts(tmp_path: Path) -> None:
    save(tmp_path / "base.stl", cuboid((0, 0, 0), (8, 3, 2)))
    job(tmp_path, (1,), cell_size=0.5, padding={"cells": 1})
    expected = {0: {"eps_r": 1.0006}, 1: SUBSTANCE}
    check(tmp_path, "m.xdmf")
    with h5py.File(tmp_path / "m.h5") as file:
        assert {flag: json.loads(file.attrs[f"flag {flag} material"]) for flag in expected} == expected
    check(tmp_path, "m.nrrd")
    header = nrrd.read_header(str(tmp_path / "m.nrrd"))
    assert {flag: json.loads(header[f"flag {flag} material"]) for flag in expected} == expected
    check(tmp_path, "m.vti")
    reader = vtkXMLImageDataReader()
    reader.SetFileName(str(tmp_path / "m.vti"))
    reader.Update()
    fields = reader.GetOutput().GetFieldData()
    values, materials = (fields.GetAbstractArray(name) for name in ("flag_values", "flag_materials"))
    found = {int(values.GetValue(i)): json.loads(materials.GetValue(i)) for i in range(values.GetNumberOfTuples())}
    assert found == expected


def test_a_map_that_makes_two_flags_one_is_a_warning(model: Model) -> None:
    for given, words in {"1=2": "flag 1 as 2", "9=0,0=5": None, "1=0,0=1": None, "2=0": "flag 2 as 0", "7=1": None, "1=7": None}.items():
        said = hexcast("convert", "m.hxc", "a.npy", "--map", given, cwd=model.folder)
        assert ("which another flag keeps" in said) == (words is not None) and (words or "") in said, (given, said)
