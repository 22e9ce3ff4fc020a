//! Pictures among the outputs of `hexcast mesh`.

use std::path::Path;

use hexcast::control::Control;
use hexcast::estimate::Estimate;
use hexcast::job::{PlaceJob, RunJob, Several, SliceJob, ViewJob};
use hexcast::lines::Lines;
use hexcast::mesh::Mesh;
use hexcast::picture::{Look, Place, Slices, View, slices, view};
use hexcast::pipeline::Prepared;
use hexcast::{Error, Result};

use crate::commands::pictures::{axis, check_ending, flag_colour};
use crate::files::output_file::{OutputFile, PendingFile};

/// Pictures that are drawn of the mesh.
#[derive(clap::Args)]
#[command(next_help_heading = "Pictures")]
pub(crate) struct PictureArguments {
    /// Draw slices of the mesh, .png, as `hexcast slice` does, with settings as in part.png:axis=x/z,at=25% (keys: axis, at, lines, size, flags,
    /// colours); may be given several times
    #[arg(long, value_name = "OUT.png")]
    slice: Vec<SliceJob>,
    /// Draw the surface of the mesh, .png, as `hexcast view` does, with settings as in part.png:direction=30/20 (keys: direction, window, size, flags,
    /// colours); may be given several times
    #[arg(long, value_name = "OUT.png")]
    view: Vec<ViewJob>,
}

/// What a picture shows.
enum Wanted {
    Slices { axes: Vec<usize>, places: Vec<Place>, has_lines: bool, look: Look },
    View(View),
}

/// Files for pictures, opened before the long work starts.
pub(crate) struct Pictures {
    files: Vec<(PendingFile, Wanted)>,
    max_bytes: u64,
}

/// Share of the columns that they may take beyond their estimate.
const BEYOND_ESTIMATE: u64 = 4;

impl PictureArguments {
    /// Puts the pictures into a job file.
    pub(crate) fn put(&self, run: &mut RunJob) {
        run.slice = (!self.slice.is_empty()).then(|| Several(self.slice.clone()));
        run.view = (!self.view.is_empty()).then(|| Several(self.view.clone()));
    }

    /// Opens the files.
    pub(crate) fn open(&self, max_bytes: u64) -> Result<Pictures> {
        let slices = self.slice.iter().map(|job| ("slice", &job.output, of_slice(job)));
        let views = self.view.iter().map(|job| ("view", &job.output, of_view(job)));
        let open = |(key, output, wanted): (&str, &String, Result<Wanted>)| {
            if output.is_empty() {
                let message = format!("a {key} is asked for without the name of its file");
                return Err(Error::new(
                    "job-value",
                    message,
                    format!("give output = \"{key}.png\", or --{key} {key}.png"),
                ));
            }
            let path = Path::new(output);
            check_ending(path)?;
            let wanted = wanted.map_err(|error| error.at(path.display()))?;
            Ok((PendingFile::open(path)?, wanted))
        };
        Ok(Pictures { files: slices.chain(views).map(open).collect::<Result<_>>()?, max_bytes })
    }
}

impl Pictures {
    /// Has the program take some of the memory.
    pub(crate) fn beside_program(self, program_bytes: u64) -> Pictures {
        Pictures { max_bytes: self.max_bytes.saturating_sub(program_bytes), ..self }
    }

    /// Refuses what is known to be wrong with a picture before the mesh is made, and what does not fit beside its columns, unless these spill.
    pub(crate) fn check(&self, prepared: &Prepared, spills: bool) -> Result<()> {
        if self.files.is_empty() {
            return Ok(());
        }
        let Prepared { geometries, lines, rays, .. } = prepared;
        let column_bytes = if spills { 0 } else { Estimate::new(geometries, lines, rays).column_bytes };
        let max_bytes = self.max_bytes.saturating_sub(column_bytes + column_bytes / BEYOND_ESTIMATE);
        let lines = &prepared.mesh_lines();
        self.files.iter().try_for_each(|(file, wanted)| {
            let checked = match wanted {
                Wanted::Slices { .. } => wanted.slices(lines, max_bytes).and_then(|slices| slices.check(lines)),
                Wanted::View(_) => wanted.view(max_bytes).check(lines.dims()),
            };
            checked.map_err(|error| error.at(file.path.display()))
        })
    }

