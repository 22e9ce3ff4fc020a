"""The mesh: arrays of the right shapes that agree with each other."""

from __future__ import annotations

import json
import subprocess

import numpy as np
import ome_zarr_models
import ome_zarr_models.v05.image_label
import pytest
import xarray
import zarr

import hexcast
from hexcast.shapes import box, sphere


@pytest.fixture(scope="module", params=["x", "y", "z"])
def mesh(request):
    """One of odd sizes, on lines that are not whole numbers, whose cells differ along all axes."""
    bodies = [{"source": sphere((0.3, 0, 0), 1.0), "flag": 4}, {"source": box((-2, 0.1, -1), (0, 1, 0.2)), "flag": 200}]
    return hexcast.mesh(bodies, dims=(23, 17, 11), axis=request.param, unit="mm", backend="cpu")


def test_lines_are_the_boundaries_of_cells(mesh):
    assert mesh.dims == (23, 17, 11)
    assert mesh.flags.shape == (11, 17, 23)
    for axis, lines in enumerate(mesh.lines):
        assert lines.dtype == np.float64
        assert lines.shape == (mesh.dims[axis] + 1,)
        np.testing.assert_array_equal(lines, mesh.origin[axis] + np.arange(len(lines)) * mesh.spacing[axis])


def test_flags_are_made_once_and_cannot_be_written_to(mesh):
    assert mesh.flags is mesh.flags
    with pytest.raises(ValueError, match="read-only"):
        mesh.flags[0, 0, 0] = 1
    assert {int(flag) for flag in np.unique(mesh.flags)} == {0, 4, 200}
    counted = {facts["flag"]: facts["cells"] for facts in mesh.report["flags"]}
    assert counted == {flag: int((mesh.flags == flag).sum()) for flag in (4, 200)}


def test_boxes_and_slabs_are_parts_of_the_flags(mesh):
    random = np.random.default_rng(7)
    for _ in range(100):
        ends = np.sort(random.integers(0, np.array(mesh.dims) + 1, (2, 3)), axis=0)
        (i0, j0, k0), (i1, j1, k1) = ends.tolist()
        np.testing.assert_array_equal(mesh.box(*ends), mesh.flags[k0:k1, j0:j1, i0:i1])
    mesh.box((0, 0, 0), (1, 1, 1))[:] = 9
    for max_bytes in (1, 23 * 17 * 3, 1 << 20):
        slabs = list(mesh.slabs(max_bytes))
        np.testing.assert_array_equal(np.concatenate([slab.flags for slab in slabs]), mesh.flags)
        assert [slab.first[2] for slab in slabs[1:]] == [slab.end[2] for slab in slabs[:-1]]
        assert slabs[-1].end == mesh.dims


@pytest.mark.parametrize(
    ("first", "end"),
    [((0, 0, 0), (24, 1, 1)), ((-1, 0, 0), (1, 1, 1)), ((2, 0, 0), (1, 1, 1)), ((0, 0), (1, 1, 1)), ("abc", (1, 1, 1))],
)
def test_a_box_that_is_not_inside_is_an_error(mesh, first, end):
    with pytest.raises(hexcast.Error) as caught:
        mesh.box(first, end)
    assert caught.value.code == "job-value"


def test_columns_hold_the_flags(mesh):
    axis, offsets, starts, flags = mesh.columns
    assert mesh.report["ray_axis"] == "xyz"[axis]
    assert (offsets.dtype, starts.dtype, flags.dtype) == (np.uint64, np.uint32, np.uint8)
    assert len(starts) == len(flags) == offsets[-1] == mesh.report["runs"]
    depth = mesh.dims[axis]
    # rays over the other axes, the earlier one fastest: the flags with the axis of the rays last
    expected = np.moveaxis(mesh.flags, 2 - axis, 2).reshape(-1, depth)
    assert len(offsets) == len(expected) + 1
    for ray, cells in enumerate(expected):
        runs = slice(int(offsets[ray]), int(offsets[ray + 1]))
        filled = np.zeros(depth, np.uint8)
        for start, flag in zip(starts[runs], flags[runs]):
            filled[start:] = flag
        np.testing.assert_array_equal(filled, cells)


