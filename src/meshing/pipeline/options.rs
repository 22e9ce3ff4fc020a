//! How a job is meshed; no choice changes the cells.

use std::collections::BTreeSet;
use std::sync::Arc;

use hexcast_core::base::error::{Error, Result};
use hexcast_core::cells::columns::Store;
use hexcast_core::input::geometry::Geometry;
use hexcast_core::input::job::Job;

/// Most bytes that a mesh takes where neither the job nor the caller limits it: all that the system gives, or in wasm,
/// which can address 4 GiB, what leaves enough for the page's other data.
pub const DEFAULT_MAX_BYTES: u64 = if cfg!(target_arch = "wasm32") { 3 << 30 } else { u64::MAX };

/// Where columns go that exceed the memory allowed.
#[derive(Clone, Default)]
#[non_exhaustive]
pub enum SpillTarget {
    /// Nowhere: what does not fit in memory is an error.
    #[default]
    None,
    /// To a store that is gone with the mesh.
    Temporary(Arc<dyn Store>),
    /// To a store that outlives an interrupted run, which gets all columns: those that it holds of the same job are not cast
    /// again.
    Resumable(Arc<dyn Store>),
}

/// The cells of a fluid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Fluid {
    /// Those of a flag; 0 is all around the geometries.
    Flag(u8),
    /// Those of all geometries, which have one flag.
    Geometries,
}

/// How a job is meshed.
#[derive(Clone, Default)]
#[non_exhaustive]
pub struct MeshOptions {
    /// Where columns go that exceed the memory allowed.
    pub spill: SpillTarget,
    /// Whether the caller will hold all flags in memory, a byte a cell, which counts against the job's `max_memory`.
    pub flags_in_memory: bool,
    /// Whether the cells that rays do not decide shall also be a mesh, [`crate::meshing::report::MeshFacts::doubt`]; its columns share the memory
    /// of those of the mesh.
    pub doubt_mask: bool,
    /// Whether nobody needs the report of a part with a halo to be merged with those of the other parts. Else the part is meshed once more,
    /// without its halo, as these count cells once.
    pub lone_report: bool,
    /// Whether faces between flags and at the sides of the box shall have the names of the solids that made them: [`Mesh::walls`](hexcast_derived::mesh::Mesh::walls).
    pub walls: bool,
    /// Which fluid shall be cut at its surface: [`Mesh::outline`](hexcast_derived::mesh::Mesh::outline).
    pub outline: Option<Fluid>,
    /// Whether the outline shall have what the fluid has of faces and edges, for embedded boundaries.
    pub outline_parts: bool,
    /// Bytes that the program and its GPU driver take besides, which count against the job's `max_memory`; 0 where only the
    /// mesh shall count.
    pub program_bytes: u64,
    /// Most bytes of buffers on a GPU, at least 2^20; None for all that it has. Where the GPU uses the host's memory they count
    /// against the job's `max_memory`, too.
    pub max_device_bytes: Option<u64>,
}

impl Fluid {
    /// Its flag.
    ///
    /// # Errors
    /// `job-conflict` where no geometry has it, or geometries have several.
    pub(super) fn flag(self, geometries: &[Geometry]) -> Result<u8> {
        let flags: BTreeSet<u8> = geometries.iter().map(|geometry| geometry.flag).collect();
        let said = flags.iter().map(u8::to_string).collect::<Vec<_>>().join(", ");
        let hint = "name one with export_flags (--export-flags): 0 is what is around all geometries";
        match (self, flags.first()) {
            (Fluid::Flag(flag), _) if flag == 0 || flags.contains(&flag) => Ok(flag),
            (Fluid::Geometries, Some(&flag)) if flags.len() == 1 => Ok(flag),
            (Fluid::Flag(flag), _) => {
                let message =
                    format!("the fluid of cut cells has flag {flag}, and no geometry has it: flags are {said}");
                Err(Error::new("job-conflict", message, hint))
            }
            _ => {
                let message = format!("cut cells are those of one fluid, and geometries have the flags {said}");
                Err(Error::new("job-conflict", message, hint))
            }
        }
    }
}

impl MeshOptions {
    /// Whether a job, or the caller, asks for what is measured with all facets of the surfaces.
    pub(crate) fn measures(&self, job: &Job) -> bool {
        job.is_measured() || self.outline.is_some()
    }

    /// Says where columns go that exceed the memory allowed.
    pub fn with_spill(self, spill: SpillTarget) -> MeshOptions {
        MeshOptions { spill, ..self }
    }

    /// Counts the flags against the memory allowed.
    pub fn with_flags_in_memory(self, flags_in_memory: bool) -> MeshOptions {
        MeshOptions { flags_in_memory, ..self }
    }

    /// Asks for a mesh of the cells that rays do not decide.
    pub fn with_doubt_mask(self, doubt_mask: bool) -> MeshOptions {
        MeshOptions { doubt_mask, ..self }
    }

    /// Says that nobody merges the report of a part with a halo with others, so that the part is not meshed once more for it.
    pub fn with_lone_report(self, lone_report: bool) -> MeshOptions {
        MeshOptions { lone_report, ..self }
    }

    /// Names faces by the solids that made them.
    pub fn with_walls(self, walls: bool) -> MeshOptions {
        MeshOptions { walls, ..self }
    }

    /// Asks for the outline of a fluid, for cut cells. Only closed bodies have one, and whole boxes.
    pub fn with_outline(self, outline: Option<Fluid>) -> MeshOptions {
        MeshOptions { outline, ..self }
    }

    /// Asks for what the fluid has of the faces and edges of cut cells, with their outline.
    pub fn with_outline_parts(self, outline_parts: bool) -> MeshOptions {
        MeshOptions { outline_parts, ..self }
    }

    /// Counts the program and its GPU driver against the memory allowed.
    pub fn with_program_bytes(self, program_bytes: u64) -> MeshOptions {
        MeshOptions { program_bytes, ..self }
    }

    /// Limits the buffers on a GPU.
    pub fn with_max_device_bytes(self, max_device_bytes: Option<u64>) -> MeshOptions {
        MeshOptions { max_device_bytes, ..self }
    }
}
