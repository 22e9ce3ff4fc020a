//! The files of an exporter as output: made in a temporary folder beside the target, and put in place one by one at the end.

use std::io::Write;
use std::path::{Path, PathBuf};

use hexcast::export::{ExportOptions, Exporter, Files, exact_size, export};
use hexcast::files::place::{ExportPlace, refused};
use hexcast::geometry::Geometry;
use hexcast::mesh::{Mesh, Named};
use hexcast::pipeline::Prepared;
use hexcast::walls;
use hexcast::{Error, Result};
use indicatif::{BinaryBytes, ProgressBar};

use crate::files::{
    disk::Planned,
    ledger,
    output::{Asked, Meshed, Output, Written},
    output_file::OutputFile,
    temporary,
};
use crate::screen::progress::Counted;

/// Files being written.
pub(crate) struct ExportOutput {
    /// The name that the caller gave.
    path: PathBuf,
    exporter: Exporter,
    options: ExportOptions,
    /// Most bytes that the program takes.
    max_bytes: u64,
    /// The folder and the last part of what the path leads to: names of files begin there.
    folder: PathBuf,
    name: String,
    /// The files by name.
    outputs: Vec<(String, ledger::Output)>,
    temporary: temporary::Folder,
}

impl ExportOutput {
    /// Opens a temporary folder, and enters all files.
    pub(crate) fn open(
        path: &Path,
        exporter: Exporter,
        (options, max_bytes): (ExportOptions, u64),
    ) -> Result<ExportOutput> {
        let ExportPlace { folder, name, files, .. } = ExportPlace::of(path, exporter)?;
        let output = |file: String| Ok((file.clone(), ledger::Output::file_of(path, folder.join(file))?));
        let outputs = files.into_iter().map(output).collect::<Result<_>>()?;
        let temporary = temporary::Folder::beside(&folder.join(&name), &folder);
        let temporary = temporary.map_err(|error| refused(path, &folder, &error))?;
        Ok(ExportOutput { path: path.into(), exporter, options, max_bytes, folder, name, outputs, temporary })
    }

    /// Says of each conductor that the files lack that they do.
    fn lost_conductors(&self, mesh: &Mesh) -> Vec<String> {
        let said = |named: &Named| {
            format!(
                "{}: flag {} (\"{}\"), a perfect conductor, is not in it: it has no cell, and column files have no faces of geometries without \
                 thickness; write this file with hexcast mesh",
                self.path.display(),
                named.flag,
                named.name
            )
        };
        self.exporter.lost_conductors(mesh, &self.options).into_iter().map(said).collect()
    }

    /// Refuses a unit that the program does not know; where files disagree, that is why there is none.
    fn check_unit(&self, Prepared { unit, notices, .. }: &Prepared) -> Result<()> {
        let unlike = notices.iter().find(|finding| unit.is_none() && finding.code == "unit-differs");
        self.exporter.check_unit(unit.as_deref()).map_err(|error| match unlike {
            Some(why) => Error::new("export-unit", &why.sentence, "give --unit, and a scale to files in another"),
            None => self.at(error),
        })
    }

    fn at(&self, error: Error) -> Error {
        error.at(self.path.display())
    }

    fn of_bytes(&self, n_bytes: u64) -> Planned {
        Planned { path: self.path.clone(), folder: self.folder.clone(), n_bytes }
    }
}

impl Output for ExportOutput {
    fn check(&self, asked: &Asked) -> Result<Option<Planned>> {
        let Asked { job, prepared, .. } = asked;
        let mut flags: Vec<u8> = prepared.geometries.iter().map(|geometry| geometry.flag).chain([0]).collect();
        match (job.close_gaps, job.gap_flag) {
            (None, _) => {}
            (_, Some(flag)) => flags.push(flag),
            // one that no geometry has
            _ => flags.extend(1..=u8::MAX),
        }
        flags.sort_unstable();
        flags.dedup();
        let (exporter, options) = (self.exporter, &self.options);
        self.check_unit(prepared)?;
        let known = || {
            exporter.check_lines(&asked.lines)?;
            exporter.check_flags(options, &flags)?;
            exporter.check_materials(options, &prepared.names, &with_cells(prepared))?;
            exporter.check_patches(options, &walls::names(&prepared.geometries).0)
        };
        known().map_err(|error| self.at(error))?;
        Ok(exporter.least_size(&asked.lines, options).map(|n_bytes| self.of_bytes(n_bytes)))
    }

