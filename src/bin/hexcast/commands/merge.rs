//! `hexcast merge`: the report of a mesh from those of its parts.

use std::io::Read;
use std::path::{Path, PathBuf};

use hexcast::pipeline;
use hexcast::{Error, Result};
use serde_json::Value;

use crate::files::{ledger, output_file::PendingFile};

const EXAMPLES: &str = "\
Examples:
    hexcast merge part*.json > ship.json
    hexcast merge part*.json -o ship.json";

/// Merge the reports of all parts of a mesh (--part K/N --report FILE) into the report of the whole mesh
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    /// Reports of all parts, in any order
    #[arg(value_name = "REPORT.json", required = true)]
    reports: Vec<PathBuf>,
    /// Write the report to a file [default: standard output]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

/// Most bytes of a report: one with a thousand boxes of doubtful cells has a thousandth of it.
const MAX_REPORT_BYTES: u64 = 64 << 20;

pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    arguments.reports.iter().try_for_each(|path| ledger::reads(path))?;
    let output = arguments.output.as_deref().map(PendingFile::open).transpose()?;
    let reports: Vec<Value> = arguments.reports.iter().map(|path| read(path)).collect::<Result<_>>()?;
    let merged = pipeline::merge(&reports)?;
    // what was read as JSON has a JSON form
    let text = format!("{}\n", serde_json::to_string_pretty(&merged).unwrap_or_default());
    match output {
        None => crate::screen::terminal::print_exact(&text),
        Some(mut file) => {
            file.put(&text)?;
            file.persist()
        }
    }
}

fn read(path: &Path) -> Result<Value> {
    let (name, mut text) = (path.display(), Vec::new());
    let read = ledger::open(path)?.take(MAX_REPORT_BYTES).read_to_end(&mut text);
    read.map_err(|error| Error::io(format!("reading {name}"), error))?;
    serde_json::from_slice(&text).map_err(|error| {
        let message = format!("{name} is not the report of a mesh, or has more than {MAX_REPORT_BYTES} bytes: {error}");
        Error::new("job-syntax", message, "give reports that `hexcast mesh --part K/N --report FILE` wrote")
    })
}
