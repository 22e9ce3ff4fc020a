// Casts the rays and sweeps their crossings into runs in one pass: intersect_count, intersect_emit and map in registers, for
// rays of at most 8 crossings. Neither crossings nor offsets of rays go through memory, which is what those kernels spend
// their time on. A new crossing finds its place among the sorted ones of its ray by a minimum and a maximum a place.
// Left to columns_deep are rows with a deeper ray or with a height too near to a centre for the tile's numbers; all rows with
// more than 32 geometries, or several under the rule nonzero; and rays that do not leave one of several geometries.
// Twins: `src/crossings.rs`, `src/map.rs`.
// Reads: bin_offsets, tiles (2 vec4 a pair, see columns_setup); flag_of_rank.
// Writes: chunks[see rays.wgsl] = (start, number of runs of each of its 8 rays, 4 bits each), or (0, DEEP);
//         runs[start ..], ray after ray, chunks in no order; adds to totals.

@group(0) @binding(3) var<storage, read> tiles: array<vec4<u32>>;
@group(0) @binding(5) var<storage, read_write> runs: array<u32>;

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
    for (var pair = bin_offsets[rays.bin]; pair < end; pair++) {
        cross_row(pair, rays.row, &lists);
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

// Lists the crossings of a facet with the eight rays of a row, where they hit. Written out: drivers that run 8 threads in
// a vector pay more for an index into a vector than for a whole crossing.
fn cross_row(pair: u32, row: u32, lists: ptr<function, Lists>) {
    let first = tiles[2u * pair];
    let steps = tiles[2u * pair + 1u];
    let tag = steps.w;
    let hits = (select(first.y, first.x, row < 4u) >> (8u * (row % 4u))) & 0xffu;
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

// Sweeps the crossings of each ray of a row into runs.
fn sweep_row(rays: RayRow, lists: ptr<function, Lists>) {
    if !can_sweep(*lists) || (*lists).overflows != 0u {
        chunks[rays.chunk] = vec2<u32>(0u, DEEP);
        atomicAdd(&totals.n_deep, 1u);
        return;
    }
    let start = atomicAdd(&totals.n_slots, (*lists).n_crossings);
    var runs_of_rays = 0u;
    var n_runs = 0u;
    var n_odd = 0u;
    for (var i = 0u; i < 8u; i++) {
        var sweep = start_sweep(start + n_runs);
        feed4(&sweep, (*lists).l0.low, (*lists).l0.high.x);
        feed4(&sweep, (*lists).l0.high, NO_EVENT);
        if sweep.flag != 0u {
            n_odd += 1u;
            sweep.runs -= sweep.last_change_is_run;
        }
        runs_of_rays |= sweep.runs << (4u * i);
        n_runs += sweep.runs;
        rotate(lists, (*lists).l0);
    }
    chunks[rays.chunk] = vec2<u32>(start, runs_of_rays);
    if n_odd != 0u {
        atomicAdd(&totals.n_odd, n_odd);
    }
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

fn write_run(slot: u32, run: u32) {
    if slot < params.event_capacity {
        runs[slot] = run;
    }
}
