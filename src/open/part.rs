//! Open parts: the geometries of a frame that are not closed, taken out of it and made whole.
//!
//! Frame -> the frame of the closed geometries, and an [`OpenPart`] for each other.

use super::caps::caps;
use super::closed::is_closed;
use super::orient::orient;
use crate::error::{Error, Result};
use crate::frame::{Frame, Ranks, SnappedFacet};
use crate::geometry::Open;
use crate::job::Rule;
use crate::lines::Lines;
use crate::rays::Rays;

/// What the surface of an open geometry lacks.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Surface {
    /// Edges that facets use an odd number of times, or for `nonzero` more often one way than the other.
    pub open_edges: u64,
    /// Facets that were turned to agree with their neighbours.
    pub turned: u64,
    /// Caps that close its holes: loops of open edges.
    pub holes: u64,
    /// Middle of the longest open edge, in world coordinates.
    pub longest_at: [f64; 3],
}

/// An open geometry, taken out of a frame.
pub struct OpenPart {
    pub(super) rank: u8,
    pub(super) policy: Open,
    /// Its facets, turned to agree with each other.
    pub(super) facets: Vec<SnappedFacet>,
    /// Triangles that close its holes.
    pub(super) caps: Vec<SnappedFacet>,
    pub(super) surface: Surface,
}

impl OpenPart {
    fn new(rank: u8, policy: Open, facets: &[SnappedFacet], fraction_bits: u32, lines: &Lines) -> OpenPart {
        let oriented = orient(facets);
        let caps = caps(&oriented.loops);
        let place = |corner: [i32; 3]| {
            [0, 1, 2].map(|axis| {
                let cells = f64::from(corner[axis]) / f64::from(1u32 << fraction_bits) + 0.5;
                lines.origin[axis] + cells * lines.spacing[axis]
            })
        };
        let edges = oriented.loops.iter().flat_map(|corners| corners.iter().zip(corners.iter().cycle().skip(1)));
        let ends = edges.map(|(from, to)| [place(*from), place(*to)]);
        let length = |[from, to]: &[[f64; 3]; 2]| (0..3).map(|axis| (to[axis] - from[axis]).powi(2)).sum::<f64>();
        let longest = ends.max_by(|one, other| length(one).total_cmp(&length(other))).unwrap_or_default();
        let surface = Surface {
            open_edges: oriented.n_open_edges,
            turned: oriented.n_turned,
            holes: oriented.loops.len() as u64,
            longest_at: [0, 1, 2].map(|axis| 0.5 * (longest[0][axis] + longest[1][axis])),
        };
        OpenPart { rank, policy, facets: oriented.facets, caps, surface }
    }

    /// Bytes that deciding it takes, about: a word a crossing of each axis, along the rays once more with the caps, and as much again
    /// while crossings are grouped.
    pub fn n_bytes(&self, rays: &Rays, fraction_bits: u32) -> u64 {
        let cell = f64::from(1u32 << fraction_bits);
        let crossings = |facets: &[SnappedFacet], axis: usize| -> f64 {
            let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
            let area = |[a, b, c]: &SnappedFacet| {
                let side = |to: &[i32; 3], axis: usize| (f64::from(to[axis]) - f64::from(a[axis])) / cell;
                0.5 * (side(b, i) * side(c, j) - side(c, i) * side(b, j)).abs()
            };
            facets.iter().map(area).sum()
        };
        let again = crossings(&self.facets, rays.axis) + crossings(&self.caps, rays.axis);
        16 * ((0..3).map(|axis| crossings(&self.facets, axis)).sum::<f64>() + again) as u64
    }
}

/// Takes the geometries that are not closed out of a frame, unless their rays shall decide as they are ([`Open::Parity`]);
/// `policies` has an entry for each geometry of the job, and `names` its name.
///
/// # Errors
/// `surface-open` where a geometry is open that must not be ([`Open::Error`]).
pub fn split(frame: Frame, rule: Rule, lines: &Lines, policies: &[(Open, &str)]) -> Result<(Frame, Vec<OpenPart>)> {
    let mut open = Vec::new();
    for (rank, &geometry) in frame.ranks.geometry_of_rank.iter().enumerate() {
        let (policy, name) = policies[geometry];
        // facets are stored rank after rank
        let [start, end] =
            [rank, rank + 1].map(|rank| frame.rank_of_facet.partition_point(|&of| usize::from(of) < rank));
        let facets = &frame.facets[start..end];
        if policy == Open::Parity || is_closed(facets, rule) {
            continue;
        }
        let part = OpenPart::new(rank as u8, policy, facets, frame.fraction_bits, lines);
        if policy == Open::Error {
            return Err(refused(name, &part.surface));
        }
        open.push((start..end, part));
    }
    if open.is_empty() {
        return Ok((frame, Vec::new()));
    }
    let is_left = |facet: usize| !open.iter().any(|(range, _)| range.contains(&facet));
    let left: Vec<usize> = (0..frame.facets.len()).filter(|&facet| is_left(facet)).collect();
    let closed = Frame {
        facets: left.iter().map(|&facet| frame.facets[facet]).collect(),
        rank_of_facet: left.iter().map(|&facet| frame.rank_of_facet[facet]).collect(),
        ranks: Ranks { flag_of_rank: (1..=frame.ranks.flag_of_rank.len() as u8).collect(), ..frame.ranks },
        ..frame
    };
    Ok((closed, open.into_iter().map(|(_, part)| part).collect()))
}

fn refused(name: &str, surface: &Surface) -> Error {
    let [x, y, z] = surface.longest_at;
    let message = format!(
        "geometry \"{name}\" is not closed: open edges {}, in {} loops, the longest edge at ({x}, {y}, {z})",
        surface.open_edges, surface.holes
    );
    Error::new(
        "surface-open",
        message,
        "close it, or mesh it with open = \"winding\", which decides its cells by the winding number",
    )
}
