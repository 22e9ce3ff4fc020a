// Counts the facets that hit rays of each bin (Eq. 13-15), by the layer of their lowest corner.
// Twins: `src/lattice.rs`, and `src/facet.rs` for the hits.
// Reads: corners, item_offsets. Writes: bin_counts[bin * n_layers + layer], one entry more than these, cleared before.
// Bound: see walk.wgsl.

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
        let f = load_facet(facet);
        var walk = start_walk(f, item - item_offsets[facet]);
        while walk.column < walk.end {
            let bin = walk.row * params.n_across + u32(walk.column);
            let hits = next_hits(&walk);
            if (hits.x | hits.y) != 0u {
                atomicAdd(&bin_counts[bin * params.n_layers + f.layer], 1u);
            }
        }
    }
}
