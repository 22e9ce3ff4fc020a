// The heights at which the rays of a row cross a facet (Eq. 17-19).
// The rays of a row that a facet hits are neighbours. At the first the quotient height / area is guessed in f32 (relative
// error under 2^-21, so less than one cell in 2^18) and mended by one exact step; to the next, quotient and remainder take
// the facet's constant step.
// Reads: planes, 3 vec4 a pair, see intersect_setup.

@group(0) @binding(4) var<storage, read> planes: array<vec4<u32>>;

struct Plane {
    height: vec3<u32>,      // at the bin's first ray, over the base cell, times the area, rounded down to cells
    base: i32,              // cell
    slope_j: vec2<u32>,     // step of the height from row to row
    area: vec2<u32>,
    step_rest: vec2<u32>,   // step from ray to ray: step_cells * area + step_rest
    step_cells: i32,
    tag: u32,               // tie above << 9 | rank << 1 | exits
}

// Quotient and remainder of a ray's height by the area.
struct Height {
    cells: i32,
    rest: vec2<u32>,
}

fn load_plane(pair: u32) -> Plane {
    let p0 = planes[3u * pair];
    let p1 = planes[3u * pair + 1u];
    let p2 = planes[3u * pair + 2u];
    return Plane(p0.xyz, bitcast<i32>(p0.w), p1.xy, p1.zw, p2.xy, bitcast<i32>(p2.z), p2.w);
}

// The height at the first ray of the row that hits; at least one does.
fn first_height(plane: Plane, row: u32, hits: Hits) -> Height {
    let bits = hits.low.x | (hits.low.y << 1u) | (hits.low.z << 2u) | (hits.low.w << 3u)
        | (hits.high.x << 4u) | (hits.high.y << 5u) | (hits.high.z << 6u) | (hits.high.w << 7u);
    let first = i32(firstTrailingBit(bits));
    let at_row = add96(plane.height, multiply96(plane.slope_j, i32(row)));
    let at_first = add96(at_row, multiply96(slope_i(plane), first));
    var height = divide(at_first, plane.area);
    height.cells += plane.base;
    return height;
}

// The step of the height from ray to ray; its cells are signed.
fn slope_i(plane: Plane) -> vec2<u32> {
    let cells = bitcast<u32>(plane.step_cells);
    let product = multiply_unsigned(cells, plane.area.x);
    let high = cells * plane.area.y - select(0u, plane.area.x, plane.step_cells < 0);
    return add64(vec2<u32>(product.x, product.y + high), plane.step_rest);
}

// Divides a height of at most 2^18 cells, not negative, by the area.
fn divide(height: vec3<u32>, area: vec2<u32>) -> Height {
    let guess = u32(float96(height) / float96(vec3<u32>(area, 0u)));
    let mended = mend_quotient(height.xy, guess, area);
    return Height(i32(mended.whole), mended.rest);
}

// The crossing of a ray at a height: cell << 9 | rank << 1 | direction.
fn event_at(height: Height, plane: Plane) -> u32 {
    let centre_is_above = (height.rest.x | height.rest.y) == 0u && (plane.tag >> 9u) == 1u;
    let first_above = height.cells + select(1, 0, centre_is_above);
    return (u32(clamp(first_above, 0, i32(params.depth))) << 9u) | (plane.tag & 0x1ffu);
}

// The height at the next ray.
fn next_height(height: Height, plane: Plane) -> Height {
    let next = add64(height.rest, plane.step_rest);
    let wraps = at_least64(next, plane.area);
    let rest = select(next, sub64(next, plane.area), vec2<bool>(wraps));
    return Height(height.cells + plane.step_cells + i32(wraps), rest);
}
