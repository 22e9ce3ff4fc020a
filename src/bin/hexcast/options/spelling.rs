//! Spellings of arguments that people use and clap does not know: negative numbers, lists with spaces, names that are not UTF-8.

use std::ffi::OsString;

use clap::builder::{OsStringValueParser, TypedValueParser};
use clap::{ArgAction, Command};

/// Options that take a list of numbers.
const LISTS: &[&str] = &[
    "--absorbing",
    "--cell-size",
    "--dims",
    "--direction",
    "--domain",
    "--from",
    "--graded",
    "--padding-cells",
    "--padding-length",
    "--stride",
    "--to",
    "--window",
    "--zarr-chunks",
    "--zarr-shards",
];

/// Lets every option of every command take a negative number, so that its own parser says what is wrong with it.
pub(crate) fn with_negative_numbers(command: Command) -> Command {
    command.mut_subcommands(|command| {
        command.mut_args(|argument| {
            let takes_value = matches!(argument.get_action(), ArgAction::Set | ArgAction::Append);
            let is_option = takes_value && !argument.is_positional();
            if is_option { argument.allow_negative_numbers(true) } else { argument }
        })
    })
}

/// The arguments with `--domain -1 -1 -1 1 1 1` as `--domain -1,-1,-1,1,1,1`: numbers that follow an option of lists are its list. One that
/// begins with a minus is joined to its option, as in `--window=-1,0,0,8,8,8`, so that the option's own parser says what is wrong with it.
pub(crate) fn joined(arguments: impl IntoIterator<Item = OsString>) -> Vec<OsString> {
    let mut joined: Vec<OsString> = Vec::new();
    let mut is_in_list = false;
    for argument in arguments {
        let is_number = argument.to_str().is_some_and(|text| text.trim_end_matches(',').parse::<f64>().is_ok());
        let follows_option = joined.last().and_then(|last| last.to_str()).is_some_and(|last| LISTS.contains(&last));
        match joined.last_mut().filter(|_| is_in_list && is_number) {
            Some(list) => {
                if !list.to_string_lossy().ends_with(',') {
                    list.push(",");
                }
                list.push(argument);
            }
            None => {
                is_in_list = follows_option && is_number;
                match joined.last_mut().filter(|_| follows_option && is_negative_list(&argument)) {
                    Some(option) => {
                        option.push("=");
                        option.push(argument);
                    }
                    None => joined.push(argument),
                }
            }
        }
    }
    joined
}

/// Whether an argument is a list of numbers, or several ones, and begins with a minus.
fn is_negative_list(argument: &OsString) -> bool {
    let is_list = |text: &str| text.split([',', ' ']).all(|number| number.is_empty() || number.parse::<f64>().is_ok());
    argument.to_str().is_some_and(|text| text.starts_with('-') && is_list(&text[1..]) && text.len() > 1)
}

/// Reads the name of an input, which jobs and reports repeat as text.
pub(crate) fn input_name() -> impl TypedValueParser<Value = String> {
    OsStringValueParser::new().try_map(|name| {
        name.into_string().map_err(
            |_| "its name is not UTF-8, and jobs and reports are: rename the file, or pipe it (hexcast ... - < FILE)",
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_after_an_option_of_lists_are_joined_and_nothing_else() {
        let table = [
            ("mesh a.stl --domain -1 -1 -1 1 1 1 -o a.vti", "mesh a.stl --domain=-1,-1,-1,1,1,1 -o a.vti"),
            ("mesh --dims 3, 4, 5 a.stl", "mesh --dims 3,4,5 a.stl"),
            ("mesh --dims 3 4 5 a.stl", "mesh --dims 3,4,5 a.stl"),
            ("mesh --domain -1,-1,0,1,1,1 7.stl", "mesh --domain=-1,-1,0,1,1,1 7.stl"),
            ("mesh --window -1,0,0,8,8,8 a.stl", "mesh --window=-1,0,0,8,8,8 a.stl"),
            ("mesh --dims -o a.vti", "mesh --dims -o a.vti"),
            ("convert - - --window -1,0 --format raw", "convert - - --window=-1,0 --format raw"),
            ("mesh --cells 5 6", "mesh --cells 5 6"),
            ("leak a.hxc --from 1 2 3 --to 4 5 6", "leak a.hxc --from 1,2,3 --to 4,5,6"),
        ];
        for (given, expected) in table {
            let words = |text: &str| text.split(' ').map(OsString::from).collect::<Vec<OsString>>();
            assert_eq!(joined(words(given)), words(expected), "{given}");
        }
    }
}
