#!/usr/bin/env python3
"""Other programs doing hexcast's job, to be timed beside it in one run.

usage: peers.py FILE.stl N [PEER ...] [--runs K] [--flags PREFIX]

The grid is hexcast's `--cells N`: cubic cells of (longest side / N), lines from the box's minimum, ceil() cells per axis.
Each peer runs in a process of its own and prints one JSON line: seconds of every run to read the file and to mesh it into u8
flags in memory, the first, which counts for nothing where there are more, apart; cells, inside cells, peak resident memory.
--flags writes PREFIX.PEER.u8 (x fastest) to compare cell by cell.
Set-up: `npm run bench` makes .tools/peers with numpy and vtk. For all peers:
python3 -m venv V && V/bin/pip install numpy scipy vtk open3d-cpu trimesh embreex warp-lang   (binary STL only)

peer      what it is                                                      known weakness
vtk       vtkPolyDataToImageStencil, slices, all cores: the one to beat     dense bytes, one mask a call
open3d    RaycastingScene.compute_occupancy, Embree, one ray a cell         slow; f32
columns   RaycastingScene.list_intersections, one ray a column             wrong where rays meet edges (f32)
trimesh   voxelized(h).fill()                                              surface cells included; memory
warp      mesh_query_ray down each column, restarted after every hit       leaks (f32 and an epsilon); runs on CUDA too
"""
import json, resource, subprocess, sys, time

PEERS = ["vtk", "open3d", "columns", "trimesh", "warp"]


def read_stl(path):
    import numpy as np
    data = open(path, "rb").read()
    count = int(np.frombuffer(data, "<u4", 1, 80)[0])
    record = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    return np.frombuffer(data, record, count, 84)["corners"]


def grid(corners, n):
    import numpy as np
    low, high = corners.reshape(-1, 3).min(0).astype(float), corners.reshape(-1, 3).max(0).astype(float)
    size = (high - low).max() / n
    return low, size, np.maximum(1, np.ceil((high - low) / size - 1e-9).astype(int))


def fill_columns(ray, crossing, rays, depth):
    """Flags of `rays` columns of `depth` cells from unsorted crossings (parity)."""
    import numpy as np
    toggles = np.zeros((rays, depth + 1), np.uint8)
    np.bitwise_xor.at(toggles, (ray, np.clip(np.floor(crossing - 0.5).astype(int) + 1, 0, depth)), 1)
    return np.bitwise_xor.accumulate(toggles, 1)[:, :depth]


def vtk(path, corners, low, size, dims):
    import vtk as v
    from vtk.util.numpy_support import vtk_to_numpy
    start = time.time()
    reader = v.vtkSTLReader(); reader.SetFileName(path); reader.Update()
    loaded = time.time()
    stencil = v.vtkPolyDataToImageStencil(); stencil.SetInputConnection(reader.GetOutputPort()); stencil.SetTolerance(0)
    stencil.SetOutputOrigin(*(low + size / 2)); stencil.SetOutputSpacing(size, size, size)
    stencil.SetOutputWholeExtent(0, dims[0] - 1, 0, dims[1] - 1, 0, dims[2] - 1)
    image = v.vtkImageStencilToImage(); image.SetInputConnection(stencil.GetOutputPort())
    image.SetInsideValue(1); image.SetOutsideValue(0); image.SetOutputScalarTypeToUnsignedChar(); image.Update()
    return start, loaded, time.time(), vtk_to_numpy(image.GetOutput().GetPointData().GetScalars())


def open3d(path, corners, low, size, dims):
    import numpy as np, open3d as o3d
    start = time.time()
    scene = o3d.t.geometry.RaycastingScene()
    scene.add_triangles(o3d.t.geometry.TriangleMesh.from_legacy(o3d.io.read_triangle_mesh(path)))
    loaded = time.time()
    x, y, z = ((low[a] + size * (np.arange(dims[a]) + 0.5)).astype(np.float32) for a in range(3))
    flags = np.empty((dims[2], dims[1], dims[0]), np.uint8)
    for k, height in enumerate(z):
        points = np.stack(np.meshgrid(x, y, [height], indexing="ij"), -1)[:, :, 0]
        flags[k] = scene.compute_occupancy(o3d.core.Tensor(points)).numpy().T
    return start, loaded, time.time(), flags


