"""The examples of docs/export, and of what is measured at surfaces, run as they are written."""

from __future__ import annotations

import json
import re
import shlex
import sys

import pytest
from conftest import ROOT, cuboid, hexcast, rod, run, save, sphere

PAGES = sorted(page for page in (ROOT / "docs/export").glob("*.md") if page.name != "README.md")


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_an_example(page, tmp_path) -> None:
    save(tmp_path / "pipe.stl", rod(1, 4, 32))
    save(tmp_path / "beam.stl", cuboid((0, 0, 0), (20, 1, 1)))
    save(tmp_path / "sphere.stl", sphere(0.4, 3) + 0.5)
    (tmp_path / "case").mkdir()
    for job in re.findall(r"```toml\n(.*?)```", page.read_text(), re.DOTALL):
        (tmp_path / "board.toml").write_text(job)
    commands = re.findall(r"^    hexcast (.*)$", page.read_text(), re.MULTILINE)
    assert commands
    for command in commands:
        words = shlex.split(command)
        hexcast(*words, cwd=tmp_path)
        assert (tmp_path / words[words.index("-o") + 1]).exists()


@pytest.mark.parametrize("name", ["lines", "fractions", "links", "staggered", "conformal", "tensors", "distance"])
def test_what_is_measured_and_graded(name, tmp_path) -> None:
    """Commands, jobs and Python of a page; the commands have the last outputs that the Python reads."""
    page = (ROOT / f"docs/{name}.md").read_text()
    for file, part in {
        "board.stl": cuboid((0, 0, 0), (2.5, 1.5, 0.2)),
        "patch.stl": cuboid((0.5, 0.4, 0.2), (1.7, 1.1, 0.25)),
        "coil.stl": sphere(1, 3),
        "body.stl": sphere(1, 3),
        "block.stl": cuboid((-1.1, -1.1, -1.1), (1.1, 1.1, 1.1)),
        "ball.stl": sphere(1, 4),
    }.items():
        save(tmp_path / file, part)
    save(tmp_path / "plate.stl", [[(2, -1, 0), (2, 1, 0), (2, 1, 2)], [(2, -1, 0), (2, 1, 2), (2, -1, 2)]])
    (tmp_path / "lines.json").write_text(re.search(r'^    (\{"x": .*\})$', page, re.MULTILINE)[1] if name == "lines" else "")
    commands = [shlex.split(line) for line in re.findall(r"^    hexcast (.*)$", page, re.MULTILINE)]
    assert commands
    for command in commands:
        hexcast(*command, *([] if command[0] == "estimate" else ["--backend", "cpu"]), cwd=tmp_path)
    for job in re.findall(r"```toml\n(.*?)```", page, re.DOTALL):
        geometry = "" if "[[geometries]]" in job else '[[geometries]]\nfile = "body.stl"\n'
        (tmp_path / "job.toml").write_text(f'cells = 24\n{job}{geometry}' if geometry else job)
        hexcast("mesh", "--job", "job.toml", "--backend", "cpu", "--report", "report.json", cwd=tmp_path)
        assert json.loads((tmp_path / "report.json").read_text())["grading" if name == "lines" else name]
    # what the page reads beside its own file: a mesh of the same cells
    hexcast("mesh", "body.stl", "--cells", "256", "--backend", "cpu", "-o", "body.npz", cwd=tmp_path)
    if name == "links":
        hexcast(*commands[0][:-4], "--links", "links.h5", "--stencil", "D3Q19", "--backend", "cpu", cwd=tmp_path)
    snippets = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    assert snippets or name == "lines"
    for code in snippets:
        run(sys.executable, "-c", code, cwd=tmp_path)


def test_every_page_is_in_the_table() -> None:
    table = (ROOT / "docs/export/README.md").read_text()
    assert len(PAGES) == 15
    assert all(f"]({page.name})" in table for page in PAGES)
