//! Findings: what the reader of a report should know about a mesh, as data, with what to do about it.
//!
//! A finding has a code of [`CODES`], the geometry, axis, flag and places that it is about, its numbers by name, and a sentence that says
//! all this. The sentence is for people: programs read the rest. A remedy is a patch of the job and the option of the command line that
//! does the same.

use std::collections::BTreeMap;

use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::{Map, Number, Value, json};

/// The code of a finding: one of [`CODES`].
pub type FindingCode = &'static str;

/// "x", "y" or "z".
pub type AxisName = &'static str;

/// How the findings of a code in the reports of parts become those of the whole box.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Merging {
    /// Those of all parts, each once: the parts find the same.
    Same,
    /// They are made anew of what was added up, with the remedies that the parts offer.
    Anew,
}

/// Every code of a finding, how findings of parts are merged, and what it means; reports list findings in this order. Codes are stable; the
/// JavaScript types list the same ones.
pub const CODES: &[(&str, Merging, &str)] = &[
    (
        "gpu-failed",
        Merging::Same,
        "the GPU could not be opened, was lost or computed wrongly, and the CPU meshed what was left",
    ),
    ("file-changed", Merging::Same, "a reader took something in a file otherwise than it stands there, or left it out"),
    ("end-without-line", Merging::Same, "the end of a geometry's box has no line of its own, as others are too close"),
    ("edge-on-line", Merging::Same, "a line lies on an edge of metal, not a third of a cell beside it"),
    ("unit-differs", Merging::Same, "a file is in another unit than the mesh; its numbers are taken as they are"),
    ("fluid-without-geometry", Merging::Same, "no geometry has a flag from which links should begin"),
    ("conductor-thin", Merging::Same, "of perfect conductors only the edges within them conduct on the staggered grid"),
    ("cells-fine", Merging::Same, "the end points lead to cells of less than half the largest size allowed"),
    ("surface-open", Merging::Anew, "a surface is not closed; the winding number or a vote decided where rays did not"),
    ("rays-odd", Merging::Anew, "rays do not leave every geometry that they enter"),
    ("surface-open-parity", Merging::Same, "a surface is not closed, and the rays of one axis decided as they are"),
    (
        "surface-inside-out",
        Merging::Same,
        "the facets of a closed surface face inwards; its cells are right all the same",
    ),
    ("flag-shared", Merging::Same, "two geometries have one flag, which nobody gave to one of them"),
    ("shells-overlap", Merging::Anew, "shells of a geometry overlap, or a cavity is turned the wrong way"),
    ("shell-lost", Merging::Anew, "shells of a geometry, parts of it that are not connected to the rest, have no cell"),
    (
        "volume-off",
        Merging::Anew,
        "the cells of a geometry, or of shells of it, differ in volume from the surface by more than 5 %",
    ),
    ("volume-filled", Merging::Anew, "filled walls have more than 5 % more volume than the surface"),
    ("wall-thin", Merging::Anew, "a geometry has walls of few cells; some may be lost"),
    ("gap-narrow", Merging::Anew, "single background cells lie between two flags"),
    ("no-cell-outside", Merging::Anew, "a geometry has no cell: it lies outside of the domain"),
    ("no-cell-no-area", Merging::Anew, "a geometry has no cell: none of its facets has an area"),
    ("no-cell-thin", Merging::Anew, "a geometry has no cell: it is thinner than a cell"),
    ("no-cell-flat", Merging::Anew, "a geometry has no cell: it lies in a plane"),
    ("no-cell-open", Merging::Anew, "a geometry has no cell: its surface is open and encloses no centre of a cell"),
    ("no-cell-small", Merging::Anew, "a geometry has no cell: it encloses no centre of a cell"),
    ("no-cell-covered", Merging::Anew, "a geometry has no cell: another has them all"),
    ("plate-covered", Merging::Same, "faces of a plate lie within another geometry, which wins"),
];

/// A geometry by its index in the report's `geometries`, from 0, and its name.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(any(test, feature = "testing"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct NamedGeometry {
    /// Its index in `geometries`, from 0.
    pub index: usize,
    /// Its name.
    pub name: String,
}

impl NamedGeometry {
    /// Names a geometry.
    pub fn new(index: usize, name: impl Into<String>) -> NamedGeometry {
        NamedGeometry { index, name: name.into() }
    }
}

