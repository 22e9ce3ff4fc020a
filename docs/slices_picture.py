"""Draws docs/slices.png, docs/view.png and docs/difference.png: a cow on a block, as slices and from outside, and the cells
that "--fill separating" adds to them.

    python docs/slices_picture.py target/release/hexcast
"""

import itertools
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

DOCS = Path(__file__).parent
COW = DOCS.parent / "tests" / "fixtures" / "spot.stl"


def box(low, high) -> bytes:
    """A box as binary STL."""
    facets = []
    for axis, side in itertools.product(range(3), range(2)):
        square = []
        for one, other in ((0, 0), (1, 0), (1, 1), (0, 1)):
            corner = [0, 0, 0]
            corner[axis], corner[(axis + 1) % 3], corner[(axis + 2) % 3] = side, one, other
            square.append([(low, high)[end][at] for at, end in enumerate(corner)])
        square = square if side else square[::-1]
        facets += [(square[0], square[1], square[2]), (square[0], square[2], square[3])]
    records = [struct.pack("<12fH", 0, 0, 0, *itertools.chain(*facet), 0) for facet in facets]
    return bytes(80) + struct.pack("<I", len(records)) + b"".join(records)


def main(program: str) -> None:
    with tempfile.TemporaryDirectory() as folder:
        block = Path(folder, "block.stl")
        block.write_bytes(box((-0.7, -1.1, -1.05), (0.7, 0.7, -0.74)))
        run = lambda *words, codes=(0,): subprocess.run([program, *map(str, words)], stdout=subprocess.DEVNULL).returncode in codes or sys.exit(1)
        mesh, other, mask = (Path(folder, f"{name}.hxc") for name in ("mesh", "other", "mask"))
        parts = [f"{block}:name=block,flag=2", f"{COW}:name=cow,flag=1,rotate=90/0/0"]
        size = ["--domain", "-0.8,-1.3,-1.1,0.8,0.8,1.1", "--dims", "40,53,55", "--backend", "cpu", "-q"]
        run("mesh", *parts, *size, "-o", mesh)
        run("mesh", *parts, *size, "--fill", "separating", "-o", other)
        run("slice", mesh, "--size", "420", "-q", "-o", DOCS / "slices.png")
        run("view", mesh, "--direction=-50,25", "--size", "520", "-q", "-o", DOCS / "view.png")
        run("diff", mesh, other, "-o", mask, codes=(1,))
        run("slice", mask, "--size", "420", "-q", "-o", DOCS / "difference.png")


main(sys.argv[1])
