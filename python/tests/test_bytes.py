"""The bytes of every format are those of the native command."""

from __future__ import annotations

import json
import warnings
import zipfile
from pathlib import Path

import numpy as np
import pytest
import xarray
import zarr

import hexcast

#: A name, the command's words after the file, and the same as options.
JOBS = [
    ("plain", ["--cells", 60], {"cells": 60}),
    ("along-x", ["--cells", 50, "--axis", "x"], {"cells": 50, "axis": "x"}),
    (
        "padded",
        ["--dims", "40,31,22", "--padding-cells", "2,1,3", "--unit", "mm"],
        {"dims": (40, 31, 22), "padding": {"cells": [2, 1, 3]}, "unit": "mm"},
    ),
    (
        "domain",
        ["--domain", "-0.5,-0.5,-0.5,0.5,0.5,0.75", "--cell-size", "0.02,0.025,0.05", "--rule", "nonzero"],
        {"domain": np.array([-0.5, -0.5, -0.5, 0.5, 0.5, 0.75]), "cell_size": [0.02, 0.025, 0.05], "rule": "nonzero"},
    ),
    (
        "padded-domain",
        ["--domain", "-0.5,-0.5,-0.5,0.5,0.5,0.75", "--cells", 30, "--padding-length", "0.1,0.2,0"],
        {"domain": (-0.5, -0.5, -0.5, 0.5, 0.5, 0.75), "cells": 30, "padding": {"length": (0.1, 0.2, 0)}},
    ),
    ("walls", ["--cells", 40, "--fill", "separating"], {"cells": np.int64(40), "fill": "separating"}),
    ("gaps", ["--cells", 40, "--close-gaps", 3], {"cells": 40, "close_gaps": 3}),
    ("window", ["--cells", 60, "--window", "3,4,5,30,28,16"], {"cells": 60, "window": (3, 4, 5, 30, 28, 16)}),
    ("part", ["--cells", 60, "--part", "2/3"], {"cells": 60, "part": "2/3"}),
]


def bytes_below(path: Path) -> dict[str, bytes]:
    """All files of a folder, or the file itself."""
    files = sorted(path.rglob("*")) if path.is_dir() else [path]
    return {str(file.relative_to(path)): file.read_bytes() for file in files if file.is_file()}


# one of the surfaces is open, which meshes say
@pytest.mark.filterwarnings("ignore::hexcast.MeshWarning")
@pytest.mark.parametrize(("name", "words", "options"), JOBS, ids=[name for name, *_ in JOBS])
@pytest.mark.parametrize("model", ["spot", "part"])
def test_files_are_those_of_the_command(model, name, words, options, request, command, tmp_path):
    file = request.getfixturevalue(model)
    # of a part the command writes its shards of the store of the whole, which are not cut as other parts are
    endings = ("npy", "raw", "vti", "hxc") if "part" in options else ("npy", "raw", "vti", "hxc", "zarr")
    names = [f"mesh.{ending}" for ending in endings]
    native, ours = tmp_path / "native", tmp_path / "ours"
    native.mkdir()
    ours.mkdir()
    outputs = [word for name in names for word in ("-o", native / name)]
    command("mesh", file, *words, "--backend", "cpu", *outputs)
    mesh = hexcast.mesh(file, backend="cpu", **options)
    for name in names:
        mesh.save(ours / name)
    assert bytes_below(ours) == bytes_below(native)
    flags = np.load(native / "mesh.npy")
    assert mesh.flags.dtype == np.uint8
    assert mesh.flags.flags.c_contiguous
    np.testing.assert_array_equal(mesh.flags, flags)
    assert mesh.flags.tobytes() == (native / "mesh.raw").read_bytes()


def test_files_of_solvers_are_those_of_the_command(spot, command, tmp_path):
    words = ["--cells", 20, "--unit", "m", "--padding-cells", 2, "--backend", "cpu"]
    options = {"cells": 20, "unit": "m", "padding": {"cells": 2}, "backend": "cpu"}
    native, ours = tmp_path / "native", tmp_path / "ours"
    for name, more, given in [
        ("whole/a.foam", [], {}),
        ("text/a.foam", ["--ascii", "--export-flags", "0,1"], {"ascii": True, "export_flags": [0, 1]}),
        ("solids/a.foam", ["--patches", "solid", "--open-patches", "spot"], {"patches": "solid", "open_patches": ["spot"]}),
        ("a.inp", [], {}),
        ("a.msh", [], {}),
        ("a.xdmf", ["--compress", 3], {"compress": 3}),
        ("geometry.xml", [], {}),
        ("a.nrrd", ["--compress", "none"], {"compress": "none"}),
        ("a.vox", [], {}),
    ]:
        for folder in (native, ours):
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
        command("mesh", f"{spot}:name=spot", *words, *more, "-o", native / name)
        hexcast.mesh([{"file": spot, "name": "spot"}], **options, walls="patches" in given).save(ours / name, **given)
    assert bytes_below(ours) == bytes_below(native)
    mesh = hexcast.mesh(spot, **options)
    for name, given, what in [
        ("a.foam", {"patches": "solid"}, "does not know"),
        ("a.foam", {"bits": True}, "bits"),
        ("a.eb", {}, "does not know where surfaces cross"),
        ("a.npy", {"export_flags": [1]}, "export_flags"),
    ]:
        with pytest.raises(hexcast.Error, match=what):
            mesh.save(tmp_path / name, **given)


