//! The CPU backend: the stages in order over strips of ray rows, on all cores.
//!
//! [`Cast`] -> columns. This is the definition that the GPU kernels are held to, and the fallback wherever there
//! is no GPU. A strip is one bin row of a lattice whose bins are as wide as the domain; strips share nothing, so
//! any number of threads gives the same columns. Memory: the columns, the lattice, and one strip's crossings a thread.

use std::ops::Range;

use crate::base::control::Control;
use crate::base::error::Result;
use crate::base::parallel::*;
use crate::cells::columns::{Band, Columns};
use crate::grid::frame::SnappedFacet;
use crate::grid::rays::Rays;
use crate::stages::cast::Cast;
use crate::stages::crossings::{Crossings, crossings, crossings_of_window};
use crate::stages::facet::rays_under;
use crate::stages::lattice::{Lattice, lattice};
use crate::stages::map::{Mapping, map};
use crate::stages::slots;

/// Rays of a strip, if the rows are not longer: small enough that its crossings stay in a core's cache. Of many rays a strip has more, so that
/// facets are in fewer strips.
const RAYS_PER_STRIP: [u64; 2] = [16_384, 65_536];
/// Strips that there are before each has more rays.
const STRIPS: u64 = 256;
/// Strips of a round, after which progress is reported and cancel is checked: enough to keep all cores busy, and on the one
/// core of a browser's worker few enough to stop within a fraction of a second.
pub const STRIPS_PER_ROUND: u32 = if HAS_THREADS { 64 } else { 4 };

/// Meshes the box on the CPU.
///
/// # Errors
/// `cancelled` when the control says so.
pub fn columns(cast: &Cast, control: &Control) -> Result<Columns> {
    Strips::new(cast, None).columns(control)
}

/// Meshes the box on the CPU in strips of the given number of ray rows; the result does not depend on it.
///
/// # Errors
/// `cancelled` when the control says so.
pub fn columns_in_strips(cast: &Cast, rows: u32, control: &Control) -> Result<Columns> {
    Strips::new(cast, Some(rows)).columns(control)
}

/// Some rays: ranges along both axes across, one row or less, or whole rows.
pub type Window = [Range<u32>; 2];

/// The window of some whole rows of rays.
pub fn window_of_rows(rays: &Rays, rows: Range<u32>) -> Window {
    [0..rays.counts[0], rows]
}

/// The window of the rays through some cells: the first, and the end, exclusive.
pub fn rays_through(rays: &Rays, [first, end]: [[u32; 3]; 2]) -> Window {
    rays.across.map(|axis| first[axis]..end[axis])
}

/// Least number of windows whose facets are searched together.
const WINDOWS_OF_GROUP: usize = 1024;
/// Facets that one task searches.
const CHUNK: usize = 8192;

/// Casts and maps the rays of some windows, in the order of their first rows, on all cores: a band each.
///
/// Cost: a pass over the boxes of all facets for every 1024 windows, or at most eight passes, and the casting of the rays.
pub fn windows(cast: &Cast, windows: &[Window]) -> Vec<Band> {
    let mapping = mapping(cast);
    over_windows(cast, windows, false, |crossings| map(crossings, &mapping))
}

/// What becomes of the crossings of each window, with their facets, if asked; cost as above.
pub fn over_windows<T: Send>(
    cast: &Cast,
    windows: &[Window],
    with_facets: bool,
    of: impl Fn(&Crossings) -> T + Sync,
) -> Vec<T> {
    let group = WINDOWS_OF_GROUP.max(windows.len().div_ceil(8));
    windows.chunks(group).flat_map(|group| over_group(cast, group, with_facets, &of)).collect()
}

fn over_group<T: Send>(
    cast: &Cast,
    windows: &[Window],
    with_facets: bool,
    of: impl Fn(&Crossings) -> T + Sync,
) -> Vec<T> {
    let Cast { frame, rays, .. } = *cast;
    // the first window that ends behind each row of rays
    let mut first_windows = Vec::with_capacity(rays.counts[1] as usize);
    for (at, window) in windows.iter().enumerate() {
        first_windows.resize(first_windows.len().max(window[1].end as usize), at);
    }
    // (window, facet) of a chunk of facets: those whose boxes reach rays of the window
    let pairs_of_chunk = |(chunk, facets): (usize, &[SnappedFacet])| {
        let mut pairs = Vec::new();
        for (index, facet) in (chunk * CHUNK..).zip(facets) {
            let Some([across, down]) = rays_under(facet, frame, rays) else { continue };
            let Some(&first) = first_windows.get(down[0] as usize) else { continue };
            let near = (first..windows.len()).take_while(|&at| windows[at][1].start <= down[1]);
            let reaches = |[rays, _]: &Window| across[0].max(rays.start) < (across[1] + 1).min(rays.end);
            pairs.extend(near.filter(|&at| reaches(&windows[at])).map(|at| (at, index as u32)));
        }
        pairs
    };
    let pairs: Vec<Vec<(usize, u32)>> =
        on_all_cores(|| frame.facets.par_chunks(CHUNK).enumerate().map(pairs_of_chunk).collect());
    let mut facets = vec![Vec::new(); windows.len()];
    for &(window, facet) in pairs.iter().flatten() {
        facets[window].push(facet);
    }
    let of_window =
        |(window, facets): (&Window, Vec<u32>)| of(&crossings_of_window(frame, rays, &facets, window, with_facets));
    let windows: Vec<(&Window, Vec<u32>)> = windows.iter().zip(facets).collect();
    on_all_cores(|| windows.into_par_iter().map(of_window).collect())
}

