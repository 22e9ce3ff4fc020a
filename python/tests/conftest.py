"""What the tests share: the native command, and models."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable

import pytest
from places import FIXTURES, ROOT


@pytest.fixture(scope="session")
def spot() -> str:
    """A closed surface."""
    return str(FIXTURES / "spot.stl")


@pytest.fixture(scope="session")
def part() -> str:
    """A surface that is not closed."""
    return str(FIXTURES / "featuretype.stl")


@pytest.fixture(scope="session")
def program() -> str:
    """Path of the native command: that of `npm test`, or that of `cargo build`."""
    built = ROOT / "target" / "debug" / ("hexcast.exe" if os.name == "nt" else "hexcast")
    return os.environ.get("HEXCAST_COMMAND", str(built))


@pytest.fixture(scope="session")
def command(program: str) -> Callable[..., None]:
    """Runs the native command."""

    def run(*words: object) -> None:
        subprocess.run([program, *map(str, words), "--quiet"], check=True, timeout=300)

    return run


def python(script: str, *arguments: object) -> subprocess.Popen[str]:
    """Starts a script in a process of its own."""
    words = [sys.executable, "-u", "-c", script, *map(str, arguments)]
    return subprocess.Popen(words, stdout=subprocess.PIPE, text=True)


@pytest.fixture(scope="session")
def start() -> Callable[..., subprocess.Popen[str]]:
    """Starts a script of Python in a process of its own."""
    return python
