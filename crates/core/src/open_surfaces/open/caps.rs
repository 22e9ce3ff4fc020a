//! Caps: triangles that close the holes of a surface, and how far their solid angle moves its winding number.
//!
//! # Theory
//! Loops of open edges -> caps; caps, cells -> [`Shift`]s. With theta(P) the solid angle of all caps at P over 4 pi, a surface
//! whose winding number is w has the winding number w + theta together with its caps. That is an integer n, so round(w) =
//! n + m with m = floor(1/2 - theta). m is 0 wherever |theta| < 1/2, which is nearly everywhere.
//!
//! A cell has the m of the sum of theta over all triangles, in f64, in their order. Nearly all cells have it without that sum, from bounds:
//!
//! - The triangles lie in clusters, a tree (`tree`), as in Barill, Dickson, Schmidt, Levin and Jacobson (Fast winding numbers for soups and clouds,
//!   2018). There, far clusters are replaced by their first derivatives; here they are expanded to a degree, and the rest
//!   is bounded. With A the area of a cluster, q the sum of its reach and that of a block of cells over their distance D, it is at most
//!   A / (4 pi D^2) q^p ((p + 3/2) / (1 - q) + q / (1 - q)^2), with p the degree (`harmonics` proves it).
//! - Of a triangle of area A at a distance of at least d from every centre of a block of half diagonal r, theta differs from its value at
//!   the middle by at most A r / (2 pi d^3), and from that with its gradient by at most 3 A r^2 / (4 pi d^4): the integrand n.x / |x|^3, a
//!   dipole, has a k-th derivative of at most (k + 1)! / |x|^(k + 2).
//! - A sum of n numbers in f64 is off by at most n / 2^53 of the sum of their magnitudes, in any order.
//!
//! Where the sum of these leaves m in no doubt, a whole block has it; else the block is split in eight, down to one cell. A cluster that
//! is far from a block becomes part of the expansion around its middle, which goes on to its parts, and is not looked at again. First all
//! are expanded to a low degree, which decides nearly all cells and costs little. Cells that are in doubt by these are looked at again with terms of
//! high degree, more closely each time, in blocks where there are many, and what is still in doubt has the exact sum. So every cell has the m that it has by
//! itself, whatever the blocks.
//!
//! Where as much of a surface is missing as is there, theta is a half all through it, but for what the snap moves. So the threshold is not
//! 1/2 but 1/2 + 10^-9: a half is closed, and what the snap moves decides nothing.
//!
//! Theta jumps by 1 where a centre passes a triangle. So sides are exact, and of the plane itself the one that the tie rule of rays says,
//! the centre a little before itself; theta is that of a point that is moved by a fraction of the snap's unit, and 1 more or less where
//! a triangle lies between the two. What is nearer than that is never expanded.
//!
//! # Practice
//! [`shifts`] works in steps of some blocks, between which it rests.
//! Cost: some 500 to 1,000 bytes a triangle; O(log n) clusters a block, 0.3 microseconds each of low degree and 5 of high; around many holes 10 to
//! 150 microseconds a cell.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::f64::consts::PI;
use std::ops::RangeInclusive;

use glam::DVec3;

use crate::base::control::{CancelToken, Control, HoleWork, Paced};
use crate::base::error::Result;
use crate::base::parallel::*;
use crate::grid::frame::SnappedFacet;

mod harmonics;
mod tree;
mod triangle;

use harmonics::{HIGH, LOW, Terms, add_around, add_slope, degree, far, moved, near, tail, value_and_change};
use tree::{Cluster, Near, Tree};
use triangle::{BEFORE, Triangle, Turn};

