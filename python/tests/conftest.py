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
def command() -> Callable[..., None]:
    """Runs the native command, which `cargo build` makes."""
    program = ROOT / "target" / "debug" / ("hexcast.exe" if os.name == "nt" else "hexcast")

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
