// Sums that saturate instead of wrapping: a total of 2^32 - 1 means "too many", whatever the order of the additions.

// Elements of a workgroup of 256 threads.
const BLOCK: u32 = 4096u;
const PER_THREAD: u32 = 16u;

fn add_saturating(a: u32, b: u32) -> u32 {
    return a + min(b, 0xffffffffu - a);
}

@group(0) @binding(0) var<storage, read_write> numbers: array<u32>;

// A sum of each thread of the workgroup.
var<workgroup> partial: array<u32, 256>;

// The numbers of a thread of a block: first and end.
fn own_numbers(block: u32, local: u32) -> vec2<u32> {
    let start = block * BLOCK + local * PER_THREAD;
    return vec2<u32>(start, min(start + PER_THREAD, arrayLength(&numbers)));
}

fn sum_of(own: vec2<u32>) -> u32 {
    var sum = 0u;
    for (var i = own.x; i < own.y; i++) {
        sum = add_saturating(sum, numbers[i]);
    }
    return sum;
}
