//! Bad edges: how many a surface has that are not proper, and the worst places, with the facets as their file counts them.
//!
//! Snapped facets -> [`BadEdges`]. Bad edges of one kind that meet at corners are a group; the longest groups are listed.
//! Cost: O(n log n) for n facets, and nothing where all edges are proper.

use serde::{Deserialize, Serialize};

use super::Closed;
use crate::base::control::Control;
use crate::base::error::Result;
use crate::base::memory::{Held, List, Memory};
use crate::base::sort::{par_sort, sort};
use crate::grid::frame::{Frame, SnappedFacet, world};
use crate::grid::lines::Lines;
use crate::input::edges::{BadEdge, EDGES, Groups, Use, Vertices, bad_edge, directions, each};
use crate::input::geometry::Geometry;

/// Bytes of a use while edges are grouped, at most: its edge, its corners, their groups, and its facet; while uses are sorted it is 40.
const GROUPED_BYTES: u64 = 96;
/// Most groups of a kind that are listed.
const MAX_GROUPS: usize = 8;
/// Most facets of a group that are listed.
pub const MAX_FACETS: usize = 8;

/// The edges of a geometry that are not shared by two facets that agree, after the snap.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(any(test, feature = "testing"), derive(schemars::JsonSchema))]
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
#[cfg_attr(any(test, feature = "testing"), derive(schemars::JsonSchema))]
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
    ///
    /// # Errors
    /// `memory` where what is held meanwhile does not fit; `cancelled`.
    pub fn of_geometries(
        frame: &Frame,
        closed: &[Closed],
        lines: &Lines,
        geometries: &[Geometry],
        with: (&Memory, &Control),
    ) -> Result<Vec<BadEdges>> {
        let mut found = vec![BadEdges::default(); geometries.len()];
        for (position, &index) in frame.ranks.geometry_at.iter().enumerate() {
            if !closed[position].is_proper {
                let world = |corner: [i32; 3]| world(corner, frame.fraction_bits, lines);
                let geometry = &geometries[index];
                let made = BadEdges::new(frame.facets_at(position), world, geometry, with);
                found[index] = made.map_err(|error| error.at(format!("geometry \"{}\"", geometry.name)))?;
            }
        }
        Ok(found)
    }

    fn new(
        facets: &[SnappedFacet],
        world: impl Fn([i32; 3]) -> [f64; 3],
        geometry: &Geometry,
        (memory, control): (&Memory, &Control),
    ) -> Result<BadEdges> {
        let mut room = Held::of(memory);
        let key = |facet: usize, corner: usize| facets[facet][corner].map(i32::cast_unsigned);
        let vertices = Vertices::within(facets.len(), &key, &mut room)?;
        let room_of_uses = memory.take(vertices.bytes_of_uses(), EDGES)?;
        let snapped = |facet: usize, vertex: usize| facets[facet][vertices.corner(facet, vertex)];
        let mut of_kinds =
            [BadEdge::Open, BadEdge::Flipped, BadEdge::Nonmanifold].map(|kind| (kind, List::new(memory, EDGES)));
        for range in vertices.ranges() {
            control.check()?;
            for uses in each(&vertices.uses(range)) {
                if let Some(kind) = bad_edge(directions(uses)) {
                    of_kinds.iter_mut().filter(|of| of.0 == kind).try_for_each(|of| of.1.extend(uses))?;
                }
            }
        }
        drop(room_of_uses);
        let n_uses: usize = of_kinds.iter().map(|(_, uses)| uses.len()).sum();
        let _room_of_groups = memory.take(GROUPED_BYTES * n_uses as u64, EDGES)?;
        for (_, uses) in &mut of_kinds {
            control.check()?;
            // in the order of the corners, whatever that of the facets; these lie far from each other, so that each is looked up once
            let keyed = uses.iter().map(|&entry| {
                let [one, other] = entry.pair().map(|vertex| snapped(entry.facet(), vertex));
                ([one.min(other), one.max(other)], entry)
            });
            let mut keyed: Vec<([[i32; 3]; 2], Use)> = keyed.collect();
            par_sort(&mut keyed);
            uses.iter_mut().zip(keyed).for_each(|(place, (_, entry))| *place = entry);
        }
        let of_kinds = of_kinds.each_ref().map(|(kind, uses)| (*kind, each(uses).collect::<Vec<&[Use]>>()));
        let [open, flipped, nonmanifold] = of_kinds.each_ref().map(|of| of.1.len() as u64);
        let corner = |facet: usize, vertex: usize| world(snapped(facet, vertex));
        let mut worst = Vec::new();
        for (kind, of_kind) in of_kinds {
            control.check()?;
            let mut groups: Vec<EdgeGroup> = Vec::new();
            let (order, ends) = connected(&of_kind);
            let starts = [0].into_iter().chain(ends.iter().copied());
            for (start, &end) in starts.zip(&ends) {
                let edges = &order[start as usize..end as usize];
                let group = EdgeGroup::new(kind, (edges, &of_kind), &corner, |facet| geometry.facet_in_file(facet));
                // of equal ones the first in the order of the corners stays first
                let place = groups.partition_point(|other| other.length >= group.length);
                if place < MAX_GROUPS {
                    groups.truncate(MAX_GROUPS - 1);
                    groups.insert(place, group);
                }
            }
            worst.extend(groups);
        }
        Ok(BadEdges { open, flipped, nonmanifold, worst })
    }
}

impl EdgeGroup {
    fn new(
        kind: BadEdge,
        (order, all): (&[u32], &[&[Use]]),
        corner: &impl Fn(usize, usize) -> [f64; 3],
        in_file: impl Fn(usize) -> u64,
    ) -> EdgeGroup {
        let mut length = 0.0;
        let mut bounds = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
        let mut facets = Vec::new();
        for &edge in order {
            let uses = all[edge as usize];
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
        EdgeGroup { kind, edges: order.len() as u64, length, bounds, facets }
    }
}

/// Edges, which come in the order of their corners, in groups that have corners in common: the indices of all edges, group by group in the
/// order of their first edges, and the end of each group.
fn connected(edges: &[&[Use]]) -> (Vec<u32>, Vec<u32>) {
    let ends = |uses: &[Use]| uses[0].pair();
    let mut corners: Vec<usize> = Vec::with_capacity(2 * edges.len());
    corners.extend(edges.iter().flat_map(|uses| ends(uses)));
    sort(&mut corners);
    corners.dedup();
    let place = |corner: usize| corners.partition_point(|other| *other < corner) as u32;
    let mut groups = Groups::new(corners.len());
    for uses in edges {
        let [low, high] = ends(uses).map(place);
        groups.join(low, high);
    }
    // by the group of an edge, then a place of the order
    const NONE: u32 = u32::MAX;
    let (mut number_of_root, mut group_ends) = (vec![NONE; corners.len()], Vec::new());
    let mut group_of = Vec::with_capacity(edges.len());
    for uses in edges {
        let number = &mut number_of_root[groups.root(place(ends(uses)[0])) as usize];
        if *number == NONE {
            *number = group_ends.len() as u32;
            group_ends.push(0);
        }
        group_ends[*number as usize] += 1;
        group_of.push(*number);
    }
    let mut next = Vec::with_capacity(group_ends.len());
    let mut end = 0;
    for of_group in &mut group_ends {
        next.push(end);
        end += *of_group;
        *of_group = end;
    }
    let mut order = vec![0; edges.len()];
    for (edge, &group) in group_of.iter().enumerate() {
        let at = &mut next[group as usize];
        order[*at as usize] = edge as u32;
        *at += 1;
    }
    (order, group_ends)
}
