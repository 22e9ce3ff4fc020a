//! `hexcast convert`: a column file to any format.

use std::fs::File;
use std::io::BufReader;

use hexcast::column_file::read_columns;
use hexcast::error::{Error, Result};

use crate::args::ConvertArgs;
use crate::outputs::Output;
use crate::terminal::{self, bytes, phase};

pub(crate) fn run(arguments: &ConvertArgs) -> Result<()> {
    let input = &arguments.input;
    let output = Output::new(&arguments.output, &arguments.write, &[input])?;
    let bar = terminal::bar(false);
    let control = terminal::control(&bar)?;
    phase(&bar, "reading", false);
    let file = File::open(input).map_err(|error| Error::io(format!("reading {}", input.display()), error))?;
    let mesh = read_columns(&mut BufReader::with_capacity(1 << 20, file)).map_err(|error| error.at(input.display()))?;
    phase(&bar, "writing", false);
    let written = output.write(&mesh, &control)?;
    bar.finish_and_clear();
    println!("{:>12}  {} ({})", "wrote", output.path.display(), bytes(written.n_bytes as f64));
    Ok(())
}
