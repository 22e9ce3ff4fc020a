//! Outputs of what is measured at surfaces: links, and fractions of cells; staggered grids; edges and faces outside metal; smoothed permittivity; and distances.

use std::path::{Path, PathBuf};

use hexcast::export::write_arrays_hdf5;
use hexcast::job::{Axis, Band, FractionsMethod, Job, Points, RunJob, Stencil, ZarrJob};
use hexcast::report::MeshFacts;
use hexcast::write::{
    Array, Compress, Format, LinksFormat, Options, distance, links, write_conformal, write_distance,
    write_distance_cells, write_fractions, write_links, write_solid, write_staggered, write_tensors,
};
use hexcast::{Error, Result};

use crate::files::{
    cells_file::check_cells,
    disk::Planned,
    output::{Asked, List, Meshed, Output, Written},
    output_file::PendingFile,
    zarr_output::{Numbers, ZarrOutput},
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
    /// How --fractions measures [default: exact, or rays where --fraction-rays is given]
    #[arg(long, value_name = "METHOD", requires = "fractions", value_enum)]
    fraction_method: Option<FractionsMethod>,
    /// Rays of --fractions along each axis of a cell, with --fraction-method rays: 1, 2, 4, 8 or 16 [default: 4]
    #[arg(long, value_name = "M", requires = "fractions", value_parser = number::<u32>)]
    fraction_rays: Option<u32>,
    /// Also measure the fractions of all flags in each face of the cut cells
    #[arg(long, requires = "fractions")]
    fraction_faces: bool,
    /// Also measure area, centre and normal of the surface in each cut cell
    #[arg(long, requires = "fractions")]
    fraction_surfaces: bool,
    /// Also measure the fractions of all flags in each edge of the cut cells; rays do not measure them
    #[arg(long, requires = "fractions")]
    fraction_edges: bool,
    /// Also measure the centre of what each flag has of a cut cell, and, with --fraction-faces, of each face; rays do not measure them
    #[arg(long, requires = "fractions")]
    fraction_centroids: bool,
    /// Write the flags at the points of a staggered (Yee) grid to a file, .npz: edges, faces and cells, and the faces of sheets
    #[arg(long, value_name = "FILE")]
    staggered: Option<PathBuf>,
    /// Flags of perfect conductors on the staggered grid: all edges of their cells conduct, not only those within the surface, which would leave
    /// metal half a cell too thin
    #[arg(long, value_name = "FLAGS", requires = "staggered", value_delimiter = ',', value_parser = number::<u8>)]
    conductors: Option<Vec<u8>>,
    /// Write the fractions of edges and faces outside metal to a file, .npz, for conformal solvers of Maxwell's equations
    #[arg(long, value_name = "FILE")]
    conformal: Option<PathBuf>,
    /// Flags that are metal for --conformal, 0 for the background [default: those of geometries with pec=true or metal=true]
    #[arg(long, value_name = "FLAGS", requires = "conformal", value_delimiter = ',', value_parser = number::<u8>)]
    metal: Option<Vec<u8>>,
    /// Least area of a face for --conformal, as a part of the fraction of its longest edge; 0 leaves areas as they are [default: 0.125]
    #[arg(long, value_name = "PART", requires = "conformal", value_parser = number::<f64>)]
    stable: Option<f64>,
    /// Write the signed distance of every cell to the nearest surface to a file, .npz, .npy, .h5, .vti, .vtr, .zarr or .zarr.zip: negative inside
    #[arg(long, value_name = "FILE")]
    distance: Option<PathBuf>,
    /// Where --distance is measured, the centres of cells or the crossings of lines [default: centres]
    #[arg(long, value_name = "WHERE", requires = "distance", value_enum)]
    distance_at: Option<Points>,
    /// How far from surfaces --distance is exact, in cells, or "all"; beyond it is that width [default: 3]
    #[arg(long, value_name = "CELLS", requires = "distance")]
    distance_band: Option<Band>,
    /// Flags of the geometries whose surfaces count for --distance, as if there were no others [default: all]
    #[arg(long, value_name = "FLAGS", requires = "distance", value_delimiter = ',', value_parser = number::<u8>)]
    distance_flags: Option<Vec<u8>>,
    /// Write the permittivity averaged around each point of E, as tensors, to a file, .npz; geometries have it as FILE:eps_r=2.2
    #[arg(long, value_name = "FILE")]
    tensors: Option<PathBuf>,
}

/// A file of what is measured.
struct MeasuredFile {
    what: What,
    file: PendingFile,
    options: Options,
}

