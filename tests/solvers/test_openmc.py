"""OpenMC finds the materials of all cells, and a bare sphere of plutonium is critical."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import h5py
import numpy as np
from conftest import Model, hexcast, run, save, sphere

#: Radius of the critical sphere in cm, one group: LA-13511, problem PUb-1-0-SP.
RADIUS = 6.082547
OPENMC = Path(sys.prefix) / "bin/openmc"


def write_inputs(folder: Path, materials: list[int], settings: str) -> None:
    """Materials of one group by their ids, all of the plutonium of that problem."""
    with h5py.File(folder / "mgxs.h5", "w") as file:
        file.attrs["filetype"] = np.bytes_("mgxs")
        file.attrs["version"] = [1, 0]
        file.attrs["energy_groups"] = 1
        file.attrs["delayed_groups"] = 0
        file.attrs["group structure"] = [0.0, 20e6]
        group = file.create_group("pu")
        group.attrs.update({"fissionable": True, "representation": np.bytes_("isotropic"), "order": 0})
        group.attrs.update({"scatter_format": np.bytes_("legendre"), "scatter_shape": np.bytes_("[G][G'][Order]")})
        group["kTs/294K"] = 294 * 8.617333262e-5
        cross = group.create_group("294K")
        for name, value in (("total", 0.3264), ("absorption", 0.101184), ("fission", 0.0816), ("nu-fission", 2.84 * 0.0816), ("chi", 1.0)):
            cross[name] = [value]
        for name, value in (("scatter_matrix", [0.225216]), ("g_min", [1]), ("g_max", [1])):
            cross[f"scatter_data/{name}"] = value
    one = '<material id="{}"><density units="macro" value="1.0"/><macroscopic name="pu"/></material>'
    text = "".join(one.format(material) for material in materials)
    (folder / "materials.xml").write_text(f"<materials><cross_sections>mgxs.h5</cross_sections>{text}</materials>")
    (folder / "settings.xml").write_text(f"<settings><energy_mode>multi-group</energy_mode>{settings}</settings>")


def test_the_same_cells(model: Model) -> None:
    arguments = ["convert", "m.hxc", "geometry.xml", "--export-flags", "0,1,9"]
    if model.is_graded:
        assert "cells differ in size" in hexcast(*arguments, cwd=model.folder, ok=False)
        return
    hexcast(*arguments, cwd=model.folder)
    write_inputs(model.folder, [1, 9, 256], "<run_mode>plot</run_mode>")
    # OpenMC looks at the middles of voxels along x and y, and at their lower sides along z
    middle, width = (" ".join(repr(part) for part in half) for half in ((0.4, 0.25, 0.225), (0.8, 0.5, 0.4)))
    plot = f'<plot id="1" type="voxel" color_by="material" filename="cells"><origin>{middle}</origin><width>{width}</width>'
    plot += f"<pixels>{' '.join(map(str, model.flags.shape))}</pixels></plot>"
    (model.folder / "plots.xml").write_text(f"<plots>{plot}</plots>")
    run(OPENMC, "--plot", cwd=model.folder)
    with h5py.File(model.folder / "cells.h5") as file:
        np.testing.assert_allclose(file.attrs["lower_left"], [0, 0, 0.025], atol=1e-12)
        np.testing.assert_allclose(file.attrs["voxel_width"], 0.05)
        # OpenMC numbers voxels z, y, x, all upwards; -1 is void
        found = file["data"][:].transpose(2, 1, 0)
    expected = np.choose(np.minimum(model.flags, 3), [256, 1, -1, 9])
    np.testing.assert_array_equal(found, expected)


def test_a_critical_sphere(tmp_path: Path) -> None:
    save(tmp_path / "pu.stl", sphere(RADIUS * 10, 5))
    hexcast("mesh", "pu.stl", "--cells", 64, "--unit", "mm", "--backend", "cpu", "-o", "geometry.xml", cwd=tmp_path)
    source = '<source><space type="point"><parameters>0 0 0</parameters></space></source><seed>7</seed>'
    settings = f"<run_mode>eigenvalue</run_mode><batches>120</batches><inactive>30</inactive><particles>4000</particles>{source}"
    write_inputs(tmp_path, [1], settings)
    said = run(OPENMC, cwd=tmp_path)
    k, sigma = (float(text) for text in re.search(r"Combined k-effective\s*=\s*(\S+) \+/- (\S+)", said).groups())
    print("OpenMC", k, sigma)
    assert sigma < 0.002
    assert abs(k - 1) < 3 * sigma
