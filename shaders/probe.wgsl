// Asks a device for what all kernels rely on; `crates/gpu/src/probe.rs` knows the answers. One workgroup.
// Writes: answers, and k to the first word of buffer_k: eight storage buffers in one stage.
// Bound: LOOPS + 32 loops an invocation.

struct Answers {
    sum: atomic<u32>,               // of 1 .. 64
    garbage: atomic<u32>,           // found in workgroup memory, which begins as zeros
    loops: array<u32, 64>,          // LOOPS steps of a generator that wraps around, from the thread's number
    shifts: array<vec4<u32>, 64>,   // left, right, right with the sign, bits counted
    quotients: array<u32, 64>,      // bits of f32
}

@group(0) @binding(0) var<storage, read_write> answers: Answers;
@group(0) @binding(1) var<storage, read_write> buffer_1: array<u32>;
@group(0) @binding(2) var<storage, read_write> buffer_2: array<u32>;
@group(0) @binding(3) var<storage, read_write> buffer_3: array<u32>;
@group(0) @binding(4) var<storage, read_write> buffer_4: array<u32>;
@group(0) @binding(5) var<storage, read_write> buffer_5: array<u32>;
@group(0) @binding(6) var<storage, read_write> buffer_6: array<u32>;
@group(0) @binding(7) var<storage, read_write> buffer_7: array<u32>;

// The bound on the loops of an invocation of any kernel.
const LOOPS: u32 = 16384u;

var<workgroup> zeros: array<u32, 2048>;

@compute @workgroup_size(64)
fn probe(@builtin(local_invocation_index) local: u32) {
    atomicAdd(&answers.sum, local + 1u);
    var garbage = 0u;
    for (var i = local; i < 2048u; i += 64u) {
        garbage |= zeros[i];
    }
    atomicOr(&answers.garbage, garbage);
    var state = local;
    for (var i = 0u; i < LOOPS; i++) {
        state = state * 1664525u + 1013904223u;
    }
    answers.loops[local] = state;
    let bits = 0x80f00001u ^ (local * 0x9e3779b9u);
    let by = local % 32u;
    answers.shifts[local] = vec4<u32>(bits << by, bits >> by, bitcast<u32>(bitcast<i32>(bits) >> by), countOneBits(bits));
    answers.quotients[local] = bitcast<u32>(f32(16777213u - 7919u * local) / f32(2u * local + 3u));
    if local == 0u {
        buffer_1[0] = 1u;
        buffer_2[0] = 2u;
        buffer_3[0] = 3u;
        buffer_4[0] = 4u;
        buffer_5[0] = 5u;
        buffer_6[0] = 6u;
        buffer_7[0] = 7u;
    }
}
