"""Errors have a code, a sentence and what to do; warnings are warnings."""

from __future__ import annotations

import errno
import pickle
import re
import warnings
from pathlib import Path

import numpy as np
import pytest

import hexcast
from hexcast.shapes import box

CUBE = box((0, 0, 0), (1, 1, 1))

CASES = [
    ((CUBE,), {"cels": 3}, "job-value", 'no option "cels"; the nearest is "cells"'),
    ((CUBE,), {"Axis": "x"}, "job-value", 'no option "Axis"; the nearest is "axis"'),
    (({"source": CUBE, "prority": 3},), {}, "job-value", 'no geometry key "prority"; the nearest is "priority"'),
    (({"geometries": [CUBE], "unitt": "mm"},), {}, "job-value", 'no key "unitt"; the nearest is "unit"'),
    (({"file": "a.stl", "source": CUBE},), {}, "job-conflict", "needs either file or source"),
    (({"flag": 2},), {}, "job-conflict", "needs either file or source"),
    (("nothing.stl",), {}, "io", "nothing.stl"),
    ((".",), {}, "io", "is a folder"),
    (("nothing.toml",), {}, "io", "nothing.toml"),
    (([],), {}, "job-empty", "no geometry"),
    ((CUBE,), {"cells": 1.5}, "job-value", "cells"),
    ((CUBE,), {"cells": 0}, "job-value", "cells"),
    ((CUBE,), {"cells": 10, "dims": (1, 2, 3)}, "job-conflict", "cells"),
    ((CUBE,), {"cell_size": float("nan")}, "job-value", "cell_size is nan"),
    ((CUBE,), {"cell_size": object()}, "job-value", "object is neither"),
    ((CUBE,), {"axis": "w"}, "job-value", "axis"),
    ((CUBE,), {"part": "4/3"}, "job-value", "part"),
    ((CUBE,), {"window": (0, 0, 0, 999, 1, 1)}, "job-value", "window ends at cell 999"),
    ((CUBE,), {"cells": 250_000, "max_cells": 10**17, "max_memory": "100MB"}, "memory", "memory"),
    ((CUBE,), {"backend": "gpu", "adapter": "no such one"}, "no-adapter", "no such one"),
    ((CUBE,), {"progress": 3}, "job-value", "progress is 3"),
    (({"source": CUBE, "flag": 256},), {}, "job-value", "flag"),
]


@pytest.mark.parametrize(("arguments", "options", "code", "message"), CASES)
def test_an_error_says_what_is_wrong(arguments, options, code, message):
    with pytest.raises(hexcast.Error) as caught:
        hexcast.mesh(*arguments, **options)
    error = caught.value
    assert error.code == code
    assert message in error.message
    assert str(error) == (f"{error.message} ({error.hint})" if error.hint else error.message)


@pytest.mark.parametrize(
    ("what", "options", "kind"),
    [
        ("nothing.stl", {}, FileNotFoundError),
        ({"source": "nothing.stl"}, {}, FileNotFoundError),
        (["nothing.stl"], {}, FileNotFoundError),
        ("nothing.toml", {}, FileNotFoundError),
        (".", {}, OSError),
        (CUBE, {"spill": "/nowhere"}, OSError),
        (b"no surface", {}, ValueError),
        (CUBE, {"cells": 0}, ValueError),
        (CUBE, {"cells": 10, "dims": (1, 2, 3)}, ValueError),
        (CUBE, {"threads": 0}, ValueError),
        (CUBE, {"cels": 3}, TypeError),
        (CUBE, {"cells": "64"}, TypeError),
        (CUBE, {"fractions": 3}, TypeError),
        (CUBE, {"cell_size": object()}, TypeError),
        ({"source": CUBE, "flag": "3"}, {}, TypeError),
        (3, {}, TypeError),
        (CUBE, {"cells": 250_000, "max_cells": 10**17, "max_memory": "100MB"}, MemoryError),
        (CUBE, {"backend": "gpu", "adapter": "no such one"}, RuntimeError),
    ],
)
def test_errors_are_those_of_python_in_its_words(what, options, kind):
    with pytest.raises(kind) as caught:
        hexcast.mesh(what, **{"backend": "cpu", **options})
    error = caught.value
    assert isinstance(error, hexcast.Error)
    assert not re.search(r"--[a-z]|struct |TOML|\bu32\b|\bu8\b|\bf64\b|sequence|invalid type: map", str(error)), str(error)
    again = pickle.loads(pickle.dumps(error))
    assert (type(again), str(again), again.code) == (type(error), str(error), error.code)
    if kind is FileNotFoundError:
        assert error.errno == errno.ENOENT


@pytest.mark.parametrize("read", [hexcast.load, hexcast.surface])
def test_a_missing_file_is_not_found(read):
    with pytest.raises(FileNotFoundError, match="there is no such file"):
        read("nothing.stl")


