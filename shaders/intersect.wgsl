// Completes each tile, the part of a facet over a bin, for the kernel map: its height over the cells at the bin's first ray with its
// steps from ray to ray and from row to row (Eq. 17-19), as fixed-point numbers of 32 bits after the point, rounded down. Seven
// rays and seven rows on, such a height is less than 15 / 2^32 cell too low: where that could change a cell, the margin makes map
// leave the row to the deep kernels, which are exact. If all three numbers are exact, so are all heights.
// Twin: `crates/core/src/stages/facet.rs`.
// Reads: corners, bin_offsets, found and its totals (see lattice).
// Writes: tiles[2 t ..] = hits of rows 0 to 3, of rows 4 to 7, 8 bits a row; cell and fraction of the height;
//         cells of the steps, i in the low half, j in the high; fraction of step i; of step j; tag, where
//         tag = margin << 10 | tie above << 9 | rank << 1 | exits.
// Bound: tile_capacity / threads loops an invocation, 2^12 at most.

@group(0) @binding(2) var<storage, read> bin_offsets: array<u32>;
@group(0) @binding(3) var<storage, read> found: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read_write> tiles: array<vec4<u32>>;
@group(0) @binding(5) var<storage, read> found_totals: array<u32>;

@compute @workgroup_size(64)
fn intersect(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    // neighbours of the list are neighbours in memory: a workgroup takes some of them
    let n_groups = groups.x * groups.y;
    let n_found = min(found_totals[0], params.tile_capacity);
    let share = (n_found + n_groups * 64u - 1u) / (n_groups * 64u) * 64u;
    let start = (group.y * groups.x + group.x) * share;
    let end = min(start + share, n_found);
    for (var i = start + local; i < end; i += 64u) {
        let of_bin = found[i];
        let f = load_facet(of_bin.x);
        let bin = of_bin.y >> RANK_BITS;
        let tile = bin_offsets[bin * params.n_layers + f.layer] + (of_bin.y & (MAX_TILES - 1u));
        if tile < params.tile_capacity {
            write_tile(tile, of_bin.zw, f.area, plane_of(f, first_ray(bin)));
        }
    }
}

// A number of cells, rounded down to 2^-32.
struct Fixed {
    cells: u32,
    fraction: u32,
    is_exact: bool,
}

fn write_tile(tile: u32, hits: vec2<u32>, area: vec2<u32>, plane: Plane) {
    var height = fixed(plane.height, area);
    var step_i = fixed(widen96(plane.slope_i), area);
    var step_j = fixed(widen96(plane.slope_j), area);
    let is_exact = height.is_exact && step_i.is_exact && step_j.is_exact;
    var margin = select(16u + (plane.tag >> 9u), 0u, is_exact);
    if is_steep(plane.slope_i, area) || is_steep(plane.slope_j, area) {
        // always within the margin
        height = Fixed(0u, 0xfffffff0u, false);
        step_i = Fixed(0u, 0u, false);
        step_j = Fixed(0u, 0u, false);
        margin = 16u;
    }
    let tag = (margin << 10u) | plane.tag;
    let steps = (step_i.cells & 0xffffu) | (step_j.cells << 16u);
    tiles[2u * tile] = vec4<u32>(hits, height.cells + bitcast<u32>(plane.base), height.fraction);
    tiles[2u * tile + 1u] = vec4<u32>(steps, step_i.fraction, step_j.fraction, tag);
}

// Whether a step may have more than 2^14 cells, which do not fit the steps, nor the heights at the corners of the bin.
fn is_steep(slope: vec2<u32>, area: vec2<u32>) -> bool {
    return float96(magnitude96(widen96(slope))) >= 16000.0 * float96(vec3<u32>(area, 0u));
}

// value / area for a quotient within +-2^19; any other is garbage, and so is the tile's height, but no ray hits it.
fn fixed(value: vec3<u32>, area: vec2<u32>) -> Fixed {
    let q = floor_quotient(value, area);
    let high = next_16_bits(q.rest, area);
    let low = next_16_bits(high.rest, area);
    return Fixed(q.whole, (high.whole << 16u) | low.whole, (low.rest.x | low.rest.y) == 0u);
}

// 16 more bits of a quotient: rest * 2^16 / area and its rest.
fn next_16_bits(rest: vec2<u32>, area: vec2<u32>) -> Quotient {
    return small_quotient(vec2<u32>(rest.x << 16u, (rest.y << 16u) | (rest.x >> 16u)), float64(rest) * 65536.0, area);
}
