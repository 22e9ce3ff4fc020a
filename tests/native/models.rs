//! Generators of surfaces, in code, so that every machine makes the same facets: integers, f32 and `libm`, no files.
//!
//! All are closed and have outward normals (right-hand rule) unless their comment says otherwise. `Facets` are f32 corners
//! as a file would hold them.

use hexcast::geometry::Facet;

/// A surface.
pub(crate) type Facets = Vec<Facet>;
/// A corner.
pub(crate) type Point = [f32; 3];

/// Cuts the quad a, b, c, d (counter-clockwise from outside) along a-c.
fn quad([a, b, c, d]: [Point; 4]) -> [Facet; 2] {
    [[a, b, c], [a, c, d]]
}

/// Makes an upright box of 12 facets: the body whose cells anybody can count.
pub(crate) fn cuboid(low: Point, high: Point) -> Facets {
    let corner = |bits: usize| std::array::from_fn(|axis| if bits >> axis & 1 == 1 { high[axis] } else { low[axis] });
    let sides = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    sides.iter().flat_map(|side| quad(side.map(corner))).collect()
}

/// Makes a cube from `low` to `low + size`.
pub(crate) fn cube(low: Point, size: f32) -> Facets {
    cuboid(low, low.map(|x| x + size))
}

/// Makes a tetrahedron, turned outwards: the smallest closed surface, with every slope that integers can have.
pub(crate) fn tetrahedron([a, b, c, d]: [Point; 4]) -> Facets {
    outwards(vec![[a, c, b], [a, b, d], [b, c, d], [c, a, d]])
}

/// Makes an octahedron in a box: six apexes, each shared by four facets, and edges that run straight under the apexes.
pub(crate) fn octahedron(low: Point, high: Point) -> Facets {
    let middle: Point = std::array::from_fn(|axis| (low[axis] + high[axis]) * 0.5);
    let apex = |axis: usize, up: bool| {
        let mut point = middle;
        point[axis] = if up { high[axis] } else { low[axis] };
        point
    };
    let mut facets = Vec::new();
    for octant in 0..8usize {
        let [x, y, z] = [0, 1, 2].map(|axis| apex(axis, octant >> axis & 1 == 1));
        // an odd number of mirrored axes turns the facet round
        facets.push(if octant.count_ones() % 2 == 1 { [x, y, z] } else { [x, z, y] });
    }
    facets
}

/// Makes an upright prism over a polygon, counter-clockwise seen from +z. Caps are fans from the first corner, which on
/// a concave polygon overlap with opposite orientation: every ray still counts right, which is why this is here.
pub(crate) fn prism(polygon: &[[f32; 2]], low: f32, high: f32) -> Facets {
    let at = |index: usize, z: f32| [polygon[index % polygon.len()][0], polygon[index % polygon.len()][1], z];
    let mut facets = Vec::new();
    for i in 0..polygon.len() {
        facets.extend(quad([at(i, low), at(i + 1, low), at(i + 1, high), at(i, high)]));
    }
    for i in 1..polygon.len() - 1 {
        facets.push([at(0, high), at(i, high), at(i + 1, high)]);
        facets.push([at(0, low), at(i + 1, low), at(i, low)]);
    }
    facets
}

/// Makes the prism of a triangle pushed along a vector, turned outwards: slanted sides, parallel edges.
pub(crate) fn wedge([a, b, c]: [Point; 3], push: Point) -> Facets {
    let [p, q, r] = [a, b, c].map(|corner| std::array::from_fn(|axis| corner[axis] + push[axis]));
    let mut facets = vec![[a, c, b], [p, q, r]];
    for [from, to, to_pushed, from_pushed] in [[a, b, q, p], [b, c, r, q], [c, a, p, r]] {
        facets.extend(quad([from, to, to_pushed, from_pushed]));
    }
    outwards(facets)
}

/// Sine and cosine of a fraction of a turn.
fn turn(part: usize, of: usize) -> (f64, f64) {
    libm::sincos(2.0 * std::f64::consts::PI * part as f64 / of as f64)
}

