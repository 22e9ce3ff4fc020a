//! Every cell of a mesh against its job, slab by slab.
//!
//! The runs of the mesh lie along an axis a; a slab is some planes of cells along a and b, one after the other along c. Rays along b
//! decide the cells of closed bodies; open ones are decided as their policy says, by rays along all three axes and the winding number.

use std::ops::Range;
use std::sync::OnceLock;

use hexcast::{Result, control::Control, job::Open, mesh::Mesh};
use rayon::prelude::*;

use super::{ray::Rays, scene::Body, scene::Scene, surface::winding};

/// Wrong cells that are named.
const SHOWN: usize = 5;
/// Solid angles that are computed: some ten or twenty seconds on two cores.
const ANGLES: u64 = 300_000_000;
/// Votes of the rays through a cell: what one that is inside adds, and one that does not leave the body as often as it enters.
const INSIDE: u8 = 1;
const ODD: u8 = 16;
/// In place of a flag: nobody knows.
const UNKNOWN: i16 = -1;

/// What was found.
#[derive(Default)]
pub(super) struct Tally {
    pub(super) n_wrong: u64,
    /// The first wrong cells, with the flag found and the one expected.
    pub(super) first: Vec<([u32; 3], i16, i16)>,
    /// Cells that the winding number decides; those of them that were looked at; those where it is too near to a half.
    pub(super) n_doubtful: [u64; 3],
}

/// The plane, number and first cell above of a crossing of a ray, and 1 for in or -1 for out.
type Crossing = (u32, u32, u32, i32);

pub(super) struct Check<'a> {
    pub(super) scene: &'a Scene,
    pub(super) mesh: &'a Mesh,
    /// The axes a, b and c.
    pub(super) axes: [usize; 3],
    /// Crossings of each body with the rays along c, which go through all slabs.
    pub(super) through: Vec<OnceLock<Vec<Crossing>>>,
    pub(super) seed: u64,
    pub(super) control: &'a Control,
}

