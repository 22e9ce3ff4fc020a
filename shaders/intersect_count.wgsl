// Counts the crossings of each ray (Eq. 16-18). Twin: `src/crossings.rs`.
// Reads: bin_offsets, edges. Writes: ray_counts[ray of the band], rays + 1 entries.

@group(0) @binding(4) var<storage, read_write> ray_counts: array<u32>;

@compute @workgroup_size(64)
fn intersect_count(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let rays = ray_row(group, local);
    if rays.count == 0u {
        return;
    }
    let counts = count_hits(rays);
    for (var i = 0u; i < rays.count; i++) {
        ray_counts[rays.first + i] = select(counts.high[i & 3u], counts.low[i & 3u], i < 4u);
    }
}