/// Makes a sphere of `n` meridians and `n / 2` parallels: slivers at the poles, every slope between, silhouette vertices.
pub(crate) fn sphere(centre: Point, radius: f32, n: usize) -> Facets {
    let rows = n / 2;
    let at = |i: usize, j: usize| -> Point {
        if j == 0 || j == rows {
            let z = if j == 0 { -radius } else { radius };
            return [centre[0], centre[1], centre[2] + z];
        }
        let ((sin_u, cos_u), (sin_v, cos_v)) = (turn(i % n, n), turn(j, 2 * rows));
        let unit = [sin_v * cos_u, sin_v * sin_u, -cos_v];
        std::array::from_fn(|axis| centre[axis] + radius * unit[axis] as f32)
    };
    let mut facets = Vec::new();
    for i in 0..n {
        for j in 0..rows {
            let [first, second] = quad([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
            if j > 0 {
                facets.push(first);
            }
            if j + 1 < rows {
                facets.push(second);
            }
        }
    }
    // at the first parallel the quad's first half is the degenerate one, at the last its second
    facets
}

/// Makes a torus about z: up to four crossings a ray and a hole.
pub(crate) fn torus(centre: Point, [ring, tube]: [f32; 2], n: usize) -> Facets {
    let at = |i: usize, j: usize| -> Point {
        let ((sin_u, cos_u), (sin_v, cos_v)) = (turn(i % n, n), turn(j % n, n));
        let away = f64::from(ring) + f64::from(tube) * cos_v;
        let offset = [away * cos_u, away * sin_u, f64::from(tube) * sin_v];
        std::array::from_fn(|axis| centre[axis] + offset[axis] as f32)
    };
    let mut facets = Vec::new();
    for i in 0..n {
        for j in 0..n {
            facets.extend(quad([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]));
        }
    }
    facets
}

/// Makes a block of `n` by `m` squares of the given size whose top has the given heights and whose floor is at z = `floor`:
/// a terrain, with a vertex in every place where a scan puts one.
pub(crate) fn terrain([n, m]: [usize; 2], size: f32, floor: f32, height: impl Fn(usize, usize) -> f32) -> Facets {
    let top = |i: usize, j: usize| [i as f32 * size, j as f32 * size, height(i, j)];
    let low = |i: usize, j: usize| [i as f32 * size, j as f32 * size, floor];
    let mut facets = Vec::new();
    for i in 0..n {
        for j in 0..m {
            facets.extend(quad([top(i, j), top(i + 1, j), top(i + 1, j + 1), top(i, j + 1)]));
            facets.extend(quad([low(i, j), low(i, j + 1), low(i + 1, j + 1), low(i + 1, j)]));
        }
        facets.extend(quad([low(i, 0), low(i + 1, 0), top(i + 1, 0), top(i, 0)]));
        facets.extend(quad([low(i + 1, m), low(i, m), top(i, m), top(i + 1, m)]));
    }
    for j in 0..m {
        facets.extend(quad([low(0, j + 1), low(0, j), top(0, j), top(0, j + 1)]));
        facets.extend(quad([low(n, j), low(n, j + 1), top(n, j + 1), top(n, j)]));
    }
    facets
}

/// Makes a cone of `n` sides: all sides share one apex, so a ray through it meets `n` facets at one point.
pub(crate) fn cone(centre: Point, radius: f32, apex: Point, n: usize) -> Facets {
    let at = |i: usize| -> Point {
        let (sin, cos) = turn(i % n, n);
        [centre[0] + radius * cos as f32, centre[1] + radius * sin as f32, centre[2]]
    };
    (0..n).flat_map(|i| [[at(i), at(i + 1), apex], [at(i + 1), at(i), centre]]).collect()
}

/// Turns every facet round, so that normals point inwards.
pub(crate) fn flipped(facets: Facets) -> Facets {
    facets.into_iter().map(|[a, b, c]| [a, c, b]).collect()
}

/// Flips a surface whose signed volume is negative. For few facets with moderate coordinates: the sum is in f64.
pub(crate) fn outwards(facets: Facets) -> Facets {
    if signed_volume(&facets) < 0.0 { flipped(facets) } else { facets }
}

/// Signed volume relative to the first corner.
pub(crate) fn signed_volume(facets: &[Facet]) -> f64 {
    let Some([origin, ..]) = facets.first() else { return 0.0 };
    let from_origin =
        |corner: Point| -> [f64; 3] { std::array::from_fn(|axis| f64::from(corner[axis]) - f64::from(origin[axis])) };
    let triple = |facet: &Facet| {
        let [a, b, c] = facet.map(from_origin);
        a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])
    };
    facets.iter().map(triple).sum::<f64>() / 6.0
}

