"""Pictures of a mesh."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Literal, Optional, Union

from . import _hexcast
from ._error import Error
from ._job import default_max_memory

Axis = Literal["x", "y", "z"]
#: A coordinate, or a text such as ``"25%"``.
Place = Union[float, str]
#: Pixels, flags, colours and memory as the compiled part takes them.
Look = tuple[Optional[int], list[int], list[tuple[int, list[int]]], int]

AXES = ("x", "y", "z")


class Picture(bytes):
    """The bytes of a PNG; notebooks show it."""

    def _repr_png_(self) -> bytes:
        return bytes(self)


def slices(
    mesh: _hexcast.RawMesh,
    axis: Union[Axis, Sequence[Axis], None],
    at: Union[Place, Sequence[Place], None],
    lines: bool,
    look: Look,
) -> Picture:
    """See :meth:`hexcast.Mesh.slice`."""
    names = [] if axis is None else [axis] if isinstance(axis, str) else list(axis)
    for name in names:
        if name not in AXES:
            raise Error(f"axis is {name!r}", "job-value", "give \"x\", \"y\" or \"z\", or a list of them")
    places: list[Place] = [] if at is None else list(at) if isinstance(at, Iterable) and not isinstance(at, str) else [at]
    # a number of NumPy is one, too
    texts = [place if isinstance(place, str) else repr(float(place)) for place in places]
    return Picture(_hexcast.draw_slices(mesh, [AXES.index(name) for name in names], texts, lines, look))


def look_of(
    size: Optional[int], flags: Optional[Sequence[int]], colours: Optional[Mapping[int, str]]
) -> Look:
    """Checks how a picture shall look."""
    shown = [] if flags is None else [int(flag) for flag in flags]
    pairs = [(int(flag), rgb_of(flag, text)) for flag, text in (colours or {}).items()]
    for flag in [*shown, *(flag for flag, _ in pairs)]:
        if not 0 <= flag <= 255:
            raise Error(f"flag {flag} of a picture", "job-value", "flags are 0 to 255")
    if size is not None and not 0 <= int(size) < 2**32:
        raise Error(f"size is {size!r}", "job-value", "give 1 to 32768 pixels")
    return (None if size is None else int(size), shown, pairs, max_bytes())


def rgb_of(flag: int, text: str) -> list[int]:
    """Red, green and blue of a text such as ``#d98324``."""
    if not re.fullmatch("#?[0-9a-fA-F]{6}", str(text)):
        raise Error(f"the colour of flag {flag} is {text!r}", "job-value", "give six hexadecimal digits, such as \"#d98324\"")
    return list(bytes.fromhex(text.lstrip("#")))


def max_bytes() -> int:
    """Most bytes for what is drawn or compared."""
    found = default_max_memory()
    return 2**64 - 1 if found is None else found