def columns(path, corners, low, size, dims):
    import numpy as np, open3d as o3d
    start = time.time()
    scene = o3d.t.geometry.RaycastingScene()
    scene.add_triangles(o3d.t.geometry.TriangleMesh.from_legacy(o3d.io.read_triangle_mesh(path)))
    loaded = time.time()
    x, y = ((low[a] + size * (np.arange(dims[a]) + 0.5)).astype(np.float32) for a in range(2))
    base = np.stack(np.meshgrid(y, x, indexing="ij")[::-1], -1).reshape(-1, 2)
    rays = np.c_[base, np.full(len(base), low[2] - size), np.zeros((len(base), 2)), np.full(len(base), size)].astype(np.float32)
    hits = scene.list_intersections(o3d.core.Tensor(rays))
    flags = fill_columns(hits["ray_ids"].numpy().astype(int), hits["t_hit"].numpy() - 1, len(base), dims[2])
    return start, loaded, time.time(), flags.T.reshape(dims[2], dims[1], dims[0])


def trimesh(path, corners, low, size, dims):
    import trimesh as t
    start = time.time()
    mesh = t.load(path)
    loaded = time.time()
    flags = mesh.voxelized(size).fill().matrix
    return start, loaded, time.time(), flags.transpose(2, 1, 0)


def warp(path, corners, low, size, dims):
    import numpy as np, warp as wp
    wp.config.quiet = True
    wp.init()

    @wp.kernel
    def cast(mesh: wp.uint64, low: wp.vec3, h: float, depth: int, out: wp.array3d(dtype=wp.uint8)):
        j, i = wp.tid()
        origin = low + wp.vec3((float(i) + 0.5) * h, (float(j) + 0.5) * h, -h)
        travelled = float(0.0); inside = int(0); k = int(0)
        for _ in range(4096):
            query = wp.mesh_query_ray(mesh, origin + wp.vec3(0.0, 0.0, travelled), wp.vec3(0.0, 0.0, 1.0), 1.0e9)
            if not query.result:
                break
            travelled = travelled + query.t + 1.0e-5 * h
            last = wp.min(depth, int(wp.ceil((travelled - h) / h - 0.5)))
            while k < last:
                if inside == 1:
                    out[k, j, i] = wp.uint8(1)
                k += 1
            inside = 1 - inside

    device = "cuda" if wp.is_cuda_available() else "cpu"
    wp.load_module(device=device)
    start = time.time()
    points = np.ascontiguousarray(corners.reshape(-1, 3))
    mesh = wp.Mesh(points=wp.array(points, dtype=wp.vec3, device=device),
                   indices=wp.array(np.arange(len(points), dtype=np.int32), device=device))
    wp.synchronize()
    loaded = time.time()
    out = wp.zeros((int(dims[2]), int(dims[1]), int(dims[0])), dtype=wp.uint8, device=device)
    wp.launch(cast, dim=(int(dims[1]), int(dims[0])), inputs=[mesh.id, wp.vec3(*map(float, low)), float(size), int(dims[2]), out], device=device)
    flags = out.numpy()
    return start, loaded, time.time(), flags


def run(peer, path, n, runs, prefix):
    import numpy as np
    corners = read_stl(path)
    low, size, dims = grid(corners, n)
    seconds = []
    for _ in range(runs + 1 if runs > 1 else 1):
        flags = None
        start, loaded, done, flags = globals()[peer](path, corners, low, size, dims)
        seconds.append((loaded - start, done - loaded))
    first, kept = seconds[0], seconds[1:] or seconds
    read_s, mesh_s = (float(np.median([each[part] for each in kept])) for part in range(2))
    flags = np.ascontiguousarray(flags).astype(np.uint8, copy=False)
    if prefix:
        flags.tofile(f"{prefix}.{peer}.u8")
    print(json.dumps({"peer": peer, "n": n, "dims": [int(d) for d in dims], "read_s": round(read_s, 4), "mesh_s": round(mesh_s, 4),
                      "runs_s": [round(sum(each), 4) for each in kept], "first_s": round(sum(first), 4),
                      "cells_per_s": float(f"{flags.size / mesh_s:.3g}"), "inside": int(np.count_nonzero(flags)),
                      "peak_gb": round(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6, 2)}))


def option(args, name, default):
    """Takes `name VALUE` out of the arguments."""
    if name not in args:
        return default
    at = args.index(name)
    value = args[at + 1]
    del args[at:at + 2]
    return value


def main(args):
    prefix = option(args, "--flags", None)
    runs = int(option(args, "--runs", 1))
    if args and args[0] == "--one":
        return run(args[1], args[2], int(args[3]), runs, prefix)
    if len(args) < 2:
        sys.exit(__doc__)
    for peer in args[2:] or PEERS:
        command = [sys.executable, __file__, "--one", peer, args[0], args[1], "--runs", str(runs)] + (["--flags", prefix] if prefix else [])
        done = subprocess.run(command, capture_output=True, text=True)
        print(done.stdout.strip() or json.dumps({"peer": peer, "error": (done.stderr.strip().splitlines() or ["no output"])[-1]}), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
