// A facet as the rays see it. Twin: `crates/core/src/stages/facet.rs`. `docs/widths.md` says what proves the widths.
// Reads: corners[3 f + axis].xyz: the three corners, snapped, axes in the order (across, across, along);
//        corners[3 f].w: rank; corners[3 f + 1].w: layer of its lowest corner along the rays.
// Four words at a time: drivers that run 8 threads in a vector load thread by thread, and pay a load, not a word.

@group(0) @binding(1) var<storage, read> corners: array<vec4<i32>>;

struct Facet {
    x: vec3<i32>,       // of the three corners, ordered so that the area is positive
    y: vec3<i32>,
    z: vec3<i32>,
    area: vec2<u32>,    // twice the projected area; 0 if no ray can hit the facet
    exits: bool,        // rays leave the body here
    first: vec2<i32>,   // first and last ray of the box, inclusive, clipped to the band; at least one
    last: vec2<i32>,
    rank: u32,
    layer: u32,
}

fn load_facet(index: u32) -> Facet {
    let x = corners[3u * index];
    let y = corners[3u * index + 1u];
    var f: Facet;
    f.x = x.xyz;
    f.y = y.xyz;
    f.z = corners[3u * index + 2u].xyz;
    f.rank = bitcast<u32>(x.w);
    f.layer = bitcast<u32>(y.w);
    f.area = sub64(multiply_signed(f.x.y - f.x.x, f.y.z - f.y.x), multiply_signed(f.x.z - f.x.x, f.y.y - f.y.x));
    let flipped = is_negative(f.area);
    if flipped {
        f.area = negate64(f.area);
        f.x = f.x.xzy;
        f.y = f.y.xzy;
        f.z = f.z.xzy;
    }
    f.exits = flipped == (params.axis == 1u);
    let low = vec2<i32>(min(f.x.x, min(f.x.y, f.x.z)), min(f.y.x, min(f.y.y, f.y.z)));
    let high = vec2<i32>(max(f.x.x, max(f.x.y, f.x.z)), max(f.y.x, max(f.y.y, f.y.z)));
    let unit = vec2<i32>(1 << params.fraction_bits);
    f.first = max((low + unit - 1) >> vec2<u32>(params.fraction_bits), vec2<i32>(0, i32(params.first_row)));
    f.last = min(high >> vec2<u32>(params.fraction_bits), vec2<i32>(i32(params.n_i), i32(params.end_row)) - 1);
    return f;
}

// Steps of q of the three edges along the two axes across.
fn edge_a(f: Facet) -> vec3<i32> {
    return f.y - f.y.yzx;
}

fn edge_b(f: Facet) -> vec3<i32> {
    return f.x.yzx - f.x;
}

// q of an edge at ray (i, j): the test for a hit is q >= 0.
fn edge_q(a: i32, b: i32, x: i32, y: i32, ray: vec2<i32>) -> vec2<u32> {
    let tie_is_inside = a < 0 || (a == 0 && b < 0);
    let dx = (ray.x << params.fraction_bits) - x;
    let dy = (ray.y << params.fraction_bits) - y;
    let value = add64(multiply_signed(a, dx), multiply_signed(b, dy));
    return shift_right64(sub64(value, vec2<u32>(select(1u, 0u, tie_is_inside), 0u)), params.fraction_bits);
}
