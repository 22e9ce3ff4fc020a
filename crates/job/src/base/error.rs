//! The one public error type: who is at fault, a stable code, a sentence with the numbers, and what to do.

use std::fmt;

/// What went wrong, and what the reader of the message can do about it.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct Problem {
    /// Stable identifier such as `stl-truncated`; one of [`CODES`].
    pub code: &'static str,
    /// A sentence with the numbers: where, what was found, what was expected.
    pub message: String,
    /// What to do about it; may be empty.
    pub hint: String,
}

/// Every failure of hexcast, by who can fix it.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// An input file cannot be understood.
    #[error("{0}")]
    File(Box<Problem>),
    /// The job asks for something contradictory or impossible.
    #[error("{0}")]
    Caller(Box<Problem>),
    /// The job is sound but larger than a limit of the format, the program or the machine.
    #[error("{0}")]
    Limit(Box<Problem>),
    /// The GPU or its driver failed.
    #[error("{0}")]
    Device(Box<Problem>),
    /// The operating system refused to read or write.
    #[error("{0}")]
    System(Box<Problem>),
    /// The caller asked to stop.
    #[error("cancelled")]
    Cancelled,
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

/// What to do where memory is too small, where no better advice is known.
#[doc(hidden)]
pub const MORE_MEMORY: &str =
    "allow more with max_memory (--max-memory), let columns spill to disk (spill, --spill DIR), or use larger cells";

/// Shorthand for results of this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// Who is at fault for an error code: the variant of [`Error`] that carries it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Actor {
    /// [`Error::File`]
    File,
    /// [`Error::Caller`]
    Caller,
    /// [`Error::Limit`]
    Limit,
    /// [`Error::Device`]
    Device,
    /// [`Error::System`]
    System,
    /// [`Error::Cancelled`]
    Cancelled,
}

/// Every error code, who is at fault and what it means. Codes are stable; the JavaScript types list the same ones.
pub const CODES: &[(&str, Actor, &str)] = &[
    ("cancelled", Actor::Cancelled, "the caller asked to stop"),
    ("stl-empty", Actor::File, "the file holds no facet"),
    ("stl-truncated", Actor::File, "an STL ends before the facets that it announces or begins"),
    ("stl-count", Actor::File, "a binary STL holds more facets than its header announces"),
    ("stl-not-stl", Actor::File, "the bytes are of no format that can be read"),
    ("stl-syntax", Actor::File, "an ASCII STL breaks the grammar on the named line"),
    ("file-syntax", Actor::File, "an OBJ, OFF, PLY, 3MF, GLB or gzip file is wrong at the named place"),
    ("stl-not-finite", Actor::File, "a vertex coordinate is NaN or infinite"),
    ("surface-open", Actor::File, "a geometry is not closed, and the job asks for an error then"),
    ("columns-corrupt", Actor::File, "a column file is damaged or cut short"),
    ("columns-version", Actor::File, "a column file was written by a newer hexcast"),
    ("job-syntax", Actor::Caller, "the job file is not valid TOML or JSON"),
    ("job-value", Actor::Caller, "a value of the job is out of range; the message names the key"),
    ("job-conflict", Actor::Caller, "two values of the job contradict each other"),
    ("output-name", Actor::Caller, "the name of an output is not that of a known format"),
    ("columns-other", Actor::Caller, "the file to resume from holds the columns of something else"),
    ("job-empty", Actor::Caller, "the job names no geometry"),
    ("domain-empty", Actor::Caller, "the domain has no extent along an axis"),
    ("lines-no-common-size", Actor::Caller, "no cell size puts every end point on a mesh line within the tolerance"),
    ("lines-wrong", Actor::Caller, "the lines of an axis are too few, too many, not finite or not ascending"),
    (
        "lines-no-sizes",
        Actor::Caller,
        "no sizes between the least and the largest reach all end points within the growth",
    ),
    ("lines-graded", Actor::Caller, "cells differ in size, and what is asked for needs equal ones"),
    ("lines-too-fine", Actor::Limit, "the lines reach over too many of their smallest cells"),
    (
        "too-many-cells",
        Actor::Limit,
        "an axis has more cells than the exact arithmetic can index, or all have more than max_cells",
    ),
    ("geometry-too-far", Actor::Limit, "a geometry lies so far outside the domain that the snap would be too coarse"),
    ("too-many-facets", Actor::Limit, "more facets than fit the 32-bit index"),
    (
        "too-many-geometries",
        Actor::Limit,
        "more than 65,535 geometries, or more than 255 that cannot be taken together",
    ),
    ("too-many-crossings", Actor::Limit, "a box has more crossings than one device buffer holds"),
    (
        "export-too-large",
        Actor::Limit,
        "a mesh has more cells, faces or points than a format of an exporter can number",
    ),
    ("export-unit", Actor::Caller, "an exporter needs lengths in a unit, and the unit of the mesh is not known"),
    ("export-material", Actor::Caller, "an exporter needs to know what a flag is made of, and the job does not say it"),
    ("cut-open", Actor::System, "a cut cell is not closed, which is an error of hexcast"),
    ("no-metal", Actor::Caller, "edges and faces outside metal are asked for, and no flag is metal"),
    ("no-permittivity", Actor::Caller, "smoothed permittivity is asked for, and what a geometry is made of has none"),
    ("memory", Actor::Limit, "the job needs more memory than the budget allows"),
    ("no-adapter", Actor::Device, "no GPU adapter was found"),
    ("device-failed", Actor::Device, "the GPU driver reported an error"),
    ("device-wrong", Actor::Device, "the GPU driver computes wrongly, and its result was discarded"),
    ("device-lost", Actor::Device, "the GPU device was lost and could not be brought back"),
    ("cad-program", Actor::System, "no program was found that converts a file of CAD, or it failed"),
    ("io", Actor::System, "reading or writing a file failed"),
    ("disposed", Actor::Caller, "in JavaScript: the mesher, mesh or surface was disposed of before the call"),
    ("callback", Actor::Caller, "in JavaScript: the caller's function threw"),
];

