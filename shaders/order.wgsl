// Puts the runs of a band into the order of the rays, with flags for ranks, where they stay on the device. It runs twice: first it counts
// the runs of each ray, and when these numbers are scanned it writes the runs. A thread takes a ray, from its last run to its first,
// as segments are linked. A run whose flag is that of the run before it is left out.
// Twin: `crates/gpu/src/runs.rs`.
// Reads: chunks, runs (see map), deep_rows, events (see map_deep), sources.
// Reads and writes: offsets[rays of the band + 1]: the runs of each ray, or when scanned the first run of each, counted from that of the
// mesh, and the end. Writes: ordered[base of the band + ..] = cell << 8 | flag, ascending in each ray; adds to found.
// Nothing that map wrote is used as an index before it is known to be possible: what is not adds to found.n_faults.
// Bound: 129 segments of 8 rays and 8 runs, or MAX_DEEP_RUNS: under 2^14 loops an invocation.

struct Sources {
    // flag of each code of a run, a byte each
    flags: array<vec4<u32>, 16>,
    n_codes: u32,
    n_places: u32,  // of `runs` that are filled
    n_deep: u32,    // rows of `deep_rows`
    n_events: u32,  // words of `events` that are filled
    base: u32,      // first run of the band
    writes: u32,    // 0: count, 1: write
}

struct Found {
    n_faults: atomic<u32>,
    n_runs: atomic<u32>,    // of rows that are not deep, before equal ones are joined
    n_places: atomic<u32>,  // of these, with the links
    n_odd: atomic<u32>,     // rays, of these rows
}

@group(0) @binding(1) var<uniform> sources: Sources;
@group(0) @binding(2) var<storage, read_write> deep_rows: array<u32>;
@group(0) @binding(3) var<storage, read_write> offsets: array<u32>;
@group(0) @binding(4) var<storage, read_write> events: array<u32>;
@group(0) @binding(5) var<storage, read_write> runs: array<vec4<u32>>;
@group(0) @binding(7) var<storage, read_write> ordered: array<u32>;
@group(0) @binding(8) var<storage, read_write> found: Found;

const LINKED: u32 = 0x80000000u;
const PLACE: u32 = 0x07ffffffu;
// Segments of a row: one a layer, and the last.
const MAX_SEGMENTS: u32 = 129u;
const MAX_DEEP_RUNS: u32 = 8192u;

// A ray on the way from its last run to its first.
struct Walk {
    // the run after, with its code, and with its flag; NONE at first
    raw: u32,
    pending: u32,
    n: u32,      // runs that are counted or written
    end: u32,    // where the next is written, and one more
    faults: u32,
}

const NONE: u32 = 0xffffffffu;

@compute @workgroup_size(64)
fn order(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let ray = thread_index(group, groups, local);
    if ray >= (params.end_row - params.first_row) * params.n_i {
        return;
    }
    let lane = ray % params.n_i % BIN;
    var last = vec2<u32>(ray / params.n_i * params.n_across + ray % params.n_i / BIN, DEEP);
    if params.all_deep == 0u {
        last = chunks[last.x];
    }
    var walk = Walk(NONE, NONE, 0u, 0u, 0u);
    if sources.writes == 1u {
        walk.end = offsets[ray + 1u] - sources.base;
    }
    if last.y == DEEP {
        walk_deep(last.x, lane, &walk);
    } else {
        walk_segments(last, lane, &walk);
    }
    if walk.raw != NONE {
        // the first run of a ray is none of background
        walk.faults |= u32((walk.raw & 0xffu) == 0u);
        if (walk.pending & 0xffu) != 0u {
            keep(&walk);
        }
    }
    if sources.writes == 0u {
        offsets[ray] = walk.n;
    } else {
        walk.faults |= u32(walk.end + sources.base != offsets[ray]);
    }
    if walk.faults != 0u {
        atomicAdd(&found.n_faults, 1u);
    }
}

fn walk_deep(row: u32, lane: u32, walk: ptr<function, Walk>) {
    if row >= sources.n_deep {
        (*walk).faults = 1u;
        return;
    }
    let first = deep_rows[16u * row + lane];
    let n = deep_rows[16u * row + 8u + lane];
    if n == 0u {
        return;
    }
    if n > MAX_DEEP_RUNS || first > sources.n_events || n > sources.n_events - first {
        (*walk).faults = 1u;
        return;
    }
    for (var left = n; left != 0u; left--) {
        visit(events[first + left - 1u], walk);
    }
}

fn walk_segments(last: vec2<u32>, lane: u32, walk: ptr<function, Walk>) {
    // counted once a row, once a band
    let tells = lane == 0u && sources.writes == 0u;
    if tells {
        atomicAdd(&found.n_odd, (last.x & ~LINKED) >> 27u);
    }
    var word = last.x;
    var counts = last.y;
    for (var left = MAX_SEGMENTS; counts != 0u; left--) {
        let is_linked = word >= LINKED;
        let first = word & PLACE;
        var places = u32(is_linked);
        var before = places;
        var n_runs = 0u;
        for (var i = 0u; i < BIN; i++) {
            let n = (counts >> (4u * i)) & 15u;
            (*walk).faults |= u32(n > 8u);
            before += select(0u, (n + 3u) / 4u, i < lane);
            places += (n + 3u) / 4u;
            n_runs += n;
        }
        if left == 0u || (*walk).faults != 0u || first > sources.n_places || places > sources.n_places - first {
            (*walk).faults = 1u;
            return;
        }
        if tells {
            atomicAdd(&found.n_runs, n_runs);
            atomicAdd(&found.n_places, places);
        }
        for (var n = (counts >> (4u * lane)) & 15u; n != 0u; n--) {
            visit(runs[first + before + (n - 1u) / 4u][(n - 1u) % 4u], walk);
        }
        if !is_linked {
            return;
        }
        let link = runs[first];
        word = link.x;
        counts = link.y;
    }
}

// Takes the run before those that were taken; the one after it stays where its flag is another.
fn visit(run: u32, walk: ptr<function, Walk>) {
    let w = *walk;
    let code = run & 0xffu;
    let is_last = w.raw == NONE;
    let follows = is_last || (run >> 8u < w.raw >> 8u && code != (w.raw & 0xffu));
    if !follows || run >> 8u >= params.depth || code >= sources.n_codes {
        (*walk).faults = 1u;
    }
    let flag = (sources.flags[code / 16u][code / 4u % 4u] >> (8u * (code % 4u))) & 0xffu;
    if !is_last && (w.pending & 0xffu) != flag {
        keep(walk);
    }
    (*walk).raw = run;
    (*walk).pending = (run & 0xffffff00u) | flag;
}

// Counts the run that waits, or writes it.
fn keep(walk: ptr<function, Walk>) {
    (*walk).n += 1u;
    if sources.writes == 1u {
        (*walk).end -= 1u;
        if (*walk).end < arrayLength(&ordered) {
            ordered[(*walk).end] = (*walk).pending;
        }
    }
}
