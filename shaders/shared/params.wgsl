// The numbers of one band, the same for all kernels. Twin: `gpu::layout::Params`.

struct Params {
    fraction_bits: u32,   // F: a cell is 2^F units; 0 where cells differ in size
    axis: u32,            // ray axis: 0, 1 or 2
    depth: u32,           // cells of a ray
    n_i: u32,             // rays along the first axis across
    first_row: u32,       // the band's ray rows: first_row <= j < end_row
    end_row: u32,
    n_across: u32,        // bins in a row of bins: ceil(n_i / BIN)
    n_bins: u32,          // bins of the band
    n_layers: u32,        // layers of a bin along the rays, 1 to 128
    n_facets: u32,        // that rays of the band may hit
    n_items: u32,         // of the walk over the lattice, see items.wgsl
    tile_capacity: u32,   // tiles that the buffer holds
    place_capacity: u32,  // places of four runs that the buffer holds
    event_capacity: u32,  // crossings of deep rows that the buffer holds; 0 to count them only
    rule: u32,            // 0 parity, 1 nonzero
    n_ranks: u32,         // geometries
    all_deep: u32,        // 1: every row of rays is deep, and its index is that of its chunk
    with_facets: u32,     // 1: the facet of each crossing of a deep row is wanted
    first_facet: u32,     // of those on the device, among all that rays of the band may hit
}

@group(0) @binding(0) var<uniform> params: Params;

// Rays of a bin along both axes across.
const BIN: u32 = 8u;
// Most tiles of a bin that map goes through, and the bits of a number below it.
const MAX_TILES: u32 = 8192u;
const RANK_BITS: u32 = 13u;

// Index of a thread in a dispatch of workgroups of 64 in two dimensions.
fn thread_index(group: vec3<u32>, groups: vec3<u32>, local: u32) -> u32 {
    return (group.y * groups.x + group.x) * 64u + local;
}
