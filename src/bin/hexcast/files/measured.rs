//! Outputs of what is measured at surfaces: links, and fractions of cells; and staggered grids.

use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use hexcast::control::Control;
use hexcast::export::write_links_hdf5;
use hexcast::job::{Axis, Job, RunJob, Stencil, ZarrJob};
use hexcast::links::Links;
use hexcast::mesh::Mesh;
use hexcast::pipeline::Prepared;
use hexcast::report::MeshFacts;
use hexcast::write::{
    Compress, Format, LinksFormat, Options, check_lines, write_fractions, write_links, write_solid, write_staggered,
    zarr,
};
use hexcast::{Error, Result};

use crate::files::{
    output_file::{OutputFile, PendingFile},
    place_of_store::is_s3,
    zarr_folder::ZarrFolder,
};
use crate::options::{
    arguments::{choice, number},
    format_arguments::FormatArguments,
    job_options::as_text,
};

/// What is measured, and where it goes.
#[derive(clap::Args)]
#[command(next_help_heading = "Measured")]
pub(crate) struct MeasuredArguments {
    /// Write the links that lead from cells of the fluid to a wall to a file, .npz, .h5 or .links: of each the fraction up to the wall, the
    /// facet and the geometry
    #[arg(long, value_name = "FILE")]
    links: Option<PathBuf>,
    /// Directions of --links: D3Q7 faces, D3Q15 faces and corners, D3Q19 faces and edges, D3Q27 all [default: D3Q19]
    #[arg(long, visible_alias = "lattice", requires = "links",
          value_parser = choice::<Stencil>(&["D3Q7", "D3Q15", "D3Q19", "D3Q27"]))]
    stencil: Option<Stencil>,
    /// Flags of the fluid, for --links [default: 0, the background]
    #[arg(long, value_name = "FLAGS", requires = "links", value_delimiter = ',', value_parser = number::<u8>)]
    fluid: Option<Vec<u8>>,
    /// Axes along which the box continues with itself, so that --links leads through its sides
    #[arg(long, value_name = "AXES", requires = "links", value_delimiter = ',', value_parser = choice::<Axis>(&["x", "y", "z"]))]
    periodic: Option<Vec<Axis>>,
    /// Write the fractions of all flags in the cells that surfaces cut to a file, .npz; or, for every cell, the fraction that is not background:
    /// .vti, .vtr, .npy, .zarr or .zarr.zip
    #[arg(long, value_name = "FILE")]
    fractions: Option<PathBuf>,
    /// Rays of --fractions along each axis of a cell: 1, 2, 4, 8 or 16 [default: 4]
    #[arg(long, value_name = "M", requires = "fractions", value_parser = number::<u32>)]
    fraction_rays: Option<u32>,
    /// Also measure the fractions of all flags in each face of the cut cells
    #[arg(long, requires = "fractions")]
    fraction_faces: bool,
    /// Also measure area, centre and normal of the surface in each cut cell
    #[arg(long, requires = "fractions")]
    fraction_surfaces: bool,
    /// Write the flags at the points of a staggered (Yee) grid to a file, .npz: edges, faces and cells, and the faces of sheets
    #[arg(long, value_name = "FILE")]
    staggered: Option<PathBuf>,
    /// Flags of perfect conductors on the staggered grid: all edges of their cells conduct, not only those within the surface, which would leave
    /// metal half a cell too thin
    #[arg(long, value_name = "FLAGS", requires = "staggered", value_delimiter = ',', value_parser = number::<u8>)]
    conductors: Option<Vec<u8>>,
}

/// Files for what is measured, opened before the long work starts; none is left where this is dropped before [`Measured::finish`].
pub(crate) struct Measured {
    links: Option<(PendingFile, Option<LinksFormat>)>,
    fractions: Option<FractionsFile>,
    staggered: Option<PendingFile>,
    options: Options,
    written: Vec<OutputFile>,
}

/// The format of a file of links, by its name; None is HDF5.
fn links_format(path: &Path) -> Result<Option<LinksFormat>> {
    let is_hdf5 = path.extension().is_some_and(|of| of.eq_ignore_ascii_case("h5") || of.eq_ignore_ascii_case("hdf5"));
    if is_hdf5 {
        return Ok(None);
    }
    LinksFormat::of_name(&path.to_string_lossy()).map(Some)
}

