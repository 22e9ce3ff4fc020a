//! The command line: reads the arguments, calls the library, prints. One source file per command.

use std::ffi::OsString;
use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use hexcast::control::CancelToken;
use hexcast::{Error, Result};

mod adapters;
mod arguments;
mod converge;
mod convert;
mod counted;
#[cfg(target_os = "linux")]
mod device_select;
mod diff;
mod disk;
mod estimate;
mod export_output;
mod format_arguments;
mod info;
mod job;
mod job_files;
mod job_options;
mod leak;
mod ledger;
mod measured;
mod memory;
mod merge;
mod mesh;
mod numbers;
mod output_file;
mod outputs;
mod parts;
mod picture_outputs;
mod pictures;
mod place_of_store;
mod progress;
mod reading;
#[cfg(feature = "s3")]
mod s3;
mod spelling;
mod spill;
mod standard;
mod store;
mod summary;
mod temporary;
mod terminal;
mod verify;
mod verify_store;
mod zarr_folder;
mod zarr_output;

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
    Mesh(Box<mesh::Arguments>),
    Info(info::Arguments),
    Job(job::Arguments),
    Estimate(estimate::Arguments),
    Parts(parts::Arguments),
    Merge(merge::Arguments),
    Adapters(adapters::Arguments),
    Convert(convert::Arguments),
    Converge(converge::Arguments),
    Slice(pictures::SliceArguments),
    View(pictures::ViewArguments),
    Diff(diff::Arguments),
    Leak(leak::Arguments),
    Verify(verify::Arguments),
    VerifyStore(verify_store::Arguments),
    /// Write a completion script for a shell to standard output
    #[command(
        after_help = "Example:\n    hexcast completions bash > ~/.local/share/bash-completion/completions/hexcast"
    )]
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
}

fn main() -> ExitCode {
    #[cfg(target_os = "linux")]
    device_select::disable_without_session();
    let arguments = spelling::joined(std::env::args_os());
    let matches = |arguments: &[OsString]| spelling::with_negative_numbers(Cli::command()).get_matches_from(arguments);
    let mut given = matches(&arguments);
    job_files::leave_out(job_options::overridden(&given));
    match job_options::with_options_of_job(&given, &arguments) {
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
    terminal::complain_of(error);
    ExitCode::from(terminal::exit_code(error))
}

fn run(command: Command, token: &CancelToken) -> Result<ExitCode> {
    match command {
        Command::Mesh(arguments) => return mesh::run(&arguments, token),
        Command::Leak(arguments) => return leak::run(&arguments, token),
        Command::Diff(arguments) => return diff::run(&arguments, token),
        Command::Info(arguments) => return info::run(&arguments, token),
        Command::Verify(arguments) => return verify::run(&arguments, token),
        Command::VerifyStore(arguments) => return verify_store::run(&arguments, token),
        Command::Job(arguments) => job::run(&arguments),
        Command::Parts(arguments) => parts::run(&arguments, token),
        Command::Merge(arguments) => merge::run(&arguments),
        Command::Estimate(arguments) => estimate::run(&arguments, token),
        Command::Adapters(arguments) => adapters::run(&arguments),
        Command::Convert(arguments) => convert::run(&arguments, token),
        Command::Converge(arguments) => converge::run(&arguments, token),
        Command::Slice(arguments) => pictures::slice(&arguments, token),
        Command::View(arguments) => pictures::view_mesh(&arguments, token),
        Command::Completions { shell } => {
            let mut script = Vec::new();
            clap_complete::generate(shell, &mut Cli::command(), "hexcast", &mut script);
            terminal::print_exact(&String::from_utf8_lossy(&script))
        }
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
            ("links", "links_output"),
            ("stencil", "links"),
            ("fluid", "links"),
            ("fractions", "fractions_output"),
            ("fraction-rays", "fractions"),
            ("fraction-faces", "fractions"),
            ("fraction-surfaces", "fractions"),
            ("staggered", "staggered_output"),
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
