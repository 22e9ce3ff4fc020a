// Counts the crossings of each ray (Eq. 16-18). Twin: `src/crossings.rs`.
// Reads: bin_offsets, edges. Writes: ray_counts[ray of the band], rays + 1 entries.

@group(0) @binding(4) var<storage, read_write> ray_counts: array<u32>;

@compute @workgroup_size(64)
fn intersect_count(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let rays = ray_row(group, local);
    if rays.count == 0u {
        return;
    }
    var low = vec4<u32>(0u);
    var high = vec4<u32>(0u);
    let end = min(bin_offsets[rays.bin + 1u], params.pair_capacity);
    for (var pair = bin_offsets[rays.bin]; pair < end; pair++) {
        let hits = hits_of_pair(pair, rays.row);
        low += hits.low;
        high += hits.high;
    }
    for (var i = 0u; i < rays.count; i++) {
        ray_counts[rays.first + i] = select(high[i & 3u], low[i & 3u], i < 4u);
    }
}
