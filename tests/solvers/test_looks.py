"""Formats to look at: the cells by readers of their own."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest
import trimesh
from conftest import Model, cuboid, hexcast, save


class Vox:
    """A reader of .vox, after the description of the format."""

    def __init__(self, path: Path) -> None:
        data = path.read_bytes()
        assert data[:4] == b"VOX " and data[8:12] == b"MAIN"
        n, n_children = struct.unpack("<2I", data[12:20])
        assert (n, n_children) == (0, len(data) - 20)
        self.models: list[tuple[tuple[int, ...], np.ndarray]] = []
        self.transforms: dict[int, tuple[int, tuple[int, ...]]] = {}
        self.groups: dict[int, list[int]] = {}
        self.shapes: dict[int, int] = {}
        self.palette: np.ndarray | None = None
        at = 20
        while at < len(data):
            name, (n, n_children) = data[at : at + 4], struct.unpack("<2I", data[at + 4 : at + 12])
            assert n_children == 0
            self.content, self.at = data[at + 12 : at + 12 + n], 0
            getattr(self, "read_" + name.decode())()
            at += 12 + n
        assert at == len(data)

    def words(self, n: int) -> tuple[int, ...]:
        self.at += 4 * n
        return struct.unpack(f"<{n}i", self.content[self.at - 4 * n : self.at])

    def text(self) -> str:
        [n] = self.words(1)
        self.at += n
        return self.content[self.at - n : self.at].decode()

    def attributes(self) -> dict[str, str]:
        return {self.text(): self.text() for _ in range(self.words(1)[0])}

    def read_SIZE(self) -> None:
        self.size = self.words(3)

    def read_XYZI(self) -> None:
        [n] = self.words(1)
        voxels = np.frombuffer(self.content, np.uint8, offset=4).reshape(n, 4)
        self.models.append((self.size, voxels))

    def read_nTRN(self) -> None:
        [node] = self.words(1)
        self.attributes()
        child, _, _, frames = self.words(4)
        assert frames == 1
        to = self.attributes().get("_t", "0 0 0")
        self.transforms[node] = child, tuple(int(word) for word in to.split())

    def read_nGRP(self) -> None:
        [node] = self.words(1)
        self.attributes()
        self.groups[node] = list(self.words(self.words(1)[0]))

    def read_nSHP(self) -> None:
        [node] = self.words(1)
        self.attributes()
        n, model = self.words(2)
        assert n == 1
        self.attributes()
        self.shapes[node] = model

    def read_RGBA(self) -> None:
        self.palette = np.frombuffer(self.content, np.uint8).reshape(256, 4)

    def cells(self, shape: tuple[int, ...]) -> np.ndarray:
        """Colours of all cells of the scene."""
        found = np.zeros(shape, np.uint8)
        group, to = self.transforms[0]
        assert to == (0, 0, 0)
        for child in self.groups[group]:
            shape_node, to = self.transforms[child]
            size, voxels = self.models[self.shapes[shape_node]]
            assert max(size) <= 256 and (voxels[:, :3] < size).all()
            places = voxels[:, :3] + np.array(to) - np.array(size) // 2
            assert (found[tuple(places.T)] == 0).all()
            found[tuple(places.T)] = voxels[:, 3]
        return found


def test_vox(model: Model) -> None:
    if model.is_graded:
        assert "cells differ in size" in hexcast("convert", "m.hxc", "m.vox", cwd=model.folder, ok=False)
        return
    hexcast("convert", "m.hxc", "m.vox", cwd=model.folder)
    read = Vox(model.folder / "m.vox")
    np.testing.assert_array_equal(read.cells(model.flags.shape), model.flags)
    assert read.palette is not None and len({tuple(read.palette[flag - 1]) for flag in (1, 2, 9)}) == 3
    assert "colour 0" in hexcast("convert", "m.hxc", "m.vox", "--export-flags", "0,1", cwd=model.folder, ok=False)


def test_vox_of_several_models(tmp_path: Path) -> None:
    save(tmp_path / "a.stl", cuboid((0, 0, 0), (600, 7, 3)))
    save(tmp_path / "b.stl", cuboid((270, 0, 0), (280, 300, 259)))
    arguments = ["a.stl", "b.stl", "--cell-size", "1", "--backend", "cpu", "-o", "m.vox", "-o", "m.npy", "--axis-order", "xyz"]
    hexcast("mesh", *arguments, cwd=tmp_path)
    flags = np.load(tmp_path / "m.npy")
    read = Vox(tmp_path / "m.vox")
    np.testing.assert_array_equal(read.cells(flags.shape), flags)
    assert len(read.models) == 6


def test_binvox(model: Model) -> None:
    if model.is_graded:
        assert "cells differ in size" in hexcast("convert", "m.hxc", "m.binvox", cwd=model.folder, ok=False)
        return
    hexcast("convert", "m.hxc", "m.binvox", "--export-flags", "2,9", cwd=model.folder)
    read = trimesh.load(model.folder / "m.binvox")
    expected = np.zeros((16, 16, 16), bool)
    nx, ny, nz = model.flags.shape
    expected[:nx, :ny, :nz] = model.of(2, 9)
    np.testing.assert_array_equal(read.matrix, expected)
    header = (model.folder / "m.binvox").read_bytes().split(b"data\n")[0].decode()
    assert header == "#binvox 1\ndim 16 16 16\ntranslate 0.0 0.0 0.0\nscale 8.0\n"


def test_surfaces(model: Model) -> None:
    """Each flag is a closed surface with the volume of its cells, in its place, for a reader of others."""
    lines = model.lines
    wanted = {flag: model.volumes[model.of(flag)].sum() for flag in (1, 2, 9)}
    hexcast("convert", "m.hxc", "m.glb", cwd=model.folder)
    scene = trimesh.load(model.folder / "m.glb", process=False)
    assert len(scene.geometry) == len(wanted)
    for node in scene.graph.nodes_geometry:
        place, name = scene.graph[node]
        mesh = scene.geometry[name]
        flag = mesh.metadata["flag"]
        assert name == {1: "base", 2: "block", 9: "1 bar"}[flag]
        assert mesh.is_watertight and mesh.is_winding_consistent
        metres = np.cbrt(np.linalg.det(place[:3, :3]))
        assert mesh.volume == pytest.approx(wanted[flag], rel=1e-4)
        cells = np.argwhere(model.flags == flag)
        low, high = (np.array([of[at] for of, at in zip(lines, ends)]) for ends in (cells.min(0), cells.max(0) + 1))
        # y is up
        turned = np.array([[low[0], low[2], -high[1]], [high[0], high[2], -low[1]]]) * metres
        np.testing.assert_allclose(mesh.copy().apply_transform(place).bounds, turned, rtol=1e-5, atol=1e-6 * metres)
    for ascii in [], ["--ascii"]:
        hexcast("convert", "m.hxc", "m.stl", *ascii, cwd=model.folder)
        read = trimesh.load(model.folder / "m.stl")
        parts = read.geometry.values() if ascii else [read]
        assert sum(part.volume for part in parts) == pytest.approx(sum(wanted.values()), rel=1e-4)


def test_surfaces_that_exceed_the_memory_are_refused(tmp_path: Path) -> None:
    save(tmp_path / "plate.stl", cuboid((0, 0, 0), (1000, 1000, 1)))
    small = ["--cell-size", "1", "--backend", "cpu", "--max-memory", "70MB"]
    hexcast("mesh", "plate.stl", *small, "-o", "m.npz", cwd=tmp_path)
    said = hexcast("mesh", "plate.stl", *small, "-o", "m.glb", cwd=tmp_path, ok=False)
    # 2,004,000 faces
    assert "surfaces take up to 76.4" in said and "--max-memory" in said
    assert not (tmp_path / "m.glb").exists()
