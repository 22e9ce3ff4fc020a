// Sorts the crossings of a deep row and sweeps them into runs: a workgroup a row, any geometries, either rule.
// Rows with more than MAX_EVENTS crossings, rays with more than MAX_OF_RAY, and rays that do not leave all they enter are left to
// the CPU definition. Twin: `crates/core/src/stages/map.rs`.
// Reads: event_offsets[row], n_deep + 1 entries. Reads and writes: events[event_offsets[row] ..], sorted and then overwritten by runs,
// cell << 8 | (rank + 1 of the geometry that wins, or 0); the second half of the buffer, event_capacity words, is for the sort.
// Writes: deep_rows[16 row ..] = first run of each of the 8 rays in `events`, then their numbers; or LEFT in the first word.
// Bound: 6 passes over 2 * MAX_EVENTS / THREADS crossings, and MAX_OF_RAY steps of a sweep: under 2^14 loops an invocation.

@group(0) @binding(2) var<storage, read> event_offsets: array<u32>;
@group(0) @binding(4) var<storage, read_write> events: array<u32>;
@group(0) @binding(5) var<storage, read_write> deep_rows: array<u32>;

const MAX_EVENTS: u32 = 32768u;
const MAX_OF_RAY: u32 = 8192u;
const LEFT: u32 = 0xffffffffu;
const THREADS: u32 = 64u;
const DIGITS: u32 = 16u;

// In the sort: crossings of each digit of each thread, digit * THREADS + thread, then where the next of them goes.
// In the sweep: a counter for each geometry of each ray, ray * n_ranks + rank.
var<workgroup> counters: array<u32, 2048>;
var<workgroup> sums: array<u32, 64>;
var<workgroup> is_left: u32;

@compute @workgroup_size(64)
fn map_deep(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let row = group.y * groups.x + group.x;
    // the last of the square of workgroups may have no row
    if row + 1u >= arrayLength(&event_offsets) {
        return;
    }
    let start = event_offsets[row];
    let n = event_offsets[row + 1u] - start;
    if n > MAX_EVENTS {
        if local == 0u {
            deep_rows[16u * row] = LEFT;
        }
        return;
    }
    if n == 0u {
        if local < BIN {
            deep_rows[16u * row + local] = start;
            deep_rows[16u * row + 8u + local] = 0u;
        }
        return;
    }
    if n <= THREADS {
        sort_few(local, start, n);
    } else {
        // an even number of passes, so that the last writes where the first has read
        let bits = firstLeadingBit(8u * params.depth + 7u) + 1u;
        for (var shift = 0u; shift < (bits + 7u) / 8u * 8u; shift += 4u) {
            sort_by_digit(local, start, n, shift);
        }
    }
    if local == 0u {
        is_left = 0u;
    }
    for (var i = local; i < BIN * params.n_ranks; i += THREADS) {
        counters[i] = 0u;
    }
    workgroupBarrier();
    if local < BIN {
        let first = first_of_ray(local, start, n);
        let end = first_of_ray(local + 1u, start, n);
        deep_rows[16u * row + local] = first;
        deep_rows[16u * row + 8u + local] = sweep_ray(local, first, end);
    }
    storageBarrier();
    workgroupBarrier();
    if local == 0u && is_left != 0u {
        deep_rows[16u * row] = LEFT;
    }
}

// What crossings are sorted by, ray by ray and cell by cell: those of a cell count together, in any order.
fn key_of(event: u32) -> u32 {
    return (event >> 27u) * (params.depth + 1u) + ((event >> 9u) & 0x3ffffu);
}

// 4 bits of it.
fn digit_of(event: u32, shift: u32) -> u32 {
    return (key_of(event) >> shift) & 15u;
}

// Sorts at most a crossing a thread: each counts those before its own.
fn sort_few(local: u32, start: u32, n: u32) {
    let event = events[start + min(local, n - 1u)];
    let key = key_of(event);
    var place = start;
    for (var i = 0u; i < n; i++) {
        let other = key_of(events[start + i]);
        place += u32(other < key || (other == key && i < local));
    }
    storageBarrier();
    workgroupBarrier();
    if local < n {
        events[place] = event;
    }
    storageBarrier();
    workgroupBarrier();
}

