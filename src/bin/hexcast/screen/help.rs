//! The help of `hexcast mesh`: ten options first, all of them and the formats where more is asked for.

use std::ffi::OsString;

use clap::Command;
use clap::builder::StyledStr;
use hexcast::export::Exporter;
use hexcast::write::Format;

/// What most people need first, which `-h` shows; `--help` shows all.
const FIRST: [&str; 10] =
    ["output", "job", "cells", "cell-size", "domain", "unit", "graded", "open", "report", "backend"];

const EXAMPLES: &str = "\
Examples:
    hexcast mesh part.stl --cells 256 -o part.vti
    hexcast mesh case.stl coil.stl:flag=7,priority=2,name=copper --max-cell-size 0.5 --unit mm -o coil.hxc
    hexcast mesh part.stl --domain -1,-1,0,1,1,2 --dims 200,200,200 -o part.raw -o part.npy --report part.json
    hexcast mesh --job antenna.toml --cells 512 -o antenna.vti --compress=none
    make-model | hexcast mesh - --cells 128 -o - --format npy > part.npy
    hexcast mesh --job ship.toml --part 3/64 -o ship.zarr --report part3.json";

/// What holds on the command line alone, beside the sentences of a key.
const IN_COMMAND: [(&str, &str); 4] = [
    ("max-cells", "Such as 2e12 [default: 1e12]"),
    ("part", "Of K/N the parts are slabs across z that take about the same time; `hexcast parts` lists them"),
    ("max-memory", "[default: 3/4 of the available memory]"),
    ("axis", "Auto takes the longest, or the first of those nearly as long"),
];

/// Words the help where the arguments ask for it: every start of the program would pay for it otherwise.
pub(crate) fn where_asked(command: Command, arguments: &[OsString]) -> Command {
    let is_group = |text: &str| text.starts_with('-') && !text.starts_with("--");
    let asks = |text: &str| matches!(text, "--help" | "help") || is_group(text) && text.contains('h');
    match arguments.iter().filter_map(|argument| argument.to_str()).any(asks) {
        true => with_first_options(with_options_for_keys(command)),
        false => command,
    }
}

/// The command with all of its help, for pages of it.
pub(crate) fn with_all(command: Command) -> Command {
    with_options_for_keys(command).mut_subcommand("mesh", |mesh| mesh.after_help(all_after()))
}

/// Says options where the sentences of a key name other keys of a job: `cell_size` is --cell-size here.
fn with_options_for_keys(command: Command) -> Command {
    command.mut_subcommands(|command| {
        let options: Vec<String> =
            command.get_opts().filter_map(|option| option.get_long()).map(String::from).collect();
        let in_options = |text: &StyledStr| {
            let text = text.to_string();
            let words = text.split('`').enumerate().map(|(at, word)| {
                let is_quoted = at % 2 == 1;
                let option = word.replace('_', "-");
                match is_quoted {
                    true if options.contains(&option) => format!("--{option}"),
                    true => format!("`{word}`"),
                    false => word.to_string(),
                }
            });
            StyledStr::from(words.collect::<String>())
        };
        command.mut_args(|argument| {
            let Some(help) = argument.get_help().map(in_options) else { return argument };
            let more = IN_COMMAND.iter().find(|(option, _)| argument.get_long() == Some(option));
            argument.help(more.map_or(help.to_string(), |(_, more)| format!("{help}. {more}")))
        })
    })
}

/// Gives `mesh` a short help of its first options.
fn with_first_options(command: Command) -> Command {
    command.mut_subcommand("mesh", |mesh| {
        let n_options = mesh.get_opts().count() + mesh.get_positionals().count();
        let rest = format!("{EXAMPLES}\n\nAll {n_options} arguments, and the formats: hexcast mesh --help");
        let of_mesh = mesh.mut_args(|argument| {
            let is_first = argument.is_positional() || argument.get_long().is_some_and(|long| FIRST.contains(&long));
            argument.hide_short_help(!is_first)
        });
        of_mesh.after_help(rest).after_long_help(all_after())
    })
}

/// What follows the options of `mesh` where all are shown.
fn all_after() -> String {
    format!("{EXAMPLES}\n\n{}", formats())
}

/// The formats, by the names of outputs.
fn formats() -> String {
    let cells = Format::ALL.into_iter().map(|format| (format!(".{}", format.extension()), format.about().to_string()));
    let exporters = Exporter::ALL.into_iter().map(|exporter| {
        let (ending, _) = Exporter::ENDINGS.into_iter().find(|(_, of)| *of == exporter).expect("each has one");
        let on_disk = [exporter.on_disk()].into_iter().filter(|text| !text.is_empty());
        let about = [exporter.about()].into_iter().chain(on_disk).collect::<Vec<_>>().join("; ");
        (ending.to_string(), format!("{}: {about}", exporter.program()))
    });
    let rows = cells.chain(exporters).map(|(ending, about)| format!("\n    {ending:<13} {about}"));
    format!("Formats, by the name of the output:{}", rows.collect::<String>())
}
