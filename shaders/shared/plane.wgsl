// The plane of a facet over the rays of one bin (Eq. 17-19). Twin: `crates/core/src/stages/facet.rs`.

struct Plane {
    height: vec3<u32>,  // at the bin's first ray, over the base cell, times the area, rounded down to cells
    base: i32,          // cell
    slope_i: vec2<u32>, // steps of the height from ray to ray
    slope_j: vec2<u32>, // and from row to row
    tag: u32,           // tie above << 9 | rank << 1 | exits
}

// First ray of a bin of the band, in the domain.
fn first_ray(bin: u32) -> vec2<i32> {
    let column = i32(bin % params.n_across);
    let row = i32(bin / params.n_across);
    return vec2<i32>(column * i32(BIN), i32(params.first_row) + row * i32(BIN));
}

// The plane where rays are equally far from each other, at one of them.
fn plane_of(f: Facet, ray: vec2<i32>) -> Plane {
    let bits = vec2<u32>(params.fraction_bits);
    let base = min(f.z.x, min(f.z.y, f.z.z)) >> params.fraction_bits;
    var plane = plane_at(f, ray << bits, base << params.fraction_bits);
    let on_unit = (plane.height.x & ((1u << params.fraction_bits) - 1u)) == 0u;
    plane.height = shift_right96(plane.height, params.fraction_bits);
    plane.base = base;
    plane.tag &= select(0x1ffu, 0x3ffu, on_unit);
    return plane;
}

// The plane at a place in units, over a base in units: all that plane_of counts in cells is in units.
fn plane_at(f: Facet, place: vec2<i32>, base: i32) -> Plane {
    let dx = f.x - vec3<i32>(f.x.x);
    let dy = f.y - vec3<i32>(f.y.x);
    let dz = f.z - vec3<i32>(f.z.x);
    let slope_i = sub64(multiply_signed(dz.y, dy.z), multiply_signed(dz.z, dy.y));
    let slope_j = sub64(multiply_signed(dx.y, dz.z), multiply_signed(dx.z, dz.y));
    var height = multiply96(f.area, f.z.x - base);
    height = add96(height, multiply96(slope_i, place.x - f.x.x));
    height = add96(height, multiply96(slope_j, place.y - f.y.x));
    // a centre that the facet goes through lies above it if the largest shift that tilts does (see facet.rs)
    let i_is_level = (slope_i.x | slope_i.y) == 0u;
    let i_is_above = !is_negative(slope_i) && !i_is_level;
    let j_is_above = !is_negative(slope_j) && (slope_j.x | slope_j.y) != 0u;
    let tie_is_above = params.axis != 0u && (i_is_above || (params.axis == 2u && i_is_level && j_is_above));
    let tag = (u32(tie_is_above) << 9u) | (f.rank << 1u) | u32(f.exits);
    return Plane(height, base, slope_i, slope_j, tag);
}