// One pass of a radix sort, stable: from one half of the buffer to the other.
fn sort_by_digit(local: u32, start: u32, n: u32, shift: u32) {
    let from_half = start + (shift / 4u % 2u) * params.event_capacity;
    let to_half = start + (1u - shift / 4u % 2u) * params.event_capacity;
    let share = (n + THREADS - 1u) / THREADS;
    let first = from_half + min(local * share, n);
    let end = from_half + min((local + 1u) * share, n);
    for (var digit = 0u; digit < DIGITS; digit++) {
        counters[digit * THREADS + local] = 0u;
    }
    for (var i = first; i < end; i++) {
        counters[digit_of(events[i], shift) * THREADS + local] += 1u;
    }
    workgroupBarrier();
    var sum = 0u;
    for (var i = 0u; i < DIGITS; i++) {
        sum += counters[local * DIGITS + i];
    }
    sums[local] = sum;
    for (var reach = 1u; reach < THREADS; reach *= 2u) {
        workgroupBarrier();
        let left = select(0u, sums[max(local, reach) - reach], local >= reach);
        workgroupBarrier();
        sums[local] += left;
    }
    workgroupBarrier();
    var before = sums[local] - sum;
    for (var i = 0u; i < DIGITS; i++) {
        let count = counters[local * DIGITS + i];
        counters[local * DIGITS + i] = before;
        before += count;
    }
    workgroupBarrier();
    for (var i = first; i < end; i++) {
        let event = events[i];
        let counter = digit_of(event, shift) * THREADS + local;
        events[to_half + counters[counter]] = event;
        counters[counter] += 1u;
    }
    storageBarrier();
    workgroupBarrier();
}

// Where the sorted crossings of a ray begin.
fn first_of_ray(ray: u32, start: u32, n: u32) -> u32 {
    var low = start;
    var high = start + n;
    for (var left = 16u; left != 0u && low < high; left--) {
        let middle = (low + high) / 2u;
        if events[middle] >> 27u < ray {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    return low;
}

// Sweeps the sorted crossings of a ray into runs, written over those that are swept; returns their number.
fn sweep_ray(ray: u32, first: u32, end: u32) -> u32 {
    if end - first > MAX_OF_RAY {
        is_left = 1u;
        return 0u;
    }
    // geometries that the ray is inside of, a bit each
    var low = vec4<u32>(0u);
    var high = vec4<u32>(0u);
    var code = 0u;
    var next_run = first;
    for (var i = first; i < end; i++) {
        let event = events[i];
        let rank = (event >> 1u) & 0xffu;
        let counter = &counters[ray * params.n_ranks + rank];
        let was_inside = *counter != 0u;
        *counter = select((*counter + 1u) - 2u * (event & 1u), *counter ^ 1u, params.rule == 0u);
        if was_inside != (*counter != 0u) {
            let bit = vec4<u32>(1u << (rank % 32u));
            let word = vec4<u32>(rank / 32u);
            low ^= select(vec4<u32>(0u), bit, word == vec4<u32>(0u, 1u, 2u, 3u));
            high ^= select(vec4<u32>(0u), bit, word == vec4<u32>(4u, 5u, 6u, 7u));
        }
        // the crossings of a cell count together
        let cell = (event >> 9u) & 0x3ffffu;
        let is_last = i + 1u == end || cell != ((events[min(i + 1u, end - 1u)] >> 9u) & 0x3ffffu);
        let winner = winner_of(low, high);
        if is_last && winner != code {
            code = winner;
            if cell < params.depth {
                events[next_run] = (cell << 8u) | code;
                next_run += 1u;
            }
        }
    }
    if any((low | high) != vec4<u32>(0u)) {
        is_left = 1u;
    }
    return next_run - first;
}

// 1 + the highest bit of 256, or 0 if none is set.
fn winner_of(low: vec4<u32>, high: vec4<u32>) -> u32 {
    let below = vec4<u32>(1u, 33u, 65u, 97u);
    let of_low = select(firstLeadingBit(low) + below, vec4<u32>(0u), low == vec4<u32>(0u));
    let of_high = select(firstLeadingBit(high) + below + vec4<u32>(128u), vec4<u32>(0u), high == vec4<u32>(0u));
    let two = max(of_low, of_high);
    return max(max(two.x, two.y), max(two.z, two.w));
}
