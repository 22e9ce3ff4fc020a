//! `hexcast slice` and `hexcast view`: pictures of a mesh.

use std::path::{Path, PathBuf};

use hexcast::control::{CancelToken, Control};
use hexcast::mesh::Mesh;
use hexcast::picture::{Look, Picture, Place, Slices, View, slices, view};
use hexcast::{Error, Result};
use indicatif::BinaryBytes;

use crate::files::{
    output_file::PendingFile,
    reading::{check_columns, open_columns},
    standard_streams::is_standard,
};
use crate::options::arguments::{default_max_memory, list, number};
use crate::screen::summary::Table;

const SLICE_EXAMPLES: &str = "\
Examples:
    hexcast slice part.hxc -o part.png
    hexcast slice part.hxc --axis z --at 0.5,1.5 -o part.png
    hexcast slice part.hxc --axis x --at 25% -o part.png";

const VIEW_EXAMPLES: &str = "\
Examples:
    hexcast view part.hxc -o part.png
    hexcast view part.hxc --direction=30,20 --flags 1,3 -o part.png";

/// Draw slices of a mesh as PNG: cells in the colours of their flags, in true proportions
#[derive(clap::Args)]
#[command(after_help = SLICE_EXAMPLES)]
pub(crate) struct SliceArguments {
    /// Axes across the slices [default: x,y,z]
    #[arg(long, value_name = "A,A,...", value_delimiter = ',', value_parser = axis)]
    axis: Vec<usize>,
    /// Places along each axis, in the unit of the mesh or in percent of its length [default: 50%]
    #[arg(long, value_name = "P,P,...", value_delimiter = ',', value_parser = place, allow_hyphen_values = true)]
    at: Vec<Place>,
    /// Pixels of the longest side of the mesh
    #[arg(long, value_name = "PIXELS", default_value = "600", value_parser = number::<u32>)]
    size: u32,
    /// Draw no lines between cells
    #[arg(long)]
    no_lines: bool,
    #[command(flatten)]
    picture: PictureArguments,
}

/// Draw the stair-step surface of a mesh as PNG, seen from a direction, without a display
#[derive(clap::Args)]
#[command(after_help = VIEW_EXAMPLES)]
pub(crate) struct ViewArguments {
    /// Direction to the eye in degrees: around z from the x axis, and up [default: -60,25]
    #[arg(long, value_name = "AROUND,UP", value_parser = list::<f64, 2>, allow_hyphen_values = true)]
    direction: Option<[f64; 2]>,
    /// Cells that are shown: the first on each axis, and the end, exclusive [default: all]
    #[arg(long, value_name = "I0,J0,K0,I1,J1,K1", value_parser = list::<u32, 6>)]
    window: Option<[u32; 6]>,
    /// Pixels of the longer side
    #[arg(long, value_name = "PIXELS", default_value = "1000", value_parser = number::<u32>)]
    size: u32,
    #[command(flatten)]
    picture: PictureArguments,
}

/// Of what a picture is, how it looks, and where it goes.
#[derive(clap::Args)]
struct PictureArguments {
    /// Column file, or - for standard input
    #[arg(value_name = "MESH.hxc")]
    mesh: PathBuf,
    /// Flags that are shown [default: all]
    #[arg(long, value_name = "F,F,...", value_delimiter = ',', value_parser = number::<u8>)]
    flags: Vec<u8>,
    /// Colours of flags, such as 1=d98324
    #[arg(long, value_name = "F=RRGGBB,...", value_delimiter = ',', value_parser = flag_colour)]
    colours: Vec<(u8, [u8; 3])>,
    /// Picture, or - for standard output
    #[arg(short, long, value_name = "OUT.png")]
    output: PathBuf,
    /// Print nothing but errors
    #[arg(short, long)]
    quiet: bool,
}

impl PictureArguments {
    fn look(&self, size: u32, max_bytes: u64) -> Look {
        let look = Look::default().with_size(size).with_flags(self.flags.clone()).with_max_bytes(max_bytes);
        self.colours.iter().fold(look, |look, &(flag, rgb)| look.with_colour(flag, rgb))
    }
}

pub(crate) fn flag_colour(text: &str) -> std::result::Result<(u8, [u8; 3]), String> {
    let found = text.split_once('=').and_then(|(flag, digits)| {
        let digits = digits.strip_prefix('#').unwrap_or(digits);
        let is_right = digits.len() == 6 && digits.bytes().all(|digit| digit.is_ascii_hexdigit());
        let [_, rgb @ ..] = u32::from_str_radix(digits, 16).ok().filter(|_| is_right)?.to_be_bytes();
        Some((flag.parse().ok()?, rgb))
    });
    found.ok_or_else(|| {
        format!("\"{text}\" is not a flag from 0 to 255 and a colour of six hexadecimal digits, such as 1=d98324")
    })
}

pub(crate) fn axis(text: &str) -> std::result::Result<usize, String> {
    ["x", "y", "z"]
        .iter()
        .position(|name| *name == text)
        .ok_or_else(|| format!("\"{text}\" is not an axis: x, y or z is needed"))
}

/// Refuses the name of a picture in another format.
pub(crate) fn check_ending(output: &Path) -> Result<()> {
    if output.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("png")) {
        return Ok(());
    }
    let message = format!("{}: pictures are written to .png only", output.display());
    Err(Error::new("job-value", message, "name a file that ends in .png"))
}

fn place(text: &str) -> std::result::Result<Place, String> {
    text.parse().map_err(|error: Error| error.to_string())
}

pub(crate) fn slice(arguments: &SliceArguments, token: &CancelToken) -> Result<()> {
    drawn(&arguments.picture, token, |mesh, max_bytes, control| {
        let planes = Slices::at(mesh, &arguments.axis, &arguments.at)?.with_lines(!arguments.no_lines);
        slices(mesh, &planes.with_look(arguments.picture.look(arguments.size, max_bytes)), control)
    })
}

pub(crate) fn view_mesh(arguments: &ViewArguments, token: &CancelToken) -> Result<()> {
    drawn(&arguments.picture, token, |mesh, max_bytes, control| {
        let mut wanted = View::default().with_look(arguments.picture.look(arguments.size, max_bytes));
        wanted.direction = arguments.direction.unwrap_or(wanted.direction);
        wanted.cells = arguments.window.map(|ends| [0, 1, 2].map(|axis| ends[axis]..ends[axis + 3]));
        view(mesh, &wanted, control)
    })
}

/// Opens a mesh, draws it, and writes the picture.
fn drawn(
    PictureArguments { mesh: input, output, quiet, .. }: &PictureArguments,
    token: &CancelToken,
    draw: impl FnOnce(&Mesh, u64, &Control) -> Result<Picture>,
) -> Result<()> {
    // first: a missing input is the more useful message
    check_columns(input)?;
    if !is_standard(output) {
        check_ending(output)?;
    }
    let mut file = PendingFile::open(output)?;
    let mut control = Control::default();
    control.cancel = token.clone();
    let max_bytes = default_max_memory().map_or(u64::MAX, |size| size.0);
    let mesh = open_columns(input, max_bytes / 2)?;
    let picture = draw(&mesh, max_bytes / 2, &control)?;
    let png = picture.png()?;
    file.put(&png)?;
    file.persist()?;
    if *quiet || is_standard(output) {
        return Ok(());
    }
    let mut table = Table::default();
    let size = format!("{} x {} pixels", picture.width(), picture.height());
    table.line("written", format!("{} ({size}, {})", output.display(), BinaryBytes(png.len() as u64)));
    crate::screen::terminal::print(&table.finish())
}
