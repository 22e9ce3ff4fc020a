"""Chunks of Dask are windows of the mesh, on workers that are processes of their own."""

from __future__ import annotations

import os
import signal
import time

import dask
import numpy as np
import pytest
import xarray
from distributed import Client, LocalCluster

import hexcast
import hexcast.dask


@pytest.fixture(scope="module")
def client(tmp_path_factory):
    folder = tmp_path_factory.mktemp("workers")
    options = {"processes": True, "threads_per_worker": 2, "dashboard_address": None, "local_directory": folder}
    with LocalCluster(n_workers=2, **options) as cluster, Client(cluster) as client:
        yield client


def test_chunks_are_parts_of_the_whole(spot):
    whole = hexcast.mesh(spot, cells=90, padding={"cells": 2}, backend="cpu")
    lazy = hexcast.dask.mesh(spot, cells=90, padding={"cells": 2}, backend="cpu", chunks=(30, 41, -1))
    assert (lazy.shape, lazy.dtype) == (whole.flags.shape, np.uint8)
    assert lazy.chunks[2] == (whole.dims[0],)
    with dask.config.set(scheduler="threads"):
        np.testing.assert_array_equal(lazy.compute(), whole.flags)
        np.testing.assert_array_equal(lazy[7:9, ::3, 5].compute(), whole.flags[7:9, ::3, 5])


def test_a_dataset_has_the_coordinates_of_the_whole(spot):
    expected = hexcast.mesh({"file": spot, "flag": 4}, cells=40, unit="m", backend="cpu").to_xarray()
    lazy = hexcast.dask.dataset({"file": spot, "flag": 4}, cells=40, unit="m", backend="cpu", chunks=16)
    xarray.testing.assert_identical(lazy.compute(scheduler="threads"), expected)


def test_a_cluster_writes_what_the_whole_mesh_is_and_reads_facets_once_a_worker(client, spot, tmp_path):
    options = {"cells": 200, "backend": "cpu"}
    lazy = hexcast.dask.dataset(spot, chunks=64, **options)
    lazy.to_zarr(tmp_path / "mesh.zarr", zarr_format=3, consolidated=False)
    stored = xarray.open_zarr(tmp_path / "mesh.zarr", consolidated=False)
    np.testing.assert_array_equal(stored.flag.values, hexcast.mesh(spot, **options).flags)
    times_read = client.run(lambda: hexcast.dask.kept.cache_info().misses)
    assert list(times_read.values()) == [1, 1]


def test_chunks_of_a_worker_that_is_killed_are_made_again(client, spot):
    options = {"cells": 120, "backend": "cpu"}
    lazy = hexcast.dask.mesh(spot, chunks=32, **options)
    # slow enough that it has not ended when a worker does; a lambda, which travels to the workers whole
    future = client.compute(lazy.map_blocks(lambda flags: [time.sleep(0.3), flags][1], dtype=np.uint8))
    pids = client.run(os.getpid)
    assert future.status == "pending"
    os.kill(next(iter(pids.values())), signal.SIGKILL)
    np.testing.assert_array_equal(future.result(timeout=120), hexcast.mesh(spot, **options).flags)
    assert set(client.run(os.getpid).values()) != set(pids.values())


def test_a_graph_of_many_chunks_is_one_layer(spot):
    lazy = hexcast.dask.mesh(spot, dims=(4700, 4700, 4700), chunks=100, backend="cpu")
    assert lazy.npartitions == 47**3
    assert len(lazy.dask.layers) == 1


def test_what_workers_cannot_do_is_refused_at_once(spot):
    for what, options, code in (
        (hexcast.surface(spot), {}, "job-conflict"),
        (spot, {"window": (0, 0, 0, 1, 1, 1)}, "job-conflict"),
        (spot, {"part": "1/2"}, "job-conflict"),
        (spot, {"close_gaps": 3}, "job-conflict"),
        (spot, {"cels": 3}, "job-value"),
        ("nothing.stl", {}, "io"),
    ):
        with pytest.raises(hexcast.Error) as caught:
            hexcast.dask.mesh(what, **options)
        assert caught.value.code == code
