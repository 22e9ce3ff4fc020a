"""openEMS: CSXCAD finds the properties of all cells, and a cavity resonates where theory says."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from conftest import DEBIAN_PYTHON, Model, cuboid, hexcast, plate, run, save
from cavity import RADIUS, mesh_cavity, resonance, theory

FIND = """
import json, sys
from CSXCAD import ContinuousStructure
structure = ContinuousStructure()
structure.ReadFromXML(sys.argv[1])
found = []
for x, y, z in json.load(open("centres.json")):
    properties = structure.GetPropertyByCoordPriority([x, y, z])
    found.append(properties.GetName() if properties else None)
grid = structure.GetGrid()
properties = {one.GetName(): [one.GetTypeString()] for one in structure.GetAllProperties()}
for one in structure.GetAllProperties():
    if one.GetTypeString() == "Material":
        properties[one.GetName()] += [one.GetMaterialProperty(key) for key in ("epsilon", "mue", "kappa", "density")]
boxes = [[one.GetProperty().GetName(), one.GetPriority(), list(one.GetStart()), list(one.GetStop())]
         for one in structure.GetAllPrimitives(False)]
json.dump({"found": found, "unit": grid.GetDeltaUnit(), "lines": [list(grid.GetLines(axis)) for axis in "xyz"],
           "properties": properties, "boxes": boxes}, open("found.json", "w"))
"""
MATERIALS = ("base.stl:name=base,eps_r=2.5,mu_r=1.5,sigma=0.02,density=1200", "block.stl:name=block,pec=true", "bar.stl:flag=9,name=1 bar,eps_r=4")


def test_the_same_cells(model: Model) -> None:
    said = hexcast("convert", "m.hxc", "m.csx.xml", cwd=model.folder, ok=False)
    assert 'flag 1 ("base") is made of' in said
    hexcast("mesh", *MATERIALS, *model.options, "-o", "m.csx.xml", cwd=model.folder)
    (model.folder / "find.py").write_text(FIND)
    (model.folder / "centres.json").write_text(json.dumps(model.centres.reshape(-1, 3).tolist()))
    run(DEBIAN_PYTHON, "find.py", "m.csx.xml", cwd=model.folder)
    read = json.loads((model.folder / "found.json").read_text())
    names = {0: None, 1: "base", 2: "block", 9: "f_1_bar"}
    assert read["found"] == [names[flag] for flag in model.flags.reshape(-1)]
    assert read["unit"] == 1e-3
    for found, lines in zip(read["lines"], model.lines):
        np.testing.assert_array_equal(found, lines)
    assert read["properties"] == {
        "base": ["Material", 2.5, 1.5, 0.02, 1200],
        "block": ["Metal"],
        "f_1_bar": ["Material", 4, 1, 0, 0],
    }
    # every cell in one box, and conductors before the rest
    seen = np.zeros(model.flags.shape, int)
    for name, priority, start, stop in read["boxes"]:
        box = tuple(slice(*np.searchsorted(lines, [low, high])) for lines, low, high in zip(model.lines, start, stop))
        seen[box] += 1
        assert priority == (20 if name == "block" else 10)
    assert (seen == model.of(1, 2, 9)).all()
    assert len(read["boxes"]) < 20


SETTINGS = """<FDTD NumberOfTimesteps="30000" endCriteria="1e-9" f_max="20e9"><Excitation Type="0" f0="13e9" fc="5e9"/>
<BoundaryCond xmin="PEC" xmax="PEC" ymin="PEC" ymax="PEC" zmin="PEC" zmax="PEC"/></FDTD>"""


def test_a_spherical_cavity(tmp_path) -> None:
    mesh_cavity(tmp_path, "c.csx.xml")
    structure = re.sub(r"<\?xml.*?\?>", "", (tmp_path / "c.csx.xml").read_text())

    def line(z: float, x: float = 0) -> str:
        corners = "".join(f'<P{i} X="{x}" Y="0" Z="{z + (i - 1) * 2}"/>' for i in (1, 2))
        return f'<Primitives><Box Priority="30">{corners}</Box></Primitives>'

    added = f"""<Excitation ID="8" Name="e" Number="0" Enabled="1" Frequency="0" Delay="0" Type="0" Excite="0,0,1" PropDir="0,0,0">{line(0)}</Excitation>
