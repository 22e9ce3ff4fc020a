// Sorts the crossings of each ray and sweeps them once into runs, in place. Twin: `src/map.rs`.
// Reads: ray_offsets[ray of the band], rays + 1 entries; flag_of_rank.
// Reads and writes: events: crossings in, runs out (cell << 8 | flag), never more of them than crossings.
// Writes: run_counts[ray], rays + 1 entries; adds to n_odd the rays on which a counter stays open.

@group(0) @binding(1) var<storage, read> ray_offsets: array<u32>;
@group(0) @binding(2) var<storage, read_write> events: array<u32>;
@group(0) @binding(3) var<storage, read_write> run_counts: array<u32>;
@group(0) @binding(4) var<storage, read_write> n_odd: atomic<u32>;

@compute @workgroup_size(64)
fn map(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let ray = thread_index(group, groups, local);
    if ray >= (params.end_row - params.first_row) * params.n_i {
        return;
    }
    let start = ray_offsets[ray];
    let end = min(ray_offsets[ray + 1u], params.event_capacity);
    if start >= end {
        run_counts[ray] = 0u;
        return;
    }
    let result = map_ray(start, end - start);
    if (result & ODD) != 0u {
        atomicAdd(&n_odd, 1u);
    }
    run_counts[ray] = result & ~ODD;
}
