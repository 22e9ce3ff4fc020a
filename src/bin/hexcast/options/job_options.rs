//! The options in a job file: turns keys that are not part of the job into arguments, and all arguments into a job file.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use clap::ArgMatches;
use clap::parser::ValueSource;
use hexcast::files::place::folder_of;
use hexcast::job::{Job, JobFile, Level, RunJob};
use hexcast::{Error, Result};
use serde::Serialize;

use crate::files::{ledger::Output, output_file::PendingFile, standard_streams};
use crate::options::job_files::{is_json, read_job_file};

/// The arguments of `hexcast mesh` with the options of its job file that they do not have. None where there are none.
///
/// # Errors
/// Those of reading the job file.
pub(crate) fn with_options_of_job(matches: &ArgMatches, arguments: &[OsString]) -> Result<Option<Vec<OsString>>> {
    let Some(("mesh", of_mesh)) = matches.subcommand() else { return Ok(None) };
    let Some(path) = of_mesh.get_one::<PathBuf>("job") else { return Ok(None) };
    let run = read_job_file(path)?.run;
    let folder =
        if standard_streams::is_standard(path) { Path::new("") } else { path.parent().unwrap_or(Path::new("")) };
    let is_given = |id: &str| of_mesh.value_source(id) == Some(ValueSource::CommandLine);
    let options = options(&run, folder).into_iter().filter(|(id, _)| !is_given(id) && !is_excluded(id, &is_given));
    let options: Vec<OsString> = options.map(|(_, option)| option).collect();
    if options.is_empty() {
        return Ok(None);
    }
    // before those of the command line, which may end in files after a --
    let command = arguments.iter().position(|argument| argument == "mesh").unwrap_or(1);
    let (before, after) = arguments.split_at((command + 1).min(arguments.len()));
    Ok(Some([before, &options, after].concat()))
}

/// Options that override keys of other names, and these.
const OTHERS: &[(&str, &[&str])] = &[
    ("cells", CELLS),
    ("dims", CELLS),
    ("cell_size", CELLS),
    ("max_cell_size", &["cells", "dims", "cell_size", "max_cell_size", "lines", "graded"]),
    ("lines", CELLS),
    ("graded", CELLS),
    ("domain", &["domain", "padding"]),
    ("padding_cells", &["padding"]),
    ("padding_length", &["padding"]),
    ("window", &["window", "part"]),
    ("part", &["window", "part"]),
    ("outputs", &["output"]),
    ("links", &["links_output"]),
    ("fractions", &["fractions_output"]),
    ("staggered", &["staggered_output"]),
];
/// Keys that choose the cells, of which an option replaces all.
const CELLS: &[&str] = &["cells", "dims", "cell_size", "max_cell_size", "tolerance", "lines", "graded"];
/// Keys that the option of the same name overrides.
const SAME: &[&str] = &[
    "tolerance",
    "max_cells",
    "halo",
    "halo_edge",
    "rule",
    "open",
    "fill",
    "close_gaps",
    "gap_flag",
    "thin_cells",
    "periodic",
    "conductors",
    "backend",
    "axis",
    "max_memory",
    "unit",
    "background",
    "adapter",
    "threads",
    "max_device_memory",
    "format",
    "report",
    "doubt",
    "compress",
    "hash",
    "axis_order",
    "map",
    "export_flags",
    "patches",
    "open_patches",
    "spill",
    "slice",
    "view",
];

/// Keys of a job file that options of the command line override.
pub(crate) fn overridden(matches: &ArgMatches) -> Vec<&'static str> {
    let Some((_, of_command)) = matches.subcommand() else { return Vec::new() };
    let ids = of_command.ids().map(|id| id.as_str());
    let given = ids.filter(|id| of_command.value_source(id) == Some(ValueSource::CommandLine));
    let keys = given.flat_map(|id| {
        let others = OTHERS.iter().filter(move |(option, _)| *option == id).flat_map(|(_, keys)| keys.iter());
        others.chain(SAME.iter().filter(move |key| **key == id)).copied()
    });
    keys.collect()
}

/// Whether an option of the command line stands in place of another.
fn is_excluded(id: &str, is_given: &impl Fn(&str) -> bool) -> bool {
    match id {
        "quiet" => is_given("verbose"),
        "verbose" => is_given("quiet"),
        "spill" => is_given("resume"),
        "resume" => is_given("spill"),
        _ => false,
    }
}