/// Most of the distance of a cluster from a block that the reaches of both may be, for it to be expanded, one look after the other. The first
/// is with terms of low degree, the others are with those of high; they leave in doubt some tenths of theta, 10^-4, 10^-7 and 10^-10.
const FIRST_LOOK: f64 = 0.4;
const CLOSER_LOOKS: [f64; 3] = [0.4, 0.25, 0.15];
/// Triangles this many half diagonals away from a block are evaluated once for all its cells, where terms of low degree are enough.
const FAR_TRIANGLE: f64 = 5.0;
/// Theta of a hole that is as much open as closed: of two halves that differ by less than what the snap moves both, the closed one. A centre
/// in the plane of a cap stands 5/32 of a unit before itself, at most, so that its theta is 2e-9 from a half at least.
const HALF: f64 = 0.5 + 1e-9;
/// More than the rounding errors of expansions.
const ROUNDING: f64 = 1e-11;
/// Most cells of a block that is decided without a rest.
const OF_STEP: u64 = 512;
/// Cells of a block that take a closer look together.
const SHARED: RangeInclusive<u64> = 28..=OF_STEP;
/// Blocks that a core looks at between two rests; each asks whether it is cancelled, too.
const BLOCKS: usize = if cfg!(target_arch = "wasm32") { 1 } else { 64 };
/// Corners that are cut off between two rests.
const CORNERS: usize = if cfg!(target_arch = "wasm32") { 1 << 13 } else { 1 << 17 };
/// Boxes of cells that a core begins with, and triangles that it evaluates, between two rests.
const BOXES: usize = 64;
const TRIANGLES: usize = 1 << 19;

/// Cells of a box, its end exclusive, whose rounded winding number is that of surface and caps plus m, where m is not 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shift {
    pub(super) low: [u32; 3],
    pub(super) high: [u32; 3],
    pub(super) m: i32,
}

/// Closes each loop with triangles, each of which cuts off the corner whose neighbours are nearest to each other: so the
/// triangles are small, and few of them are near any cell.
///
/// # Errors
/// `cancelled`.
pub(super) async fn caps(loops: &[Vec<[i32; 3]>], control: &Control) -> Result<Vec<SnappedFacet>> {
    let (mut caps, mut paced) = (Vec::new(), Paced::new(control, CORNERS));
    for corners in loops {
        let n = corners.len();
        let mut around: Vec<[usize; 2]> = (0..n).map(|at| [(at + n - 1) % n, (at + 1) % n]).collect();
        let length = |[one, other]: [usize; 2]| -> i64 {
            (0..3).map(|axis| (i64::from(corners[one][axis]) - i64::from(corners[other][axis])).pow(2)).sum()
        };
        let ear = |at: usize, around: &[[usize; 2]]| Reverse((length(around[at]), at, around[at]));
        let mut ears: BinaryHeap<_> = (0..n).map(|at| ear(at, &around)).collect();
        let mut n_left = n;
        while let Some(Reverse((_, at, [before, after]))) = ears.pop().filter(|_| n_left >= 3) {
            paced.done(1).await?;
            if around[at] != [before, after] {
                continue;
            }
            caps.push([after, at, before].map(|corner| corners[corner]));
            // the corner that was cut off is between no others
            around[at] = [at; 2];
            around[before][1] = after;
            around[after][0] = before;
            n_left -= 1;
            ears.extend([before, after].map(|at| ear(at, &around)));
        }
    }
    Ok(caps)
}

/// A box of cells.
pub(super) struct Cells<'a> {
    /// The first, and their number.
    pub(super) first: [u32; 3],
    pub(super) dims: [u32; 3],
    /// The centre of a cell along an axis, in units of the snap from the centre of cell 0.
    pub(super) centre: &'a (dyn Fn(usize, u32) -> i64 + Sync),
}

/// Finds the cells of a box where m is not 0, counted from its first. Caps are counted from cell 0, so that numbers, and with them m, are
/// the same whatever the box. The smallest cell is 2^`fraction_bits` units of the snap; `sizes` are its lengths along the axes, in any
/// unit.
///
/// # Errors
/// `cancelled`.
pub(super) async fn shifts(
    caps: &[SnappedFacet],
    cells: &Cells<'_>,
    fraction_bits: u32,
    sizes: [f64; 3],
    control: &Control,
) -> Result<Vec<Shift>> {
    let CapAngles { triangles, unit, scale, before } = CapAngles::new(caps, fraction_bits, sizes);
    if triangles.is_empty() || cells.dims.contains(&0) {
        return Ok(Vec::new());
    }
    let n_cells: u64 = cells.dims.map(u64::from).iter().product();
    let area = triangles.iter().map(|triangle| triangle.area).sum::<f64>();
    // a ball half of whose surface is missing
    let doubtful = 4.0 / 3.0 * PI * libm::pow(area / (2.0 * PI), 1.5) / scale.element_product();
    control.begin_holes(HoleWork::new(triangles.len() as u64, n_cells.min(doubtful as u64)));
    let tree = Tree::new(&triangles, control).await?;
    let first = cells.first;
    let field = Field { triangles, tree, centre: cells.centre, unit, scale, before, cancel: &control.cancel };
    let mut found =
        Found { doubtful: vec![[first, [0, 1, 2].map(|axis| first[axis] + cells.dims[axis])]], ..Found::default() };
    field.look::<LOW>(&[FIRST_LOOK], &mut found, control).await?;
    if !found.doubtful.is_empty() {
        field.look::<HIGH>(&CLOSER_LOOKS, &mut found, control).await?;
    }
    field.alone(&mut found, control).await?;
    let from_first = |cell: [u32; 3]| [0, 1, 2].map(|axis| cell[axis] - first[axis]);
    let of_box = |shift: Shift| Shift { low: from_first(shift.low), high: from_first(shift.high), ..shift };
    Ok(found.shifts.into_iter().map(of_box).collect())
}

