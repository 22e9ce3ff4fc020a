//! Output files and folders: checked before the long work starts, written to a temporary file beside the target, and put in place at
//! the end, so that no half file is ever seen under the target's name.

use std::io::BufWriter;
use std::path::{Path, PathBuf};

use hexcast::Result;
use hexcast::control::Control;
use hexcast::estimate::slab_bytes;
use hexcast::export::Exporter;
use hexcast::job::{Job, ZarrJob};
use hexcast::mesh::Mesh;
use hexcast::pipeline::Prepared;
use hexcast::shards::Shards;
use hexcast::write::zarr::Place;
use hexcast::write::{Format, Options, check_lines, exact_size, sidecar_json, write};

use crate::files::{
    disk::{Planned, check_room},
    export_output::ExportOutput,
    output_file::{OutputFile, PendingFile, with_ending},
    standard_streams,
    zarr_folder::is_zarr,
    zarr_output::ZarrOutput,
};
pub(crate) use crate::options::format_arguments::FormatArguments;
use crate::options::format_arguments::exporter_of;
use crate::screen::progress::{Counted, Progress};

/// Where outputs go.
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
    pub(crate) fn has_zarr(meshes: &[PathBuf]) -> bool {
        meshes.iter().any(|path| is_zarr(path))
    }
}

/// Files being written; none is left where this is dropped before [`Outputs::finish`].
pub(crate) struct Outputs {
    meshes: Vec<MeshFile>,
    stores: Vec<(ZarrOutput, Options)>,
    exports: Vec<ExportOutput>,
    report: Option<PendingFile>,
    written: Vec<OutputFile>,
    /// Bytes of flags to expand at a time.
    pub(crate) slab_bytes: usize,
    /// SHA-256 of the flags, if a file that holds nothing else was written.
    pub(crate) flags_sha256: Option<String>,
}

struct MeshFile {
    format: Format,
    options: Options,
    file: PendingFile,
    /// Beside `.raw`.
    sidecar: Option<PendingFile>,
    /// Whether it holds the mask of doubtful cells in place of the flags.
    is_doubt: bool,
}

impl MeshFile {
    /// Whether the bytes of a `.raw` are the flags of the mesh, in their order.
    fn has_flags(&self) -> bool {
        !self.options.bits && !self.options.has_own_bytes() && !self.is_doubt
    }
}

impl Outputs {
    /// Checks names and folders and opens a temporary file for each output and the report.
    pub(crate) fn open(targets: &Targets, arguments: &FormatArguments, max_bytes: u64) -> Result<Outputs> {
        let (folder_paths, paths): (Vec<&PathBuf>, Vec<&PathBuf>) =
            targets.meshes.iter().partition(|path| is_zarr(path));
        let (export_paths, paths): (Vec<&PathBuf>, Vec<&PathBuf>) =
            paths.into_iter().partition(|path| exporter_of(path).is_some());
        let exporters: Vec<Exporter> = export_paths.iter().filter_map(|path| exporter_of(path)).collect();
        let format_of = |path: &Path| arguments.format_of(path);
        let mut formats = paths.iter().map(|path| format_of(path)).collect::<Result<Vec<Format>>>()?;
        formats.extend(targets.doubt.map(format_of).transpose()?);
        arguments.check(&formats, &exporters, !folder_paths.is_empty() || targets.has_archive)?;
        arguments.check_standard(targets.uses_standard_output())?;
        let mut stores = Vec::new();
        for path in folder_paths {
            let store = ZarrOutput::open(path, targets.is_part)?;
            stores.push((store, arguments.zarr_options(max_bytes).with_zarr(targets.zarr)));
        }
        let mut exports = Vec::new();
        for (path, exporter) in export_paths.into_iter().zip(exporters) {
            exports.push(ExportOutput::open(path, exporter, arguments.export_options(max_bytes))?);
        }
        let mut meshes = Vec::new();
        let n_flags = paths.len();
        let paths = paths.into_iter().map(PathBuf::as_path).chain(targets.doubt);
        for (index, (path, format)) in paths.zip(formats).enumerate() {
            let file = PendingFile::open(path)?;
            let sidecar = if format == Format::Raw && !file.is_standard() {
                Some(PendingFile::open(&with_ending(path, ".json"))?)
            } else {
                None
            };
            let options = arguments.options(format, max_bytes).with_zarr(targets.zarr);
            meshes.push(MeshFile { format, options, file, sidecar, is_doubt: index == n_flags });
        }
        let report = targets.report.map(PendingFile::open).transpose()?;
        let slab_bytes = slab_bytes(max_bytes) as usize;
        Ok(Outputs { meshes, stores, exports, report, written: Vec::new(), slab_bytes, flags_sha256: None })
    }

