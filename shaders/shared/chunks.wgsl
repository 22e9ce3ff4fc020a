// What map tells of the rows of rays, and the deep kernels and the host read: a chunk is one row of rays of one bin.

// Marks a chunk that map leaves to the deep kernels: no eight counts of at most 8 look like this.
const DEEP: u32 = 0xffffffffu;

// Two words a chunk. Of a deep one: its index among the deep rows, DEEP. Of any other: where its last segment of runs is, and how
// many runs each ray has in it, 4 bits each; see map.wgsl.
@group(0) @binding(6) var<storage, read_write> chunks: array<vec2<u32>>;
