"""VTK, meshio and dolfinx read hexahedra from XDMF, and find the same cells."""

from __future__ import annotations

import re

import meshio
import numpy as np
import pytest
from conftest import DEBIAN_PYTHON, ROOT, Model, hexcast, run
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