/// Writes links; without a format as HDF5, at the place of the file.
fn put_links(file: &PendingFile, format: Option<LinksFormat>, links: &Links, compress: Compress) -> Result<OutputFile> {
    let Some(format) = format else {
        let failed = |error: Error| error.at(file.path.display());
        write_links_hdf5(links, file.temporary.path(), compress).map_err(failed)?;
        let metadata = std::fs::metadata(file.temporary.path());
        let n_bytes = metadata.map_err(|error| failed(Error::io("reading its size", error)))?.len();
        return Ok(OutputFile { path: file.path.clone(), n_bytes });
    };
    put(file, |out| write_links(links, format, compress, out))
}

/// Where fractions go.
enum FractionsFile {
    /// An entry for each flag of each cell that is cut.
    Sparse(PendingFile),
    /// One number for every cell.
    Dense(PendingFile, Format),
    /// The same in a store.
    Store(Box<(ZarrFolder, Options)>),
}

/// The format of a file of fractions, by its name; [`Format::Npz`] is that of the fractions of each flag.
fn fractions_format(path: &Path) -> Result<Format> {
    match Format::of_name(&path.to_string_lossy()) {
        Ok(format) if !matches!(format, Format::Raw | Format::Columns) => Ok(format),
        _ => {
            let message = format!("{}: no format of fractions of cells has this ending", path.display());
            Err(Error::new(
                "job-value",
                message,
                "use .npz for those of each flag, or .vti, .vtr, .npy, .zarr or .zarr.zip",
            ))
        }
    }
}

impl FractionsFile {
    fn open(path: &Path, store: Options) -> Result<FractionsFile> {
        match fractions_format(path)? {
            Format::Npz => Ok(FractionsFile::Sparse(PendingFile::open(path)?)),
            Format::Zarr if is_s3(path) => {
                let message = format!("{}: fractions of cells are not written to a bucket", path.display());
                Err(Error::new("job-value", message, "write a folder, and copy it"))
            }
            Format::Zarr => Ok(FractionsFile::Store(Box::new((ZarrFolder::open(path)?, store)))),
            format => Ok(FractionsFile::Dense(PendingFile::open(path)?, format)),
        }
    }
}

impl MeasuredArguments {
    /// Puts the names of the files into a job file.
    pub(crate) fn put(&self, run: &mut RunJob) -> Result<()> {
        run.links_output = self.links.as_deref().map(as_text).transpose()?;
        run.fractions_output = self.fractions.as_deref().map(as_text).transpose()?;
        run.staggered_output = self.staggered.as_deref().map(as_text).transpose()?;
        Ok(())
    }

    /// Asks in a job for what shall be written; what the job asks for alone is counted in the report.
    pub(crate) fn ask(&self, job: &mut Job) -> Result<()> {
        if self.links.is_some() {
            let links = job.links.get_or_insert_default();
            links.stencil = self.stencil.unwrap_or(links.stencil);
            links.fluid = self.fluid.clone().unwrap_or_else(|| std::mem::take(&mut links.fluid));
        }
        job.periodic = self.periodic.clone().unwrap_or_else(|| std::mem::take(&mut job.periodic));
        if self.fractions.is_some() {
            let fractions = job.fractions.get_or_insert_default();
            fractions.rays = self.fraction_rays.unwrap_or(fractions.rays);
            fractions.faces |= self.fraction_faces;
            fractions.surfaces |= self.fraction_surfaces;
        }
        job.staggered |= self.staggered.is_some();
        job.conductors = self.conductors.clone().unwrap_or_else(|| std::mem::take(&mut job.conductors));
        let is_dense = |path: &PathBuf| fractions_format(path).is_ok_and(|format| format != Format::Npz);
        if job.halo.is_some_and(|halo| halo > 0) && self.fractions.as_ref().is_some_and(is_dense) {
            let message =
                "--fractions of every cell and --halo are given together: only the cells within the halo are measured";
            return Err(Error::new("job-conflict", message, "leave out --halo, or write .npz, which lists cut cells"));
        }
        job.validate()
    }

