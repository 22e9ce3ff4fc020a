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
pub const STRIPS_PER_ROUND: u32 = if cfg!(target_arch = "wasm32") { 4 } else { 64 };

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
    /// Rays of the next strip that are there already.
    skipped: usize,
    /// Strips of a round.
    per_round: u32,
}

impl<'a> Strips<'a> {
    /// Builds the lattice of the box, in strips of `rows` ray rows or of a size that suits a core's cache.
    pub fn new(frame: &'a Frame, rays: &'a Rays, rule: Rule, rows: Option<u32>) -> Strips<'a> {
        let bin = [rays.counts[0], rows.unwrap_or(rows_of_strip(rays)).max(1)];
        let lattice = lattice(frame, rays, bin, 0..Lattice::n_rows(rays, bin));
        Strips { frame, rays, rule, lattice, next: 0, skipped: 0, per_round: STRIPS_PER_ROUND }
    }

    /// Makes at most so many strips, at least one, in a round instead of [`STRIPS_PER_ROUND`].
    pub fn in_rounds_of(self, strips: u32) -> Strips<'a> {
        Strips { per_round: strips.clamp(1, STRIPS_PER_ROUND), ..self }
    }

    /// Begins with the ray of this index instead of the first.
    pub fn from_ray(self, ray: u64) -> Strips<'a> {
        if ray >= self.rays.n_rays() {
            return Strips { next: self.lattice.rows.end, ..self };
        }
        let rays_of_strip = u64::from(self.rays.counts[0]) * u64::from(self.lattice.bin[1]);
        Strips { next: (ray / rays_of_strip) as u32, skipped: (ray % rays_of_strip) as usize, ..self }
    }

    /// Bytes of the lattice.
    pub fn n_bytes(&self) -> u64 {
        4 * (self.lattice.offsets.capacity() + self.lattice.facets.capacity()) as u64
    }

    /// Meshes the next strips on all cores; none once all are done.
    ///
    /// # Errors
    /// `cancelled` when the control says so.
    pub fn round(&mut self, control: &Control) -> Result<Option<Vec<Band>>> {
        control.check()?;
        let n_strips = self.lattice.rows.end;
        if self.next >= n_strips {
            return Ok(None);
        }
        let end = self.next.saturating_add(self.per_round).min(n_strips);
        let mapping = Mapping { rule: self.rule, flag_of_rank: &self.frame.ranks.flag_of_rank, depth: self.rays.depth };
        let first = self.next;
        let band_of = |strip| {
            let skipped = if strip == first { self.skipped } else { 0 };
            map(&crossings(self.frame, self.rays, &self.lattice, strip).without_first(skipped), &mapping)
        };
        let bands = (first..end).into_par_iter().map(band_of).collect();
        (self.next, self.skipped) = (end, 0);
        control.advance(u64::from(end) * self.rays.n_rays() / u64::from(n_strips), self.rays.n_rays());
        Ok(Some(bands))
    }

    fn columns(mut self, control: &Control) -> Result<Columns> {
        let mut bands = Vec::new();
        while let Some(mut more) = self.round(control)? {
            bands.append(&mut more);
        }
        Ok(Columns::new(*self.rays, bands))
    }
}

/// Ray rows of a strip where the caller has no opinion.
pub fn rows_of_strip(rays: &Rays) -> u32 {
    (RAYS_PER_STRIP / rays.counts[0]).clamp(1, rays.counts[1].div_ceil(16))
}
