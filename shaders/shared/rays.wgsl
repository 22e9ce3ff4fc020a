// Which rays a thread of the intersection casts (Eq. 10-12), and which of them a facet hits (Eq. 16).
// A workgroup of 64 threads covers 8 bins of a row; a thread casts the 8 neighbouring rays of one row of one bin, so
// that a facet's numbers are loaded once for 8 rays. Twin: `src/rays.rs`.
// Reads: bin_offsets[bin], n_bins + 1 entries; edges, 2 vec4 a pair, see intersect_setup.

@group(0) @binding(2) var<storage, read> bin_offsets: array<u32>;
@group(0) @binding(3) var<storage, read> edges: array<vec4<i32>>;

struct RayRow {
    bin: u32,       // bin of the band
    row: u32,       // row of rays in the bin
    chunk: u32,     // index in the band of this row of this bin: row of the band * n_across + column of bins
    first: u32,     // index in the band of the first ray
    count: u32,     // rays of the row inside the domain, 0 to 8
}

fn ray_row(group: vec3<u32>, local: u32) -> RayRow {
    return ray_row_at(group.x * 8u + local / 8u, group.y * BIN + local % 8u);
}

// The rays of a column of bins in row j of the band.
fn ray_row_at(column: u32, j: u32) -> RayRow {
    let i = column * BIN;
    var r: RayRow;
    r.bin = j / BIN * params.n_across + column;
    r.row = j % BIN;
    r.chunk = j * params.n_across + column;
    r.first = j * params.n_i + i;
    r.count = 0u;
    if column < params.n_across && j < params.end_row - params.first_row {
        r.count = min(BIN, params.n_i - i);
    }
    return r;
}

struct Hits {
    low: vec4<u32>,     // 1 where the facet is hit, for rays 0 to 3
    high: vec4<u32>,    // and 4 to 7
}

fn hits_of_pair(pair: u32, row: u32) -> Hits {
    let e0 = edges[2u * pair];
    let e1 = edges[2u * pair + 1u];
    let a = vec3<i32>(e0.w, e1.x, -e0.w - e1.x);
    let b = vec3<i32>(e1.y, e1.z, -e1.y - e1.z);
    let q = e0.xyz + b * i32(row);
    let i = vec4<i32>(0, 1, 2, 3);
    let q0 = vec4<i32>(q.x) + a.x * i;
    let q1 = vec4<i32>(q.y) + a.y * i;
    let q2 = vec4<i32>(q.z) + a.z * i;
    let low = q0 | q1 | q2;
    let high = (q0 + 4 * a.x) | (q1 + 4 * a.y) | (q2 + 4 * a.z);
    return Hits(1u - (bitcast<vec4<u32>>(low) >> vec4<u32>(31u)), 1u - (bitcast<vec4<u32>>(high) >> vec4<u32>(31u)));
}

// The hits without those past the end of the row.
fn hits_inside(pair: u32, rays: RayRow) -> Hits {
    var hits = hits_of_pair(pair, rays.row);
    hits.low &= vec4<u32>(vec4<u32>(0u, 1u, 2u, 3u) < vec4<u32>(rays.count));
    hits.high &= vec4<u32>(vec4<u32>(4u, 5u, 6u, 7u) < vec4<u32>(rays.count));
    return hits;
}

// The number of facets that hit each ray of a row.
fn count_hits(rays: RayRow) -> Hits {
    var counts = Hits();
    let end = min(bin_offsets[rays.bin + 1u], params.pair_capacity);
    for (var pair = bin_offsets[rays.bin]; pair < end; pair++) {
        let hits = hits_inside(pair, rays);
        counts.low += hits.low;
        counts.high += hits.high;
    }
    return counts;
}