    /// Whether a file is written that can be compressed.
    pub(crate) fn has_archive(&self) -> bool {
        let of_links = self.links.as_deref().map(links_format);
        let has_fractions = self.fractions.as_deref().is_some_and(|path| fractions_format(path) != Ok(Format::Npy));
        self.staggered.is_some() || has_fractions || matches!(of_links, Some(Ok(None | Some(LinksFormat::Npz))))
    }

    /// Opens the files.
    pub(crate) fn open(&self, formats: &FormatArguments, (zarr, max_bytes): (ZarrJob, u64)) -> Result<Measured> {
        let links = self.links.as_ref().map(|path| Ok((PendingFile::open(path)?, links_format(path)?))).transpose()?;
        let store = formats.zarr_options(max_bytes).with_zarr(zarr);
        let fractions = self.fractions.as_ref().map(|path| FractionsFile::open(path, store));
        let staggered = self.staggered.as_ref().map(|path| {
            if !path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("npz")) {
                let message = format!("{}: a staggered grid is written as .npz", path.display());
                return Err(Error::new("job-value", message, "use .npz"));
            }
            PendingFile::open(path)
        });
        Ok(Measured {
            links,
            fractions: fractions.transpose()?,
            staggered: staggered.transpose()?,
            options: store,
            written: Vec::new(),
        })
    }
}

impl Measured {
    /// Refuses what is known to be wrong with a file before the mesh is made.
    pub(crate) fn check(&self, prepared: &Prepared) -> Result<()> {
        let Some(FractionsFile::Dense(file, format)) = &self.fractions else { return Ok(()) };
        check_lines(&prepared.lines, *format).map_err(|error| error.at(file.path.display()))
    }

    /// Writes what was measured.
    pub(crate) fn write(&mut self, mesh: &Mesh, facts: &MeshFacts, control: &Control) -> Result<()> {
        let compress = self.options.compress;
        if let Some(((file, format), links)) = self.links.as_ref().zip(facts.links.as_ref()) {
            self.written.push(put_links(file, *format, links, compress)?);
        }
        if let Some((file, fractions)) = self.fractions.as_mut().zip(facts.fractions.as_ref()) {
            self.written.push(match file {
                FractionsFile::Sparse(file) => put(file, |out| write_fractions(fractions, compress, out))?,
                FractionsFile::Dense(file, format) => {
                    let compress = if *format == Format::Npy { Compress::None } else { compress };
                    let options = self.options.with_compress(compress);
                    put(file, |out| write_solid(mesh, fractions, (*format, &options), out, control))?
                }
                FractionsFile::Store(of_store) => {
                    let (folder, options) = &mut **of_store;
                    folder.put(|set| zarr::write_solid(mesh, fractions, options, set, control))?
                }
            });
        }
        if let Some((file, staggered)) = self.staggered.as_ref().zip(facts.staggered.as_ref()) {
            self.written.push(put(file, |out| write_staggered(staggered, mesh, compress, out))?);
        }
        Ok(())
    }

    /// Puts the files in their places.
    pub(crate) fn finish(self) -> Result<Vec<OutputFile>> {
        let fractions = match self.fractions {
            Some(FractionsFile::Store(of_store)) => {
                of_store.0.finish()?;
                None
            }
            Some(FractionsFile::Sparse(file) | FractionsFile::Dense(file, _)) => Some(file),
            None => None,
        };
        let links = self.links.map(|(file, _)| file);
        [links, fractions, self.staggered].into_iter().flatten().try_for_each(PendingFile::persist)?;
        Ok(self.written)
    }
}

fn put(file: &PendingFile, write: impl FnOnce(&mut dyn Write) -> Result<u64>) -> Result<OutputFile> {
    let mut out = BufWriter::with_capacity(1 << 20, file.temporary.as_file());
    let path = file.path.clone();
    let n_bytes = write(&mut out).map_err(|error| error.at(path.display().to_string()))?;
    Ok(OutputFile { path, n_bytes })
}
