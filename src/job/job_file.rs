//! The job file of the command line: a job, and what else `hexcast mesh` has options for. Natively only.

use serde::de::IgnoredAny;
use serde::{Deserialize, Serialize};

use super::{ByteSize, Job, not_valid, of_json, of_toml, on_one_line, toml_table};
use crate::error::{Error, Result};

/// What `hexcast mesh` does with a mesh: the keys of a job file that are no part of the job. Each is the option of that name.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields, expecting = "the options of hexcast mesh")]
#[non_exhaustive]
pub struct RunJob {
    /// Files of the mesh, a name or a list of names; relative to the job file, as all names here. `-` is standard output.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub output: Option<Names>,
    /// Format of an output that is `-`, such as "vti".
    #[serde(skip_serializing_if = "Option::is_none")]
    pub format: Option<String>,
    /// File for the report, as JSON.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub report: Option<String>,
    /// File for a mask of the cells that rays did not decide.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub doubt: Option<String>,
    /// File for the links to walls, `.npz`, `.h5` or `.links`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub links_output: Option<String>,
    /// File for the fractions of cut cells, `.npz`; `.vti`, `.vtr`, `.npy` and `.zarr` have the fraction of every cell that is not background.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fractions_output: Option<String>,
    /// File for the flags of a staggered grid, `.npz`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub staggered_output: Option<String>,
    /// zlib level of outputs, 1 to 9, or "none"; by default 6.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub compress: Option<Level>,
    /// Writes `.raw` and `.npy` with eight cells a byte.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub bits: bool,
    /// "sha256": also makes that hash of all flags.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hash: Option<String>,
    /// Order of the axes in `.raw`, `.npy` and `.npz`, "zyx" or "xyz".
    #[serde(skip_serializing_if = "Option::is_none")]
    pub axis_order: Option<String>,
    /// Numbers written in place of flags in `.raw`, `.npy` and `.npz`, such as "1=0,0=1".
    #[serde(skip_serializing_if = "Option::is_none")]
    pub map: Option<String>,
    /// Flags whose cells are exported for a solver; by default all but 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub export_flags: Option<Vec<u8>>,
    /// Exports text in place of binary numbers.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub ascii: bool,
    /// Folder for columns that exceed the memory allowed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spill: Option<String>,
    /// Keeps finished columns beside the first output, so that the same job continues after an interruption.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub resume: bool,
    /// Part of the name of the GPU to use.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub adapter: Option<String>,
    /// Most memory of a GPU to take, as a number or as text such as "2GB".
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_device_memory: Option<ByteSize>,
    /// Number of threads, 1 to 1024; by default one a core.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub threads: Option<u16>,
    /// Expands all flags in memory, to take the time.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub flags_in_memory: bool,
    /// Ends with exit code 8 if there are warnings.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub strict: bool,
    /// Prints the report as JSON.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub json: bool,
    /// Prints nothing but warnings and errors.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub quiet: bool,
    /// Prints more.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub verbose: bool,
}

/// A name, or several.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(untagged, expecting = "a name or a list of names is needed")]
pub enum Names {
    /// One name.
    One(String),
    /// Any number of names.
    Many(Vec<String>),
}

impl Names {
    /// All names.
    pub fn all(&self) -> &[String] {
        match self {
            Names::One(name) => std::slice::from_ref(name),
            Names::Many(names) => names,
        }
    }
}

/// A zlib level, or the word "none".
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(untagged, expecting = "1 to 9 or \"none\" is needed")]
pub enum Level {
    /// 1 (fast) to 9 (small).
    Level(u8),
    /// "none".
    Word(String),
}

/// A job file: the job, and what the command line does with its mesh.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct JobFile {
    /// What to do with the mesh.
    #[serde(flatten)]
    pub run: RunJob,
    /// What to mesh.
    #[serde(flatten)]
    pub job: Job,
}

impl JobFile {
    /// Joins both.
    pub fn new(job: Job, run: RunJob) -> JobFile {
        JobFile { run, job }
    }

    /// Reads a job file in TOML. The job is not validated, since options may change it.
    ///
    /// # Errors
    /// `job-syntax` and `job-value` as for [`Job::from_toml`].
    pub fn from_toml(text: &str) -> Result<JobFile> {
        let [mut of_run, mut of_job] = [toml_table(text)?, toml_table(text)?];
        for (table, is_run) in [(&mut of_run, true), (&mut of_job, false)] {
            let others: Vec<_> =
                table.get_ref().keys().filter(|key| is_of_run(key.get_ref()) != is_run).cloned().collect();
            others.iter().for_each(|key| _ = table.get_mut().remove(key));
        }
        Ok(JobFile { run: of_toml(of_run, text)?, job: of_toml(of_job, text)? })
    }

    /// Reads a job file in JSON. The job is not validated, since options may change it.
    ///
    /// # Errors
    /// Those of [`JobFile::from_toml`].
    pub fn from_json(text: &str) -> Result<JobFile> {
        let _: IgnoredAny =
            serde_json::from_str(text).map_err(|error| not_valid("JSON", &on_one_line(&error.to_string())))?;
        let value: serde_json::Value =
            serde_json::from_str(text).map_err(|error| not_valid("JSON", &on_one_line(&error.to_string())))?;
        let serde_json::Value::Object(keys) = value else {
            return Err(Error::new("job-value", "the job is not an object of keys", super::HINT));
        };
        let (of_run, of_job) = keys.into_iter().partition(|(key, _)| is_of_run(key));
        let object = serde_json::Value::Object;
        Ok(JobFile { run: of_json(object(of_run))?, job: of_json(object(of_job))? })
    }

    /// Writes the file as TOML; reading it back gives the same.
    ///
    /// # Errors
    /// `job-value` where a name has no form in TOML.
    pub fn to_toml(&self) -> Result<String> {
        let failed = |error: toml::ser::Error| Error::new("job-value", format!("the job as TOML: {error}"), "");
        let [run, job] = [toml::to_string(&self.run).map_err(failed)?, toml::to_string(&self.job).map_err(failed)?];
        Ok(format!("{run}{job}"))
    }

    /// Writes the file as JSON; reading it back gives the same.
    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).unwrap_or_default()
    }
}

/// The keys of [`RunJob`].
pub const RUN_KEYS: &[&str] = &[
    "output",
    "format",
    "report",
    "doubt",
    "compress",
    "bits",
    "links_output",
    "fractions_output",
    "staggered_output",
    "axis_order",
    "map",
    "export_flags",
    "ascii",
    "hash",
    "spill",
    "resume",
    "adapter",
    "max_device_memory",
    "threads",
    "flags_in_memory",
    "strict",
    "json",
    "quiet",
    "verbose",
];

fn is_of_run(key: &str) -> bool {
    RUN_KEYS.contains(&key)
}

#[cfg(test)]
mod tests;
