//! The shapes of cells, measured as OpenFOAM's `checkMesh` does: which cells it would call wrong.
//!
//! [`Polyhedra`] -> cells. A face is wrong where the centre of one of its cells is on the wrong side of it, where the line between both centres hardly passes it, or passes it far from its
//! centre (skewness). Limits are a little stricter than those of `checkMesh`. Source: OpenFOAM 1912, `primitiveMeshCheck.C`, `primitiveMeshTools.C`.

use super::closed::{Behind, Polyhedra};
use super::planar::{Point, cross, dot, minus};

/// `checkMesh` allows 4.
const MOST_SKEW: f64 = 3.6;
/// Cosine of the angle between the line of centres and the normal; `checkMesh` allows 0.
const LEAST_COSINE: f64 = 0.05;
/// Of the cube of a cell's largest face's diameter: less is no volume.
const LEAST_VOLUME: f64 = 1e-6;

struct Measured {
    centre: Point,
    area: Point,
}

fn plus(a: Point, b: Point, times: f64) -> Point {
    [0, 1, 2].map(|axis| a[axis] + times * b[axis])
}

/// The centre and area of a face, by triangles around the mean of its corners.
fn face(corners: &[u32], points: &[Point]) -> Measured {
    let at = |index: usize| points[corners[index % corners.len()] as usize];
    let n = corners.len();
    let mean = (0..n).fold([0.0; 3], |sum, index| plus(sum, at(index), 1.0 / n as f64));
    let triangle = |index: usize| cross(minus(at(index + 1), at(index)), minus(mean, at(index)));
    let area = (0..n).fold([0.0; 3], |sum, index| plus(sum, triangle(index), 0.5));
    let length = dot(area, area).sqrt();
    let (mut centre, mut all) = ([0.0; 3], 0.0);
    for index in 0..n {
        let shown = dot(triangle(index), area) / length;
        let middle = plus(plus(at(index), at(index + 1), 1.0), mean, 1.0);
        (centre, all) = (plus(centre, middle, shown / 3.0), all + shown);
    }
    Measured { centre: if all > 0.0 { centre.map(|of| of / all) } else { mean }, area }
}

/// Cells that are wrong, in order.
pub(super) fn wrong(of: &Polyhedra) -> Vec<u32> {
    let n = of.n_cells as usize;
    let faces: Vec<Measured> = of.faces.iter().map(|one| face(of.corners(one), &of.points)).collect();
    let sides = |index: usize| {
        let one = &of.faces[index];
        let other = if let Behind::Cell(other) = one.behind { Some((other as usize, -1.0)) } else { None };
        [Some((one.owner as usize, 1.0)), other].into_iter().flatten()
    };
    let (mut means, mut counts) = (vec![[0.0; 3]; n], vec![0.0; n]);
    for (index, one) in faces.iter().enumerate() {
        for (cell, _) in sides(index) {
            (means[cell], counts[cell]) = (plus(means[cell], one.centre, 1.0), counts[cell] + 1.0);
        }
    }
    (0..n).for_each(|cell| means[cell] = means[cell].map(|of| of / counts[cell]));
    let (mut centres, mut volumes, mut largest) = (vec![[0.0; 3]; n], vec![0.0; n], vec![0.0f64; n]);
    for (index, one) in faces.iter().enumerate() {
        for (cell, sign) in sides(index) {
            let cone = sign * dot(one.area, minus(one.centre, means[cell]));
            let middle = plus(one.centre.map(|of| 0.75 * of), means[cell], 0.25);
            (centres[cell], volumes[cell]) = (plus(centres[cell], middle, cone), volumes[cell] + cone);
            largest[cell] = largest[cell].max(dot(one.area, one.area).sqrt());
        }
    }
    let mut wrong = Vec::new();
    for cell in 0..n {
        if volumes[cell] > 3.0 * LEAST_VOLUME * largest[cell].powf(1.5) {
            centres[cell] = centres[cell].map(|of| of / volumes[cell]);
        } else {
            (centres[cell], wrong) = (means[cell], [wrong, vec![cell as u32]].concat());
        }
    }
    for (index, one) in faces.iter().enumerate() {
        let mut both = sides(index);
        let (Some((owner, _)), other) = (both.next(), both.next()) else { continue };
        let to_face = minus(one.centre, centres[owner]);
        let length = dot(one.area, one.area).sqrt();
        let mut is_right = dot(one.area, to_face) > 0.0;
        let (across, least) = match other {
            Some((other, _)) => {
                let across = minus(centres[other], centres[owner]);
                is_right &= dot(one.area, minus(centres[other], one.centre)) > 0.0;
                is_right &= dot(one.area, across) > LEAST_COSINE * length * dot(across, across).sqrt();
                (across, 0.2)
            }
            None => (one.area.map(|of| of * dot(one.area, to_face) / (length * length)), 0.4),
        };
        let beside = plus(to_face, across, -dot(one.area, to_face) / dot(one.area, across));
        let off = dot(beside, beside).sqrt();
        let reach = of
            .corners(&of.faces[index])
            .iter()
            .map(|&at| dot(beside, minus(of.points[at as usize], one.centre)).abs() / off.max(f64::MIN_POSITIVE));
        let reach = reach.fold(least * dot(across, across).sqrt(), f64::max);
        is_right &= off <= MOST_SKEW * reach;
        if !is_right {
            wrong.extend(sides(index).map(|(cell, _)| cell as u32));
        }
    }
    wrong.sort_unstable();
    wrong.dedup();
    wrong
}
