//! How a job is meshed; no choice changes the cells.

use std::sync::Arc;

use hexcast_core::cells::columns::Store;

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
    /// Bytes that the program and its GPU driver take besides, which count against the job's `max_memory`; 0 where only the
    /// mesh shall count.
    pub program_bytes: u64,
    /// Most bytes of buffers on a GPU, at least 2^20; None for all that it has. Where the GPU uses the host's memory they count
    /// against the job's `max_memory`, too.
    pub max_device_bytes: Option<u64>,
    /// How often the cells of the job are halved along each axis.
    pub(crate) halved: u32,
}

impl MeshOptions {
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

    /// Counts the program and its GPU driver against the memory allowed.
    pub fn with_program_bytes(self, program_bytes: u64) -> MeshOptions {
        MeshOptions { program_bytes, ..self }
    }

    /// Limits the buffers on a GPU.
    pub fn with_max_device_bytes(self, max_device_bytes: Option<u64>) -> MeshOptions {
        MeshOptions { max_device_bytes, ..self }
    }
}
