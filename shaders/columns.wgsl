// Casts the rays and sweeps their crossings into runs in one pass: intersect_count, intersect_emit and map in registers, for
// rays of at most 8 crossings. Neither crossings nor offsets of rays go through memory, which is what those kernels spend
// their time on. A new crossing finds its place among the sorted ones of its ray by a minimum and a maximum a place.
// Left to columns_deep are rows with a deeper ray or with a height too near to a centre for the tile's numbers; all rows with
// more than 32 geometries, or several under the rule nonzero; and rays that do not leave one of several geometries.
// Twins: `src/crossings.rs`, `src/map.rs`.
// Reads: bin_offsets, tiles (2 vec4 a pair, see columns_setup); flag_of_rank.
// Writes: chunks[see rays.wgsl] = (start, number of runs of each of its 8 rays, 4 bits each), or (0, DEEP);
//         runs[start ..], ray after ray, four runs a place and each ray from a new place on, chunks in no order; adds to totals.

@group(0) @binding(3) var<storage, read> tiles: array<vec4<u32>>;
@group(0) @binding(5) var<storage, read_write> runs: array<vec4<u32>>;

// Whether there is only one geometry, under the rule parity. A constant of the pipeline, like ONE_RANK.
override ALTERNATES: bool = false;

@compute @workgroup_size(64)
fn columns(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let rays = ray_row(group, local);
    if rays.count == 0u {
        return;
    }
    var lists = Lists();
    for (var i = 0u; i < 8u; i++) {
        rotate(&lists, empty_list());
    }
    let end = min(bin_offsets[rays.bin + 1u], params.pair_capacity);
    // two at a time, since drivers that run 8 threads in a vector pay for each variable that a loop carries
    for (var pair = bin_offsets[rays.bin]; pair < end; pair += 2u) {
        let next = min(pair + 1u, end - 1u);
        cross_row(pair, rays.row, 0xffu, &lists);
        cross_row(next, rays.row, select(0u, 0xffu, next != pair), &lists);
    }
    sweep_row(rays, &lists);
}

// The crossings of the 8 rays of a row.
struct Lists {
    l0: List, l1: List, l2: List, l3: List, l4: List, l5: List, l6: List, l7: List,
    n_crossings: u32,
    overflows: u32,     // whether a crossing found no place, or none is certain
}

// The crossings of a ray, sorted; free places hold NO_EVENT.
struct List {
    low: vec4<u32>,
    high: vec4<u32>,
}

fn empty_list() -> List {
    return List(vec4<u32>(NO_EVENT), vec4<u32>(NO_EVENT));
}

