//! A job as text: TOML or JSON, and errors with the key and the place in the text.

use serde::de::{DeserializeOwned, DeserializeSeed, IgnoredAny};

use super::quoted::{in_lines, on_one_line, toml_problem};
#[cfg(not(target_arch = "wasm32"))]
use super::serde_messages;
use crate::base::error::{Error, Result};

pub(super) type Table<'t> = toml::Spanned<toml::de::DeTable<'t>>;

/// The keys of a text of TOML.
pub(super) fn toml_table(text: &str) -> Result<Table<'_>> {
    toml::de::DeTable::parse(text).map_err(|error| not_valid("TOML", &in_lines(&toml_problem(text, &error))))
}

/// Reads keys of a text; errors name the key and the line.
pub(super) fn of_toml<T: DeserializeOwned>(table: Table<'_>, text: &str) -> Result<T> {
    serde_path_to_error::deserialize(toml::Deserializer::from(table)).map_err(|error| {
        let key = error.path().to_string();
        let mut inner = error.into_inner();
        inner.set_input(Some(text));
        wrong_value(&key, &in_lines(&toml_problem(text, &inner)))
    })
}

/// Reads keys of a value; errors name the key.
pub(super) fn of_json<T: DeserializeOwned>(value: serde_json::Value) -> Result<T> {
    serde_path_to_error::deserialize(value)
        .map_err(|error| wrong_value(&error.path().to_string(), &on_one_line(&error.inner().to_string())))
}

/// Refuses a text that is not JSON: serde_json also calls some wrong values a syntax error.
pub(super) fn check_json(text: &str) -> Result<()> {
    let read: serde_json::Result<IgnoredAny> = serde_json::from_str(text);
    read.map(|_| ()).map_err(|error| not_valid("JSON", &on_one_line(&error.to_string())))
}

/// The value of a text of JSON, which has no lines and columns.
pub(super) fn json_value(text: &str) -> Result<serde_json::Value> {
    serde_json::from_str(text).map_err(|error| not_valid("JSON", &on_one_line(&error.to_string())))
}

/// Reads a text of JSON; errors name the key, and line and column.
pub(super) fn of_json_text<'de, S: DeserializeSeed<'de>>(text: &'de str, seed: S) -> Result<S::Value> {
    let mut json = serde_json::Deserializer::from_str(text);
    let mut track = serde_path_to_error::Track::new();
    let read = seed.deserialize(serde_path_to_error::Deserializer::new(&mut json, &mut track));
    read.map_err(|error| {
        let place = format!(" at line {} column {}", error.line(), error.column());
        let whole = error.to_string();
        let problem = whole.strip_suffix(&place).unwrap_or(&whole);
        let place = format!("line {}, column {}: ", error.line(), error.column());
        wrong_value_at(&track.path().to_string(), &place, &on_one_line(problem))
    })
}

fn not_valid(language: &str, problem: &str) -> Error {
    Error::new("job-syntax", format!("the job is not valid {language}: {}", problem.trim_end()), HINT)
}

fn wrong_value(key: &str, problem: &str) -> Error {
    wrong_value_at(key, "", problem)
}

fn wrong_value_at(key: &str, place: &str, problem: &str) -> Error {
    // the path of the job itself is "." or nothing
    let key = if matches!(key, "." | "") { "the job" } else { key };
    // the page makes jobs by fields, so that its wasm does without
    #[cfg(not(target_arch = "wasm32"))]
    let problem = &serde_messages::in_words(key, problem);
    Error::new("job-value", format!("{}: {place}{}", on_one_line(key), problem.trim_end()), HINT)
}

const HINT: &str = "compare with the example: hexcast job example, or docs/job.schema.json";
