//! Which geometries got no cell: thinner than the cells, outside the domain, or covered by others.

use super::task::Prepared;
use crate::cast::Cast;
use crate::control::Control;
use crate::cpu;
use crate::domain::{BoundingBox, Domain};
use crate::frame::Frame;
use crate::job::Rule;

/// A sentence for every geometry that got no cell, with its thickness and the cell size; `cells` counts those of each flag.
pub(super) fn geometries_without_cells(
    prepared: &Prepared,
    frame: &Frame,
    cells: &[u64; 256],
    rule: Rule,
) -> Vec<String> {
    let mut sentences = Vec::new();
    for (index, geometry) in prepared.geometries.iter().enumerate() {
        let Some([low, high]) = geometry.bounding_box() else { continue };
        let shares_flag = prepared.geometries.iter().filter(|other| other.flag == geometry.flag).count() > 1;
        let thickness = |axis: usize| (high[axis] - low[axis]) / prepared.lines.spacing[axis];
        let axis = (0..3).min_by(|&a, &b| thickness(a).total_cmp(&thickness(b))).unwrap_or(0);
        // a shared flag tells nothing of one geometry; only a thin or far one can have missed all centres by itself
        let is_lost = if !shares_flag {
            cells[usize::from(geometry.flag)] == 0
        } else {
            (thickness(axis) < 2.0 || is_outside(&prepared.domain, [low, high]))
                && is_alone_without_cells(prepared, frame, index, rule)
        };
        if is_lost {
            let name = ["x", "y", "z"][axis];
            sentences.push(format!(
                "geometry \"{}\" (flag {}) got no cell: it is {:?} thick along {name}, a cell is {:?}; use smaller cells, or \
                 look at its place in the domain and at the priorities",
                geometry.name,
                geometry.flag,
                high[axis] - low[axis],
                prepared.lines.spacing[axis],
            ));
        }
    }
    sentences
}

fn is_outside(domain: &Domain, [low, high]: BoundingBox) -> bool {
    (0..3).any(|axis| high[axis] <= domain.low[axis] || low[axis] >= domain.high[axis])
}

/// Meshes one geometry by itself to see whether it has any cell.
fn is_alone_without_cells(prepared: &Prepared, frame: &Frame, geometry: usize, rule: Rule) -> bool {
    let Some(rank) = frame.ranks.geometry_of_rank.iter().position(|&index| index == geometry) else { return false };
    // facets are stored rank after rank
    let start = frame.rank_of_facet.partition_point(|&other| usize::from(other) < rank);
    let end = frame.rank_of_facet.partition_point(|&other| usize::from(other) <= rank);
    let alone = Frame {
        facets: frame.facets[start..end].to_vec(),
        rank_of_facet: frame.rank_of_facet[start..end].to_vec(),
        ranks: frame.ranks.clone(),
        ..*frame
    };
    let cast = Cast { frame: &alone, rays: &prepared.rays, rule };
    cpu::columns(&cast, &Control::default()).is_ok_and(|columns| columns.n_runs() == 0)
}
