//! Difference: the cells in which two meshes of the same number of cells have different flags.
//!
//! Two meshes -> [`Difference`], the cells of each pair of flags and a mask of all of them. If both meshes have their rays
//! along the same axis, runs are compared ray by ray. Otherwise the cells of the second mesh are expanded, for some rays of
//! the first at a time.
//! Cost: O(runs), or O(cells) where the axes differ; the mask, and flags of 2^26 cells a thread, in wasm of 2^19.

use std::cmp::Reverse;

use serde::Serialize;

use crate::mesh::Mesh;
use hexcast_core::base::control::{Control, at_once};
use hexcast_core::base::error::{Error, Result};
use hexcast_core::base::parallel::*;
use hexcast_core::base::sort::sort_by_key;
use hexcast_core::cells::columns::{Band, Columns, ColumnsBuilder, Named, for_differing, run};
use hexcast_core::cells::flags::flags_of_box;
use hexcast_core::grid::rays::Rays;
use hexcast_core::set;

/// Cells that are compared by a thread at a time: where both have their rays along one axis, and where the other's cells are expanded. The
/// one thread of wasm rests in between, after some hundredths of a second.
const CELLS: [u32; 2] = if cfg!(target_arch = "wasm32") { [1 << 22, 1 << 19] } else { [1 << 26; 2] };

/// What differs between two meshes; as JSON all but the mask.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Difference {
    /// Number of cells that differ.
    pub cells: u64,
    /// Number of all cells.
    pub n_cells: u64,
    /// Whether the lines are the same; where they are not, cells are compared by their indices.
    pub are_lines_equal: bool,
    /// The pairs of flags, most cells first; of equal ones ascending.
    pub pairs: Vec<FlagPair>,
    /// The lines of the first mesh, and flag 1 where the two differ.
    #[serde(skip)]
    pub mask: Mesh,
}

/// Cells that have one flag in the first mesh and another in the second.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct FlagPair {
    /// The flag in the first mesh.
    pub one: u8,
    /// The flag in the second.
    pub other: u8,
    /// Number of cells.
    pub cells: u64,
    /// The first of them along the rays of the first mesh.
    pub first: [u32; 3],
    /// The box around them; its end is exclusive.
    pub bounds: [[u32; 3]; 2],
}

/// Ascending by both flags.
type Pairs = Vec<FlagPair>;

/// Compares two meshes cell by cell. The mask takes at most `max_bytes`.
///
/// # Errors
/// `job-conflict` where they differ in their numbers of cells; `memory` where the mask takes more than is allowed; `io` where columns are in
/// a store that fails; `cancelled`.
pub fn difference(one: &Mesh, other: &Mesh, max_bytes: u64, control: &Control) -> Result<Difference> {
    at_once(difference_with_rests(one, other, max_bytes, &control.without_pauses()))
}

/// Like [`difference()`], with a rest every some cells ([`Control::rest`]).
///
/// # Errors
/// Those of [`difference()`].
#[doc(hidden)]
pub async fn difference_with_rests(one: &Mesh, other: &Mesh, max_bytes: u64, control: &Control) -> Result<Difference> {
    let [dims, others] = [one, other].map(Mesh::dims);
    if dims != others {
        let text = |[nx, ny, nz]: [u32; 3]| format!("{nx} x {ny} x {nz}");
        let message = format!("one mesh has {} cells, the other {}", text(dims), text(others));
        return Err(Error::new("job-conflict", message, "compare meshes of the same box and cells"));
    }
    let rays = *one.columns.rays();
    let is_expanded = rays.axis != other.columns.rays().axis;
    let step = u64::from((CELLS[usize::from(is_expanded)] / rays.depth).max(1));
    let blocks: Vec<u64> = (0..rays.n_rays()).step_by(step as usize).collect();
    let mut builder = ColumnsBuilder::new(rays, max_bytes, None);
    let mut pairs = Pairs::new();
    for blocks in blocks.chunks(4 * current_num_threads()) {
        control.rest().await?;
        let compare = |&first: &u64| compared(one, other, first..(first + step).min(rays.n_rays()));
        let found: Vec<Result<(Band, Pairs)>> = blocks.par_iter().map(compare).collect();
        for found in found {
            let (band, of_band) = found?;
            builder.push(vec![band]).map_err(|error| too_large(&error, max_bytes))?;
            of_band.into_iter().for_each(|pair| add(&mut pairs, pair));
        }
    }
    sort_by_key(&mut pairs, |pair| (Reverse(pair.cells), pair.one, pair.other));
    let names = vec![Named::new(1, "different")];
    let mask = Mesh::new(one.lines.clone(), builder.finish()?, names, one.unit.clone())?;
    let cells = pairs.iter().map(|pair| pair.cells).sum();
    Ok(Difference { cells, n_cells: one.n_cells(), are_lines_equal: one.lines == other.lines, pairs, mask })
}

/// Why the mask does not fit.
fn too_large(error: &Error, max_bytes: u64) -> Error {
    let message = format!("the cells that differ take more than {max_bytes} bytes: {error}");
    Error::new("memory", message, "allow more memory, or compare boxes of the meshes")
}

