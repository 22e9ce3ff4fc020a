//! Checks that the shells of geometries have cells, and as much volume as they enclose.
//!
//! Prepared job, what the snap found, the cells of each flag -> a [`ShellCheck`] for each geometry. What a geometry has in the mesh, where others
//! win cells of it, is not looked at here.
//!
//! A shell is not cast where that is not needed: where the bound of its volume says that it is off by less than 5 %; or where no other has cells
//! in its box, and the cells of its flag there have its volume. In a window only shells that meet it are looked at, and those are left out that
//! have far more crossings than the window has rays: these are no thin ones. Parts look at all, where that takes no longer than the part
//! itself, so that their reports say the same.

use super::prepare::Prepared;
use crate::meshing::report::{MAX_OFF, MAX_SHELLS, MAX_SHELLS_OF_PART, ShellCheck, ShellReport, is_cut, off};
use hexcast_core::base::control::Control;
use hexcast_core::base::error::Result;
use hexcast_core::base::memory::Memory;
use hexcast_core::cells::columns::Columns;
use hexcast_core::grid::closed::Closed;
use hexcast_core::grid::frame::Frame;
use hexcast_core::grid::lines::Lines;
use hexcast_core::grid::volume_bound::BoundSums;
use hexcast_core::input::geometry::{Fill, Geometry};
use hexcast_core::input::job::Job;
use hexcast_derived::certificate::shells::lone::{CellBox, cells_of, stand_alone, volumes};
use hexcast_derived::certificate::shells::numbers::Numbers;
use hexcast_derived::certificate::shells::own_cells::{Alone, Caster, Shell, shells};

/// By how many times as many cells along each axis are tried for shells without cells.
const FACTORS: [u32; 8] = [2, 3, 4, 6, 8, 12, 16, 24];
/// Crossings that are expected of a try, or of the shells of a window, at most, where its rays are fewer.
const MOST_TRIED: f64 = 1e6;

/// What the checks are made from.
pub(super) struct Checked<'a> {
    pub(super) job: &'a Job,
    pub(super) prepared: &'a Prepared,
    pub(super) memory: &'a Memory,
    /// A frame of the whole box, or of a window of it.
    pub(super) frame: &'a Frame,
    /// By position.
    pub(super) closed: &'a [Closed],
    /// By position.
    pub(super) bound_sums: &'a [BoundSums],
    pub(super) columns: &'a Columns,
    /// Volume of the cells of each flag.
    pub(super) volumes: &'a [f64; 256],
}

/// Shells of a geometry that are to be cast.
struct Wanted {
    /// By shell.
    is_wanted: Vec<bool>,
    /// By how much the volume of the cells of those that are not can differ from theirs, together.
    off_by: f64,
}

impl Wanted {
    /// Drops shells whose volume is known to be off by so much at most, where that is little.
    fn drop_known(&mut self, shells: &[Shell], off_by: &[Option<f64>]) {
        for (shell, of) in shells.iter().enumerate() {
            if let Some(off_by) = off_by[shell].filter(|off_by| is_little(*off_by, of.volume)) {
                self.is_wanted[shell] = false;
                self.off_by += off_by;
            }
        }
    }
}