/// The names of clap and the arguments, one each, with `=`.
fn options(run: &RunJob, folder: &Path) -> Vec<(&'static str, OsString)> {
    let mut options = Vec::new();
    let mut put = |id: &'static str, option: &str, value: Option<OsString>| {
        options.extend(value.map(|value| {
            let mut argument = OsString::from(format!("--{option}="));
            argument.push(value);
            (id, argument)
        }));
    };
    let place = |name: &String| -> OsString {
        let is_elsewhere = name == standard_streams::NAME || name.contains("://");
        if is_elsewhere { name.into() } else { folder.join(name).into_os_string() }
    };
    for name in run.output.iter().flat_map(|names| names.all()) {
        put("outputs", "output", Some(place(name)));
    }
    put("report", "report", run.report.as_ref().map(place));
    put("doubt", "doubt", run.doubt.as_ref().map(place));
    put("links", "links", run.links_output.as_ref().map(place));
    put("fractions", "fractions", run.fractions_output.as_ref().map(place));
    put("staggered", "staggered", run.staggered_output.as_ref().map(place));
    for slice in run.slice.iter().flat_map(|slices| &slices.0) {
        put("slice", "slice", Some(picture(slice.clone(), |slice| &mut slice.output, &place)));
    }
    for view in run.view.iter().flat_map(|views| &views.0) {
        put("view", "view", Some(picture(view.clone(), |view| &mut view.output, &place)));
    }
    put("spill", "spill", run.spill.as_ref().map(place));
    put("format", "format", run.format.as_ref().map(OsString::from));
    let level = |level: &Level| match level {
        Level::Level(level) => level.to_string().into(),
        Level::Word(word) => OsString::from(word),
    };
    put("compress", "compress", run.compress.as_ref().map(level));
    put("hash", "hash", run.hash.as_ref().map(OsString::from));
    put("axis_order", "axis-order", run.axis_order.as_ref().map(OsString::from));
    put("map", "map", run.map.as_ref().filter(|map| !map.is_empty()).map(OsString::from));
    let flags = |flags: &Vec<u8>| flags.iter().map(u8::to_string).collect::<Vec<String>>().join(",").into();
    put("export_flags", "export-flags", run.export_flags.as_ref().map(flags));
    put("patches", "patches", run.patches.as_ref().map(OsString::from));
    put("open_patches", "open-patches", run.open_patches.as_ref().map(|names| names.join(",").into()));
    put("adapter", "adapter", run.adapter.as_ref().map(OsString::from));
    put("max_device_memory", "max-device-memory", run.max_device_memory.map(|size| size.0.to_string().into()));
    put("threads", "threads", run.threads.map(|threads| threads.to_string().into()));
    let switches = [
        ("bits", "--bits", run.bits),
        ("ascii", "--ascii", run.ascii),
        ("resume", "--resume", run.resume),
        ("flags_in_memory", "--flags-in-memory", run.flags_in_memory),
        ("strict", "--strict", run.strict),
        ("json", "--json", run.json),
        ("quiet", "--quiet", run.quiet),
        ("verbose", "--verbose", run.verbose),
    ];
    options.extend(switches.into_iter().filter(|(.., is_on)| *is_on).map(|(id, option, _)| (id, option.into())));
    options
}

/// A picture as the JSON that its option takes, with the place of its file.
fn picture<T: Serialize>(
    mut picture: T,
    output: impl Fn(&mut T) -> &mut String,
    place: &impl Fn(&String) -> OsString,
) -> OsString {
    let name = output(&mut picture);
    // no name stays none, which the option refuses
    if !name.is_empty() {
        *name = place(name).to_string_lossy().into_owned();
    }
    // a struct of numbers and strings always has a JSON form
    serde_json::to_string(&picture).unwrap_or_default().into()
}

/// Writes a job file that does what all arguments do, TOML or JSON by its name; `-` is standard output, in TOML.
///
/// # Errors
/// `io` where it cannot be written; `job-value` where a name is not UTF-8.
pub(crate) fn dump(job: &Job, run: RunJob, path: &Path) -> Result<()> {
    let mut file = PendingFile::open(path)?;
    let is_here = standard_streams::is_standard(path) || folder_of(path) == Path::new(".");
    let place = |name: &str| -> String {
        if is_here || name == standard_streams::NAME || name.contains("://") {
            return name.into();
        }
        // a path is UTF-8 if its last part is and that of the current folder
        std::path::absolute(name).map_or(name.into(), |path| path.to_string_lossy().into_owned())
    };
    let (mut job, mut run) = (job.clone(), run);
    job.geometries.iter_mut().for_each(|geometry| geometry.file = place(&geometry.file));
    let RunJob { report, doubt, spill, links_output, fractions_output, staggered_output, .. } = &mut run;
    for name in [report, doubt, spill, links_output, fractions_output, staggered_output].into_iter().flatten() {
        *name = place(name);
    }
    let slices = run.slice.iter_mut().flat_map(|slices| &mut slices.0).map(|slice| &mut slice.output);
    let views = run.view.iter_mut().flat_map(|views| &mut views.0).map(|view| &mut view.output);
    slices.chain(views).for_each(|name| *name = place(name));
    run.output =
        run.output.map(|names| hexcast::job::Names::Many(names.all().iter().map(|name| place(name)).collect()));
    let made = JobFile::new(job, run);
    outputs(&made.run).filter(|name| *name != standard_streams::NAME).try_for_each(|name| {
        // only to find out whether it could be written beside the job file
        Output::file_of(Path::new(name), PathBuf::from(name)).map(|_| ())
    })?;
    file.put(if is_json(path) { made.to_json() + "\n" } else { made.to_toml()? })?;
    file.persist()
}

/// The files that a job writes.
fn outputs(run: &RunJob) -> impl Iterator<Item = &str> {
    let single = [&run.report, &run.doubt, &run.links_output, &run.fractions_output, &run.staggered_output];
    let slices = run.slice.iter().flat_map(|slices| &slices.0).map(|slice| &slice.output);
    let views = run.view.iter().flat_map(|views| &views.0).map(|view| &view.output);
    let meshes = run.output.iter().flat_map(|names| names.all());
    single.into_iter().flatten().chain(meshes).chain(slices).chain(views).map(String::as_str)
}

/// A path as text of a job file.
///
/// # Errors
/// `job-value` where it is not UTF-8.
pub(crate) fn as_text(path: &Path) -> Result<String> {
    path.to_str().map(String::from).ok_or_else(|| {
        let message = format!("{} is not UTF-8, and job files are", path.display());
        Error::new("job-value", message, "give it another name")
    })
}
