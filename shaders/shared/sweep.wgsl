// The walk over the sorted crossings of a ray, which finds its runs. Twin: `src/map.rs`.
// Reads: flag_of_rank, four flags a word. The kernel says where a run goes: write_run(slot, run).

@group(0) @binding(8) var<uniform> flag_of_rank: array<vec4<u32>, 16>;

// Whether there is only one geometry. A constant of the pipeline: the long way is then not even compiled.
override ONE_RANK: bool = false;

// Stands for no crossing; sorts above all.
const NO_EVENT: u32 = 0xffffffffu;

struct Sweep {
    start: u32,                 // where its runs go
    runs: u32,                  // written so far
    inside: u32,                // the counter of the only geometry, or a bit for each
    flag: u32,                  // after the cells so far
    last_change_is_run: u32,    // 0 if the last change lies past the end of the ray
    only_flag: u32,
}

fn start_sweep(start: u32) -> Sweep {
    return Sweep(start, 0u, 0u, 0u, 0u, flag_of(0u));
}

fn flag_of(rank: u32) -> u32 {
    return (flag_of_rank[rank / 16u][(rank / 4u) % 4u] >> (8u * (rank % 4u))) & 0xffu;
}

// A counter after a crossing.
fn count(counter: u32, event: u32) -> u32 {
    if params.rule == 0u {
        return counter ^ 1u;
    }
    return counter + 1u - 2u * (event & 1u);
}

// Counts a crossing. The crossings of a cell count together: the flag may change when the next is in another cell, or none.
fn feed(sweep: ptr<function, Sweep>, event: u32, next: u32) {
    (*sweep).inside = select((*sweep).inside ^ (1u << ((event >> 1u) & 31u)), count((*sweep).inside, event), ONE_RANK);
    let cell = event >> 9u;
    if cell != next >> 9u {
        let flag = winner(*sweep);
        if flag != (*sweep).flag {
            let is_run = cell < params.depth;
            if is_run {
                write_run((*sweep).start + (*sweep).runs, (cell << 8u) | flag);
            }
            (*sweep).runs += u32(is_run);
            (*sweep).last_change_is_run = u32(is_run);
            (*sweep).flag = flag;
        }
    }
}

// Counts crossings; places after the last hold NO_EVENT, which changes nothing but the counter.
fn feed4(sweep: ptr<function, Sweep>, sorted: vec4<u32>, next: u32) {
    feed(sweep, sorted.x, sorted.y);
    feed(sweep, sorted.y, sorted.z);
    feed(sweep, sorted.z, sorted.w);
    feed(sweep, sorted.w, next);
}

// The flag of the geometry of highest rank that the counters are inside of.
fn winner(sweep: Sweep) -> u32 {
    if sweep.inside == 0u {
        return 0u;
    }
    if ONE_RANK {
        return sweep.only_flag;
    }
    return flag_of(firstLeadingBit(sweep.inside));
}
