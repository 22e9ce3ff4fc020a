"""What the tests of solvers share: surfaces from numbers, the command, an asymmetric model, and its flags as the command writes them."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
COMMAND = Path(os.environ.get("HEXCAST_COMMAND", ROOT / "target" / "debug" / "hexcast"))
#: The Python that Debian's packages are for: dolfinx, openEMS and PyTorch.
DEBIAN_PYTHON = "/usr/bin/python3"
ENVIRONMENT = {**os.environ, "WM_PROJECT_DIR": "/usr/share/openfoam", "OMP_NUM_THREADS": "2"}


def run(*command: object, cwd: Path, ok: bool = True) -> str:
    """Runs a program and returns what it printed; a failure that nobody expects ends the test with that text."""
    texts = [str(word) for word in command]
    done = subprocess.run(texts, cwd=cwd, env=ENVIRONMENT, text=True, capture_output=True, timeout=600, check=False)
    text = done.stdout + done.stderr
    assert (done.returncode == 0) == ok, f"{texts}: exit code {done.returncode}\n{text[-6000:]}"
    return text


def hexcast(*arguments: object, cwd: Path, ok: bool = True) -> str:
    return run(COMMAND, *arguments, cwd=cwd, ok=ok)


def save(path: Path, triangles: np.ndarray) -> None:
    """Writes a binary STL."""
    record = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    records = np.zeros(len(triangles), dtype=record)
    records["corners"] = triangles
    path.write_bytes(b"test".ljust(80) + np.uint32(len(triangles)).tobytes() + records.tobytes())


def save_solids(path: Path, solids: dict[str, np.ndarray]) -> None:
    """Writes an STL as text, with named solids."""
    lines = []
    for name, triangles in solids.items():
        lines.append(f"solid {name}")
        for facet in triangles:
            corners = "".join(f"   vertex {x!r} {y!r} {z!r}\n" for x, y, z in np.asarray(facet, float).tolist())
            lines.append(f" facet normal 0 0 0\n  outer loop\n{corners}  endloop\n endfacet")
        lines.append(f"endsolid {name}")
    path.write_text("\n".join(lines) + "\n")


def cuboid(low: tuple[float, ...], high: tuple[float, ...]) -> np.ndarray:
    corners = np.array([[x, y, z] for z in (low[2], high[2]) for y in (low[1], high[1]) for x in (low[0], high[0])])
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return np.array([corners[[q[0], q[i], q[i + 1]]] for q in quads for i in (1, 2)])


def plate(low: tuple[float, ...], high: tuple[float, ...]) -> np.ndarray:
    """A rectangle across z."""
    a, b, c, d = ((low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1]))
    return np.array([[(*p, low[2]) for p in facet] for facet in ((a, b, c), (a, c, d))])


def rod(radius: float, length: float, sides: int = 256) -> np.ndarray:
    """A cylinder along x from 0, its axis the x axis."""
    turns = 2 * np.pi * (np.arange(sides + 1) % sides) / sides
    y, z = radius * np.cos(turns), radius * np.sin(turns)
    triangles = []
    for i in range(sides):
        a, b = (0, y[i], z[i]), (0, y[i + 1], z[i + 1])
        c, d = (length, y[i + 1], z[i + 1]), (length, y[i], z[i])
        triangles += [[a, b, c], [a, c, d], [(0, 0, 0), b, a], [(length, 0, 0), d, c]]
    return np.array(triangles)


def sphere(radius: float, steps: int) -> np.ndarray:
    """An icosahedron, each facet cut in four so many times, as large as the sphere about 0."""
    t = (1 + 5**0.5) / 2
    corners = np.array([p for a, b in ((1, t), (-1, t), (1, -t), (-1, -t)) for p in ((a, b, 0), (0, a, b), (b, 0, a))])
    near = np.isclose(np.linalg.norm(corners[:, None] - corners[None], axis=-1), 2)
    faces = [(i, j, k) for i in range(12) for j in range(i) for k in range(j) if near[i, j] and near[j, k] and near[i, k]]
    facets = corners[np.array(faces)]
    inward = np.linalg.det(facets) < 0
    facets[inward] = facets[inward][:, ::-1]
    for _ in range(steps):
        a, b, c = facets[:, 0], facets[:, 1], facets[:, 2]
        ab, bc, ca = a + b, b + c, c + a
        # the middles in the order of their ends, so that neighbours have the same
        facets = np.concatenate([np.stack(part, 1) for part in ((2 * a, ab, ca), (ab, 2 * b, bc), (ca, bc, 2 * c), (ab, bc, ca))])
        facets /= np.linalg.norm(facets, axis=2, keepdims=True)
    volume = np.linalg.det(facets).sum() / 6
    return facets * radius * (4 / 3 * np.pi / volume) ** (1 / 3)


class Model:
    """Three cuboids that look different along every axis, on lines that are not equally spaced along two of them."""

    def __init__(self, folder: Path, graded: bool) -> None:
        self.folder = folder
        save(folder / "base.stl", cuboid((0, 0, 0), (8, 3, 2)))
        save(folder / "block.stl", cuboid((2, 0, 1), (5, 2, 4)))
        save(folder / "bar.stl", cuboid((6, 1, 1), (7, 5, 3)))
        x = [0, 0.75, 1.5, 2, 2.5, 3, 3.5, 4, 4.5, 5, 5.5, 6, 6.5, 7, 7.4, 8] if graded else np.arange(0, 8.25, 0.5).tolist()
        z = [0, 0.4, 1, 1.5, 2, 2.5, 3, 3.6, 4] if graded else np.arange(0, 4.25, 0.5).tolist()
        self.lines = [np.array(x), np.arange(0, 5.25, 0.5), np.array(z)]
        (folder / "lines.json").write_text(json.dumps(dict(zip("xyz", (list(axis) for axis in self.lines)))))
        geometries = ["base.stl:name=base", "block.stl:name=block,E=2e11,nu=0.3,density=8000", "bar.stl:flag=9,name=1 bar"]
        self.is_graded = graded
        self.options = ["--lines", "lines.json", "--unit", "mm", "--backend", "cpu"]
        hexcast("mesh", *geometries, *self.options, "-o", "m.hxc", "-o", "m.raw", cwd=folder)
        counts = [len(axis) - 1 for axis in self.lines]
        #: Flag of cell [x, y, z].
        self.flags = np.fromfile(folder / "m.raw", np.uint8).reshape(counts[::-1]).transpose(2, 1, 0)
        # not what hexcast says, but what the cuboids are
        centres = np.meshgrid(*[(axis[1:] + axis[:-1]) / 2 for axis in self.lines], indexing="ij")
        self.centres = np.stack(centres, -1)
        sizes = np.meshgrid(*[np.diff(axis) for axis in self.lines], indexing="ij")
        self.volumes = sizes[0] * sizes[1] * sizes[2]
        expected = np.zeros_like(self.flags)
        for flag, low, high in ((1, (0, 0, 0), (8, 3, 2)), (2, (2, 0, 1), (5, 2, 4)), (9, (6, 1, 1), (7, 5, 3))):
            expected[((self.centres > low) & (self.centres < high)).all(-1)] = flag
        assert (self.flags == expected).all()

    def of(self, *flags: int) -> np.ndarray:
        """Which cells have one of these flags."""
        return np.isin(self.flags, flags)


@pytest.fixture(params=[False, True], ids=["equal", "graded"])
def model(tmp_path: Path, request: pytest.FixtureRequest) -> Model:
    return Model(tmp_path, request.param)
