//! `hexcast converge`: one job at several sizes of cells, to choose one.

use std::path::{Path, PathBuf};

use hexcast::control::{CancelToken, Control};
use hexcast::converge::{FlagLevel, Level, converge};
use hexcast::pipeline::Engine;
use hexcast::{Error, Result};
use indicatif::{BinaryBytes, HumanCount};
use plotters::prelude::*;

use crate::files::{output_file::PendingFile, reading::read_job_files};
use crate::options::arguments::{JobArguments, at_least_one};
use crate::screen::{progress::Progress, summary::size, terminal};

const EXAMPLES: &str = "\
Examples:
    hexcast converge part.stl
    hexcast converge case.stl coil.stl --sizes 50,100,200,400 --unit mm -o errors.svg
    hexcast converge --job antenna.toml --json";

/// Mesh at several sizes of cells, and show the errors of volume and area, the time and the bytes of each
///
/// The area is the one seen along each axis, because the area of a stair-step surface does not converge to that of a smooth one.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    #[command(flatten)]
    job: JobArguments,
    /// Cells along the longest side of the box, of each mesh, in place of the cells of a job file
    #[arg(long, value_name = "N,N,...", value_delimiter = ',', default_value = "32,64,128,256", value_parser = at_least_one::<u32>)]
    sizes: Vec<u32>,
    /// Draw the errors against the cells, .svg
    #[arg(short, long, value_name = "GRAPH.svg")]
    output: Option<PathBuf>,
    /// Print the levels as JSON
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(arguments: &Arguments, token: &CancelToken) -> Result<()> {
    let mut job = arguments.job.job()?;
    if !arguments.job.chooses_cells() {
        (job.cells, job.dims, job.cell_size) = (None, None, None);
        (job.max_cell_size, job.tolerance) = (None, None);
    }
    arguments.job.set_threads(job.max_memory)?;
    let output = arguments.output.as_deref().map(open_graph).transpose()?;
    // triangles of files of CAD are those of the smallest cells
    let mut finest = job.clone();
    finest.cells = arguments.sizes.iter().copied().max();
    let sources = read_job_files(&finest, token, Progress::new(arguments.json))?;
    let mut control = Control::default();
    control.cancel = token.clone();
    let levels = pollster::block_on(async {
        let mut engine = Engine::open(job.backend, arguments.job.adapter.as_deref()).await?;
        converge(&job, &sources, &arguments.sizes, &mut engine, &control).await
    })?;
    if let Some(mut file) = output {
        file.put(graph(&levels))?;
        file.persist()?;
    }
    if arguments.json {
        // structs of numbers always have a JSON form
        let json = serde_json::to_value(&levels).unwrap_or_default();
        return terminal::print_exact(&format!("{json:#}\n"));
    }
    terminal::print(&table(&levels, job.unit.as_deref()))
}

/// Opens the file of a graph.
fn open_graph(path: &Path) -> Result<PendingFile> {
    if !path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("svg")) {
        let message = format!("{}: graphs are written to .svg only", path.display());
        return Err(Error::new("job-value", message, "name a file that ends in .svg"));
    }
    PendingFile::open(path)
}