def test_cut_cells_are_those_of_the_command_and_say_what_they_lack(spot, command, tmp_path):
    native, ours = tmp_path / "native", tmp_path / "ours"
    for folder in (native, ours):
        folder.mkdir()
    words = ["--cells", 20, "--unit", "m", "--padding-cells", 2, "--backend", "cpu", "--export-flags", 0, "--cut"]
    command("mesh", spot, *words, "-o", native / "a.foam", "-o", native / "a.eb")
    cut = {"fluid": 0, "boundary": True}
    mesh = hexcast.mesh(spot, cells=20, unit="m", padding={"cells": 2}, backend="cpu", cut_cells=cut)
    for name in ("a.foam", "a.eb"):
        with pytest.warns(hexcast.MeshWarning, match=f"{name}: "):
            mesh.save(ours / name)
    assert bytes_below(ours) == bytes_below(native)
    with pytest.raises(hexcast.Error, match="cut cells are those of one fluid"):
        hexcast.mesh([spot, {"file": spot, "flag": 3}], cells=8, backend="cpu", cut_cells={})
    with pytest.raises(hexcast.Error, match="cells are cut of a whole box"):
        hexcast.mesh(spot, cells=8, backend="cpu", cut_cells={}, window=(0, 0, 0, 2, 2, 2))


def test_a_job_file_is_that_of_the_command(spot, command, tmp_path):
    job = tmp_path / "job.toml"
    (tmp_path / "cow.stl").write_bytes(Path(spot).read_bytes())
    job.write_text(
        """
        cells = 30
        unit = "m"
        padding = { cells = 2 }
        [[geometries]]
        file = "cow.stl"
        flag = 7
        name = "cow"
        [[geometries]]
        file = "cow.stl"
        scale = 0.5
        translate = [0.1, 0, 0.05]
        priority = -1
        """
    )
    command("mesh", "--job", job, "--cells", 45, "--backend", "cpu", "-o", tmp_path / "mesh.hxc", "--compress=none")
    mesh = hexcast.mesh(job, cells=45, backend="cpu")
    mesh.save(tmp_path / "ours.hxc", compress="none")
    assert (tmp_path / "ours.hxc").read_bytes() == (tmp_path / "mesh.hxc").read_bytes()
    assert mesh.names == {7: "cow", 2: "cow"}
    # the same as a dict, and what the report has as its job
    job = json.loads(json.dumps(mesh.report["job"]))
    np.testing.assert_array_equal(hexcast.mesh(job).flags, mesh.flags)


def test_the_report_is_that_of_the_command(spot, command, tmp_path):
    command("mesh", spot, "--cells", 50, "--backend", "cpu", "--certify", "--report", tmp_path / "report.json")
    native = json.loads((tmp_path / "report.json").read_text())
    ours = hexcast.mesh(spot, cells=50, backend="cpu", certify=True).report
    for report in (native, ours):
        for key in ("seconds", "cells_per_second", "peak_bytes"):
            report.pop(key)
    assert ours == native


def test_packed_bits_and_levels(spot, command, tmp_path):
    options = ["--bits", "--compress=3", "-o", tmp_path / "a.npy", "-o", tmp_path / "a.raw", "-o", tmp_path / "a.vti"]
    command("mesh", spot, "--cells", 30, "--backend", "cpu", *options)
    mesh = hexcast.mesh(spot, cells=30, backend="cpu")
    for ending, choice in (("npy", {"bits": True}), ("raw", {"bits": True}), ("vti", {"compress": 3})):
        mesh.save(tmp_path / f"b.{ending}", **choice)
        assert (tmp_path / f"b.{ending}").read_bytes() == (tmp_path / f"a.{ending}").read_bytes()


