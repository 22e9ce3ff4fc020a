// Counts the facets of each bin (Eq. 13-15). A thread takes every n-th (facet, row of bins) item: no facet, however large,
// is one thread's work. Twin: `src/lattice.rs`.
// Reads: corners, row_offsets. Writes: bin_counts[bin], n_bins + 1 entries, cleared before.

@group(0) @binding(3) var<storage, read_write> bin_counts: array<atomic<u32>>;

@compute @workgroup_size(64)
fn lattice_count(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let n_items = row_offsets[params.n_facets];
    let n_threads = groups.x * groups.y * 64u;
    for (var item = thread_index(group, groups, local); item < n_items; item += n_threads) {
        var walk = start_walk(item);
        while walk.column < walk.end {
            if overlaps(walk) {
                atomicAdd(&bin_counts[walk.row * params.n_across + u32(walk.column)], 1u);
            }
            advance(&walk);
        }
    }
}
