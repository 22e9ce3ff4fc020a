#!/usr/bin/env python3
"""Other programs doing hexcast's job, to be timed beside it in one run.

usage: peers.py FILE.stl N [PEER ...] [--runs K] [--enough SECONDS] [--limit SECONDS] [--flags PREFIX]

The grid is hexcast's `--cells N`: cubic cells of (longest side / N), lines from the box's minimum, ceil() cells per axis.
Each peer runs in a process of its own and prints one JSON line: seconds of every run to read the file and to mesh it into u8
flags in memory, the first, which counts for nothing where there are more, apart; cells, inside cells, peak resident memory.
No run begins after --enough seconds of runs; --limit ends a peer, start of Python included.
--flags writes PREFIX.PEER.u8 (x fastest) to compare cell by cell, which means something where same_grid is true.
Set-up: `npm run bench` makes .tools/peers with all that can be had for its Python. By hand:
python3 -m venv V && V/bin/pip install numpy scipy vtk open3d-cpu trimesh warp-lang   (binary STL only; open3d where there is no open3d-cpu)

peer      what it is                                                      known weakness
vtk       vtkPolyDataToImageStencil, slices, all cores: the one to beat     dense bytes, one mask a call
open3d    RaycastingScene.compute_occupancy, Embree, one ray a cell         slow; f32
columns   RaycastingScene.list_intersections, one ray a column             wrong where rays meet edges (f32)
trimesh   voxelized(h).fill()                                              surface cells included; its own origin; memory
warp      mesh_query_ray along each column, restarted after every hit      f32 and an epsilon; one core, or CUDA
"""
import functools, json, subprocess, sys, time

PEERS = ["vtk", "open3d", "columns", "trimesh", "warp"]
MODULES = {"vtk": "vtkmodules", "open3d": "open3d", "columns": "open3d", "trimesh": "trimesh", "warp": "warp"}


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


def vtk(path, low, size, dims):
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
    return start, loaded, time.time(), vtk_to_numpy(image.GetOutput().GetPointData().GetScalars()).reshape(dims[::-1])


def open3d(path, low, size, dims):
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


def columns(path, low, size, dims):
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


def trimesh(path, low, size, dims):
    import trimesh as t
    start = time.time()
    mesh = t.load(path)
    loaded = time.time()
    flags = mesh.voxelized(size).fill().matrix
    return start, loaded, time.time(), flags.transpose(2, 1, 0)


@functools.cache
def warp_kernel():
    """Compiles the kernel, or takes it from Warp's cache, and returns it with its device."""
    import warp as wp
    wp.init()

    @wp.kernel
    def cast(mesh: wp.uint64, low: wp.vec3, h: float, epsilon: float, depth: int, out: wp.array3d(dtype=wp.uint8)):
        j, i = wp.tid()
        origin = low + wp.vec3((float(i) + 0.5) * h, (float(j) + 0.5) * h, -h)
        travelled = float(0.0); inside = int(0); k = int(0)
        for _ in range(4096):
            query = wp.mesh_query_ray(mesh, origin + wp.vec3(0.0, 0.0, travelled), wp.vec3(0.0, 0.0, 1.0), 1.0e9)
            if not query.result:
                break
            travelled = travelled + query.t + epsilon
            last = wp.min(depth, int(wp.ceil((travelled - h) / h - 0.5)))
            while k < last:
                if inside == 1:
                    out[k, j, i] = wp.uint8(1)
                k += 1
            inside = 1 - inside

    device = "cuda" if wp.is_cuda_available() else "cpu"
    wp.load_module(device=device)
    return cast, device


def warp(path, low, size, dims):
    import numpy as np, warp as wp
    cast, device = warp_kernel()
    start = time.time()
    points = np.ascontiguousarray(read_stl(path).reshape(-1, 3))
    mesh = wp.Mesh(points=wp.array(points, dtype=wp.vec3, device=device),
                   indices=wp.array(np.arange(len(points), dtype=np.int32), device=device))
    wp.synchronize()
    loaded = time.time()
    # a few steps of f32 at the far end of the box: with less, a ray finds the same facet for ever
    epsilon = 1e-6 * float(np.abs(points).max() + size * dims[2])
    out = wp.zeros((int(dims[2]), int(dims[1]), int(dims[0])), dtype=wp.uint8, device=device)
    wp.launch(cast, dim=(int(dims[1]), int(dims[0])), inputs=[mesh.id, wp.vec3(*map(float, low)), float(size), epsilon, int(dims[2]), out], device=device)
    flags = out.numpy()
    return start, loaded, time.time(), flags


def peak_bytes():
    """Returns the most memory that this process has had, or None where the system does not tell."""
    try:
        # not ru_maxrss: on Linux it begins with what the process had before it became this one
        return 1024 * next(int(line.split()[1]) for line in open("/proc/self/status") if line.startswith("VmHWM:"))
    except (OSError, StopIteration):
        pass
    try:
        import resource
    except ImportError:
        return None
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)


def run(peer, path, n, runs, enough, prefix):
    import numpy as np
    low, size, dims = grid(read_stl(path), n)
    seconds = []
    while len(seconds) <= (runs if runs > 1 else 0) and sum(map(sum, seconds)) < enough:
        flags = None
        start, loaded, done, flags = globals()[peer](path, low, size, dims)
        seconds.append((loaded - start, done - loaded))
    peak = peak_bytes()
    first, kept = seconds[0], seconds[1:] or seconds
    read_s, mesh_s = (float(np.median([each[part] for each in kept])) for part in range(2))
    flags = np.ascontiguousarray(flags).astype(np.uint8, copy=False)
    if prefix:
        flags.tofile(f"{prefix}.{peer}.u8")
    print(json.dumps({"peer": peer, "version": sys.modules[MODULES[peer]].__version__, "n": n, "dims": list(flags.shape[::-1]),
                      "same_grid": peer != "trimesh" and flags.shape == tuple(dims[::-1]),
                      "device": warp_kernel()[1] if peer == "warp" else "cpu",
                      "read_s": round(read_s, 4), "mesh_s": round(mesh_s, 4),
                      "runs_s": [round(sum(each), 4) for each in kept], "first_s": round(sum(first), 4),
                      "cells_per_s": float(f"{flags.size / mesh_s:.3g}"), "inside": int(np.count_nonzero(flags)),
                      "peak_mib": peak and round(peak / 2**20)}))


def described(command, limit):
    """Runs one peer and returns its JSON line, or one with the error."""
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=limit)
    except subprocess.TimeoutExpired:
        return json.dumps({"peer": command[3], "error": f"not done after {limit:g} s"})
    lines = done.stdout.strip().splitlines()
    if done.returncode == 0 and lines and lines[-1].startswith("{"):
        return lines[-1]
    said = (done.stderr.strip().splitlines() or ["nothing said"])[-1]
    how = f"ended by signal {-done.returncode}" if done.returncode < 0 else f"ended with code {done.returncode}"
    return json.dumps({"peer": command[3], "error": f"{how}: {said}"})


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
    enough = float(option(args, "--enough", "inf"))
    limit = option(args, "--limit", None)
    if args and args[0] == "--one":
        return run(args[1], args[2], int(args[3]), runs, enough, prefix)
    if len(args) < 2:
        sys.exit(__doc__)
    for peer in args[2:] or PEERS:
        command = [sys.executable, __file__, "--one", peer, args[0], args[1], "--runs", str(runs), "--enough", str(enough)]
        print(described(command + (["--flags", prefix] if prefix else []), limit and float(limit)), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
