//! All links of a box: a cast for each pair of directions, then in order.

use super::field::{Field, place};
use super::sheared::Sheared;
use super::walk::Walk;
use super::{Link, Links};
use crate::control::Control;
use crate::cpu::Strips;
use crate::error::{Error, Result};
use crate::job::{LinksJob, Stencil};
use crate::parallel::*;

impl Field<'_> {
    /// Finds all links of a stencil.
    ///
    /// # Errors
    /// `lines-graded` where cells differ in size and the stencil has more than faces; `memory` where the links would take more than
    /// `max_bytes`; `cancelled`; `io` where the columns are in a store that fails.
    pub fn links(&self, job: &LinksJob, max_bytes: u64, control: &Control) -> Result<Links> {
        if self.frame.is_graded() && job.stencil != Stencil::D3Q7 {
            let message = format!("cells differ in size, and links of {:?} need equal ones", job.stencil);
            return Err(Error::new("lines-graded", message, "use the stencil D3Q7, or equal cells"));
        }
        let mut is_fluid = [false; 256];
        job.fluid.iter().for_each(|&flag| is_fluid[usize::from(flag)] = true);
        let mut links: Vec<Link> = Vec::new();
        for (pair, halves) in job.stencil.directions()[1..].chunks_exact(2).enumerate() {
            let sheared = Sheared::new(self.frame, halves[0]);
            let (forward, backward) = (2 * pair as u8 + 1, 2 * pair as u8 + 2);
            let directions = if sheared.is_backward { [backward, forward] } else { [forward, backward] };
            let walk = Walk { field: self, sheared: &sheared, is_fluid: &is_fluid, directions };
            let mut strips = Strips::new(&sheared.cast(self.rule), None);
            while let Some(crossings) = strips.crossings(true, control)? {
                let found: Result<Vec<Vec<Link>>> = crossings.par_iter().map(|some| walk.links(some)).collect();
                let found = found?;
                let n = links.len() + found.iter().map(Vec::len).sum::<usize>();
                check_bytes(n, max_bytes)?;
                found.iter().for_each(|more| links.extend_from_slice(more));
            }
        }
        let dims = self.frame.dims;
        sort(&mut links, dims);
        if !self.is_plain {
            let without = self.links_without_crossing(&links, &job.stencil.directions(), &is_fluid, control)?;
            check_bytes(links.len() + without.len(), max_bytes)?;
            links.extend(without);
            sort(&mut links, dims);
        }
        Ok(Links { stencil: job.stencil, fluid: job.fluid.clone(), dims, links })
    }
}

/// Refuses more links than memory holds: they are sorted in place, and grow by doubling.
fn check_bytes(n_links: usize, max_bytes: u64) -> Result<()> {
    let n_bytes = 2 * size_of::<Link>() as u64 * n_links as u64;
    if n_bytes <= max_bytes {
        return Ok(());
    }
    let message = format!("{n_links} links or more take {n_bytes} bytes: {max_bytes} are left of the memory allowed");
    let hint = "allow more with max_memory (--max-memory), use a stencil of fewer directions, or larger cells";
    Err(Error::new("memory", message, hint))
}

fn sort(links: &mut [Link], dims: [u32; 3]) {
    links.par_sort_unstable_by_key(|link| place(link.cell, link.direction, dims));
}
