// Up to eight crossings of a ray, sorted, and their sweep into runs, for any geometries and either rule. Without branches: drivers that
// run 8 threads in a vector pay for each variable that a branch changes. Twin: `crates/core/src/stages/map.rs`.

// Stands for no crossing, and for no run; sorts above all.
const NO_EVENT: u32 = 0xffffffffu;

// Crossings or runs of a ray, sorted; free places hold NO_EVENT.
struct List {
    low: vec4<u32>,
    high: vec4<u32>,
}

fn no_list() -> List {
    return List(vec4<u32>(NO_EVENT), vec4<u32>(NO_EVENT));
}

// A list with one more crossing, or none if it is NO_EVENT.
fn insert(list: List, event: u32, undecided: ptr<function, u32>) -> List {
    let v = vec4<u32>(event);
    *undecided |= u32(max(list.high.w, event) != NO_EVENT);
    return List(
        min(list.low, max(vec4<u32>(0u, list.low.xyz), v)),
        min(list.high, max(vec4<u32>(list.low.w, list.high.xyz), v)),
    );
}

// The crossings of a ray that are still needed once those before `until` are swept.
fn what_stays(s: Swept, list: List, until: u32, undecided: ptr<function, u32>) -> List {
    var due = List(later(list.low, until), later(list.high, until));
    var open = List(marks(s.open.low), marks(s.open.high));
    var all = no_list();
    for (var i = 0u; i < 4u; i++) {
        all = insert(insert(all, due.low.x, undecided), due.high.x, undecided);
        all = insert(insert(all, open.low.x, undecided), open.high.x, undecided);
        due = List(due.low.yzwx, due.high.yzwx);
        open = List(open.low.yzwx, open.high.yzwx);
    }
    return all;
}

fn later(events: vec4<u32>, until: u32) -> vec4<u32> {
    return select(events, vec4<u32>(NO_EVENT), (events >> vec4<u32>(9u)) < vec4<u32>(until));
}

fn marks(open: vec4<u32>) -> vec4<u32> {
    return select(open & vec4<u32>(0x1ffu), vec4<u32>(NO_EVENT), open == vec4<u32>(0u));
}

// What the sweep of a ray finds.
struct Swept {
    runs: List,
    n_runs: u32,
    last_is_run: u32,   // 0 if the last change lies past the end of the ray
    code: u32,          // of the geometry that wins now: rank + 1, or 0
    open: List,         // what the ray is inside of, the newest first: OPEN | rank << 1 | direction of the crossing, or 0
}

const OPEN: u32 = 0x200u;

// Whether there is one geometry, under the rule parity, which opens and closes by turns; a constant of the pipeline, as in map.wgsl.
override ALTERNATES: bool = false;

// Sweeps the sorted crossings of a ray in cells before `until`; those before `done` have begun their runs. Without branches: drivers
// that run 8 threads in a vector pay for each variable that a branch changes.
fn sweep(list: List, done: u32, until: u32) -> Swept {
    var s = Swept(no_list(), 0u, 0u, 0u, List());
    s = step(s, list.low.x, list.low.y, done, until);
    s = step(s, list.low.y, list.low.z, done, until);
    s = step(s, list.low.z, list.low.w, done, until);
    s = step(s, list.low.w, list.high.x, done, until);
    s = step(s, list.high.x, list.high.y, done, until);
    s = step(s, list.high.y, list.high.z, done, until);
    s = step(s, list.high.z, list.high.w, done, until);
    return step(s, list.high.w, NO_EVENT, done, until);
}

// The crossings of a cell count together: a run may begin when the next is in another cell.
fn step(before: Swept, event: u32, next: u32, done: u32, until: u32) -> Swept {
    var s = before;
    let cell = event >> 9u;
    let is_due = cell < until;
    let key = OPEN | (event & 0x1ffu) | (1u - params.rule);
    if ALTERNATES {
        s.open.low.x ^= select(0u, key, is_due);
    } else {
        s.open = next_open(s.open, key, is_due);
    }
    let two = max(s.open.low, s.open.high);
    let winner = max(max(two.x, two.y), max(two.z, two.w));
    let code = ((winner >> 1u) & 0xffu) + (winner >> 9u);
    let changes = is_due & (cell != next >> 9u) & (code != s.code);
    let is_run = changes & (cell < params.depth);
    s.code = select(s.code, code, changes);
    s.last_is_run = select(s.last_is_run, u32(is_run), changes);
    let writes = is_run & (cell >= done);
    let place = vec4<u32>(select(8u, s.n_runs, writes));
    let run = vec4<u32>((cell << 8u) | code);
    s.runs.low = select(s.runs.low, run, place == vec4<u32>(0u, 1u, 2u, 3u));
    s.runs.high = select(s.runs.high, run, place == vec4<u32>(4u, 5u, 6u, 7u));
    s.n_runs += u32(writes);
    return s;
}

// What is open behind a crossing: it closes what one of the same geometry opened, under the rule nonzero the newest of the other
// direction; else it opens.
fn next_open(before: List, key: u32, is_due: bool) -> List {
    var open = before;
    let low = open.low == vec4<u32>(key ^ params.rule);
    let high = open.high == vec4<u32>(key ^ params.rule);
    let low_xy = low.x | low.y;
    let in_low = low_xy | low.z | low.w;
    let high_xy = high.x | high.y;
    let newest_low = vec4<bool>(low.x, low.y & !low.x, low.z & !low_xy, low.w & !(low_xy | low.z));
    let newest_high = vec4<bool>(high.x, high.y & !high.x, high.z & !high_xy, high.w & !(high_xy | high.z))
        & vec4<bool>(!in_low);
    let closes = is_due & (in_low | high_xy | high.z | high.w);
    let opens = is_due & !closes;
    let shifted = List(vec4<u32>(key, open.low.xyz), vec4<u32>(open.low.w, open.high.xyz));
    open.low = select(open.low, vec4<u32>(0u), newest_low & vec4<bool>(closes));
    open.high = select(open.high, vec4<u32>(0u), newest_high & vec4<bool>(closes));
    open.low = select(open.low, shifted.low, vec4<bool>(opens));
    open.high = select(open.high, shifted.high, vec4<bool>(opens));
    return open;
}

fn without_runs_from(runs_of_ray: List, n: u32) -> List {
    let none = vec4<u32>(NO_EVENT);
    return List(
        select(none, runs_of_ray.low, vec4<u32>(0u, 1u, 2u, 3u) < vec4<u32>(n)),
        select(none, runs_of_ray.high, vec4<u32>(4u, 5u, 6u, 7u) < vec4<u32>(n)),
    );
}
