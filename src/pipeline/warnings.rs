//! Warnings about a mesh: rays that found an open surface, and geometries without cells.

use super::prepare::Prepared;
use crate::frame::Frame;
use crate::geometry::Fill;

const AXES: [&str; 3] = ["x", "y", "z"];

/// A sentence about rays that do not leave every geometry they enter, if there are any.
pub(super) fn about_odd_rays(odd_rays: u64, n_rays: u64) -> Option<String> {
    (odd_rays > 0).then(|| {
        format!(
            "{odd_rays} of {n_rays} rays do not leave every geometry they enter: a surface is not closed there. Their cells \
             are flagged up to the last matched pair of crossings; `hexcast info` counts the open edges of a file"
        )
    })
}

/// A sentence for every geometry that is known to have no cell, with the cause; `cells` counts those of each flag.
///
/// A geometry whose box holds no centre of a cell has none. Where the box does hold one, only the cells of its flag tell, and
/// only if no other geometry has the same flag.
pub(super) fn about_geometries_without_cells(prepared: &Prepared, frame: &Frame, cells: &[u64; 256]) -> Vec<String> {
    let mut sentences = Vec::new();
    for (index, geometry) in prepared.geometries.iter().enumerate() {
        let Some([low, high]) = geometry.bounding_box() else { continue };
        let n_of_flag = prepared.geometries.iter().filter(|other| other.flag == geometry.flag).count();
        let has_cells = n_of_flag > 1 || cells[usize::from(geometry.flag)] > 0;
        let thin_axis = axis_without_centre(frame, index);
        if has_cells && (thin_axis.is_none() || geometry.fill != Fill::Centre) {
            continue;
        }
        let lines = &prepared.lines;
        let ends_of = |axis: usize| [lines.line(axis, 0), lines.line(axis, lines.dims[axis])];
        let is_outside = |axis: &usize| high[*axis] <= ends_of(*axis)[0] || low[*axis] >= ends_of(*axis)[1];
        let thickness = |axis: usize| (high[axis] - low[axis]) / lines.spacing[axis];
        let thinnest = (0..3).min_by(|&a, &b| thickness(a).total_cmp(&thickness(b))).unwrap_or(0);
        let cause = if let Some(axis) = (0..3).find(is_outside) {
            let ([start, end], name) = (ends_of(axis), AXES[axis]);
            let [from, to] = [low[axis], high[axis]];
            format!("it reaches from {from:?} to {to:?} along {name}, the domain from {start:?} to {end:?}")
        } else {
            let axis = thin_axis.unwrap_or(thinnest);
            let (thick, size, name) = (high[axis] - low[axis], lines.spacing[axis], AXES[axis]);
            let advice = if thin_axis.is_some() {
                "or keep it with fill = \"separating\" or \"conservative\""
            } else {
                "or check the priorities of the geometries that overlap it"
            };
            format!("it is {thick:?} thick along {name}, a cell is {size:?}; use smaller cells, {advice}")
        };
        sentences.push(format!("geometry \"{}\" (flag {}) got no cell: {cause}", geometry.name, geometry.flag));
    }
    sentences
}

/// The first axis along which the box of a geometry holds no centre of a cell.
fn axis_without_centre(frame: &Frame, geometry: usize) -> Option<usize> {
    let rank = frame.ranks.geometry_of_rank.iter().position(|&index| index == geometry)?;
    // facets are stored rank after rank
    let end_of = |n_ranks: usize| frame.rank_of_facet.partition_point(|&other| usize::from(other) < n_ranks);
    let corners = frame.facets[end_of(rank)..end_of(rank + 1)].as_flattened();
    // one that is not closed has been taken out of the frame
    if corners.is_empty() {
        return None;
    }
    (0..3).find(|&axis| {
        let low = corners.iter().map(|corner| corner[axis]).min().unwrap_or(0);
        let high = corners.iter().map(|corner| corner[axis]).max().unwrap_or(0);
        // cell i is inside only if low < i <= high in centres
        let (first, last) = ((low >> frame.fraction_bits) + 1, high >> frame.fraction_bits);
        first.max(0) > last.min(frame.dims[axis] as i32 - 1)
    })
}
