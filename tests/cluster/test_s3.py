"""Stores in a bucket: the bytes of a folder, whatever ends in the middle."""

from __future__ import annotations

import json
import signal
import subprocess
import time

from conftest import COMMAND, SPOT, assert_same, files, hexcast

MESH = ["mesh", SPOT, "--cells", 300, "--backend", "cpu", "--zarr-shards=64KiB", "--quiet"]
STORE = "s3://meshes/folder/mesh.zarr"


def start(server, part):
    words = [COMMAND, *map(str, MESH), "-o", STORE, "--part", part]
    return subprocess.Popen(words, env=server.env, stderr=subprocess.PIPE, text=True)


def wait_for_shards(server, process, n):
    """Waits until a process has written so many files more."""
    folder = server.root / "meshes"
    before = len(files(folder))
    while len(files(folder)) < before + n:
        assert process.poll() is None, "it ended before it could be disturbed"
        time.sleep(0.002)


def test_parts_fill_a_bucket_though_the_server_and_a_process_are_killed(server, tmp_path):
    whole = tmp_path / "whole.zarr"
    hexcast(*MESH, "-o", whole)
    first = start(server, "3/3")
    wait_for_shards(server, first, 20)
    server.kill()
    time.sleep(1)
    assert first.poll() is None, "requests are repeated while the server is away"
    server.start()
    assert first.wait(timeout=200) == 0, first.stderr.read()
    killed = start(server, "1/3")
    wait_for_shards(server, killed, 5)
    killed.send_signal(signal.SIGKILL)
    killed.wait()
    found = json.loads(hexcast("verify-store", STORE, "--json", env=server.env, code=9))
    assert len(found["missing"]) > 0
    assert found["wrong"] == found["unknown"] == []
    for part in ("2/3", "1/3", "2/3"):
        assert start(server, part).wait(timeout=100) == 0
    assert_same(server.root / "meshes" / "folder" / "mesh.zarr", whole)
    hexcast("verify-store", STORE, env=server.env)
    hexcast("verify-store", STORE, SPOT, "--cells", 300, "--backend", "cpu", env=server.env)


def test_a_whole_mesh_goes_to_a_bucket_and_errors_say_why(server, tmp_path):
    hexcast(*MESH, "-o", tmp_path / "whole.zarr")
    hexcast(*MESH, "-o", STORE, env=server.env)
    assert_same(server.root / "meshes" / "folder" / "mesh.zarr", tmp_path / "whole.zarr")
    error = hexcast(*MESH, "--unit", "mm", "-o", STORE, env=server.env, code=7)
    assert "the store is that of another mesh" in error
    error = hexcast(*MESH, "-o", STORE, env={**server.env, "AWS_SECRET_ACCESS_KEY": "wrong"}, code=7)
    assert "s3://meshes/folder/mesh.zarr" in error