/// Applies a function to every corner.
pub(crate) fn mapped(facets: &[Facet], place: impl Fn(Point) -> Point) -> Facets {
    facets.iter().map(|facet| facet.map(&place)).collect()
}

/// Moves a surface.
pub(crate) fn moved(facets: &[Facet], by: Point) -> Facets {
    mapped(facets, |corner| std::array::from_fn(|axis| corner[axis] + by[axis]))
}

/// Scales a surface about the origin.
pub(crate) fn scaled(facets: &[Facet], factor: f32) -> Facets {
    mapped(facets, |corner| corner.map(|x| x * factor))
}

/// Joins surfaces in one, as several solids of one file.
pub(crate) fn joined<const N: usize>(parts: [Facets; N]) -> Facets {
    parts.concat()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashMap;

    /// Number of directed edges whose opposite is missing: 0 for a closed, consistently turned surface.
    fn open_edges(facets: &[Facet]) -> usize {
        let mut count: HashMap<[[u32; 3]; 2], i32> = HashMap::new();
        let bits = |corner: Point| corner.map(|x| (x + 0.0).to_bits());
        for facet in facets {
            for edge in 0..3 {
                let [from, to] = [bits(facet[edge]), bits(facet[(edge + 1) % 3])];
                *count.entry([from.min(to), from.max(to)]).or_default() += if from < to { 1 } else { -1 };
            }
        }
        count.values().filter(|&&sum| sum != 0).count()
    }

    #[test]
    fn generators_make_closed_surfaces_with_outward_normals_and_the_right_volume() {
        let l_shape = [[0.0, 0.0], [4.0, 0.0], [4.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]];
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.0]];
        let wave = |i: usize, j: usize| 2.0 + ((i + j) % 2) as f32;
        let table: [(&str, Facets, f64, f64); 10] = [
            ("cuboid", cuboid([1.0, 2.0, 3.0], [3.0, 5.0, 7.0]), 24.0, 0.0),
            ("tetrahedron", tetrahedron(corners), 1.0, 0.0),
            ("mirrored tetrahedron", tetrahedron([corners[1], corners[0], corners[2], corners[3]]), 1.0, 0.0),
            ("octahedron", octahedron([-1.0; 3], [1.0; 3]), 4.0 / 3.0, 1e-12),
            ("concave prism", prism(&l_shape, 0.0, 2.0), 12.0, 0.0),
            ("wedge", wedge([corners[0], corners[1], corners[2]], [0.5, 0.25, -2.0]), 2.0, 0.0),
            ("sphere", sphere([1.0; 3], 2.0, 96), 33.51, 0.2),
            ("torus", torus([0.0; 3], [3.0, 1.0], 96), 59.218, 0.4),
            ("terrain", terrain([4, 4], 1.0, 0.0, wave), 40.0, 3.0),
            ("cone", cone([0.0; 3], 1.0, [0.0, 0.0, 3.0], 128), std::f64::consts::PI, 0.01),
        ];
        for (name, facets, volume, tolerance) in table {
            assert_eq!(open_edges(&facets), 0, "{name}: open edges");
            assert!((signed_volume(&facets) - volume).abs() <= tolerance, "{name}: {}", signed_volume(&facets));
        }
        assert_eq!(open_edges(&cuboid([0.0; 3], [1.0; 3])[1..]), 3, "a missing facet opens three edges");
    }
}
