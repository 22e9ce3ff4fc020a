//! Keys that the command line has, put over those of a job file.

use clap::parser::ValueSource;
use clap::{ArgMatches, Args, Command, FromArgMatches};
use hexcast::job::Job;
use hexcast::{Error, Result};
use serde::Serialize;
use serde_json::{Map, Value};

/// A struct whose fields are arguments, and the names of those that were given.
pub(crate) struct Given<T> {
    keys: T,
    given: Vec<String>,
}

impl<T> Given<T> {
    /// Whether a key was given.
    pub(crate) fn has(&self, key: &str) -> bool {
        self.given.iter().any(|given| given == key)
    }
}

impl Given<Job> {
    /// A job with the keys that were given in place of its own. It has none of the keys that these exclude: the reader of job files leaves
    /// them out.
    pub(crate) fn over(&self, mut job: Job) -> Result<Job> {
        // the only keys that can be long, and no argument changes them so
        let (geometries, lines) = (std::mem::take(&mut job.geometries), job.lines.take());
        let (mut keys, over) = (keys_of(&job)?, keys_of(&self.keys)?);
        keys.extend(over.into_iter().filter(|(key, _)| self.has(key)));
        let mut made: Job = serde_json::from_value(Value::Object(keys)).map_err(failed)?;
        (made.geometries, made.lines) = (geometries, lines);
        Ok(made)
    }
}

/// The keys of a struct that have a value, in their order.
pub(crate) fn keys_of(keys: &impl Serialize) -> Result<Map<String, Value>> {
    match serde_json::to_value(keys).map_err(failed)? {
        Value::Object(keys) => Ok(keys),
        // a struct has keys
        _ => Ok(Map::new()),
    }
}

fn failed(error: serde_json::Error) -> Error {
    Error::new("job-value", format!("the options as keys of a job: {error}"), "")
}

/// The names of clap of what the command line has; a value may be that by default, too.
pub(crate) fn given(matches: &ArgMatches) -> impl Iterator<Item = &str> {
    matches.ids().map(|id| id.as_str()).filter(|id| matches.value_source(id) == Some(ValueSource::CommandLine))
}

impl<T: FromArgMatches> FromArgMatches for Given<T> {
    fn from_arg_matches(matches: &ArgMatches) -> std::result::Result<Given<T>, clap::Error> {
        Ok(Given { given: given(matches).map(String::from).collect(), keys: T::from_arg_matches(matches)? })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> std::result::Result<(), clap::Error> {
        *self = Given::from_arg_matches(matches)?;
        Ok(())
    }
}

impl<T: Args> Args for Given<T> {
    fn augment_args(command: Command) -> Command {
        T::augment_args(command)
    }

    fn augment_args_for_update(command: Command) -> Command {
        T::augment_args_for_update(command)
    }
}
