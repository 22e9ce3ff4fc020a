//! Pictures among the outputs of `hexcast mesh`.

use std::path::Path;

use hexcast::job::{PlaceJob, RunJob, Several, SliceJob, ViewJob};
use hexcast::lines::Lines;
use hexcast::picture::{Look, Place, Slices, View, slices, view};
use hexcast::{Error, Result};

use crate::commands::pictures::{axis, check_ending, flag_colour};
use crate::files::{
    disk::Planned,
    output::{Asked, List, Meshed, Output, Written},
    output_file::PendingFile,
};

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

/// A picture to be drawn.
struct PictureOutput {
    wanted: Wanted,
    file: PendingFile,
    is_drawn: bool,
    /// Memory for it and the columns.
    max_bytes: u64,
}

impl PictureArguments {
    /// Puts the pictures into a job file.
    pub(crate) fn put(&self, run: &mut RunJob) {
        run.slice = (!self.slice.is_empty()).then(|| Several(self.slice.clone()));
        run.view = (!self.view.is_empty()).then(|| Several(self.view.clone()));
    }

    /// Opens the files.
    pub(crate) fn open(&self, max_bytes: u64) -> Result<List> {
        let slices = self.slice.iter().map(|job| ("slice", &job.output, of_slice(job)));
        let views = self.view.iter().map(|job| ("view", &job.output, of_view(job)));
        let open = |(key, output, wanted): (&str, &String, Result<Wanted>)| -> Result<Box<dyn Output>> {
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
            Ok(Box::new(PictureOutput { wanted, file: PendingFile::open(path)?, is_drawn: false, max_bytes }))
        };
        slices.chain(views).map(open).collect()
    }
}

impl Output for PictureOutput {
    /// Refuses also what does not fit beside the columns of the mesh.
    fn check(&self, asked: &Asked) -> Result<Option<Planned>> {
        let (lines, max_bytes) = (&asked.lines, self.max_bytes.saturating_sub(asked.held_bytes));
        let checked = match &self.wanted {
            Wanted::Slices { .. } => self.wanted.slices(lines, max_bytes).and_then(|slices| slices.check(lines)),
            Wanted::View(_) => self.wanted.view(max_bytes).check(lines.dims()),
        };
        checked.map(|()| None).map_err(|error| error.at(self.file.path.display()))
    }

    /// A view in which no cell is seen is not written, and a warning says so.
    fn write(&mut self, meshed: &Meshed, written: &mut Written) -> Result<()> {
        let &Meshed { mesh, control, .. } = meshed;
        let max_bytes = self.max_bytes.saturating_sub(meshed.held_bytes);
        let drawn = match &self.wanted {
            Wanted::Slices { .. } => {
                self.wanted.slices(mesh.lines(), max_bytes).and_then(|planes| slices(mesh, &planes, control))
            }
            Wanted::View(_) => view(mesh, &self.wanted.view(max_bytes), control),
        };
        match drawn.and_then(|picture| picture.png()) {
            Ok(png) => {
                self.file.put(&png)?;
                self.is_drawn = true;
                written.files.push(self.file.of_bytes(png.len() as u64));
            }
            // all else that is wrong with a view was refused before
            Err(error) if error.code() == "job-value" => {
                written.warnings.push(format!("{} is not written: {error}", self.file.path.display()));
            }
            Err(error) => return Err(error.at(self.file.path.display())),
        }
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<()> {
        if self.is_drawn { self.file.persist() } else { Ok(()) }
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
