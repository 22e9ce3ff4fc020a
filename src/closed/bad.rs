//! Bad edges: how many a surface has that are not proper, and the worst places, with the facets as their file counts them.
//!
//! Snapped facets -> [`BadEdges`]. Bad edges of one kind that meet at corners are a group; the longest groups are listed.
//! Cost: O(n log n) for n facets, and nothing where all edges are proper.

use serde::{Deserialize, Serialize};

use super::Closed;
use crate::edges::{BadEdge, Groups, Use, Vertices, bad_edge, each};
use crate::frame::{Frame, SnappedFacet, world};
use crate::geometry::Geometry;
use crate::lines::Lines;
use crate::sort::{sort, sort_by_key};

/// Most groups of a kind that are listed.
const MAX_GROUPS: usize = 8;
/// Most facets of a group that are listed.
pub const MAX_FACETS: usize = 8;

/// The edges of a geometry that are not shared by two facets that agree, after the snap.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct BadEdges {
    /// Edges that one facet has.
    pub open: u64,
    /// Edges that two facets use in the same direction: one of the two is inside-out.
    pub flipped: u64,
    /// Edges that more than two facets have.
    pub nonmanifold: u64,
    /// At most 8 groups of each kind, open ones first, then flipped ones; of each kind the longest first.
    pub worst: Vec<EdgeGroup>,
}

/// Bad edges of one kind that meet at corners.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct EdgeGroup {
    /// What is not proper of them.
    pub kind: BadEdge,
    /// Number of edges.
    pub edges: u64,
    /// Their length together.
    pub length: f64,
    /// Corners of the box around them, in world coordinates.
    pub bounds: [[f64; 3]; 2],
    /// Facets that have them, counted from 0 in their file, ascending; at most 8.
    pub facets: Vec<u64>,
}

impl BadEdges {
    /// Finds those of the geometries of a frame, in the order of the job; `closed` is known of each position.
    pub fn of_geometries(frame: &Frame, closed: &[Closed], lines: &Lines, geometries: &[Geometry]) -> Vec<BadEdges> {
        let mut found = vec![BadEdges::default(); geometries.len()];
        for (position, &index) in frame.ranks.geometry_at.iter().enumerate() {
            if !closed[position].is_proper {
                let world = |corner: [i32; 3]| world(corner, frame.fraction_bits, lines);
                found[index] = BadEdges::new(frame.facets_at(position), world, &geometries[index]);
            }
        }
        found
    }

    fn new(facets: &[SnappedFacet], world: impl Fn([i32; 3]) -> [f64; 3], geometry: &Geometry) -> BadEdges {
        let vertices = Vertices::of(facets.len(), &|facet, corner| facets[facet][corner].map(i32::cast_unsigned));
        let snapped = |facet: usize, vertex: usize| facets[facet][vertices.corner(facet, vertex)];
        let mut of_kinds = [BadEdge::Open, BadEdge::Flipped, BadEdge::Nonmanifold].map(|kind| (kind, Vec::new()));
        for range in vertices.ranges() {
            for uses in each(&vertices.uses(range)) {
                if let Some(kind) = bad_edge(uses) {
                    of_kinds.iter_mut().filter(|of| of.0 == kind).for_each(|of| of.1.extend_from_slice(uses));
                }
            }
        }
        for (_, uses) in &mut of_kinds {
            // in the order of the corners, whatever that of the facets
            sort_by_key(uses, |entry: &Use| {
                let [one, other] = entry.pair().map(|vertex| snapped(entry.facet(), vertex));
                ([one.min(other), one.max(other)], *entry)
            });
        }
        let of_kinds = of_kinds.each_ref().map(|(kind, uses)| (*kind, each(uses).collect::<Vec<&[Use]>>()));
        let [open, flipped, nonmanifold] = of_kinds.each_ref().map(|of| of.1.len() as u64);
        let corner = |facet: usize, vertex: usize| world(snapped(facet, vertex));
        let mut worst = Vec::new();
        for (kind, of_kind) in of_kinds {
            let mut groups: Vec<EdgeGroup> = Vec::new();
            for edges in connected(&of_kind) {
                let group = EdgeGroup::new(kind, &edges, &corner, |facet| geometry.facet_in_file(facet));
                // of equal ones the first in the order of the corners stays first
                let place = groups.partition_point(|other| other.length >= group.length);
                if place < MAX_GROUPS {
                    groups.truncate(MAX_GROUPS - 1);
                    groups.insert(place, group);
                }
            }
            worst.extend(groups);
        }
        BadEdges { open, flipped, nonmanifold, worst }
    }
}

impl EdgeGroup {
    fn new(
        kind: BadEdge,
        edges: &[&[Use]],
        corner: &impl Fn(usize, usize) -> [f64; 3],
        in_file: impl Fn(usize) -> u64,
    ) -> EdgeGroup {
        let mut length = 0.0;
        let mut bounds = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
        let mut facets = Vec::new();
        for uses in edges {
            let ends = uses[0].pair().map(|vertex| corner(uses[0].facet(), vertex));
            length += (0..3).map(|axis| (ends[1][axis] - ends[0][axis]).powi(2)).sum::<f64>().sqrt();
            for end in ends {
                for axis in 0..3 {
                    bounds[0][axis] = bounds[0][axis].min(end[axis]);
                    bounds[1][axis] = bounds[1][axis].max(end[axis]);
                }
            }
            facets.extend(uses.iter().map(|entry| in_file(entry.facet())));
        }
        sort(&mut facets);
        facets.dedup();
        facets.truncate(MAX_FACETS);
        EdgeGroup { kind, edges: edges.len() as u64, length, bounds, facets }
    }
}

/// Edges, which come in the order of their corners, in groups that have corners in common; groups in the order of their first edges.
fn connected<'a>(edges: &[&'a [Use]]) -> Vec<Vec<&'a [Use]>> {
    let ends = |uses: &[Use]| uses[0].pair();
    let mut corners: Vec<usize> = edges.iter().flat_map(|uses| ends(uses)).collect();
    sort(&mut corners);
    corners.dedup();
    let place = |corner: usize| corners.partition_point(|other| *other < corner) as u32;
    let mut groups = Groups::new(corners.len());
    for uses in edges {
        let [low, high] = ends(uses).map(place);
        groups.join(low, high);
    }
    let mut index_of_root = vec![None; corners.len()];
    let mut found: Vec<Vec<&[Use]>> = Vec::new();
    for uses in edges {
        let root = groups.root(place(ends(uses)[0])) as usize;
        let index = *index_of_root[root].get_or_insert_with(|| {
            found.push(Vec::new());
            found.len() - 1
        });
        found[index].push(uses);
    }
    found
}