/// Compares some rays of the first mesh: the mask, and the pairs of flags.
fn compared(one: &Mesh, other: &Mesh, range: std::ops::Range<u64>) -> Result<(Band, Pairs)> {
    let rays = *one.columns.rays();
    let mut band = set!(Band { first_ray: range.start, ..Band::default() });
    let mut pairs = Pairs::new();
    let others = runs_of(&other.columns, rays, range.clone())?;
    let mut index = 0;
    one.columns.for_rays(range.clone(), |runs| {
        let start = band.runs.len();
        let ray = range.start + index as u64;
        let [i, j] = [ray % u64::from(rays.counts[0]), ray / u64::from(rays.counts[0])].map(|at| at as u32);
        for_differing(runs, others.ray(index), rays.depth, |span, flags| {
            // a span that continues the last one takes away its end
            if band.runs.len() > start && band.runs.last() == Some(&run(span.start, 0)) {
                band.runs.pop();
            } else {
                band.runs.push(run(span.start, 1));
            }
            if span.end < rays.depth {
                band.runs.push(run(span.end, 0));
            }
            let [low, last] = [span.start, span.end - 1].map(|along| rays.cell([i, j, along]));
            let bounds = [low, last.map(|index| index + 1)];
            let (cells, [one, other]) = (u64::from(span.end - span.start), flags);
            add(&mut pairs, FlagPair { one, other, cells, first: low, bounds });
        });
        band.ends.push(band.runs.len() as u32);
        index += 1;
    })?;
    Ok((band, pairs))
}

fn add(pairs: &mut Pairs, pair: FlagPair) {
    let known = match pairs.binary_search_by_key(&(pair.one, pair.other), |known| (known.one, known.other)) {
        Ok(at) => &mut pairs[at],
        Err(at) => return pairs.insert(at, pair),
    };
    let [low, high] = pair.bounds;
    known.cells += pair.cells;
    for axis in 0..3 {
        known.bounds[0][axis] = known.bounds[0][axis].min(low[axis]);
        known.bounds[1][axis] = known.bounds[1][axis].max(high[axis]);
    }
}

/// The runs that columns have along some rays, also where their own rays are others.
fn runs_of(columns: &Columns, rays: Rays, range: std::ops::Range<u64>) -> Result<Band> {
    let mut band = Band::default();
    if columns.rays().axis == rays.axis {
        columns.for_rays(range, |runs| {
            band.runs.extend_from_slice(runs);
            band.ends.push(band.runs.len() as u32);
        })?;
        return Ok(band);
    }
    let n_first = u64::from(rays.counts[0]);
    let mut next = range.start;
    while next < range.end {
        // the rays of one row
        let (i, j) = ((next % n_first) as u32, (next / n_first) as u32);
        let n = (n_first - u64::from(i)).min(range.end - next) as u32;
        let [low, high] = [rays.cell([i, j, 0]), rays.cell([i + n, j + 1, rays.depth])];
        let cells = [0, 1, 2].map(|axis| low[axis]..high[axis]);
        let lengths = cells.each_ref().map(|range| range.len());
        let steps = [1, lengths[0], lengths[0] * lengths[1]];
        let flags = flags_of_box(columns, &cells)?;
        for ray in 0..n as usize {
            let mut last = 0;
            for along in 0..rays.depth {
                let flag = flags[ray * steps[rays.across[0]] + along as usize * steps[rays.axis]];
                if flag != last {
                    band.runs.push(run(along, flag));
                    last = flag;
                }
            }
            band.ends.push(band.runs.len() as u32);
        }
        next += u64::from(n);
    }
    Ok(band)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{pattern, pattern_flags};

    #[test]
    fn the_cells_that_differ_are_found_whatever_the_axes_of_the_rays() {
        let dims = [9, 5, 7];
        let expected: Vec<(u8, u8)> = pattern_flags(dims, 3).into_iter().zip(pattern_flags(dims, 2)).collect();
        for (axis, other) in (0..3).flat_map(|axis| (0..3).map(move |other| (axis, other))) {
            let found =
                difference(&pattern(axis, dims, 3), &pattern(other, dims, 2), u64::MAX, &Control::default()).unwrap();
            let differs: Vec<u8> = expected.iter().map(|(one, other)| u8::from(one != other)).collect();
            assert_eq!(found.mask.box_flags(&dims.map(|n| 0..n)).unwrap(), differs, "axes {axis}, {other}");
            assert_eq!(found.cells, differs.iter().map(|&cell| u64::from(cell)).sum::<u64>());
            assert!(found.pairs.len() > 2 && found.are_lines_equal);
            for pair in &found.pairs {
                let cell = |at: u32| [at % dims[0], at / dims[0] % dims[1], at / dims[0] / dims[1]];
                let of_pair = |at: &u32| expected[*at as usize] == (pair.one, pair.other);
                let cells: Vec<[u32; 3]> = (0..dims.iter().product()).filter(of_pair).map(cell).collect();
                assert_eq!(pair.cells, cells.len() as u64);
                let low = [0, 1, 2].map(|axis| cells.iter().map(|cell| cell[axis]).min().unwrap());
                let high = [0, 1, 2].map(|axis| cells.iter().map(|cell| cell[axis] + 1).max().unwrap());
                assert_eq!(pair.bounds, [low, high]);
                assert!(cells.contains(&pair.first));
            }
        }
    }

    #[test]
    fn equal_meshes_do_not_differ_and_others_are_refused() {
        let mesh = pattern(0, [9, 5, 7], 3);
        let found = difference(&mesh, &pattern(2, [9, 5, 7], 3), u64::MAX, &Control::default()).unwrap();
        assert_eq!((found.cells, found.pairs.len(), found.mask.columns.n_runs()), (0, 0, 0));
        let error = difference(&mesh, &pattern(0, [9, 5, 8], 3), u64::MAX, &Control::default()).unwrap_err();
        assert_eq!(error.code(), "job-conflict");
        assert!(error.to_string().contains("9 x 5 x 7 cells, the other 9 x 5 x 8"), "{error}");
        let error = difference(&mesh, &pattern(1, [9, 5, 7], 2), 99, &Control::default()).unwrap_err();
        assert_eq!(error.code(), "memory");
        let control = Control::default();
        control.cancel.cancel();
        assert_eq!(difference(&mesh, &mesh, u64::MAX, &control), Err(Error::Cancelled));
    }
}