    fn plan(&self, meshed: &Meshed) -> Result<Option<Planned>> {
        self.exporter.check(meshed.mesh, &self.options).map_err(|error| self.at(error))?;
        let (what, held) = self.exporter.held(meshed.mesh);
        let left = self.max_bytes.saturating_sub(meshed.held_bytes);
        if held > left {
            let [held, left] = [held, left].map(BinaryBytes);
            let message =
                format!("{what} take up to {held} while they are made, and {left} of the memory allowed are left");
            return Err(self.at(Error::new("memory", message, "allow more (--max-memory), or use larger cells")));
        }
        Ok(exact_size(meshed.mesh, self.exporter, &self.options).map(|n_bytes| self.of_bytes(n_bytes)))
    }

    fn write(&mut self, meshed: &Meshed, written: &mut Written) -> Result<()> {
        let Meshed { mesh, facts, control, progress, .. } = meshed;
        if facts.is_none() {
            written.warnings.extend(self.lost_conductors(mesh));
        }
        let bar = progress.bytes("write", exact_size(mesh, self.exporter, &self.options));
        let mut folder = Counting { folder: &self.temporary, bar: bar.clone() };
        let done = export(mesh, self.exporter, &self.name, &self.options, &mut folder, control);
        bar.finish_and_clear();
        let lacks = done.map_err(|error| self.at(error))?;
        written.warnings.extend(lacks.into_iter().map(|said| format!("{}: {said}", self.path.display())));
        for name in self.exporter.file_names(&self.name) {
            let metadata = self.temporary.path(&name).metadata();
            let failed = |error| Error::io(format!("writing {}", self.path.display()), error);
            let (path, n_bytes) = (self.folder.join(name), metadata.map_err(failed)?.len());
            let path = path.strip_prefix(".").map(Path::to_path_buf).unwrap_or(path);
            written.files.push(OutputFile { path, n_bytes });
        }
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<()> {
        self.outputs.iter().try_for_each(|(name, output)| output.put_path(&self.temporary.path(name)))
    }
}

/// The background, and the flags of geometries that are as good as certain to get cells: their boxes are cells thick, in the mesh, and clear of
/// those of other flags. The rest is known when the mesh is.
fn with_cells(prepared: &Prepared) -> Vec<u8> {
    let lines = &prepared.lines;
    // two boxes meet if they do so along all axes
    let meet = |[low, high]: &[[f64; 3]; 2], [first, last]: &[[f64; 3]; 2]| {
        (0..3).all(|axis| high[axis] > first[axis] && low[axis] < last[axis])
    };
    let whole = [0, 1].map(|end| [0, 1, 2].map(|axis| lines.line(axis, end * lines.dims()[axis])));
    let has_cells = |geometry: &Geometry| {
        let Some(own) = geometry.bounding_box() else { return false };
        let others = prepared.geometries.iter().filter(|other| other.flag != geometry.flag);
        let [first, last] = own.map(|corner| [0, 1, 2].map(|axis| lines.position(axis, corner[axis])));
        (0..3).all(|axis| last[axis].min(lines.dims()[axis].into()) - first[axis].max(0.0) >= LEAST_CELLS)
            && meet(&own, &whole)
            && !others.filter_map(Geometry::bounding_box).any(|other| meet(&own, &other))
    };
    let found = prepared.geometries.iter().filter(|geometry| has_cells(geometry));
    found.map(|geometry| geometry.flag).chain([0]).collect()
}

/// Cells along each axis of a box in which a geometry gets some.
const LEAST_CELLS: f64 = 2.0;

/// The temporary folder, whose bytes are counted.
struct Counting<'a> {
    folder: &'a temporary::Folder,
    bar: ProgressBar,
}

impl Files for Counting<'_> {
    fn create(&mut self, name: &str) -> Result<Box<dyn Write + '_>> {
        let file = self.folder.create(name).map_err(|error| Error::io(format!("writing {name}"), error))?;
        Ok(Box::new(Counted { file, bar: self.bar.clone() }))
    }

    fn place(&mut self, name: &str) -> Result<PathBuf> {
        self.folder.place(name).map_err(|error| Error::io(format!("writing {name}"), error))
    }
}
