// Counts the rows of bins that each facet's box reaches in the band: the work items of the lattice.
// Twin: the loop over rows in `src/lattice.rs`.
// Reads: corners. Writes: row_counts[f], n_facets + 1 entries (the last stays 0 and becomes the total in the scan).

@group(0) @binding(2) var<storage, read_write> row_counts: array<u32>;

@compute @workgroup_size(64)
fn lattice_rows(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let facet = thread_index(group, groups, local);
    if facet >= params.n_facets {
        return;
    }
    let rows = bin_rows(load_facet(facet));
    row_counts[facet] = u32(rows.y - rows.x);
}
