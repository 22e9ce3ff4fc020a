#!/usr/bin/env python3
"""Surfaces with holes: how many cells change when facets are missing, beside libigl's fast winding number.

usage: open.py HEXCAST FOLDER [--cells N] [--seed S] [--igl]

For each closed binary STL of FOLDER: meshes it whole, then with 1, 5 and 10 % of its facets removed at random, in the same box of
cells along x, y and z, and counts the cells that differ. --igl asks libigl (pip: libigl) for the same cells of the same facets:
a cell is inside where the fast winding number at its centre is more than 0.5.
"""
import argparse, json, os, subprocess, tempfile, time

import numpy as np

RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def read_stl(path):
    data = open(path, "rb").read()
    count = int(np.frombuffer(data, "<u4", 1, 80)[0])
    return np.frombuffer(data, RECORD, count, 84) if len(data) == 84 + 50 * count else None


def write_stl(path, records):
    with open(path, "wb") as file:
        file.write(bytes(80) + np.uint32(len(records)).tobytes() + records.tobytes())


def mesh(hexcast, stl, settings, folder):
    """Flags and report of a mesh on the CPU."""
    raw = os.path.join(folder, "out.raw")
    done = subprocess.run(
        [hexcast, "mesh", stl, *settings, "--backend", "cpu", "-o", raw, "--json"], capture_output=True, text=True
    )
    if done.returncode != 0:
        raise SystemExit(done.stderr)
    return np.fromfile(raw, np.uint8), json.loads(done.stdout)


def igl_flags(records, report):
    import igl

    corners = records["corners"].reshape(-1, 3).astype(float)
    facets = np.arange(len(corners)).reshape(-1, 3)
    axes = [report["origin"][a] + report["spacing"][a] * (np.arange(report["dims"][a]) + 0.5) for a in range(3)]
    z, y, x = np.meshgrid(axes[2], axes[1], axes[0], indexing="ij")
    centres = np.stack([x.ravel(), y.ravel(), z.ravel()], 1)
    start = time.time()
    winding = igl.fast_winding_number(corners, facets, centres)
    return (np.abs(winding) > 0.5).astype(np.uint8), time.time() - start


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("hexcast")
    parser.add_argument("folder")
    parser.add_argument("--cells", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--igl", action="store_true")
    args = parser.parse_args()
    print("| model | facets | removed | cells that differ | seconds | doubtful |" + (" libigl | seconds |" if args.igl else ""))
    print("|---|---:|---:|---:|---:|---:|" + ("---:|---:|" if args.igl else ""))
    with tempfile.TemporaryDirectory() as folder:
        for name in sorted(os.listdir(args.folder)):
            path = os.path.join(args.folder, name)
            whole = read_stl(path) if name.endswith(".stl") else None
            if whole is None:
                continue
            flags, report = mesh(args.hexcast, path, ["--cells", str(args.cells), "--padding-cells", "2"], folder)
            if report["open"]:
                continue
            low = report["origin"]
            high = [low[a] + report["spacing"][a] * report["dims"][a] for a in range(3)]
            domain = "--domain=" + ",".join(repr(c) for c in [*low, *high])
            settings = [domain, "--dims", ",".join(map(str, report["dims"]))]
            for share in [0.01, 0.05, 0.1]:
                random = np.random.default_rng(args.seed)
                left = whole[random.random(len(whole)) >= share]
                holed = os.path.join(folder, "holed.stl")
                write_stl(holed, left)
                results = [mesh(args.hexcast, holed, [*settings, "--axis", axis], folder) for axis in "xyz"]
                if any((other != results[0][0]).any() for other, _ in results[1:]):
                    raise SystemExit(f"{name}: the cells depend on the axis")
                differ = (results[0][0] != flags).mean()
                seconds, open_report = results[0][1]["seconds"]["total"], results[0][1]["open"]
                doubtful = sum(entry["doubtful_cells"] for entry in open_report) / len(flags)
                line = f"| {name} | {len(whole)} | {share:.0%} | {differ:.4%} | {seconds:.2f} | {doubtful:.1%} |"
                if args.igl:
                    theirs, took = igl_flags(left, report)
                    line += f" {(theirs != flags).mean():.4%} | {took:.2f} |"
                print(line, flush=True)


if __name__ == "__main__":
    main()
