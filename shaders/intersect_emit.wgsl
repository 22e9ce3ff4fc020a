// Writes the crossings of each ray (Eq. 19), in the order of the bin's facets. Twin: `src/crossings.rs`.
// The quotient height / area is guessed in f32 (relative error under 2^-21, so less than one cell in 2^18) and mended by
// one exact step.
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

// Emits the crossings of a facet with the eight rays of a row, where they hit. Written out: an index into a vector that is
// only known at run time costs more than the whole crossing on some drivers.
fn emit_row(pair: u32, row: u32, hits: Hits, low: vec4<u32>, high: vec4<u32>) {
    let p0 = planes[3u * pair];
    let slopes = planes[3u * pair + 1u];
    let facet = planes[3u * pair + 2u];
    let base = bitcast<i32>(p0.w);
    let slope = widen96(slopes.xy);
    var height = add96(p0.xyz, multiply96(slopes.zw, i32(row)));
    emit(hits.low.x, low.x, height, facet, base);
    height = add96(height, slope);
    emit(hits.low.y, low.y, height, facet, base);
    height = add96(height, slope);
    emit(hits.low.z, low.z, height, facet, base);
    height = add96(height, slope);
    emit(hits.low.w, low.w, height, facet, base);
    height = add96(height, slope);
    emit(hits.high.x, high.x, height, facet, base);
    height = add96(height, slope);
    emit(hits.high.y, high.y, height, facet, base);
    height = add96(height, slope);
    emit(hits.high.z, high.z, height, facet, base);
    height = add96(height, slope);
    emit(hits.high.w, high.w, height, facet, base);
}

fn emit(hit: u32, slot: u32, height: vec3<u32>, facet: vec4<u32>, base: i32) {
    if hit == 1u && slot < params.event_capacity {
        events[slot] = crossing(height, facet, base);
    }
}

// The event of a hit: `height` is Q of the ray, `facet` is (area, 1 / area, tag).
fn crossing(height: vec3<u32>, facet: vec4<u32>, base: i32) -> u32 {
    let value = (f32(height.z) * 4294967296.0 + f32(height.y)) * 4294967296.0 + f32(height.x);
    var cells = u32(value * bitcast<f32>(facet.z));
    let product = multiply_unsigned(cells, facet.x) + vec2<u32>(0u, cells * facet.y);
    var rest = sub64(height.xy, product);
    if is_negative(rest) {
        cells -= 1u;
        rest = add64(rest, facet.xy);
    } else if at_least64(rest, facet.xy) {
        cells += 1u;
        rest = sub64(rest, facet.xy);
    }
    let centre_is_above = (rest.x | rest.y) == 0u && (facet.w >> 9u) == 1u;
    let first_above = base + i32(cells) + select(1, 0, centre_is_above);
    return u32(clamp(first_above, 0, i32(params.depth))) << 9u | (facet.w & 0x1ffu);
}
