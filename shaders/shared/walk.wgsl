// The walk over the bins of an item where rays are equally far from each other: q of the three edges, from bin to bin.
// Twin: `for_each_bin` in `crates/core/src/stages/lattice.rs`.
// Bound: BIN rows of a bin; with items.wgsl under 2^14 loops an invocation.

struct Walk {
    column: i32,        // next bin of the row
    end: i32,           // end of the bins of the item
    row: u32,           // row of bins in the band
    q0: vec2<u32>,      // q of each edge at the first ray of the next bin
    q1: vec2<u32>,
    q2: vec2<u32>,
    a: vec3<i32>,       // steps of q from ray to ray
    b: vec3<i32>,       // and from row to row
    reach: vec3<i32>,   // the most that q grows within a bin
}

fn start_walk(f: Facet, index: u32) -> Walk {
    let bins = bins_of_item(f.first, f.last, index);
    var w: Walk;
    w.row = bins.row;
    w.column = bins.column;
    w.end = bins.end;
    w.a = edge_a(f);
    w.b = edge_b(f);
    w.reach = (max(w.a, vec3<i32>(0)) + max(w.b, vec3<i32>(0))) * i32(BIN - 1u);
    let ray = vec2<i32>(w.column * i32(BIN), i32(params.first_row + w.row * BIN));
    w.q0 = edge_q(w.a.x, w.b.x, f.x.x, f.y.x, ray);
    w.q1 = edge_q(w.a.y, w.b.y, f.x.y, f.y.y, ray);
    w.q2 = edge_q(w.a.z, w.b.z, f.x.z, f.y.z, ray);
    return w;
}

// The rays of the next bin that the facet hits (Eq. 16), 8 bits a row: rows 0 to 3, then 4 to 7; steps to the bin after it.
fn next_hits(w: ptr<function, Walk>) -> vec2<u32> {
    let now = *w;
    var hits = vec2<u32>(0u, 0u);
    // most bins under a box are beside the facet: one edge says so
    let greatest = add64(now.q0, widen(now.reach.x)).y | add64(now.q1, widen(now.reach.y)).y
        | add64(now.q2, widen(now.reach.z)).y;
    if (greatest >> 31u) == 0u {
        hits = hits_of_bin(now);
    }
    let step = now.a * i32(BIN);
    (*w).q0 = add64(now.q0, widen(step.x));
    (*w).q1 = add64(now.q1, widen(step.y));
    (*w).q2 = add64(now.q2, widen(step.z));
    (*w).column += 1;
    return hits;
}

// q is clamped to +-2^30: a bin changes it by less than 2^30, so a clamped value keeps its sign.
fn hits_of_bin(w: Walk) -> vec2<u32> {
    let i = vec4<i32>(0, 1, 2, 3);
    let a0 = w.a.x * i;
    let a1 = w.a.y * i;
    let a2 = w.a.z * i;
    // a facet may hit places past the end of the row, and rows past the end of the band
    let n_inside = min(params.n_i - u32(w.column) * BIN, BIN);
    let inside = (1u << n_inside) - 1u;
    let n_rows = min(params.end_row - params.first_row - w.row * BIN, BIN);
    var q = vec3<i32>(clamp_to_2_30(w.q0), clamp_to_2_30(w.q1), clamp_to_2_30(w.q2));
    var hits = vec2<u32>(0u, 0u);
    for (var row = 0u; row < BIN; row++) {
        let low = (q.x + a0) | (q.y + a1) | (q.z + a2);
        let high = (q.x + 4 * w.a.x + a0) | (q.y + 4 * w.a.y + a1) | (q.z + 4 * w.a.z + a2);
        let bits = (bits_of_signs(~low) | (bits_of_signs(~high) << 4u)) & select(0u, inside, row < n_rows);
        hits = vec2<u32>((hits.x >> 8u) | (hits.y << 24u), (hits.y >> 8u) | (bits << 24u));
        q += w.b;
    }
    return hits;
}

fn bits_of_signs(v: vec4<i32>) -> u32 {
    let signs = bitcast<vec4<u32>>(v) >> vec4<u32>(31u);
    return signs.x | (signs.y << 1u) | (signs.z << 2u) | (signs.w << 3u);
}
