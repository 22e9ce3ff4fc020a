// Sums blocks of 4,096 numbers: the first half of reduce-then-scan, which needs no forward progress between workgroups.
// Reads: numbers[n]. Writes: sums[ceil(n / 4096)].

@group(0) @binding(1) var<storage, read_write> sums: array<u32>;

@compute @workgroup_size(256)
fn scan_reduce(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let block = group.y * groups.x + group.x;
    let own = own_numbers(block, local);
    partial[local] = sum_of(own);
    for (var half = 128u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if local < half {
            partial[local] = add_saturating(partial[local], partial[local + half]);
        }
    }
    if local == 0u && block < arrayLength(&sums) {
        sums[block] = partial[0];
    }
}
