//! All outputs of a command: opened before the long work starts, and driven in one order, so that no half file is ever seen under a target's name.

use std::path::{Path, PathBuf};

use hexcast::Result;
use hexcast::estimate::{Estimate, slab_bytes};
use hexcast::export::Exporter;
use hexcast::job::{Job, ZarrJob};
use hexcast::pipeline::Prepared;
use hexcast::write::Format;

use crate::files::{
    cells_file::CellsFile,
    disk::check_room,
    export_output::ExportOutput,
    output::{Asked, List, Meshed, Written},
    output_file::PendingFile,
    standard_streams,
    zarr_output::{ZarrOutput, is_zarr},
};
pub(crate) use crate::options::format_arguments::FormatArguments;
use crate::options::format_arguments::exporter_of;

/// Share of the columns that they may take beyond their estimate.
const BEYOND_ESTIMATE: u64 = 4;

/// Where the cells go.
#[derive(Default)]
pub(crate) struct Targets<'a> {
    pub(crate) meshes: &'a [PathBuf],
    /// Of the mask of doubtful cells.
    pub(crate) doubt: Option<&'a Path>,
    pub(crate) report: Option<&'a Path>,
    /// Shapes of the shards of Zarr stores.
    pub(crate) zarr: ZarrJob,
    /// Whether only a part of a mesh is written, to a store that has others, too.
    pub(crate) is_part: bool,
    /// Whether what is measured is written beside it to a file that can be compressed.
    pub(crate) has_archive: bool,
}

impl Targets<'_> {
    /// Whether standard output gets a file.
    pub(crate) fn uses_standard_output(&self) -> bool {
        let mut paths = self.meshes.iter().map(PathBuf::as_path).chain(self.doubt).chain(self.report);
        paths.any(standard_streams::is_standard)
    }

    /// Whether a name asks for a Zarr store.
    pub(crate) fn has_zarr(&self) -> bool {
        self.meshes.iter().any(|path| is_zarr(path))
    }
}

/// All outputs of a command.
pub(crate) struct Outputs {
    /// The cells, whose writing the report counts.
    pub(crate) cells: List,
    report: Option<PendingFile>,
    pub(crate) measured: List,
    /// Drawn after all else is in its place: one that fails leaves it there.
    pub(crate) pictures: List,
    pub(crate) written: Written,
    /// Whether standard output is a file's, so that nothing else may be printed there.
    pub(crate) has_standard_output: bool,
    /// Whether a file is written whose SHA-256 is that of the flags.
    pub(crate) will_hash: bool,
    /// Bytes of flags to expand at a time.
    pub(crate) slab_bytes: usize,
}

impl Outputs {
    /// Checks names and folders and opens a temporary file for each output of the cells and the report.
    pub(crate) fn open(targets: &Targets, arguments: &FormatArguments, max_bytes: u64) -> Result<Outputs> {
        let (mut cells, mut exports, mut stores): (List, List, List) = Default::default();
        let is_file = |path: &&PathBuf| !is_zarr(path) && exporter_of(path).is_none();
        let paths = targets.meshes.iter().filter(is_file).map(|path| (path.as_path(), false));
        let paths: Vec<(&Path, bool)> = paths.chain(targets.doubt.map(|path| (path, true))).collect();
        let formats = paths.iter().map(|(path, _)| arguments.format_of(path)).collect::<Result<Vec<Format>>>()?;
        let of_exports = || targets.meshes.iter().filter_map(|path| Some((path, exporter_of(path)?)));
        let exporters: Vec<Exporter> = of_exports().map(|(_, exporter)| exporter).collect();
        arguments.check(&formats, &exporters, targets.has_zarr() || targets.has_archive)?;
        let has_standard_output = targets.uses_standard_output();
        arguments.check_standard(has_standard_output)?;
        for path in targets.meshes.iter().filter(|path| is_zarr(path)) {
            let options = arguments.zarr_options(max_bytes).with_zarr(targets.zarr);
            stores.push(Box::new(ZarrOutput::open(path, options, targets.is_part)?));
        }
        for (path, exporter) in of_exports() {
            exports.push(Box::new(ExportOutput::open(
                path,
                exporter,
                (arguments.export_options(max_bytes), max_bytes),
            )?));
        }
        let mut will_hash = false;
        for ((path, is_doubt), format) in paths.into_iter().zip(formats) {
            let options = arguments.options(format, max_bytes).with_zarr(targets.zarr);
            let file = CellsFile::open(path, format, options, is_doubt)?;
            will_hash |= file.has_flags_alone();
            cells.push(Box::new(file));
        }
        let report = targets.report.map(PendingFile::open).transpose()?;
        cells.extend(exports.into_iter().chain(stores));
        let (measured, pictures, written) = Default::default();
        let slab_bytes = slab_bytes(max_bytes) as usize;
        Ok(Outputs { cells, report, measured, pictures, written, has_standard_output, will_hash, slab_bytes })
    }

    /// Refuses what is known to be wrong with an output before the mesh is made, and files that no disk has room for.
    pub(crate) fn check(&self, job: &Job, prepared: &Prepared, (spills, program_bytes): (bool, u64)) -> Result<()> {
        let Prepared { geometries, lines, rays, .. } = prepared;
        // pictures alone look at it, and it takes a while
        let is_estimated = !spills && !self.pictures.is_empty();
        let column_bytes = if is_estimated { Estimate::new(geometries, lines, rays).column_bytes } else { 0 };
        let held_bytes = program_bytes + column_bytes + column_bytes / BEYOND_ESTIMATE;
        let asked = Asked { job, prepared, lines: prepared.mesh_lines(), held_bytes };
        let all = self.measured.iter().chain(&self.pictures).chain(&self.cells);
        check_room(all.map(|output| output.check(&asked)), " at least")
    }

    /// Writes the cells, if the disks have room for the files whose size is known.
    pub(crate) fn write_cells(&mut self, meshed: &Meshed) -> Result<()> {
        check_room(self.cells.iter().map(|output| output.plan(meshed)), "")?;
        self.cells.iter_mut().try_for_each(|output| output.write(meshed, &mut self.written))
    }

    /// Writes the report and what is measured, and puts these and the cells in their places.
    pub(crate) fn finish(&mut self, meshed: &Meshed, report: &str) -> Result<()> {
        if let Some(file) = &mut self.report {
            file.put(report)?;
            self.written.files.push(file.of_bytes(report.len() as u64));
        }
        self.measured.iter_mut().try_for_each(|output| output.write(meshed, &mut self.written))?;
        meshed.control.check()?;
        self.cells.drain(..).try_for_each(|output| output.finish())?;
        self.report.take().map_or(Ok(()), PendingFile::persist)?;
        self.measured.drain(..).try_for_each(|output| output.finish())
    }

    /// Draws the pictures, and puts them in their places one by one.
    pub(crate) fn draw(&mut self, meshed: &Meshed) -> Result<()> {
        self.pictures.drain(..).try_for_each(|mut picture| {
            picture.write(meshed, &mut self.written)?;
            picture.finish()
        })
    }
}
