"""Meshes run beside Python: progress, Ctrl-C, threads, forks, memory."""

from __future__ import annotations

import io
import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from tqdm import tqdm

import hexcast
from hexcast.shapes import sphere

BALL = sphere((0, 0, 0), 1.0, steps=200)


def test_progress_goes_from_none_to_all_on_the_calling_thread():
    seen = []
    mesh = hexcast.mesh(BALL, cells=1500, backend="cpu", progress=lambda *now: seen.append((*now, threading.get_ident())))
    rays = mesh.report["rays"]
    done, totals, threads = zip(*seen)
    assert list(done) == sorted(done)
    assert done[-1] == rays
    assert (set(totals), set(threads)) == ({rays}, {threading.get_ident()})


def test_bars_of_tqdm(capsys):
    with tqdm(file=io.StringIO()) as bar:
        mesh = hexcast.mesh(BALL, cells=300, backend="cpu", progress=bar)
        assert bar.n == bar.total == mesh.report["rays"]
    hexcast.mesh(BALL, cells=300, backend="cpu", progress=True)
    assert "100%" in capsys.readouterr().err


@pytest.mark.parametrize("backend", ["cpu", "gpu"])
def test_what_progress_raises_ends_the_mesh(backend):
    seen = []

    def stop(done, total):
        seen.append((done, total))
        raise LookupError("enough")

    # far more cells than anybody waits for
    with pytest.raises(LookupError, match="enough"):
        hexcast.mesh(BALL, cells=40_000, backend=backend, progress=stop, max_cells=10**15, max_memory="20GB")
    assert len(seen) == 1
    assert seen[0][0] < seen[0][1]
    # and the next is as good as ever
    assert hexcast.mesh(BALL, cells=10, backend=backend).dims == (10, 10, 10)


MESH_FOR_LONG = """
import hexcast, sys
from hexcast.shapes import sphere
def tell(done, total):
    print("rays", done, total)
try:
    hexcast.mesh(sphere((0, 0, 0), 1.0), cells=40_000, backend=sys.argv[1], progress=tell, max_cells=10**15, max_memory="20GB")
except KeyboardInterrupt:
    print("interrupted")
"""

SAVE_FOR_LONG = """
import hexcast, sys
from hexcast.shapes import sphere
mesh = hexcast.mesh(sphere((0, 0, 0), 1.0), cells=1200, backend="cpu")
print("saves")
try:
    # more than anybody waits for: each look at the flags of all cells is another piece
    while True:
        mesh.save(sys.argv[1], compress=9)
except KeyboardInterrupt:
    print("interrupted")
"""


@pytest.mark.parametrize("backend", ["cpu", "gpu"])
def test_ctrl_c_ends_a_mesh(start, backend):
    child = start(MESH_FOR_LONG, backend)
    first = child.stdout.readline().split()
    child.send_signal(signal.SIGINT)
    # the whole would take many minutes
    rest, _ = child.communicate(timeout=60)
    *more, last = rest.splitlines()
    assert last == "interrupted"
    assert child.returncode == 0
    _, done, total = more[-1].split() if more else first
    assert int(done) < int(total)


def test_ctrl_c_ends_a_file_and_leaves_nothing(start, tmp_path):
    child = start(SAVE_FOR_LONG, tmp_path / "mesh.vti")
    assert child.stdout.readline() == "saves\n"
    # the file under its temporary name
    while not list(tmp_path.glob(".hexcast-*/new")):
        assert child.poll() is None
        time.sleep(0.01)
    child.send_signal(signal.SIGINT)
    rest, _ = child.communicate(timeout=60)
    assert rest == "interrupted\n"
    assert [path.name for path in tmp_path.iterdir()] in ([], ["mesh.vti"])


def test_other_threads_run_while_a_mesh_is_made(tmp_path):
    """The interpreter would switch threads after a day: another runs only where this one lets go of the GIL."""
    steps, ended = [0], threading.Event()

    def count():
        while not ended.is_set():
            steps[0] += 1
            time.sleep(0.001)

    other = threading.Thread(target=count)
    interval = sys.getswitchinterval()
    sys.setswitchinterval(86_400)
    try:
        other.start()
        mesh = None

        def act_make():
            nonlocal mesh
            mesh = hexcast.mesh(BALL, cells=500, backend="cpu")

        for act in (act_make, lambda: mesh.flags, lambda: mesh.save(tmp_path / "mesh.vti"), lambda: mesh.columns):
            before = steps[0]
            act()
            assert steps[0] > before
    finally:
        sys.setswitchinterval(interval)
        ended.set()
        other.join()


def test_threads_mesh_side_by_side():
    expected = hexcast.mesh(BALL, cells=200, backend="cpu").flags
    for backend in ("cpu", "gpu"):
        with ThreadPoolExecutor(4) as pool:
            meshes = pool.map(lambda _: hexcast.mesh(BALL, cells=200, backend=backend), range(8))
            assert all(np.array_equal(mesh.flags, expected) for mesh in meshes)


def count_cells(_: int) -> int:
    return int(hexcast.mesh(BALL, cells=100, backend="cpu").flags.sum())


@pytest.mark.filterwarnings("ignore:.*fork:DeprecationWarning")
def test_a_forked_process_meshes_too():
    expected = count_cells(0)
    with multiprocessing.get_context("fork").Pool(2) as pool:
        assert pool.map_async(count_cells, range(4)).get(timeout=120) == 4 * [expected]


def test_a_gpu_is_opened_without_a_word_where_no_session_runs(spot):
    script = "import hexcast, sys; print(hexcast.mesh(sys.argv[1], cells=20, backend='gpu').report['backend'])"
    environment = {name: value for name, value in os.environ.items() if name != "XDG_RUNTIME_DIR"}
    words = [sys.executable, "-c", script, spot]
    child = subprocess.run(words, capture_output=True, env=environment, text=True, timeout=120)
    assert (child.stdout, child.stderr) == ("gpu\n", "")


MEASURE = """
import hexcast, sys
from hexcast.shapes import sphere
def peak():
    lines = open("/proc/self/status").read().splitlines()
    return next(int(line.split()[1]) << 10 for line in lines if line.startswith("VmHWM:"))
mesh = hexcast.mesh(sphere((0, 0, 0), 1.0), cells=700, backend="cpu")
open("/proc/self/clear_refs", "w").write("5")
before = peak()
flags = mesh.flags
print(peak() - before, flags.nbytes, int(flags.flags.owndata), int(flags.base is None))
before = flags.ctypes.data
print(int(mesh.flags.ctypes.data == before), int(mesh.flags.T.base is flags))
"""


def test_flags_take_their_own_bytes_and_no_more(start):
    child = start(MEASURE)
    lines, _ = child.communicate(timeout=300)
    (grown, n_bytes, owns, is_base), (same, is_view) = [map(int, line.split()) for line in lines.splitlines()]
    # written once, into the memory of the array: a copy would take as much again
    assert n_bytes == 700**3
    assert 0.99 * n_bytes < grown < 1.2 * n_bytes
    assert (owns, is_base, same, is_view) == (1, 1, 1, 1)