// Puts a list in the last place; the one in the first is gone.
fn rotate(lists: ptr<function, Lists>, list: List) {
    (*lists).l0 = (*lists).l1;
    (*lists).l1 = (*lists).l2;
    (*lists).l2 = (*lists).l3;
    (*lists).l3 = (*lists).l4;
    (*lists).l4 = (*lists).l5;
    (*lists).l5 = (*lists).l6;
    (*lists).l6 = (*lists).l7;
    (*lists).l7 = list;
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

// Lists the crossings of a facet with the rays of a row, a bit each, where they hit. Written out: drivers that run 8 threads in
// a vector pay more for an index into a vector than for a whole crossing.
fn cross_row(pair: u32, row: u32, rays: u32, lists: ptr<function, Lists>) {
    let first = tiles[2u * pair];
    let steps = tiles[2u * pair + 1u];
    let tag = steps.w;
    let hits = (select(first.y, first.x, row < 4u) >> (8u * (row % 4u))) & rays;
    let step_i = bitcast<u32>(bitcast<i32>(steps.x << 16u) >> 16u);
    let slope = Slope(hits, step_i, steps.y, tag >> 10u, 1u - ((tag >> 9u) & 1u), tag & 0x1ffu);
    let step_j = Height(bitcast<u32>(bitcast<i32>(steps.x) >> 16u), steps.z);
    var height = height_of_row(Height(first.z, first.w), step_j, row);
    var l = *lists;
    var overflows = l.overflows;
    l.l0 = insert(l.l0, cross(0u, slope, &height, &overflows), &overflows);
    l.l1 = insert(l.l1, cross(1u, slope, &height, &overflows), &overflows);
    l.l2 = insert(l.l2, cross(2u, slope, &height, &overflows), &overflows);
    l.l3 = insert(l.l3, cross(3u, slope, &height, &overflows), &overflows);
    l.l4 = insert(l.l4, cross(4u, slope, &height, &overflows), &overflows);
    l.l5 = insert(l.l5, cross(5u, slope, &height, &overflows), &overflows);
    l.l6 = insert(l.l6, cross(6u, slope, &height, &overflows), &overflows);
    l.l7 = insert(l.l7, cross(7u, slope, &height, &overflows), &overflows);
    l.n_crossings += countOneBits(hits);
    l.overflows = overflows;
    *lists = l;
}

// The height at the first ray of a row.
fn height_of_row(first: Height, step: Height, row: u32) -> Height {
    let low = (step.fraction & 0xffffu) * row;
    let high = (step.fraction >> 16u) * row + (low >> 16u);
    let fraction = first.fraction + ((high << 16u) | (low & 0xffffu));
    return Height(first.cells + step.cells * row + (high >> 16u) + u32(fraction < first.fraction), fraction);
}

// The crossing of one ray, NO_EVENT if it does not hit; steps to the next ray.
fn cross(ray: u32, slope: Slope, height: ptr<function, Height>, overflows: ptr<function, u32>) -> u32 {
    let h = *height;
    let hits = ((slope.hits >> ray) & 1u) != 0u;
    *overflows |= u32(hits && h.fraction + 16u < slope.margin);
    let first_above = h.cells + select(1u, 0u, (h.fraction | slope.tie_is_below) == 0u);
    let cell = clamp(bitcast<i32>(first_above), 0, i32(params.depth));
    let fraction = h.fraction + slope.step_fraction;
    *height = Height(h.cells + slope.step_cells + u32(fraction < h.fraction), fraction);
    return select(NO_EVENT, (u32(cell) << 9u) | slope.label, hits);
}

// A list with one more crossing, or none if it is NO_EVENT.
fn insert(list: List, event: u32, overflows: ptr<function, u32>) -> List {
    let v = vec4<u32>(event);
    *overflows |= u32(max(list.high.w, event) != NO_EVENT);
    return List(
        min(list.low, max(vec4<u32>(0u, list.low.xyz), v)),
        min(list.high, max(vec4<u32>(list.low.w, list.high.xyz), v)),
    );
}

// Sweeps the crossings of each ray of a row into runs, and writes them four at a time.
fn sweep_row(rays: RayRow, lists: ptr<function, Lists>) {
    if !can_sweep(*lists) || (*lists).overflows != 0u {
        chunks[rays.chunk] = vec2<u32>(0u, DEEP);
        atomicAdd(&totals.n_deep, 1u);
        return;
    }
    var row = Swept();
    if ALTERNATES {
        cancel_twins(lists);
    }
    for (var i = 0u; i < 8u; i++) {
        rotate(lists, runs_of((*lists).l0, i, &row));
    }
    let start = atomicAdd(&totals.n_places, row.n_places);
    chunks[rays.chunk] = vec2<u32>(start, row.n_runs);
    var place = start;
    for (var i = 0u; i < 8u; i++) {
        write_runs(&place, (*lists).l0.low);
        write_runs(&place, (*lists).l0.high);
        rotate(lists, (*lists).l0);
    }
    let n_lost = (*lists).n_crossings - row.n_all_runs;
    if n_lost != 0u {
        atomicAdd(&totals.n_lost, n_lost);
    }
    if row.n_odd != 0u {
        atomicAdd(&totals.n_odd, row.n_odd);
    }
}

// What the sweep of a row finds.
struct Swept {
    n_runs: u32,        // of each ray, 4 bits each
    n_all_runs: u32,
    n_places: u32,      // that the runs take, four each
    n_odd: u32,         // rays on which a counter stays open
}

// Writes the runs of a half list, if there are any.
fn write_runs(place: ptr<function, u32>, half: vec4<u32>) {
    if half.x != NO_EVENT {
        if *place < params.event_capacity / 4u {
            runs[*place] = half;
        }
        *place += 1u;
    }
}

// The runs of a ray, in order, from its crossings.
fn runs_of(crossings: List, ray: u32, row: ptr<function, Swept>) -> List {
    var list = List();
    if ALTERNATES {
        list = alternating_runs(crossings, row);
    } else {
        list = swept_runs(crossings, row);
    }
    let is_run = vec4<u32>(list.low != vec4<u32>(NO_EVENT)) + vec4<u32>(list.high != vec4<u32>(NO_EVENT));
    let n_runs = is_run.x + is_run.y + is_run.z + is_run.w;
    (*row).n_runs |= n_runs << (4u * ray);
    (*row).n_all_runs += n_runs;
    (*row).n_places += (n_runs + 3u) / 4u;
    return list;
}

// One geometry under the rule parity: each crossing begins a run, by turns inside and outside. Crossings past the end of the
// ray begin none, nor does the last of an odd number.
fn alternating_runs(crossings: List, row: ptr<function, Swept>) -> List {
    let low = crossings.low;
    let high = crossings.high;
    let none = vec4<u32>(NO_EVENT);
    let no_next_low = vec2<bool>(low.y == NO_EVENT, low.w == NO_EVENT);
    let no_next_high = vec2<bool>(high.y == NO_EVENT, high.w == NO_EVENT);
    let is_odd = (low.x != NO_EVENT && no_next_low.x) || (low.z != NO_EVENT && no_next_low.y)
        || (high.x != NO_EVENT && no_next_high.x) || (high.z != NO_EVENT && no_next_high.y);
    (*row).n_odd += u32(is_odd);
    let flags = vec4<u32>(flag_of(0u), 0u, flag_of(0u), 0u);
    let depth = vec4<u32>(params.depth);
    let ends_low = vec4<bool>(no_next_low.x, false, no_next_low.y, false) | ((low >> vec4<u32>(9u)) >= depth);
    let ends_high = vec4<bool>(no_next_high.x, false, no_next_high.y, false) | ((high >> vec4<u32>(9u)) >= depth);
    return List(
        select(((low >> vec4<u32>(9u)) << vec4<u32>(8u)) | flags, none, ends_low),
        select(((high >> vec4<u32>(9u)) << vec4<u32>(8u)) | flags, none, ends_high),
    );
}

// Takes out pairs of crossings of the same cell, at most four a ray: nothing lies between them. They are rare.
fn cancel_twins(lists: ptr<function, Lists>) {
    for (var left = select(0u, 4u * 8u, have_twins(*lists)); left != 0u; left--) {
        rotate(lists, without_twins((*lists).l0));
    }
}

fn have_twins(lists: Lists) -> bool {
    return any(twins_in(lists.l0) | twins_in(lists.l1) | twins_in(lists.l2) | twins_in(lists.l3)
        | twins_in(lists.l4) | twins_in(lists.l5) | twins_in(lists.l6) | twins_in(lists.l7));
}

// Whether a crossing at one of four places is of the cell of the next, before or after the middle.
fn twins_in(list: List) -> vec4<bool> {
    return twins(list.low, vec4<u32>(list.low.yzw, list.high.x)) | twins(list.high, vec4<u32>(list.high.yzw, NO_EVENT));
}

fn twins(crossings: vec4<u32>, next: vec4<u32>) -> vec4<bool> {
    return ((crossings ^ next) < vec4<u32>(512u)) & (next != vec4<u32>(NO_EVENT));
}

// A list without its first pair of crossings of the same cell.
fn without_twins(list: List) -> List {
    let low = twins(list.low, vec4<u32>(list.low.yzw, list.high.x));
    let high = twins(list.high, vec4<u32>(list.high.yzw, NO_EVENT));
    let until = vec4<bool>(low.x, low.x || low.y, low.x || low.y || low.z, any(low));
    let until_high = vec4<bool>(high.x, high.x || high.y, high.x || high.y || high.z, any(high)) | vec4<bool>(until.w);
    return List(
        select(list.low, vec4<u32>(list.low.zw, list.high.xy), until),
        select(list.high, vec4<u32>(list.high.zw, NO_EVENT, NO_EVENT), until_high),
    );
}

// Any geometries and either rule: crossing after crossing.
fn swept_runs(crossings: List, row: ptr<function, Swept>) -> List {
    swept = List(vec4<u32>(NO_EVENT), vec4<u32>(NO_EVENT));
    var sweep = start_sweep(0u);
    feed4(&sweep, crossings.low, crossings.high.x);
    feed4(&sweep, crossings.high, NO_EVENT);
    if sweep.flag != 0u {
        (*row).n_odd += 1u;
        if sweep.last_change_is_run != 0u {
            write_run(sweep.runs - 1u, NO_EVENT);
        }
    }
    return swept;
}

// The runs so far of the ray that is swept.
var<private> swept: List;

fn write_run(slot: u32, run: u32) {
    swept.low = select(swept.low, vec4<u32>(run), vec4<u32>(slot) == vec4<u32>(0u, 1u, 2u, 3u));
    swept.high = select(swept.high, vec4<u32>(run), vec4<u32>(slot) == vec4<u32>(4u, 5u, 6u, 7u));
}

// Whether a bit is enough to count each geometry, and all rays leave all that they enter.
fn can_sweep(lists: Lists) -> bool {
    if ONE_RANK {
        return true;
    }
    let open = open_in(lists.l0) | open_in(lists.l1) | open_in(lists.l2) | open_in(lists.l3)
        | open_in(lists.l4) | open_in(lists.l5) | open_in(lists.l6) | open_in(lists.l7);
    return params.n_ranks <= 32u && params.rule == 0u && open == 0u;
}

// The geometries, a bit each, that a ray enters and does not leave under the rule parity.
fn open_in(list: List) -> u32 {
    let bits = bits_of(list.low) ^ bits_of(list.high);
    return bits.x ^ bits.y ^ bits.z ^ bits.w;
}

fn bits_of(events: vec4<u32>) -> vec4<u32> {
    let bits = vec4<u32>(1u) << ((events >> vec4<u32>(1u)) & vec4<u32>(31u));
    return select(bits, vec4<u32>(0u), events == vec4<u32>(NO_EVENT));
}
