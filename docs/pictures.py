"""Draws the pictures of open surfaces, thin walls and leaks in this folder, with NumPy and Pillow.

    cargo build --release
    python docs/pictures.py motorbike.stl hubble_hst.stl

The motorbike is the one of OpenFOAM's tutorials, the Hubble telescope one of NASA's 3D resources.
"""

import itertools
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np
from PIL import Image, ImageDraw

ROOT = pathlib.Path(__file__).parent.parent
COLOURS = np.array([[255, 255, 255], [58, 143, 201], [217, 131, 36]], np.uint8)
HEIGHT = 360


def hexcast(*arguments, codes=(0,)):
    """Runs hexcast and returns what it prints."""
    done = subprocess.run([ROOT / "target/release/hexcast", *arguments], capture_output=True, text=True)
    if done.returncode not in codes:
        raise SystemExit(done.stderr)
    return done.stdout


def flags(model, *options):
    """Flags of a mesh as an array of shape (nz, ny, nx)."""
    with tempfile.TemporaryDirectory() as folder:
        output = f"{folder}/mesh.npy"
        hexcast("mesh", model, "--backend", "cpu", "--quiet", *options, "-o", output)
        return np.load(output)


def panel(plane, title):
    """A plane of colours, seen with its first axis upwards, below a title."""
    picture = Image.fromarray(COLOURS[plane[::-1]])
    width = picture.width * HEIGHT // picture.height
    framed = Image.new("RGB", (width + 2, HEIGHT + 26), "white")
    framed.paste(picture.resize((width, HEIGHT), Image.Resampling.NEAREST), (1, 25))
    draw = ImageDraw.Draw(framed)
    draw.rectangle((0, 24, width + 1, HEIGHT + 25), outline="#7a8a99")
    draw.text((4, 4), title, fill="black", font_size=14)
    return framed


def save(name, panels):
    """Panels side by side."""
    gap = 12
    width = sum(panel.width for panel in panels) + gap * (len(panels) - 1)
    sheet = Image.new("RGB", (width, panels[0].height), "white")
    at = 0
    for one in panels:
        sheet.paste(one, (at, 0))
        at += one.width + gap
    sheet.quantize(16).save(ROOT / "docs" / name, optimize=True)


def write_boxes(path, boxes):
    """Writes boxes, each of its low and its high corner, as one binary STL."""
    square = [(0, 0), (1, 0), (1, 1), (0, 0), (1, 1), (0, 1)]
    facets = []
    for ends, axis, side in itertools.product(np.array(boxes, float), range(3), range(2)):
        order = square if side else square[::-1]
        corners = [np.insert(corner, axis, side) for corner in order]
        # seen along y the two other axes are the other way round
        corners = corners[::-1] if axis == 1 else corners
        facets += [[ends[n, range(3)] for n in corners[:3]], [ends[n, range(3)] for n in corners[3:]]]
    records = np.zeros(len(facets), [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    records["corners"] = facets
    path.write_bytes(bytes(80) + np.uint32(len(facets)).tobytes() + records.tobytes())


def leak():
    """A casing with two inner walls and a hole of 3 mm, and the way that it leaves open."""
    walls = [
        [(0, 0, 0), (120, 80, 4)], [(0, 0, 36), (120, 80, 40)], [(0, 0, 0), (120, 4, 40)], [(0, 76, 0), (120, 80, 40)],
        [(0, 0, 0), (4, 80, 40)], [(40, 0, 0), (44, 56, 40)], [(76, 24, 0), (80, 80, 40)],
        # the wall on the right, around the hole
        [(116, 0, 0), (120, 50, 40)], [(116, 53, 0), (120, 80, 40)], [(116, 0, 0), (120, 80, 18)], [(116, 0, 21), (120, 80, 40)],
    ]
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        write_boxes(folder / "casing.stl", walls)
        options = ["--cell-size", "1", "--rule", "nonzero", "--padding-cells", "12", "--backend", "cpu", "--quiet"]
        hexcast("mesh", folder / "casing.stl", *options, "-o", folder / "mesh.hxc", "-o", folder / "mesh.npy")
        ends = ["--from", "20,20,20", "--to", "126,10,20"]
        found = json.loads(hexcast("leak", folder / "mesh.hxc", *ends, "--json", codes=(9,)))
        return np.load(folder / "mesh.npy"), found


def leak_panel():
    """The middle plane of the casing with the shortest path and the narrowest place."""
    mesh, found = leak()
    # 12 cells of padding, of 1 mm
    picture = panel(mesh[12 + 19], "hexcast leak: the shortest path, and the narrowest place")
    scale = HEIGHT / mesh.shape[1]
    at = lambda x, y: (1 + (x + 12) * scale, 25 + HEIGHT - (y + 12) * scale)
    draw = ImageDraw.Draw(picture)
    draw.line([at(x, y) for x, y, _ in found["path"]["points"]], fill="#d98324", width=3)
    low, high = found["narrowest"]["bounds"]
    (left, bottom), (right, top) = at(*low[:2]), at(*high[:2])
    draw.rectangle((left - 4, top - 4, right + 4, bottom + 4), outline="#c0392b", width=3)
    return picture


def main(motorbike, hubble):
    size = ["--cells", "400", "--padding-cells", "8"]
    before = flags(motorbike, *size, "--open", "parity", "--axis", "z")
    after = flags(motorbike, *size, "--axis", "z")
    across = (before != after).sum(axis=(0, 2)).argmax()
    save("motorbike.png", [
        panel(before[:, across, :], "rays of one axis (--open parity)"),
        panel(after[:, across, :], "decided by the winding number"),
    ])
    size = ["--cells", "120", "--padding-cells", "4"]
    centre, separating = flags(hubble, *size), flags(hubble, *size, "--fill", "separating")
    # what is seen along the axis where most is added; added cells in another colour
    added = [(separating.any(axis) > centre.any(axis)).sum() for axis in range(3)]
    axis = int(np.argmax(added))
    seen = separating.any(axis) * np.uint8(2)
    seen[centre.any(axis)] = 1
    save("walls.png", [
        panel(centre.any(axis).astype(np.uint8), "cells with their centres inside"),
        panel(seen, "--fill separating adds the orange ones"),
    ])
    save("leak.png", [leak_panel()])


main(*sys.argv[1:3])
