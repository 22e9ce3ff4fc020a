// Casts the rays and sweeps their crossings into runs in one pass, in registers, for any number of geometries and either rule.
// A thread casts the 8 rays of one row of one bin (Eq. 10-12), so that a tile's numbers are loaded once for 8 rays. It goes through the
// tiles of the bin layer by layer, so that crossings come roughly in order, and keeps for each ray the 8 that are not swept yet, sorted:
// a new one finds its place by a minimum and a maximum a place.
// Where a row gets crowded, the crossings before the end of the layer are swept, and only those that opened a geometry stay.
// Left to the deep kernels are rows with more open crossings than places, with a height too near to a centre for the tile's numbers,
// rays that do not leave all they enter (but for one geometry), and bins with more than MAX_TILES tiles.
// Twins: `crates/core/src/stages/crossings.rs`, `crates/core/src/stages/map.rs`.
// Reads: bin_offsets, tiles (see intersect), layer_ends[layer]: no crossing of a later layer is in a cell before it.
// Writes: chunks (see chunks.wgsl), runs, and adds to totals. A run is cell << 8 | (rank + 1 of the geometry that wins, or 0).
//         A segment holds the runs of a part of the row: ray after ray, four runs a place and each ray from a new place on.
//         chunk = (LINKED? | odd rays << 27 | place, counts): if LINKED, the first place holds the same two words of the segment
//         before. Segments are in no order; beyond place_capacity nothing is written, and the host sees it by n_places.
// Bound: MAX_TILES / 2 pairs of tiles, 128 layers, each with a sweep of 8 rays of 4 loops: under 2^14 loops an invocation.

@group(0) @binding(2) var<storage, read> bin_offsets: array<u32>;
@group(0) @binding(3) var<storage, read> tiles: array<vec4<u32>>;
@group(0) @binding(5) var<storage, read_write> runs: array<vec4<u32>>;

struct Totals {
    n_places: atomic<u32>,  // of four words of `runs`, given away
    n_deep: atomic<u32>,    // rows of rays for the deep kernels
    n_lost: atomic<u32>,    // crossings that begin no run
    n_unused: atomic<u32>,  // places given to rows that turned out to be deep
}

@group(0) @binding(7) var<storage, read_write> totals: Totals;
@group(0) @binding(8) var<uniform> layer_ends: array<vec4<u32>, 32>;

const LINKED: u32 = 0x80000000u;

// Whether bins may have more than one layer, a constant of the pipeline: drivers that run 8 threads in a vector run what an `if` holds
// though no thread takes it.
override HAS_LAYERS: bool = true;

@compute @workgroup_size(64)
fn map(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    // a workgroup covers 8 bins of a row
    let column = group.x * 8u + local / 8u;
    let row_of_bin = local % 8u;
    let row_of_band = group.y * BIN + row_of_bin;
    if column >= params.n_across || row_of_band >= params.end_row - params.first_row {
        return;
    }
    let chunk = row_of_band * params.n_across + column;
    let first_layer = (group.y * params.n_across + column) * params.n_layers;
    var tile = bin_offsets[first_layer];
    let end = bin_offsets[first_layer + params.n_layers];
    if end - tile > MAX_TILES || end > params.tile_capacity {
        leave_to_deep(chunk);
        return;
    }
    var row = Row(no_lists(), 0u, 0u, 0u, 0u, 0u, 0u, 0u);
    if HAS_LAYERS {
        for (var layer = 0u; tile < end && layer + 1u < params.n_layers; layer++) {
            cross_tiles(&tile, bin_offsets[first_layer + layer + 1u], row_of_bin, &row);
            if tile != end && is_crowded(row.lists) {
                sweep_until(&row, layer_ends[layer / 4u][layer % 4u]);
            }
        }
    }
    cross_tiles(&tile, end, row_of_bin, &row);
    let open = sweep_rest(&row);
    if row.undecided != 0u {
        if row.n_places != 0u {
            atomicAdd(&totals.n_unused, row.n_places);
        }
        leave_to_deep(chunk);
        return;
    }
    chunks[chunk] = vec2<u32>(row.place | (countOneBits(open) << 27u), row.counts);
    if row.n_crossings != row.n_runs {
        atomicAdd(&totals.n_lost, row.n_crossings - row.n_runs);
    }
}

fn leave_to_deep(chunk: u32) {
    chunks[chunk] = vec2<u32>(atomicAdd(&totals.n_deep, 1u), DEEP);
}

