"""What the cluster tests share: the command with S3, a server of S3 on this machine, and comparing folders."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
COMMAND = Path(os.environ.get("HEXCAST_COMMAND", ROOT / "target" / "debug" / "hexcast"))
SPOT = ROOT / "tests" / "fixtures" / "spot.stl"


def files(root: Path) -> dict[str, bytes]:
    """All files below a folder by their names in it."""
    return {str(path.relative_to(root)): path.read_bytes() for path in sorted(root.rglob("*")) if path.is_file()}


def assert_same(one: Path, other: Path) -> None:
    left, right = files(one), files(other)
    assert left.keys() == right.keys()
    assert len(left) > 10
    assert [name for name in left if left[name] != right[name]] == []


class Server:
    """A server of S3 that keeps objects as files, so that they outlive it."""

    def __init__(self, root: Path) -> None:
        self.root = root
        (root / "meshes").mkdir(parents=True)
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.port = free.getsockname()[1]
        self.start()

    def start(self) -> None:
        keys = ["--access-key", "key", "--secret-key", "secret"]
        words = [os.environ["HEXCAST_S3_SERVER"], "--host", "127.0.0.1", "--port", str(self.port), *keys, self.root]
        self.process = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        for _ in range(200):
            with socket.socket() as probe:
                if probe.connect_ex(("127.0.0.1", self.port)) == 0:
                    return
            time.sleep(0.05)
        raise AssertionError("the server did not start")

    def kill(self) -> None:
        self.process.send_signal(signal.SIGKILL)
        self.process.wait()

    @property
    def env(self) -> dict[str, str]:
        return {
            **os.environ,
            "AWS_ENDPOINT_URL": f"http://127.0.0.1:{self.port}",
            "AWS_ACCESS_KEY_ID": "key",
            "AWS_SECRET_ACCESS_KEY": "secret",
            "AWS_REGION": "us-east-1",
        }


@pytest.fixture
def server(tmp_path):
    server = Server(tmp_path / "s3")
    yield server
    server.kill()


def hexcast(*words: object, env: dict[str, str] | None = None, code: int = 0) -> str:
    """Runs the command; returns what it printed."""
    done = subprocess.run([COMMAND, *map(str, words)], capture_output=True, text=True, timeout=300, env=env)
    assert done.returncode == code, f"{words}: {done.returncode}\n{done.stderr}"
    return done.stdout + done.stderr
