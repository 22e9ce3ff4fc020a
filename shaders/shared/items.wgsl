// The items of the lattice, shared by all kernels that walk over it, so that they find the same bins.
// An item is a facet with up to SEGMENT bins of one row of bins under its box. A thread takes an equal share of the items, ITEMS at
// most: no facet, however large, is one thread's work. Twin: `for_each_bin` in `crates/core/src/stages/lattice.rs`.
// What is done in the bins of an item, start_walk and next_hits, is in walk.wgsl, or in graded.wgsl where cells differ in size.
// Reads: item_offsets[f], the number of items of all facets before f, n_facets + 1 entries.
// Bound: 32 steps to find the facet of an item, SEGMENT bins.

const SEGMENT: u32 = 16u;

@group(0) @binding(2) var<storage, read> item_offsets: array<u32>;

// Walks the items of a thread and calls the kernel's visit(facet, its numbers, bin of the band, hits) where a facet hits rays of a bin.
fn walk_items(thread: u32, n_threads: u32) {
    let items = own_items(thread, n_threads);
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
                visit(facet, f, bin, hits);
            }
        }
    }
}

// The items of a thread: neighbours, equally many for every thread.
fn own_items(thread: u32, n_threads: u32) -> vec2<u32> {
    let n_own = (params.n_items + n_threads - 1u) / n_threads;
    let first = min(thread * n_own, params.n_items);
    return vec2<u32>(first, min(first + n_own, params.n_items));
}

// The facet that an item belongs to: the last with item_offsets <= item.
fn facet_of_item(item: u32) -> u32 {
    var low = 0u;
    var high = params.n_facets;
    for (var left = 32u; left != 0u && high - low > 1u; left--) {
        let middle = (low + high) / 2u;
        if item_offsets[middle] <= item {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}

// The same for an item after one of a facet: in most cases of the same or the next.
fn facet_after(facet: u32, item: u32) -> u32 {
    if item < item_offsets[facet + 1u] {
        return facet;
    }
    let next = min(facet + 1u, params.n_facets - 1u);
    if item < item_offsets[next + 1u] {
        return next;
    }
    return facet_of_item(item);
}

// Bins of an item: columns of a row of bins in the band.
struct Bins {
    column: i32,
    end: i32,
    row: u32,
}

// The bins of an item of a facet, given the first and the last ray of its box.
fn bins_of_item(first: vec2<i32>, last: vec2<i32>, index: u32) -> Bins {
    let columns = last.x / i32(BIN) - first.x / i32(BIN) + 1;
    let segments = (u32(columns) + SEGMENT - 1u) / SEGMENT;
    let column = first.x / i32(BIN) + i32(index % segments * SEGMENT);
    let end = min(column + i32(SEGMENT), last.x / i32(BIN) + 1);
    return Bins(column, end, (u32(first.y) - params.first_row) / BIN + index / segments);
}
