//! Links through periodic sides: from a cell at one side of the box to one at the other.
//!
//! # Theory
//! Such a link has two halves, one before each of the two sides, which its middle lies on. In a frame with a cell more at both ends they are halves of two
//! links that lead out of the box: from the one cell forwards, from the other backwards. Each half is walked from its cell to the side. A link from
//! the first cell meets the first crossing of its own half behind which the flag is no fluid; else the side, where that of the other half is none there;
//! else a crossing of the other half, the last of its walk first, on whose side towards the other cell the flag is none. What lies at the side
//! itself, such as the ends of a pipe, is in neither half. A wall at the side that no facet tells has q = 1/2 and no facet.
//!
//! Cost: a cast for each pair of directions that leads through a side, with as many rays as the others; the flags of two planes of cells for each side.

use super::Link;
use super::field::{Field, place};
use super::sheared::Sheared;
use super::walk::{HalfHit, Walk};
use hexcast_core::base::control::Control;
use hexcast_core::base::error::{Error, Result};
use hexcast_core::base::parallel::*;
use hexcast_core::base::sort::sort_by_key;
use hexcast_core::cells::flags::flags_of_box;
use hexcast_core::grid::frame::Frame;
use hexcast_core::input::job::{LinksJob, Stencil};
use hexcast_core::stages::cpu::Strips;

/// Of a wall at the side.
const MIDDLE: f32 = 0.5;

/// The halves of links before sides: key and crossings, in the order of keys.
type Halves = Vec<(u64, Vec<HalfHit>)>;

/// What lies at the end of links.
struct Ends<'a> {
    halves: &'a Halves,
    directions: &'a [[i8; 3]],
    is_fluid: &'a [bool; 256],
}

