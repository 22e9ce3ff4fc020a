//! What the report says of the shells of a geometry: those that the cells do not keep.

use serde::{Deserialize, Serialize};

use hexcast_core::base::finding::Finding;
use hexcast_core::grid::lines::{AXES, Lines};

/// Part of a volume by which that of cells may be off without a word.
pub const MAX_OFF: f64 = 0.05;
/// Most shells of each kind that are listed of a geometry.
pub const MAX_SHELLS: usize = 20;
/// The same in the report of a part, which is merged with those of others.
pub const MAX_SHELLS_OF_PART: usize = 1000;

/// What was found of the shells of a geometry, each alone: what other geometries win is not looked at.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct ShellCheck {
    /// Number of its shells: groups of facets connected over shared edges.
    pub shells: u64,
    /// Those of them that have no cell.
    pub without_cells: u64,
    /// Those that have cells, the volume of which differs by more than 5 % from that of the shell.
    pub off: u64,
    /// Shells without cells, then those whose volume is off, at most 20 of each kind, the largest first; of a part (`--part`) at most 1,000.
    pub listed: Vec<ShellReport>,
    /// Volume of the cells of all its shells together; null where no shell is listed and it is off by less than 5 %, and where there is nothing
    /// to compare with.
    pub volume: Option<f64>,
    /// How many times as many cells along each axis, of equal ones, would give every listed shell a cell; null where none of those that
    /// were tried does, and where no shell lacks one.
    pub cells_factor: Option<u32>,
}

/// A shell that the cells do not keep.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct ShellReport {
    /// Its number, from 0, in the order of their first facets.
    pub shell: u64,
    /// Least and greatest coordinates.
    pub bounding_box: [[f64; 3]; 2],
    /// The volume that it encloses: less than 0 of a cavity.
    pub mesh_volume: f64,
    /// Number of its cells, counted as often as it winds around them; less than 0 of a cavity.
    pub cells: i64,
    /// Volume of these cells.
    pub volume: f64,
    /// Whether it has no cell.
    pub is_lost: bool,
    /// Whether lines through centres cross it, so that `fill = "separating"` keeps it; false where it is not lost.
    pub is_crossed: bool,
}

impl ShellReport {
    /// By how much the volume of its cells differs from its own, as a part of this; infinite without one.
    pub fn off(&self) -> f64 {
        off(self.volume, self.mesh_volume)
    }
}

/// By how much a volume of cells differs from one of a surface, as a part of this.
pub fn off(volume: f64, mesh_volume: f64) -> f64 {
    if volume == mesh_volume { 0.0 } else { (volume - mesh_volume).abs() / mesh_volume.abs() }
}

impl ShellCheck {
    /// Counts and lists shells that have no cell, or too much or too little volume.
    #[doc(hidden)]
    pub fn new(shells: u64, volume: Option<f64>, mut found: Vec<ShellReport>, most: usize) -> ShellCheck {
        let size = |of: &ShellReport| of.mesh_volume.abs();
        found.sort_by(|one, other| {
            other.is_lost.cmp(&one.is_lost).then(size(other).total_cmp(&size(one))).then(one.shell.cmp(&other.shell))
        });
        let n_lost = found.iter().filter(|of| of.is_lost).count();
        let off = found.split_off(n_lost);
        let (without_cells, n_off) = (found.len() as u64, off.len() as u64);
        let listed = found.into_iter().take(most).chain(off.into_iter().take(most)).collect();
        ShellCheck { shells, without_cells, off: n_off, listed, volume, cells_factor: None }
    }

    /// Those of several parts of a box, each once.
    #[doc(hidden)]
    pub fn merged(parts: &[&ShellCheck]) -> Option<ShellCheck> {
        let first = *parts.first()?;
        if parts.iter().all(|part| *part == first) {
            return Some(first.clone());
        }
        let mut found: Vec<ShellReport> = parts.iter().flat_map(|part| part.listed.iter().cloned()).collect();
        found.sort_by_key(|of| of.shell);
        found.dedup_by_key(|of| of.shell);
        let merged = ShellCheck::new(first.shells, None, found, MAX_SHELLS);
        // a part with very many does not list all
        let most = |of: fn(&ShellCheck) -> u64| parts.iter().map(|part| of(part)).max().unwrap_or(0);
        Some(ShellCheck {
            without_cells: merged.without_cells.max(most(|part| part.without_cells)),
            off: merged.off.max(most(|part| part.off)),
            cells_factor: parts.iter().filter_map(|part| part.cells_factor).max(),
            ..merged
        })
    }
}

