//! The command line: reads the arguments, calls the library, prints. One source file per command.

use std::ffi::OsString;
use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use hexcast::control::CancelToken;
use hexcast::{Error, Result};

mod options {
    pub(crate) mod arguments;
    #[cfg(target_os = "linux")]
    pub(crate) mod device_select;
    pub(crate) mod format_arguments;
    pub(crate) mod given;
    pub(crate) mod job_files;
    pub(crate) mod job_options;
    pub(crate) mod spelling;
}
mod files {
    pub(crate) mod cells_file;
    pub(crate) mod disk;
    pub(crate) mod export_output;
    pub(crate) mod ledger;
    pub(crate) mod measured;
    pub(crate) mod output;
    pub(crate) mod output_file;
    pub(crate) mod outputs;
    pub(crate) mod place_of_store;
    pub(crate) mod reading;
    #[cfg(feature = "s3")]
    pub(crate) mod s3;
    pub(crate) mod spill;
    pub(crate) mod standard_streams;
    pub(crate) mod store;
    pub(crate) mod temporary;
    pub(crate) mod zarr_output;
}
mod screen {
    pub(crate) mod help;
    pub(crate) mod memory;
    pub(crate) mod progress;
    pub(crate) mod summary;
    pub(crate) mod terminal;
}
mod commands {
    pub(crate) mod adapters;
    pub(crate) mod converge;
    pub(crate) mod convert;
    pub(crate) mod diff;
    pub(crate) mod estimate;
    pub(crate) mod info;
    pub(crate) mod job;
    pub(crate) mod leak;
    pub(crate) mod man;
    pub(crate) mod merge;
    pub(crate) mod mesh;
    pub(crate) mod parts;
    pub(crate) mod picture_outputs;
    pub(crate) mod pictures;
    pub(crate) mod refine;
    pub(crate) mod verify;
    pub(crate) mod verify_store;
}

const EXIT_CODES: &str = "\
Exit codes:
    0  done                                      5  larger than a limit or the memory
    1  different: diff found cells that differ   6  the GPU or its driver failed
    2  wrong use of the command line             7  the system refused to read or write a file
    3  an input file cannot be understood        8  warnings, and --strict was given
    4  the job contradicts itself or is          9  found: leak a path, verify or verify-store wrong cells
       impossible                              130  cancelled (Ctrl-C)";

/// Turns closed surfaces (STL, OBJ, OFF, PLY, 3MF, GLB) into Cartesian meshes: exactly, on the GPU or the CPU.
#[derive(Parser)]
#[command(version, after_help = EXIT_CODES, max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Mesh(Box<commands::mesh::Arguments>),
    Info(commands::info::Arguments),
    Job(commands::job::Arguments),
    Estimate(commands::estimate::Arguments),
    Parts(commands::parts::Arguments),
    Merge(commands::merge::Arguments),
    Adapters(commands::adapters::Arguments),
    Convert(commands::convert::Arguments),
    Converge(commands::converge::Arguments),
    Refine(commands::refine::Arguments),
    Slice(commands::pictures::SliceArguments),
    View(commands::pictures::ViewArguments),
    Diff(commands::diff::Arguments),
    Leak(commands::leak::Arguments),
    Verify(commands::verify::Arguments),
    VerifyStore(commands::verify_store::Arguments),
    /// Write a completion script for a shell to standard output
    #[command(
        after_help = "Example:\n    hexcast completions bash > ~/.local/share/bash-completion/completions/hexcast"
    )]
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
    Man(commands::man::Arguments),
}

fn main() -> ExitCode {
    #[cfg(target_os = "linux")]
    options::device_select::disable_without_session();
    let arguments = options::spelling::joined(std::env::args_os());
    let matches = |arguments: &[OsString]| {
        let command = options::spelling::with_negative_numbers(Cli::command());
        screen::help::where_asked(command, arguments).get_matches_from(arguments)
    };
    let mut given = matches(&arguments);
    options::job_files::leave_out(options::job_options::overridden(&given));
    match options::job_options::with_options_of_job(&given, &arguments) {
        Ok(with_options) => given = with_options.map_or(given, |arguments| matches(&arguments)),
        Err(error) => return failed(&error),
    }
    let command = Cli::from_arg_matches(&given).unwrap_or_else(|error| error.exit()).command;
    let token = CancelToken::default();
    let handler_token = token.clone();
    // without a handler Ctrl-C still ends the program, only less politely
    let _ = ctrlc::set_handler(move || handler_token.cancel());
    match run(command, &token) {
        Ok(code) => code,
        Err(error) => failed(&error),
    }
}

fn failed(error: &Error) -> ExitCode {
    screen::terminal::complain_of(error);
    ExitCode::from(screen::terminal::exit_code(error))
}

