"""The scripts of examples/scale, run as a scheduler would, and held to their schemas."""

from __future__ import annotations

import json
import os
import subprocess

import kubernetes_validate
import yaml
from conftest import COMMAND, ROOT, SPOT, assert_same, hexcast

SCALE = ROOT / "examples" / "scale"


def job(folder):
    path = folder / "ship.toml"
    path.write_text(f'cells = 120\nbackend = "cpu"\nzarr = {{ shard_bytes = "32KiB" }}\n[[geometries]]\nfile = "{SPOT}"\n')
    return path


def test_the_slurm_array_makes_the_store_and_the_report_of_the_undivided_run(tmp_path):
    toml = job(tmp_path)
    path = f"{COMMAND.parent}:{os.environ['PATH']}"
    tasks = 5
    for task in [*range(1, tasks + 1), 2]:
        env = {**os.environ, "PATH": path, "SLURM_ARRAY_TASK_ID": str(task), "SLURM_ARRAY_TASK_COUNT": str(tasks)}
        words = [SCALE / "slurm_array.sh", toml, tmp_path / "ship.zarr"]
        subprocess.run(words, check=True, timeout=100, env={**env, "SLURM_CPUS_PER_TASK": "1", "SLURM_MEM_PER_NODE": "8192"})
    reports = sorted((tmp_path / "ship.zarr.reports").iterdir())
    assert len(reports) == tasks
    merged = json.loads(hexcast("merge", *reports))
    report, words = tmp_path / "whole.json", ["--job", toml, "-o", tmp_path / "whole.zarr", "--quiet"]
    hexcast("mesh", *words, "--axis", merged["ray_axis"], "--report", report)
    assert_same(tmp_path / "ship.zarr", tmp_path / "whole.zarr")
    times = ("seconds", "peak_bytes", "cells_per_second")
    expected = {key: value for key, value in json.loads(report.read_text()).items() if key not in times}
    assert {key: value for key, value in merged.items() if key not in times} == expected


def test_the_kubernetes_job_is_valid_and_its_pods_fill_a_bucket(server, tmp_path):
    manifest = yaml.safe_load((SCALE / "kubernetes_job.yaml").read_text())
    kubernetes_validate.validate(manifest, "1.31", strict=True)
    spec = manifest["spec"]
    container = spec["template"]["spec"]["containers"][0]
    variables = {of["name"]: of["value"] for of in container["env"] if "value" in of}
    assert variables["PARTS"] == str(spec["completions"])
    toml, completions = job(tmp_path), 4
    given = {"PATH": f"{COMMAND.parent}:{os.environ['PATH']}", "JOB": str(toml), "PARTS": str(completions)}
    # what Kubernetes says of the limits of the container
    of_limits = {of["name"]: of["valueFrom"]["resourceFieldRef"]["resource"] for of in container["env"] if "valueFrom" in of}
    assert of_limits == {"CPUS": "limits.cpu", "MEMORY": "limits.memory"}
    given = {**given, "CPUS": "1", "MEMORY": str(8 << 30)}
    for index in reversed(range(completions)):
        env = {**variables, **server.env, **given, "JOB_COMPLETION_INDEX": str(index)}
        subprocess.run([*container["command"], *container["args"]], check=True, timeout=100, env=env)
    hexcast("mesh", "--job", toml, "-o", tmp_path / "whole.zarr", "--quiet")
    assert_same(server.root / "meshes" / "ship.zarr", tmp_path / "whole.zarr")
