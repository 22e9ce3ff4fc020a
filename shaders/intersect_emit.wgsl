// Writes the crossings of each ray (Eq. 19), in the order of the bin's facets. Twin: `src/crossings.rs`.
// The rays of a row that a facet hits are neighbours. At the first the quotient height / area is guessed in f32 (relative
// error under 2^-21, so less than one cell in 2^18) and mended by one exact step; to the next, quotient and remainder take
// the facet's constant step.
// Reads: bin_offsets, edges, planes (see intersect_setup), ray_offsets[ray of the band].
// Writes: events[ray_offsets[ray] ..] = cell << 9 | rank << 1 | direction, up to event_capacity.

@group(0) @binding(4) var<storage, read> planes: array<vec4<u32>>;
@group(0) @binding(5) var<storage, read> ray_offsets: array<u32>;
@group(0) @binding(6) var<storage, read_write> events: array<u32>;

@compute @workgroup_size(64)
fn intersect_emit(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let rays = ray_row(group, local);
    if rays.count == 0u {
        return;
    }
    var low = vec4<u32>(0u);
    var high = vec4<u32>(0u);
    for (var i = 0u; i < 4u; i++) {
        low[i] = ray_offsets[rays.first + min(i, rays.count - 1u)];
        high[i] = ray_offsets[rays.first + min(i + 4u, rays.count - 1u)];
    }
    // a facet may hit places past the end of the row: they have no slot
    let valid_low = vec4<u32>(vec4<u32>(0u, 1u, 2u, 3u) < vec4<u32>(rays.count));
    let valid_high = vec4<u32>(vec4<u32>(4u, 5u, 6u, 7u) < vec4<u32>(rays.count));
    let end = min(bin_offsets[rays.bin + 1u], params.pair_capacity);
    for (var pair = bin_offsets[rays.bin]; pair < end; pair++) {
        var hits = hits_of_pair(pair, rays.row);
        hits.low &= valid_low;
        hits.high &= valid_high;
        if any((hits.low | hits.high) != vec4<u32>(0u)) {
            emit_row(pair, rays.row, hits, low, high);
            low += hits.low;
            high += hits.high;
        }
    }
}

// Quotient and remainder of a ray's height by the area.
struct Height {
    cells: i32,
    rest: vec2<u32>,
}

// What a facet's rows share.
struct Plane {
    area: vec2<u32>,
    step_rest: vec2<u32>,
    step_cells: i32,
    tag: u32,
}

// Emits the crossings of a facet with the eight rays of a row, where they hit. Written out: drivers that run 8 threads in a
// vector pay more for an index into a vector than for a whole crossing.
fn emit_row(pair: u32, row: u32, hits: Hits, low: vec4<u32>, high: vec4<u32>) {
    let p0 = planes[3u * pair];
    let p1 = planes[3u * pair + 1u];
    let p2 = planes[3u * pair + 2u];
    let plane = Plane(p1.zw, p2.xy, bitcast<i32>(p2.z), p2.w);
    let bits = hits.low.x | (hits.low.y << 1u) | (hits.low.z << 2u) | (hits.low.w << 3u)
        | (hits.high.x << 4u) | (hits.high.y << 5u) | (hits.high.z << 6u) | (hits.high.w << 7u);
    let first = i32(firstTrailingBit(bits));
    let at_row = add96(p0.xyz, multiply96(p1.xy, i32(row)));
    let at_first = add96(at_row, multiply96(slope_of(plane), first));
    var height = divide(at_first, plane.area);
    height.cells += bitcast<i32>(p0.w);
    emit(hits.low.x, low.x, &height, plane);
    emit(hits.low.y, low.y, &height, plane);
    emit(hits.low.z, low.z, &height, plane);
    emit(hits.low.w, low.w, &height, plane);
    emit(hits.high.x, high.x, &height, plane);
    emit(hits.high.y, high.y, &height, plane);
    emit(hits.high.z, high.z, &height, plane);
    emit(hits.high.w, high.w, &height, plane);
}

// The step of the height from ray to ray: cells * area + rest, cells signed.
fn slope_of(plane: Plane) -> vec2<u32> {
    let cells = bitcast<u32>(plane.step_cells);
    let product = multiply_unsigned(cells, plane.area.x);
    let high = cells * plane.area.y - select(0u, plane.area.x, plane.step_cells < 0);
    return add64(vec2<u32>(product.x, product.y + high), plane.step_rest);
}

// Divides a height of at most 2^18 cells, not negative, by the area.
fn divide(height: vec3<u32>, area: vec2<u32>) -> Height {
    let value = (f32(height.z) * 4294967296.0 + f32(height.y)) * 4294967296.0 + f32(height.x);
    let guess = u32(value / (f32(area.y) * 4294967296.0 + f32(area.x)));
    let mended = mend_quotient(height.xy, guess, area);
    return Height(i32(mended.whole), mended.rest);
}

// Emits the crossing of one ray, if it hits, and steps to the next.
fn emit(hit: u32, slot: u32, height: ptr<function, Height>, plane: Plane) {
    if hit == 1u {
        let rest = (*height).rest;
        let centre_is_above = (rest.x | rest.y) == 0u && (plane.tag >> 9u) == 1u;
        let first_above = (*height).cells + select(1, 0, centre_is_above);
        if slot < params.event_capacity {
            events[slot] = (u32(clamp(first_above, 0, i32(params.depth))) << 9u) | (plane.tag & 0x1ffu);
        }
        let next = add64(rest, plane.step_rest);
        let wraps = at_least64(next, plane.area);
        (*height).rest = select(next, sub64(next, plane.area), vec2<bool>(wraps));
        (*height).cells += plane.step_cells + i32(wraps);
    }
}
