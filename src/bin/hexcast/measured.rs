//! Outputs of what is measured at surfaces: links, and fractions of cells; and staggered grids.

use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use hexcast::job::{Job, LinksJob, RunJob, Stencil};
use hexcast::report::MeshFacts;
use hexcast::write::{Compress, LinksFormat, write_fractions, write_links, write_staggered};
use hexcast::{Error, Mesh, Result};

use super::arguments::choice;
use super::job_options::as_text;
use super::output_file::{OutputFile, PendingFile};

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
    /// Write the fraction that each flag has of the cells that surfaces cut to a file, .npz
    #[arg(long, value_name = "FILE")]
    fractions: Option<PathBuf>,
    /// Rays of --fractions along each axis of a cell: 1, 2, 4, 8 or 16 [default: 4]
    #[arg(long, value_name = "M", requires = "fractions")]
    fraction_rays: Option<u32>,
    /// Write the flags at the points of a staggered (Yee) grid to a file, .npz: edges, faces and cells, and the faces of sheets
    #[arg(long, value_name = "FILE")]
    staggered: Option<PathBuf>,
}

/// Files for what is measured, opened before the long work starts.
pub(crate) struct Measured {
    links: Option<(PendingFile, LinksFormat)>,
    fractions: Option<PendingFile>,
    staggered: Option<PendingFile>,
    compress: Compress,
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
            job.fractions = Some(fractions.with_rays(self.fraction_rays.unwrap_or(fractions.rays)));
        }
        job.staggered |= self.staggered.is_some();
        job.validate()
    }

    /// Whether a file is written that can be compressed.
    pub(crate) fn has_archive(&self) -> bool {
        let of_links = self.links.as_ref().map(|path| LinksFormat::of_name(&path.to_string_lossy()));
        self.fractions.is_some() || self.staggered.is_some() || matches!(of_links, Some(Ok(LinksFormat::Npz)))
    }

    /// Opens the files; none of them may be an output or an input.
    pub(crate) fn open(&self, others: &[&Path], compress: Compress) -> Result<Measured> {
        let mut taken: Vec<PathBuf> = others.iter().filter_map(|other| other.canonicalize().ok()).collect();
        let mut open = |path: &PathBuf| {
            let (place, file) = PendingFile::open(path)?;
            if taken.contains(&place) || others.contains(&path.as_path()) {
                let message = format!("{} is an input or another output, too", path.display());
                return Err(Error::new("job-conflict", message, "give the output another name"));
            }
            taken.push(place);
            Ok(file)
        };
        let links = self.links.as_ref().map(|path| Ok((open(path)?, LinksFormat::of_name(&path.to_string_lossy())?)));
        let is_npz = |path: &Path| path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("npz"));
        for (path, what) in [(&self.fractions, "the fractions of cells are"), (&self.staggered, "a staggered grid is")]
        {
            if let Some(path) = path.as_ref().filter(|path| !is_npz(path)) {
                let message = format!("{}: {what} written as .npz", path.display());
                return Err(Error::new("job-value", message, "use .npz"));
            }
        }
        Ok(Measured {
            links: links.transpose()?,
            fractions: self.fractions.as_ref().map(&mut open).transpose()?,
            staggered: self.staggered.as_ref().map(&mut open).transpose()?,
            compress,
        })
    }
}

impl Measured {
    /// Writes what was measured, and puts the files in their places.
    pub(crate) fn write(self, mesh: &Mesh, facts: &MeshFacts) -> Result<Vec<OutputFile>> {
        let compress = self.compress;
        let mut written = Vec::new();
        if let Some(((file, format), links)) = self.links.zip(facts.links.as_ref()) {
            written.push(put(file, |out| write_links(links, format, compress, out))?);
        }
        if let Some((file, fractions)) = self.fractions.zip(facts.fractions.as_ref()) {
            written.push(put(file, |out| write_fractions(fractions, compress, out))?);
        }
        if let Some((file, staggered)) = self.staggered.zip(facts.staggered.as_ref()) {
            written.push(put(file, |out| write_staggered(staggered, mesh, compress, out))?);
        }
        Ok(written)
    }
}

fn put(file: PendingFile, write: impl FnOnce(&mut dyn Write) -> Result<u64>) -> Result<OutputFile> {
    let mut out = BufWriter::with_capacity(1 << 20, file.temporary.as_file());
    let path = file.path.clone();
    let n_bytes = write(&mut out).map_err(|error| error.at(path.display().to_string()))?;
    drop(out);
    file.persist()?;
    Ok(OutputFile { path, n_bytes })
}
