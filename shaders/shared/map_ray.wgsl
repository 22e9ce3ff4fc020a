// Sorts the crossings of one ray and sweeps them once into runs, in place: events[start .. start + n], never more runs than
// crossings. Twin: `src/map.rs`. The kernel binds `events`.

// Marks a count of changes or runs of a ray on which a counter stays open.
const ODD: u32 = 0x80000000u;

// Returns the number of runs, and ODD.
fn map_ray(start: u32, n: u32) -> u32 {
    if n == 0u {
        return 0u;
    }
    if ONE_RANK {
        return map_one(start, n);
    }
    return map_many(start, n);
}

// One geometry: the changes of the counter are the runs. Up to 8 crossings are sorted in registers.
fn map_one(start: u32, n: u32) -> u32 {
    var sweep = start_sweep(start);
    if n <= 8u {
        feed_sorted(&sweep, n);
    } else {
        sort(start, n);
        // runs are written behind the crossings that are read
        var event = events[start];
        for (var i = 1u; i <= n; i++) {
            let next = event_or_none(start, i, n);
            feed(&sweep, event, next);
            event = next;
        }
    }
    if sweep.flag != 0u {
        return (sweep.runs - sweep.last_change_is_run) | ODD;
    }
    return sweep.runs;
}

fn write_run(slot: u32, run: u32) {
    events[slot] = run;
}

// Sorts up to 8 events with Batcher's odd-even merge network and feeds them in order.
fn feed_sorted(sweep: ptr<function, Sweep>, n: u32) {
    let start = (*sweep).start;
    var a = vec4<u32>(events[start], event_or_none(start, 1u, n), event_or_none(start, 2u, n), event_or_none(start, 3u, n));
    if n <= 4u {
        a = sort4(a);
        feed4(sweep, a, NO_EVENT);
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
    feed4(sweep, vec4<u32>(low.x, even.x, odd.x, even.y), odd.y);
    feed4(sweep, vec4<u32>(odd.y, even.z, odd.z, high.w), NO_EVENT);
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
        var counter = 0u;
        while at < n && events[start + at] >> 24u == rank {
            let key = events[start + at] >> 1u;
            let was_inside = counter != 0u;
            while at < n && events[start + at] >> 1u == key {
                counter = count(counter, events[start + at]);
                at += 1u;
            }
            if was_inside != (counter != 0u) {
                events[start + changes] = ((key & 0x7fffffu) << 8u) | rank;
                changes += 1u;
            }
        }
        if counter != 0u {
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
