// Casts the rows of rays that columns leaves, with any number of crossings and any geometries: by way of memory, a thread a row.
// Twins: `src/crossings.rs`, `src/map.rs`.
// Reads: bin_offsets, edges, planes (see intersect_setup); flag_of_rank. Reads and writes chunks: where the second number is DEEP,
// the first becomes the place of the row's results, in four words. Adds to totals.
// Writes: events[4 place .. 4 place + 8], the number of runs of each ray, then their runs, ray after ray. This is the buffer
//         `runs`; beyond event_capacity nothing is written, and the host sees it by n_places.

@group(0) @binding(5) var<storage, read_write> events: array<u32>;

@compute @workgroup_size(64)
fn columns_deep(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let chunk = thread_index(group, groups, local);
    if chunk >= (params.end_row - params.first_row) * params.n_across {
        return;
    }
    if chunks[chunk].y != DEEP {
        return;
    }
    let rays = ray_row_at(chunk % params.n_across, chunk / params.n_across);
    let counts = count_hits(rays);
    let low = before_each(counts.low);
    let n_low = low.w + counts.low.w;
    let high = before_each(counts.high);
    let n = n_low + high.w + counts.high.w;
    let n_places = (n + BIN + 3u) / 4u;
    let place = atomicAdd(&totals.n_places, n_places);
    if place + n_places > params.event_capacity / 4u {
        return;
    }
    let start = 4u * place;
    emit_rays(rays, low + start + BIN, high + start + BIN + n_low);
    chunks[chunk].x = place;
    let n_runs = map_row(start, counts);
    atomicAdd(&totals.n_lost, n - n_runs);
}

// The sums of the numbers before each.
fn before_each(n: vec4<u32>) -> vec4<u32> {
    return vec4<u32>(0u, n.x, n.x + n.y, n.x + n.y + n.z);
}

// Maps ray after ray and moves its runs behind those of the ray before; returns their number.
fn map_row(start: u32, counts: Hits) -> u32 {
    var source = start + BIN;
    var next = source;
    for (var i = 0u; i < BIN; i++) {
        let n = select(counts.high[i & 3u], counts.low[i & 3u], i < 4u);
        let result = map_ray(source, n);
        let n_runs = result & ~ODD;
        for (var k = 0u; k < n_runs; k++) {
            events[next + k] = events[source + k];
        }
        events[start + i] = n_runs;
        next += n_runs;
        source += n;
        if (result & ODD) != 0u {
            atomicAdd(&totals.n_odd, 1u);
        }
    }
    return next - start - BIN;
}
