//! The CPU backend: the stages in order over strips of ray rows, on all cores.
//!
//! Frame, rays, a rule -> columns. This is the definition that the GPU kernels are held to, and the fallback wherever there
//! is no GPU. A strip is one bin row of a lattice whose bins are as wide as the domain; strips share nothing, so
//! any number of threads gives the same columns. Memory: the columns, the lattice, and one strip's crossings a thread.

use crate::columns::{Band, Columns};
use crate::control::Control;
use crate::crossings::crossings;
use crate::error::Result;
use crate::frame::Frame;
use crate::lattice::{Lattice, lattice};
use crate::map::{Mapping, Rule, map};
use crate::parallel::*;
use crate::rays::Rays;

/// Rays of a strip, if the rows are not longer: small enough that its crossings stay in a core's cache.
const RAYS_PER_STRIP: u32 = 16_384;
/// Strips handed to the cores between two looks at progress and cancel: enough to keep cores busy, and on the one core of
/// a browser's worker few enough to stop within a fraction of a second.
const STRIPS_PER_ROUND: u32 = if cfg!(target_arch = "wasm32") { 4 } else { 64 };

/// Meshes the box on the CPU.
///
/// # Errors
/// `cancelled` when the control says so.
pub fn columns(frame: &Frame, rays: &Rays, rule: Rule, control: &Control) -> Result<Columns> {
    Strips::new(frame, rays, rule, None).columns(control)
}

/// Meshes the box on the CPU in strips of the given number of ray rows; the result does not depend on it.
///
/// # Errors
/// `cancelled` when the control says so.
pub fn columns_in_strips(frame: &Frame, rays: &Rays, rule: Rule, rows: u32, control: &Control) -> Result<Columns> {
    Strips::new(frame, rays, rule, Some(rows)).columns(control)
}

/// A mesh on the CPU in rounds of strips, for callers that have other things to do between them.
pub struct Strips<'a> {
    frame: &'a Frame,
    rays: &'a Rays,
    rule: Rule,
    lattice: Lattice,
    next: u32,
    bands: Vec<Band>,
}

impl<'a> Strips<'a> {
    /// Builds the lattice of the box, in strips of `rows` ray rows or of a size that suits a core's cache.
    pub fn new(frame: &'a Frame, rays: &'a Rays, rule: Rule, rows: Option<u32>) -> Strips<'a> {
        let fitting = (RAYS_PER_STRIP / rays.counts[0]).clamp(1, rays.counts[1].div_ceil(16));
        let bin = [rays.counts[0], rows.unwrap_or(fitting).max(1)];
        let lattice = lattice(frame, rays, bin, 0..Lattice::n_rows(rays, bin));
        Strips { frame, rays, rule, lattice, next: 0, bands: Vec::new() }
    }

    /// Meshes the next strips on all cores; false once all are done.
    ///
    /// # Errors
    /// `cancelled` when the control says so.
    pub fn round(&mut self, control: &Control) -> Result<bool> {
        control.check()?;
        let n_strips = self.lattice.rows.end;
        let end = self.next.saturating_add(STRIPS_PER_ROUND).min(n_strips);
        let mapping = Mapping { rule: self.rule, flag_of_rank: &self.frame.ranks.flag_of_rank, depth: self.rays.depth };
        let strips = (self.next..end).into_par_iter();
        self.bands
            .par_extend(strips.map(|strip| map(&crossings(self.frame, self.rays, &self.lattice, strip), &mapping)));
        self.next = end;
        control.advance(u64::from(end) * self.rays.n_rays() / u64::from(n_strips), self.rays.n_rays());
        Ok(end < n_strips)
    }

    /// The columns of all strips.
    ///
    /// # Panics
    /// If a round is still to be done: a bug of the caller.
    pub fn finish(self) -> Columns {
        Columns::new(*self.rays, self.bands)
    }

    fn columns(mut self, control: &Control) -> Result<Columns> {
        while self.round(control)? {}
        Ok(self.finish())
    }
}