def test_xarray_has_what_zarr_has(mesh, tmp_path):
    mesh.save(tmp_path / "mesh.zarr")
    stored = xarray.open_zarr(tmp_path / "mesh.zarr", consolidated=False)
    data = mesh.to_xarray()
    assert data.flag.dims == ("z", "y", "x")
    for name in ("flag", "x", "y", "z"):
        np.testing.assert_array_equal(data[name].values, stored[name].values)
    assert data.x.attrs == {"units": "mm"}
    assert data.flag.attrs["flag_values"].tolist() == [0, 4, 200]
    assert data.flag.attrs["flag_meanings"] == "background surface_1 surface_2"
    assert np.shares_memory(data.flag.values, mesh.flags)


def coarser(flags, rule, n_of):
    """Cells of twice the size, from the definition: eight cells, or as many as there are, by the cells of each flag in the mesh."""
    padded = np.full([2 * ((n + 1) // 2) for n in flags.shape], 255, np.uint8)
    padded[tuple(slice(0, n) for n in flags.shape)] = flags
    nz, ny, nx = (n // 2 for n in padded.shape)
    eight = padded.reshape(nz, 2, ny, 2, nx, 2).transpose(0, 2, 4, 1, 3, 5).reshape(nz, ny, nx, 8)
    best, of = np.zeros((nz, ny, nx), np.uint8), np.zeros((nz, ny, nx), int)
    # the rarest first: later ones must have more
    for flag in sorted((flag for flag in n_of if flag), key=lambda flag: (n_of[flag], flag)):
        n = (eight == flag).sum(-1)
        wins = (of == 0) & (n > 0) if rule == "any" else n > of
        best[wins], of[wins] = flag, n[wins]
    if rule == "majority":
        best[(eight == 0).sum(-1) > of] = 0
    return best


@pytest.mark.parametrize("rule", ["any", "majority"])
def test_stores_are_those_of_ome_zarr_with_levels(rule, tmp_path):
    bodies = [{"source": box((-15, -10, -4), (15, 10, 5)), "flag": 4}, {"source": sphere((0, 0, 6), 4.0), "flag": 2}]
    mesh = hexcast.mesh(bodies, cells=150, padding={"cells": 3}, unit="mm", backend="cpu", zarr={"levels": rule})
    mesh.save(tmp_path / "mesh.zarr")
    group = zarr.open_group(tmp_path / "mesh.zarr", mode="r")
    # the validator of the format
    image = ome_zarr_models.open_ome_zarr(group)
    assert isinstance(image, ome_zarr_models.v05.image_label.ImageLabel)
    (multiscale,) = image.ome_attributes.multiscales
    assert [axis.unit for axis in multiscale.axes] == ["millimeter"] * 3
    assert multiscale.type == rule
    label = image.ome_attributes.image_label
    assert [of.label_value for of in label.colors] == [2, 4]
    flags, n_of = mesh.flags, dict(zip(*(list(map(int, of)) for of in np.unique(mesh.flags, return_counts=True))))
    assert [dataset.path for dataset in multiscale.datasets] == ["flag", "levels/1/flag", "levels/2/flag"]
    for level, dataset in enumerate(multiscale.datasets):
        flags = coarser(flags, rule, n_of) if level else flags
        np.testing.assert_array_equal(group[dataset.path][:], flags)
        scale, translation = dataset.coordinateTransformations
        for axis, name in enumerate("zyx"):
            middles = group[dataset.path.replace("flag", name)][:]
            np.testing.assert_allclose(translation.translation[axis] + scale.scale[axis] * np.arange(len(middles)), middles, atol=1e-12)
    # xarray finds the places of each level
    stored = xarray.open_zarr(tmp_path / "mesh.zarr", group="levels/1")
    assert stored.flag.dims == ("z", "y", "x") and stored.x.size == -(-mesh.dims[0] // 2)


def test_estimates_and_parts(spot):
    estimate = hexcast.estimate(spot, cells=200)
    mesh = hexcast.mesh(spot, cells=200, backend="cpu")
    assert estimate["cells"] == mesh.report["cells"]
    windows = hexcast.parts(spot, (2, 1, 3), cells=50)
    whole = hexcast.mesh(spot, cells=50, backend="cpu").flags
    joined = np.full_like(whole, 255)
    for number, window in enumerate(windows, 1):
        i0, j0, k0, i1, j1, k1 = window
        flags = hexcast.mesh(spot, cells=50, window=window, backend="cpu").flags
        joined[k0:k1, j0:j1, i0:i1] = flags
        part = hexcast.mesh(spot, cells=50, part=f"{number}/2x1x3", backend="cpu")
        np.testing.assert_array_equal(part.flags, flags)
    np.testing.assert_array_equal(joined, whole)
    with pytest.raises(hexcast.Error, match="n is 0"):
        hexcast.parts(spot, 0)


def test_reports_of_parts_with_a_halo_merge_into_that_of_the_whole(spot, program, tmp_path):
    options = {"cells": 40, "axis": "z", "backend": "cpu"}
    names = []
    for part in ["1/3", "2/3", "3/3"]:
        mesh = hexcast.mesh(spot, part=part, halo=1, **options)
        names.append(tmp_path / f"{part[0]}.json")
        names[-1].write_text(json.dumps(mesh.report))
    merged = json.loads(subprocess.run([program, "merge", *names], check=True, capture_output=True).stdout)
    whole = hexcast.mesh(spot, **options).report
    for key in ["cells", "dims", "flags", "runs", "crossings", "flags_hash", "findings", "geometries"]:
        assert merged[key] == json.loads(json.dumps(whole[key])), key


# the surface is open, which meshes say
@pytest.mark.filterwarnings("ignore::hexcast.MeshWarning")
@pytest.mark.parametrize("backend", ["cpu", "gpu"])
def test_windows_have_the_flags_and_lines_of_the_whole(part, backend):
    options = {"cells": 48, "padding": {"cells": 3}, "backend": backend}
    surface = hexcast.surface(part)
    whole = hexcast.mesh(surface, **options)
    random = np.random.default_rng(11)
    for _ in range(12):
        first = random.integers(0, whole.dims)
        end = random.integers(first + 1, np.array(whole.dims) + 1)
        (i0, j0, k0), (i1, j1, k1) = first.tolist(), end.tolist()
        axis = "xyz"[random.integers(3)]
        mesh = hexcast.mesh(surface, window=[*first, *end], axis=axis, **options)
        np.testing.assert_array_equal(mesh.flags, whole.flags[k0:k1, j0:j1, i0:i1])
        window = mesh.report["window"]
        assert [window[key] for key in ("first", "end", "of")] == [[i0, j0, k0], [i1, j1, k1], list(whole.dims)]
        for ours, lines, a, b in zip(mesh.lines, whole.lines, (i0, j0, k0), (i1, j1, k1)):
            np.testing.assert_allclose(ours, lines[a : b + 1], rtol=1e-14, atol=1e-14)


@pytest.mark.parametrize("edge", ["background", "clamp"])
def test_a_halo_is_background_or_the_nearest_flags_beyond_the_box(spot, edge):
    options = {"cells": 30, "backend": "cpu", "domain": (-0.2, -0.5, -0.3, 0.3, 0.4, 0.2)}
    whole = hexcast.mesh(spot, **options)
    nx, ny, nz = whole.dims
    mesh = hexcast.mesh(spot, window=(0, 0, 0, nx, ny, nz), halo=3, halo_edge=edge, **options)
    mode = {"background": "constant", "clamp": "edge"}[edge]
    np.testing.assert_array_equal(mesh.flags, np.pad(whole.flags, 3, mode=mode))
    # the surface reaches beyond the box, so that the two differ
    assert whole.flags[0].any() and whole.flags[:, 0].any()
    assert mesh.report["job"]["halo_edge"] == edge
