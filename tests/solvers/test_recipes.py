"""The recipes of docs/export for arrays: flow and diffusion through spheres in a cubic array."""

from __future__ import annotations

import re
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import DEBIAN_PYTHON, ROOT, hexcast, run, save, sphere

#: Part of the space that the spheres fill, and the drag of one over that of Stokes (Zick and Homsy 1982).
FILLED = 0.216
DRAG = 7.442
#: Diffusivity around them, relative to that without them (Rayleigh 1892).
DIFFUSIVITY = 0.7068


def recipe(page: str, language: str) -> tuple[list[str], str]:
    """Arguments of the command of a page, and its program."""
    text = (ROOT / f"docs/export/{page}.md").read_text()
    [command] = re.findall(r"^    hexcast (.*)$", text, re.MULTILINE)
    [program] = re.findall(rf"```{language}\n(.*?)```", text, re.DOTALL)
    return command.split(), program


def number_of(what: str, said: str) -> float:
    return float(re.search(rf"^{what} (\S+)", said, re.MULTILINE)[1])


def save_sphere(folder: Path) -> None:
    save(folder / "sphere.stl", sphere((FILLED * 3 / 4 / np.pi) ** (1 / 3), 4) + 0.5)


def test_lbmpy(tmp_path: Path) -> None:
    save_sphere(tmp_path)
    arguments, program = recipe("lbmpy", "python")
    hexcast(*arguments, cwd=tmp_path)
    (tmp_path / "drag.py").write_text(program)
    drag = number_of("drag", run(sys.executable, "drag.py", "array.npy", cwd=tmp_path))
    print("lbmpy", drag)
    assert drag == pytest.approx(DRAG, rel=0.03)


def test_palabos(tmp_path: Path) -> None:
    save_sphere(tmp_path)
    arguments, program = recipe("palabos", "cpp")
    hexcast(*arguments, cwd=tmp_path)
    shutil.copytree("/usr/include/palabos", tmp_path / "palabos")
    header = tmp_path / "palabos/multiGrid/coarseGridProcessors3D.hh"
    lines = header.read_text().split("\n")
    assert ".assign(" in lines[158]
    lines[158] = lines[158].replace(".assign(", ".insert(")
    header.write_text("\n".join(lines))
    (tmp_path / "drag.cpp").write_text(program)
    [shell] = re.findall(r"```sh\n(.*?)```", (ROOT / "docs/export/palabos.md").read_text(), re.DOTALL)
    drag = number_of("drag", run("sh", "-ec", shell, cwd=tmp_path))
    print("Palabos", drag)
    assert drag == pytest.approx(DRAG, rel=0.03)


def test_taufactor(tmp_path: Path) -> None:
    save_sphere(tmp_path)
    arguments, program = recipe("taufactor", "python")
    hexcast(*arguments, cwd=tmp_path)
    (tmp_path / "diffusivity.py").write_text(program)
    modules = f"PYTHONPATH={Path(sys.prefix) / 'apart'}"
    said = run("env", modules, DEBIAN_PYTHON, "diffusivity.py", "array.npy", cwd=tmp_path)
    diffusivity = number_of("relative diffusivity", said)
    print("taufactor", diffusivity)
    assert diffusivity == pytest.approx(DIFFUSIVITY, rel=0.03)