    /// Draws all pictures, and puts them in their places. A view in which no cell is seen is not written, and a warning says so.
    pub(crate) fn write(self, mesh: &Mesh, control: &Control) -> Result<(Vec<OutputFile>, Vec<String>)> {
        let max_bytes = self.max_bytes.saturating_sub(mesh.columns().n_bytes());
        let (mut written, mut warnings) = (Vec::new(), Vec::new());
        for (mut file, wanted) in self.files {
            let drawn = match &wanted {
                Wanted::Slices { .. } => {
                    wanted.slices(mesh.lines(), max_bytes).and_then(|planes| slices(mesh, &planes, control))
                }
                Wanted::View(_) => view(mesh, &wanted.view(max_bytes), control),
            };
            let path = file.path.clone();
            match drawn.and_then(|picture| picture.png()) {
                Ok(png) => {
                    file.put(&png)?;
                    file.persist()?;
                    written.push(OutputFile { path, n_bytes: png.len() as u64 });
                }
                // all else that is wrong with a view was refused before
                Err(error) if error.code() == "job-value" => {
                    warnings.push(format!("{} is not written: {error}", path.display()));
                }
                Err(error) => return Err(error.at(path.display())),
            }
        }
        Ok((written, warnings))
    }
}

impl Wanted {
    fn slices(&self, lines: &Lines, max_bytes: u64) -> Result<Slices> {
        let Wanted::Slices { axes, places, has_lines, look } = self else { return Ok(Slices::new(Vec::new())) };
        let look = look.clone().with_max_bytes(max_bytes);
        Ok(Slices::of_lines(lines, axes, places)?.with_lines(*has_lines).with_look(look))
    }

    fn view(&self, max_bytes: u64) -> View {
        let Wanted::View(view) = self else { return View::default() };
        view.clone().with_look(view.look.clone().with_max_bytes(max_bytes))
    }
}

fn of_slice(job: &SliceJob) -> Result<Wanted> {
    let axes =
        job.axis.iter().flat_map(|axes| &axes.0).map(|name| axis(name).map_err(|problem| wrong("axis", &problem)));
    let place = |place: &PlaceJob| match place {
        PlaceJob::Coordinate(at) => at.to_string().parse(),
        PlaceJob::Text(text) => text.parse(),
    };
    let places = job.at.iter().flat_map(|places| &places.0).map(place);
    let look = look(job.size, job.flags.as_ref(), &job.colours)?;
    let (axes, places) = (axes.collect::<Result<_>>()?, places.collect::<Result<_>>()?);
    Ok(Wanted::Slices { axes, places, has_lines: job.lines.unwrap_or(true), look })
}

fn of_view(job: &ViewJob) -> Result<Wanted> {
    let mut view = View::default().with_look(look(job.size, job.flags.as_ref(), &job.colours)?);
    view.direction = job.direction.unwrap_or(view.direction);
    view.cells = job.window.map(|ends| [0, 1, 2].map(|axis| ends[axis]..ends[axis + 3]));
    Ok(Wanted::View(view))
}

fn look<'a>(
    size: Option<u32>,
    flags: Option<&Vec<u8>>,
    colours: impl IntoIterator<Item = (&'a String, &'a String)>,
) -> Result<Look> {
    let mut look = Look::default().with_flags(flags.cloned().unwrap_or_default());
    look.size = size;
    for (flag, rgb) in colours {
        let (flag, rgb) = flag_colour(&format!("{flag}={rgb}")).map_err(|problem| wrong("colours", &problem))?;
        look = look.with_colour(flag, rgb);
    }
    Ok(look)
}

fn wrong(key: &str, problem: &str) -> Error {
    Error::new("job-value", format!("{key}: {problem}"), "")
}