/// Shells that a sentence names.
const MAX_NAMED: usize = 5;

impl ShellReport {
    /// The axis along which its box holds no centre of a cell, and the size of the box there; else the axis along which that is least.
    fn thin_axis(&self, lines: &Lines) -> (usize, f64) {
        let [low, high] = self.bounding_box;
        let thickness = |axis: usize| (axis, high[axis] - low[axis]);
        // cell i is inside only if low < its centre <= high
        let n_below = |axis: usize, place: f64| (lines.position(axis, place) - 0.5).floor();
        let without = (0..3).filter(|&axis| n_below(axis, low[axis]) >= n_below(axis, high[axis]));
        let thinnest =
            |axes: &mut dyn Iterator<Item = usize>| axes.map(thickness).min_by(|one, other| one.1.total_cmp(&other.1));
        thinnest(&mut { without }).or(thinnest(&mut (0..3))).unwrap_or_default()
    }

    fn named(&self, lines: &Lines) -> String {
        let [low, high] = self.bounding_box.map(|corner| lines.text_of(corner));
        format!("{} from {low} to {high}", self.shell)
    }
}

/// The geometry that a check is about.
pub(super) struct Subject<'a> {
    pub(super) index: usize,
    pub(super) name: &'a str,
    pub(super) flag: u8,
    /// The volume that it encloses, without a sign.
    pub(super) mesh_volume: f64,
}

impl ShellCheck {
    /// What is to be said of the shells of a geometry.
    pub(super) fn findings(&self, geometry: &Subject<'_>, lines: &Lines) -> Vec<Finding> {
        let of_geometry = |finding: Finding| {
            finding.of_geometry(geometry.index, geometry.name).of_flag(geometry.flag).with_count("shells", self.shells)
        };
        self.lost(geometry, lines).into_iter().chain(self.volume_off(geometry, lines)).map(of_geometry).collect()
    }

    /// Names some of its shells; `is_lost` says which.
    fn named(&self, is_lost: bool, n: u64, lines: &Lines) -> String {
        let all = || self.listed.iter().filter(|of| of.is_lost == is_lost);
        let named: Vec<String> = all().take(MAX_NAMED).map(|of| of.named(lines)).collect();
        let n_more = n.saturating_sub(named.len() as u64);
        let more = if n_more > 0 { format!(" and {n_more} more") } else { String::new() };
        format!("number {}{more}", named.join(", "))
    }

    fn lost(&self, geometry: &Subject<'_>, lines: &Lines) -> Option<Finding> {
        let lost = || self.listed.iter().filter(|of| of.is_lost);
        let (axis, thickness) = lost().map(|of| of.thin_axis(lines)).min_by(|one, other| one.1.total_cmp(&other.1))?;
        let thinnest = lost().find(|of| of.thin_axis(lines) == (axis, thickness))?;
        let place = 0.5 * (thinnest.bounding_box[0][axis] + thinnest.bounding_box[1][axis]);
        let last = f64::from(lines.dims()[axis] - 1);
        let size = lines.cell_size(axis, lines.position(axis, place).clamp(0.0, last) as u32);
        let (name, flag, n, of, along) = (geometry.name, geometry.flag, self.without_cells, self.shells, AXES[axis]);
        let (have, them) = if n == 1 { ("has", "it") } else { ("have", "them") };
        // with as many digits as files hold
        let [thick, cell] = [thickness, size].map(|length| length as f32);
        let smaller = match self.cells_factor {
            Some(factor) => format!("use smaller cells, {factor} times as many along each axis,"),
            None => "use smaller cells,".into(),
        };
        let fill =
            if lost().all(|of| of.is_crossed) { "\"separating\" or \"conservative\"" } else { "\"conservative\"" };
        let sentence = format!(
            "{n} of the {of} shells of geometry \"{name}\" (flag {flag}) {have} no cell: {}; the thinnest is {thick:?} thick along {along}, \
             where a cell is {cell:?}; {smaller} or keep {them} with fill = {fill}",
            self.named(true, n, lines),
        );
        let found = Finding::new("shell-lost", sentence).along(axis).with_count("lost", n);
        let found = found.with_value("thickness", thickness).with_value("cell_size", size);
        let found = found.with_count("crossed", lost().filter(|of| of.is_crossed).count() as u64);
        let found = self.cells_factor.map_or(found.clone(), |factor| found.with_count("cells_factor", factor.into()));
        Some(lost().fold(found, |found, of| found.within(of.bounding_box)))
    }

