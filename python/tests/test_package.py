"""The package agrees with the crate, its types, and its documentation."""

from __future__ import annotations

import importlib.metadata
import json
import re
import subprocess
import sys
import tarfile
from pathlib import Path

import hexcast
import pytest
import pyvista
from hexcast._options import GEOMETRY_KEYS, JOB_KEYS

from places import ROOT

PACKAGE = Path(hexcast.__file__).parent


def test_options_are_the_keys_of_the_job():
    """The schema of the report, which is made of the crate's types, has those of the job in it."""
    schema = json.loads((ROOT / "docs" / "report.schema.json").read_text())
    job = schema["$defs"]["Job"]["properties"]
    assert {"geometries", *JOB_KEYS} == set(job)
    assert {*GEOMETRY_KEYS} - {"source"} == set(schema["$defs"]["GeometryJob"]["properties"])


def test_versions_are_those_of_the_crate(spot):
    crate = re.search(r'^version = "(.+)"$', (ROOT / "Cargo.toml").read_text(), re.M)[1]
    assert hexcast.__version__ == crate == hexcast.mesh(spot, cells=5, backend="cpu").report["version"]


def test_the_types_are_right(tmp_path):
    """mypy checks the package, and what a caller may and may not write."""
    good = tmp_path / "good.py"
    good.write_text(
        """
import numpy as np
import hexcast
from numpy.typing import NDArray

mesh = hexcast.mesh(["a.stl", {"file": "b.stl", "flag": 3}], cells=64, padding={"cells": 2}, progress=True)
flags: NDArray[np.uint8] = mesh.box((0, 0, 0), mesh.dims)
x, y, z = mesh.lines
for first, end, part in mesh.slabs():
    flags = part
mesh.save("a.vti", compress=3)
try:
    hexcast.load("a.hxc")
except hexcast.Error as error:
    code: str = error.code
"""
    )
    bad = tmp_path / "bad.py"
    bad.write_text(
        """
import hexcast
hexcast.mesh("a.stl", cels=64)
hexcast.mesh("a.stl", cells="64")
hexcast.mesh("a.stl", axis="w")
hexcast.mesh("a.stl").flags = 3
hexcast.mesh("a.stl").save("a.vti", compress="much")
"""
    )
    words = [sys.executable, "-m", "mypy", "--strict", "--config-file=", f"--cache-dir={ROOT / 'target' / 'mypy'}"]
    words += [ROOT / "python" / "package" / "hexcast", good, bad]
    checked = subprocess.run(words, capture_output=True, text=True, timeout=300)
    wrong = re.findall(r"^(.+):(\d+): error", checked.stdout, re.M)
    assert [(Path(file).name, int(line)) for file, line in wrong] == [("bad.py", n) for n in range(3, 8)], checked.stdout


def test_the_wheel_is_for_all_versions_of_python():
    assert (PACKAGE / "py.typed").exists()
    assert [path.name for path in PACKAGE.glob("_hexcast.*.so")] == ["_hexcast.abi3.so"] or sys.platform == "win32"


def test_the_wheel_has_the_text_of_its_licences():
    files = {path.name: path for path in importlib.metadata.files("hexcast") if "licenses" in path.parts}
    for name in ("LICENSE-MIT", "LICENSE-APACHE"):
        assert files[name].read_text() == (ROOT / name).read_text() == (ROOT / "python" / name).read_text()


def test_the_source_distribution_has_what_it_needs_and_nothing_else(tmp_path):
    """It holds the crates, too, as they pack themselves, with the kernels that one of them has."""
    words = [Path(sys.executable).with_name("maturin"), "sdist", "--manifest-path", "python/Cargo.toml", "--out", tmp_path]
    subprocess.run(words, cwd=ROOT, check=True, capture_output=True, timeout=120)
    (file,) = tmp_path.iterdir()
    with tarfile.open(file) as archive:
        names = {name.split("/", 1)[1] for name in archive.getnames()}
    assert {"PKG-INFO", "src/lib.rs", "python/src/lib.rs", "package/hexcast/__init__.py", "LICENSE-MIT", "LICENSE-APACHE"} <= names
    folders = {name.split("/")[0] for name in names if "/" in name}
    assert folders == {"src", "crates", "python", "package", "docs", "examples"}
    assert {"crates/gpu/shaders/map.wgsl"} | {f"crates/{name}/src/lib.rs" for name in ["job", "core", "derived", "files", "gpu"]} <= names
    # the schema that the command prints, the documentation of the root of the crate, and the programs that it lists
    assert {name for name in names if name.startswith("docs/")} == {"docs/job.schema.json", "docs/rust.md"}
    assert all(name.endswith(".rs") for name in names if name.startswith("examples/"))


def test_no_gpu_and_one_in_software_are_no_warning(spot):
    """Warnings are errors in these tests; the report says what meshed."""
    report = hexcast.mesh(spot, cells=16).report
    assert report["findings"] == []
    assert (report["backend"] == "gpu") == (report["fallback"] is None)


def test_readme_runs(spot, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "part.stl").write_bytes(Path(spot).read_bytes())
    blocks = re.findall(r"```python\n(.+?)```", (ROOT / "python" / "README.md").read_text(), re.S)
    assert blocks
    for block in blocks:
        exec(compile(block, "README.md", "exec"), {})


PAGES = ["conformal", "distance", "export/README", "export/amrex", "export/openfoam", "fractions", "links", "refine", "scenes", "staggered", "tensors", "zarr"]


# cut cells of an example say what they lack
@pytest.mark.filterwarnings("ignore::hexcast.MeshWarning")
@pytest.mark.parametrize("page", PAGES)
def test_what_a_page_says_of_python_runs(page, spot, tmp_path, monkeypatch):
    """Blocks marked ``py``; those marked ``python`` read files of the command, and run with the solvers."""
    monkeypatch.chdir(tmp_path)
    for name in ("part.stl", "body.stl", "rotor.stl"):
        (tmp_path / name).write_bytes(Path(spot).read_bytes())
    pyvista.Sphere(radius=1.5).save(tmp_path / "tank.stl")
    pyvista.Cylinder(radius=1, height=4).triangulate().save(tmp_path / "pipe.stl")
    (tmp_path / "case").mkdir()
    given = set(tmp_path.rglob("*"))
    blocks = re.findall(r"```py\n(.+?)```", (ROOT / "docs" / f"{page}.md").read_text(), re.S)
    assert len(blocks) == 1
    names = {"hexcast": hexcast}
    exec(compile(blocks[0], page, "exec"), names)
    assert set(tmp_path.rglob("*")) - given
    if page == "scenes":
        assert (names["flags"] == names["scene"].mesh.flags).all()
