// Casts the rays of the deep rows against a batch of facets, with exact quotients, and writes their crossings row by row.
// Twin: `crates/core/src/stages/crossings.rs`.
// Reads: corners, item_offsets; chunks (see chunks.wgsl), unless all rows are deep.
// Reads and writes: next_event, events (see events.wgsl).
// Bound: that of items.wgsl and walk.wgsl, and for each bin 64 crossings: ITEMS is smaller here.

@compute @workgroup_size(64)
fn intersect_deep(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    walk_items(thread_index(group, groups, local), groups.x * groups.y * 64u);
}

fn visit(facet: u32, f: Facet, bin: u32, hits: vec2<u32>) {
    let plane = plane_of(f, first_ray(bin));
    let first_chunk = bin / params.n_across * BIN * params.n_across + bin % params.n_across;
    for (var row = 0u; row < BIN; row++) {
        let of_row = hits_of_row(hits, row);
        if of_row != 0u {
            let index = deep_index(first_chunk + row * params.n_across);
            if index != DEEP {
                cross_row(facet, plane, f.area, row, of_row, atomicAdd(&next_event[index], countOneBits(of_row)));
            }
        }
    }
}

// Index of a chunk among the deep rows, or DEEP if it is not one of them.
fn deep_index(chunk: u32) -> u32 {
    if params.all_deep == 1u {
        return chunk;
    }
    return select(DEEP, chunks[chunk].x, chunks[chunk].y == DEEP);
}

// Writes the crossings of the rays of a row, a bit each, from a place on.
fn cross_row(facet: u32, plane: Plane, area: vec2<u32>, row: u32, hits: u32, first: u32) {
    let height = add96(plane.height, multiply96(plane.slope_j, i32(row)));
    var left = hits;
    for (var place = first; left != 0u; place++) {
        let ray = firstTrailingBit(left);
        left &= left - 1u;
        if place < params.event_capacity {
            let q = floor_quotient(add96(height, multiply96(plane.slope_i, i32(ray))), area);
            let centre_is_above = (q.rest.x | q.rest.y) == 0u && (plane.tag >> 9u) == 1u;
            let first_above = plane.base + bitcast<i32>(q.whole) + select(1, 0, centre_is_above);
            write_event(place, ray, u32(clamp(first_above, 0, i32(params.depth))), plane.tag, facet);
        }
    }
}