    /// Refuses what is known to be wrong with an output before the mesh is made.
    pub(crate) fn check(&self, job: &Job, prepared: &Prepared) -> Result<()> {
        for output in &self.meshes {
            check_lines(&prepared.lines, output.format).map_err(|error| error.at(output.file.path.display()))?;
            if output.format == Format::ZarrZip {
                Shards::new(prepared.lines.dims(), &output.options.zarr)?;
            }
        }
        for (_, options) in &self.stores {
            let lines = if job.part.is_some() { &prepared.whole } else { &prepared.lines };
            Shards::new(lines.dims(), &options.zarr)?;
        }
        self.exports.iter().try_for_each(|export| export.check(job, prepared))
    }

    /// Whether a `.raw` of one byte a cell will be written, whose hash is that of the flags.
    pub(crate) fn will_hash(&self) -> bool {
        self.meshes.iter().any(|mesh| mesh.format == Format::Raw && mesh.has_flags())
    }

    /// Formats of the files of the mesh.
    pub(crate) fn flags_files(&self) -> impl Iterator<Item = Format> {
        self.meshes.iter().filter(|mesh| !mesh.is_doubt).map(|mesh| mesh.format)
    }

    /// Number of meshes to write.
    pub(crate) fn n_meshes(&self) -> usize {
        self.meshes.len() + self.stores.len() + self.exports.len()
    }

    /// Says which conductors the files of solvers lack.
    pub(crate) fn lost_conductors(&self, mesh: &Mesh) -> Vec<String> {
        self.exports.iter().flat_map(|export| export.lost_conductors(mesh)).collect()
    }

    /// Writes the mesh, and the mask of its doubtful cells, to all their files, if the disks have room for those whose size is known.
    pub(crate) fn write(
        &mut self,
        mesh: &Mesh,
        place: &Place,
        doubt: Option<&Mesh>,
        control: &Control,
        progress: Progress,
    ) -> Result<()> {
        let of = |is_doubt: bool| doubt.filter(|_| is_doubt).unwrap_or(mesh);
        let planned = self.meshes.iter().filter_map(|output| {
            let mesh = of(output.is_doubt);
            let n_bytes = exact_size(mesh, output.format, &output.options)?;
            Some(Planned { path: output.file.path.clone(), folder: output.file.folder().into(), n_bytes })
        });
        let exported = self.exports.iter().map(|export| export.plan(mesh)).collect::<Result<Vec<_>>>()?;
        check_room(&planned.chain(exported.into_iter().flatten()).collect::<Vec<_>>())?;
        for output in &mut self.meshes {
            let mesh = of(output.is_doubt);
            let bar = progress.bytes("write", exact_size(mesh, output.format, &output.options));
            let path = output.file.path.display().to_string();
            let mut writer = Counted { file: BufWriter::with_capacity(1 << 20, output.file.temporary.as_file()), bar };
            let written = write(mesh, output.format, &output.options, &mut writer, control);
            writer.bar.finish_and_clear();
            drop(writer);
            let written = written.map_err(|error| error.at(&path))?;
            let path = output.file.path.clone();
            self.written.push(OutputFile { path, n_bytes: written.n_bytes });
            if let Some(sidecar) = &mut output.sidecar {
                let text = sidecar_json(mesh, &output.options, &written);
                sidecar.put(&text)?;
                self.written.push(OutputFile { path: sidecar.path.clone(), n_bytes: text.len() as u64 });
            }
            self.flags_sha256 = self.flags_sha256.take().or(written.sha256.filter(|_| output.has_flags()));
        }
        for export in &mut self.exports {
            self.written.extend(export.write(mesh, control, progress)?);
        }
        for (store, options) in &mut self.stores {
            self.written.push(store.write(mesh, place, options, control, progress)?);
        }
        Ok(())
    }

    /// Writes the report, if one was asked for, and puts all files in their places.
    pub(crate) fn finish(mut self, report: &str) -> Result<Vec<OutputFile>> {
        if let Some(file) = &mut self.report {
            file.put(report)?;
            self.written.push(OutputFile { path: file.path.clone(), n_bytes: report.len() as u64 });
        }
        let meshes = self.meshes.into_iter().flat_map(|mesh| [Some(mesh.file), mesh.sidecar]);
        for file in meshes.chain([self.report]).flatten() {
            file.persist()?;
        }
        self.exports.into_iter().try_for_each(ExportOutput::finish)?;
        self.stores.into_iter().try_for_each(|(store, _)| store.finish())?;
        Ok(self.written)
    }
}
