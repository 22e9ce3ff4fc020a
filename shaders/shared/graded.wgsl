// Where rays and centres are where cells differ in size, and the walk over the bins of an item there. Places are in units: F is 0.
// A facet hits a ray iff all three q >= 0, with q = A (x - X) + B (y - Y), less 1 where a tie counts as outside: 55 bits at most.
// Twins: `crates/core/src/stages/crossings/graded.rs`, `ends_of_bin` in `crates/core/src/stages/lattice.rs`, and `crates/core/src/grid/frame/centres.rs`.
// Reads: centres, ascending: of the n_i rays along the first axis across, of the depth cells along the rays, of all rows of rays.
// Bound: SEARCH_LOOPS for each of 4 searches an item; for each bin BIN rays, BIN rows, and BIN rays of each row.

@group(0) @binding(5) var<storage, read> centres: array<i32>;

// Each loop of a search halves three times what is left, which is less than 2^18.
const SEARCH_LOOPS: u32 = 6u;

// The first of the centres start .. end that is not below a place, or end.
fn first_from(start: u32, end: u32, place: i32) -> u32 {
    var left = vec2<u32>(start, end);
    for (var i = 0u; i < SEARCH_LOOPS && left.x < left.y; i++) {
        left = halved(halved(halved(left, place), place), place);
    }
    return left.x;
}

fn halved(left: vec2<u32>, place: i32) -> vec2<u32> {
    let middle = (left.x + left.y) >> 1u;
    let is_below = left.x < left.y && centres[middle] < place;
    return select(vec2<u32>(left.x, middle), vec2<u32>(middle + 1u, left.y), vec2<bool>(is_below));
}

// The first cell of a ray whose centre is not below a place, or their number.
fn first_cell_from(place: i32) -> u32 {
    return first_from(params.n_i, params.n_i + params.depth, place) - params.n_i;
}

// Where a ray of a row is, or the last of them.
fn ray_place(i: u32) -> i32 {
    return centres[min(i, params.n_i - 1u)];
}

// Where a row of rays is, or the last of the band.
fn row_place(j: u32) -> i32 {
    return centres[params.n_i + params.depth + min(j, params.end_row - 1u)];
}

struct Walk {
    column: i32,        // next bin of the row
    end: i32,           // end of the bins of the item
    row: u32,           // row of bins in the band
    x: vec3<i32>,       // the corners
    y: vec3<i32>,
    a: vec3<i32>,       // steps of q for a unit along both axes across
    b: vec3<i32>,
}

fn start_walk(f: Facet, index: u32) -> Walk {
    let low = vec2<i32>(min(f.x.x, min(f.x.y, f.x.z)), min(f.y.x, min(f.y.y, f.y.z)));
    let high = vec2<i32>(max(f.x.x, max(f.x.y, f.x.z)), max(f.y.x, max(f.y.y, f.y.z)));
    let before = params.n_i + params.depth;
    let rows = vec2<u32>(before + params.first_row, before + params.end_row);
    let first = vec2<u32>(first_from(0u, params.n_i, low.x), first_from(rows.x, rows.y, low.y) - before);
    let end = vec2<u32>(first_from(0u, params.n_i, high.x + 1), first_from(rows.x, rows.y, high.y + 1) - before);
    let bins = bins_of_item(vec2<i32>(first), vec2<i32>(end) - 1, index);
    return Walk(bins.column, bins.end, bins.row, f.x, f.y, edge_a(f), edge_b(f));
}

// Numbers of the three edges.
struct Edges {
    e0: vec2<u32>,
    e1: vec2<u32>,
    e2: vec2<u32>,
}

// What places along the first axis across, one for each edge, add to q.
fn edges_across(w: Walk, x: vec3<i32>) -> Edges {
    let d = x - w.x;
    return Edges(multiply_signed(w.a.x, d.x), multiply_signed(w.a.y, d.y), multiply_signed(w.a.z, d.z));
}

// The same along the second axis, with what a tie that counts as outside takes away.
fn edges_down(w: Walk, y: vec3<i32>) -> Edges {
    let d = y - w.y;
    let tie_is_inside = (w.a < vec3<i32>(0)) | ((w.a == vec3<i32>(0)) & (w.b < vec3<i32>(0)));
    let less = select(vec3<u32>(1u), vec3<u32>(0u), tie_is_inside);
    return Edges(
        sub64(multiply_signed(w.b.x, d.x), vec2<u32>(less.x, 0u)),
        sub64(multiply_signed(w.b.y, d.y), vec2<u32>(less.y, 0u)),
        sub64(multiply_signed(w.b.z, d.z), vec2<u32>(less.z, 0u)),
    );
}

// 1 if all three q are 0 or more, else 0.
fn is_inside(across: Edges, down: Edges) -> u32 {
    let signs = add64(across.e0, down.e0).y | add64(across.e1, down.e1).y | add64(across.e2, down.e2).y;
    return 1u - (signs >> 31u);
}

// The rays of the next bin that the facet hits (Eq. 16), 8 bits a row: rows 0 to 3, then 4 to 7; steps to the bin after it.
fn next_hits(w: ptr<function, Walk>) -> vec2<u32> {
    let now = *w;
    (*w).column += 1;
    let i = u32(now.column) * BIN;
    let j = params.first_row + now.row * BIN;
    // most bins under a box are beside the facet: an edge has all its rays on one side, also the one that lies farthest inside
    let zero = vec3<i32>(0);
    let far_x = select(vec3<i32>(ray_place(i)), vec3<i32>(ray_place(i + BIN - 1u)), now.a > zero);
    let far_y = select(vec3<i32>(row_place(j)), vec3<i32>(row_place(j + BIN - 1u)), now.b > zero);
    if is_inside(edges_across(now, far_x), edges_down(now, far_y)) == 0u {
        return vec2<u32>(0u, 0u);
    }
    var across: array<Edges, 8>;
    for (var ray = 0u; ray < BIN; ray++) {
        across[ray] = edges_across(now, vec3<i32>(ray_place(i + ray)));
    }
    // a facet may hit places past the end of the row, and rows past the end of the band
    let inside = (1u << min(params.n_i - i, BIN)) - 1u;
    let n_rows = min(params.end_row - j, BIN);
    var hits = vec2<u32>(0u, 0u);
    for (var row = 0u; row < BIN; row++) {
        let down = edges_down(now, vec3<i32>(row_place(j + row)));
        var bits = 0u;
        for (var ray = 0u; ray < BIN; ray++) {
            bits |= is_inside(across[ray], down) << ray;
        }
        bits &= select(0u, inside, row < n_rows);
        hits = vec2<u32>((hits.x >> 8u) | (hits.y << 24u), (hits.y >> 8u) | (bits << 24u));
    }
    return hits;
}
