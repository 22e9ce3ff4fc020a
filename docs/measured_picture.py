"""Draws docs/measured.svg: a slice through a ball in few cells, with fractions, normals and links. Needs NumPy.

    python docs/measured_picture.py target/release/hexcast
"""

import math
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

#: Cells along each axis, pixels of a cell, and the plane that is shown.
N, PIXELS, PLANE = 12, 40, 6


def ball(rings: int = 24) -> bytes:
    """A ball of radius 1 as binary STL."""

    def at(i, j):
        a, b = math.pi * i / rings, math.pi * j / rings
        return (math.sin(a) * math.cos(b), math.sin(a) * math.sin(b), math.cos(a) if i % rings else (1 - 2 * (i > 0)))

    facets = []
    for i in range(rings):
        for j in range(2 * rings):
            a, b, c, d = at(i, j), at(i + 1, j), at(i + 1, (j + 1) % (2 * rings)), at(i, (j + 1) % (2 * rings))
            facets += [f for f, keep in (((a, b, c), i < rings - 1), ((a, c, d), i > 0)) if keep]
    records = [struct.pack("<12fH", 0, 0, 0, *(number for at in facet for number in at), 0) for facet in facets]
    return bytes(80) + struct.pack("<I", len(records)) + b"".join(records)


def main(program: str) -> None:
    with tempfile.TemporaryDirectory() as folder:
        model = Path(folder, "ball.stl")
        model.write_bytes(ball())
        files = [f"{folder}/{name}" for name in ("solid.npy", "cut.npz", "links.npz")]
        box = ["--domain", "-1.25,-1.25,-1.25,1.25,1.25,1.25", "--dims", f"{N},{N},{N}", "--backend", "cpu", "-q"]
        run = lambda *more: subprocess.run([program, "mesh", str(model), *box, *more], check=True)
        run("--fractions", files[0], "--fraction-rays", "16")
        run("--fractions", files[1], "--fraction-surfaces", "--links", files[2], "--stencil", "D3Q19")
        solid, cut, links = [np.load(file) for file in files]
        cells, points, normals = cut["surface_cell"], cut["surface_point"], cut["surface_normal"]
        steps = links["directions"][links["direction"]]
        ends = np.stack([links[axis] for axis in "xyz"], 1), steps, links["q"]
    draw = []
    x_of, y_of = (lambda x, panel: (x + panel * (N + 1)) * PIXELS), (lambda y: (N - y) * PIXELS)
    for y in range(N):
        for x in range(N):
            for panel, share in ((0, solid[PLANE, y, x]), (1, float(solid[PLANE, y, x] > 0.5))):
                grey = [round(255 + share * (of - 255)) for of in (90, 140, 190)]
                draw.append(
                    f'<rect x="{x_of(x, panel)}" y="{y_of(y + 1)}" width="{PIXELS}" height="{PIXELS}" '
                    f'fill="rgb({grey[0]},{grey[1]},{grey[2]})" stroke="#ccc"/>'
                )
                if panel == 0 and 0 < share < 1:
                    draw.append(
                        f'<text x="{x_of(x, 0) + 3}" y="{y_of(y) - 4}" font-size="10" '
                        f'font-family="sans-serif">{share:.2f}</text>'
                    )
    line = lambda a, b, panel, colour: draw.append(
        f'<line x1="{x_of(a[0], panel):.1f}" y1="{y_of(a[1]):.1f}" x2="{x_of(b[0], panel):.1f}" '
        f'y2="{y_of(b[1]):.1f}" stroke="{colour}" stroke-width="1.5"/>'
    )
    for cell, point, normal in zip(cells.astype(int), points, normals):
        if cell // (N * N) == PLANE:
            at = np.array([cell % N, cell // N % N]) + point[:2]
            line(at, at + 0.6 * normal[:2], 0, "#b03030")
            draw.append(f'<circle cx="{x_of(at[0], 0):.1f}" cy="{y_of(at[1]):.1f}" r="2.5" fill="#b03030"/>')
    for cell, step, q in zip(*ends):
        if cell[2] == PLANE and step[2] == 0:
            at = cell[:2] + 0.5
            line(at, at + q * step[:2], 1, "#208040")
            draw.append(f'<circle cx="{x_of(at[0], 1):.1f}" cy="{y_of(at[1]):.1f}" r="2" fill="#208040"/>')
    size = f"{(2 * N + 1) * PIXELS} {N * PIXELS}"
    text = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {size}">' + "\n".join(draw) + "</svg>\n"
    Path(__file__).with_name("measured.svg").write_text(text)


main(sys.argv[1])
