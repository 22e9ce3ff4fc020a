//! `hexcast verify-store`: which shards of a Zarr store are missing or wrong, by their checksums or, with the job, by meshing again.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::{Arc, Mutex, PoisonError};

use hexcast::control::{CancelToken, Control};
use hexcast::job::Levels;
use hexcast::pipeline::{self, Engine, MeshOptions};
use hexcast::write::Options;
use hexcast::write::zarr::{Place, Stored, write_part};
use hexcast::{Error, Result};
use indicatif::HumanCount;
use rayon::prelude::*;
use serde::Serialize;

use crate::files::{ledger, place_of_store, reading, store::Store};
use crate::options::arguments::JobArguments;
use crate::screen::{progress::Progress, terminal};

const EXAMPLES: &str = "\
Examples:
    hexcast verify-store ship.zarr
    hexcast verify-store ship.zarr --job ship.toml
    hexcast verify-store ship.zarr --job ship.toml --part 3/64

Without a job a shard is wrong if it cannot be read: its index has a checksum, and so have its chunks if they are compressed. With the
job, or the arguments of the mesh, every byte of the store must be what this hexcast would write.";

/// Exit code where a shard is missing or wrong.
const WRONG: u8 = 9;

/// Name the missing and wrong shards of a Zarr store, such as one that several processes have filled
#[derive(clap::Args)]
#[command(after_help = EXAMPLES, mut_arg("files", |files| files.required_unless_present("store")))]
pub(crate) struct Arguments {
    /// Zarr folder, or s3://BUCKET/NAME.zarr
    #[arg(value_name = "STORE.zarr")]
    store: PathBuf,
    #[command(flatten)]
    job: JobArguments,
    /// Print what was found as JSON
    #[arg(long, help_heading = "Output")]
    json: bool,
}

/// What is wrong with a store; empty lists where nothing is.
#[derive(Serialize, Default)]
struct Found {
    /// Number of shards that were looked at.
    shards: u64,
    /// Keys that are not there.
    missing: Vec<String>,
    /// Keys whose values are wrong, and why.
    wrong: Vec<Wrong>,
    /// Keys of files that are no part of the store.
    unknown: Vec<String>,
}

#[derive(Serialize)]
struct Wrong {
    key: String,
    problem: String,
}

pub(crate) fn run(arguments: &Arguments, token: &CancelToken) -> Result<ExitCode> {
    arguments.job.set_threads(None)?;
    let name = arguments.store.display();
    ledger::reads(&arguments.store)?;
    let store = place_of_store::open(&arguments.store)?;
    let metadata = store.get(Stored::METADATA).map_err(|error| error.at(name.to_string()))?.ok_or_else(|| {
        let message = format!("{name} is not a Zarr store of flags: it has no {}", Stored::METADATA);
        Error::new("io", message, "name a store that `hexcast mesh -o OUT.zarr` wrote")
    })?;
    let at = |error: Error| error.at(name.to_string());
    let (levels, rule) =
        store.get("zarr.json")?.map_or(Ok(Default::default()), |group| Stored::levels(&group)).map_err(at)?;
    let mut all = vec![Stored::new("", &metadata).map_err(at)?];
    for group in &levels {
        let key = format!("{group}{}", Stored::METADATA);
        let missing = || Error::new("io", format!("it has no {key}"), "mesh it again");
        let metadata = store.get(&key)?.ok_or_else(missing).map_err(at)?;
        all.push(Stored::new(group, &metadata).map_err(at)?);
    }
    let mut found = if arguments.job.has_job() {
        by_job(arguments, &store, (&all, rule), token)?
    } else {
        by_checksums(&store, &all, token)?
    };
    found.missing.sort();
    found.wrong.sort_by(|one, other| one.key.cmp(&other.key));
    if arguments.json {
        // a struct of texts always has a JSON form
        terminal::print_exact(&format!("{}\n", serde_json::to_string_pretty(&found).unwrap_or_default()))?;
    } else {
        terminal::print(&sentences(&name.to_string(), &found))?;
    }
    let is_right = found.missing.is_empty() && found.wrong.is_empty() && found.unknown.is_empty();
    Ok(if is_right { ExitCode::SUCCESS } else { ExitCode::from(WRONG) })
}

/// Keys of shards, known and unknown.
fn shards_of(store: &dyn Store, all: &[Stored]) -> Result<(BTreeSet<String>, BTreeSet<String>)> {
    let mut keys = store.keys(Stored::SHARDS)?;
    keys.extend(store.keys(Stored::LEVELS)?.into_iter().filter(|key| Stored::is_of_shard(key)));
    Ok(keys.into_iter().partition(|key| all.iter().any(|stored| stored.has(key))))
}

