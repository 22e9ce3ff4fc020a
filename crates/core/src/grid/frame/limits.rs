//! What a frame can hold: refusals of more, and the fraction bits that fit.

use super::centres::Scale;
use super::ranks::MAX_RANKS;
use crate::base::error::{Error, Result};
use crate::grid::lines::{AXES, Lines};
use crate::input::geometry::Geometry;
use crate::input::job::short_number;
use hexcast_job::input::choices::check_n_geometries;

/// Bits that span all snapped coordinates of an axis. 26 keeps the kernels' inner loop in one 32-bit word.
pub const SPAN_BITS: u32 = 26;
/// Fewer fraction bits than this would snap visibly: an error.
pub const MIN_FRACTION_BITS: u32 = 8;
/// Most cells along an axis: 2^([`SPAN_BITS`] - [`MIN_FRACTION_BITS`]), less the room for half a cell at both ends.
pub const MAX_CELLS_PER_AXIS: u32 = (1 << (SPAN_BITS - MIN_FRACTION_BITS)) - 2;

/// Refuses what the exact arithmetic cannot index.
///
/// # Errors
/// `too-many-geometries`, `too-many-facets`, `too-many-cells`, as for [`super::Frame::new`].
pub fn check_limits(geometries: &[Geometry], lines: &Lines) -> Result<()> {
    check_n_geometries(geometries.len(), "there are")?;
    let n_facets: usize = geometries.iter().map(|geometry| geometry.facets.len()).sum();
    if n_facets > 1 << 31 {
        return Err(Error::new("too-many-facets", format!("{n_facets} facets: at most 2^31 fit"), "split the job"));
    }
    for axis in 0..3 {
        if lines.dims()[axis] > MAX_CELLS_PER_AXIS {
            let name = AXES[axis];
            let message = format!("{} cells along {name}: at most {MAX_CELLS_PER_AXIS} fit", lines.dims()[axis]);
            return Err(Error::new("too-many-cells", message, "use larger cells or split the domain"));
        }
    }
    Ok(())
}

pub fn too_many_ranks(n_geometries: usize) -> Error {
    let message = format!(
        "{n_geometries} geometries overlap so that a ray would have to tell more than {MAX_RANKS} apart. \
         Closed geometries of one flag whose boxes lie apart count as one"
    );
    let hint = "give geometries of the same substance the same flag, one after the other, and join in one file those that overlap";
    Error::new("too-many-geometries", message, hint)
}

/// The largest F for which corners and centres of every axis span at most 2^SPAN_BITS units.
pub(super) fn fraction_bits(geometries: &[Geometry], lines: &Lines, scale: &Scale) -> Result<u32> {
    let mut widest = 0.0f64;
    let mut widest_name = "";
    let mut low = [-1.0f64; 3];
    // one cell beyond the last centre
    let last_centre = |axis: usize| {
        let n = lines.dims()[axis];
        if lines.is_graded() { scale.units_from_world(axis, lines.centre(axis, n - 1)) } else { f64::from(n - 1) }
    };
    let mut high = [0, 1, 2].map(|axis| last_centre(axis) + 1.0);
    let domain_span = high.into_iter().fold(0.0, f64::max) + 1.0;
    if lines.is_graded() {
        check_smallest(lines, high)?;
    }
    for geometry in geometries {
        let Some(bounding_box) = geometry.bounding_box() else { continue };
        for axis in 0..3 {
            let ends = bounding_box.map(|corner| scale.units_from_world(axis, corner[axis]));
            low[axis] = low[axis].min(ends[0] - 1.0);
            high[axis] = high[axis].max(ends[1] + 1.0);
            if high[axis] - low[axis] > widest {
                widest = high[axis] - low[axis];
                widest_name = &geometry.name;
            }
        }
    }
    let span = widest.max(domain_span);
    let bits = (0..=SPAN_BITS).rev().find(|&bits| span * f64::from(1u32 << bits) <= f64::from(1u32 << SPAN_BITS));
    match bits {
        Some(bits) if bits >= MIN_FRACTION_BITS => Ok(bits),
        _ => {
            let limit = 1u32 << (SPAN_BITS - MIN_FRACTION_BITS);
            let message = format!(
                "geometry \"{widest_name}\" and the domain together span {} cells along an axis: \
                 the exact arithmetic holds {limit}",
                short_number(widest.round()),
            );
            Err(Error::new("geometry-too-far", message, "remove the far facets, enlarge the cells or move the domain"))
        }
    }
}

/// Refuses listed lines of which the whole axis is too long for its smallest cell; `ends` are in units of that.
fn check_smallest(lines: &Lines, ends: [f64; 3]) -> Result<()> {
    let limit = f64::from(1u32 << (SPAN_BITS - MIN_FRACTION_BITS)) - 1.0;
    let Some(axis) = (0..3).find(|&axis| ends[axis] > limit) else { return Ok(()) };
    let message = format!(
        "the smallest cell along {} is {:?}, and the lines span {} times that: the exact arithmetic holds {limit}",
        AXES[axis],
        lines.smallest()[axis],
        ends[axis].round(),
    );
    Err(Error::new("lines-too-fine", message, "make the smallest cells larger (min_size), or the domain smaller"))
}
