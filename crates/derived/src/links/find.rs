//! All links of a box: a cast for each pair of directions, then in order.

use super::field::{Field, place};
use super::order::{ByPlane, in_order};
use super::sheared::Sheared;
use super::walk::Walk;
use super::{Link, Links};
use hexcast_core::base::control::Control;
use hexcast_core::base::error::{Error, Result};
use hexcast_core::base::parallel::*;
use hexcast_core::base::sort::sort_nearly_by_key;
use hexcast_core::input::job::{LinksJob, Stencil};
use hexcast_core::stages::cpu::{STRIPS_PER_ROUND, rows_of_strip};
use hexcast_core::stages::lattice::{Lattice, lattice};

impl Field<'_> {
    /// Finds all links of a stencil that begin in the window.
    ///
    /// # Errors
    /// `lines-graded` where cells differ in size and the stencil has more than faces; `memory` where the links would take more than
    /// `max_bytes`; `cancelled`; `io` where the columns are in a store that fails.
    pub async fn links(&self, job: &LinksJob, max_bytes: u64, control: &Control) -> Result<Links> {
        if self.frame.is_graded() && job.stencil != Stencil::D3Q7 {
            let message = format!("cells differ in size, and links of {:?} need equal ones", job.stencil);
            return Err(Error::new("lines-graded", message, "use the stencil D3Q7, or equal cells"));
        }
        let mut is_fluid = [false; 256];
        job.fluid.iter().for_each(|&flag| is_fluid[usize::from(flag)] = true);
        let near = self.window.with_neighbours(self.frame.dims);
        let directions = job.stencil.directions();
        // of each direction
        let mut parts: Vec<Vec<ByPlane>> = directions.iter().map(|_| Vec::new()).collect();
        let mut n = 0;
        for (pair, halves) in directions[1..].chunks_exact(2).enumerate() {
            let sheared = Sheared::new(self.frame, halves[0], near);
            let (forward, backward) = (2 * pair as u8 + 1, 2 * pair as u8 + 2);
            let directions = if sheared.is_backward { [backward, forward] } else { [forward, backward] };
            let walk = Walk { field: self, sheared: &sheared, is_fluid: &is_fluid, directions };
            let rays = &sheared.rays;
            let bin = [rays.counts[0], rows_of_strip(rays)];
            let n_strips = Lattice::n_rows(rays, bin);
            let (lattice, starts) = (lattice(&sheared.frame, rays, bin, 0..n_strips), walk.starts());
            for first in (0..n_strips).step_by(STRIPS_PER_ROUND as usize) {
                control.check()?;
                let strips = first..(first + STRIPS_PER_ROUND).min(n_strips);
                let of_strip = |memory: &mut _, strip| walk.links(&lattice, strip, &starts, memory);
                let found = match self.is_plain {
                    true => on_all_cores(|| map_within(strips, of_strip)),
                    // it looks at the columns
                    false => map_within(strips, of_strip),
                };
                let found: Result<Vec<[ByPlane; 2]>> = found.into_iter().collect();
                for both in found? {
                    for (part, direction) in both.into_iter().zip(directions) {
                        n += part.links.len();
                        parts[usize::from(direction)].push(part);
                    }
                }
                check_bytes(n, max_bytes)?;
                control.rest().await?;
            }
        }
        let dims = self.window.dims();
        let mut planes: Vec<Vec<Link>> =
            on_all_cores(|| map_within(0..dims[2], |memory, z| in_order(parts.iter().flatten(), z, dims, memory)));
        drop(parts);
        if !self.is_plain {
            let without = self.links_without_crossing(&planes, &directions, &is_fluid, control)?;
            check_bytes(n + without.iter().map(Vec::len).sum::<usize>(), max_bytes)?;
            for (links, more) in planes.iter_mut().skip(self.window.halo as usize).zip(without) {
                links.extend(more);
                sort_nearly_by_key(links, |link| place(link.cell, link.direction, dims));
            }
        }
        if self.periodic.contains(&true) {
            let through = self.periodic_links(job, &is_fluid, control).await?;
            n += through.len();
            check_bytes(n, max_bytes)?;
            for link in through {
                planes[link.cell[2] as usize].push(link);
            }
            planes
                .par_iter_mut()
                .for_each(|links| sort_nearly_by_key(links, |link| place(link.cell, link.direction, dims)));
        }
        Ok(Links { stencil: job.stencil, fluid: job.fluid.clone(), dims, origin: self.window.origin(), planes })
    }
}

/// Refuses more links than memory holds: they are put in order, which takes them twice.
fn check_bytes(n_links: usize, max_bytes: u64) -> Result<()> {
    let n_bytes = 2 * size_of::<Link>() as u64 * n_links as u64;
    if n_bytes <= max_bytes {
        return Ok(());
    }
    let message = format!("{n_links} links or more take {n_bytes} bytes: {max_bytes} are left of the memory allowed");
    let hint = "allow more with max_memory (--max-memory), use a stencil of fewer directions, or larger cells";
    Err(Error::new("memory", message, hint))
}