    fn volume_off(&self, geometry: &Subject<'_>, lines: &Lines) -> Option<Finding> {
        let surface = geometry.mesh_volume;
        let total = self.volume.filter(|volume| off(*volume, surface) > MAX_OFF && self.without_cells < self.shells);
        if total.is_none() && self.off == 0 {
            return None;
        }
        let (name, flag) = (geometry.name, geometry.flag);
        let percent = |volume: f64, surface: f64| {
            let part = 100.0 * (volume.abs() - surface.abs()) / surface.abs();
            format!("{:.1} % too {}", part.abs(), if part < 0.0 { "small" } else { "large" })
        };
        let of_all = total.map(|volume| {
            format!(
                "that of its {} is {}",
                if self.shells == 1 { "cells" } else { "cells together" },
                percent(volume, surface)
            )
        });
        let of_shells = (self.off > 0 && self.shells > 1).then(|| {
            let worst =
                self.listed.iter().filter(|of| !of.is_lost).max_by(|one, other| one.off().total_cmp(&other.off()));
            let worst = worst.map_or(String::new(), |of| {
                format!(
                    ", the worst of those that are listed, number {}, is {}",
                    of.named(lines),
                    percent(of.volume, of.mesh_volume)
                )
            });
            format!(
                "that of {} of its {} shells is off by more than {} %{worst}",
                self.off,
                self.shells,
                100.0 * MAX_OFF
            )
        });
        let parts: Vec<String> = of_all.into_iter().chain(of_shells).collect();
        let sentence = format!(
            "the cells of geometry \"{name}\" (flag {flag}) have another volume than its surface: {}; use smaller cells",
            parts.join("; ")
        );
        let found = Finding::new("volume-off", sentence).with_count("off", self.off).with_value("mesh_volume", surface);
        let found = self.volume.map_or(found.clone(), |volume| found.with_value("volume", volume));
        Some(self.listed.iter().filter(|of| !of.is_lost).fold(found, |found, of| found.within(of.bounding_box)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shell(shell: u64, mesh_volume: f64, is_lost: bool) -> ShellReport {
        ShellReport {
            shell,
            bounding_box: [[0.0; 3], [1.0; 3]],
            mesh_volume,
            cells: 0,
            volume: 0.0,
            is_lost,
            is_crossed: false,
        }
    }

    #[test]
    fn the_largest_are_listed_first_and_all_are_counted() {
        let found = (0..50).map(|n| shell(n, -(n as f64), n % 2 == 0)).collect();
        let check = ShellCheck::new(60, None, found, 3);
        let listed: Vec<u64> = check.listed.iter().map(|of| of.shell).collect();
        assert_eq!((check.without_cells, check.off, listed), (25, 25, vec![48, 46, 44, 49, 47, 45]));
    }

    #[test]
    fn shells_that_several_parts_meet_are_counted_once() {
        let part = |shells: [u64; 2]| {
            ShellCheck::new(9, Some(1.0), shells.iter().map(|&n| shell(n, 1.0, true)).collect(), MAX_SHELLS_OF_PART)
        };
        let merged = ShellCheck::merged(&[&part([1, 2]), &part([2, 5])]).unwrap();
        assert_eq!((merged.shells, merged.without_cells, merged.volume), (9, 3, None));
        assert_eq!(merged.listed.iter().map(|of| of.shell).collect::<Vec<_>>(), [1, 2, 5]);
        assert_eq!(ShellCheck::merged(&[]), None);
    }
}
