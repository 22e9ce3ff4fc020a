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
    walk_items(thread_index(group, groups, local), groups.x * groups.y * 64u);
}

fn visit(facet: u32, f: Facet, bin: u32, hits: vec2<u32>) {
    atomicAdd(&bin_counts[bin * params.n_layers + f.layer], 1u);
}
