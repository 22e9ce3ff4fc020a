// Counts the facets of each bin (Eq. 13-15). A thread takes an equal share of the (facet, row of bins) items: no facet, however large,
// is one thread's work. Twin: `src/lattice.rs`.
// Reads: corners, row_offsets. Writes: bin_counts[bin], n_bins + 1 entries, cleared before.

@group(0) @binding(3) var<storage, read_write> bin_counts: array<atomic<u32>>;

@compute @workgroup_size(64)
fn lattice_count(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let items = own_items(thread_index(group, groups, local), groups.x * groups.y * 64u);
    if items.x == items.y {
        return;
    }
    var facet = facet_of_item(items.x);
    for (var item = items.x; item < items.y; item++) {
        facet = facet_after(facet, item);
        var walk = start_walk(facet, item);
        while walk.column < walk.end {
            if overlaps(walk) {
                atomicAdd(&bin_counts[walk.row * params.n_across + u32(walk.column)], 1u);
            }
            advance(&walk);
        }
    }
}
