"""Measures one mesh made by one process and by four workers of Dask of which one is killed, to Zarr stores that must be equal.

    .tools/python/bin/python benches/scale.py HEXCAST FOLDER [CELLS]

HEXCAST is the command; the Python package is installed. CELLS is the number along each axis, 2160 unless it is given: 1.008e10 cells. The
folder gets two stores, some hundred megabytes each, which are removed. Prints a table in Markdown.
"""

from __future__ import annotations

import filecmp
import json
import os
import shutil
import signal
import statistics
import subprocess
import sys
import time
from pathlib import Path

from distributed import Client, LocalCluster, wait

import hexcast.dask

SPOT = str(Path(__file__).resolve().parents[1] / "tests" / "fixtures" / "spot.stl")
PARTS = 16


def files(root: Path) -> list[str]:
    return sorted(str(path.relative_to(root)) for path in root.rglob("*") if path.is_file())


def seconds(words: list[str]) -> float:
    start = time.monotonic()
    subprocess.run(words, check=True)
    return time.monotonic() - start


def by_dask(store: Path, options: dict[str, object]) -> float:
    """Seconds that four workers take, one of which is killed when a quarter of the shards is there."""
    cluster = LocalCluster(n_workers=4, threads_per_worker=1, processes=True, dashboard_address=None)
    with cluster, Client(cluster) as client:
        tasks = hexcast.dask.to_zarr(SPOT, store, n=PARTS, **options)
        pids = list(client.run(os.getpid).values())
        start = time.monotonic()
        futures = client.compute(tasks)
        while sum(future.done() for future in futures) < PARTS // 4:
            time.sleep(0.05)
        os.kill(pids[0], signal.SIGKILL)
        wait(futures)
        client.gather(futures)
        return time.monotonic() - start


def main() -> None:
    command, folder = sys.argv[1], Path(sys.argv[2])
    n = int(sys.argv[3]) if len(sys.argv) > 3 else 2160
    whole, parted = folder / "whole.zarr", folder / "parted.zarr"
    mesh = [command, "mesh", SPOT, "--dims", f"{n},{n},{n}", "--backend", "cpu", "--quiet"]
    alone = seconds([*mesh, "-o", str(whole)])
    together = by_dask(parted, {"dims": [n, n, n], "backend": "cpu"})
    names = files(whole)
    differing = filecmp.cmpfiles(whole, parted, names, shallow=False)[1:]
    assert names == files(parted) and differing == ([], []), differing
    n_bytes = sum((whole / name).stat().st_size for name in names)
    shutil.rmtree(parted)
    parts = []
    for k in (1, PARTS // 2, PARTS):
        report = folder / "part.json"
        words = [*mesh, "--part", f"{k}/{PARTS}", "-o", str(parted), "--report", str(report)]
        parts.append((seconds(words), json.loads(report.read_text())))
        report.unlink()
    rate = n**3 / alone
    print(f"| {n}^3 cells, {len(names)} files of {n_bytes} bytes in all | seconds | 1e9 cells/s |")
    print("| --- | ---: | ---: |")
    print(f"| one process, all cores | {alone:.1f} | {rate / 1e9:.3f} |")
    print(f"| four workers of Dask, one killed after a quarter | {together:.1f} | {n**3 / together / 1e9:.3f} |")
    median = statistics.median(took for took, _ in parts)
    print(f"| one part of {PARTS} in a process of its own, median of three | {median:.1f} | {n**3 / PARTS / median / 1e9:.3f} |")
    for took, report in parts:
        spent = report["seconds"]
        peak = report["peak_bytes"]["host"]
        print(f"part: {took:.2f} s, of which {spent['total']:.2f} s to columns, {spent['write']:.2f} s to write; peak {peak} bytes")
    shutil.rmtree(whole)
    shutil.rmtree(parted)


if __name__ == "__main__":
    main()
