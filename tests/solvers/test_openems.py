"""openEMS: CSXCAD finds the properties of all cells, and a cavity resonates where theory says."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest
from conftest import DEBIAN_PYTHON, Model, hexcast, run
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