/// What helps against what was found.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(any(test, feature = "testing"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Remedy {
    /// What it does, in some words, as on a button.
    pub label: String,
    /// What to change in the job that was given, in the keys of job files. An object changes the keys that it has, and null removes one; what
    /// is no object replaces the value. In `geometries` the keys are indices of the job's entries, from 0.
    pub patch: Value,
    /// What does the same on the command line: an option, or a file with settings in place of that file; null where nothing does.
    pub option: Option<String>,
}

impl Remedy {
    /// A patch of the job, and the option of the command line that does the same.
    pub fn new(label: impl Into<String>, patch: Value, option: impl Into<String>) -> Remedy {
        Remedy { label: label.into(), patch, option: Some(option.into()) }
    }

    /// A patch that no option of the command line stands for.
    pub fn without_option(label: impl Into<String>, patch: Value) -> Remedy {
        Remedy { label: label.into(), patch, option: None }
    }

    /// Sets a key of one of the job's entries, whose file is given.
    pub fn of_entry(label: impl Into<String>, entry: (usize, &str), key: &str, value: Value) -> Remedy {
        Remedy::of_keys(label, entry, &[(key, value)])
    }

    /// Sets some keys of one of the job's entries, whose file is given.
    pub fn of_keys(label: impl Into<String>, (entry, file): (usize, &str), keys: &[(&str, Value)]) -> Remedy {
        let text = |value: &Value| value.as_str().map_or_else(|| value.to_string(), str::to_string);
        let settings: Vec<String> = keys.iter().map(|(key, value)| format!("{key}={}", text(value))).collect();
        let patch: Map<String, Value> = keys.iter().map(|(key, value)| (key.to_string(), value.clone())).collect();
        let option = in_shell(&format!("{file}:{}", settings.join(",")));
        Remedy::new(label, json!({ "geometries": { entry.to_string(): patch } }), option)
    }
}

/// An argument as a shell takes it: in quotes where it has letters that a shell does not leave as they are.
fn in_shell(argument: &str) -> String {
    let is_plain = |letter: char| letter.is_alphanumeric() || "_-./:=,+@%\\".contains(letter);
    match argument.chars().all(is_plain) {
        true => argument.into(),
        false => format!("'{}'", argument.replace('\'', r"'\''")),
    }
}

/// Something that the reader of a report should know.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(any(test, feature = "testing"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Finding {
    /// What it is: a stable word such as `wall-thin`. The documentation lists all.
    #[serde(deserialize_with = "known_code")]
    pub code: FindingCode,
    /// All of it in words.
    pub sentence: String,
    /// The geometry that it is about; null where it is about none, or about several.
    pub geometry: Option<NamedGeometry>,
    /// A second geometry that it is about, such as the one that has the cells of the first.
    pub other: Option<NamedGeometry>,
    /// Number of the shell of the geometry, from 0; null where it is about all of it.
    pub shell: Option<u64>,
    /// The flag whose cells it is about.
    pub flag: Option<u8>,
    /// "x", "y" or "z", where it is about one axis.
    #[serde(deserialize_with = "known_axis")]
    pub axis: Option<AxisName>,
    /// Points where it is, in world coordinates; the most telling first.
    pub points: Vec<[f64; 3]>,
    /// Boxes where it is, in world coordinates, by their least and greatest corners.
    pub boxes: Vec<[[f64; 3]; 2]>,
    /// Its numbers by name.
    pub values: BTreeMap<String, Number>,
    /// What helps; the best first.
    pub remedies: Vec<Remedy>,
}

const AXES: [&str; 3] = ["x", "y", "z"];

impl Finding {
    /// Says a sentence; `code` is one of [`CODES`].
    pub fn new(code: FindingCode, sentence: impl Into<String>) -> Finding {
        debug_assert!(place_of(code) < CODES.len(), "finding {code} is not in CODES");
        Finding {
            code,
            sentence: sentence.into(),
            geometry: None,
            other: None,
            shell: None,
            flag: None,
            axis: None,
            points: Vec::new(),
            boxes: Vec::new(),
            values: BTreeMap::new(),
            remedies: Vec::new(),
        }
    }

    /// Names the geometry that it is about.
    pub fn of_geometry(self, index: usize, name: impl Into<String>) -> Finding {
        Finding { geometry: Some(NamedGeometry::new(index, name)), ..self }
    }

