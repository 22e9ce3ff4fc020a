//! Every cell of a mesh against its job, slab by slab.
//!
//! The runs of the mesh lie along an axis a; a slab is some planes of cells along a and b, one after the other along c. Rays along b
//! decide the cells of closed bodies; open ones are decided as their policy says, by rays along all three axes and the winding number.
//! Cells along surfaces are those that a facet touches, or that it crosses on a ray of one of the axes between two faces.
//! Cells of the mesh beyond the box are those of a halo, background or like the nearest.

use std::ops::Range;
use std::sync::OnceLock;

use hexcast::job::{Fill, HaloEdge, Open};
use hexcast::{Error, Result, control::Control, mesh::Mesh};
use rayon::prelude::*;

use super::{ray::Rays, scene::Body, scene::Scene, surface::winding, touched::touched};

/// Wrong cells that are named.
const SHOWN: usize = 5;
/// Solid angles that are computed: some ten or twenty seconds on two cores.
const ANGLES: u64 = 300_000_000;
/// In place of a flag: nobody knows.
const UNKNOWN: i16 = -1;
/// Votes of the rays through a cell: what one that is inside adds, and one that does not leave the body as often as it enters.
const INSIDE: u8 = 1;
const ODD: u8 = 16;

/// What was found.
#[derive(Default)]
pub(super) struct Tally {
    pub(super) n_wrong: u64,
    /// The first wrong cells, with the flag found and the one expected.
    pub(super) first: Vec<([u32; 3], i16, i16)>,
    /// Cells that the winding number decides; those of them that were looked at; those where it is too near to a half.
    pub(super) n_doubtful: [u64; 3],
}

/// The plane, number and first place above of a crossing of a ray, and 1 for in or -1 for out.
pub(super) type Crossing = (u32, u32, u32, i32);

pub(super) struct Check<'a> {
    pub(super) scene: &'a Scene,
    pub(super) mesh: &'a Mesh,
    /// The axes a, b and c.
    pub(super) axes: [usize; 3],
    /// Centres and faces of the cells of the mesh within the box, along a, b and c.
    pub(super) places: [[Vec<i32>; 2]; 3],
    /// Cells of the mesh before those, and what cells beyond the box have.
    pub(super) before: [usize; 3],
    pub(super) edge: HaloEdge,
    /// Crossings of each body with the rays along c, which go through all slabs, between centres and between faces.
    pub(super) through: Vec<[OnceLock<Vec<Crossing>>; 2]>,
    pub(super) seed: u64,
    pub(super) control: &'a Control,
}

