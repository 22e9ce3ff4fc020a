// Replaces numbers by the sum of all before them: the second half of reduce-then-scan.
// Reads: bases[block], the scanned sums of the blocks (zeros for a single block). Reads and writes: numbers[n].

@group(0) @binding(1) var<storage, read_write> bases: array<u32>;

@compute @workgroup_size(256)
fn scan_apply(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let block = group.y * groups.x + group.x;
    let own = own_numbers(block, local);
    partial[local] = sum_of(own);
    for (var reach = 1u; reach < 256u; reach *= 2u) {
        workgroupBarrier();
        var left = 0u;
        if local >= reach {
            left = partial[local - reach];
        }
        workgroupBarrier();
        partial[local] = add_saturating(partial[local], left);
    }
    workgroupBarrier();
    var before = 0u;
    if block < arrayLength(&bases) {
        before = bases[block];
    }
    if local > 0u {
        before = add_saturating(before, partial[local - 1u]);
    }
    for (var i = own.x; i < own.y; i++) {
        let number = numbers[i];
        numbers[i] = before;
        before = add_saturating(before, number);
    }
}