impl Error {
    /// Builds the error of a code of [`CODES`]; the code decides the variant.
    pub fn new(code: &'static str, message: impl Into<String>, hint: impl Into<String>) -> Error {
        Error::of(Problem { code, message: message.into(), hint: hint.into() })
    }

    fn of(problem: Problem) -> Error {
        let (code, problem) = (problem.code, Box::new(problem));
        let actor = CODES.iter().find(|(known, ..)| *known == code).map(|(_, actor, _)| *actor);
        match actor {
            Some(Actor::File) => Error::File(problem),
            Some(Actor::Limit) => Error::Limit(problem),
            Some(Actor::Device) => Error::Device(problem),
            Some(Actor::System) => Error::System(problem),
            Some(Actor::Cancelled) => Error::Cancelled,
            Some(Actor::Caller) => Error::Caller(problem),
            None => unreachable!("error code {code} is not in CODES"),
        }
    }

    /// Builds an `io` error that names what was being done.
    pub fn io(doing: impl fmt::Display, error: std::io::Error) -> Error {
        Error::new("io", format!("{doing}: {error}"), "")
    }

    /// The stable code, such as `stl-truncated`.
    pub fn code(&self) -> &'static str {
        self.problem().map_or("cancelled", |problem| problem.code)
    }

    /// What the reader can do about it; may be empty.
    pub fn hint(&self) -> &str {
        self.problem().map_or("", |problem| &problem.hint)
    }

    /// Puts a location, such as a file name, before the message.
    pub fn at(mut self, location: impl fmt::Display) -> Error {
        if let Error::File(p) | Error::Caller(p) | Error::Limit(p) | Error::Device(p) | Error::System(p) = &mut self {
            p.message = format!("{location}: {}", p.message);
        }
        self
    }

    fn problem(&self) -> Option<&Problem> {
        match self {
            Error::File(p) | Error::Caller(p) | Error::Limit(p) | Error::Device(p) | Error::System(p) => Some(p),
            Error::Cancelled => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_code_is_listed_once_and_builds_the_variant_of_its_actor() {
        for (index, (code, actor, _)) in CODES.iter().enumerate() {
            assert!(CODES[..index].iter().all(|(other, ..)| other != code), "{code} is listed twice");
            let error = Error::new(code, "message", "hint");
            assert_eq!(error.code(), *code);
            let variant = match error {
                Error::File(_) => Actor::File,
                Error::Caller(_) => Actor::Caller,
                Error::Limit(_) => Actor::Limit,
                Error::Device(_) => Actor::Device,
                Error::System(_) => Actor::System,
                Error::Cancelled => Actor::Cancelled,
            };
            assert_eq!(variant, *actor, "{code}");
        }
    }

    #[test]
    fn a_location_is_put_before_the_message() {
        let error = Error::new("stl-empty", "no facet", "").at("a.stl");
        assert_eq!(error.to_string(), "a.stl: no facet");
    }
}
