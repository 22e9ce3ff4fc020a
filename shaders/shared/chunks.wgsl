// What the kernels that make columns tell the host.

struct Totals {
    n_places: atomic<u32>,  // of four words of `runs`, given away
    n_odd: atomic<u32>,     // rays on which a counter stays open
    n_deep: atomic<u32>,    // rows of rays for columns_deep
    n_lost: atomic<u32>,    // crossings that begin no run
}

// Marks a chunk of columns_deep: no eight counts of at most 8 look like this.
const DEEP: u32 = 0xffffffffu;

@group(0) @binding(6) var<storage, read_write> chunks: array<vec2<u32>>;
@group(0) @binding(7) var<storage, read_write> totals: Totals;