impl Check<'_> {
    /// Holds all cells of some slabs to the job; of the doubtful ones as many as time allows, chosen at random.
    pub(super) fn all(&self, slabs: &[Range<u32>]) -> Result<Tally> {
        let counted = self.with_stride(slabs, u64::MAX)?;
        let n_angles = u128::from(counted.n_doubtful[0]) * self.scene.facets.len() as u128;
        if n_angles == 0 { Ok(counted) } else { self.with_stride(slabs, n_angles.div_ceil(ANGLES.into()) as u64) }
    }

    /// Looks at one doubtful cell of so many.
    fn with_stride(&self, slabs: &[Range<u32>], stride: u64) -> Result<Tally> {
        let tallies: Result<Vec<Tally>> = slabs.par_iter().map(|slab| self.slab(slab, stride)).collect();
        let mut all = Tally::default();
        for tally in tallies? {
            all.n_wrong += tally.n_wrong;
            all.first.extend(tally.first.into_iter().take(SHOWN - all.first.len()));
            (0..3).for_each(|kind| all.n_doubtful[kind] += tally.n_doubtful[kind]);
        }
        Ok(all)
    }

    fn slab(&self, slab: &Range<u32>, stride: u64) -> Result<Tally> {
        let mut tally = Tally::default();
        // the cells of a ray along b follow each other, then those rays along a
        let mut expected = vec![0; self.steps()[2] * slab.len()];
        for (rank, body) in self.scene.bodies.iter().enumerate() {
            self.control.check()?;
            let Some(policy) = body.open.filter(|&policy| policy != Open::Parity) else {
                self.cast(rank, usize::from(body.open.is_none()), slab, |at, _| expected[at] = body.flag);
                continue;
            };
            let mut votes = vec![0; expected.len()];
            (0..3).for_each(|along| self.cast(rank, along, slab, |at, vote| votes[at] += vote));
            for (at, votes) in votes.into_iter().enumerate().filter(|&(_, votes)| votes != 0) {
                let (n_in, n_even) = (votes % ODD, 3 - votes / ODD);
                let is_inside = match policy {
                    _ if n_in == 3 => Some(true),
                    Open::Vote => Some(2 * n_in > n_even),
                    _ => self.wound(body, self.cell(at, slab), stride, &mut tally),
                };
                if is_inside != Some(false) {
                    expected[at] = is_inside.map_or(UNKNOWN, |_| body.flag);
                }
            }
        }
        self.compare(&expected, slab, &mut tally).map(|()| tally)
    }

    /// From a cell of a slab to the next along a, b and c.
    fn steps(&self) -> [usize; 3] {
        let [n_a, n_b] = [0, 1].map(|k| self.mesh.lines.dims()[self.axes[k]] as usize);
        [n_b, 1, n_a * n_b]
    }

    /// Casts rays at a body along an axis, through a slab, and calls `vote` for the cells inside. A ray that does not leave the body as
    /// often as it enters is odd in all its cells, or, where such are counted as they are, inside up to where it last left.
    fn cast(&self, rank: usize, along: usize, slab: &Range<u32>, mut vote: impl FnMut(usize, u8)) {
        let (dims, bits) = (self.mesh.lines.dims(), self.scene.bits);
        let [numbered, across] = [[1, 2], [0, 2], [1, 0]][along];
        let rays = Rays { axes: [numbered, across, along].map(|k| self.axes[k]), dims, bits };
        // cells of the slab along each axis
        let cells = [0, 1, 2].map(|k| if k == 2 { slab.clone() } else { 0..dims[self.axes[k]] });
        let body = &self.scene.bodies[rank];
        let of_slab = OnceLock::new();
        let crossings = if along == 2 { &self.through[rank] } else { &of_slab }.get_or_init(|| {
            let mut crossings: Vec<Crossing> = Vec::new();
            for facet in &self.scene.facets[body.facets.clone()] {
                let planes = rays.reach(facet);
                for plane in planes.start.max(cells[across].start)..planes.end.min(cells[across].end) {
                    rays.cross(facet, plane, |ray, cell, step| crossings.push((plane, ray, cell, step)));
                }
            }
            crossings.sort_unstable();
            crossings
        });
        for of_ray in crossings.chunk_by(|one, next| (one.0, one.1) == (next.0, next.1)) {
            let (mut inside, mut count, mut begin) = (Vec::new(), 0, None);
            for of_cell in of_ray.chunk_by(|one, next| one.2 == next.2) {
                count += i64::from(of_cell.iter().map(|crossing| crossing.3).sum::<i32>());
                let cell = of_cell[0].2.clamp(cells[along].start, cells[along].end);
                match begin {
                    None if self.scene.is_inside(count) => begin = Some(cell),
                    Some(_) if !self.scene.is_inside(count) => inside.extend(begin.take().map(|at| (at..cell, INSIDE))),
                    _ => {}
                }
            }
            if begin.is_some() && body.open != Some(Open::Parity) {
                inside = vec![(cells[along].clone(), ODD)];
            }
            let (steps, [plane, ray]) = (self.steps(), [of_ray[0].0, of_ray[0].1]);
            let first = (plane - cells[across].start) as usize * steps[across] + ray as usize * steps[numbered];
            for (range, kind) in inside {
                range.for_each(|cell| vote(first + (cell - cells[along].start) as usize * steps[along], kind));
            }
        }
    }

    fn cell(&self, at: usize, slab: &Range<u32>) -> [u32; 3] {
        let [n_b, _, plane] = self.steps();
        let mut cell = [slab.start + (at / plane) as u32; 3];
        (cell[self.axes[0]], cell[self.axes[1]]) = ((at % plane / n_b) as u32, (at % n_b) as u32);
        cell
    }

    /// Whether a body holds a doubtful cell; None where nobody knows, or the cell is not one of those looked at.
    fn wound(&self, body: &Body, cell: [u32; 3], stride: u64, tally: &mut Tally) -> Option<bool> {
        tally.n_doubtful[0] += 1;
        let mixed = |hash: u64, index| (hash ^ u64::from(index)).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29);
        if !cell.into_iter().fold(self.seed, mixed).is_multiple_of(stride) {
            return None;
        }
        tally.n_doubtful[1] += 1;
        let facets = [&self.scene.facets[body.facets.clone()], &body.patches];
        let (winding, doubt) = winding(facets, cell, self.scene.bits, self.mesh.lines.smallest());
        if 0.5 - (winding - winding.round()).abs() <= doubt {
            tally.n_doubtful[2] += 1;
            return None;
        }
        Some(self.scene.is_inside(winding.round() as i64))
    }

    fn compare(&self, expected: &[i16], slab: &Range<u32>, tally: &mut Tally) -> Result<()> {
        let [n_b, _, plane] = self.steps();
        let [first_ray, end_ray] = [slab.start, slab.end].map(|index| u64::from(index) * n_b as u64);
        let mut ray = 0;
        self.mesh.columns.for_rays(first_ray..end_ray, |runs| {
            let (first, mut start, mut flag) = (ray / n_b * plane + ray % n_b, 0, 0);
            for &run in runs.iter().chain([&((plane / n_b) as u32 * 256)]) {
                let end = run as usize / 256;
                for at in (start..end).map(|a| first + a * n_b) {
                    if expected[at] != flag && expected[at] != UNKNOWN {
                        tally.n_wrong += 1;
                        tally.first.push((self.cell(at, slab), flag, expected[at]));
                        tally.first.truncate(SHOWN);
                    }
                }
                (start, flag) = (end, (run % 256) as i16);
            }
            ray += 1;
        })
    }
}
