"""Signed distances by hexcast beside libigl, in one run: `python benches/distances.py MODEL.stl CELLS HEXCAST [--runs 5]`.

Needs NumPy and libigl (`pip install libigl numpy`). Both get the same points and the same facets. hexcast's time is that of the whole command: reading, signs, distances and writing `.npy`;
libigl's is that of its tree and queries alone, which run on all cores: signs by the fast winding number, and unsigned.
"""

import argparse
import json
import statistics
import subprocess
import tempfile
import time
from pathlib import Path

import igl
import numpy as np


def facets_of(path: str) -> np.ndarray:
    """Corners of the facets of a binary STL file."""
    kind = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    return np.fromfile(path, kind, offset=84)["corners"].astype(np.float64)


def median_of(act, runs: int):
    times, result = [], None
    for _ in range(runs):
        start = time.perf_counter()
        result = act()
        times.append(time.perf_counter() - start)
    return statistics.median(times), result


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("model")
    parser.add_argument("cells")
    parser.add_argument("command")
    parser.add_argument("--runs", type=int, default=5)
    asked = parser.parse_args()
    corners = facets_of(asked.model)
    vertices, faces = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    faces = faces.reshape(-1, 3).astype(np.int64)
    with tempfile.TemporaryDirectory() as folder:
        out = str(Path(folder) / "d.npy")
        for band in ["3", "all"]:
            call = [asked.command, "mesh", asked.model, "--cells", asked.cells, "--backend", "cpu", "--quiet", "--distance", out, "--distance-band", band]
            took, _ = median_of(lambda: subprocess.run(call, check=True), asked.runs if band == "3" else 1)
            found = np.load(out)
            print(json.dumps({"who": "hexcast", "band": band, "points": found.size, "seconds": round(took, 3)}), flush=True)
        report = json.loads(subprocess.run([*call[:4], asked.cells, "--backend", "cpu", "--json"], check=True, capture_output=True, text=True).stdout)
        axes = [origin + spacing * (np.arange(n) + 0.5) for origin, spacing, n in zip(report["origin"], report["spacing"], report["dims"])]
        # a tenth of the planes: all of libigl's points take minutes
        planes = slice(0, None, 10)
        z, y, x = np.meshgrid(axes[2][planes], axes[1], axes[0], indexing="ij")
        points = np.stack([x, y, z], axis=-1).reshape(-1, 3)
        expected = found[planes].reshape(-1)
        width = 3 * max(report["spacing"])
        kinds = {"fast winding number": igl.SIGNED_DISTANCE_TYPE_FAST_WINDING_NUMBER, "unsigned": igl.SIGNED_DISTANCE_TYPE_UNSIGNED}
        for name, kind in kinds.items():
            for bounds in [(-width, width), (-np.inf, np.inf)]:
                took, result = median_of(lambda: igl.signed_distance(points, vertices, faces, kind, *bounds), 1)
                numbers = result[0]
                near = np.abs(expected) < min(width, bounds[1]) * 0.999
                differ = np.abs(np.abs(numbers) - np.abs(expected))[near].max() / max(report["spacing"])
                others = int((np.signbit(numbers) != np.signbit(expected))[near].sum()) if kind != kinds["unsigned"] else None
                row = {"who": f"libigl, {name}", "band": "3" if bounds[1] == width else "all", "points": len(points), "seconds": round(took, 3)}
                print(json.dumps({**row, "differ_in_cells": float(differ), "other_signs": others}), flush=True)


if __name__ == "__main__":
    main()
