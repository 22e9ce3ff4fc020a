//! Where the time of the columns goes: kernel by kernel on the GPU, stage by stage on the CPU.

use std::error::Error;
use std::time::Instant;

use hexcast::control::Control;
use hexcast::gpu::{Gpu, Options};
use hexcast_core::stages::cast::Cast;
use hexcast_core::stages::cpu;
use hexcast_core::stages::crossings::crossings;
use hexcast_core::stages::lattice::{Lattice, lattice};
use hexcast_core::stages::map::{Mapping, map};
use rayon::prelude::*;
use serde::Serialize;

use crate::line::lap;

/// Ray rows of a strip; `hexcast_core::stages::cpu` takes more or fewer, by the length of a row.
const STRIP: u32 = 16;

/// Name and seconds of a pass.
pub(crate) type Pass = (String, f64);

/// The passes of one mesh.
pub(crate) struct Passes {
    pub(crate) passes: Vec<Pass>,
    /// Bands of the mesh; on the CPU 1.
    pub(crate) n_bands: u32,
    /// Rows of rays that were left to the deep kernels.
    pub(crate) n_deep: u64,
}

/// What the passes of a mesh read and write, in numbers of things.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Counts {
    pub(crate) n_facets: u64,
    /// Bins of the GPU's lattice.
    pub(crate) n_bins: u64,
    /// (facet, bin) pairs of the GPU's lattice.
    pub(crate) n_pairs: u64,
    /// (facet, bin) pairs of the CPU's lattice.
    pub(crate) n_cpu_pairs: u64,
    pub(crate) n_rays: u64,
    pub(crate) n_crossings: u64,
    pub(crate) n_runs: u64,
    /// Bands of the GPU's mesh; each gets the facets that its rays may hit.
    pub(crate) n_bands: u32,
}

/// Counts what passes read and write.
pub(crate) fn counts(cast: &Cast, n_bands: u32) -> Result<Counts, Box<dyn Error>> {
    let Cast { frame, rays, .. } = *cast;
    let of_bins = |bin| lattice(frame, rays, bin, 0..Lattice::n_rows(rays, bin));
    let of_gpu = of_bins([8, 8]);
    let columns = cpu::columns(cast, &Control::default())?;
    Ok(Counts {
        n_facets: frame.facets.len() as u64,
        n_bins: of_gpu.offsets.len() as u64 - 1,
        n_pairs: of_gpu.facets.len() as u64,
        n_cpu_pairs: of_bins([rays.counts[0], STRIP]).facets.len() as u64,
        n_rays: rays.n_rays(),
        n_crossings: columns.n_crossings(),
        n_runs: columns.n_runs(),
        n_bands,
    })
}

/// Of the given number of meshes and one more, which compiles, the passes of the one that was disturbed least.
pub(crate) fn least_disturbed(
    runs: u32,
    passes: impl Fn() -> Result<Passes, Box<dyn Error>>,
) -> Result<Passes, Box<dyn Error>> {
    let sum = |all: &Passes| all.passes.iter().map(|pass| pass.1).sum::<f64>();
    let mut best = passes()?;
    for _ in 0..runs {
        let next = passes()?;
        if sum(&next) < sum(&best) {
            best = next;
        }
    }
    Ok(best)
}

/// Seconds of each kernel; every dispatch is waited for, so that the sum is more than an undisturbed mesh takes.
pub(crate) fn of_gpu(gpu: &Gpu, cast: &Cast) -> Result<Passes, Box<dyn Error>> {
    let options = Options { profile: true, ..Options::default() };
    let mut bands = Vec::new();
    let start = Instant::now();
    let usage = pollster::block_on(gpu.continue_columns(cast, &options, &Control::default(), &mut bands))?;
    let total = start.elapsed().as_secs_f64();
    let mut passes: Vec<Pass> =
        usage.profile.iter().flatten().map(|(kernel, seconds)| (format!("{kernel:?}"), *seconds)).collect();
    let in_kernels: f64 = passes.iter().map(|pass| pass.1).sum();
    passes.push(("upload, clears, readback".into(), total - in_kernels));
    Ok(Passes { passes, n_bands: usage.n_bands, n_deep: usage.deep })
}

/// Seconds of each stage, run one after another over the whole box; the mesh itself runs them strip by strip.
pub(crate) fn of_cpu(cast: &Cast) -> Result<Passes, Box<dyn Error>> {
    let Cast { frame, rays, rule } = *cast;
    let bin = [rays.counts[0], STRIP];
    let n_rows = Lattice::n_rows(rays, bin);
    let mapping = Mapping { rule, flag_of_rank: &frame.ranks.flag_of_rank, depth: rays.depth };
    let mut clock = Instant::now();
    let lattice = lattice(frame, rays, bin, 0..n_rows);
    let lattice_s = lap(&mut clock);
    let strips: Vec<_> = (0..n_rows).into_par_iter().map(|row| crossings(frame, rays, &lattice, row, false)).collect();
    let crossings_s = lap(&mut clock);
    let bands: Vec<_> = strips.par_iter().map(|strip| map(strip, &mapping)).collect();
    let map_s = lap(&mut clock);
    drop((strips, bands));
    let mut clock = Instant::now();
    cpu::columns(cast, &Control::default())?;
    let whole = ("all, strip by strip".into(), lap(&mut clock));
    let passes = vec![("lattice".into(), lattice_s), ("crossings".into(), crossings_s), ("map".into(), map_s), whole];
    Ok(Passes { passes, n_bands: 1, n_deep: 0 })
}
