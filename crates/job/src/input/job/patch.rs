//! Patches of a job, such as those of the report's remedies.
//!
//! A job, a patch -> the job with what the patch changes. An object changes the keys that it has, null removes a key, and any other value
//! takes the place of the old one, as in JSON Merge Patch. In a list, which a merge patch can only replace, an object has indices as
//! keys; entries that become null are removed last, so that indices are those of the job that is patched.
//! Source: RFC 7396, section 2.

use serde_json::{Map, Value};

use super::Job;
use super::text::{json_value, of_json};
use crate::base::error::{Error, Result};

impl Job {
    /// Applies a patch, such as that of a remedy, and validates the result.
    ///
    /// # Errors
    /// Those of [`Job::from_plain_json`]; `job-value` where the patch is no object, or has an entry that the job does not have.
    pub fn patched(&self, patch: &Value) -> Result<Job> {
        if !patch.is_object() {
            return Err(Error::new("job-value", format!("the patch {patch} is no object"), "give the keys to change"));
        }
        let mut value = json_value(&self.to_json())?;
        apply(&mut value, patch)?;
        let job: Job = of_json(value)?;
        job.validate()?;
        Ok(job)
    }
}

fn apply(value: &mut Value, patch: &Value) -> Result<()> {
    let Value::Object(changes) = patch else {
        *value = patch.clone();
        return Ok(());
    };
    if let Value::Array(list) = value {
        return apply_to_list(list, changes);
    }
    if !value.is_object() {
        *value = Value::Object(Map::new());
    }
    let Value::Object(keys) = value else { return Ok(()) };
    for (key, change) in changes {
        if change.is_null() {
            keys.shift_remove(key);
        } else {
            apply(keys.entry(key.as_str()).or_insert(Value::Null), change)?;
        }
    }
    Ok(())
}

fn apply_to_list(list: &mut Vec<Value>, changes: &Map<String, Value>) -> Result<()> {
    let n = list.len();
    for (key, change) in changes {
        let entry = key.parse().ok().and_then(|index: usize| list.get_mut(index));
        let no_entry = || {
            let message = format!("the patch changes entry \"{key}\" of a list of {n}");
            Error::new("job-value", message, "give the index of an entry, from 0")
        };
        apply(entry.ok_or_else(no_entry)?, change)?;
    }
    list.retain(|entry| !entry.is_null());
    Ok(())
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;
    use crate::input::job::{Fill, GeometryJob, GradedJob, PerAxis};

    fn job() -> Job {
        let geometries = ["a.stl", "b.stl", "c.stl"].map(GeometryJob::new).to_vec();
        let graded = GradedJob { max_size: PerAxis::All(2.0), min_size: None, growth: None, absorbing: None };
        Job { geometries, graded: Some(graded), unit: Some("mm".into()), ..Job::default() }
    }

    #[test]
    fn a_patch_changes_what_it_names_and_nothing_else() {
        let patch = json!({
            "fill": "separating",
            "unit": null,
            "graded": { "min_size": 0.5 },
            "geometries": { "0": null, "2": { "priority": 3, "flag": 7 } },
        });
        let mut expected = job();
        (expected.fill, expected.unit) = (Fill::Separating, None);
        expected.graded.as_mut().unwrap().min_size = Some(0.5);
        (expected.geometries[2].priority, expected.geometries[2].flag) = (3, Some(7));
        expected.geometries.remove(0);
        assert_eq!(job().patched(&patch).unwrap(), expected);
        assert_eq!(job().patched(&json!({})).unwrap(), job());
    }

    #[test]
    fn a_patch_of_what_is_not_there_is_refused() {
        for patch in [
            json!({ "geometries": { "3": { "priority": 1 } } }),
            json!({ "geometries": { "a": { "priority": 1 } } }),
            json!({ "geometries": { "0": { "prioirty": 1 } } }),
            json!({ "cells": "many" }),
            json!([]),
        ] {
            assert_eq!(job().patched(&patch).unwrap_err().code(), "job-value", "{patch}");
        }
    }
}
