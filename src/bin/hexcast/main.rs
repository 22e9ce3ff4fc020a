//! The command line. Files, terminals, clocks and signals are here; what is done with them is in the library.

mod adapters;
mod args;
mod convert;
mod estimate;
mod info;
mod inputs;
mod job_args;
mod mesh;
mod outputs;
mod terminal;

use std::process::ExitCode;

use clap::{CommandFactory, Parser};
use hexcast::Error;

use args::{Cli, Command};

fn main() -> ExitCode {
    let cli = Cli::parse();
    let result = match cli.command {
        Command::Mesh(arguments) => mesh::run(&arguments),
        Command::Info(arguments) => info::run(&arguments),
        Command::Estimate(arguments) => estimate::run(&arguments),
        Command::Adapters { json } => adapters::run(json),
        Command::Convert(arguments) => convert::run(&arguments),
        Command::Completions { shell } => {
            clap_complete::generate(shell, &mut Cli::command(), "hexcast", &mut std::io::stdout());
            Ok(())
        }
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            terminal::show_error(&error);
            ExitCode::from(exit_code(&error))
        }
    }
}

/// The exit code of an error: by who can mend it. 2 is clap's, for usage.
fn exit_code(error: &Error) -> u8 {
    match error {
        Error::File(_) => 3,
        Error::Caller(_) => 4,
        Error::Limit(_) => 5,
        Error::Device(_) => 6,
        Error::System(_) => 7,
        Error::Cancelled => 130,
    }
}