/// What a file holds.
#[derive(Clone, Copy)]
enum What {
    /// Links, without a format as HDF5.
    Links(Option<LinksFormat>),
    /// An entry for each flag of each cell that is cut.
    Fractions,
    /// One number for every cell.
    Solid(Format),
    Staggered,
    Conformal,
    /// A number for every centre or node, without a format as HDF5.
    Distance(Option<Format>),
    Tensors,
}

/// The format of a file of links, by its name; None is HDF5.
fn links_format(path: &Path) -> Result<Option<LinksFormat>> {
    if is_hdf5(path) { Ok(None) } else { LinksFormat::of_name(&path.to_string_lossy()).map(Some) }
}

fn is_hdf5(path: &Path) -> bool {
    path.extension().is_some_and(|of| of.eq_ignore_ascii_case("h5") || of.eq_ignore_ascii_case("hdf5"))
}

/// The format of a file of fractions, by its name; [`Format::Npz`] is that of the fractions of each flag.
fn fractions_format(path: &Path) -> Result<Format> {
    let hint = "use .npz for those of each flag, or .vti, .vtr, .npy, .zarr or .zarr.zip";
    format_of_numbers(path, "fractions of cells", hint)
}

/// The format of a file of distances, by its name; None is HDF5.
fn distance_format(path: &Path) -> Result<Option<Format>> {
    if is_hdf5(path) {
        return Ok(None);
    }
    format_of_numbers(path, "distances", "use .npz, .npy, .h5, .vti, .vtr, .zarr or .zarr.zip").map(Some)
}

fn format_of_numbers(path: &Path, of: &str, hint: &str) -> Result<Format> {
    match Format::of_name(&path.to_string_lossy()) {
        Ok(format) if !matches!(format, Format::Raw | Format::Columns) => Ok(format),
        _ => Err(Error::new("job-value", format!("{}: no format of {of} has this ending", path.display()), hint)),
    }
}

impl MeasuredArguments {
    /// Puts the names of the files into a job file.
    pub(crate) fn put(&self, run: &mut RunJob) -> Result<()> {
        run.links_output = self.links.as_deref().map(as_text).transpose()?;
        run.fractions_output = self.fractions.as_deref().map(as_text).transpose()?;
        run.staggered_output = self.staggered.as_deref().map(as_text).transpose()?;
        run.conformal_output = self.conformal.as_deref().map(as_text).transpose()?;
        run.distance_output = self.distance.as_deref().map(as_text).transpose()?;
        run.tensors_output = self.tensors.as_deref().map(as_text).transpose()?;
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
            fractions.method = self.fraction_method.or(fractions.method);
            fractions.rays = self.fraction_rays.or(fractions.rays);
            fractions.faces |= self.fraction_faces;
            fractions.surfaces |= self.fraction_surfaces;
            fractions.edges |= self.fraction_edges;
            fractions.centroids |= self.fraction_centroids;
        }
        job.staggered |= self.staggered.is_some();
        job.conductors = self.conductors.clone().unwrap_or_else(|| std::mem::take(&mut job.conductors));
        if self.conformal.is_some() {
            let conformal = job.conformal.get_or_insert_default();
            conformal.metal = self.metal.clone().unwrap_or_else(|| std::mem::take(&mut conformal.metal));
            conformal.stable = self.stable.unwrap_or(conformal.stable);
        }
        if let Some(path) = &self.distance {
            let distance = job.distance.get_or_insert_default();
            distance.at = self.distance_at.unwrap_or(distance.at);
            distance.band = self.distance_band.unwrap_or(distance.band);
            distance.flags = self.distance_flags.clone().unwrap_or_else(|| std::mem::take(&mut distance.flags));
            if distance.at == Points::Nodes && matches!(distance_format(path)?, Some(Format::Zarr | Format::ZarrZip)) {
                let message =
                    format!("{}: a Zarr store holds numbers of cells, and nodes are asked for", path.display());
                return Err(Error::new(
                    "job-conflict",
                    message,
                    "use .npz, .npy, .h5, .vti or .vtr, or leave out nodes",
                ));
            }
        }
        if self.tensors.is_some() {
            job.tensors.get_or_insert_default();
        }
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
        let has_distance = self.distance.as_deref().is_some_and(|path| distance_format(path) != Ok(Some(Format::Npy)));
        let is_npz = self.staggered.is_some() || self.conformal.is_some() || self.tensors.is_some();
        is_npz || has_fractions || has_distance || matches!(of_links, Some(Ok(None | Some(LinksFormat::Npz))))
    }

    /// Opens the files.
    pub(crate) fn open(&self, formats: &FormatArguments, (zarr, max_bytes): (ZarrJob, u64)) -> Result<List> {
        let options = formats.zarr_options(max_bytes).with_zarr(zarr);
        let mut all: List = Vec::new();
        let file = |path: &Path, what| Ok(Box::new(MeasuredFile { what, file: PendingFile::open(path)?, options }));
        if let Some(path) = &self.links {
            all.push(file(path, What::Links(links_format(path)?))?);
        }
        if let Some(path) = &self.fractions {
            match fractions_format(path)? {
                Format::Zarr => all.push(Box::new(ZarrOutput::of_numbers(path, options, Numbers::Fractions)?)),
                Format::Npz => all.push(file(path, What::Fractions)?),
                format => all.push(file(path, What::Solid(format))?),
            }
        }
        if let Some(path) = &self.distance {
            match distance_format(path)? {
                Some(Format::Zarr) => all.push(Box::new(ZarrOutput::of_numbers(path, options, Numbers::Distances)?)),
                format => all.push(file(path, What::Distance(format))?),
            }
        }
        let staggered = (&self.staggered, What::Staggered, "a staggered grid is");
        let conformal = (&self.conformal, What::Conformal, "edges and faces outside metal are");
        let tensors = (&self.tensors, What::Tensors, "smoothed permittivity is");
        for (path, what, named) in [staggered, conformal, tensors] {
            let Some(path) = path else { continue };
            if !path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("npz")) {
                let message = format!("{}: {named} written as .npz", path.display());
                return Err(Error::new("job-value", message, "use .npz"));
            }
            all.push(file(path, what)?);
        }
        Ok(all)
    }
}

