//! Exporters: a mesh as the files of another program, one source file an exporter.
//!
//! Mesh, exporter, options -> one or several named files, one after the other. All but HDF5 are written from the first byte to
//! the last. An exporter never
//! holds all cells: it holds the flags of two slabs or, where points and faces are numbered, of a few planes (`layers`), and goes over the
//! mesh once for each part of a file. It knows no file system: the caller gives a writer, or for HDF5 a path, for each name ([`Files`]).
//! In wasm HDF5 is held in memory, and goes to a writer at its end.
//!
//! An exporter pauses before every slab. In wasm its caller takes the bytes written so far, and resumes it when it wants more.
//!
//! A new exporter is a file in `formats/`, its row in `formats.rs`, and a page in `docs/export/`.

use std::borrow::Cow;

use hexcast_core::base::control::{Control, at_once};
use hexcast_core::base::error::{Error, Result};
use hexcast_core::grid::lines::Lines;
use hexcast_derived::mesh::{Mesh, Named};

mod arrays;
mod boxes;
mod decimal;
mod electric;
mod format;
mod formats;
mod hdf5;
mod layers;
mod limits;
mod names;
mod options;
mod output;
mod patches;
mod plates;
mod surfaces;
mod unit;
mod xml;

use crate::write::Compress;
#[doc(hidden)]
pub use arrays::write as write_arrays;
#[cfg(not(target_arch = "wasm32"))]
pub use arrays::write_arrays_hdf5;
pub use formats::Exporter;
pub use options::{ExportOptions, PatchNames};
use output::Export;
pub use output::Files;
pub use unit::Length;

impl Exporter {
    /// The program that reads it, or the name of the format.
    pub fn program(self) -> &'static str {
        self.format().program
    }

    /// What is in its files, for a list of formats: a few words.
    pub fn about(self) -> &'static str {
        self.format().about
    }

    /// What is made on disk besides one file of the name that was given; empty where that is all.
    pub fn on_disk(self) -> &'static str {
        self.format().on_disk
    }

    /// Finds the exporter by the end of a path, upper or lower case; None where it asks for none.
    pub fn of_name(path: &str) -> Option<Exporter> {
        let path = path.trim_end_matches('/').replace('\\', "/").to_ascii_lowercase();
        let ends = |ending: &str| {
            let rest = path.strip_suffix(&ending.to_ascii_lowercase());
            rest.is_some_and(|rest| {
                if ending.starts_with('.') { !rest.is_empty() } else { rest.is_empty() || rest.ends_with('/') }
            })
        };
        Exporter::ENDINGS.into_iter().find(|(ending, _)| ends(ending)).map(|(_, exporter)| exporter)
    }

    /// The files of an output, relative to the folder of its path; `name` is the last part of that path. All of them are written.
    pub fn file_names(self, name: &str) -> Vec<String> {
        (self.format().file_names)(name)
    }

    /// Whether files are compressed where the caller asks for it.
    pub fn compresses(self) -> bool {
        self.format().compresses
    }

    /// Whether there is a form of text besides the binary one.
    pub fn has_ascii(self) -> bool {
        self.format().has_ascii
    }

    /// Whether cells are cut at the surface of a fluid, where the mesh has its outline ([`Mesh::outline`]).
    pub fn cuts(self) -> bool {
        self.format().cuts
    }

    /// Whether cells always are cut, and the mesh needs an outline with its parts.
    #[doc(hidden)]
    pub fn is_boundary(self) -> bool {
        self.format().is_boundary
    }

    /// Whether only some flags can be exported.
    pub fn has_flags(self) -> bool {
        self.format().has_flags
    }

    /// The axis across which an exporter holds whole planes of flags, where it does.
    pub fn held_planes(self) -> Option<usize> {
        self.format().held_planes
    }

    /// What it holds of a mesh besides planes or slabs, such as cut cells or surfaces, and about the most bytes of that.
    #[doc(hidden)]
    pub fn held(self, mesh: &Mesh) -> (&'static str, u64) {
        let (what, n_bytes) = self.format().held;
        (what, n_bytes(mesh))
    }

    /// Whether files name faces at the boundary of exported cells, as [`ExportOptions::patches`] says.
    pub fn has_patches(self) -> bool {
        self.format().longest_name.is_some()
    }

    /// Whether files have the faces of geometries without thickness ([`Mesh::plates`]), not only cells.
    pub fn has_plates(self) -> bool {
        self.format().has_plates
    }

    /// Perfect conductors that have neither a cell nor a face, so that files for electromagnetic fields lack them: a column file has no faces.
    pub fn lost_conductors<'a>(self, mesh: &'a Mesh, options: &ExportOptions) -> Vec<&'a Named> {
        let cells = mesh.columns().cells_per_flag();
        let has_some = |flag: u8| cells[usize::from(flag)] > 0 || mesh.plates().iter().any(|plate| plate.flag == flag);
        let is_lost = |named: &&Named| named.material.pec && !has_some(named.flag);
        let chosen = |named: &&Named| !options.chosen([named.flag]).is_empty();
        mesh.names().iter().filter(|_| self.has_plates()).filter(is_lost).filter(chosen).collect()
    }

    /// Refuses a unit of lengths that this exporter cannot use, for callers that have no mesh yet.
    ///
    /// # Errors
    /// `export-unit` where lengths must be in metres or centimetres, and the unit is not known.
    pub fn check_unit(self, unit: Option<&str>) -> Result<()> {
        self.format().unit.map_or(Ok(()), |(what, own)| unit::known(unit, what, own).map(|_| ()))
    }

    /// Refuses cells that this exporter cannot use, for callers that have no mesh yet.
    ///
    /// # Errors
    /// `lines-graded` where cells must be equal, or cubes; `export-too-large`.
    pub fn check_lines(self, lines: &Lines) -> Result<()> {
        (self.format().check_lines)(lines)
    }

    /// Refuses flags to export that no cell can have, for callers that have no mesh yet, and those that this exporter cannot write.
    ///
    /// # Errors
    /// `job-conflict`.
    pub fn check_flags(self, options: &ExportOptions, possible: &[u8]) -> Result<()> {
        let Some(flags) = options.flags.as_ref().filter(|_| self.has_flags()) else { return Ok(()) };
        if flags.is_empty() {
            return Err(Error::new("job-conflict", "no flag is to be exported", "name at least one"));
        }
        if let Some(flag) = flags.iter().find(|flag| !possible.contains(flag)) {
            let possible: Vec<String> = possible.iter().map(u8::to_string).collect();
            let (message, known) =
                (format!("flag {flag} is to be exported, and no geometry has it"), possible.join(", "));
            return Err(Error::new(
                "job-conflict",
                format!("{message}; flags of the job: {known}"),
                "name some of these",
            ));
        }
        (self.format().check_flags)(flags)
    }

    /// Refuses substances that this exporter cannot use, or needs to know, for callers that have no mesh yet: those of `flags` that are exported.
    ///
    /// # Errors
    /// `export-material` where the job does not say what a flag is made of; `job-value` where the program cannot compute it.
    pub fn check_materials(self, options: &ExportOptions, names: &[Named], flags: &[u8]) -> Result<()> {
        (self.format().check_materials)(names, &options.chosen(flags.iter().copied()))
    }

    /// Refuses patches that are to be open and no solid has, for callers that have no mesh yet: `solids` are the names of all walls.
    ///
    /// # Errors
    /// `job-conflict`.
    #[doc(hidden)]
    pub fn check_patches(self, options: &ExportOptions, solids: &[String]) -> Result<()> {
        self.format().longest_name.map_or(Ok(()), |longest| patches::check_open(options, solids, longest))
    }

    /// The bytes that files of cells take at least that are not known yet; None where that depends on the flags.
    #[doc(hidden)]
    pub fn least_size(self, lines: &Lines, options: &ExportOptions) -> Option<u64> {
        (self == Exporter::Nrrd && options.compress == Compress::None).then(|| lines.n_cells())
    }

    /// Refuses, before any byte is written, a mesh that this exporter cannot write with these options.
    ///
    /// # Errors
    /// Those of [`Exporter::check_unit`], [`Exporter::check_lines`] and [`Exporter::check_materials`]; `job-conflict` where no cell has one of the
    /// flags; `export-too-large`.
    pub fn check(self, mesh: &Mesh, options: &ExportOptions) -> Result<()> {
        self.check_unit(mesh.unit())?;
        self.check_lines(mesh.lines())?;
        if !self.has_flags() {
            return Ok(());
        }
        let options = &self.options_for(mesh, options);
        let keeps = options.selection(mesh, self.has_plates())?;
        self.check_flags(options, &(0..=255).collect::<Vec<u8>>())?;
        self.check_materials(options, mesh.names(), &options.exported(mesh))?;
        if let Some(longest) = self.format().longest_name {
            patches::check(mesh, options, longest)?;
        }
        (self.format().check_mesh)(mesh, options, &keeps)
    }

    /// With the one flag whose cells are cut, where cells are cut and the caller does not say which are exported.
    fn options_for<'a>(self, mesh: &Mesh, options: &'a ExportOptions) -> Cow<'a, ExportOptions> {
        match mesh.outline().filter(|_| self.cuts() && options.flags.is_none()) {
            Some(outline) => Cow::Owned(options.clone().with_flags(vec![outline.fluid])),
            None => Cow::Borrowed(options),
        }
    }
}

