//! Room: how much memory the columns get, and what happens to those that do not fit.

use sha2::{Digest, Sha256};

use super::engine::{Casting, Engine};
use super::task::{Aside, DEFAULT_MAX_BYTES, Prepared, Task};
use crate::cast::Cast;
use crate::columns::{Growing, Head, Named};
use crate::cpu;
use crate::error::Result;
use crate::estimate::{Allowed, Device, Estimate, Plan};
use crate::job::{BackendChoice, Job};
use crate::report::InputReport;

/// The memory of a mesh.
pub(super) struct Room(Plan);

impl Room {
    /// Holds the estimate of a task against the memory allowed.
    ///
    /// # Errors
    /// `memory`.
    pub(super) fn new(task: &Task, prepared: &Prepared, engine: &Engine) -> Result<Room> {
        let max_bytes = task.job.max_memory.map_or(DEFAULT_MAX_BYTES, |size| size.0);
        let rays = &prepared.rays;
        let can_spill = !matches!(task.aside, Aside::Nowhere);
        if max_bytes == u64::MAX && !can_spill {
            let (most_rows, most_strips) = (rays.counts[1], cpu::STRIPS_PER_ROUND);
            return Ok(Room(Plan { columns: u64::MAX, most_rows, most_strips, needed: 0 }));
        }
        let estimate = Estimate::new(&prepared.geometries, &prepared.lines, rays);
        let (program_bytes, device) = (task.program_bytes, engine.device());
        if device == Device::Shared {
            // those of a larger mesh before this one would be taken as they are
            engine.clear_pool_over(max_bytes / 16);
        }
        let allowed = Allowed { max_bytes, program_bytes, device, can_spill, flags: task.flags_in_memory };
        Plan::new(&estimate, &allowed).map(Room)
    }

    /// What to mesh, in bands or rounds of a size that the memory allows.
    pub(super) fn casting<'a>(&self, cast: Cast<'a>) -> Casting<'a> {
        Casting { cast, most_rows: self.0.most_rows, most_strips: self.0.most_strips }
    }

    /// Columns without rays yet, or with those that were kept of the same job.
    ///
    /// # Errors
    /// Those of [`Growing::keeping`] and [`Head::encode`].
    pub(super) fn growing(
        &self,
        task: &Task,
        prepared: &Prepared,
        names: &[Named],
        inputs: &[InputReport],
    ) -> Result<Growing> {
        let identity = || identity(task.job, prepared, inputs);
        let head = |identity: Option<[u8; 32]>| {
            // a job is the same in another unit
            let unit = task.job.unit.clone().filter(|_| identity.is_none());
            let (lines, names) = (prepared.lines, names.to_vec());
            Head { identity, rays: prepared.rays, zlib: false, lines, unit, names }.encode()
        };
        let (rays, max_bytes) = (prepared.rays, self.0.columns);
        match &task.aside {
            Aside::Nowhere => Ok(Growing::new(rays, max_bytes, None)),
            Aside::Spill(store) => Ok(Growing::new(rays, max_bytes, Some((head(None)?, store.clone())))),
            Aside::Keep(store) => Growing::keeping(rays, max_bytes, head(Some(identity()))?, store.clone()),
        }
    }
}

/// Stands for everything that decides the columns: the version, the job but for who does it in how much memory, the bytes
/// of its files, the lines and the rays.
fn identity(job: &Job, prepared: &Prepared, inputs: &[InputReport]) -> [u8; 32] {
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
