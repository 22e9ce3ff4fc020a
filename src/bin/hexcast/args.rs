//! The arguments, as clap reads them.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};

const EXIT_CODES: &str = "\
Exit codes:
  0    done
  1    unexpected failure
  2    wrong usage
  3    an input file is wrong
  4    the job is wrong
  5    a limit of the format, the program or the machine
  6    the GPU or its driver failed
  7    the system refused to read or write
  130  cancelled";

/// Exact Cartesian meshing of closed surfaces.
#[derive(Parser)]
#[command(version, about, after_help = EXIT_CODES, max_term_width = 100)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Subcommand)]
pub(crate) enum Command {
    /// Mesh surfaces and write the cells' flags.
    #[command(after_help = MESH_EXAMPLES)]
    Mesh(MeshArgs),
    /// Tell what a surface file holds, and whether it is closed.
    Info(InfoArgs),
    /// Tell what a mesh would cost, without making it.
    Estimate(EstimateArgs),
    /// List the GPU adapters of this machine.
    Adapters {
        /// Print JSON.
        #[arg(long)]
        json: bool,
    },
    /// Turn a column file into any output format.
    Convert(ConvertArgs),
    /// Print completions for a shell.
    Completions {
        /// Which shell.
        shell: clap_complete::Shell,
    },
}

const MESH_EXAMPLES: &str = "\
Examples:
  hexcast mesh part.stl --cells 256 -o part.vti
  hexcast mesh coil.stl:flag=7,priority=2,name=copper case.stl --cell-size 0.5 --unit mm -o mesh.npy
  hexcast mesh --job job.toml --report report.json -o mesh.hxc";

#[derive(Args)]
pub(crate) struct JobArgs {
    /// Surfaces: FILE or FILE:flag=7,priority=2,name=copper,scale=0.001,rotate=0/0/90,translate=1/2/3,solid=lid,split=true.
    /// Flags are 1, 2, ... in order where not given.
    pub(crate) files: Vec<String>,
    /// Read the job from a TOML or JSON file; its paths are relative to it, and the options here override its values.
    #[arg(long, value_name = "FILE")]
    pub(crate) job: Option<PathBuf>,
    /// Cubic cells, so many along the longest axis (default 128).
    #[arg(long, value_name = "N", help_heading = "Cells")]
    pub(crate) cells: Option<u32>,
    /// Exactly so many cells on x, y, z.
    #[arg(long, value_name = "NX,NY,NZ", value_parser = numbers::<u32, 3>, help_heading = "Cells")]
    pub(crate) dims: Option<[u32; 3]>,
    /// Cell size: one for all axes, or three.
    #[arg(long, value_name = "S[,SY,SZ]", value_delimiter = ',', help_heading = "Cells")]
    pub(crate) cell_size: Option<Vec<f64>>,
    /// The largest size per axis, at most this, that puts the ends of all bounding boxes on mesh lines.
    #[arg(long, value_name = "S", help_heading = "Cells")]
    pub(crate) max_cell_size: Option<f64>,
    /// How far from a mesh line, in cells, --max-cell-size lets an end lie (default 0.05).
    #[arg(long, value_name = "CELLS", help_heading = "Cells")]
    pub(crate) tolerance: Option<f64>,
    /// Two corners of the box; by default the box around the surfaces.
    #[arg(
        long,
        value_name = "X0,Y0,Z0,X1,Y1,Z1", value_parser = numbers::<f64, 6>, allow_hyphen_values = true,
        help_heading = "Domain"
    )]
    pub(crate) domain: Option<[f64; 6]>,
    /// Whole cells around the surfaces' box, on both sides: one number, or three.
    #[arg(long, value_name = "N[,NY,NZ]", value_delimiter = ',', help_heading = "Domain")]
    pub(crate) padding_cells: Option<Vec<u32>>,
    /// A length around the surfaces' box, on both sides: one number, or three.
    #[arg(
        long,
        value_name = "L[,LY,LZ]",
        value_delimiter = ',',
        conflicts_with = "padding_cells",
        help_heading = "Domain"
    )]
    pub(crate) padding_length: Option<Vec<f64>>,
    /// What is inside: an odd number of crossings, or a winding number other than zero.
    #[arg(long, value_parser = ["parity", "nonzero"])]
    pub(crate) rule: Option<String>,
    /// Who meshes: the GPU where there is one and else the CPU, or one of them alone.
    #[arg(long, value_parser = ["auto", "gpu", "cpu"])]
    pub(crate) backend: Option<String>,
    /// Axis of the rays; the result does not depend on it.
    #[arg(long, value_parser = ["auto", "x", "y", "z"])]
    pub(crate) axis: Option<String>,
    /// Unit of the files' lengths, such as mm: repeated in every output.
    #[arg(long)]
    pub(crate) unit: Option<String>,
    /// Make every solid of the files a geometry of its own.
    #[arg(long)]
    pub(crate) split: bool,
}

