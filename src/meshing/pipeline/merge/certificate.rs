//! Merges certificates of windows to that of their box: counts add up, and of several places the one is kept that the whole box names.

use std::collections::BTreeMap;

use super::part::{Part, rank, total};
use crate::meshing::report::{CertificateReport, GapReport, GeometryReport, OverlapReport, ThinWallReport};
use hexcast_core::base::error::Result;
use hexcast_core::grid::lines::Lines;
use hexcast_core::grid::totals::{Ruler, Total};

/// The certificate of the whole; None where a part has none.
pub(super) fn merged_certificate(
    parts: &[Part],
    geometries: &[GeometryReport],
    whole: &Lines,
) -> Result<Option<CertificateReport>> {
    let all: Option<Vec<&CertificateReport>> = parts.iter().map(|part| part.certificate.as_ref()).collect();
    let (Some(all), Some(Some(first))) = (all, parts.first().map(|part| &part.certificate)) else { return Ok(None) };
    let rank = |index: usize| rank(index, geometries);
    let axis_of_rays = parts[0].report["ray_axis"].as_str().map_or(0, index_of);
    let thin_walls = all.iter().flat_map(|of| &of.thin_walls).map(|wall| ((rank(wall.index), wall.axis), wall.clone()));
    let overlaps = all.iter().flat_map(|of| &of.overlaps).map(|of| (of.indices.map(rank), of.clone()));
    let gaps = all.iter().flat_map(|of| &of.gaps).map(|gap| ((gap.flags, gap.axis), gap.clone()));
    let mut merged = CertificateReport {
        thin_cells: first.thin_cells,
        thin_walls: joined(thin_walls, join_walls),
        overlaps: joined(overlaps, |all, more| join_overlaps(all, more, axis_of_rays)),
        gaps: joined(gaps, join_gaps),
    };
    let ruler = Ruler::new(whole, whole);
    for overlap in &mut merged.overlaps {
        let mut volume = Total::default();
        for (part, of_part) in parts.iter().zip(&all) {
            let pairs = of_part.overlaps.iter().zip(&part.window.sums.overlaps);
            let own = pairs.filter(|(of, _)| of.indices == overlap.indices);
            own.map(|(_, sum)| total(sum)).try_for_each(|total| total.map(|total| volume.add(total)))?;
        }
        overlap.volume = ruler.volume(volume, 1);
    }
    Ok(Some(merged))
}

fn index_of(axis: &str) -> usize {
    ["x", "y", "z"].iter().position(|name| *name == axis).unwrap_or(0)
}

/// Joins what has the same key, in the order of the keys.
fn joined<K: Ord, T>(all: impl Iterator<Item = (K, T)>, mut join: impl FnMut(&mut T, T)) -> Vec<T> {
    let mut by_key: BTreeMap<K, T> = BTreeMap::new();
    for (key, value) in all {
        match by_key.get_mut(&key) {
            Some(known) => join(known, value),
            None => drop(by_key.insert(key, value)),
        }
    }
    by_key.into_values().collect()
}

/// Coordinates of a place: across the rays of an axis, and along them.
fn along(place: [f64; 3], axis: usize) -> ([f64; 2], f64) {
    let [one, other] = [[1, 2], [0, 2], [0, 1]][axis];
    ([place[one], place[other]], place[axis])
}

fn join_walls(all: &mut ThinWallReport, more: ThinWallReport) {
    all.rays += more.rays;
    all.lost += more.lost;
    let order = |wall: &ThinWallReport| (wall.cells, along(wall.place, index_of(wall.axis)));
    if order(&more) < order(all) {
        (all.cells, all.place) = (more.cells, more.place);
    }
}

fn join_overlaps(all: &mut OverlapReport, more: OverlapReport, axis: usize) {
    all.cells += more.cells;
    let order = |overlap: &OverlapReport| {
        let ([one, other], first) = along(overlap.place, axis);
        (u32::MAX - overlap.longest, other, one, first)
    };
    if order(&more) < order(all) {
        (all.longest, all.place) = (more.longest, more.place);
    }
}

fn join_gaps(all: &mut GapReport, more: GapReport) {
    all.cells += more.cells;
    let order = |[x, y, z]: [f64; 3]| [z, y, x];
    if order(more.place) < order(all.place) {
        all.place = more.place;
    }
    for axis in 0..3 {
        all.bounds[0][axis] = all.bounds[0][axis].min(more.bounds[0][axis]);
        all.bounds[1][axis] = all.bounds[1][axis].max(more.bounds[1][axis]);
    }
}