    /// Names a second geometry that it is about.
    pub fn and_geometry(self, index: usize, name: impl Into<String>) -> Finding {
        Finding { other: Some(NamedGeometry::new(index, name)), ..self }
    }

    /// Says which shell of the geometry it is about.
    pub fn of_shell(self, shell: u64) -> Finding {
        Finding { shell: Some(shell), ..self }
    }

    /// Says which flag it is about.
    pub fn of_flag(self, flag: u8) -> Finding {
        Finding { flag: Some(flag), ..self }
    }

    /// Says along which axis it is, 0 to 2.
    pub fn along(self, axis: usize) -> Finding {
        Finding { axis: AXES.get(axis).copied(), ..self }
    }

    /// Says along which axis it is: "x", "y" or "z".
    pub fn along_named(self, axis: AxisName) -> Finding {
        Finding { axis: Some(axis), ..self }
    }

    /// Adds a point where it is.
    pub fn at(mut self, point: [f64; 3]) -> Finding {
        self.points.push(point);
        self
    }

    /// Adds a box where it is.
    pub fn within(mut self, bounds: [[f64; 3]; 2]) -> Finding {
        self.boxes.push(bounds);
        self
    }

    /// Adds a whole number.
    pub fn with_count(mut self, name: &str, n: u64) -> Finding {
        self.values.insert(name.into(), n.into());
        self
    }

    /// Adds a number; one that is not finite is left out.
    pub fn with_value(mut self, name: &str, value: f64) -> Finding {
        self.values.extend(Number::from_f64(value).map(|number| (name.into(), number)));
        self
    }

    /// Whether two say the same, in whatever words.
    pub fn is_same(&self, other: &Finding) -> bool {
        let data = |of: &Finding| Finding { sentence: String::new(), remedies: Vec::new(), ..of.clone() };
        self.code == other.code && data(self) == data(other)
    }

    /// Whether two are about the same, whatever their numbers and places.
    pub fn is_about_same(&self, other: &Finding) -> bool {
        let subject = |of: &Finding| (of.code, of.shell, of.flag, of.axis, of.values.get("other_flag").cloned());
        (subject(self), &self.geometry, &self.other) == (subject(other), &other.geometry, &other.other)
    }

    /// Adds what helps.
    pub fn with_remedy(mut self, remedy: impl Into<Option<Remedy>>) -> Finding {
        self.remedies.extend(remedy.into());
        self
    }
}

/// Puts findings in the order of [`CODES`], those of one code as they are.
pub fn in_order_of_codes(findings: Vec<Finding>) -> Vec<Finding> {
    // a stable sort of the standard library takes 3 kB of wasm
    let mut left: Vec<Option<Finding>> = findings.into_iter().map(Some).collect();
    let mut ordered = Vec::with_capacity(left.len());
    for (code, ..) in CODES {
        let of_code = left.iter_mut().filter(|finding| finding.as_ref().is_some_and(|of| of.code == *code));
        ordered.extend(of_code.filter_map(Option::take));
    }
    ordered
}

/// Their sentences.
pub fn sentences(findings: &[Finding]) -> Vec<String> {
    findings.iter().map(|finding| finding.sentence.clone()).collect()
}

/// How findings of a code are merged.
pub fn merging(code: &str) -> Merging {
    CODES.get(place_of(code)).map_or(Merging::Same, |(_, merging, _)| *merging)
}

fn place_of(code: &str) -> usize {
    CODES.iter().position(|(known, ..)| *known == code).unwrap_or(CODES.len())
}

fn known_code<'de, D: Deserializer<'de>>(deserializer: D) -> Result<FindingCode, D::Error> {
    let code = String::deserialize(deserializer)?;
    let known = CODES.get(place_of(&code)).map(|(known, ..)| *known);
    known.ok_or_else(|| D::Error::custom(format!("\"{code}\" is no code of a finding")))
}

fn known_axis<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<AxisName>, D::Error> {
    let Some(name) = Option::<String>::deserialize(deserializer)? else { return Ok(None) };
    let known = AXES.into_iter().find(|axis| *axis == name);
    known.map(Some).ok_or_else(|| D::Error::custom(format!("\"{name}\" is not x, y or z")))
}
