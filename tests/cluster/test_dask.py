"""A store filled by workers of Dask that are processes, of which one is killed: the bytes of the undivided run."""

from __future__ import annotations

import os
import signal
import subprocess
import time

import dask
import pytest
from conftest import COMMAND, SPOT, assert_same, files
from distributed import Client, LocalCluster, wait

import hexcast
import hexcast.dask

OPTIONS = {"cells": 700, "backend": "cpu", "zarr": {"shard_bytes": "1MiB"}}


@pytest.fixture(scope="module")
def client(tmp_path_factory):
    folder = tmp_path_factory.mktemp("workers")
    options = {"processes": True, "threads_per_worker": 1, "dashboard_address": None, "local_directory": folder}
    with LocalCluster(n_workers=4, **options) as cluster, Client(cluster) as client:
        yield client


def test_four_workers_of_which_one_is_killed_fill_the_store_of_the_undivided_run(client, tmp_path):
    whole, store = tmp_path / "whole.zarr", tmp_path / "mesh.zarr"
    words = [COMMAND, "mesh", SPOT, "--cells", "700", "--backend", "cpu", "--zarr-shards=1MiB", "--quiet", "-o", whole]
    subprocess.run(words, check=True, timeout=200)
    tasks = hexcast.dask.to_zarr(str(SPOT), store, n=11, **OPTIONS)
    futures = client.compute(tasks)
    pids = client.run(os.getpid)
    assert len(pids) == 4
    while not store.exists() or len(files(store)) < 12:
        time.sleep(0.005)
    assert any(not future.done() for future in futures)
    os.kill(next(iter(pids.values())), signal.SIGKILL)
    wait(futures, timeout=200)
    reports = client.gather(futures)
    assert len({tuple(report["window"]["first"]) for report in reports}) == 11
    assert_same(store, whole)
    assert set(client.run(os.getpid).values()) != set(pids.values())


def test_a_store_of_zarr_takes_parts_too_and_others_are_refused(tmp_path):
    import zarr

    options = {**OPTIONS, "cells": 100, "zarr": {"shard_bytes": "64KiB"}}
    store = zarr.storage.LocalStore(tmp_path / "mesh.zarr")
    tasks = hexcast.dask.to_zarr(str(SPOT), store, n=[1, 2, 2], compress=1, **options)
    with dask.config.set(scheduler="threads"):
        dask.compute(*tasks[::-1])
        dask.compute(tasks[1])
    mesh = hexcast.mesh(str(SPOT), **options)
    mesh.save(tmp_path / "whole.zarr", compress=1)
    assert_same(tmp_path / "mesh.zarr", tmp_path / "whole.zarr")
    other = hexcast.dask.to_zarr(str(SPOT), tmp_path / "mesh.zarr", n=1, unit="mm", compress=1, **options)
    with pytest.raises(hexcast.Error, match="the store is that of another mesh"):
        dask.compute(*other, scheduler="threads")
    with pytest.raises(hexcast.Error, match="1000 parts along z"):
        hexcast.dask.to_zarr(str(SPOT), tmp_path / "mesh.zarr", n=1000, **options)