/// Writes a mesh for another program; `name` is the last part of the path of the output, which [`Exporter::file_names`] extends. Returns what the files lack of the
/// mesh, a sentence each: parts of cut cells that the format cannot hold.
///
/// # Errors
/// Those of [`Exporter::check`]; `export-too-large` where the format cannot number so many cells or points; those of `files`; `io` where
/// a writer fails; `cancelled`, looked at before every slab.
pub fn export(
    mesh: &Mesh,
    exporter: Exporter,
    name: &str,
    options: &ExportOptions,
    files: &mut dyn Files,
    control: &Control,
) -> Result<Vec<String>> {
    at_once(export_with_rests(mesh, (exporter, name), options, files, &control.without_pauses()))
}

/// Like [`export()`], with a rest before every slab ([`Control::rest`]).
///
/// # Errors
/// Those of [`export()`].
#[doc(hidden)]
pub async fn export_with_rests(
    mesh: &Mesh,
    (exporter, name): (Exporter, &str),
    options: &ExportOptions,
    files: &mut dyn Files,
    control: &Control,
) -> Result<Vec<String>> {
    exporter.check(mesh, options)?;
    let options = exporter.options_for(mesh, options);
    let job = Export::new(mesh, &options, control);
    (exporter.format().write)(&job, name, files).await?;
    Ok(job.lacks())
}

/// Returns the size of all files before they are written, in bytes; None where it depends on the flags.
pub fn exact_size(mesh: &Mesh, exporter: Exporter, options: &ExportOptions) -> Option<u64> {
    (exporter.format().exact_size)(mesh, options)
}

#[cfg(test)]
mod tests;
