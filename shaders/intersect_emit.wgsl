// Writes the crossings of each ray (Eq. 19), in the order of the bin's facets. Twin: `src/crossings.rs`.
// Reads: bin_offsets, edges, planes (see intersect_setup), ray_offsets[ray of the band].
// Writes: events[ray_offsets[ray] ..] = cell << 9 | rank << 1 | direction, up to event_capacity.

@group(0) @binding(5) var<storage, read_write> events: array<u32>;
@group(0) @binding(6) var<storage, read> ray_offsets: array<u32>;

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
    emit_rays(rays, low, high);
}
