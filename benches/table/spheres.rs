//! Model 4 of the paper: 64 spheres, made here so that the bench needs no file.
//!
//! 4 x 4 x 4 spheres of radius 0.45 at unit distance, each of 53 slices and 15 stacks: 1,484 facets, 94,976 in all.

use std::f64::consts::PI;
use std::io::{self, Write};

use hexcast::geometry::Facet;

const PER_AXIS: u32 = 4;
const RADIUS: f64 = 0.45;
const SLICES: u32 = 53;
const STACKS: u32 = 15;

/// Makes the facets, corners counter-clockwise seen from outside.
pub(crate) fn spheres() -> Vec<Facet> {
    let centre = |place: u32| [place % PER_AXIS, place / PER_AXIS % PER_AXIS, place / PER_AXIS.pow(2)].map(f64::from);
    (0..PER_AXIS.pow(3)).flat_map(|place| sphere(centre(place), [SLICES, STACKS])).collect()
}

/// One of them, of so many slices and stacks: `2 slices (stacks - 1)` facets.
pub(crate) fn sphere(centre: [f64; 3], [slices, stacks]: [u32; 2]) -> Vec<Facet> {
    // all corners of a pole are the same point
    let corner = |stack: u32, slice: u32| -> [f32; 3] {
        let polar = PI * f64::from(stack) / f64::from(stacks);
        let turn = 2.0 * PI * f64::from(slice % slices) / f64::from(slices);
        let across = if stack.is_multiple_of(stacks) { 0.0 } else { RADIUS * polar.sin() };
        let offset = [across * turn.cos(), across * turn.sin(), RADIUS * polar.cos()];
        std::array::from_fn(|axis| (centre[axis] + offset[axis]) as f32)
    };
    let mut facets = Vec::new();
    for stack in 0..stacks {
        for slice in 0..slices {
            let [a, b] = [stack, stack + 1].map(|stack| corner(stack, slice));
            let [c, d] = [stack, stack + 1].map(|stack| corner(stack, slice + 1));
            // at the poles one of the two would have no area
            if stack + 1 < stacks {
                facets.push([a, b, d]);
            }
            if stack > 0 {
                facets.push([a, d, c]);
            }
        }
    }
    facets
}

/// Writes facets as binary STL, normals zero.
pub(crate) fn write_stl(facets: &[Facet], out: &mut impl Write) -> io::Result<()> {
    out.write_all(&[0; 80])?;
    out.write_all(&(facets.len() as u32).to_le_bytes())?;
    for facet in facets {
        out.write_all(&[0; 12])?;
        for number in facet.as_flattened() {
            out.write_all(&number.to_le_bytes())?;
        }
        out.write_all(&[0; 2])?;
    }
    out.flush()
}
