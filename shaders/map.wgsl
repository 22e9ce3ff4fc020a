// Sorts the crossings of each ray and sweeps them once into runs, in place. Twin: `src/map.rs`.
// Reads: ray_offsets[ray of the band], rays + 1 entries; flag_of_rank, four flags a word.
// Reads and writes: events: crossings in, runs out (cell << 8 | flag), never more of them than crossings.
// Writes: run_counts[ray], rays + 1 entries; adds to n_odd the rays on which a counter stays open.

@group(0) @binding(1) var<storage, read> ray_offsets: array<u32>;
@group(0) @binding(2) var<storage, read_write> events: array<u32>;
@group(0) @binding(3) var<storage, read_write> run_counts: array<u32>;
@group(0) @binding(5) var<storage, read_write> n_odd: atomic<u32>;
@group(0) @binding(4) var<uniform> flag_of_rank: array<vec4<u32>, 16>;

// Whether there is only one geometry. A constant of the pipeline: the long way is then not even compiled.
override ONE_RANK: bool = false;

// Marks a count of changes or runs of a ray on which a counter stays open.
const ODD: u32 = 0x80000000u;

@compute @workgroup_size(64)
fn map(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let ray = thread_index(group, groups, local);
    if ray >= (params.end_row - params.first_row) * params.n_i {
        return;
    }
    let start = ray_offsets[ray];
    let end = min(ray_offsets[ray + 1u], params.event_capacity);
    if start >= end {
        run_counts[ray] = 0u;
        return;
    }
    var result = 0u;
    if ONE_RANK {
        result = map_one(start, end - start);
    } else {
        result = map_many(start, end - start);
    }
    if (result & ODD) != 0u {
        atomicAdd(&n_odd, 1u);
    }
    run_counts[ray] = result & ~ODD;
}

fn flag_of(rank: u32) -> u32 {
    return (flag_of_rank[rank / 16u][(rank / 4u) % 4u] >> (8u * (rank % 4u))) & 0xffu;
}

fn count(counter: i32, event: u32) -> i32 {
    if params.rule == 0u {
        return counter ^ 1;
    }
    return counter + 1 - 2 * i32(event & 1u);
}

// Sorts above all events: feeding it only ends the cell before.
const NO_EVENT: u32 = 0xffffffffu;

// One geometry: the changes of the counter are the runs. Up to 8 crossings are sorted in registers.
fn map_one(start: u32, n: u32) -> u32 {
    var sweep = Sweep(start, 0u, 0u, 0, false, 0u, flag_of(0u));
    if n <= 8u {
        feed_sorted(&sweep, n);
    } else {
        sort(start, n);
        for (var i = start; i < start + n; i++) {
            feed(&sweep, events[i]);
        }
    }
    feed(&sweep, NO_EVENT);
    if sweep.is_inside {
        return (sweep.runs - sweep.last_change_is_run) | ODD;
    }
    return sweep.runs;
}

// The state of a walk over the sorted crossings of one geometry.
struct Sweep {
    start: u32,                 // where its runs go
    runs: u32,                  // written so far
    cell: u32,                  // cell of the crossings counted last
    counter: i32,
    is_inside: bool,            // before that cell
    last_change_is_run: u32,    // 0 if the last change lies past the end of the ray
    flag: u32,
}

fn feed(sweep: ptr<function, Sweep>, event: u32) {
    let cell = event >> 9u;
    if cell != (*sweep).cell {
        let is_inside = (*sweep).counter != 0;
        if is_inside != (*sweep).is_inside {
            let is_run = (*sweep).cell < params.depth;
            if is_run {
                events[(*sweep).start + (*sweep).runs] = ((*sweep).cell << 8u) | select(0u, (*sweep).flag, is_inside);
            }
            (*sweep).runs += u32(is_run);
            (*sweep).last_change_is_run = u32(is_run);
            (*sweep).is_inside = is_inside;
        }
        (*sweep).cell = cell;
    }
    if event != NO_EVENT {
        (*sweep).counter = count((*sweep).counter, event);
    }
}