/// The triangles of caps, whose solid angle is summed at single points.
pub(crate) struct CapAngles {
    triangles: Vec<Triangle>,
    unit: f64,
    scale: DVec3,
    before: DVec3,
}

impl CapAngles {
    /// Takes caps, counted from cell 0; `fraction_bits` and `sizes` are those of [`shifts`].
    pub(crate) fn new(caps: &[SnappedFacet], fraction_bits: u32, sizes: [f64; 3]) -> CapAngles {
        let unit = 1.0 / f64::from(1u32 << fraction_bits);
        let scale = DVec3::from(sizes) / sizes[0];
        let place = |corner: [i32; 3]| DVec3::from(corner.map(f64::from)) * unit * scale;
        let triangles = caps.iter().filter_map(|&cap| Triangle::new(cap, place)).collect();
        let before = DVec3::from(BEFORE.map(f64::from)) / 32.0 * unit * scale;
        CapAngles { triangles, unit, scale, before }
    }

    pub(crate) fn n_triangles(&self) -> usize {
        self.triangles.len()
    }

    /// m of a point, in units of the snap, by the sum over all triangles, in their order: that of a cell with its centre there.
    pub(crate) fn shift_at(&self, point: [i32; 3]) -> i32 {
        let place = DVec3::from(point.map(f64::from)) * self.unit * self.scale - self.before;
        let theta = |triangle: &Triangle| triangle.theta_of_centre(point.map(i64::from), place);
        (HALF - self.triangles.iter().map(theta).fold(0.0, |sum, theta| sum + theta)).floor() as i32
    }
}

/// What is known of some cells.
#[derive(Default)]
struct Found {
    shifts: Vec<Shift>,
    /// Boxes of cells that need a closer look.
    doubtful: Vec<[[u32; 3]; 2]>,
}

impl Found {
    fn add(&mut self, Found { mut shifts, mut doubtful }: Found) {
        self.shifts.append(&mut shifts);
        self.doubtful.append(&mut doubtful);
    }

    fn note(&mut self, low: [u32; 3], high: [u32; 3], m: i32) {
        if m != 0 {
            self.shifts.push(Shift { low, high, m });
        }
    }
}

/// Theta of some triangles at a point, how far it may be wrong, and at least the sum of all magnitudes.
#[derive(Clone, Copy, Default)]
struct Known {
    theta: f64,
    error: f64,
    magnitude: f64,
}

impl Known {
    fn add(&mut self, theta: f64, error: f64, magnitude: f64) {
        self.theta += theta;
        self.error += error;
        self.magnitude += magnitude;
    }
}

/// Some cells, and what is known of all triangles there.
struct Block<const N: usize> {
    low: [u32; 3],
    high: [u32; 3],
    middle: DVec3,
    half: DVec3,
    /// Theta of what is far, if anything is, around the middle; `known` has its error and magnitude.
    local: Option<Box<Terms<N>>>,
    known: Known,
    near: Vec<Near>,
}

impl<const N: usize> Block<N> {
    fn n_cells(&self) -> u64 {
        (0..3).map(|axis| u64::from(self.high[axis] - self.low[axis])).product()
    }
}

/// The caps, and the cells around them.
struct Field<'a> {
    triangles: Vec<Triangle>,
    tree: Tree,
    centre: &'a (dyn Fn(usize, u32) -> i64 + Sync),
    /// Cells a unit of the snap.
    unit: f64,
    scale: DVec3,
    before: DVec3,
    cancel: &'a CancelToken,
}