// The rays of a row on the way.
struct Row {
    lists: Lists,
    n_crossings: u32,
    n_runs: u32,        // written
    n_places: u32,      // taken for them
    undecided: u32,     // whether a crossing found no place, or none is certain
    swept: u32,         // the crossings of cells before it are swept
    place: u32,         // of the last segment, and LINKED; and the counts of its runs, 0 if there is none
    counts: u32,
}

// The crossings of 8 rays, or their runs.
struct Lists {
    l0: List, l1: List, l2: List, l3: List, l4: List, l5: List, l6: List, l7: List,
}

fn no_lists() -> Lists {
    let none = no_list();
    return Lists(none, none, none, none, none, none, none, none);
}

// The lists but the first, and one more behind them.
fn rotated(l: Lists, last: List) -> Lists {
    return Lists(l.l1, l.l2, l.l3, l.l4, l.l5, l.l6, l.l7, last);
}

// A facet along the rays of a row.
struct Slope {
    hits: u32,          // a bit a ray
    step_cells: u32,    // change of the height from ray to ray
    step_fraction: u32,
    margin: u32,        // how near below a centre the height is uncertain, in 2^-32, plus 16
    tie_is_below: u32,  // 0 if a centre at the height lies above the facet
    label: u32,         // rank << 1 | exits
}

struct Height {
    cells: u32,         // wraps around
    fraction: u32,
}

// Lists the crossings of all tiles up to an end. Two at a time, since drivers that run 8 threads in a vector pay for each variable that a
// loop carries.
fn cross_tiles(tile: ptr<function, u32>, end: u32, row_of_bin: u32, row: ptr<function, Row>) {
    for (; *tile < end; *tile += 2u) {
        let next = min(*tile + 1u, end - 1u);
        cross_row(*tile, row_of_bin, 0xffu, row);
        cross_row(next, row_of_bin, select(0u, 0xffu, next != *tile), row);
    }
    *tile = end;
}

// Lists the crossings of a facet with the rays of a row, a bit each, where they hit. Written out: drivers that run 8 threads in
// a vector pay more for an index into a vector than for a whole crossing.
fn cross_row(tile: u32, row_of_bin: u32, rays: u32, row: ptr<function, Row>) {
    let first = tiles[2u * tile];
    let steps = tiles[2u * tile + 1u];
    let tag = steps.w;
    let hits = (select(first.y, first.x, row_of_bin < 4u) >> (8u * (row_of_bin % 4u))) & rays;
    let step_i = bitcast<u32>(bitcast<i32>(steps.x << 16u) >> 16u);
    let slope = Slope(hits, step_i, steps.y, tag >> 10u, 1u - ((tag >> 9u) & 1u), tag & 0x1ffu);
    let step_j = Height(bitcast<u32>(bitcast<i32>(steps.x) >> 16u), steps.z);
    var height = height_of_row(Height(first.z, first.w), step_j, row_of_bin);
    var l = (*row).lists;
    var undecided = (*row).undecided;
    l.l0 = insert(l.l0, cross(0u, slope, &height, &undecided), &undecided);
    l.l1 = insert(l.l1, cross(1u, slope, &height, &undecided), &undecided);
    l.l2 = insert(l.l2, cross(2u, slope, &height, &undecided), &undecided);
    l.l3 = insert(l.l3, cross(3u, slope, &height, &undecided), &undecided);
    l.l4 = insert(l.l4, cross(4u, slope, &height, &undecided), &undecided);
    l.l5 = insert(l.l5, cross(5u, slope, &height, &undecided), &undecided);
    l.l6 = insert(l.l6, cross(6u, slope, &height, &undecided), &undecided);
    l.l7 = insert(l.l7, cross(7u, slope, &height, &undecided), &undecided);
    (*row).lists = l;
    (*row).n_crossings += countOneBits(hits);
    (*row).undecided = undecided;
}

// The height at the first ray of a row.
fn height_of_row(first: Height, step: Height, row: u32) -> Height {
    let low = (step.fraction & 0xffffu) * row;
    let high = (step.fraction >> 16u) * row + (low >> 16u);
    let fraction = first.fraction + ((high << 16u) | (low & 0xffffu));
    return Height(first.cells + step.cells * row + (high >> 16u) + u32(fraction < first.fraction), fraction);
}

