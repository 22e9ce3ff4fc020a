// Writes the crossings of the rays of a row to `events`, which the kernel binds, up to event_capacity.

// Emits the crossings of all facets of the row's bin from the places low and high on, in the order of the facets.
fn emit_rays(rays: RayRow, low: vec4<u32>, high: vec4<u32>) {
    var next_low = low;
    var next_high = high;
    let end = min(bin_offsets[rays.bin + 1u], params.pair_capacity);
    for (var pair = bin_offsets[rays.bin]; pair < end; pair++) {
        let hits = hits_inside(pair, rays);
        if any((hits.low | hits.high) != vec4<u32>(0u)) {
            emit_row(pair, rays.row, hits, next_low, next_high);
            next_low += hits.low;
            next_high += hits.high;
        }
    }
}

// Emits the crossings of a facet with the eight rays of a row, where they hit. Written out: drivers that run 8 threads in a
// vector pay more for an index into a vector than for a whole crossing.
fn emit_row(pair: u32, row: u32, hits: Hits, low: vec4<u32>, high: vec4<u32>) {
    let plane = load_plane(pair);
    var height = first_height(plane, row, hits);
    emit(hits.low.x, low.x, &height, plane);
    emit(hits.low.y, low.y, &height, plane);
    emit(hits.low.z, low.z, &height, plane);
    emit(hits.low.w, low.w, &height, plane);
    emit(hits.high.x, high.x, &height, plane);
    emit(hits.high.y, high.y, &height, plane);
    emit(hits.high.z, high.z, &height, plane);
    emit(hits.high.w, high.w, &height, plane);
}

// Emits the crossing of one ray, if it hits, and steps to the next.
fn emit(hit: u32, slot: u32, height: ptr<function, Height>, plane: Plane) {
    if hit == 1u {
        if slot < params.event_capacity {
            events[slot] = event_at(*height, plane);
        }
        *height = next_height(*height, plane);
    }
}
