//! Rays through a plane of cells, and the facets that they cross: in exact integers, with the tie rule of the definition.
//!
//! A centre P stands for P - (e1, e2, e3) with e1 >> e2 >> e3 > 0 along x, y, z. A linear function that is 0 at P has there the sign
//! of the first component of its gradient that is not 0, turned round. All coordinates are below 2^26: a 2 x 2 determinant
//! fits 64 bits, a 3 x 3 determinant 128.

/// Corners in units of the snap.
pub(super) type Facet = [[i32; 3]; 3];

/// Rays along one axis through a plane of cells.
#[derive(Clone, Copy)]
pub(super) struct Rays<'a> {
    /// The axis that numbers the rays, the axis across the plane, and the axis of the rays.
    pub(super) axes: [usize; 3],
    /// Where the rays and the planes are, and the places along the rays between which crossings lie: all ascending.
    pub(super) places: [&'a [i32]; 3],
}

impl Rays<'_> {
    /// Calls `found` for every ray of plane number `index` that crosses a facet, with the number of the ray, the first place
    /// above the crossing (0 to the number of places), and 1 where the ray enters or -1 where it leaves.
    pub(super) fn cross(&self, facet: &Facet, index: u32, mut found: impl FnMut(u32, u32, i32)) {
        let ([over, across, along], [rays, planes, places]) = (self.axes, self.places);
        let [p, q, r] = facet.map(|corner| corner.map(i64::from));
        let normal = normal(&[p, q, r]);
        let turn = normal[along].signum();
        if turn == 0 {
            return;
        }
        // whether the axes, in their order, are turned like x, y, z
        let handed = if (over + 1) % 3 == across { turn } else { -turn };
        let height = i64::from(planes[index as usize]);
        let (mut first, mut end) = (0, rays.len());
        for (from, to) in [(p, q), (q, r), (r, p)] {
            let (du, dv) = (handed * (to[over] - from[over]), handed * (to[across] - from[across]));
            let mut gradient = [0; 3];
            (gradient[over], gradient[across]) = (-dv, du);
            // inside of the edge: at a ray the value is start - dv times its place
            let start = du * (height - from[across]) + dv * from[over];
            let least = i64::from(!is_positive_at_zero(gradient));
            match dv {
                ..0 => first = first.max(n_below(rays, -(start - least).div_euclid(-dv))),
                0 if start < least => return,
                0 => {}
                _ => end = end.min(n_below(rays, (start - least).div_euclid(dv) + 1)),
            }
        }
        let facing = normal.map(|component| turn * component);
        let least = i128::from(!is_positive_at_zero(facing));
        let [n_over, n_across, n_along] = [over, across, along].map(|axis| i128::from(facing[axis]));
        let rest = n_across * i128::from(height - p[across]) - n_along * i128::from(p[along]);
        for ray in first..end {
            let start = rest + n_over * i128::from(i64::from(rays[ray]) - p[over]);
            let above = -(start - least).div_euclid(n_along);
            found(ray as u32, n_below(places, above.clamp(-1 << 40, 1 << 40) as i64) as u32, -turn as i32);
        }
    }

    /// Planes that may have rays within a facet.
    pub(super) fn reach(&self, facet: &Facet) -> std::ops::Range<u32> {
        let [p, q, r] = facet.map(|corner| i64::from(corner[self.axes[1]]));
        let [start, end] = [p.min(q).min(r), p.max(q).max(r) + 1].map(|place| n_below(self.places[1], place) as u32);
        start..end
    }
}

/// How many of ascending places lie below one.
pub(super) fn n_below(places: &[i32], place: i64) -> usize {
    places.partition_point(|&at| i64::from(at) < place)
}

/// Whether a function that is 0 at a centre counts as positive there.
fn is_positive_at_zero(gradient: [i64; 3]) -> bool {
    gradient.into_iter().find(|&component| component != 0).is_some_and(|component| component < 0)
}

pub(super) fn normal([p, q, r]: &[[i64; 3]; 3]) -> [i64; 3] {
    let [u, v] = [q, r].map(|end| [0, 1, 2].map(|axis| end[axis] - p[axis]));
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}
