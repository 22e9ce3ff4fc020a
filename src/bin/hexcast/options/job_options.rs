//! The options in a job file: turns keys that are not part of the job into arguments, and all arguments into a job file.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use clap::ArgMatches;
use hexcast::files::place::folder_of;
use hexcast::job::{Job, JobFile, RunJob};
use hexcast::{Error, Result};
use serde_json::Value;

use crate::files::{ledger::Output, output_file::PendingFile, standard_streams};
use crate::options::{
    given::{given, keys_of},
    job_files::{is_json, read_job_file},
};

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
    let is_given = |id: &str| given(of_mesh).any(|given| given == id);
    let options = options(&run, folder)?.into_iter().filter(|(id, _)| !is_given(id) && !is_excluded(id, &is_given));
    let options: Vec<OsString> = options.map(|(_, option)| option).collect();
    if options.is_empty() {
        return Ok(None);
    }
    // before those of the command line, which may end in files after a --
    let command = arguments.iter().position(|argument| argument == "mesh").unwrap_or(1);
    let (before, after) = arguments.split_at((command + 1).min(arguments.len()));
    Ok(Some([before, &options, after].concat()))
}

/// Options that override keys of other names than theirs, and these.
const OTHERS: &[(&str, &[&str])] = &[
    ("cells", CELLS),
    ("dims", CELLS),
    ("cell_size", CELLS),
    ("max_cell_size", &["cells", "dims", "cell_size", "max_cell_size", "lines", "graded"]),
    ("lines", CELLS),
    // they are the domain
    ("lines", &["domain", "padding"]),
    ("graded", CELLS),
    ("domain", &["domain", "padding"]),
    ("padding_cells", &["padding"]),
    ("padding_length", &["padding"]),
    ("window", &["window", "part"]),
    ("part", &["window", "part"]),
    // of `parts`: borders of shards, which the job's key may give
    ("zarr", &[]),
    ("outputs", &["output"]),
    ("links", &["links_output"]),
    ("fractions", &["fractions_output"]),
    ("staggered", &["staggered_output"]),
    ("conformal", &["conformal_output"]),
    ("distance", &["distance_output"]),
    ("tensors", &["tensors_output"]),
];
/// Keys that choose the cells, of which an option replaces all.
const CELLS: &[&str] = &["cells", "dims", "cell_size", "max_cell_size", "tolerance", "lines", "graded"];

/// Keys of a job file that options of the command line override: those of the same names, where nothing else is said.
pub(crate) fn overridden(matches: &ArgMatches) -> Vec<String> {
    let Some((_, of_command)) = matches.subcommand() else { return Vec::new() };
    let keys = given(of_command).flat_map(|id| {
        let others: Vec<_> = OTHERS.iter().filter(|(option, _)| *option == id).map(|(_, keys)| *keys).collect();
        if others.is_empty() { vec![id] } else { others.concat() }
    });
    keys.map(String::from).collect()
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

/// Keys whose options have other names, and those.
const RENAMED: [(&str, &str); 7] = [
    ("output", "outputs"),
    ("links_output", "links"),
    ("fractions_output", "fractions"),
    ("staggered_output", "staggered"),
    ("conformal_output", "conformal"),
    ("distance_output", "distance"),
    ("tensors_output", "tensors"),
];
/// Keys that are names of files.
const FILES: [&str; 10] = [
    "output",
    "report",
    "doubt",
    "links_output",
    "fractions_output",
    "staggered_output",
    "conformal_output",
    "tensors_output",
    "distance_output",
    "spill",
];

/// The names of clap and the arguments, one each, with `=`.
fn options(run: &RunJob, folder: &Path) -> Result<Vec<(String, OsString)>> {
    let place = |name: &str| -> OsString {
        let is_elsewhere = name == standard_streams::NAME || name.contains("://");
        if is_elsewhere { name.into() } else { folder.join(name).into_os_string() }
    };
    let text = |key: &str, text: &str| if FILES.contains(&key) { place(text) } else { text.into() };
    let mut options = Vec::new();
    for (key, value) in keys_of(run)? {
        let key = key.as_str();
        let id = RENAMED.iter().find(|(other, _)| *other == key).map_or(key, |(_, id)| id);
        // clap's name of the option --output is another than the option's
        let option = if key == "output" { key.into() } else { id.replace('_', "-") };
        let mut put = |value: OsString| {
            let mut argument = OsString::from(format!("--{option}="));
            argument.push(value);
            options.push((id.into(), argument));
        };
        match value {
            Value::Bool(true) => options.push((id.into(), format!("--{option}").into())),
            Value::String(one) if key != "map" || !one.is_empty() => put(text(key, &one)),
            Value::Number(number) => put(number.to_string().into()),
            Value::Array(list) if key == "output" => {
                list.iter().filter_map(Value::as_str).for_each(|name| put(place(name)));
            }
            Value::Array(list) if matches!(key, "slice" | "view") => {
                list.into_iter().for_each(|table| put(picture(table, &place)))
            }
            table @ Value::Object(_) => put(picture(table, &place)),
            Value::Array(list) => {
                let words = list.iter().map(|word| word.as_str().map_or(word.to_string(), String::from));
                put(words.collect::<Vec<_>>().join(",").into());
            }
            _ => {}
        }
    }
    Ok(options)
}

/// A picture as the JSON that its option takes, with the place of its file; no name stays none, which the option refuses.
fn picture(mut table: Value, place: &impl Fn(&str) -> OsString) -> OsString {
    let name = table["output"].as_str().filter(|name| !name.is_empty());
    if let Some(placed) = name.map(|name| place(name).to_string_lossy().into_owned()) {
        table["output"] = placed.into();
    }
    table.to_string().into()
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
    let (report, doubt, spill) = (&mut run.report, &mut run.doubt, &mut run.spill);
    let on_lines = [&mut run.staggered_output, &mut run.conformal_output, &mut run.tensors_output];
    let others = [&mut run.links_output, &mut run.fractions_output, &mut run.distance_output];
    for name in [report, doubt, spill].into_iter().chain(on_lines).chain(others).flatten() {
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
    let measured = [&run.links_output, &run.fractions_output, &run.staggered_output, &run.conformal_output];
    let single = [&run.report, &run.doubt, &run.tensors_output, &run.distance_output].into_iter().chain(measured);
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
