//! What the report says of the shells of a geometry: those that the cells do not keep.

use serde::{Deserialize, Serialize};

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
    /// Volume of the cells of all its shells together; null where it was not counted: a bound says that it is off by less than 5 %, or there
    /// is nothing to compare with.
    pub volume: Option<f64>,
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
    pub(crate) fn new(shells: u64, volume: Option<f64>, mut found: Vec<ShellReport>, most: usize) -> ShellCheck {
        let size = |of: &ShellReport| of.mesh_volume.abs();
        found.sort_by(|one, other| {
            other.is_lost.cmp(&one.is_lost).then(size(other).total_cmp(&size(one))).then(one.shell.cmp(&other.shell))
        });
        let n_lost = found.iter().filter(|of| of.is_lost).count();
        let off = found.split_off(n_lost);
        let (without_cells, n_off) = (found.len() as u64, off.len() as u64);
        let listed = found.into_iter().take(most).chain(off.into_iter().take(most)).collect();
        ShellCheck { shells, without_cells, off: n_off, listed, volume }
    }

    /// Those of several parts of a box, each once.
    pub(crate) fn merged(parts: &[&ShellCheck]) -> Option<ShellCheck> {
        let first = parts.first()?;
        let mut found: Vec<ShellReport> = parts.iter().flat_map(|part| part.listed.iter().cloned()).collect();
        found.sort_by_key(|of| of.shell);
        found.dedup_by_key(|of| of.shell);
        let merged = ShellCheck::new(first.shells, None, found, MAX_SHELLS);
        // a part with very many does not list all
        let most = |of: fn(&ShellCheck) -> u64| parts.iter().map(|part| of(part)).max().unwrap_or(0);
        Some(ShellCheck {
            without_cells: merged.without_cells.max(most(|part| part.without_cells)),
            off: merged.off.max(most(|part| part.off)),
            ..merged
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shell(shell: u64, mesh_volume: f64, is_lost: bool) -> ShellReport {
        ShellReport { shell, bounding_box: [[0.0; 3], [1.0; 3]], mesh_volume, cells: 0, volume: 0.0, is_lost }
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
