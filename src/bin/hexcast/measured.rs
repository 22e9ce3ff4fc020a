//! Outputs of what is measured at surfaces: links, and fractions of cells; and staggered grids.

use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use hexcast::control::Control;
use hexcast::estimate::slab_bytes;
use hexcast::job::{Job, LinksJob, RunJob, Stencil};
use hexcast::mesh::Mesh;
use hexcast::report::MeshFacts;
use hexcast::write::{
    Compress, Format, LinksFormat, Options, write_fractions, write_links, write_solid, write_staggered,
};
use hexcast::{Error, Result};

use super::arguments::choice;
use super::format_arguments::FormatArguments;
use super::job_options::as_text;
use super::output_file::{OutputFile, PendingFile};
use super::taken::Taken;

/// What is measured, and where it goes.
#[derive(clap::Args)]
#[command(next_help_heading = "Output")]
pub(crate) struct MeasuredArguments {
    /// Write the links from cells of the fluid to surfaces to a file, .npz or .links: the fraction of each up to the wall, its facet and geometry
    #[arg(long, value_name = "FILE")]
    links: Option<PathBuf>,
    /// Directions of --links: faces, also corners, also edges, or all [default: D3Q19]
    #[arg(long, visible_alias = "lattice", requires = "links",
          value_parser = choice::<Stencil>(&["D3Q7", "D3Q15", "D3Q19", "D3Q27"]))]
    stencil: Option<Stencil>,
    /// Flags that --links calls fluid [default: 0, the background]
    #[arg(long, value_name = "FLAGS", requires = "links", value_delimiter = ',')]
    fluid: Option<Vec<u8>>,
    /// Write the fraction that each flag has of the cells that surfaces cut to a file, .npz; .vti, .vtr and .npy have the fraction of every cell that
    /// is not background
    #[arg(long, value_name = "FILE")]
    fractions: Option<PathBuf>,
    /// Rays of --fractions along each axis of a cell: 1, 2, 4, 8 or 16 [default: 4]
    #[arg(long, value_name = "M", requires = "fractions")]
    fraction_rays: Option<u32>,
    /// Also measure the fraction that each flag has of each face of these cells
    #[arg(long, requires = "fractions")]
    fraction_faces: bool,
    /// Also measure area, centre and normal of the surface in each cell
    #[arg(long, requires = "fractions")]
    fraction_surfaces: bool,
    /// Write the flags at the points of a staggered (Yee) grid to a file, .npz: edges, faces and cells, and the faces of sheets
    #[arg(long, value_name = "FILE")]
    staggered: Option<PathBuf>,
}

/// Files for what is measured, opened before the long work starts; none is left where this is dropped before [`Measured::finish`].
pub(crate) struct Measured {
    links: Option<(PendingFile, LinksFormat)>,
    fractions: Option<(PendingFile, FractionsFormat)>,
    staggered: Option<PendingFile>,
    compress: Compress,
    slab_bytes: usize,
    written: Vec<OutputFile>,
}

/// What a file of fractions holds.
#[derive(Clone, Copy)]
enum FractionsFormat {
    /// An entry for each flag of each cell that is cut.
    Sparse,
    /// One number for every cell.
    Dense(Format),
}

impl FractionsFormat {
    fn of_name(path: &Path) -> Result<FractionsFormat> {
        let ending = path.extension().unwrap_or_default().to_ascii_lowercase();
        match ending.to_str() {
            Some("npz") => Ok(FractionsFormat::Sparse),
            Some("npy") => Ok(FractionsFormat::Dense(Format::Npy)),
            Some("vti") => Ok(FractionsFormat::Dense(Format::Vti)),
            Some("vtr") => Ok(FractionsFormat::Dense(Format::Vtr)),
            _ => {
                let message = format!("{}: no format of fractions of cells has this ending", path.display());
                Err(Error::new("job-value", message, "use .npz for those of each flag, or .vti, .vtr or .npy"))
            }
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
            let links: LinksJob = job.links.take().unwrap_or_default();
            let stencil = self.stencil.unwrap_or(links.stencil);
            let fluid = self.fluid.clone().unwrap_or_else(|| links.fluid.clone());
            job.links = Some(links.with_stencil(stencil).with_fluid(fluid));
        }
        if self.fractions.is_some() {
            let fractions = job.fractions.unwrap_or_default();
            let fractions = fractions.with_rays(self.fraction_rays.unwrap_or(fractions.rays));
            let fractions = fractions.with_faces(fractions.faces || self.fraction_faces);
            job.fractions = Some(fractions.with_surfaces(fractions.surfaces || self.fraction_surfaces));
        }
        job.staggered |= self.staggered.is_some();
        job.validate()
    }

    /// Whether a file is written that can be compressed.
    pub(crate) fn has_archive(&self) -> bool {
        let of_links = self.links.as_ref().map(|path| LinksFormat::of_name(&path.to_string_lossy()));
        let of_fractions = self.fractions.as_deref().map(FractionsFormat::of_name);
        let is_npy = matches!(of_fractions, Some(Ok(FractionsFormat::Dense(Format::Npy))));
        self.staggered.is_some() || of_fractions.is_some() && !is_npy || matches!(of_links, Some(Ok(LinksFormat::Npz)))
    }

    /// Opens the files, whose places must not be taken.
    pub(crate) fn open(&self, taken: &mut Taken, formats: &FormatArguments, max_bytes: u64) -> Result<Measured> {
        let links_format = |path: &Path| LinksFormat::of_name(&path.to_string_lossy());
        let links = self.links.as_ref().map(|path| Ok((taken.open(path)?, links_format(path)?))).transpose()?;
        let fractions = self.fractions.as_ref().map(|path| Ok((taken.open(path)?, FractionsFormat::of_name(path)?)));
        let staggered = self.staggered.as_ref().map(|path| {
            if !path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("npz")) {
                let message = format!("{}: a staggered grid is written as .npz", path.display());
                return Err(Error::new("job-value", message, "use .npz"));
            }
            taken.open(path)
        });
        Ok(Measured {
            links,
            fractions: fractions.transpose()?,
            staggered: staggered.transpose()?,
            compress: formats.compression(),
            slab_bytes: slab_bytes(max_bytes) as usize,
            written: Vec::new(),
        })
    }
}

impl Measured {
    /// Writes what was measured.
    pub(crate) fn write(&mut self, mesh: &Mesh, facts: &MeshFacts, control: &Control) -> Result<()> {
        let compress = self.compress;
        if let Some(((file, format), links)) = self.links.as_ref().zip(facts.links.as_ref()) {
            self.written.push(put(file, |out| write_links(links, *format, compress, out))?);
        }
        if let Some(((file, format), fractions)) = self.fractions.as_ref().zip(facts.fractions.as_ref()) {
            self.written.push(put(file, |out| match *format {
                FractionsFormat::Sparse => write_fractions(fractions, compress, out),
                FractionsFormat::Dense(format) => {
                    let compress = if format == Format::Npy { Compress::None } else { compress };
                    let options = Options::default().with_compress(compress).with_slab_bytes(self.slab_bytes);
                    write_solid(mesh, fractions, (format, &options), out, control)
                }
            })?);
        }
        if let Some((file, staggered)) = self.staggered.as_ref().zip(facts.staggered.as_ref()) {
            self.written.push(put(file, |out| write_staggered(staggered, mesh, compress, out))?);
        }
        Ok(())
    }

    /// Puts the files in their places.
    pub(crate) fn finish(self) -> Result<Vec<OutputFile>> {
        let (links, fractions) = (self.links.map(|(file, _)| file), self.fractions.map(|(file, _)| file));
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