<ProbeBox ID="9" Name="ut" Number="0" Type="0" Weight="1" NormDir="-1">{line(-2, 2)}</ProbeBox></Properties>"""
    structure = structure.replace("</Properties>", added)
    (tmp_path / "run.xml").write_text(f'<?xml version="1.0"?><openEMS>{SETTINGS}{structure}</openEMS>')
    said = run("openEMS", "run.xml", cwd=tmp_path)
    assert not re.search(r"Unknown Property|Error|Unused primitive", said), said
    time, voltage = np.loadtxt(tmp_path / "ut", comments="%", unpack=True)[:2]
    found = resonance(time, voltage)
    print("openEMS", found, "theory", theory(RADIUS))
    assert found == pytest.approx(theory(RADIUS), rel=0.01)


#: Of a patch antenna, in mm: board, patch, and where it is fed.
BOARD, PATCH, THICK, FEED = 30, (16, 20), 1.524, -6
ANTENNA = """<FDTD NumberOfTimesteps="12000" endCriteria="1e-9" f_max="4e9"><Excitation Type="0" f0="2.3e9" fc="1.2e9"/>
<BoundaryCond xmin="MUR" xmax="MUR" ymin="MUR" ymax="MUR" zmin="MUR" zmax="MUR"/></FDTD>"""


def ring(folder: Path, name: str, structure: str) -> float:
    """Frequency at which an antenna rings that is fed under its patch."""
    feed = f'<Primitives><Box Priority="30"><P1 X="{FEED}" Y="0" Z="0"/><P2 X="{FEED}" Y="0" Z="{THICK}"/></Box></Primitives>'
    added = f"""<Excitation ID="8" Name="e" Number="0" Enabled="1" Frequency="0" Delay="0" Type="0" Excite="0,0,1" PropDir="0,0,0">{feed}</Excitation>
<ProbeBox ID="9" Name="ut" Number="0" Type="0" Weight="1" NormDir="-1">{feed}</ProbeBox></Properties>"""
    structure = re.sub(r"<\?xml.*?\?>", "", structure).replace("</Properties>", added)
    where = folder / name
    where.mkdir()
    (where / "run.xml").write_text(f'<?xml version="1.0"?><openEMS>{ANTENNA}{structure}</openEMS>')
    said = run("openEMS", "run.xml", cwd=where)
    assert not re.search(r"Unknown Property|Error|Unused primitive", said), said
    time, voltage = np.loadtxt(where / "ut", comments="%", unpack=True)[:2]
    return resonance(time, voltage, (1.5e9, 3.5e9), after=2e-9)


def test_a_patch_antenna_from_surfaces_rings_as_one_that_was_typed(tmp_path: Path) -> None:
    x, y = PATCH
    save(tmp_path / "board.stl", cuboid((-BOARD, -BOARD, 0), (BOARD, BOARD, THICK)))
    save(tmp_path / "patch.stl", plate((-x, -y, THICK), (x, y, THICK)))
    save(tmp_path / "ground.stl", plate((-BOARD, -BOARD, 0), (BOARD, BOARD, 0)))
    across = list(range(-70, 71, 2))
    up = [*range(-30, 0, 3), 0, 0.381, 0.762, 1.143, 1.524, 3, *range(5, 45, 3)]
    (tmp_path / "lines.json").write_text(json.dumps({"x": across, "y": across, "z": up}))
    geometries = ["ground.stl:pec=true", "board.stl:eps_r=3.38", "patch.stl:pec=true"]
    # the same files in another order: the board does not cover what lies on it
    for number, order in enumerate((geometries, geometries[::-1])):
        hexcast("mesh", *order, "--lines", "lines.json", "--unit", "mm", "--backend", "cpu", "-o", f"{number}.csx.xml", cwd=tmp_path)
    structures = [(tmp_path / f"{number}.csx.xml").read_text() for number in range(2)]
    assert [text.count("<Metal") for text in structures] == [2, 2]

    def box(low: tuple[float, ...], high: tuple[float, ...], priority: int) -> str:
        ends = "".join(f'<P{i} X="{p[0]}" Y="{p[1]}" Z="{p[2]}"/>' for i, p in ((1, low), (2, high)))
        return f'<Primitives><Box Priority="{priority}">{ends}</Box></Primitives>'

    grid = re.search(r"<RectilinearGrid.*?</RectilinearGrid>", structures[0], re.DOTALL)
    assert grid is not None and "1.524" in grid[0]
    # a strip that a user lays on the patch is not "unused", and has no effect
    typed = f"""<ContinuousStructure CoordSystem="0">{grid[0]}<BackgroundMaterial Epsilon="1" Mue="1" Kappa="0" Sigma="0"/><Properties>
<Metal ID="0" Name="ground">{box((-BOARD, -BOARD, 0), (BOARD, BOARD, 0), 10)}</Metal>
<Metal ID="1" Name="patch">{box((-x, -y, THICK), (x, y, THICK), 10)}</Metal>
<Material ID="2" Name="board"><Property Epsilon="3.38"/>{box((-BOARD, -BOARD, 0), (BOARD, BOARD, THICK), 0)}</Material>
</Properties></ContinuousStructure>"""
    expected = ring(tmp_path, "typed", typed)
    found = [ring(tmp_path, f"meshed{number}", structure) for number, structure in enumerate(structures)]
    print("patch antenna: typed", expected, "from surfaces", found)
    assert expected == pytest.approx(2.317e9, rel=0.05)
    assert found == pytest.approx([expected] * 2, rel=0.02)