impl Checked<'_> {
    /// The check of each geometry of the job; None of those whose shells cannot be told from their cells: all cells along their surfaces are
    /// their own.
    ///
    /// # Errors
    /// `cancelled`; `memory`.
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
        let is_proper = self.closed[position].is_proper;
        let check = self.of_shells(index, (position, is_proper), whole, control).await?;
        // the snap may make an edge proper whose facets it leaves without an area
        let is_sure = check.listed.is_empty() && check.volume.is_none() || !is_proper;
        if is_sure { Ok(check) } else { self.of_shells(index, (position, false), whole, control).await }
    }

    /// The check with shells that are numbered as if no edge had more than two facets, or without that.
    async fn of_shells(
        &self,
        index: usize,
        (position, is_proper): (usize, bool),
        whole: &Frame,
        control: &Control,
    ) -> Result<ShellCheck> {
        let geometry = &self.prepared.geometries[index];
        let closed = self.closed[position];
        let (lines, rule) = (&self.prepared.whole, self.job.rule);
        let numbers = Numbers::new(&geometry.facets, is_proper, self.memory, control).await?;
        let n_shells = numbers.n_shells() as u64;
        if n_shells == 0 || n_shells == 1 && self.is_known(index, position) {
            return Ok(ShellCheck::new(n_shells, None, Vec::new(), MAX_SHELLS));
        }
        let shells = shells(geometry, &numbers, closed.by(rule), control).await?;
        let is_wanted =
            |shell: &Shell| (closed.by(rule) || shell.is_closed(rule)) && self.meets(shell, [[0; 3], lines.dims()]);
        let is_wanted: Vec<bool> = shells.iter().map(is_wanted).collect();
        let (is_wanted, is_all) = self.in_reach(&shells, is_wanted);
        let most = if self.job.part.is_some() && !is_all { MAX_SHELLS_OF_PART } else { MAX_SHELLS };
        let separates = geometry.fill == Fill::Separating;
        let snapped = self.frame.facets_at(position);
        let has_all = self.frame.dims == whole.dims && snapped.len() == geometry.facets.len();
        let snapped = if has_all { snapped } else { &[] };
        let caster = Caster { geometry, frame: whole, snapped, lines, rule, separates };
        let is_wanted = self.unknown((&caster, position), (&numbers, &shells), is_wanted, control).await?;
        if !is_wanted.contains(&true) {
            return Ok(ShellCheck::new(n_shells, None, Vec::new(), most));
        }
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

    /// The shells whose cells must be counted, of those that are wanted: neither a bound nor the mesh says that they are near enough.
    async fn unknown(
        &self,
        (caster, position): (&Caster<'_>, usize),
        (numbers, shells): (&Numbers, &[Shell]),
        is_wanted: Vec<bool>,
        control: &Control,
    ) -> Result<Vec<bool>> {
        if !self.closed[position].nonzero {
            return Ok(is_wanted);
        }
        let lines = &self.prepared.whole;
        let may_be_bounded = |(shell, is_wanted): (&Shell, &bool)| {
            *is_wanted
                && !is_cut(shell.bounds, lines)
                && shell.expected_bound(lines).is_some_and(|bound| is_little(bound, shell.volume))
        };
        let mut wanted = Wanted { is_wanted: is_wanted.clone(), off_by: 0.0 };
        let asked: Vec<bool> = shells.iter().zip(&wanted.is_wanted).map(may_be_bounded).collect();
        if asked.contains(&true) {
            wanted.drop_known(shells, &caster.bounds(numbers, &asked, control).await?);
        }
        let in_mesh = self.off_in_mesh((caster.geometry, position), shells, &wanted.is_wanted)?;
        wanted.drop_known(shells, &in_mesh);
        // of a casing, whose cavity has nearly the volume of the body, the difference counts
        let is_sure = is_little(wanted.off_by, caster.geometry.signed_volume());
        Ok(if is_sure { wanted.is_wanted } else { is_wanted })
    }

    /// By how much the volume of the cells of shells differs from their own, for those that are wanted and whose cells the mesh has for themselves.
    fn off_in_mesh(
        &self,
        (geometry, position): (&Geometry, usize),
        shells: &[Shell],
        is_wanted: &[bool],
    ) -> Result<Vec<Option<f64>>> {
        let mut off_by = vec![None; shells.len()];
        if !is_wanted.contains(&true) || !self.has_own_cells(geometry, position) || self.columns.is_spilled() {
            return Ok(off_by);
        }
        let lines = &self.prepared.whole;
        let boxes: Vec<CellBox> = shells.iter().map(|shell| cells_of(shell.bounds, lines)).collect();
        let is_alone = stand_alone(&boxes);
        let is_known =
            |shell: usize| is_wanted[shell] && is_alone[shell] && self.is_uncovered(shells[shell].bounds, position);
        let known: Vec<usize> = (0..shells.len()).filter(|&shell| is_known(shell)).collect();
        let boxes: Vec<CellBox> = known.iter().map(|&shell| boxes[shell].clone()).collect();
        let found = volumes(self.columns, geometry.flag, &boxes, lines)?;
        for (shell, found) in known.into_iter().zip(found) {
            off_by[shell] = Some((found - shells[shell].volume.abs()).abs());
        }
        Ok(off_by)
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
        let (bounds, volume) = (geometry.bounding_box().unwrap_or_default(), geometry.signed_volume().abs());
        let has_own = || self.has_own_cells(geometry, position) && self.is_uncovered(bounds, position);
        let is_bounded = || {
            let is_within = self.closed[position].nonzero && !is_cut(bounds, &self.prepared.whole);
            let cell = self.prepared.whole.cell_volume().filter(|_| is_within);
            let bound = cell.map(|cell| self.bound_sums[position].of_cells(self.frame.fraction_bits, cell));
            bound.is_some_and(|bound| is_little(bound, volume))
        };
        let found = self.volumes[usize::from(geometry.flag)];
        // one without volume has no cell, either
        has_own() && found > 0.0 && off(found, volume) <= MAX_OFF || is_bounded()
    }

    /// Whether the cells of the flag of a geometry are those that its surface encloses, but for those that others win.
    fn has_own_cells(&self, geometry: &Geometry, position: usize) -> bool {
        let geometries = &self.prepared.geometries;
        let has_flag = geometries.iter().filter(|other| other.flag == geometry.flag).count() == 1;
        geometry.is_plain()
            && has_flag
            && self.closed[position].nonzero
            && self.prepared.window.is_none()
            && self.job.close_gaps.is_none()
    }

    /// Whether a part of a geometry lies in the box, and no geometry that wins over it has cells there.
    fn is_uncovered(&self, bounds: [[f64; 3]; 2], position: usize) -> bool {
        let (geometries, geometry_at) = (&self.prepared.geometries, &self.frame.ranks.geometry_at);
        let meets = |other: &Geometry| {
            let [low, high] = other.bounding_box().unwrap_or_default();
            (0..3).all(|axis| low[axis] <= bounds[1][axis] && bounds[0][axis] <= high[axis])
        };
        let mut higher = (position + 1..geometry_at.len()).map(|above| (above, &geometries[geometry_at[above]]));
        !is_cut(bounds, &self.prepared.whole)
            && higher.all(|(above, other)| self.closed[above].by(self.job.rule) && other.is_plain() && !meets(other))
    }
}

/// Whether a difference is little against a volume: less than 5 %, of which a fifth is for the snap, which moves surfaces by less than a hundredth of
/// a cell. Against none no difference is little: a shell without volume has no cell, which is to be said.
fn is_little(off_by: f64, volume: f64) -> bool {
    off_by < 0.8 * MAX_OFF * volume.abs()
}
