//! All links of a box: a cast for each pair of directions, then in order.

use super::field::{Field, place};
use super::sheared::Sheared;
use super::walk::Walk;
use super::{Link, Links};
use crate::base::control::Control;
use crate::base::error::{Error, Result};
use crate::base::parallel::*;
use crate::base::sort::sort_nearly_by_key;
use crate::input::job::{LinksJob, Stencil};
use crate::stages::cpu::Strips;
use crate::stages::crossings::by_ray;

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
        let (mut parts, mut n) = (Vec::new(), 0);
        for (pair, halves) in job.stencil.directions()[1..].chunks_exact(2).enumerate() {
            let sheared = Sheared::new(self.frame, halves[0], near);
            let (forward, backward) = (2 * pair as u8 + 1, 2 * pair as u8 + 2);
            let directions = if sheared.is_backward { [backward, forward] } else { [forward, backward] };
            let walk = Walk { field: self, sheared: &sheared, is_fluid: &is_fluid, directions };
            let mut strips = Strips::new(&sheared.cast(self.rule), None);
            while let Some(crossings) = strips.crossings(true, control)? {
                let found: Result<Vec<ByPlane>> =
                    crossings.par_iter().map(|some| Ok(ByPlane::new(&walk.links(some)?))).collect();
                let found = found?;
                n += found.iter().map(|part| part.links.len()).sum::<usize>();
                check_bytes(n, max_bytes)?;
                parts.extend(found);
                control.rest().await?;
            }
        }
        let dims = self.window.dims();
        let mut planes: Vec<Vec<Link>> = (0..dims[2])
            .into_par_iter()
            .map(|z| {
                let of_plane: Vec<&[Link]> = parts.iter().map(|part| part.of_plane(z)).collect();
                let mut links = of_plane.concat();
                // those of a part are in order already, or nearly
                sort_nearly_by_key(&mut links, |link| place(link.cell, link.direction, dims));
                links
            })
            .collect();
        drop(parts);
        if !self.is_plain {
            let without = self.links_without_crossing(&planes, &job.stencil.directions(), &is_fluid, control)?;
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

/// Links of some rays, plane after plane.
struct ByPlane {
    /// The first plane that has any.
    first: u32,
    /// First entry of `links` of each plane from there on, then the end.
    offsets: Vec<u32>,
    links: Vec<Link>,
}

impl ByPlane {
    fn new(links: &[Link]) -> ByPlane {
        let ends = || links.iter().map(|link| link.cell[2]);
        let (first, last) = (ends().min().unwrap_or(0), ends().max().unwrap_or(0));
        let by_plane: Vec<(u32, Link)> = links.iter().map(|&link| (link.cell[2] - first, link)).collect();
        let (offsets, links) = by_ray(&by_plane, (last - first) as usize + 1);
        ByPlane { first, offsets, links }
    }

    fn of_plane(&self, z: u32) -> &[Link] {
        let Some(plane) = z.checked_sub(self.first).map(|plane| plane as usize) else { return &[] };
        match self.offsets.get(plane..plane + 2) {
            Some(ends) => &self.links[ends[0] as usize..ends[1] as usize],
            None => &[],
        }
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
