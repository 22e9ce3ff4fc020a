"""Draws docs/lines.svg: the lines around a patch antenna, generated and drawn by hexcast.

    python docs/lines_picture.py target/release/hexcast
"""

import struct
import subprocess
import sys
import tempfile
from pathlib import Path

#: Boxes in mm: name, first and last corner, options.
BOXES = [
    ("substrate", (0, 0, 0), (60, 60, 1.6), "min_cells=4"),
    ("patch", (11.4, 15.8, 1.6), (48.6, 44.2, 1.635), "metal=true"),
    ("feed", (28.5, 0, 1.6), (31.5, 15.8, 1.635), "metal=true"),
]
SIZE = ["--graded", "4", "--min-size", "0.02", "--padding-length", "15", "--unit", "mm"]


def stl(low, high) -> bytes:
    """A box as binary STL."""
    corner = lambda bits: tuple((high if bits >> axis & 1 else low)[axis] for axis in range(3))
    sides = [(0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6)]
    facets = [[corner(k) for k in three] for a, b, c, d in sides for three in ((a, b, c), (a, c, d))]
    records = [struct.pack("<12fH", 0, 0, 0, *(number for at in facet for number in at), 0) for facet in facets]
    return bytes(80) + struct.pack("<I", len(records)) + b"".join(records)


def main(program: str) -> None:
    with tempfile.TemporaryDirectory() as folder:
        arguments = []
        for name, low, high, options in BOXES:
            path = Path(folder, f"{name}.stl")
            path.write_bytes(stl(low, high))
            arguments.append(f"{path}:{options}")
        drawing = Path(__file__).with_name("lines.svg")
        subprocess.run([program, "estimate", *arguments, *SIZE, "-o", drawing], check=True, stdout=subprocess.DEVNULL)


if __name__ == "__main__":
    main(sys.argv[1])