// The crossing of one ray, NO_EVENT if it does not hit; steps to the next ray.
fn cross(ray: u32, slope: Slope, height: ptr<function, Height>, undecided: ptr<function, u32>) -> u32 {
    let h = *height;
    let hits = ((slope.hits >> ray) & 1u) != 0u;
    *undecided |= u32(hits && h.fraction + 16u < slope.margin);
    let first_above = h.cells + select(1u, 0u, (h.fraction | slope.tie_is_below) == 0u);
    let cell = clamp(bitcast<i32>(first_above), 0, i32(params.depth));
    let fraction = h.fraction + slope.step_fraction;
    *height = Height(h.cells + slope.step_cells + u32(fraction < h.fraction), fraction);
    return select(NO_EVENT, (u32(cell) << 9u) | slope.label, hits);
}

// Whether a ray has two places left, or fewer.
fn is_crowded(l: Lists) -> bool {
    return (l.l0.high.y & l.l1.high.y & l.l2.high.y & l.l3.high.y
        & l.l4.high.y & l.l5.high.y & l.l6.high.y & l.l7.high.y) != NO_EVENT;
}

// Sweeps the crossings of all rays in cells before `until` into a segment of runs. What stays are crossings of later cells and
// those that opened a geometry, put into cell 0.
fn sweep_until(row: ptr<function, Row>, until: u32) {
    var lists = (*row).lists;
    var stay = lists;
    var written = Written(0u, 0u, 0u);
    var undecided = (*row).undecided;
    for (var ray = 0u; ray < 8u; ray++) {
        let list = lists.l0;
        let s = sweep(list, (*row).swept, until);
        written = with_ray(written, s.n_runs, ray);
        stay = rotated(stay, what_stays(s, list, until, &undecided));
        lists = rotated(lists, s.runs);
    }
    write_segment(row, lists, written);
    (*row).undecided = undecided;
    (*row).lists = stay;
    (*row).swept = until;
}

// Sweeps all crossings that are left into the last segment. Returns a bit for each ray that is inside of something at its end: what
// it does not leave it has not entered. That takes back the last run of a ray with one geometry, if this segment has it.
fn sweep_rest(row: ptr<function, Row>) -> u32 {
    var lists = (*row).lists;
    var written = Written(0u, 0u, 0u);
    var open = 0u;
    for (var ray = 0u; ray < 8u; ray++) {
        let s = sweep(lists.l0, (*row).swept, params.depth + 1u);
        let is_open = s.code != 0u;
        let n_runs = s.n_runs - select(0u, s.last_is_run, is_open);
        open |= u32(is_open) << ray;
        written = with_ray(written, n_runs, ray);
        lists = rotated(lists, without_runs_from(s.runs, n_runs));
    }
    if open != 0u && (params.n_ranks != 1u || (*row).swept != 0u) {
        (*row).undecided = 1u;
    }
    write_segment(row, lists, written);
    return open;
}

// What a segment has: numbers of runs of its rays, 4 bits each, of all, and places.
struct Written {
    counts: u32,
    n_runs: u32,
    n_places: u32,
}

fn with_ray(w: Written, n_runs: u32, ray: u32) -> Written {
    return Written(w.counts | (n_runs << (4u * ray)), w.n_runs + n_runs, w.n_places + (n_runs + 3u) / 4u);
}

// Writes runs as the next segment of a row, if there are any.
fn write_segment(row: ptr<function, Row>, runs_of_rays: Lists, written: Written) {
    if written.counts == 0u || (*row).undecided != 0u {
        return;
    }
    let is_linked = (*row).counts != 0u;
    let n_places = written.n_places + u32(is_linked);
    let start = atomicAdd(&totals.n_places, n_places);
    var place = start;
    if is_linked {
        write_place(&place, vec4<u32>((*row).place, (*row).counts, 0u, 0u));
    }
    var lists = runs_of_rays;
    for (var i = 0u; i < 8u; i++) {
        write_place(&place, lists.l0.low);
        write_place(&place, lists.l0.high);
        lists = rotated(lists, lists.l0);
    }
    (*row).place = start | select(0u, LINKED, is_linked);
    (*row).counts = written.counts;
    (*row).n_runs += written.n_runs;
    (*row).n_places += n_places;
}

// Writes four words, if there are any.
fn write_place(place: ptr<function, u32>, words: vec4<u32>) {
    if words.x != NO_EVENT {
        if *place < params.place_capacity {
            runs[*place] = words;
        }
        *place += 1u;
    }
}