/// Reads every shard.
fn by_checksums(store: &Arc<dyn Store>, all: &[Stored], token: &CancelToken) -> Result<Found> {
    let (there, unknown) = shards_of(&**store, all)?;
    let found = Mutex::new(Found { unknown: unknown.into_iter().collect(), ..Found::default() });
    let add = |act: &dyn Fn(&mut Found)| act(&mut found.lock().unwrap_or_else(PoisonError::into_inner));
    let keys = all.iter().flat_map(|stored| stored.keys().map(move |key| (stored, key)));
    keys.par_bridge().try_for_each(|(stored, key)| {
        if token.is_cancelled() {
            return Err(Error::Cancelled);
        }
        add(&|found| found.shards += 1);
        let value = if there.contains(&key) { store.get(&key)? } else { None };
        match value.map(|value| stored.check(&value)) {
            // without the job nobody knows which are left out
            None if stored.is_sparse() => {}
            None => add(&|found| found.missing.push(key.clone())),
            Some(Err(error)) => add(&|found| {
                found.wrong.push(Wrong { key: key.clone(), problem: error.to_string() });
            }),
            Some(Ok(())) => {}
        }
        Ok(())
    })?;
    Ok(found.into_inner().unwrap_or_else(PoisonError::into_inner))
}

/// Meshes the job, or a part of it, and compares what would be written.
fn by_job(
    arguments: &Arguments,
    store: &Arc<dyn Store>,
    (all, rule): (&[Stored], Option<Levels>),
    token: &CancelToken,
) -> Result<Found> {
    let (mut zarr, compress) = all[0].options();
    zarr.levels = rule;
    let mut job = arguments.job.job()?;
    job.zarr = Some(zarr);
    if job.window.is_some() || job.halo.is_some() {
        let message = "the job has a window or a halo, and a store is made of parts";
        return Err(Error::new("job-conflict", message, "remove them, or give --part K/N"));
    }
    let progress = Progress::new(arguments.json);
    let sources = reading::read_job_files(&job, token, progress)?;
    let mut control = Control::default();
    control.cancel = token.clone();
    let mut engine = pollster::block_on(Engine::open(job.backend, arguments.job.adapter.as_deref()))?;
    let options = MeshOptions::default();
    let (mesh, facts) = pollster::block_on(pipeline::mesh(&job, sources, &options, &mut engine, &control))?;
    let place = Place::new(facts.whole.clone(), facts.window.map_or([0; 3], |window| window.first));
    let found = Mutex::new((Found::default(), BTreeSet::new()));
    let comparing = |key: &str, value: &[u8]| {
        let (found, made) = &mut *found.lock().unwrap_or_else(PoisonError::into_inner);
        made.insert(key.to_string());
        compare(&**store, found, key, value)
    };
    let options = Options::default().with_compress(compress).with_zarr(zarr);
    write_part(&mesh, &place, &options, &comparing, &control, |_| ())?;
    let (mut found, made) = found.into_inner().unwrap_or_else(PoisonError::into_inner);
    let (there, unknown) = shards_of(&**store, all)?;
    found.unknown = unknown.into_iter().collect();
    // of a whole mesh: shards that have no flag, and a file where they should have none
    let extra = there.into_iter().filter(|key| job.part.is_none() && !made.contains(key));
    let wrong = |key| Wrong { key, problem: "it has no flag, and a sparse store leaves it out".into() };
    found.wrong.extend(extra.map(wrong));
    Ok(found)
}

/// Compares what the job makes with what is there.
fn compare(store: &dyn Store, found: &mut Found, key: &str, value: &[u8]) -> Result<()> {
    found.shards += u64::from(Stored::is_of_shard(key));
    match store.get(key)? {
        None => found.missing.push(key.into()),
        Some(there) if there != value => {
            let (n, expected) = (there.len(), value.len());
            let problem = format!("its {n} bytes are not the {expected} that the job makes");
            found.wrong.push(Wrong { key: key.into(), problem });
        }
        Some(_) => {}
    }
    Ok(())
}

fn sentences(name: &str, found: &Found) -> String {
    let mut text = String::new();
    found.missing.iter().for_each(|key| text += &format!("Missing: {key}\n"));
    found.wrong.iter().for_each(|of| text += &format!("Wrong: {}: {}\n", of.key, of.problem));
    found.unknown.iter().for_each(|key| text += &format!("No part of the store: {key}\n"));
    let n_shards = HumanCount(found.shards);
    let [missing, wrong, unknown] = [found.missing.len(), found.wrong.len(), found.unknown.len()];
    if [missing, wrong, unknown] == [0; 3] {
        return format!("{name}: {n_shards} shards, all as they should be.\n");
    }
    text +=
        &format!("{name}: {n_shards} shards; files missing {missing}, wrong {wrong}, no part of the store {unknown}. ");
    text + "Mesh the parts of missing and wrong shards again; remove files that are not part of the store.\n"
}
