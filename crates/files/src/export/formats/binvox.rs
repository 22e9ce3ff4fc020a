//! binvox: the cells of some flags as a cube of bits, run after run, to look at and for programs that learn from shapes.
//!
//! One file: a header in text, then pairs of a value (0 or 1) and how often it comes (1 to 255), x slowest, then z, then y. The cube has as many
//! cells along every axis as the mesh along its longest: what lies beyond the mesh is 0. `translate` is the origin, `scale` the side of the cube.
//! Source: the format of binvox by Patrick Min. Cost: some planes of flags across x.

use crate::export::{
    format::Format,
    limits::cubes,
    output::{Export, Files, Out},
};
use hexcast_core::base::error::Result;

pub(in crate::export) static FORMAT: Format = Format {
    program: "binvox",
    about: "a cube of bits, to look at",
    check_lines: |lines| cubes(lines, ".binvox").map(|_| ()),
    held_planes: Some(0),
    ..Format::new(&[".binvox"], |job, name, files| Box::pin(write(job, name, files)))
};

async fn write(job: &Export<'_>, name: &str, files: &mut dyn Files) -> Result<()> {
    let keeps = job.options.selection(job.mesh, false)?;
    let [nx, ny, nz] = job.mesh.dims();
    let side = nx.max(ny).max(nz);
    let [x, y, z] = job.mesh.lines().origin();
    let scale = f64::from(side) * cubes(job.mesh.lines(), ".binvox")?;
    let mut runs = Runs { out: Out::create(files, name)?, value: false, n: 0 };
    runs.out.text(format_args!(
        "#binvox 1\ndim {side} {side} {side}\ntranslate {x:?} {y:?} {z:?}\nscale {scale:?}\ndata\n"
    ))?;
    let plane = ny as usize * nz as usize;
    let step = (job.options.slab_bytes / plane).clamp(1, nx as usize);
    for start in (0..nx).step_by(step) {
        job.control.rest().await?;
        let end = start.saturating_add(step as u32).min(nx);
        let flags = job.mesh.box_flags(&[start..end, 0..ny, 0..nz])?;
        let n = (end - start) as usize;
        for x in 0..n {
            for row in flags.chunks_exact(n * ny as usize) {
                row[x..].iter().step_by(n).try_for_each(|flag| runs.put(keeps[usize::from(*flag)], 1))?;
                runs.put(false, u64::from(side - ny))?;
            }
            runs.put(false, u64::from(side - nz) * u64::from(side))?;
        }
    }
    job.control.check()?;
    runs.put(false, u64::from(side - nx) * u64::from(side) * u64::from(side))?;
    runs.flush()?;
    runs.out.finish()
}

/// The run that is being made longer.
struct Runs<'a> {
    out: Out<'a>,
    value: bool,
    n: u64,
}

impl Runs<'_> {
    fn put(&mut self, value: bool, n: u64) -> Result<()> {
        if value != self.value && n > 0 {
            self.flush()?;
            self.value = value;
        }
        self.n += n;
        Ok(())
    }

    fn flush(&mut self) -> Result<()> {
        while self.n > 0 {
            let n = self.n.min(255);
            self.out.put(&[u8::from(self.value), n as u8])?;
            self.n -= n;
        }
        Ok(())
    }
}
