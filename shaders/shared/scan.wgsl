// Sums that saturate instead of wrapping: a total of 2^32 - 1 means "too many", whatever the order of the additions.

// Elements of a workgroup of 256 threads.
const BLOCK: u32 = 4096u;
const PER_THREAD: u32 = 16u;

fn add_saturating(a: u32, b: u32) -> u32 {
    return a + min(b, 0xffffffffu - a);
}
