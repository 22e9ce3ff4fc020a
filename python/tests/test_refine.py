"""Octrees: leaves are cells of the meshes of their levels, fill the box once, and are what the command writes."""

from __future__ import annotations


import subprocess

import numpy as np
import pytest

import hexcast
from hexcast.shapes import box, sphere

BODIES = [{"source": sphere((0.3, 0, 0), 1.0), "flag": 4, "name": "ball"}, {"source": box((-2, 0.1, -1), (0, 1, 0.2)), "flag": 200, "name": "block"}]


def test_leaves_are_cells_of_the_meshes_of_their_levels_and_fill_the_box():
    leaves = hexcast.refine(BODIES, 2, dims=(20, 12, 9), unit="mm", backend="cpu")
    assert leaves.dims == ((20, 12, 9), (40, 24, 18), (80, 48, 36))
    assert (leaves.names, leaves.unit) == ({4: "ball", 200: "block"}, "mm")
    filled = np.zeros(leaves.dims[-1][::-1], int)
    for level, dims in enumerate(leaves.dims):
        flags = hexcast.mesh(BODIES, dims=dims, unit="mm", backend="cpu").flags
        of_level = leaves.level == level
        assert of_level.any()
        i, j, k = leaves.i[of_level], leaves.j[of_level], leaves.k[of_level]
        np.testing.assert_array_equal(leaves.flag[of_level], flags[k, j, i])
        # all fine cells of each leaf
        n = 4 >> level
        for dz in range(n):
            for dy in range(n):
                for dx in range(n):
                    np.add.at(filled, (n * k + dz, n * j + dy, n * i + dx), 1)
    assert (filled == 1).all()
    sizes = np.diff(leaves.boxes(), axis=1)[:, 0]
    assert np.isclose(sizes.prod(axis=1).sum(), np.prod([leaves.x[-1] - leaves.x[0], leaves.y[-1] - leaves.y[0], leaves.z[-1] - leaves.z[0]]))
    assert "leaves of 3 levels" in repr(leaves) and len(leaves) == len(leaves.flag)


def test_levels_of_flags_and_boxes(tmp_path):
    coarse = hexcast.refine(BODIES, 2, level_of_flags={4: 0, 200: 0}, cells=20, backend="cpu")
    assert set(coarse.level.tolist()) == {0}
    within = hexcast.refine(BODIES, 2, level_of_flags={4: 0, 200: 0}, boxes=[((-2, -1, -1, -1.5, -0.5, -0.5), 2)], cells=20, backend="cpu")
    fine = within.boxes()[within.level == 2]
    assert len(fine) and (fine[:, 1].max(axis=0) < [-1.2, -0.2, -0.2]).all()
    for wrong, code in [({"levels": 17}, "job-value"), ({"levels": 1, "window": (0, 0, 0, 1, 1, 1)}, "job-conflict"), ({"levels": 1, "boxes": [((1, 2), 1)]}, "job-value")]:
        with pytest.raises(hexcast.Error) as caught:
            hexcast.refine(BODIES, cells=20, backend="cpu", **wrong)
        assert caught.value.code == code
    with pytest.raises(hexcast.Error, match="leaves are written as .npz"):
        coarse.save(tmp_path / "leaves.csv")


def test_the_command_has_the_same_leaves(spot, program, tmp_path):
    leaves = hexcast.refine(spot, 2, cells=24, backend="cpu")
    leaves.save(tmp_path / "ours.npz")
    subprocess.run([program, "refine", spot, "--cells", "24", "--levels", "2", "--backend", "cpu", "-o", tmp_path / "theirs.npz"], check=True)
    with np.load(tmp_path / "ours.npz") as ours, np.load(tmp_path / "theirs.npz") as theirs:
        assert ours.files == theirs.files
        for name in ours.files:
            np.testing.assert_array_equal(ours[name], theirs[name])
            assert ours[name].dtype == theirs[name].dtype
