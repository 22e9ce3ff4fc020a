"""Draws the pictures of open surfaces and thin walls in this folder, with NumPy and Pillow.

    cargo build --release
    python docs/pictures.py motorbike.stl hubble_hst.stl

The motorbike is the one of OpenFOAM's tutorials, the Hubble telescope one of NASA's 3D resources.
"""

import pathlib
import subprocess
import sys
import tempfile

import numpy as np
from PIL import Image, ImageDraw

ROOT = pathlib.Path(__file__).parent.parent
COLOURS = np.array([[255, 255, 255], [58, 143, 201], [217, 131, 36]], np.uint8)
HEIGHT = 360


def flags(model, *options):
    """Flags of a mesh as an array of shape (nz, ny, nx)."""
    with tempfile.TemporaryDirectory() as folder:
        output = f"{folder}/mesh.npy"
        command = [ROOT / "target/release/hexcast", "mesh", model, "--backend", "cpu", "--quiet", *options, "-o", output]
        subprocess.run(command, check=True, capture_output=True)
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


main(*sys.argv[1:3])
