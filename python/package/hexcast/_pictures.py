"""Pictures of a mesh, and what differs between two."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Literal, NamedTuple, Optional, Union

from . import _hexcast
from ._error import Error
from ._job import default_max_memory

if TYPE_CHECKING:
    from ._mesh import Mesh

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


class FlagPair(NamedTuple):
    """Cells that have one flag in the first mesh and another in the second."""

    #: The flag in the first mesh.
    one: int
    #: The flag in the second.
    other: int
    #: Number of cells.
    cells: int
    #: The first of them along the rays of the first mesh.
    first: tuple[int, int, int]
    #: The box around them: its first cell, and its end, exclusive.
    bounds: tuple[tuple[int, int, int], tuple[int, int, int]]


class Difference(NamedTuple):
    """What differs between two meshes."""

    #: Number of cells that differ.
    cells: int
    #: Number of all cells.
    n_cells: int
    #: Whether the lines are the same; where they are not, cells were compared by their indices.
    are_lines_equal: bool
    #: The pairs of flags, most cells first.
    pairs: list[FlagPair]
    #: The lines of the first mesh, and flag 1 where the two differ.
    mask: Mesh


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


def difference(
    one: _hexcast.RawMesh, other: _hexcast.RawMesh, mesh_of: Callable[[_hexcast.RawMesh], Mesh]
) -> Difference:
    """See :meth:`hexcast.Mesh.diff`."""
    text, mask = _hexcast.diff(one, other, max_bytes())
    found = json.loads(text)
    pairs = [
        FlagPair(pair["one"], pair["other"], pair["cells"], cell(pair["first"]), (cell(pair["bounds"][0]), cell(pair["bounds"][1])))
        for pair in found["pairs"]
    ]
    return Difference(found["cells"], found["n_cells"], found["are_lines_equal"], pairs, mesh_of(mask))


def cell(numbers: Sequence[int]) -> tuple[int, int, int]:
    """A cell of JSON."""
    x, y, z = numbers
    return x, y, z
