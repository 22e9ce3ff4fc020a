"""From what a caller gives to a function of rays done and rays in all."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, Optional

from ._error import Error


@contextmanager
def follow(progress: Any) -> Iterator[Optional[Callable[[int, int], object]]]:
    """The function; closes a bar that it opened."""
    if progress is None or progress is False:
        yield None
    elif progress is True:
        from tqdm.auto import tqdm

        with tqdm(unit=" rays", unit_scale=True) as bar:
            yield moves(bar)
    elif hasattr(progress, "update") and hasattr(progress, "total"):
        yield moves(progress)
    elif callable(progress):
        yield progress
    else:
        message = f"progress is {progress!r}"
        raise Error(message, "job-value", "give a function of rays done and rays in all, a bar of tqdm, or True")


def moves(bar: Any) -> Callable[[int, int], object]:
    """Moves a bar of tqdm."""

    def move(done: int, total: int) -> None:
        bar.total = total
        bar.update(done - bar.n)

    return move