impl MeasuredFile {
    fn options_of(&self, format: Format) -> Options {
        let compress = if format == Format::Npy { Compress::None } else { self.options.compress };
        self.options.with_compress(compress)
    }

    /// Writes arrays as HDF5, and returns the number of bytes.
    fn hdf5(&self, arrays: &[Array], meshed: &Meshed) -> Result<u64> {
        let place = self.file.temporary.path();
        let size = || std::fs::metadata(place).map_err(|error| Error::io("reading its size", error));
        let written = write_arrays_hdf5(arrays, place, self.options.compress, meshed.control).and_then(|()| size());
        Ok(written.map_err(|error| error.at(self.file.path.display()))?.len())
    }
}

impl Output for MeasuredFile {
    fn check(&self, asked: &Asked) -> Result<Option<Planned>> {
        let (What::Solid(format) | What::Distance(Some(format))) = self.what else { return Ok(None) };
        check_cells(&self.file, asked, (format, &self.options)).map(|()| None)
    }

    fn write(&mut self, meshed: &Meshed, written: &mut Written) -> Result<()> {
        let (mesh, compress, file) = (meshed.mesh, self.options.compress, &self.file);
        let Some(facts) = meshed.facts else { return Ok(()) };
        let MeshFacts { links, fractions, staggered, conformal, tensors, distance, .. } = facts;
        let n_bytes = match (self.what, links, fractions, (staggered, conformal, tensors, distance)) {
            (What::Links(None), Some(links), ..) => self.hdf5(&links::arrays(links), meshed)?,
            (What::Links(Some(format)), Some(links), ..) => {
                file.fill(|out| write_links(links, format, compress, out))?
            }
            (What::Fractions, _, Some(fractions), _) => file.fill(|out| write_fractions(fractions, compress, out))?,
            (What::Solid(format), _, Some(fractions), _) => {
                let options = self.options_of(format);
                file.fill(|out| write_solid(mesh, fractions, (format, &options), out, meshed.control))?
            }
            (What::Staggered, .., (Some(staggered), ..)) => {
                file.fill(|out| write_staggered(staggered, mesh, compress, out))?
            }
            (What::Conformal, .., (_, Some(conformal), ..)) => {
                file.fill(|out| write_conformal(conformal, mesh, compress, out))?
            }
            (What::Distance(None), .., (.., Some(distance))) => self.hdf5(&distance::arrays(distance, mesh), meshed)?,
            (What::Distance(Some(Format::Npz)), .., (.., Some(distance))) => {
                file.fill(|out| write_distance(distance, mesh, compress, out))?
            }
            (What::Distance(Some(format)), .., (.., Some(distance))) => {
                let options = self.options_of(format);
                file.fill(|out| write_distance_cells(mesh, distance, (format, &options), out, meshed.control))?
            }
            (What::Tensors, .., (.., Some(tensors), _)) => {
                file.fill(|out| write_tensors(tensors, mesh, compress, out))?
            }
            _ => return Ok(()),
        };
        written.files.push(file.of_bytes(n_bytes));
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<()> {
        self.file.persist()
    }
}
