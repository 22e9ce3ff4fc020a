// The intersection as the paper has it: a thread a ray loops over the facets of its bin (Eq. 16-19). Nothing is prepared a
// bin, so every ray orients and projects every facet anew. Same integers and tie rule as the kernels that ship, one pass,
// and a fixed number of places a ray instead of count, scan, emit. For the bench only.
// Reads: corners; bin_offsets[bin], n_bins + 1 entries; bin_facets, bin after bin.
// Writes: ray_counts[ray]; events[SLOTS * ray ..], the first SLOTS crossings of a ray in the order of its bin.

@group(0) @binding(2) var<storage, read> bin_offsets: array<u32>;
@group(0) @binding(3) var<storage, read> bin_facets: array<u32>;
@group(0) @binding(4) var<storage, read_write> ray_counts: array<u32>;
@group(0) @binding(5) var<storage, read_write> events: array<u32>;

const SLOTS: u32 = 16u;

@compute @workgroup_size(64)
fn naive_gather(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let ray = thread_index(group, groups, local);
    if ray >= params.n_i * params.n_j {
        return;
    }
    let place = vec2<u32>(ray % params.n_i, ray / params.n_i);
    let bin = place.y / BIN * params.n_across + place.x / BIN;
    var n = 0u;
    for (var entry = bin_offsets[bin]; entry < bin_offsets[bin + 1u]; entry++) {
        let f = load_facet(bin_facets[entry]);
        if is_hit(f, vec2<i32>(place)) {
            if n < SLOTS {
                events[SLOTS * ray + n] = crossing(f, vec2<i32>(place));
            }
            n += 1u;
        }
    }
    ray_counts[ray] = n;
}

fn is_hit(f: Facet, ray: vec2<i32>) -> bool {
    let a = edge_a(f);
    let b = edge_b(f);
    let q0 = edge_q(a.x, b.x, f.x.x, f.y.x, ray);
    let q1 = edge_q(a.y, b.y, f.x.y, f.y.y, ray);
    let q2 = edge_q(a.z, b.z, f.x.z, f.y.z, ray);
    return ((q0.y | q1.y | q2.y) >> 31u) == 0u;
}

// Height over the facet's lowest whole cell times the area, divided by it: guessed in f32, mended by one exact step.
fn crossing(f: Facet, ray: vec2<i32>) -> u32 {
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
    let whole = shift_right96(height, params.fraction_bits);
    let value = (f32(whole.z) * 4294967296.0 + f32(whole.y)) * 4294967296.0 + f32(whole.x);
    var cells = u32(value / (f32(f.area.y) * 4294967296.0 + f32(f.area.x)));
    var rest = sub64(whole.xy, multiply_unsigned(cells, f.area.x) + vec2<u32>(0u, cells * f.area.y));
    if is_negative(rest) {
        cells -= 1u;
        rest = add64(rest, f.area);
    } else if at_least64(rest, f.area) {
        cells += 1u;
        rest = sub64(rest, f.area);
    }
    let on_centre = on_unit && (rest.x | rest.y) == 0u;
    let above = i32(cells) + select(1, 0, on_centre && tie_is_above(slope_i, slope_j));
    return u32(clamp(base + above, 0, i32(params.depth))) << 9u | f.rank << 1u | u32(f.exits);
}

fn tie_is_above(slope_i: vec2<u32>, slope_j: vec2<u32>) -> bool {
    let i_is_zero = (slope_i.x | slope_i.y) == 0u;
    let i_is_above = !is_negative(slope_i) && !i_is_zero;
    let j_is_above = !is_negative(slope_j) && (slope_j.x | slope_j.y) != 0u;
    return params.axis != 0u && (i_is_above || (params.axis == 2u && i_is_zero && j_is_above));
}
