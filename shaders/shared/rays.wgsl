// Which rays a thread of map casts (Eq. 10-12): a workgroup of 64 threads covers 8 bins of a row; a thread casts the 8 neighbouring rays
// of one row of one bin, so that a tile's numbers are loaded once for 8 rays. Twin: `src/rays.rs`.

struct RayRow {
    bin: u32,       // bin of the band
    row: u32,       // row of rays in the bin
    chunk: u32,     // index in the band of this row of this bin: row of the band * n_across + column of bins
    count: u32,     // rays of the row inside the domain, 0 to 8
}

fn ray_row(group: vec3<u32>, local: u32) -> RayRow {
    let column = group.x * 8u + local / 8u;
    let j = group.y * BIN + local % 8u;
    var r = RayRow(group.y * params.n_across + column, local % 8u, j * params.n_across + column, 0u);
    if column < params.n_across && j < params.end_row - params.first_row {
        r.count = min(BIN, params.n_i - column * BIN);
    }
    return r;
}
