// Casts all rows of rays against a batch of facets where cells differ in size, with exact heights in units, and writes their
// crossings row by row: what intersect_deep does for equal cells.
// Twin: `crates/core/src/stages/crossings/graded.rs`.
// Reads: corners, item_offsets, centres (see graded.wgsl).
// Reads and writes: next_event, events (see events.wgsl).
// Bound: that of items.wgsl and graded.wgsl, and for each bin 64 crossings with a search each: an item is a thread's work.

@compute @workgroup_size(64)
fn intersect_graded(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    walk_items(thread_index(group, groups, local), groups.x * groups.y * 64u);
}

fn visit(facet: u32, f: Facet, bin: u32, hits: vec2<u32>) {
    // over the first corner, so that rays are counted from there
    let plane = plane_at(f, vec2<i32>(f.x.x, f.y.x), min(f.z.x, min(f.z.y, f.z.z)));
    let first = vec2<u32>(first_ray(bin));
    for (var row = 0u; row < BIN; row++) {
        var left = hits_of_row(hits, row);
        if left == 0u {
            continue;
        }
        let height = add96(plane.height, multiply96(plane.slope_j, row_place(first.y + row) - f.y.x));
        let chunk = (first.y + row - params.first_row) * params.n_across + bin % params.n_across;
        for (var place = atomicAdd(&next_event[chunk], countOneBits(left)); left != 0u; place++) {
            let ray = firstTrailingBit(left);
            left &= left - 1u;
            if place < params.event_capacity {
                let at_ray = add96(height, multiply96(plane.slope_i, ray_place(first.x + ray) - f.x.x));
                write_event(place, ray, first_cell_above(plane, at_ray, f.area), plane.tag, facet);
            }
        }
    }
}

// The first cell above a height: a centre at the height is above it only by the tie rule.
fn first_cell_above(plane: Plane, height: vec3<u32>, area: vec2<u32>) -> u32 {
    let q = units(height, area);
    let centre_is_above = (q.rest.x | q.rest.y) == 0u && (plane.tag >> 9u) == 1u;
    return first_cell_from(plane.base + bitcast<i32>(q.whole) + select(1, 0, centre_is_above));
}

// Quotient and remainder of a height, not negative, by the area, for quotients below 2^32: one of those that wide.wgsl has holds 2^19
// only, so the low 13 bits come second.
fn units(height: vec3<u32>, area: vec2<u32>) -> Quotient {
    let high = floor_quotient(shift_right96(height, 13u), area);
    let low = height.x & 0x1fffu;
    let rest = vec2<u32>((high.rest.x << 13u) | low, (high.rest.y << 13u) | (high.rest.x >> 19u));
    let q = small_quotient(rest, float64(high.rest) * 8192.0 + f32(low), area);
    return Quotient((high.whole << 13u) | q.whole, q.rest);
}