impl Field<'_> {
    /// Decides what is in doubt with terms of one degree, as far as that goes, more closely each time.
    async fn look<const N: usize>(&self, looks: &[f64], found: &mut Found, control: &Control) -> Result<()> {
        let moments = self.tree.expand::<N>(&self.triangles, control).await?;
        for (at, &far) in looks.iter().enumerate() {
            let is_last = N == HIGH && at + 1 == looks.len();
            let boxes = std::mem::take(&mut found.doubtful);
            Search { field: self, moments: &moments, far, is_last }.boxes(&boxes, found, control).await?;
        }
        Ok(())
    }

    /// Decides the cells that are left, by the exact sum.
    async fn alone(&self, found: &mut Found, control: &Control) -> Result<()> {
        let n_of_step = (TRIANGLES / self.triangles.len()).max(1) * current_num_threads();
        for cells in std::mem::take(&mut found.doubtful).chunks(n_of_step) {
            let shifts: Vec<i32> = cells.par_iter().map(|&[cell, _]| self.exact(cell)).collect();
            cells.iter().zip(shifts).for_each(|(&[low, high], m)| found.note(low, high, m));
            control.rest().await?;
        }
        Ok(())
    }

    /// m of a cell by the sum over all triangles, in their order: what all else agrees with.
    fn exact(&self, cell: [u32; 3]) -> i32 {
        let (centre, point) = (self.centre_of(cell), self.extent(cell, cell.map(|c| c + 1)).0);
        let theta = |triangle: &Triangle| triangle.theta_of_centre(centre, point);
        let mut all = 0.0;
        for some in self.triangles.chunks(1 << 12) {
            if self.cancel.is_cancelled() {
                return 0;
            }
            all = some.iter().map(theta).fold(all, |sum, theta| sum + theta);
        }
        (HALF - all).floor() as i32
    }

    /// The middle of the points before the centres of some cells, and half of their extent.
    fn extent(&self, low: [u32; 3], high: [u32; 3]) -> (DVec3, DVec3) {
        let point = |cell: [u32; 3]| {
            DVec3::from(self.centre_of(cell).map(|units| units as f64)) * self.unit * self.scale - self.before
        };
        let (first, last) = (point(low), point(high.map(|end| end - 1)));
        ((first + last) * 0.5, (last - first) * 0.5)
    }

    fn centre_of(&self, cell: [u32; 3]) -> [i64; 3] {
        [0, 1, 2].map(|axis| (self.centre)(axis, cell[axis]))
    }

    /// m, if it is the same for every theta that is wrong by at most so much. A sum of n numbers in any order is off by at most n / 2^53 of
    /// the sum of their magnitudes, and theta of a triangle by some 2^-53.
    fn shift(&self, known: &Known) -> Option<i32> {
        let n = self.triangles.len() as f64 + 64.0;
        // what lies in near clusters adds less than 0.5 to the magnitude
        let error = known.error + ROUNDING + n * f64::EPSILON * (2.0 + known.magnitude);
        let [low, high] = [-1.0, 1.0].map(|sign| (HALF - known.theta + sign * error).floor());
        (low == high).then_some(low as i32)
    }
}

/// A look at cells with N terms.
struct Search<'a, const N: usize> {
    field: &'a Field<'a>,
    /// Of the clusters that have them.
    moments: &'a [Option<Box<Terms<N>>>],
    /// Most of the distance of a cluster that the reaches may be.
    far: f64,
    is_last: bool,
}

