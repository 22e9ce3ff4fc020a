"""VTK, meshio and dolfinx read hexahedra from XDMF, and find the same cells."""

from __future__ import annotations

import re

import h5py
import meshio
import numpy as np
import pytest
from conftest import DEBIAN_PYTHON, ROOT, Model, hexcast, rod, run, save_solids
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkFiltersVerdict import vtkCellSizeFilter
from vtkmodules.vtkIOXdmf2 import vtkXdmfReader


def cells_of(model: Model, middles: np.ndarray) -> tuple[np.ndarray, ...]:
    return tuple(np.searchsorted(lines, middles[:, axis]) - 1 for axis, lines in enumerate(model.lines))


@pytest.mark.parametrize("compress", ["none", "6"])
@pytest.mark.parametrize("flags", [(1, 2, 9), (0, 2)])
def test_vtk_and_meshio(model: Model, flags: tuple[int, ...], compress: str) -> None:
    hexcast("convert", "m.hxc", "m.xdmf", "--export-flags", ",".join(map(str, flags)), f"--compress={compress}", cwd=model.folder)
    kept = model.of(*flags)
    reader = vtkXdmfReader()
    reader.SetFileName(str(model.folder / "m.xdmf"))
    sizes = vtkCellSizeFilter()
    sizes.SetInputConnection(reader.GetOutputPort())
    sizes.Update()
    grid = sizes.GetOutput()
    read = meshio.read(model.folder / "m.xdmf")
    [block] = read.cells
    assert block.type == "hexahedron" and grid.GetNumberOfCells() == len(block.data) == kept.sum()
    cells = cells_of(model, read.points[block.data].mean(axis=1))
    data = grid.GetCellData()
    for found in (vtk_to_numpy(data.GetArray("flag")), read.cell_data["flag"][0]):
        all_found = np.full(model.flags.shape, -1)
        all_found[cells] = found
        np.testing.assert_array_equal(all_found, np.where(kept, model.flags.astype(int), -1))
    # VTK's own volumes are positive where the corners are in its order
    np.testing.assert_allclose(vtk_to_numpy(data.GetArray("Volume")), model.volumes[cells], rtol=1e-12)


def test_the_recipe_for_dolfinx(model: Model) -> None:
    [script] = re.findall(r"```python\n(.*?)```", (ROOT / "docs/export/xdmf.md").read_text(), re.DOTALL)
    hexcast("convert", "m.hxc", "beam.xdmf", cwd=model.folder)
    (model.folder / "run.py").write_text(script)
    said = run(DEBIAN_PYTHON, "run.py", cwd=model.folder)
    found = {int(flag): float(volume) for flag, volume in re.findall(r"^flag (\d+): (\S+)$", said, re.MULTILINE)}
    assert found == pytest.approx({flag: model.volumes[model.of(flag)].sum() for flag in (1, 2, 9)}, rel=1e-12)


AREAS = """
import sys
import dolfinx, h5py, numpy as np, ufl
from mpi4py import MPI

with dolfinx.io.XDMFFile(MPI.COMM_WORLD, "pipe.xdmf", "r") as file:
    mesh = file.read_mesh(name="Grid")
    mesh.topology.create_connectivity(2, 3)
    mesh.topology.create_connectivity(3, 2)
    walls = file.read_meshtags(mesh, name="facets")
ds = ufl.Measure("ds", domain=mesh, subdomain_data=walls)
one = dolfinx.fem.Constant(mesh, 1.0)
for wall in np.unique(walls.values):
    print(f"wall {wall}: {dolfinx.fem.assemble_scalar(dolfinx.fem.form(one * ds(int(wall))))!r}")
"""


def test_dolfinx_has_the_areas_of_solids(tmp_path) -> None:
    facets = rod(1.0, 2.0).reshape(-1, 4, 3, 3)
    save_solids(tmp_path / "pipe.stl", {"wall": facets[:, :2].reshape(-1, 3, 3), "inlet": facets[:, 2], "outlet": facets[:, 3]})
    arguments = ["pipe.stl", "--cell-size", 0.25, "--backend", "cpu", "-o", "pipe.xdmf", "-o", "m.raw", "--patches", "solid"]
    hexcast("mesh", *arguments, cwd=tmp_path)
    (tmp_path / "run.py").write_text(AREAS.replace("h5py, ", ""))
    said = run(DEBIAN_PYTHON, "run.py", cwd=tmp_path)
    found = {int(wall): float(area) for wall, area in re.findall(r"^wall (\d+): (\S+)$", said, re.MULTILINE)}
    with h5py.File(tmp_path / "pipe.h5") as file:
        names = {int(key.split()[1]): value for key, value in file.attrs.items() if key.startswith("wall ")}
    flags = np.fromfile(tmp_path / "m.raw", np.uint8).reshape(8, 8, 8)
    across = flags[:, :, 0].sum() / 16
    every = sum((np.diff(np.pad(flags, 1).astype(int), axis=axis) != 0).sum() for axis in range(3)) / 16
    areas = {names[wall] if isinstance(names[wall], str) else names[wall].decode(): area for wall, area in found.items()}
    assert areas == pytest.approx({"inlet": across, "outlet": across, "wall": every - 2 * across}, rel=1e-12)