#[derive(Args)]
pub(crate) struct WriteArgs {
    /// Compression of .vti and .hxc: none, or a zlib level 1 to 9 [default: 1 for .vti, none for .hxc].
    #[arg(long, value_name = "LEVEL", value_parser = parse_level)]
    pub(crate) compress: Option<u8>,
    /// Eight cells a byte in .raw and .npy, for meshes with a single flag.
    #[arg(long)]
    pub(crate) bits: bool,
}

/// Exactly so many numbers with commas between.
fn numbers<T: std::str::FromStr, const N: usize>(text: &str) -> Result<[T; N], String> {
    let parse = |part: &str| part.trim().parse().map_err(|_| format!("\"{part}\" is no such number"));
    let numbers = text.split(',').map(parse).collect::<Result<Vec<T>, String>>()?;
    let n = numbers.len();
    numbers.try_into().map_err(|_| format!("{N} numbers with commas between are needed, these are {n}"))
}

fn parse_level(text: &str) -> Result<u8, String> {
    match text {
        "none" | "0" => Ok(0),
        _ => text.parse().ok().filter(|level| (1..=9).contains(level)).ok_or("none, or a level from 1 to 9".into()),
    }
}

#[derive(Args)]
pub(crate) struct MeshArgs {
    #[command(flatten)]
    pub(crate) job: JobArgs,
    /// Write the mesh: .vti, .npy, .raw (with .raw.json) or .hxc; may be given several times.
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) write: WriteArgs,
    /// Write the report as JSON.
    #[arg(long, value_name = "FILE")]
    pub(crate) report: Option<PathBuf>,
    /// Print the report as JSON on standard output, and nothing else there.
    #[arg(long)]
    pub(crate) json: bool,
    /// Hash the flags for the report; auto does so up to 2^32 cells, and where a .raw file is written anyway.
    #[arg(long, value_parser = ["auto", "always", "never"], default_value = "auto")]
    pub(crate) hash: String,
    /// Use the GPU whose name contains this; see `hexcast adapters`.
    #[arg(long, value_name = "NAME")]
    pub(crate) adapter: Option<String>,
    /// Threads of the CPU (default: all cores).
    #[arg(long, value_name = "N")]
    pub(crate) threads: Option<usize>,
    /// Print nothing but errors.
    #[arg(short, long, conflicts_with = "json")]
    pub(crate) quiet: bool,
    /// Print more: where every end of a bounding box lies, and all times.
    #[arg(short, long)]
    pub(crate) verbose: bool,
}

#[derive(Args)]
pub(crate) struct EstimateArgs {
    #[command(flatten)]
    pub(crate) job: JobArgs,
    /// Print JSON.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args)]
pub(crate) struct InfoArgs {
    /// Surface files.
    #[arg(required = true)]
    pub(crate) files: Vec<PathBuf>,
    /// Print JSON.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args)]
pub(crate) struct ConvertArgs {
    /// A column file (.hxc).
    pub(crate) input: PathBuf,
    /// The file to write: .vti, .npy, .raw or .hxc.
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) write: WriteArgs,
}
