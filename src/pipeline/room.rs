//! Room: how much memory the columns get, and what happens to those that do not fit.

use sha2::{Digest, Sha256};

use super::{Aside, DEFAULT_MAX_BYTES, Engine, Prepared, Task};
use crate::columns::Growing;
use crate::error::Result;
use crate::estimate::{Allowed, Estimate, MOST_BAND, band_bytes, slab_bytes};
use crate::job::{BackendChoice, Job};
use crate::report::InputReport;

/// Bytes left to what is not counted: the program, its threads, the pieces at hand of columns put aside.
const RESERVE: u64 = 32 << 20;

/// The memory of a mesh.
pub(super) struct Room {
    /// Bytes for the columns.
    columns: u64,
    /// Most ray rows that the GPU brings home at once, before they are packed.
    pub(super) most_rows: u32,
}

impl Room {
    /// Holds the estimate of a task against the memory allowed.
    ///
    /// # Errors
    /// `memory`.
    pub(super) fn new(task: &Task, prepared: &Prepared, engine: &Engine) -> Result<Room> {
        let max_bytes = task.job.max_memory.map_or(DEFAULT_MAX_BYTES, |size| size.0);
        let rays = &prepared.rays;
        if max_bytes == u64::MAX && matches!(task.aside, Aside::Nowhere) {
            return Ok(Room { columns: u64::MAX, most_rows: rays.counts[1] });
        }
        let estimate = Estimate::new(&prepared.geometries, &prepared.lines, rays);
        let on_gpu = engine.backend() == "gpu";
        let can_spill = !matches!(task.aside, Aside::Nowhere);
        estimate.check(&Allowed { max_bytes, on_gpu, can_spill, flags: task.flags_in_memory })?;
        let band_bytes = band_bytes(max_bytes);
        let working = estimate.host.working(on_gpu, band_bytes);
        let left = max_bytes - working;
        // a small budget keeps a share for the columns, a large one everything else
        let others = (RESERVE + 2 * slab_bytes(max_bytes)).min(left / 2);
        let rays_of_band = match estimate.host.band {
            0 => rays.n_rays(),
            bytes => (rays.n_rays().min(MOST_BAND) as f64 * (band_bytes as f64 / bytes as f64).min(1.0)) as u64,
        };
        let most_rows = (rays_of_band / u64::from(rays.counts[0])).clamp(1, u64::from(rays.counts[1])) as u32;
        Ok(Room { columns: left - others, most_rows })
    }

    /// Columns without rays yet, or with those that were kept; `identity` stands for what is meshed.
    ///
    /// # Errors
    /// Those of [`Growing::keeping`].
    #[cfg_attr(target_arch = "wasm32", expect(unused_variables, reason = "wasm keeps nothing"))]
    pub(super) fn growing(
        &self,
        aside: &Aside,
        prepared: &Prepared,
        identity: impl FnOnce() -> [u8; 32],
    ) -> Result<Growing> {
        match aside {
            Aside::Nowhere => Ok(Growing::new(prepared.rays, self.columns, None)),
            Aside::Spill(store) => Ok(Growing::new(prepared.rays, self.columns, Some(store.clone()))),
            #[cfg(not(target_arch = "wasm32"))]
            Aside::Keep(store) => Growing::keeping(prepared.rays, self.columns, store.clone(), &identity()),
        }
    }
}

/// Stands for everything that decides the columns: the version, the job but for who does it in how much memory, the bytes
/// of its files, the lines and the rays.
pub(super) fn identity(job: &Job, prepared: &Prepared, inputs: &[InputReport]) -> [u8; 32] {
    let job = Job { backend: BackendChoice::Auto, max_memory: None, unit: None, ..job.clone() };
    let files: Vec<&str> = inputs.iter().map(|input| input.sha256.as_str()).collect();
    let facts = [
        env!("CARGO_PKG_VERSION").to_string(),
        job.to_json(),
        files.join(" "),
        format!("{:?} {:?}", prepared.lines, prepared.rays),
    ];
    Sha256::digest(facts.join("\n")).into()
}