impl<const N: usize> Search<'_, N> {
    /// Decides all cells of some boxes but those that need a closer look.
    async fn boxes(&self, boxes: &[[[u32; 3]; 2]], done: &mut Found, control: &Control) -> Result<()> {
        let (mut left, n_cores) = (Vec::new(), current_num_threads());
        let mut add = |steps: Vec<(Found, Vec<Block<N>>)>, left: &mut Vec<Block<N>>| {
            for (found, mut parts) in steps {
                done.add(found);
                left.append(&mut parts);
            }
        };
        for some in boxes.chunks(BOXES * n_cores) {
            add(some.par_iter().map(|&[low, high]| self.step(self.first(low, high))).collect(), &mut left);
            control.rest().await?;
            while !left.is_empty() {
                let some = left.split_off(left.len().saturating_sub(BLOCKS * n_cores));
                add(some.into_par_iter().map(|block| self.step(block)).collect(), &mut left);
                control.rest().await?;
            }
        }
        Ok(())
    }

    /// Decides a block, or gives its parts.
    fn step(&self, block: Block<N>) -> (Found, Vec<Block<N>>) {
        let mut found = Found::default();
        if block.n_cells() <= OF_STEP {
            self.descend(&block, &mut found);
            return (found, Vec::new());
        }
        match self.of_block(&block) {
            Some(m) => {
                found.note(block.low, block.high, m);
                (found, Vec::new())
            }
            None => (found, parts(block.low, block.high).map(|[low, high]| self.part(&block, low, high)).collect()),
        }
    }

    fn descend(&self, block: &Block<N>, found: &mut Found) {
        if self.field.cancel.is_cancelled() {
            return;
        }
        if block.n_cells() == 1 {
            match self.of_cell(block.low, block) {
                Some(m) => found.note(block.low, block.high, m),
                None => found.doubtful.push([block.low, block.high]),
            }
            return;
        }
        if let Some(m) = self.of_block(block) {
            return found.note(block.low, block.high, m);
        }
        if self.is_vague(block) {
            return found.doubtful.push([block.low, block.high]);
        }
        for [low, high] in parts(block.low, block.high) {
            if (0..3).any(|axis| high[axis] - low[axis] > 1) {
                self.descend(&self.part(block, low, high), found);
            } else if let Some(m) = self.of_cell(low, block) {
                found.note(low, high, m);
            } else {
                found.doubtful.push([low, high]);
            }
        }
    }

    /// Whether so many cells of a block need a closer look that they may share it: two of them do.
    fn is_vague(&self, block: &Block<N>) -> bool {
        let cell = |part: u32| [0, 1, 2].map(|axis| block.low[axis] + (block.high[axis] - block.low[axis]) * part / 4);
        !self.is_last
            && SHARED.contains(&block.n_cells())
            && [1, 3].iter().all(|&part| self.of_cell(cell(part), block).is_none())
    }

    /// Some cells, of which nothing is known yet.
    fn first(&self, low: [u32; 3], high: [u32; 3]) -> Block<N> {
        let (middle, half) = self.field.extent(low, high);
        let near = vec![self.field.tree.root()];
        let block = Block { low, high, middle, half, local: None, known: Known::default(), near };
        if block.n_cells() == 1 { block } else { self.part(&block, low, high) }
    }

    /// A part of a block: what is far from it becomes part of its expansion.
    fn part(&self, block: &Block<N>, low: [u32; 3], high: [u32; 3]) -> Block<N> {
        let (middle, half) = self.field.extent(low, high);
        let (field, tree) = (self.field, &self.field.tree);
        let (radius, mut known) = (half.length(), block.known);
        let mut local = block.local.as_ref().map(|local| Box::new(moved(local, middle - block.middle)));
        let none = || Box::new(Terms::zero());
        let (mut left, mut near) = (block.near.clone(), Vec::new());
        while let Some(item) = left.pop() {
            match item {
                Near::Cluster(index) => {
                    let cluster = &tree.clusters[index as usize];
                    let step = middle - cluster.centre;
                    if let Some((moments, error)) = self.moments(index, step.length(), radius) {
                        add_around(local.get_or_insert_with(none), moments, step);
                        known.add(0.0, error, magnitude(cluster.area, step.length() - cluster.reach - radius));
                    } else if cluster.reach > radius {
                        tree.open(cluster, &mut left);
                    } else {
                        near.push(item);
                    }
                }
                Near::Triangle(index) => {
                    let triangle = &field.triangles[index as usize];
                    let distance = triangle.distance(middle, half);
                    let is_far = N == LOW && distance >= FAR_TRIANGLE * radius;
                    if is_far && distance > field.before.length() {
                        add_slope(local.get_or_insert_with(none), triangle.theta(middle), triangle.gradient(middle));
                        let area = triangle.area.min(PI * distance * distance);
                        let error = 3.0 * area * radius * radius / (4.0 * PI * distance.powi(4));
                        known.add(0.0, error, magnitude(triangle.area, distance));
                    } else {
                        near.push(item);
                    }
                }
            }
        }
        Block { low, high, middle, half, local, known, near }
    }

    /// m, if it is the same in a whole block.
    fn of_block(&self, block: &Block<N>) -> Option<i32> {
        let field = self.field;
        let (radius, mut known) = (block.half.length(), block.known);
        let (theta, mut change) = block.local.as_ref().map_or((0.0, 0.0), |local| value_and_change(local, radius));
        for &item in &block.near {
            change += match item {
                Near::Cluster(index) => {
                    let Cluster { centre, reach, area, .. } = field.tree.clusters[index as usize];
                    magnitude(area, (centre - block.middle).length() - reach - radius)
                }
                Near::Triangle(index) => {
                    let triangle = &field.triangles[index as usize];
                    let distance = triangle.distance(block.middle, block.half);
                    let is_clear = distance > field.before.length();
                    let area = triangle.area.min(2.0 * PI * distance * distance);
                    if is_clear { area * radius / (2.0 * PI * distance.powi(3)) } else { f64::INFINITY }
                }
            };
            if change >= 0.5 {
                return None;
            }
        }
        let mut turn = Turn::new();
        for &item in &block.near {
            if let Near::Triangle(index) = item {
                turn.add(&field.triangles[index as usize], block.middle);
            }
        }
        known.add(theta + turn.theta(), change, change + turn.magnitude);
        field.shift(&known)
    }

    /// m of a cell of a block, if it is beyond doubt.
    fn of_cell(&self, cell: [u32; 3], block: &Block<N>) -> Option<i32> {
        let (field, tree) = (self.field, &self.field.tree);
        let place = field.extent(cell, cell.map(|c| c + 1)).0;
        let (centre, mut known, mut turn) = (field.centre_of(cell), block.known, Turn::new());
        known.theta = block.local.as_ref().map_or(0.0, |local| near(local, place - block.middle));
        let mut left = block.near.clone();
        while let Some(item) = left.pop() {
            match item {
                Near::Cluster(index) => {
                    let cluster = &tree.clusters[index as usize];
                    let step = place - cluster.centre;
                    match self.moments(index, step.length(), 0.0) {
                        Some((moments, error)) => {
                            let magnitude = magnitude(cluster.area, step.length() - cluster.reach);
                            known.add(far(moments, step), error, magnitude);
                        }
                        None => tree.open(cluster, &mut left),
                    }
                }
                Near::Triangle(index) => {
                    let triangle = &field.triangles[index as usize];
                    if triangle.is_beyond(2.0 * field.before.length(), place) {
                        turn.add(triangle, place);
                    } else {
                        let theta = triangle.theta_of_centre(centre, place);
                        known.add(theta, 0.0, theta.abs());
                    }
                }
            }
        }
        known.add(turn.theta(), 0.0, turn.magnitude);
        field.shift(&known)
    }

    /// The moments of a cluster and how far their expansion may be wrong, if it is far enough from a block to be expanded, and from the
    /// points before its centres.
    fn moments(&self, cluster: u32, distance: f64, radius: f64) -> Option<(&Terms<N>, f64)> {
        let moments = self.moments[cluster as usize].as_deref()?;
        let cluster = &self.field.tree.clusters[cluster as usize];
        let reach = cluster.reach + radius;
        let is_far = reach <= self.far * distance && distance - reach > self.field.before.length();
        is_far.then(|| (moments, tail(degree(N), cluster.area, reach, distance)))
    }
}

/// The parts of a block: it is halved along each axis where it can be.
fn parts(low: [u32; 3], high: [u32; 3]) -> impl Iterator<Item = [[u32; 3]; 2]> {
    let middles = [0, 1, 2].map(|axis| low[axis] + (high[axis] - low[axis]).div_ceil(2));
    let part = move |part: usize| {
        let is_upper = [0, 1, 2].map(|axis| part >> axis & 1 == 1);
        let low = [0, 1, 2].map(|axis| if is_upper[axis] { middles[axis] } else { low[axis] });
        let high = [0, 1, 2].map(|axis| if is_upper[axis] { high[axis] } else { middles[axis] });
        [low, high]
    };
    (0..8).map(part).filter(|[low, high]| (0..3).all(|axis| low[axis] < high[axis]))
}

/// At most theta of triangles of an area at a distance of at least so much.
fn magnitude(area: f64, distance: f64) -> f64 {
    area / (4.0 * PI * distance.max(0.0).powi(2))
}

#[cfg(test)]
mod tests;
