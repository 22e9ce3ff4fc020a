//! What is written of a mesh: checked before the mesh is made, written to temporary files beside the targets, and put in place at the end.
//!
//! A family of outputs is a file that implements [`Output`]: files of cells, Zarr stores, files of solvers, what is measured, pictures.

use hexcast::Result;
use hexcast::control::Control;
use hexcast::job::Job;
use hexcast::lines::Lines;
use hexcast::mesh::Mesh;
use hexcast::pipeline::Prepared;
use hexcast::report::MeshFacts;

use crate::files::{disk::Planned, output_file::OutputFile};
use crate::screen::progress::Progress;

/// One output; nothing of it is left where it is dropped before [`Output::finish`].
pub(crate) trait Output: Send + Sync {
    /// Refuses, before the mesh is made, what is known to be wrong with it, and says how many bytes it takes at least where that is known.
    fn check(&self, _: &Asked) -> Result<Option<Planned>> {
        Ok(None)
    }

    /// Refuses, before anything is written, a mesh that it cannot hold, and says how many bytes it takes where that is known.
    fn plan(&self, _: &Meshed) -> Result<Option<Planned>> {
        Ok(None)
    }

    /// Writes it where nobody looks for it.
    fn write(&mut self, meshed: &Meshed, written: &mut Written) -> Result<()>;

    /// Puts it in its place.
    fn finish(self: Box<Self>) -> Result<()>;
}

/// A mesh that is not made yet.
pub(crate) struct Asked<'a> {
    pub(crate) job: &'a Job,
    pub(crate) prepared: &'a Prepared,
    /// Those of the mesh, with its halo.
    pub(crate) lines: Lines,
    /// Memory that the program and the columns will take, about.
    pub(crate) held_bytes: u64,
}

/// A mesh, and how it is written.
pub(crate) struct Meshed<'a> {
    pub(crate) mesh: &'a Mesh,
    /// What else was found; None where the mesh was read from a column file.
    pub(crate) facts: Option<&'a MeshFacts>,
    /// Memory that the program and the columns take.
    pub(crate) held_bytes: u64,
    pub(crate) control: &'a Control,
    pub(crate) progress: Progress,
}

impl<'a> Meshed<'a> {
    /// A mesh of which no more is known.
    pub(crate) fn new(mesh: &'a Mesh, control: &'a Control, progress: Progress) -> Meshed<'a> {
        Meshed { mesh, facts: None, held_bytes: mesh.columns().n_bytes(), control, progress }
    }
}

/// What came of writing.
#[derive(Default)]
pub(crate) struct Written {
    pub(crate) files: Vec<OutputFile>,
    pub(crate) warnings: Vec<String>,
    /// SHA-256 of the flags, if a file that holds nothing else was written.
    pub(crate) flags_sha256: Option<String>,
}

/// Outputs, in the order in which they are written.
pub(crate) type List = Vec<Box<dyn Output>>;
