//! Cells of one flag cut at its surface: which flag that is, and the outline of its cells.
//!
//! The job, [`Uncut`] -> [`Outline`].

use std::collections::BTreeSet;

use super::prepare::Task;
use super::surfaces::Uncut;
use hexcast_core::base::error::{Error, Result};
use hexcast_core::grid::frame::Frame;
use hexcast_core::input::geometry::Geometry;
use hexcast_derived::cut_cells::{CutBy, outline, parts};
use hexcast_derived::mesh::outline::Outline;
use hexcast_derived::walls;

impl Uncut {
    /// The outline of the fluid that a job asks for, of at most so many bytes.
    ///
    /// # Errors
    /// `job-conflict` where no geometry has the flag, or it is not given and geometries have several; those of [`outline`].
    pub(super) async fn outline(&self, task: &Task<'_>, max_bytes: u64) -> Result<Option<Outline>> {
        let &Task { job, prepared, control, .. } = task;
        let Some(asked) = job.cut_cells else { return Ok(None) };
        let fluid = flag_of(asked.fluid, &prepared.geometries)?;
        // this frame, and the facets by planes
        let n_frames = 2 + u64::from(asked.boundary);
        let max_bytes = max_bytes.saturating_sub(n_frames * 38 * self.frame.facets.len() as u64);
        let (frame, is_oriented) = (&self.frame, self.are_oriented());
        let moved = asked.boundary.then(|| within_sides(frame)).flatten();
        let by = CutBy { frame: moved.as_ref().unwrap_or(frame), ..self.cut_by(job, prepared, &is_oriented) };
        let (names, first_of) = walls::names(&prepared.geometries);
        let wall_of = |facet: u32| {
            let position = usize::from(frame.position_of_facet[facet as usize]);
            let index = frame.ranks.geometry_at[position];
            let in_geometry = (facet as usize - frame.range_at(position).start) as u64;
            first_of[index] + prepared.geometries[index].solid_of(in_geometry) as u32
        };
        let mut found = outline(by, (fluid, names), &wall_of, max_bytes, control).await?;
        if asked.boundary {
            let max_bytes = max_bytes.saturating_sub(size_of_val(&found.cells[..]) as u64);
            found.parts = parts(by, &found, max_bytes, control).await?;
        }
        Ok(Some(found))
    }
}

/// The flag that is cut.
///
/// # Errors
/// `job-conflict` where no geometry has it, or it is not given and geometries have several.
fn flag_of(fluid: Option<u8>, geometries: &[Geometry]) -> Result<u8> {
    let flags: BTreeSet<u8> = geometries.iter().map(|geometry| geometry.flag).collect();
    let said = flags.iter().map(u8::to_string).collect::<Vec<_>>().join(", ");
    let message = match (fluid, flags.first()) {
        (Some(flag), _) if flag == 0 || flags.contains(&flag) => return Ok(flag),
        (None, Some(&flag)) if flags.len() == 1 => return Ok(flag),
        (Some(flag), _) => format!("the fluid of cut cells has flag {flag}, and no geometry has it: flags are {said}"),
        _ => format!("cut cells are those of one fluid, and geometries have the flags {said}"),
    };
    let hint = "name one with cut_cells.fluid (--export-flags): 0 is what is around all geometries";
    Err(Error::new("job-conflict", message, hint))
}

/// The frame with all corners that lie in the low sides of the box a unit further out, where there are any: so what ends there reaches through the side, as at the high sides, where
/// a line stands for what is below it. A unit is a part of 2^F of a cell.
fn within_sides(frame: &Frame) -> Option<Frame> {
    let sides = [0, 1, 2].map(|axis| frame.face(axis, 0));
    let is_at = |corner: &[i32; 3]| (0..3).any(|axis| corner[axis] == sides[axis]);
    if !frame.facets.as_flattened().iter().any(is_at) {
        return None;
    }
    let mut moved = frame.clone();
    for corner in moved.facets.as_flattened_mut() {
        corner.iter_mut().zip(sides).for_each(|(place, side)| *place -= i32::from(*place == side));
    }
    Some(moved)
}
