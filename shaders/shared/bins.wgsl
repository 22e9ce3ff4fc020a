// The walk along the bins of one row of bins that a facet may overlap; shared by lattice_count and lattice_fill so that
// both find the same bins. Twin: `for_each_bin` in `src/lattice.rs`.
// Reads: row_offsets[f], the exclusive scan of the facets' rows of bins, n_facets + 1 entries.

@group(0) @binding(2) var<storage, read> row_offsets: array<u32>;

struct Walk {
    facet: u32,
    column: i32,        // next bin of the row
    end: i32,           // end of the bins of the facet's box
    row: u32,           // row of bins in the band
    q0: vec2<u32>,      // greatest q of each edge over the rays of the next bin
    q1: vec2<u32>,
    q2: vec2<u32>,
    step: vec3<i32>,    // change of q from bin to bin
}

// The facet whose rows hold entry `item`: the last with row_offsets <= item.
fn facet_of_item(item: u32) -> u32 {
    var low = 0u;
    var high = params.n_facets;
    while high - low > 1u {
        let middle = (low + high) / 2u;
        if row_offsets[middle] <= item {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}

// The same for an item after one of a facet: in most cases of the same or the next.
fn facet_after(facet: u32, item: u32) -> u32 {
    if item < row_offsets[facet + 1u] {
        return facet;
    }
    let next = min(facet + 1u, params.n_facets - 1u);
    if item < row_offsets[next + 1u] {
        return next;
    }
    return facet_of_item(item);
}

// The items of a thread: neighbours, equally many for every thread.
fn own_items(thread: u32, n_threads: u32) -> vec2<u32> {
    let n_items = row_offsets[params.n_facets];
    let n_own = n_items / n_threads + u32(n_items % n_threads != 0u);
    let first = min(thread * n_own, n_items);
    return vec2<u32>(first, min(first + n_own, n_items));
}

fn start_walk(facet: u32, item: u32) -> Walk {
    var w: Walk;
    w.facet = facet;
    let f = load_facet(w.facet);
    w.row = u32(bin_rows(f).x) + item - row_offsets[w.facet];
    w.column = f.first.x / i32(BIN);
    w.end = f.last.x / i32(BIN) + 1;
    let a = edge_a(f);
    let b = edge_b(f);
    let ray = vec2<i32>(w.column * i32(BIN), i32(params.first_row + w.row * BIN));
    let reach = (max(a, vec3<i32>(0)) + max(b, vec3<i32>(0))) * i32(BIN - 1u);
    w.q0 = add64(edge_q(a.x, b.x, f.x.x, f.y.x, ray), widen(reach.x));
    w.q1 = add64(edge_q(a.y, b.y, f.x.y, f.y.y, ray), widen(reach.y));
    w.q2 = add64(edge_q(a.z, b.z, f.x.z, f.y.z, ray), widen(reach.z));
    w.step = a * i32(BIN);
    return w;
}

fn overlaps(w: Walk) -> bool {
    return ((w.q0.y | w.q1.y | w.q2.y) >> 31u) == 0u;
}

fn advance(w: ptr<function, Walk>) {
    (*w).q0 = add64((*w).q0, widen((*w).step.x));
    (*w).q1 = add64((*w).q1, widen((*w).step.y));
    (*w).q2 = add64((*w).q2, widen((*w).step.z));
    (*w).column += 1;
}