fn mapping<'a>(cast: &Cast<'a>) -> Mapping<'a> {
    Mapping { rule: cast.rule, flag_of_rank: &cast.frame.ranks.flag_of_rank, depth: cast.rays.depth }
}

/// Meshes on the CPU in rounds of strips, for callers that do other work in between.
pub struct Strips<'a> {
    cast: Cast<'a>,
    lattice: Lattice,
    next: u32,
    /// Rays of the next strip to leave out.
    skipped: usize,
    /// Strips of a round.
    per_round: u32,
}

impl<'a> Strips<'a> {
    /// Builds the lattice of the box, in strips of `rows` ray rows or of a size that suits a core's cache.
    pub fn new(cast: &Cast<'a>, rows: Option<u32>) -> Strips<'a> {
        let Cast { frame, rays, .. } = *cast;
        let bin = [rays.counts[0], rows.unwrap_or(rows_of_strip(rays)).max(1)];
        let lattice = lattice(frame, rays, bin, 0..Lattice::n_rows(rays, bin));
        Strips { cast: *cast, lattice, next: 0, skipped: 0, per_round: STRIPS_PER_ROUND }
    }

    /// Makes at most so many strips, at least one, in a round instead of [`STRIPS_PER_ROUND`].
    pub fn in_rounds_of(self, strips: u32) -> Strips<'a> {
        Strips { per_round: strips.clamp(1, STRIPS_PER_ROUND), ..self }
    }

    /// Begins with the ray of this index instead of the first.
    pub fn at_ray(self, ray: u64) -> Strips<'a> {
        if ray >= self.cast.rays.n_rays() {
            return Strips { next: self.lattice.rows.end, ..self };
        }
        let rays_of_strip = u64::from(self.cast.rays.counts[0]) * u64::from(self.lattice.bin[1]);
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
        let Some((strips, skipped)) = self.next_strips(control)? else { return Ok(None) };
        let (Cast { frame, rays, .. }, mapping) = (self.cast, mapping(&self.cast));
        let of_strip = |scratch: &mut _, strip| {
            if strip == strips.start && skipped > 0 {
                map(&crossings(frame, rays, &self.lattice, strip, false).without_first(skipped), &mapping)
            } else {
                slots::band((frame, rays), &self.lattice, strip, &mapping, scratch)
            }
        };
        let bands = on_all_cores(|| map_within(strips.clone(), of_strip));
        let (n_rays, n_strips) = (rays.n_rays(), self.lattice.rows.end);
        control.advance(u64::from(self.next) * n_rays / u64::from(n_strips), n_rays);
        Ok(Some(bands))
    }

    /// Casts the rays of the next strips on all cores, with the facets of their crossings, if asked; none once all are done.
    ///
    /// # Errors
    /// `cancelled` when the control says so.
    pub fn crossings(&mut self, with_facets: bool, control: &Control) -> Result<Option<Vec<Crossings>>> {
        let Some((strips, skipped)) = self.next_strips(control)? else { return Ok(None) };
        let of_strip = |strip| {
            let crossings = crossings(self.cast.frame, self.cast.rays, &self.lattice, strip, with_facets);
            crossings.without_first(if strip == strips.start { skipped } else { 0 })
        };
        Ok(Some(on_all_cores(|| strips.clone().into_par_iter().map(of_strip).collect())))
    }

    /// The next strips, and how many rays of the first to leave out; none once all are done.
    fn next_strips(&mut self, control: &Control) -> Result<Option<(Range<u32>, usize)>> {
        control.check()?;
        let (first, end) = (self.next, self.next.saturating_add(self.per_round).min(self.lattice.rows.end));
        self.next = end;
        Ok((first < end).then(|| (first..end, std::mem::take(&mut self.skipped))))
    }

    fn columns(mut self, control: &Control) -> Result<Columns> {
        let mut bands = Vec::new();
        while let Some(mut more) = self.round(control)? {
            bands.append(&mut more);
        }
        Columns::new(*self.cast.rays, bands)
    }
}

/// Ray rows of a strip where the caller does not say.
pub fn rows_of_strip(rays: &Rays) -> u32 {
    let [least, most] = RAYS_PER_STRIP;
    let n_rays = (rays.n_rays() / STRIPS).clamp(least, most);
    (n_rays as u32 / rays.counts[0]).clamp(1, rays.counts[1].div_ceil(16))
}