def test_both_backends_have_the_same_bytes(spot):
    meshes = [hexcast.mesh(spot, cells=70, backend=backend) for backend in ("cpu", "gpu", "gpu")]
    assert [mesh.report["backend"] for mesh in meshes] == ["cpu", "gpu", "gpu"]
    print("adapter:", meshes[1].report["adapter"])
    np.testing.assert_array_equal(meshes[0].flags, meshes[1].flags)
    np.testing.assert_array_equal(meshes[0].flags, meshes[2].flags)
    # the device that was opened for one mesh is there for the next
    assert meshes[1].report["seconds"]["device"] > 0
    assert meshes[2].report["seconds"]["device"] == 0


def test_a_column_file_is_read_back(spot, tmp_path):
    mesh = hexcast.mesh({"file": spot, "flag": 9, "name": "cow"}, cells=40, unit="mm", backend="cpu")
    mesh.save(tmp_path / "mesh.hxc")
    back = hexcast.load(tmp_path / "mesh.hxc")
    np.testing.assert_array_equal(back.flags, mesh.flags)
    assert (back.dims, back.unit, back.names) == (mesh.dims, "mm", {9: "cow"})
    assert back.report["runs"] == mesh.report["runs"]
    with pytest.raises(hexcast.Error) as caught:
        hexcast.load(spot)
    assert caught.value.code == "columns-corrupt"


def test_files_are_replaced_as_a_whole_or_not_at_all(spot, tmp_path):
    mesh = hexcast.mesh(spot, cells=20, backend="cpu")
    for ending in ("npy", "raw", "vti", "hxc", "zarr", "zarr.zip"):
        path = tmp_path / f"mesh.{ending}"
        mesh.save(path)
        first = bytes_below(path)
        mesh.save(path)
        assert bytes_below(path) == first
    with pytest.raises(hexcast.Error, match="no format has the extension"):
        mesh.save(tmp_path / "mesh.xyz")
    with pytest.raises(hexcast.Error, match="no such file|cannot be written"):
        mesh.save(tmp_path / "nowhere" / "mesh.npy")
    (tmp_path / "folder.zarr").mkdir()
    (tmp_path / "folder.zarr" / "mine").write_text("kept")
    with pytest.raises(hexcast.Error, match="is not a Zarr folder"):
        mesh.save(tmp_path / "folder.zarr")
    assert (tmp_path / "folder.zarr" / "mine").read_text() == "kept"
    assert not [path for path in tmp_path.iterdir() if path.name.startswith(".")]


@pytest.mark.parametrize(
    "words", [["--cells", 90, "--zarr-chunks", "16,8,8", "--zarr-shards", "32,32,16"], ["--graded", 0.05]]
)
def test_an_archive_of_a_store_is_a_store_with_the_same_files(spot, command, tmp_path, words):
    folder, archive, npy, solid = (tmp_path / f"mesh.{ending}" for ending in ("zarr", "zarr.zip", "npy", "solid.zarr.zip"))
    outputs = [word for path in (folder, archive, npy) for word in ("-o", path)]
    command("mesh", spot, *words, "--backend", "cpu", "--unit", "mm", *outputs, "--fractions", solid)
    with zipfile.ZipFile(archive) as opened:
        stored = {entry.filename: opened.read(entry) for entry in opened.infolist()}
        # readers find a chunk in an entry by its place
        assert {entry.compress_type for entry in opened.infolist()} == {zipfile.ZIP_STORED}
    files = {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    assert stored == files
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        mesh = xarray.open_zarr(zarr.storage.ZipStore(archive, mode="r"))
        fractions = xarray.open_zarr(zarr.storage.ZipStore(solid, mode="r"))
    np.testing.assert_array_equal(mesh.flag.values, np.load(npy))
    np.testing.assert_array_equal(mesh.x.values, fractions.x.values)
    assert 0.0 < fractions.solid.values[mesh.flag.values == 1].min() < 1.0


@pytest.mark.parametrize("rays", [None, 4])
def test_fractions_in_a_store_are_those_of_npy(spot, command, tmp_path, rays):
    dense, store = tmp_path / "solid.npy", tmp_path / "solid.zarr"
    how = ["--fraction-rays", rays] if rays else []
    for path, words in ((dense, []), (store, ["--zarr-chunks", "8,8,8"])):
        command("mesh", spot, "--cells", 40, "--backend", "cpu", "--unit", "mm", "--fractions", path, *words, *how)
    stored = xarray.open_zarr(store)
    assert stored.solid.dims == ("z", "y", "x")
    assert stored.solid.dtype == np.float32
    np.testing.assert_array_equal(stored.solid.values, np.load(dense))
    assert (len(stored.x), stored.x.attrs) == (stored.solid.shape[2], {"units": "mm"})
    assert "flags" not in stored.solid.attrs
    assert stored.solid.attrs.get("rays") == rays
