// Prepares each (facet, bin) pair: edge functions and plane at the bin's first ray. Twin: `src/facet.rs`.
// Edge values are clamped to +-2^30: a bin changes them by less than 2^30, so a clamped value keeps its sign and the
// loops over rays need 32 bits only.
// Reads: corners, bin_offsets (total in the last entry), pairs.
// Writes, in as few words as the loops over rays can do with, since loading them is what those spend their time on:
//         edges[2 p ..] = (q0 q1 q2 a0) (a1 b0 b1 -); the third edge's a and b are minus the sum of the others';
//         planes[3 p ..] = (Q0 Q1 Q2 base cell) (slope j, area) (rest, cells, tag), where
//         Q = floor((height - base cell) * area) in cells, 96 bits; tag = tie above << 9 | rank << 1 | exits;
//         slope i = cells * area + rest, the step of the height from ray to ray, with 0 <= rest < area.

@group(0) @binding(2) var<storage, read> bin_offsets: array<u32>;
@group(0) @binding(3) var<storage, read> pairs: array<vec2<u32>>;
@group(0) @binding(4) var<storage, read_write> edges: array<vec4<i32>>;
@group(0) @binding(5) var<storage, read_write> planes: array<vec4<u32>>;

@compute @workgroup_size(64)
fn intersect_setup(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let n_pairs = min(bin_offsets[params.n_bins], params.pair_capacity);
    let n_threads = groups.x * groups.y * 64u;
    for (var pair = thread_index(group, groups, local); pair < n_pairs; pair += n_threads) {
        let bin = pairs[pair].y;
        let f = load_facet(pairs[pair].x);
        let column = i32(bin % params.n_across);
        let row = i32(bin / params.n_across);
        let ray = vec2<i32>(column * i32(BIN), i32(params.first_row) + row * i32(BIN));
        write_edges(pair, f, ray);
        write_plane(pair, f, ray);
    }
}

fn write_edges(pair: u32, f: Facet, ray: vec2<i32>) {
    let a = edge_a(f);
    let b = edge_b(f);
    let q0 = clamp_to_2_30(edge_q(a.x, b.x, f.x.x, f.y.x, ray));
    let q1 = clamp_to_2_30(edge_q(a.y, b.y, f.x.y, f.y.y, ray));
    let q2 = clamp_to_2_30(edge_q(a.z, b.z, f.x.z, f.y.z, ray));
    edges[2u * pair] = vec4<i32>(q0, q1, q2, a.x);
    edges[2u * pair + 1u] = vec4<i32>(a.y, b.x, b.y, 0);
}

fn write_plane(pair: u32, f: Facet, ray: vec2<i32>) {
    let dx = f.x - vec3<i32>(f.x.x);
    let dy = f.y - vec3<i32>(f.y.x);
    let dz = f.z - vec3<i32>(f.z.x);
    let slope_i = sub64(multiply_signed(dz.y, dy.z), multiply_signed(dz.z, dy.y));
    let slope_j = sub64(multiply_signed(dx.y, dz.z), multiply_signed(dx.z, dz.y));
    let base = min(f.z.x, min(f.z.y, f.z.z)) >> params.fraction_bits;
    var height = multiply96(f.area, f.z.x - (base << params.fraction_bits));
    height = add96(height, multiply96(slope_i, (ray.x << params.fraction_bits) - f.x.x));
    height = add96(height, multiply96(slope_j, (ray.y << params.fraction_bits) - f.y.x));
    let on_unit = (height.x & ((1u << params.fraction_bits) - 1u)) == 0u;
    let i_is_above = !is_negative(slope_i) && (slope_i.x | slope_i.y) != 0u;
    let j_is_above = !is_negative(slope_j) && (slope_j.x | slope_j.y) != 0u;
    let j_decides = params.axis == 2u && (slope_i.x | slope_i.y) == 0u;
    let tie_is_above = on_unit && params.axis != 0u && (i_is_above || (j_decides && j_is_above));
    let tag = (u32(tie_is_above) << 9u) | (f.rank << 1u) | u32(f.exits);
    let step = step_of(slope_i, f.area);
    planes[3u * pair] = vec4<u32>(shift_right96(height, params.fraction_bits), bitcast<u32>(base));
    planes[3u * pair + 1u] = vec4<u32>(slope_j, f.area);
    planes[3u * pair + 2u] = vec4<u32>(step.xyz, tag);
}

// Remainder and quotient of a slope by the area, rounding down. Where the quotient passes 2^18 it may be off and the remainder
// out of range, though slope = cells * area + rest still holds: then no two neighbouring rays hit the facet, and nobody
// takes the step.
fn step_of(slope: vec2<u32>, area: vec2<u32>) -> vec3<u32> {
    let falls = is_negative(slope);
    let size = select_wide(slope, negate64(slope), falls);
    let quotient = (f32(size.y) * 4294967296.0 + f32(size.x)) / (f32(area.y) * 4294967296.0 + f32(area.x));
    let mended = mend_quotient(size, u32(min(quotient, 1073741824.0)), area);
    var cells = mended.whole;
    var rest = mended.rest;
    if falls {
        let is_whole = (rest.x | rest.y) == 0u;
        cells = select(~cells, 0u - cells, is_whole);
        rest = select_wide(sub64(area, rest), rest, is_whole);
    }
    return vec3<u32>(rest, cells);
}

fn select_wide(if_false: vec2<u32>, if_true: vec2<u32>, condition: bool) -> vec2<u32> {
    return select(if_false, if_true, vec2<bool>(condition));
}
