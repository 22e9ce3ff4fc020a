// Prepares each (facet, bin) pair: edge functions and plane at the bin's first ray. Twin: `src/facet.rs`.
// Reads: corners, bin_offsets (total in the last entry), pairs.
// Writes, in as few words as the loops over rays can do with, since loading them is what those spend their time on:
//         edges[2 p ..] = (q0 q1 q2 a0) (a1 b0 b1 -); the third edge's a and b are minus the sum of the others';
//         planes[3 p ..] = (Q0 Q1 Q2 base cell) (slope j, area) (rest, cells, tag), where
//         Q = floor((height - base cell) * area) in cells, 96 bits; tag = tie above << 9 | rank << 1 | exits;
//         slope i = cells * area + rest, the step of the height from ray to ray, with 0 <= rest < area.

@group(0) @binding(4) var<storage, read_write> edges: array<vec4<i32>>;
@group(0) @binding(5) var<storage, read_write> planes: array<vec4<u32>>;

@compute @workgroup_size(64)
fn intersect_setup(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let end = n_pairs();
    let n_threads = groups.x * groups.y * 64u;
    for (var pair = thread_index(group, groups, local); pair < end; pair += n_threads) {
        let f = load_facet(pairs[pair].x);
        let first = first_ray(pairs[pair].y);
        let e = facet_edges(f, first);
        edges[2u * pair] = vec4<i32>(e.q, e.a.x);
        edges[2u * pair + 1u] = vec4<i32>(e.a.y, e.b.xy, 0);
        write_plane(pair, f, facet_plane(f, first));
    }
}

// Where the quotient of the step passes 2^18 it may be off and the remainder out of range, though
// slope = cells * area + rest still holds: then no two neighbouring rays hit the facet, and nobody takes the step.
fn write_plane(pair: u32, f: Facet, plane: FacetPlane) {
    let step = floor_quotient(widen96(plane.slope_i), f.area);
    planes[3u * pair] = vec4<u32>(plane.height, bitcast<u32>(plane.base));
    planes[3u * pair + 1u] = vec4<u32>(plane.slope_j, f.area);
    planes[3u * pair + 2u] = vec4<u32>(step.rest, step.whole, tag_of(f, plane));
}
