"""The embedded boundary for AMReX, by a reader of VisMF written from AMReX's description of it; volumes, areas and walls are compared with geometry and with --fractions."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from conftest import cuboid, hexcast, rod, save, sphere

REAL = "((8, (64 11 52 0 1 12 0 1023)),(8, (8 7 6 5 4 3 2 1)))"
BOX = re.compile(r"\(\((-?\d+),(-?\d+),(-?\d+)\) \((-?\d+),(-?\d+),(-?\d+)\) \(([01]),([01]),([01])\)\)")
ARRAYS = ["volfrac", "centroid", "bndryarea", "bndrycent", "bndrynorm", "levelset", *(f"{a}_{x}" for a in ("areafrac", "facecent", "edgecent") for x in "xyz")]


def boxes(text: str) -> np.ndarray:
    """Of each box the first place, the last, and along which axes places are nodes."""
    return np.array([[int(n) for n in found] for found in BOX.findall(text)]).reshape(-1, 3, 3)


class Array:
    """An array of VisMF: of each grid its box without ghosts, and its numbers by x, y, z and component, ghosts included."""

    def __init__(self, folder: Path, name: str) -> None:
        head = (folder / "Level_0" / f"{name}_H").read_text()
        version, how, n, ghosts = (int(line) for line in head.split("\n")[:4])
        assert (version, how, ghosts) == (1, 1, 2)
        self.boxes = boxes(head)
        places = re.findall(r"FabOnDisk: (\S+) (\d+)\n", head)
        assert len(places) == len(self.boxes) == int(re.match(r"\((\d+) 0\n", head.split("\n", 4)[4])[1])
        ends = [np.array([[float(x) for x in row.split(",")[:-1]] for row in part.split()]) for part in re.split(rf"\n{len(places)},{n}\n", head)[1:]]
        self.grids = []
        for index, (file, start) in enumerate(places):
            data = (folder / "Level_0" / file).read_bytes()[int(start) :]
            line, numbers = data.split(b"\n", 1)
            words = re.match(r"FAB (.*)(\(\(-?\d+,.*\)\)) (\d+)$", line.decode())
            assert words[1] == REAL and int(words[3]) == n
            low, high, nodal = boxes(words[2])[0]
            mine = self.boxes[index]
            assert (low == mine[0] - 2).all() and (high == mine[1] + 2).all() and (nodal == mine[2]).all()
            shape = high - low + 1
            of = np.frombuffer(numbers, "<f8", shape.prod() * n).reshape(n, *shape[::-1]).transpose(3, 2, 1, 0)
            np.testing.assert_array_equal([ends[0][index], ends[1][index]], [of.min(axis=(0, 1, 2)), of.max(axis=(0, 1, 2))])
            self.grids.append((low, of))

    def of_box(self, low: np.ndarray, high: np.ndarray, default: float) -> np.ndarray:
        """The numbers of a box of places; `default` where no grid has them. Grids that share a place must agree."""
        found = np.full((*(high - low + 1), self.grids[0][1].shape[3]), np.nan)
        for first, of in self.grids:
            start, end = np.maximum(first, low), np.minimum(first + of.shape[:3], high + 1)
            if (start >= end).any():
                continue
            here = tuple(slice(*s) for s in zip(start - low, end - low))
            there = of[tuple(slice(*s) for s in zip(start - first, end - first))]
            before = found[here]
            np.testing.assert_array_equal(np.where(np.isnan(before), there, before), there)
            found[here] = there
        return np.where(np.isnan(found), default, found).squeeze()


class Boundary:
    """A folder for EB2::BuildFromChkptFile."""

    def __init__(self, folder: Path) -> None:
        lines = (folder / "Header").read_text().split("\n")
        assert lines[:2] == ["Checkpoint version: 1", "1"] and lines[5:7] == ["1", "64"]
        self.low, self.high = ([float(word) for word in line.split()] for line in lines[2:4])
        self.grow = [int(word) for word in lines[4].split()]
        lists = re.findall(r"\((\d+) 0\n((?:.*\n)*?)\)\n", "\n".join(lines[7:]))
        self.cut, self.covered = (boxes(lists[i][1]) if i < len(lists) else np.zeros((0, 3, 3), int) for i in range(2))
        assert [int(count) for count, _ in lists] == [len(self.cut), *([len(self.covered)] * (len(lists) - 1))]
        self.arrays = {name: Array(folder, name) for name in ARRAYS}
        for array in self.arrays.values():
            np.testing.assert_array_equal(array.boxes[:, 0], self.cut[:, 0])
            np.testing.assert_array_equal(array.boxes[:, 1], self.cut[:, 1] + array.boxes[:, 2])
        self.dims = np.array([int(n) for n in re.search(r"n_cell = (.*)", (folder / "inputs").read_text())[1].split()])

    def of(self, name: str, default: float = np.nan) -> np.ndarray:
        array = self.arrays[name]
        return array.of_box(np.zeros(3, int), self.dims - 1 + array.boxes[0, 2], default)

    def areas(self) -> list[np.ndarray]:
        """Of each axis the area fractions below and above all cells."""
        return [np.stack([area.take(range(n), axis), area.take(range(1, n + 1), axis)]) for axis, n in enumerate(self.dims) for area in [self.of(f"areafrac_{'xyz'[axis]}")]]

    def check(self) -> None:
        """What holds for every cell: walls close, linear functions are integrated exactly over flat walls, and nodes, edges, faces and cells agree."""
        volume, areas, level = self.of("volfrac"), self.areas(), self.of("levelset")
        vector = np.stack([low - high for low, high in areas], axis=-1)
        wall = self.of("bndryarea")[..., None] * self.of("bndrynorm")
        np.testing.assert_allclose(wall, vector, atol=1e-12)
        assert ((volume >= 0) & (volume <= 1)).all()
        all_areas = np.concatenate(areas)
        assert (all_areas[:, volume == 0] == 0).all()
        # from nodes: no cell without one has any fluid, and faces of a cell with all are whole
        corners = np.stack([level[x : x + self.dims[0], y : y + self.dims[1], z : z + self.dims[2]] < 0 for x in (0, 1) for y in (0, 1) for z in (0, 1)])
        assert (volume[~corners.any(0)] == 0).all() and (volume[corners.all(0)] == 1).all() and (all_areas[:, corners.all(0)] == 1).all()
        # a cell that AMReX takes for cut has an open face and a wall
        is_cut = corners.any(0) & ~corners.all(0) & (all_areas > 0).any(0) & (all_areas < 1).any(0)
        assert ((self.of("bndryarea") > 0) == is_cut).all()
        assert (volume[is_cut] > 0).all()
        for axis, name in enumerate("xyz"):
            edge, ends = self.of(f"edgecent_{name}"), np.stack([level.take(range(n, n + self.dims[axis]), axis) < 0 for n in (0, 1)])
            assert (edge[ends.all(0)] == 1).all() and (edge[~ends.any(0)] == -1).all()
            assert (edge[ends[0] & ~ends[1]] <= 0).all() and (edge[~ends[0] & ends[1]] >= 0).all() and (abs(edge[ends[0] ^ ends[1]]) <= 0.5).all()


@pytest.fixture
def ball(tmp_path: Path) -> Path:
    save(tmp_path / "ball.stl", sphere(1.0, 4))
    return tmp_path


def volume_of(facets: np.ndarray) -> float:
    return np.linalg.det(facets.astype("f4").astype(float)).sum() / 6


@pytest.mark.parametrize("fluid", [1, 0])
def test_a_sphere(ball: Path, fluid: int) -> None:
    domain = ["--domain", "-2,-2,-2,2,2,2", "--dims", "24,24,24", "--unit", "mm", "--backend", "cpu", "--export-flags", fluid]
    said = hexcast("mesh", "ball.stl", *domain, "--fractions", "f.npz", "--fraction-faces", "--fraction-centroids", "--fraction-edges", "--report", "r.json", "-o", "case.eb", cwd=ball)
    assert "warning" not in said
    found = Boundary(ball / "case.eb")
    assert (found.low, found.high, found.grow) == ([-2.0] * 3, [2.0] * 3, [16] * 3)
    np.testing.assert_array_equal(found.cut, [[[-16] * 3, [39] * 3, [0] * 3]])
    found.check()
    size, of_ball = 1 / 6, volume_of(sphere(1.0, 4))
    volume = found.of("volfrac")
    # corners are snapped to 2^-17 of a cell or less, once; cells with less than 1e-6 of the fluid are covered
    assert volume.sum() * size**3 == pytest.approx(of_ball if fluid else 64 - of_ball, rel=1e-7)
    measured = json.loads((ball / "r.json").read_text())["fractions"]["volumes"]
    assert volume.sum() * size**3 == pytest.approx(next(of["volume"] for of in measured if of["flag"] == fluid), rel=1e-10)
    # the same numbers as those of --fractions, which are rounded to 32 bits
    cut = np.load(ball / "f.npz")
    mine = (cut["flag"] == fluid) & (cut["fraction"] >= 1e-6)
    at = np.unravel_index(cut["cell"][mine], (24, 24, 24)[::-1])[::-1]
    np.testing.assert_allclose(volume[at], cut["fraction"][mine], atol=1e-7)
    np.testing.assert_allclose(found.of("centroid")[at], cut["centroid"][mine] - 0.5, atol=2e-7)
    areas = [area[(slice(None), *at)] for area in found.areas()]
    each = np.concatenate(areas).T
    # but for those of cells that are covered, as they have next to nothing
    is_shut = (each == 0) & (cut["faces"][mine] < 1e-4)
    np.testing.assert_allclose(np.where(is_shut, 0, cut["faces"][mine]), each, atol=1e-7)
    for axis, name in enumerate("xyz"):
        part = (areas[axis][0] > 0) & (areas[axis][0] < 1)
        assert part.sum() > 100
        np.testing.assert_allclose(found.of(f"facecent_{name}")[at][part], cut["face_centroid"][mine][part, 2 * axis] - 0.5, atol=2e-7)
    # walls: all of the sphere, and the normals point out of the fluid
    area, normal = found.of("bndryarea"), found.of("bndrynorm")
    is_wall = area > 0
    assert area.sum() * size**2 == pytest.approx(4 * np.pi, rel=4e-3)
    place = (np.argwhere(is_wall) + 0.5 + found.of("bndrycent")[is_wall]) * size - 2
    np.testing.assert_allclose(np.linalg.norm(place, axis=1), 1, atol=8e-3)
    outward = (place * normal[is_wall]).sum(1) / np.linalg.norm(place, axis=1)
    assert ((outward if fluid else -outward) > 0.97).all()
    nodes = np.linalg.norm(np.stack(np.meshgrid(*[np.linspace(-2, 2, 25)] * 3, indexing="ij")), axis=0)
    level = found.of("levelset")
    far = abs(nodes - 1) > 5e-3
    assert ((level < 0) == ((nodes < 1) == (fluid == 1)))[far].all()


def test_a_pipe_goes_on_past_its_ends(tmp_path: Path) -> None:
    """The box is that of the pipe: its ends are no walls, and cells past them have what the ends have."""
    facets, size = rod(1.0, 9.0, 64), 1 / 8
    save(tmp_path / "pipe.stl", facets)
    arguments = ["mesh", "pipe.stl", "--dims", "72,16,16", "--unit", "mm", "--backend", "cpu", "-o", "case.eb"]
    assert "warning" not in hexcast(*arguments, cwd=tmp_path)
    found = Boundary(tmp_path / "case.eb")
    np.testing.assert_array_equal(found.cut[:, :2], [[[-16, -16, -16], [63, 31, 31]], [[64, -16, -16], [87, 31, 31]]])
    found.check()
    assert found.of("volfrac").sum() * size**3 == pytest.approx(volume_of(facets), rel=1e-7)
    area = found.of("areafrac_x").sum((1, 2)) * size**2
    np.testing.assert_allclose(area, volume_of(facets) / 9, rtol=1e-7)
    past = found.arrays["volfrac"].of_box(np.array([-18, 0, 0]), np.array([-1, 15, 15]), np.nan)
    np.testing.assert_allclose(past, np.broadcast_to(found.of("areafrac_x")[0], past.shape), atol=1e-12)
    assert abs(found.of("bndrynorm")[..., 0]).max() < 1e-9
    # written again into its folder; a file of another is named
    hexcast(*arguments, cwd=tmp_path)
    (tmp_path / "case.eb/Level_0/other_H").write_text("")
    assert "other_H is in the folder" in hexcast(*arguments, cwd=tmp_path, ok=False)


def test_walls_on_lines_and_what_is_thinner_than_a_cell(tmp_path: Path) -> None:
    save(tmp_path / "block.stl", cuboid((1, 1, 1), (3, 3, 3)))
    save(tmp_path / "plate.stl", cuboid((-1, 1.53, -1), (5, 1.56, 5)))
    domain = ["--domain", "0,0,0,4,4,4", "--dims", "16,16,16", "--unit", "mm", "--backend", "cpu", "--export-flags", "0"]
    # between whole cells: the wall is that of the fluid's
    hexcast("mesh", "block.stl", *domain, "-o", "case.eb", cwd=tmp_path)
    found = Boundary(tmp_path / "case.eb")
    found.check()
    inside = np.zeros((16, 16, 16), bool)
    inside[4:12, 4:12, 4:12] = True
    np.testing.assert_array_equal(found.of("volfrac"), ~inside)
    assert found.of("bndryarea").sum() == 6 * 64 and found.of("bndryarea")[3, 5, 5] == 1
    np.testing.assert_array_equal(found.of("bndrynorm")[3, 5, 5], [1, 0, 0])
    np.testing.assert_array_equal(found.of("bndrycent")[3, 5, 5], [0.5, 0, 0])
    # a plate within a layer of cells stays tight: these are covered, and said
    said = hexcast("mesh", "plate.stl", *domain, "-o", "case.eb", cwd=tmp_path)
    assert "of 256 cut cells 256 are covered, with 225.280 cells of the fluid" in said
    found = Boundary(tmp_path / "case.eb")
    found.check()
    is_layer = np.broadcast_to((np.arange(16) == 6)[None, :, None], (16, 16, 16))
    np.testing.assert_array_equal(found.of("volfrac"), ~is_layer)


def test_what_has_no_boundary_is_refused(ball: Path) -> None:
    cells = ["--domain", "-2,-2,-2,2,2,2", "--dims", "8,8,8", "--backend", "cpu"]
    (ball / "lines.json").write_text('{"x": [-2, -1, 0, 0.5, 2], "y": [-2, 0, 2], "z": [-2, 0, 2]}')
    assert "AMReX holds equal ones only" in hexcast("mesh", "ball.stl", "--lines", "lines.json", "-o", "case.eb", cwd=ball, ok=False)
    save(ball / "open.stl", sphere(1.0, 2)[1:])
    assert "not closed" in hexcast("mesh", "open.stl", *cells, "-o", "case.eb", cwd=ball, ok=False)
    hexcast("mesh", "ball.stl", *cells, "-o", "m.hxc", cwd=ball)
    assert "does not know where surfaces cross" in hexcast("convert", "m.hxc", "case.eb", cwd=ball, ok=False)
    inner = ["--domain", "-0.2,-0.2,-0.2,0.2,0.2,0.2", "--dims", "8,8,8"]
    assert "no surface passes through the box" in hexcast("mesh", "ball.stl", *inner, "-o", "case.eb", cwd=ball, ok=False)
    assert not (ball / "case.eb").exists()