def test_errors_survive_pickle():
    error = pickle.loads(pickle.dumps(hexcast.Error("a sentence", "io", "a hint")))
    assert (error.message, error.code, error.hint) == ("a sentence", "io", "a hint")
    assert isinstance(error, OSError)


def test_every_code_makes_an_error():
    from hexcast._hexcast import error_codes

    codes = error_codes()
    assert {code for *_, code, _ in CASES} <= set(codes)
    assert "stl-truncated" in codes


def test_a_job_file_with_an_error_names_the_place(tmp_path):
    job = tmp_path / "job.toml"
    job.write_text("cells = 3\nunknown = 4\n")
    with pytest.raises(hexcast.Error) as caught:
        hexcast.mesh(job)
    assert caught.value.code == "job-value"
    assert str(job) in caught.value.message
    assert "line 2" in caught.value.message
    job.write_bytes(b"\xff\xfe")
    with pytest.raises(hexcast.Error, match="cannot be read"):
        hexcast.mesh(job)


def test_options_take_the_place_of_those_of_the_job():
    job = {"geometries": [CUBE], "cells": 20, "backend": "cpu", "axis": None}
    assert hexcast.mesh(job).dims == (20, 20, 20)
    assert hexcast.mesh(job, dims=(3, 4, 5)).dims == (3, 4, 5)
    assert hexcast.mesh(job, cell_size=np.float32(0.5), padding={"cells": 1}).dims == (4, 4, 4)
    assert hexcast.mesh(job, cells=None).dims == (20, 20, 20)
    assert job == {"geometries": [CUBE], "cells": 20, "backend": "cpu", "axis": None}


def test_warnings_of_the_report_are_issued_where_the_caller_is():
    vertices, faces = CUBE
    with warnings.catch_warnings(record=True) as issued:
        warnings.simplefilter("always")
        mesh = hexcast.mesh((vertices, faces[2:]), cells=20, backend="cpu")
    assert [str(warning.message) for warning in issued] == mesh.report["warnings"] != []
    assert [warning.message.finding for warning in issued] == mesh.report["findings"]
    assert {(warning.category, warning.filename) for warning in issued} == {(hexcast.MeshWarning, __file__)}


def test_a_warning_has_the_finding_and_its_remedy_helps():
    vertices, faces = CUBE
    plate = (vertices * (1, 1, 0.01) + (0, 0, 0.52), faces)
    job = {"geometries": [CUBE, plate], "dims": (10, 10, 10), "backend": "cpu"}
    with pytest.warns(hexcast.MeshWarning, match="got no cell") as issued:
        hexcast.mesh(job)
    (warning,) = issued
    finding = warning.message.finding
    assert (finding["code"], finding["geometry"]["index"], finding["axis"]) == ("no-cell-thin", 1, "z")
    assert pickle.loads(pickle.dumps(warning.message)).finding == finding
    # the patch has the keys of the job
    (remedy,) = finding["remedies"]
    settings = remedy["patch"]["geometries"]["1"]
    assert settings == {"fill": "separating"}
    # it is kept, and thicker than it is
    found = hexcast.mesh({**job, "geometries": [CUBE, {"source": plate, **settings}]}).report["findings"]
    assert [of["code"] for of in found] == ["volume-filled"]


def test_flags_that_do_not_fit_are_an_error_and_the_mesh_stays():
    mesh = hexcast.mesh(CUBE, dims=(1, 250_000, 250_000), axis="z", backend="cpu", window=(0, 0, 0, 1, 2, 250_000))
    assert mesh.box((0, 0, 0), (1, 2, 3)).all()


@pytest.mark.parametrize("name", ["part.npy", "link.npy", "inner/../part.npy"])
def test_a_mesh_is_not_saved_over_its_surface(tmp_path, name):
    """The reader looks at the bytes of a file, whatever it is called."""
    part = tmp_path / "part.npy"
    (tmp_path / "inner").mkdir()
    ascii_facet = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
    part.write_text(f"solid s\n{ascii_facet}endsolid s\n")
    (tmp_path / "link.npy").hardlink_to(part)
    before = part.read_bytes()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        mesh = hexcast.mesh(str(part), domain=(0, 0, 0, 1, 1, 1), cells=4, backend="cpu")
    with pytest.raises(hexcast.Error, match="an input of the mesh") as refused:
        mesh.save(tmp_path / name)
    assert refused.value.code == "job-conflict"
    assert part.read_bytes() == before
    mesh.save(tmp_path / "other.npy")


def test_the_default_limit_is_what_the_container_leaves():
    available, meminfo = hexcast._hexcast.available_bytes(), Path("/proc/meminfo").read_text()
    of_system = next(1024 * int(line.split()[1]) for line in meminfo.splitlines() if line.startswith("MemAvailable:"))
    assert 0 < available < 1.2 * of_system
