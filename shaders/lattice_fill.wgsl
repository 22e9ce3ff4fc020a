// Writes the facets of each bin, in no order within a bin. Twin: `src/lattice.rs`.
// Reads: corners, row_offsets. Reads and writes: next_pair[bin], a copy of the scanned bin counts.
// Writes: pairs[slot] = (facet, bin of the band), up to pair_capacity.

@group(0) @binding(3) var<storage, read_write> next_pair: array<atomic<u32>>;
@group(0) @binding(4) var<storage, read_write> pairs: array<vec2<u32>>;

@compute @workgroup_size(64)
fn lattice_fill(
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
                let bin = walk.row * params.n_across + u32(walk.column);
                let slot = atomicAdd(&next_pair[bin], 1u);
                if slot < params.pair_capacity {
                    pairs[slot] = vec2<u32>(walk.facet, bin);
                }
            }
            advance(&walk);
        }
    }
}
