// Moves the runs of each ray together, so that only they travel home. Twin: `Band` in `src/columns.rs`.
// Reads: ray_offsets (where the runs of a ray stand), run_offsets[ray], the scan of the run counts, rays + 1 entries; events.
// Writes: runs[run_offsets[ray] ..].

@group(0) @binding(1) var<storage, read> ray_offsets: array<u32>;
@group(0) @binding(2) var<storage, read> run_offsets: array<u32>;
@group(0) @binding(3) var<storage, read> events: array<u32>;
@group(0) @binding(4) var<storage, read_write> runs: array<u32>;

@compute @workgroup_size(64)
fn compact(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let ray = thread_index(group, groups, local);
    if ray >= (params.end_row - params.first_row) * params.n_i {
        return;
    }
    let source = ray_offsets[ray];
    let target_start = run_offsets[ray];
    let n = run_offsets[ray + 1u] - target_start;
    for (var i = 0u; i < n; i++) {
        runs[target_start + i] = events[source + i];
    }
}