/// A block of lines for each flag, a line for each size.
fn table(levels: &[Level], unit: Option<&str>) -> String {
    let unit = unit.map_or(String::new(), |unit| format!(" {unit}"));
    let mut text = String::new();
    let percent = |error: Option<f64>| error.map_or("-".to_string(), |error| format!("{:+.4} %", 100.0 * error));
    for index in 0..levels.first().map_or(0, |level| level.flags.len()) {
        let FlagLevel { flag, name, .. } = &levels[0].flags[index];
        text += &format!("flag {flag} \"{}\"\n", terminal::one_line(name));
        let head = ["cells", "size", "of the flag", "volume off", "area off", "time", ".hxc", "flags"];
        let rows = levels.iter().map(|level| {
            let found = &level.flags[index];
            let [nx, ny, nz] = level.dims;
            [
                format!("{nx} x {ny} x {nz}"),
                format!("{}{unit}", size(level.spacing)),
                HumanCount(found.cells).to_string(),
                percent(found.volume_error),
                percent(found.area_error),
                format!("{:.3} s", level.seconds),
                BinaryBytes(level.column_bytes).to_string(),
                BinaryBytes(level.flag_bytes).to_string(),
            ]
        });
        let rows: Vec<[String; 8]> = std::iter::once(head.map(String::from)).chain(rows).collect();
        let widths: [usize; 8] =
            std::array::from_fn(|column| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0));
        for row in &rows {
            let cells: Vec<String> = row.iter().zip(widths).map(|(cell, width)| format!("{cell:>width$}")).collect();
            text += &format!("  {}\n", cells.join("  "));
        }
    }
    if levels.iter().any(|level| level.flags.iter().any(|found| found.volume_error.is_none())) {
        text += "No error is given where a surface is open or cut by the domain, or where not only the centres decide the cells (invert, shell, fill).\n";
    }
    text
}

/// The size of errors against cells along the longest side, both on logarithmic axes; errors of 0 have no place there.
fn graph(levels: &[Level]) -> String {
    let longest = |level: &Level| f64::from(level.dims.into_iter().max().unwrap_or(1));
    let n_flags = levels.first().map_or(0, |level| level.flags.len());
    let mut lines: Vec<(String, Vec<(f64, f64)>)> = Vec::new();
    for index in 0..n_flags {
        for (what, of) in
            [("volume", (|of| of.volume_error) as fn(&FlagLevel) -> Option<f64>), ("area", |of| of.area_error)]
        {
            let points = levels.iter().filter_map(|level| Some((longest(level), of(&level.flags[index])?.abs())));
            let points: Vec<(f64, f64)> = points.filter(|(_, error)| *error > 0.0).collect();
            lines.push((format!("{} of \"{}\"", what, terminal::one_line(&levels[0].flags[index].name)), points));
        }
    }
    let all = || lines.iter().flat_map(|(_, points)| points);
    let around = |of: fn(&(f64, f64)) -> f64, empty: [f64; 2]| {
        let found = all().map(of).fold([f64::INFINITY, 0.0], |[low, high], at| [low.min(at), high.max(at)]);
        if found[1] > 0.0 { found } else { empty }
    };
    let [x, y] = [around(|point| point.0, [1.0, 10.0]), around(|point| point.1, [1e-3, 1.0])];
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, (800, 500)).into_drawing_area();
        let draw = || -> std::result::Result<(), Box<dyn std::error::Error + '_>> {
            area.fill(&WHITE)?;
            let mut chart = ChartBuilder::on(&area)
                .margin(20)
                .x_label_area_size(45)
                .y_label_area_size(75)
                .caption("Errors of volume and projected area", ("sans-serif", 20))
                .build_cartesian_2d((x[0] * 0.9..x[1] * 1.1).log_scale(), (y[0] * 0.5..y[1] * 2.0).log_scale())?;
            let percent = |error: &f64| format!("{} %", (error * 100.0 * 1e9).round() / 1e9);
            let whole = |cells: &f64| format!("{cells:.0}");
            let mesh = &mut chart.configure_mesh();
            mesh.x_desc("cells along the longest side")
                .y_desc("error")
                .y_label_formatter(&percent)
                .x_label_formatter(&whole)
                .draw()?;
            for (index, (name, points)) in lines.iter().enumerate() {
                let colour = Palette99::pick(index).to_rgba();
                let drawn = chart.draw_series(LineSeries::new(points.iter().copied(), &colour).point_size(3))?;
                drawn.label(name).legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], colour));
            }
            // errors fall, so that this corner is the emptiest
            let labels = &mut chart.configure_series_labels();
            labels
                .position(SeriesLabelPosition::UpperRight)
                .background_style(WHITE.mix(0.8))
                .border_style(BLACK)
                .draw()?;
            area.present()?;
            Ok(())
        };
        // text in memory takes everything
        let _ = draw();
    }
    text
}
