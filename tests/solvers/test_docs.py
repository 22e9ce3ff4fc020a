"""The examples of docs/export run as they are written."""

from __future__ import annotations

import re
import shlex

import pytest
from conftest import ROOT, cuboid, hexcast, rod, save, sphere

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


def test_every_page_is_in_the_table() -> None:
    table = (ROOT / "docs/export/README.md").read_text()
    assert len(PAGES) == 13
    assert all(f"]({page.name})" in table for page in PAGES)
