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
    walk_items(thread_index(group, groups, local), groups.x * groups.y * 64u);
    atomicAdd(&n_hits[0], own_hits);
}

var<private> own_hits: u32;

fn visit(facet: u32, f: Facet, bin: u32, hits: vec2<u32>) {
    own_hits += countOneBits(hits.x) + countOneBits(hits.y);
    let tile = atomicAdd(&next_tile[bin * params.n_layers + f.layer], 1u);
    if tile < params.tile_capacity {
        tiles[2u * tile] = vec4<u32>(facet, bin, hits);
    }
}