impl<'a> Check<'a> {
    pub(super) fn new(
        scene: &'a Scene,
        mesh: &'a Mesh,
        (edge, seed): (HaloEdge, u64),
        control: &'a Control,
    ) -> Check<'a> {
        let rays = mesh.columns().rays();
        let axes = [rays.axis, rays.across[0], rays.across[1]];
        let places = axes.map(|axis| scene.grid.places(axis, scene.bits));
        let before = axes.map(|axis| (-scene.grid.cells[axis].start).max(0) as usize);
        let through = scene.bodies.iter().map(|_| Default::default()).collect();
        Check { scene, mesh, axes, places, before, edge, through, seed, control }
    }

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
        // gaps end within their width of a cell
        let n_c = self.places[2][0].len() as u32;
        let (first, last) = (self.plane(slab.start), self.plane(slab.end - 1));
        let width = self.scene.gaps.map_or(0, |(width, _)| width);
        let planes = first.saturating_sub(width)..last.saturating_add(width).saturating_add(1).min(n_c);
        // the cells of a ray along b follow each other, then those rays along a
        let mut expected = vec![0; self.steps()[2] * planes.len()];
        for (rank, body) in self.scene.bodies.iter().enumerate() {
            self.control.check()?;
            if !body.shell {
                self.inside(rank, &planes, &mut expected, (stride, &mut tally));
            }
            match body.fill {
                Fill::Centre => {}
                Fill::Separating => (0..3).for_each(|along| self.crossed(rank, along, &planes, &mut expected)),
                Fill::Conservative => self.touched(body, &planes, &mut expected),
                fill => return Err(Error::new("job-value", format!("{fill:?} is no fill that is checked"), "")),
            }
        }
        if let Some(gaps) = self.scene.gaps {
            let counts = [self.places[0][0].len(), self.places[1][0].len(), planes.len()];
            close_gaps(&mut expected, counts, self.steps(), gaps);
        }
        self.compare(&expected, (slab, &planes), &mut tally).map(|()| tally)
    }

    /// The plane of the box that a plane of the mesh is, or is nearest to.
    fn plane(&self, of_mesh: u32) -> u32 {
        (of_mesh as usize).saturating_sub(self.before[2]).min(self.places[2][0].len() - 1) as u32
    }

    /// Gives the cells within a body its flag, or those outside if it is inverted.
    fn inside(&self, rank: usize, planes: &Range<u32>, expected: &mut [i16], (stride, tally): (u64, &mut Tally)) {
        let body = &self.scene.bodies[rank];
        let policy = body.open.filter(|&policy| policy != Open::Parity);
        let along = usize::from(body.open.is_none());
        if policy.is_none() && !body.invert {
            return self.cast(rank, along, planes, |at, _| expected[at] = body.flag);
        }
        let mut votes = vec![0; expected.len()];
        match policy {
            Some(_) => (0..3).for_each(|along| self.cast(rank, along, planes, |at, vote| votes[at] += vote)),
            None => self.cast(rank, along, planes, |at, _| votes[at] = 3 * INSIDE),
        }
        for (at, votes) in votes.into_iter().enumerate().filter(|&(_, votes)| votes != 0 || body.invert) {
            let (n_in, n_even) = (votes % ODD, 3 - votes / ODD);
            let is_inside = match policy {
                _ if votes == 0 => Some(false),
                _ if n_in == 3 => Some(true),
                Some(Open::Vote) => Some(2 * n_in > n_even),
                _ => self.wound(body, self.cell(at, planes), stride, tally),
            };
            match is_inside {
                None => expected[at] = UNKNOWN,
                Some(is_inside) if is_inside != body.invert => expected[at] = body.flag,
                Some(_) => {}
            }
        }
    }

    /// From a cell of a slab to the next along a, b and c.
    fn steps(&self) -> [usize; 3] {
        let [n_a, n_b] = [0, 1].map(|k| self.places[k][0].len());
        [n_b, 1, n_a * n_b]
    }

    /// Cells of a slab along each axis.
    fn cells(&self, planes: &Range<u32>) -> [Range<u32>; 3] {
        [0, 1, 2].map(|k| if k == 2 { planes.clone() } else { 0..self.places[k][0].len() as u32 })
    }

    /// Rays along an axis through the centres of cells, whose crossings lie between centres, or between faces.
    fn rays(&self, along: usize, is_between_faces: bool) -> ([usize; 3], Rays<'_>) {
        let order = [[1, 2, 0], [0, 2, 1], [1, 0, 2]][along];
        let places = order.map(|k| &self.places[k][usize::from(is_between_faces && k == along)][..]);
        (order, Rays { axes: order.map(|k| self.axes[k]), places })
    }

    /// The crossings of a body's facets, without those that were missing if they lie between faces, with the rays of a slab.
    fn crossings(&self, rank: usize, along: usize, planes: &Range<u32>, is_between_faces: bool) -> Vec<Crossing> {
        let ([_, across, _], rays) = self.rays(along, is_between_faces);
        let (body, cells) = (&self.scene.bodies[rank], self.cells(planes)[across].clone());
        let n = if is_between_faces { body.n_own } else { body.facets.len() };
        let mut crossings: Vec<Crossing> = Vec::new();
        for facet in &self.scene.facets[body.facets.clone()][..n] {
            let reach = rays.reach(facet);
            for plane in reach.start.max(cells.start)..reach.end.min(cells.end) {
                rays.cross(facet, plane, |ray, place, step| crossings.push((plane, ray, place, step)));
            }
        }
        crossings.sort_unstable();
        crossings
    }

    /// Calls `act` with these crossings; those of rays along c are found once for all slabs.
    fn with_crossings(
        &self,
        (rank, along): (usize, usize),
        planes: &Range<u32>,
        is_between_faces: bool,
        act: impl FnOnce(&[Crossing]),
    ) {
        if along == 2 {
            let through = &self.through[rank][usize::from(is_between_faces)];
            act(through.get_or_init(|| self.crossings(rank, along, planes, is_between_faces)));
        } else {
            act(&self.crossings(rank, along, planes, is_between_faces));
        }
    }

    /// Casts rays at a body along an axis, through a slab, and calls `vote` for the cells inside. A ray that does not leave the body as
    /// often as it enters is odd in all its cells, or, where such are counted as they are, inside up to where it last left.
    fn cast(&self, rank: usize, along: usize, planes: &Range<u32>, mut vote: impl FnMut(usize, u8)) {
        let ([numbered, across, _], _) = self.rays(along, false);
        let (cells, steps, body) = (self.cells(planes), self.steps(), &self.scene.bodies[rank]);
        self.with_crossings((rank, along), planes, false, |crossings| {
            for of_ray in crossings.chunk_by(|one, next| (one.0, one.1) == (next.0, next.1)) {
                let (mut inside, mut count, mut begin) = (Vec::new(), 0, None);
                for of_cell in of_ray.chunk_by(|one, next| one.2 == next.2) {
                    count += i64::from(of_cell.iter().map(|crossing| crossing.3).sum::<i32>());
                    let cell = of_cell[0].2.clamp(cells[along].start, cells[along].end);
                    match begin {
                        None if self.scene.is_inside(count) => begin = Some(cell),
                        Some(_) if !self.scene.is_inside(count) => {
                            inside.extend(begin.take().map(|at| (at..cell, INSIDE)))
                        }
                        _ => {}
                    }
                }
                if begin.is_some() && body.open != Some(Open::Parity) {
                    inside = vec![(cells[along].clone(), ODD)];
                }
                let [plane, ray] = [of_ray[0].0, of_ray[0].1];
                let first = (plane - cells[across].start) as usize * steps[across] + ray as usize * steps[numbered];
                for (range, kind) in inside {
                    range.for_each(|cell| vote(first + (cell - cells[along].start) as usize * steps[along], kind));
                }
            }
        });
    }

    /// Gives the cells in which a body crosses a ray between two faces its flag.
    fn crossed(&self, rank: usize, along: usize, planes: &Range<u32>, expected: &mut [i16]) {
        let ([numbered, across, _], _) = self.rays(along, true);
        let (cells, steps, flag) = (self.cells(planes), self.steps(), self.scene.bodies[rank].flag);
        self.with_crossings((rank, along), planes, true, |crossings| {
            for &(plane, ray, face, _) in crossings.iter().filter(|of| cells[along].contains(&of.2.wrapping_sub(1))) {
                let of_ray = (plane - cells[across].start) as usize * steps[across] + ray as usize * steps[numbered];
                expected[of_ray + (face - 1 - cells[along].start) as usize * steps[along]] = flag;
            }
        });
    }

    /// Gives the cells that a body touches its flag.
    fn touched(&self, body: &Body, planes: &Range<u32>, expected: &mut [i16]) {
        let (cells, steps) = (self.cells(planes), self.steps());
        // along x, y and z
        let at = [0, 1, 2].map(|axis| self.axes.iter().position(|&of| of == axis).unwrap_or(axis));
        let (faces, ends) = (at.map(|k| &self.places[k][1][..]), at.map(|k| cells[k].clone()));
        for facet in &self.scene.facets[body.facets.clone()][..body.n_own] {
            touched(facet, faces, &ends, |cell| {
                let place = |axis: usize| (cell[axis] - ends[axis].start) as usize * steps[at[axis]];
                expected[(0..3).map(place).sum::<usize>()] = body.flag;
            });
        }
    }

    /// A cell of a slab, along a, b and c.
    fn cell(&self, at: usize, planes: &Range<u32>) -> [usize; 3] {
        let [n_b, _, plane] = self.steps();
        [at % plane / n_b, at % n_b, planes.start as usize + at / plane]
    }

    /// Whether a body holds a doubtful cell; None where nobody knows, or the cell is not one of those looked at.
    fn wound(&self, body: &Body, cell: [usize; 3], stride: u64, tally: &mut Tally) -> Option<bool> {
        tally.n_doubtful[0] += 1;
        let mut centre = [0; 3];
        (0..3).for_each(|k| centre[self.axes[k]] = self.places[k][0][cell[k]].into());
        let mixed = |hash: u64, place: i64| (hash ^ place as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29);
        if !centre.into_iter().fold(self.seed, mixed).is_multiple_of(stride) {
            return None;
        }
        tally.n_doubtful[1] += 1;
        let facets = [&self.scene.facets[body.facets.clone()], &body.patches];
        let (winding, doubt) = winding(facets, centre, self.scene.grid.unit);
        if 0.5 - (winding - winding.round()).abs() <= doubt {
            tally.n_doubtful[2] += 1;
            return None;
        }
        Some(self.scene.is_inside(winding.round() as i64))
    }

    fn compare(&self, expected: &[i16], (slab, planes): (&Range<u32>, &Range<u32>), tally: &mut Tally) -> Result<()> {
        let (rays, [n_a, n_b, _]) = (self.mesh.columns().rays(), [0, 1, 2].map(|k| self.places[k][0].len()));
        let (n_across, [step, _, of_plane]) = (rays.counts[0] as usize, self.steps());
        let mut ray = slab.start as usize * n_across;
        self.mesh.columns().for_rays(ray as u64..slab.end as u64 * n_across as u64, |runs| {
            let (b, c) = (ray % n_across, ray / n_across);
            let is_beyond = |k: usize, cell: usize, n| cell.wrapping_sub(self.before[k]) >= n;
            let is_background =
                self.edge == HaloEdge::Background && (is_beyond(1, b, n_b) || is_beyond(2, c, self.places[2][0].len()));
            let nearest = |k: usize, cell: usize, n: usize| cell.saturating_sub(self.before[k]).min(n - 1);
            let first = (self.plane(c as u32) - planes.start) as usize * of_plane + nearest(1, b, n_b);
            let mut hold = |a: usize, flag: i16, wanted: i16| {
                if wanted != flag && wanted != UNKNOWN {
                    tally.n_wrong += 1;
                    let mut cell = [0; 3];
                    [a, b, c].into_iter().zip(self.axes).for_each(|(index, axis)| cell[axis] = index as u32);
                    tally.first.push((cell, flag, wanted));
                    tally.first.truncate(SHOWN);
                }
            };
            let (mut start, mut flag) = (0, 0);
            for &run in runs.iter().chain([&(rays.depth * 256)]) {
                let end = run as usize / 256;
                for a in start..end {
                    let is_background = is_background || self.edge == HaloEdge::Background && is_beyond(0, a, n_a);
                    hold(a, flag, if is_background { 0 } else { expected[first + nearest(0, a, n_a) * step] });
                }
                (start, flag) = (end, (run % 256) as i16);
            }
            ray += 1;
        })
    }
}

