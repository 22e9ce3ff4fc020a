"""Refuses names that are not known."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Sequence

from ._error import InvalidType


def check_names(given: Iterable[object], names: Sequence[str], what: str) -> None:
    """Refuses a name that is not one of these, and names the nearest."""
    for name in given:
        if name in names:
            continue
        near = difflib.get_close_matches(str(name), names, n=1, cutoff=0.0)
        message = f'there is no {what} "{name}"; the nearest is "{near[0]}"'
        raise InvalidType(message, "job-value", f"{what}s are {', '.join(names)}")
