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
    if ray >= params.n_i * params.end_row {
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

// Height over the facet's lowest whole cell times the area, divided by it.
fn crossing(f: Facet, ray: vec2<i32>) -> u32 {
    let plane = plane_of(f, ray);
    let q = floor_quotient(plane.height, f.area);
    let above = i32(q.whole) + select(1, 0, (plane.tag >> 9u) == 1u && (q.rest.x | q.rest.y) == 0u);
    return (u32(clamp(plane.base + above, 0, i32(params.depth))) << 9u) | (plane.tag & 0x1ffu);
}
