//! The job file of the command line: a job, and what else `hexcast mesh` has options for. Natively only.

use serde::{Deserialize, Serialize};

use super::text::{check_json, of_toml, toml_table};
use super::{ByteSize, Job, Several, SliceJob, ViewJob};
use crate::base::error::{Error, Result};

mod keys;

use keys::{names, of_keys};

/// What `hexcast mesh` does with a mesh: the keys of a job file that are no part of the job. Each is the option of that name.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(any(test, feature = "testing"), derive(schemars::JsonSchema))]
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
    /// File for the fractions of cut cells, `.npz`; or for the fraction of every cell that is not background, `.vti`, `.vtr`, `.npy`, `.zarr` or `.zarr.zip`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fractions_output: Option<String>,
    /// File for the flags of a staggered grid, `.npz`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub staggered_output: Option<String>,
    /// File for edges and faces outside metal, `.npz`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub conformal_output: Option<String>,
    /// File for signed distances, `.npz`, `.npy`, `.h5`, `.vti` or `.vtr`; at the centres of cells also `.zarr` or `.zarr.zip`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distance_output: Option<String>,
    /// File for smoothed permittivity, `.npz`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tensors_output: Option<String>,
    /// Slices of the mesh as pictures, one table or a list of them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slice: Option<Several<SliceJob>>,
    /// Views of the surface of the mesh as pictures, one table or a list of them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub view: Option<Several<ViewJob>>,
    /// zlib level of outputs, 1 to 9, or "none"; by default 6.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub compress: Option<Level>,
    /// Writes `.raw` and `.npy` with eight cells per byte.
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
    /// By what patches and surfaces of exported files are named: "side", "neighbour" or "solid"; by default "side".
    #[serde(skip_serializing_if = "Option::is_none")]
    pub patches: Option<String>,
    /// Solids whose patches a fluid flows through.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub open_patches: Option<Vec<String>>,
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
    /// Number of threads, 1 to 1024; by default one per core, and at most one for every 8 MB of `max_memory`, but two.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub threads: Option<u16>,
    /// Expands all flags in memory, to take the time.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub flags_in_memory: bool,
    /// Ends with exit code 8 if there are warnings; that `auto` found no GPU to use is not counted.
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
#[cfg_attr(any(test, feature = "testing"), derive(schemars::JsonSchema))]
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
#[cfg_attr(any(test, feature = "testing"), derive(schemars::JsonSchema))]
#[serde(untagged, expecting = "1 to 9 or \"none\" is needed")]
pub enum Level {
    /// 1 (fast) to 9 (small).
    Level(u8),
    /// "none".
    Word(String),
}

/// A job file: the job, and what the command line does with its mesh.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
#[cfg_attr(any(test, feature = "testing"), derive(schemars::JsonSchema))]
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
        JobFile::from_toml_without(text, &[])
    }

    /// The same without some keys, which are not looked at: options override them.
    ///
    /// # Errors
    /// Those of [`JobFile::from_toml`].
    pub fn from_toml_without(text: &str, overridden: &[&str]) -> Result<JobFile> {
        let [mut of_run, mut of_job] = [toml_table(text)?, toml_table(text)?];
        for (table, is_run) in [(&mut of_run, true), (&mut of_job, false)] {
            let is_other = |key: &str| is_of_run(key) != is_run || overridden.contains(&key);
            let others: Vec<_> = table.get_ref().keys().filter(|key| is_other(key.get_ref())).cloned().collect();
            others.iter().for_each(|key| _ = table.get_mut().remove(key));
        }
        Ok(JobFile { run: of_toml(of_run, text)?, job: of_toml(of_job, text).map_err(with_run_keys)? })
    }

    /// Reads a job file in JSON. The job is not validated, since options may change it.
    ///
    /// # Errors
    /// Those of [`JobFile::from_toml`].
    pub fn from_json(text: &str) -> Result<JobFile> {
        JobFile::from_json_without(text, &[])
    }

    /// The same without some keys, which are not looked at: options override them.
    ///
    /// # Errors
    /// Those of [`JobFile::from_toml`].
    pub fn from_json_without(text: &str, overridden: &[&str]) -> Result<JobFile> {
        check_json(text)?;
        let run = of_keys(text, &|key| is_of_run(key) && !overridden.contains(&key))?;
        let job = of_keys(text, &|key| !is_of_run(key) && !overridden.contains(&key)).map_err(with_run_keys)?;
        Ok(JobFile { run, job })
    }

    /// Writes the file as TOML; reading it back gives the same.
    ///
    /// # Errors
    /// `job-value` where a name has no form in TOML.
    pub fn to_toml(&self) -> Result<String> {
        let failed = |error: toml::ser::Error| Error::new("job-value", format!("the job as TOML: {error}"), "");
        toml::to_string(self).map_err(failed)
    }

    /// Writes the file as JSON; reading it back gives the same.
    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).unwrap_or_default()
    }
}

/// The error of a key that there is not names those of runs, too.
fn with_run_keys(error: Error) -> Error {
    let message = error.to_string();
    if !message.contains("; keys are `geometries`") {
        return error;
    }
    let keys: Vec<String> = names::<RunJob>().iter().map(|key| format!("`{key}`")).collect();
    let keys = keys.join(", ");
    Error::new(error.code(), format!("{message}, {keys}"), error.hint())
}

fn is_of_run(key: &str) -> bool {
    names::<RunJob>().contains(&key)
}

#[cfg(test)]
mod tests;
