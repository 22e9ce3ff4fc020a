// A facet as the rays of one bin see it: its edge functions and its plane at the bin's first ray. Twin: `src/facet.rs`.

// Reads: bin_offsets (total in the last entry), pairs: facet and bin of the band.

@group(0) @binding(2) var<storage, read> bin_offsets: array<u32>;
@group(0) @binding(3) var<storage, read> pairs: array<vec2<u32>>;

// Edge values are clamped to +-2^30: a bin changes them by less than 2^30, so a clamped value keeps its sign and the
// loops over rays need 32 bits only.
struct Edges {
    q: vec3<i32>,
    a: vec3<i32>,       // steps of q from ray to ray
    b: vec3<i32>,       // and from row to row
}

struct FacetPlane {
    height: vec3<u32>,  // over the base cell, times the area, rounded down to cells
    base: i32,          // cell
    slope_i: vec2<u32>, // steps of the height from ray to ray
    slope_j: vec2<u32>, // and from row to row
    tie_is_above: bool, // whether a centre that the facet goes through lies above it
}

// Pairs that the buffers hold.
fn n_pairs() -> u32 {
    return min(bin_offsets[params.n_bins], params.pair_capacity);
}

// What of a facet and its plane goes with every crossing: tie above << 9 | rank << 1 | exits.
fn tag_of(f: Facet, plane: FacetPlane) -> u32 {
    return (u32(plane.tie_is_above) << 9u) | (f.rank << 1u) | u32(f.exits);
}

// First ray of a bin of the band, in the domain.
fn first_ray(bin: u32) -> vec2<i32> {
    let column = i32(bin % params.n_across);
    let row = i32(bin / params.n_across);
    return vec2<i32>(column * i32(BIN), i32(params.first_row) + row * i32(BIN));
}

fn facet_edges(f: Facet, ray: vec2<i32>) -> Edges {
    let a = edge_a(f);
    let b = edge_b(f);
    let q0 = clamp_to_2_30(edge_q(a.x, b.x, f.x.x, f.y.x, ray));
    let q1 = clamp_to_2_30(edge_q(a.y, b.y, f.x.y, f.y.y, ray));
    let q2 = clamp_to_2_30(edge_q(a.z, b.z, f.x.z, f.y.z, ray));
    return Edges(vec3<i32>(q0, q1, q2), a, b);
}

fn facet_plane(f: Facet, ray: vec2<i32>) -> FacetPlane {
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
    return FacetPlane(shift_right96(height, params.fraction_bits), base, slope_i, slope_j, tie_is_above);
}
