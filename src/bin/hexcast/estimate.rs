//! `hexcast estimate`: what a mesh would cost.

use hexcast::control::Control;
use hexcast::error::Result;
use hexcast::estimate::estimate;
use hexcast::pipeline::prepare;

use crate::args::EstimateArgs;
use crate::terminal::{bytes, grouped, three};
use crate::{inputs, job_args};

pub(crate) fn run(arguments: &EstimateArgs) -> Result<()> {
    let job = job_args::job(&arguments.job)?;
    let prepared = prepare(&job, inputs::sources(&job, &Control::default())?)?;
    let cost = estimate(&prepared.geometries, &prepared.lines, &prepared.rays);
    if arguments.json {
        println!("{}", serde_json::to_string_pretty(&cost).unwrap_or_default());
        return Ok(());
    }
    let line = |key: &str, value: String| println!("{key:>12}  {value}");
    line("cells", format!("{} = {}", three(cost.dims, " x "), grouped(cost.cells)));
    line("cell size", three(cost.spacing, " x "));
    line("rays", grouped(cost.rays));
    line("crossings", format!("about {}", grouped(cost.crossings as u64)));
    line("columns", format!("about {} in memory", bytes(cost.columns_bytes)));
    line("flags", format!("{} in a file, one byte a cell", bytes(cost.flags_bytes as f64)));
    Ok(())
}