/// Closes gaps: gives a flag to background cells that lie, along x, y or z, in a row of fewer than `width` between two flagged ones. All axes
/// are looked at before a cell changes, and beyond the mesh there is background without end. `counts` and `steps` are the number of cells along
/// each axis and how far the next one is. Beside cells that nobody knows nobody knows the gaps.
fn close_gaps(cells: &mut [i16], counts: [usize; 3], steps: [usize; 3], (width, flag): (u32, i16)) {
    let (mut closed, mut unsure) = (vec![false; cells.len()], vec![false; cells.len()]);
    for along in 0..3 {
        let [over, across] = [(along + 1) % 3, (along + 2) % 3];
        let starts =
            (0..counts[over]).flat_map(|i| (0..counts[across]).map(move |j| i * steps[over] + j * steps[across]));
        for start in starts {
            // the flagged cell before the background, if there is one
            let mut before = None;
            for at in 0..counts[along] {
                let cell = cells[start + at * steps[along]];
                if cell == 0 {
                    continue;
                }
                if let Some((last, known)) = before.filter(|&(last, _)| at - last <= width as usize) {
                    let is_known = known && cell != UNKNOWN;
                    let list = if is_known { &mut closed } else { &mut unsure };
                    (last + 1..at).for_each(|at| list[start + at * steps[along]] = true);
                }
                before = Some((at, cell != UNKNOWN));
            }
        }
    }
    for (cell, (is_closed, is_unsure)) in
        cells.iter_mut().zip(closed.into_iter().zip(unsure)).filter(|(cell, _)| **cell == 0)
    {
        *cell = if is_closed {
            flag
        } else if is_unsure {
            UNKNOWN
        } else {
            0
        };
    }
}