fn run(command: Command, token: &CancelToken) -> Result<ExitCode> {
    match command {
        Command::Mesh(arguments) => return commands::mesh::run(&arguments, token),
        Command::Leak(arguments) => return commands::leak::run(&arguments, token),
        Command::Diff(arguments) => return commands::diff::run(&arguments, token),
        Command::Info(arguments) => return commands::info::run(&arguments, token),
        Command::Verify(arguments) => return commands::verify::run(&arguments, token),
        Command::VerifyStore(arguments) => return commands::verify_store::run(&arguments, token),
        Command::Job(arguments) => commands::job::run(&arguments),
        Command::Parts(arguments) => commands::parts::run(&arguments, token),
        Command::Merge(arguments) => commands::merge::run(&arguments),
        Command::Estimate(arguments) => commands::estimate::run(&arguments, token),
        Command::Adapters(arguments) => commands::adapters::run(&arguments),
        Command::Convert(arguments) => commands::convert::run(&arguments, token),
        Command::Converge(arguments) => commands::converge::run(&arguments, token),
        Command::Refine(arguments) => commands::refine::run(&arguments, token),
        Command::Slice(arguments) => commands::pictures::slice(&arguments, token),
        Command::View(arguments) => commands::pictures::view_mesh(&arguments, token),
        Command::Completions { shell } => {
            let mut script = Vec::new();
            clap_complete::generate(shell, &mut Cli::command(), "hexcast", &mut script);
            screen::terminal::print_exact(&String::from_utf8_lossy(&script))
        }
        Command::Man(arguments) => commands::man::run(&arguments, screen::help::with_all(Cli::command())),
    }?;
    Ok(ExitCode::SUCCESS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn numbers_out_of_range_are_explained_in_words() {
        let mut n_refused = 0;
        for command in Cli::command().get_subcommands() {
            for option in command.get_arguments().filter_map(|argument| argument.get_long()) {
                for value in ["300", "99999999999", "99999999999999999999999", "-7", "1.5", "much"] {
                    let given = ["hexcast", command.get_name(), &format!("--{option}={value}")];
                    let Err(error) = Cli::command().try_get_matches_from(given) else { continue };
                    let said = error.to_string();
                    let of_rust = ["..=", "too large to fit", "invalid digit", "invalid float", "out of range for"];
                    assert!(!of_rust.iter().any(|words| said.contains(words)), "{given:?}: {said}");
                    n_refused += usize::from(said.contains("invalid value"));
                }
            }
        }
        assert!(n_refused > 100, "{n_refused} values were refused");
    }

    #[test]
    fn every_option_of_mesh_is_a_key_of_the_job_file() {
        let schema: serde_json::Value = serde_json::from_str(include_str!("../../../docs/job.schema.json")).unwrap();
        let keys = schema["properties"].as_object().unwrap();
        let of_geometries = schema["$defs"]["GeometryJob"]["properties"].as_object().unwrap();
        // options that are parts of a key, or have another name where they are given without settings
        let others = [
            ("padding-cells", "padding"),
            ("padding-length", "padding"),
            ("min-size", "graded"),
            ("growth", "graded"),
            ("absorbing", "graded"),
            ("zarr-chunks", "zarr"),
            ("zarr-shards", "zarr"),
            ("zarr-levels", "zarr"),
            ("zarr-sparse", "zarr"),
            ("links", "links_output"),
            ("stencil", "links"),
            ("fluid", "links"),
            ("fractions", "fractions_output"),
            ("fraction-method", "fractions"),
            ("fraction-rays", "fractions"),
            ("fraction-faces", "fractions"),
            ("fraction-surfaces", "fractions"),
            ("fraction-edges", "fractions"),
            ("fraction-centroids", "fractions"),
            ("staggered", "staggered_output"),
            ("metal", "conformal"),
            ("stable", "conformal"),
            ("conformal", "conformal_output"),
            ("distance", "distance_output"),
            ("distance-at", "distance"),
            ("distance-band", "distance"),
            ("distance-flags", "distance"),
            ("tensors", "tensors_output"),
            ("cut", "cut_cells"),
        ];
        let command = Cli::command();
        let mesh = command.find_subcommand("mesh").unwrap();
        let of_file = ["job", "dump-job"];
        let options = mesh.get_arguments().filter_map(|argument| argument.get_long());
        let options: Vec<&str> = options.filter(|option| !of_file.contains(option)).collect();
        for option in &options {
            let key = others.iter().find(|(other, _)| other == option).map(|(_, key)| key.to_string());
            let key = key.unwrap_or_else(|| option.replace('-', "_"));
            assert!(keys.contains_key(&key) || of_geometries.contains_key(&key), "--{option} is no key {key}");
        }
        let of_keys = |key: &str| options.contains(&&*key.replace('_', "-")) || others.iter().any(|(_, of)| *of == key);
        for key in keys.keys().filter(|key| *key != "geometries") {
            assert!(of_keys(key), "the key {key} is no option");
        }
    }
}
