// Prepares each tile, the part of a facet over a bin, for the kernel columns: which rays hit it (Eq. 16), and its height
// over the cells at the bin's first ray with its steps from ray to ray and from row to row (Eq. 17-19), as fixed-point
// numbers of 32 bits after the point, rounded down. Seven rays and seven rows on, such a height is less than
// 15 / 2^32 cell too low: where that could change a cell, `margin` below makes columns leave the row to columns_deep, which is
// exact. If all three numbers are exact, so are all heights.
// Twin: `src/facet.rs`.
// Reads: corners, bin_offsets (total in the last entry), pairs.
// Writes: tiles[2 p ..] = hits of rows 0 to 3, of rows 4 to 7, 8 bits a row; cell and fraction of the height;
//         cells of the steps, i in the low half, j in the high; fraction of step i; of step j; tag, where
//         tag = margin << 10 | tie above << 9 | rank << 1 | exits.

@group(0) @binding(4) var<storage, read_write> tiles: array<vec4<u32>>;

@compute @workgroup_size(64)
fn columns_setup(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let end = n_pairs();
    let n_threads = groups.x * groups.y * 64u;
    for (var pair = thread_index(group, groups, local); pair < end; pair += n_threads) {
        let f = load_facet(pairs[pair].x);
        let first = first_ray(pairs[pair].y);
        write_tile(pair, hits_of(facet_edges(f, first), first), f, facet_plane(f, first));
    }
}

// The rays that hit the facet, 8 bits a row.
fn hits_of(e: Edges, first: vec2<i32>) -> vec2<u32> {
    let i = vec4<i32>(0, 1, 2, 3);
    let a0 = e.a.x * i;
    let a1 = e.a.y * i;
    let a2 = e.a.z * i;
    // a facet may hit places past the end of the row
    let n_inside = u32(min(i32(params.n_i) - first.x, i32(BIN)));
    let inside = (1u << n_inside) - 1u;
    var hits = vec2<u32>(0u, 0u);
    var q = e.q;
    for (var row = 0u; row < BIN; row++) {
        let low = (q.x + a0) | (q.y + a1) | (q.z + a2);
        let high = (q.x + 4 * e.a.x + a0) | (q.y + 4 * e.a.y + a1) | (q.z + 4 * e.a.z + a2);
        let bits = (bits_of_signs(~low) | (bits_of_signs(~high) << 4u)) & inside;
        hits = vec2<u32>((hits.x >> 8u) | (hits.y << 24u), (hits.y >> 8u) | (bits << 24u));
        q += e.b;
    }
    return hits;
}

fn bits_of_signs(v: vec4<i32>) -> u32 {
    let signs = bitcast<vec4<u32>>(v) >> vec4<u32>(31u);
    return signs.x | (signs.y << 1u) | (signs.z << 2u) | (signs.w << 3u);
}

// A number of cells, rounded down to 2^-32.
struct Fixed {
    cells: u32,
    fraction: u32,
    is_exact: bool,
}

fn write_tile(pair: u32, hits: vec2<u32>, f: Facet, plane: FacetPlane) {
    var height = fixed(plane.height, f.area);
    var step_i = fixed(widen96(plane.slope_i), f.area);
    var step_j = fixed(widen96(plane.slope_j), f.area);
    let is_exact = height.is_exact && step_i.is_exact && step_j.is_exact;
    var margin = select(16u + u32(plane.tie_is_above), 0u, is_exact);
    if is_steep(plane.slope_i, f.area) || is_steep(plane.slope_j, f.area) {
        // always within the margin
        height = Fixed(0u, 0xfffffff0u, false);
        step_i = Fixed(0u, 0u, false);
        step_j = Fixed(0u, 0u, false);
        margin = 16u;
    }
    let tag = (margin << 10u) | tag_of(f, plane);
    let steps = (step_i.cells & 0xffffu) | (step_j.cells << 16u);
    tiles[2u * pair] = vec4<u32>(hits, height.cells + bitcast<u32>(plane.base), height.fraction);
    tiles[2u * pair + 1u] = vec4<u32>(steps, step_i.fraction, step_j.fraction, tag);
}

// Whether a step may have more than 2^14 cells, which do not fit the steps, nor the heights at the corners of the bin.
fn is_steep(slope: vec2<u32>, area: vec2<u32>) -> bool {
    return float96(magnitude96(widen96(slope))) >= 16000.0 * float96(vec3<u32>(area, 0u));
}

// value / area for a quotient within +-2^19, where the guesses in f32 are off by one at most; any other is garbage, and so
// is the tile's height, but no ray hits it.
fn fixed(value: vec3<u32>, area: vec2<u32>) -> Fixed {
    let q = floor_quotient(value, area);
    let divisor = float96(vec3<u32>(area, 0u));
    let high = next_16_bits(q.rest, divisor, area);
    let low = next_16_bits(high.rest, divisor, area);
    return Fixed(q.whole, (high.whole << 16u) | low.whole, (low.rest.x | low.rest.y) == 0u);
}

// 16 more bits of a quotient: rest * 2^16 / area and its rest.
fn next_16_bits(rest: vec2<u32>, divisor: f32, area: vec2<u32>) -> Quotient {
    let value = vec2<u32>(rest.x << 16u, (rest.y << 16u) | (rest.x >> 16u));
    return mend_quotient(value, u32(float96(vec3<u32>(rest, 0u)) * 65536.0 / divisor), area);
}
