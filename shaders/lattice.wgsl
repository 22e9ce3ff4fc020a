// Finds what each facet hits in each bin (Eq. 13-15): counts the facets of a bin, by the layer of their lowest corner, and lists them,
// so that the rays are tested once. Twins: `crates/core/src/stages/lattice.rs`, and `crates/core/src/stages/facet.rs` for the hits.
// Reads: corners, item_offsets.
// Writes: bin_counts[bin * n_layers + layer], one entry more than these, cleared before.
//         found[k] = (facet, bin of the band << RANK_BITS | rank, hits of rows 0 to 3, of rows 4 to 7), in no order, for k < tile_capacity.
//         The rank is the number of those before it in its bin and layer; beyond MAX_TILES they are only counted.
//         Adds to found_totals.
// Bound: see items.wgsl and walk.wgsl.

@group(0) @binding(3) var<storage, read_write> bin_counts: array<atomic<u32>>;
@group(0) @binding(4) var<storage, read_write> found: array<vec4<u32>>;

struct FoundTotals {
    n_found: atomic<u32>,
    n_hits: atomic<u32>,    // rays that all facets hit, modulo 2^32: so many crossings the rays must have
}

@group(0) @binding(5) var<storage, read_write> found_totals: FoundTotals;

@compute @workgroup_size(64)
fn lattice(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    walk_items(thread_index(group, groups, local), groups.x * groups.y * 64u);
    atomicAdd(&found_totals.n_hits, own_hits);
}

var<private> own_hits: u32;

fn visit(facet: u32, f: Facet, bin: u32, hits: vec2<u32>) {
    own_hits += countOneBits(hits.x) + countOneBits(hits.y);
    let rank = atomicAdd(&bin_counts[bin * params.n_layers + f.layer], 1u);
    if rank < MAX_TILES {
        let place = atomicAdd(&found_totals.n_found, 1u);
        if place < params.tile_capacity {
            found[place] = vec4<u32>(facet, (bin << RANK_BITS) | rank, hits);
        }
    }
}
