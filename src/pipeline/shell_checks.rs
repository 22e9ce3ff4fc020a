//! Checks that the shells of geometries have cells, and as much volume as they enclose.
//!
//! Prepared job, what the snap found, the cells of each flag -> a [`ShellCheck`] for each geometry. What a geometry has in the mesh, where others
//! win cells of it, is not looked at here.
//!
//! A shell is not cast where that is not needed: where the bound of the volume says that it is off by less than 5 %; or where it is all of its
//! geometry, whose flag and cells no other has, and the cells of the flag have its volume. In a window only shells that meet it are looked at,
//! and those are left out that have far more crossings than the window has rays: these are no thin ones. Parts look at all, where that takes
//! no longer than the part itself, so that their reports say the same.

use super::prepare::Prepared;
use crate::closed::Closed;
use crate::control::Control;
use crate::error::Result;
use crate::frame::Frame;
use crate::geometry::{Fill, Geometry};
use crate::job::Job;
use crate::lines::Lines;
use crate::report::{MAX_OFF, MAX_SHELLS, MAX_SHELLS_OF_PART, ShellCheck, ShellReport, is_cut, off};
use crate::shells::alone::{Alone, Caster, Shell, numbers, shells};
use crate::shells::numbers::Numbers;
use crate::volume_bound::BoundSums;

/// By how many times as many cells along each axis are tried for shells without cells.
const FACTORS: [u32; 8] = [2, 3, 4, 6, 8, 12, 16, 24];
/// Crossings that are expected of a try, or of the shells of a window, at most, where its rays are fewer.
const MOST_TRIED: f64 = 1e6;

/// What the checks are made from.
pub(super) struct Checked<'a> {
    pub(super) job: &'a Job,
    pub(super) prepared: &'a Prepared,
    /// A frame of the whole box, or of a window of it.
    pub(super) frame: &'a Frame,
    /// By position.
    pub(super) closed: &'a [Closed],
    /// By position.
    pub(super) bound_sums: &'a [BoundSums],
    /// Volume of the cells of each flag.
    pub(super) volumes: &'a [f64; 256],
}

