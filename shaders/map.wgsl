// Sorts the crossings of each ray and sweeps them once into runs, in place. Twin: `src/map.rs`.
// Reads: ray_offsets[ray of the band], rays + 1 entries; flag_of_rank, four flags a word.
// Reads and writes: events: crossings in, runs out (cell << 8 | flag), never more of them than crossings.
// Writes: run_counts[ray], rays + 1 entries; adds to n_odd the rays on which a counter stays open.

@group(0) @binding(1) var<storage, read> ray_offsets: array<u32>;
@group(0) @binding(2) var<storage, read_write> events: array<u32>;
@group(0) @binding(3) var<storage, read_write> run_counts: array<u32>;
@group(0) @binding(5) var<storage, read_write> n_odd: atomic<u32>;
@group(0) @binding(4) var<uniform> flag_of_rank: array<vec4<u32>, 16>;

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
    if params.n_ranks == 1u {
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
    return flag_of_rank[rank / 16u][(rank / 4u) % 4u] >> (8u * (rank % 4u)) & 0xffu;
}

fn count(counter: i32, event: u32) -> i32 {
    if params.rule == 0u {
        return counter ^ 1;
    }
    return counter + 1 - 2 * i32(event & 1u);
}

// One geometry: the changes of the counter are the runs.
fn map_one(start: u32, n: u32) -> u32 {
    sort(start, n);
    let flag = flag_of(0u);
    var runs = 0u;
    var counter = 0;
    var last_change_is_run = 0u;
    var at = 0u;
    while at < n {
        let cell = events[start + at] >> 9u;
        let was_inside = counter != 0;
        while at < n && events[start + at] >> 9u == cell {
            counter = count(counter, events[start + at]);
            at += 1u;
        }
        if was_inside != (counter != 0) {
            last_change_is_run = u32(cell < params.depth);
            if cell < params.depth {
                events[start + runs] = cell << 8u | select(flag, 0u, was_inside);
                runs += 1u;
            }
        }
    }
    if counter != 0 {
        return (runs - last_change_is_run) | ODD;
    }
    return runs;
}

// Several geometries: where each begins and ends, then the winner at each of these cells.
fn map_many(start: u32, n: u32) -> u32 {
    for (var i = start; i < start + n; i++) {
        let event = events[i];
        events[i] = (event >> 1u & 0xffu) << 24u | event >> 9u << 1u | (event & 1u);
    }
    sort(start, n);
    let changes = find_changes(start, n);
    sort(start, changes & ~ODD);
    return sweep(start, changes & ~ODD) | (changes & ODD);
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
                events[start + changes] = (key & 0x7fffffu) << 8u | rank;
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
fn sweep(start: u32, n: u32) -> u32 {
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
            events[start + runs] = cell << 8u | winner;
            runs += 1u;
            flag = winner;
        }
    }
    return runs;
}
