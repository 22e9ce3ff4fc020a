//! `hexcast job`: an example of a job file, and its schema.

use hexcast::Result;

use crate::screen::terminal;

const EXAMPLE: &str = include_str!("job_example.toml");
const SCHEMA: &str = include_str!("../../../../docs/job.schema.json");

const HELP: &str = "\
A job file says what to mesh and what to do with the mesh, in TOML or JSON: hexcast mesh --job job.toml.
Its keys are the long options of hexcast mesh, with _ for -, and [[geometries]], a table for each surface.
Names in it are relative to the file. Options of the command line override its keys. The commands estimate,
parts, converge, verify and leak take the same file, and of it what they need.

Examples:
    hexcast job example > job.toml
    hexcast mesh part.stl --cells 256 -o part.vti --dump-job job.toml
    hexcast job schema > job.schema.json";

/// Explain the job file: print an example, or its JSON schema
#[derive(clap::Args)]
#[command(after_help = HELP)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    what: What,
}

#[derive(clap::Subcommand)]
enum What {
    /// Print a job file in TOML with every key and a short explanation
    Example,
    /// Print the JSON schema of the job file, for editors that complete and check keys
    Schema,
}

pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    terminal::print_exact(match arguments.what {
        What::Example => EXAMPLE,
        What::Schema => SCHEMA,
    })
}
