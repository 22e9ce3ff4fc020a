//! The CPU backend: the stages in order over strips of ray rows, on all cores.
//!
//! Frame, rays, a rule -> columns. This is the definition that the GPU kernels are held to, and the fallback wherever there
//! is no GPU. A strip is one bin row of a lattice whose bins are as wide as the domain; strips share nothing, so
//! any number of threads gives the same columns. Memory: the columns, the lattice, and one strip's crossings a thread.

use rayon::prelude::*;

use crate::columns::{Band, Columns};
use crate::control::Control;
use crate::crossings::crossings;
use crate::error::Result;
use crate::frame::Frame;
use crate::lattice::{Lattice, lattice};
use crate::map::{Mapping, Rule, map};
use crate::rays::Rays;

/// Rays of a strip, if the rows are not longer: small enough that its crossings stay in a core's cache.
const RAYS_PER_STRIP: u32 = 16_384;
/// Strips handed to the cores between two looks at progress and cancel.
const STRIPS_PER_ROUND: u32 = 64;

/// Meshes the box on the CPU.
///
/// # Errors
/// `cancelled` when the control says so.
pub fn columns(frame: &Frame, rays: &Rays, rule: Rule, control: &Control) -> Result<Columns> {
    let rows_per_strip = (RAYS_PER_STRIP / rays.counts[0]).clamp(1, rays.counts[1].div_ceil(16));
    columns_in_strips(frame, rays, rule, rows_per_strip, control)
}

/// Meshes the box on the CPU in strips of the given number of ray rows; the result does not depend on it.
///
/// # Errors
/// `cancelled` when the control says so.
pub fn columns_in_strips(frame: &Frame, rays: &Rays, rule: Rule, rows: u32, control: &Control) -> Result<Columns> {
    let bin = [rays.counts[0], rows.max(1)];
    let n_strips = Lattice::n_rows(rays, bin);
    let mapping = Mapping { rule, flag_of_rank: &frame.ranks.flag_of_rank, depth: rays.depth };
    control.check()?;
    let lattice = lattice(frame, rays, bin, 0..n_strips);
    let mut bands: Vec<Band> = Vec::with_capacity(n_strips as usize);
    for start in (0..n_strips).step_by(STRIPS_PER_ROUND as usize) {
        control.check()?;
        let end = (start + STRIPS_PER_ROUND).min(n_strips);
        let round = (start..end).into_par_iter().map(|strip| map(&crossings(frame, rays, &lattice, strip), &mapping));
        bands.par_extend(round);
        control.advance(u64::from(end) * rays.n_rays() / u64::from(n_strips), rays.n_rays());
    }
    Ok(Columns::new(*rays, bands))
}