impl Checked<'_> {
    /// The check of each geometry of the job; None of those whose shells cannot be told from their cells: all cells along their surfaces are
    /// their own.
    ///
    /// # Errors
    /// `cancelled`.
    pub(super) async fn all(&self, control: &Control) -> Result<Vec<Option<ShellCheck>>> {
        let mut all = vec![None; self.prepared.geometries.len()];
        // that of a window has other centres
        let whole = Frame::without_facets(&self.prepared.geometries, &self.prepared.whole)?;
        for (position, &index) in self.frame.ranks.geometry_at.iter().enumerate() {
            let geometry = &self.prepared.geometries[index];
            if geometry.fill != Fill::Conservative && !geometry.facets.is_empty() {
                all[index] = Some(self.of(index, position, &whole, control).await?);
            }
        }
        Ok(all)
    }

    async fn of(&self, index: usize, position: usize, whole: &Frame, control: &Control) -> Result<ShellCheck> {
        let geometry = &self.prepared.geometries[index];
        let closed = self.closed[position];
        let (lines, rule) = (&self.prepared.whole, self.job.rule);
        let numbers = numbers(geometry, closed.is_proper, control).await?;
        let n_shells = numbers.n_shells() as u64;
        if n_shells == 0 || n_shells == 1 && self.is_known(index, position) {
            return Ok(ShellCheck::new(n_shells, None, Vec::new(), MAX_SHELLS));
        }
        let shells = shells(geometry, &numbers, closed.by(rule), control).await?;
        let is_wanted: Vec<bool> = shells.iter().map(|shell| self.is_wanted(shell, geometry, position)).collect();
        let (is_wanted, is_all) = self.in_reach(&shells, is_wanted);
        let most = if self.job.part.is_some() && !is_all { MAX_SHELLS_OF_PART } else { MAX_SHELLS };
        let separates = geometry.fill == Fill::Separating;
        let snapped = self.frame.facets_at(position);
        let has_all = self.frame.dims == whole.dims && snapped.len() == geometry.facets.len();
        let snapped = if has_all { snapped } else { &[] };
        let caster = Caster { geometry, frame: whole, snapped, lines, rule, separates };
        let alone = caster.cast((&numbers, &shells), &is_wanted, control).await?;
        let has_volume = closed.nonzero && !separates && !geometry.shell;
        let found = |(number, (shell, alone)): (usize, (&Shell, &Option<Alone>))| {
            let alone = (*alone)?;
            let is_off = has_volume && !is_cut(shell.bounds, lines) && off(alone.volume, shell.volume) > MAX_OFF;
            (alone.is_none() || is_off).then(|| ShellReport {
                shell: number as u64,
                bounding_box: shell.bounds,
                mesh_volume: shell.volume,
                cells: alone.cells,
                volume: alone.volume,
                is_lost: alone.is_none(),
                is_crossed: false,
            })
        };
        let found = shells.iter().zip(&alone).enumerate().filter_map(found).collect();
        let found: Vec<ShellReport> = found;
        let volume: Option<f64> = alone.iter().map(|alone| alone.map(|alone| alone.volume)).sum();
        let has_all = has_volume && !is_cut(geometry.bounding_box().unwrap_or_default(), lines);
        let volume = volume
            .map(f64::abs)
            .filter(|volume| has_all && (!found.is_empty() || off(*volume, geometry.signed_volume().abs()) > MAX_OFF));
        let mut check = ShellCheck::new(n_shells, volume, found, most);
        self.add_help(&mut check, &caster, (&numbers, &shells), control).await?;
        Ok(check)
    }

    /// Finds out what would keep the shells that have no cell, of those that are listed: a fill, or smaller cells.
    async fn add_help(
        &self,
        check: &mut ShellCheck,
        caster: &Caster<'_>,
        of: (&Numbers, &[Shell]),
        control: &Control,
    ) -> Result<()> {
        let mut is_lost = vec![false; of.1.len()];
        check.listed.iter().filter(|of| of.is_lost).for_each(|of| is_lost[of.shell as usize] = true);
        if !is_lost.contains(&true) {
            return Ok(());
        }
        let crossed = Caster { separates: true, ..*caster }.cast(of, &is_lost, control).await?;
        for listed in check.listed.iter_mut().filter(|of| of.is_lost) {
            listed.is_crossed = crossed[listed.shell as usize].is_some_and(|alone| !alone.is_none());
        }
        let lines = &self.prepared.whole;
        let expected: f64 =
            of.1.iter().zip(&is_lost).filter(|(_, is_lost)| **is_lost).map(|(of, _)| of.axis(lines).1).sum();
        let Some(spacing) = lines.spacing() else { return Ok(()) };
        for factor in FACTORS {
            let dims = lines.dims().map(|n| n.saturating_mul(factor));
            let fine = Lines::new(lines.origin(), spacing.map(|size| size / f64::from(factor)), dims);
            let Ok(fine) = fine else { return Ok(()) };
            let Ok(frame) = Frame::without_facets(&self.prepared.geometries, &fine) else { return Ok(()) };
            if expected * f64::from(factor).powi(2) > MOST_TRIED {
                return Ok(());
            }
            let finer = Caster { frame: &frame, snapped: &[], lines: &fine, ..*caster };
            let found = finer.cast(of, &is_lost, control).await?;
            if found.iter().flatten().all(|alone| !alone.is_none()) {
                check.cells_factor = Some(factor);
                return Ok(());
            }
        }
        Ok(())
    }

    /// Whether the cells of a shell must be counted, in a mesh of the whole box.
    fn is_wanted(&self, shell: &Shell, geometry: &Geometry, position: usize) -> bool {
        let (lines, rule) = (&self.prepared.whole, self.job.rule);
        let is_closed = self.closed[position].by(rule) || shell.is_closed(rule);
        is_closed
            && self.meets(shell, [[0; 3], lines.dims()])
            && !self.is_bounded((shell.bounds, shell.volume), geometry, position)
    }

    /// Whether the box of a shell and some cells have a place in common.
    fn meets(&self, shell: &Shell, [first, end]: [[u32; 3]; 2]) -> bool {
        let lines = &self.prepared.whole;
        (0..3).all(|axis| {
            let [low, high] = shell.bounds.map(|corner| corner[axis]);
            low < lines.line(axis, end[axis]) && high > lines.line(axis, first[axis])
        })
    }

    /// The shells that are counted, of those that are wanted, and whether these are all: in a part, unless that would take long, so that the
    /// reports of all parts say the same; in a window or another part those that meet it, but for those that take long.
    fn in_reach(&self, shells: &[Shell], is_wanted: Vec<bool>) -> (Vec<bool>, bool) {
        let Some(window) = self.prepared.window else { return (is_wanted, true) };
        let most = MOST_TRIED.max(4.0 * self.prepared.rays.n_rays() as f64);
        let expected = |shell: &Shell| shell.axis(&self.prepared.whole).1;
        let of_wanted = shells.iter().zip(&is_wanted).filter(|(_, is_wanted)| **is_wanted);
        if self.job.part.is_some() && of_wanted.map(|(shell, _)| expected(shell)).sum::<f64>() <= most {
            return (is_wanted, true);
        }
        let is_near = |shell: &Shell| self.meets(shell, window) && expected(shell) <= most;
        (shells.iter().zip(is_wanted).map(|(shell, is_wanted)| is_wanted && is_near(shell)).collect(), false)
    }

    /// Whether the only shell of a geometry is known to be off by less than 5 %.
    fn is_known(&self, index: usize, position: usize) -> bool {
        let geometry = &self.prepared.geometries[index];
        let (bounds, volume) = (geometry.bounding_box().unwrap_or_default(), geometry.signed_volume());
        let in_mesh = self.volume_in_mesh(index, position);
        in_mesh.is_some_and(|found| off(found, volume.abs()) <= MAX_OFF)
            || self.is_bounded((bounds, volume), geometry, position)
    }

    /// Whether the bound of all shells of a geometry says of one, in a box and of a volume, that it is off by less than 5 %.
    fn is_bounded(&self, (bounds, volume): ([[f64; 3]; 2], f64), geometry: &Geometry, position: usize) -> bool {
        let Some(cell) = self.prepared.whole.cell_volume() else { return false };
        let bound = self.bound_sums[position].of_cells(self.frame.fraction_bits, cell);
        let is_within = self.closed[position].nonzero && !is_cut(bounds, &self.prepared.whole);
        // of a casing, whose cavity has nearly the volume of the body, the difference counts; a fifth is for the snap, which moves surfaces by
        // less than a hundredth of a cell
        let least = volume.abs().min(geometry.signed_volume().abs());
        is_within && bound <= 0.8 * MAX_OFF * least
    }

    /// The volume of the cells of a geometry in the mesh, if they are those that it has alone.
    fn volume_in_mesh(&self, index: usize, position: usize) -> Option<f64> {
        let (geometries, geometry_at) = (&self.prepared.geometries, &self.frame.ranks.geometry_at);
        let geometry = &geometries[index];
        let is_plain = |geometry: &Geometry| geometry.fill == Fill::Centre && !geometry.shell && !geometry.invert;
        let bounds = geometry.bounding_box()?;
        let meets = |other: &Geometry| {
            let [low, high] = other.bounding_box().unwrap_or_default();
            (0..3).all(|axis| low[axis] <= bounds[1][axis] && bounds[0][axis] <= high[axis])
        };
        let higher =
            geometry_at[position + 1..].iter().enumerate().map(|(above, &index)| (position + 1 + above, index));
        let mut higher = higher.map(|(position, index)| (self.closed[position].by(self.job.rule), &geometries[index]));
        let is_alone = higher.all(|(is_closed, other)| is_closed && is_plain(other) && !meets(other));
        let has_flag = geometries.iter().filter(|other| other.flag == geometry.flag).count() == 1;
        let is_own = is_plain(geometry)
            && self.closed[position].nonzero
            && !is_cut(bounds, &self.prepared.whole)
            && self.prepared.window.is_none()
            && self.job.close_gaps.is_none();
        (is_own && is_alone && has_flag).then(|| self.volumes[usize::from(geometry.flag)])
    }
}
