// Writes what each facet hits in each bin, layer by layer, in no order within a layer: the beginnings of tiles.
// Twins: `src/lattice.rs`, and `src/facet.rs` for the hits.
// Reads: corners, item_offsets. Reads and writes: next_tile[bin * n_layers + layer], a copy of the scanned counts.
// Writes: tiles[2 t] = (facet, bin of the band, hits of rows 0 to 3, of rows 4 to 7), for t < tile_capacity.
//         Adds to n_hits[0] all rays that all facets hit, modulo 2^32: so many crossings the rays must have.
// Bound: see walk.wgsl.

@group(0) @binding(3) var<storage, read_write> next_tile: array<atomic<u32>>;
@group(0) @binding(4) var<storage, read_write> tiles: array<vec4<u32>>;
@group(0) @binding(5) var<storage, read_write> n_hits: array<atomic<u32>>;

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
    var own_hits = 0u;
    for (var item = items.x; item < items.y; item++) {
        facet = facet_after(facet, item);
        let f = load_facet(facet);
        var walk = start_walk(f, item - item_offsets[facet]);
        while walk.column < walk.end {
            let bin = walk.row * params.n_across + u32(walk.column);
            let hits = next_hits(&walk);
            if (hits.x | hits.y) != 0u {
                own_hits += countOneBits(hits.x) + countOneBits(hits.y);
                let tile = atomicAdd(&next_tile[bin * params.n_layers + f.layer], 1u);
                if tile < params.tile_capacity {
                    tiles[2u * tile] = vec4<u32>(facet, bin, hits);
                }
            }
        }
    }
    atomicAdd(&n_hits[0], own_hits);
}