impl Field<'_> {
    /// The links through periodic sides, in no order.
    pub(super) async fn periodic_links(
        &self,
        job: &LinksJob,
        is_fluid: &[bool; 256],
        control: &Control,
    ) -> Result<Vec<Link>> {
        if self.frame.is_graded() {
            let message = "cells differ in size, and links through periodic sides need equal ones";
            return Err(Error::new("lines-graded", message, "use equal cells, or leave out periodic"));
        }
        let halves = self.halves(job.stencil, is_fluid, control).await?;
        let directions = job.stencil.directions();
        let ends = Ends { halves: &halves, directions: &directions, is_fluid };
        let mut links = Vec::new();
        for axis in (0..3).filter(|&axis| self.periodic[axis]) {
            for is_end in [false, true] {
                control.rest().await?;
                self.through_side(axis, is_end, &ends, &mut links)?;
            }
        }
        Ok(links)
    }

    /// What lies on the halves of links between the centres of cells and periodic sides.
    async fn halves(&self, stencil: Stencil, is_fluid: &[bool; 256], control: &Control) -> Result<Halves> {
        let mut frame: Frame = self.frame.clone();
        for axis in (0..3).filter(|&axis| self.periodic[axis]) {
            frame = frame.with_mirrored_ends(axis);
        }
        let field = Field { frame: &frame, ..*self };
        let dims = self.frame.dims;
        // the cell of the box, if it is one
        let cell = |cell: [u32; 3]| {
            let mut of_box = cell;
            for axis in 0..3 {
                of_box[axis] = cell[axis].checked_sub(u32::from(self.periodic[axis]))?;
            }
            (0..3).all(|axis| of_box[axis] < dims[axis]).then_some(of_box)
        };
        let mut halves = Vec::new();
        for (pair, both) in stencil.directions()[1..].chunks_exact(2).enumerate() {
            if (0..3).all(|axis| !self.periodic[axis] || both[0][axis] == 0) {
                continue;
            }
            let sheared = Sheared::new(&frame, both[0], [[0; 3], frame.dims]);
            let (forward, backward) = (2 * pair as u8 + 1, 2 * pair as u8 + 2);
            let directions = if sheared.is_backward { [backward, forward] } else { [forward, backward] };
            let walk = Walk { field: &field, sheared: &sheared, is_fluid, directions };
            let half_of = |[low, high]: [[u32; 3]; 2]| match (cell(low), cell(high)) {
                (Some(low), None) => Some((place(low, directions[0], dims), low, false)),
                (None, Some(high)) => Some((place(high, directions[1], dims), high, true)),
                _ => None,
            };
            let mut strips = Strips::new(&sheared.cast(self.rule), None);
            while let Some(crossings) = strips.crossings(true, control)? {
                let found: Result<Vec<Halves>> = crossings.par_iter().map(|some| walk.halves(some, half_of)).collect();
                halves.extend(found?.into_iter().flatten());
                control.rest().await?;
            }
        }
        sort_by_key(&mut halves, |(key, _)| *key);
        Ok(halves)
    }

    /// The links from cells at a side of the box through it.
    fn through_side(&self, axis: usize, is_end: bool, ends: &Ends<'_>, links: &mut Vec<Link>) -> Result<()> {
        let dims = self.frame.dims;
        let plane = |at: u32| {
            let mut cells = dims.map(|n| 0..n);
            cells[axis] = at..at + 1;
            flags_of_box(&*self.columns.for_slab(&cells[self.columns.rays().axis])?, &cells)
        };
        let (last, step) = (dims[axis] - 1, if is_end { 1 } else { -1 });
        let [here, there] = if is_end { [last, 0] } else { [0, last] };
        let (of_here, of_there) = (plane(here)?, plane(there)?);
        let mut n = dims.map(|n| n as usize);
        n[axis] = 1;
        let index = |mut cell: [u32; 3]| {
            cell[axis] = 0;
            cell[0] as usize + n[0] * (cell[1] as usize + n[1] * cell[2] as usize)
        };
        for (at, _) in of_here.iter().enumerate().filter(|(_, flag)| ends.is_fluid[usize::from(**flag)]) {
            let mut cell = [at % n[0], at / n[0] % n[1], at / (n[0] * n[1])].map(|at| at as u32);
            cell[axis] = here;
            for (direction, along) in (0u8..).zip(ends.directions).filter(|(_, along)| along[axis] == step) {
                let Some(other) = self.wrapped(axis, cell, *along) else { continue };
                let to_flag = of_there[index(other)];
                // opposites follow each other
                let opposite = if direction % 2 == 1 { direction + 1 } else { direction - 1 };
                let halves = [place(cell, direction, dims), place(other, opposite, dims)].map(|key| ends.half(key));
                if let Some((q, facet, geometry)) = ends.wall(halves, to_flag) {
                    links.push(Link { cell, q, facet, geometry, direction, flag: to_flag });
                }
            }
        }
        Ok(())
    }

    /// The cell to which a link through a side across an axis leads; None where it leaves the box, or is one of another side, too, whose axis comes before.
    fn wrapped(&self, axis: usize, cell: [u32; 3], along: [i8; 3]) -> Option<[u32; 3]> {
        let mut other = [0; 3];
        for of in 0..3 {
            let n = i64::from(self.frame.dims[of]);
            let at = i64::from(cell[of]) + i64::from(along[of]);
            if !(0..n).contains(&at) && (!self.periodic[of] || of < axis) {
                return None;
            }
            other[of] = at.rem_euclid(n) as u32;
        }
        Some(other)
    }
}

impl Ends<'_> {
    fn half(&self, key: u64) -> &[HalfHit] {
        let found = self.halves.binary_search_by_key(&key, |(key, _)| *key);
        found.map_or(&[], |at| &self.halves[at].1)
    }

    fn is_wall(&self, flag: u8) -> bool {
        !self.is_fluid[usize::from(flag)]
    }

    /// Where a link of two halves meets a wall: q, facet and geometry; the other half is walked from the other cell, whose flag is given.
    fn wall(&self, [own, other]: [&[HalfHit]; 2], to_flag: u8) -> Option<(f32, i32, i16)> {
        if let Some(hit) = own.iter().find(|hit| self.is_wall(hit.flag)) {
            return Some((hit.q[0], hit.facet, hit.geometry));
        }
        if self.is_wall(other.last().map_or(to_flag, |hit| hit.flag)) {
            return Some((MIDDLE, -1, -1));
        }
        // behind the first crossing is the other cell
        let behind = |at: usize| at.checked_sub(1).map_or(to_flag, |before| other[before].flag);
        let at = (0..other.len()).rev().find(|&at| self.is_wall(behind(at)))?;
        Some((other[at].q[1], other[at].facet, other[at].geometry))
    }
}