// Sorts up to 8 events with Batcher's odd-even merge network and feeds them in order.
fn feed_sorted(sweep: ptr<function, Sweep>, n: u32) {
    let start = (*sweep).start;
    var a = vec4<u32>(events[start], event_or_none(start, 1u, n), event_or_none(start, 2u, n), event_or_none(start, 3u, n));
    if n <= 4u {
        a = sort4(a);
        feed4(sweep, a);
        return;
    }
    var b = vec4<u32>(
        events[start + 4u], event_or_none(start, 5u, n), event_or_none(start, 6u, n), event_or_none(start, 7u, n),
    );
    a = sort4(a);
    b = sort4(b);
    // merge: compare places i and i + 4, then i + 2 and i + 4, then i + 1 and i + 2
    let low = min(a, b);
    let high = max(a, b);
    let middle = vec4<u32>(min(low.zw, high.xy), max(low.zw, high.xy));
    let x = vec3<u32>(low.y, middle.y, middle.w);
    let y = vec3<u32>(middle.x, middle.z, high.z);
    let even = min(x, y);
    let odd = max(x, y);
    feed4(sweep, vec4<u32>(low.x, even.x, odd.x, even.y));
    feed4(sweep, vec4<u32>(odd.y, even.z, odd.z, high.w));
}

fn event_or_none(start: u32, index: u32, n: u32) -> u32 {
    if index < n {
        return events[start + index];
    }
    return NO_EVENT;
}

fn sort4(v: vec4<u32>) -> vec4<u32> {
    let low = min(v.xz, v.yw);
    let high = max(v.xz, v.yw);
    let ends = vec2<u32>(min(low.x, low.y), max(high.x, high.y));
    let inner = vec2<u32>(max(low.x, low.y), min(high.x, high.y));
    return vec4<u32>(ends.x, min(inner.x, inner.y), max(inner.x, inner.y), ends.y);
}

fn feed4(sweep: ptr<function, Sweep>, sorted: vec4<u32>) {
    feed(sweep, sorted.x);
    feed(sweep, sorted.y);
    feed(sweep, sorted.z);
    feed(sweep, sorted.w);
}

// Several geometries: where each begins and ends, then the winner at each of these cells.
fn map_many(start: u32, n: u32) -> u32 {
    for (var i = start; i < start + n; i++) {
        let event = events[i];
        events[i] = (((event >> 1u) & 0xffu) << 24u) | ((event >> 9u) << 1u) | (event & 1u);
    }
    sort(start, n);
    let changes = find_changes(start, n);
    sort(start, changes & ~ODD);
    return sweep_ranks(start, changes & ~ODD) | (changes & ODD);
}

// Turns events sorted by rank and cell into changes, cell << 8 | rank; returns their number, and ODD if a counter stays open.
fn find_changes(start: u32, n: u32) -> u32 {
    var changes = 0u;
    var odd = 0u;
    var at = 0u;
    while at < n {
        let rank = events[start + at] >> 24u;
        var counter = 0;
        while at < n && events[start + at] >> 24u == rank {
            let key = events[start + at] >> 1u;
            let was_inside = counter != 0;
            while at < n && events[start + at] >> 1u == key {
                counter = count(counter, events[start + at]);
                at += 1u;
            }
            if was_inside != (counter != 0) {
                events[start + changes] = ((key & 0x7fffffu) << 8u) | rank;
                changes += 1u;
            }
        }
        if counter != 0 {
            odd = ODD;
            changes -= 1u;
        }
    }
    return changes | odd;
}

// Sweeps sorted changes and writes a run wherever the winning flag changes; returns the number of runs.
fn sweep_ranks(start: u32, n: u32) -> u32 {
    var inside = array<u32, 8>();
    var flag = 0u;
    var runs = 0u;
    var at = 0u;
    while at < n {
        let cell = events[start + at] >> 8u;
        if cell >= params.depth {
            break;
        }
        while at < n && events[start + at] >> 8u == cell {
            let rank = events[start + at] & 0xffu;
            inside[rank / 32u] ^= 1u << (rank % 32u);
            at += 1u;
        }
        var winner = 0u;
        for (var word = 0u; word < 8u; word++) {
            if inside[word] != 0u {
                winner = flag_of(word * 32u + firstLeadingBit(inside[word]));
            }
        }
        if winner != flag {
            events[start + runs] = (cell << 8u) | winner;
            runs += 1u;
            flag = winner;
        }
    }
    return runs;
}
