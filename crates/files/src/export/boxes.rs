//! The cells of a flag as few boxes.
//!
//! Mesh, flag -> boxes that together are the cells of the flag, each cell in one of them. Plane by plane from below: a box of the plane before
//! goes on where all its cells have the flag here, too; what then is left becomes new boxes, each a run of cells along x that goes on along y as
//! long as it can. Fewest boxes are not sought: that is a hard problem, and solvers look through the boxes once.
//! Cost: O(cells) time; besides two slabs of flags, which are whole planes, one plane, and 40 bytes for each box that goes on, at most a cell each.

use std::ops::Range;

use super::output::Export;
use hexcast_core::base::error::Result;

/// A box that the planes to come may make longer.
struct Open {
    x: Range<usize>,
    y: Range<usize>,
    start: u32,
}

impl Open {
    fn rows(&self, nx: usize) -> impl Iterator<Item = Range<usize>> + use<> {
        let x = self.x.clone();
        self.y.clone().map(move |y| x.start + nx * y..x.end + nx * y)
    }

    fn closed(&self, end: u32) -> [[u32; 3]; 2] {
        [[self.x.start as u32, self.y.start as u32, self.start], [self.x.end as u32, self.y.end as u32, end]]
    }
}

/// Calls `visit` with each box: the numbers of its first cell on each axis, and of the first cell after it.
///
/// # Errors
/// `cancelled`, looked at before every slab; `io` as for [`Mesh::flag`](hexcast_derived::mesh::Mesh::flag); whatever `visit` returns.
pub(super) async fn for_each_box(
    job: &Export<'_>,
    flag: u8,
    visit: &mut dyn FnMut([[u32; 3]; 2]) -> Result<()>,
) -> Result<()> {
    let [nx, ny, nz] = job.mesh.dims();
    let (nx, plane) = (nx as usize, nx as usize * ny as usize);
    let mut open: Vec<Open> = Vec::new();
    let mut left: Vec<bool> = Vec::with_capacity(plane);
    let mut z = 0;
    let mut push = |flags: &[u8]| {
        for flags in flags.chunks_exact(plane) {
            left.clear();
            left.extend(flags.iter().map(|other| *other == flag));
            let mut done = Ok(());
            open.retain(|open| {
                let goes_on = open.rows(nx).all(|row| left[row].iter().all(|is_left| *is_left));
                if goes_on {
                    open.rows(nx).for_each(|row| left[row].fill(false));
                } else if done.is_ok() {
                    done = visit(open.closed(z));
                }
                goes_on
            });
            done?;
            begin(&mut left, nx, z, &mut open);
            z += 1;
        }
        Ok(())
    };
    job.for_each_slab(plane, &mut push).await?;
    open.iter().try_for_each(|open| visit(open.closed(nz)))
}

/// Makes boxes of what is left of a plane, and takes it away.
fn begin(left: &mut [bool], nx: usize, z: u32, open: &mut Vec<Open>) {
    let ny = left.len() / nx;
    for y in 0..ny {
        let mut x = 0;
        while x < nx {
            let run = left[x + nx * y..nx * (y + 1)].iter().take_while(|is_left| **is_left).count();
            if run > 0 {
                let goes_on = |y: &usize| left[x + nx * y..x + run + nx * y].iter().all(|is_left| *is_left);
                let end = (y + 1..ny).find(|y| !goes_on(y)).unwrap_or(ny);
                let new = Open { x: x..x + run, y: y..end, start: z };
                new.rows(nx).for_each(|row| left[row].fill(false));
                open.push(new);
            }
            x += run.max(1);
        }
    }
}
