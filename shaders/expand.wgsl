// Expands the flags of a slab of cells from the runs of its rays: a thread makes a word, four bytes of rows along x, which come y before z.
// A byte is the flag of a cell, or a bit for each of eight cells, 1 where its flag is not 0. The bytes of a row after its cells are 0.
// Twin: `crates/core/src/cells/flags.rs`. Callers on other devices run it, too: it uses no other file.
// Reads: slab; offsets[rays + 1], the first run of ray i + n_i * j over the axes across, and the end; runs, cell << 8 | flag, ascending in
// each ray, with cells counted from the first of the slab. Cells before the first run of a ray have flag 0.
// Reads and writes: flags[(skip + row_bytes * n_y * n_z + 3) / 4], 0 at first; slabs may share a word.
// Bound: 32 cells, each with 19 steps of a search: under 2^14 loops an invocation.

struct Slab {
    // cells on x, y and z
    n_x: u32,
    n_y: u32,
    n_z: u32,
    // of the rays: 0, 1 or 2
    axis: u32,
    // from the first byte of a row to that of the next
    row_bytes: u32,
    // bytes of `flags` before the first row
    skip: u32,
    // cells of a byte: 1 or 8
    per_byte: u32,
}

@group(0) @binding(0) var<uniform> slab: Slab;
@group(0) @binding(1) var<storage, read> offsets: array<u32>;
@group(0) @binding(2) var<storage, read> runs: array<u32>;
@group(0) @binding(3) var<storage, read_write> flags: array<u32>;

// The longest ray has fewer than 2^18 cells.
const SEARCH_STEPS: u32 = 19u;

@compute @workgroup_size(64)
fn expand(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let word = (group.y * groups.x + group.x) * 64u + local;
    let end = slab.skip + slab.row_bytes * slab.n_y * slab.n_z;
    if word >= (end + 3u) / 4u {
        return;
    }
    var bits = 0u;
    for (var k = 0u; k < 4u; k++) {
        let at = 4u * word + k;
        if at >= slab.skip && at < end {
            bits |= byte_at(at - slab.skip) << (8u * k);
        }
    }
    // the rest is 0, or of the slab before, which has ended
    flags[word] |= bits;
}

fn byte_at(at: u32) -> u32 {
    let row = at / slab.row_bytes;
    let first = (at % slab.row_bytes) * slab.per_byte;
    if first >= slab.n_x {
        return 0u;
    }
    let cell = vec3<u32>(first, row % slab.n_y, row / slab.n_y);
    if slab.per_byte == 1u {
        return flag_of(cell);
    }
    var bits = 0u;
    for (var k = 0u; k < 8u && first + k < slab.n_x; k++) {
        bits |= select(0u, 1u << k, flag_of(cell + vec3<u32>(k, 0u, 0u)) != 0u);
    }
    return bits;
}

fn flag_of(cell: vec3<u32>) -> u32 {
    var ray = cell.x + slab.n_x * cell.y;
    if slab.axis == 0u {
        ray = cell.y + slab.n_y * cell.z;
    } else if slab.axis == 1u {
        ray = cell.x + slab.n_x * cell.z;
    }
    let first = offsets[ray];
    // the runs that begin at the cell or before it
    var low = first;
    var high = offsets[ray + 1u];
    for (var left = SEARCH_STEPS; left != 0u && low < high; left--) {
        let middle = low + (high - low) / 2u;
        if runs[middle] >> 8u <= cell[slab.axis] {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    if low == first {
        return 0u;
    }
    return runs[low - 1u] & 0xffu;
}
