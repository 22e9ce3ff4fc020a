//! `hexcast man`: the help of the program and of each command as a page for `man`.

use clap::Command;
use hexcast::{Error, Result};

use crate::screen::terminal::print_exact;

/// Write a page for man to standard output
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n    hexcast man > hexcast.1\n    hexcast man mesh > hexcast-mesh.1 && man ./hexcast-mesh.1"
)]
pub(crate) struct Arguments {
    /// The command that the page is of, such as mesh; the program itself without it
    name: Option<String>,
}

pub(crate) fn run(arguments: &Arguments, mut program: Command) -> Result<()> {
    // names and usage of commands are known once they are built
    program.build();
    let of = match &arguments.name {
        None => program.clone(),
        Some(name) => program.find_subcommand(name).cloned().unwrap_or_else(|| refuse(name, &mut program)),
    };
    let mut page = Vec::new();
    clap_mangen::Man::new(of).render(&mut page).map_err(|error| Error::io("making a page for man", error))?;
    print_exact(&String::from_utf8_lossy(&page))
}

/// Ends the program as a command that is not there does.
fn refuse(name: &str, program: &mut Command) -> ! {
    let names: Vec<&str> = program.get_subcommands().map(Command::get_name).collect();
    let message = format!("there is no command \"{name}\": commands are {}", names.join(", "));
    program.error(clap::error::ErrorKind::InvalidValue, message).exit()
}
