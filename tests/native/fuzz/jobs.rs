//! Jobs: TOML, JSON, and the argument that names a file and its settings.

use hexcast::Result;
use hexcast::job::{GeometryJob, Job};

use super::harness::Target;
use super::{MAX_JOB_MESSAGE, assert_error_is_good, kind, measured};

/// Bytes that reading a job may take for each of the text, and besides: a table of the parsers takes some hundred bytes for two
/// brackets, a geometry of `{}` takes 400.
const BYTES: [u64; 2] = [2000, 64 << 10];

const WORDS: &[&str] = &[
    "geometries",
    "[[geometries]]\n",
    "file",
    "solid",
    "split",
    "name",
    "flag",
    "priority",
    "open",
    "fill",
    "shell",
    "invert",
    "scale",
    "rotate",
    "about",
    "translate",
    "domain",
    "padding",
    "cells",
    "dims",
    "cell_size",
    "max_cell_size",
    "tolerance",
    "max_cells",
    "rule",
    "close_gaps",
    "gap_flag",
    "backend",
    "axis",
    "max_memory",
    "unit",
    "length",
    "true",
    "false",
    "null",
    "nan",
    "-inf",
    "1e308",
    "-1e308",
    "5e-324",
    "-0.0",
    "0x7f",
    "1_0",
    "255",
    "256",
    "18446744073709551615",
    "4294967296",
    "-9223372036854775808",
    "\"",
    "'",
    "\"\"\"",
    "=",
    " = ",
    ",",
    ":",
    "/",
    "[",
    "]",
    "{",
    "}",
    "[1, 2, 3]",
    "[0,0,0,1,1,1]",
    "{cells = 2}",
    "{ \"length\": 0.5 }",
    "\\u001b",
    "\\ud800",
    "\\\\",
    "\u{1b}[2J",
    "\u{202e}",
    "é",
    "\u{1f600}",
    "\n",
    "\r",
    "\0",
    "#",
    "2GB",
    "1.5 GiB",
    "winding",
    "separating",
    "conservative",
    "parity",
    "1979-05-27T07:32:00Z",
    ".",
];

/// Checks a job that was read, or the error, and that the job is the same after it was written and read again.
fn check(read: impl Fn() -> Result<Job>, n_bytes: usize, has_lines: bool) -> String {
    let (result, allocated) = measured(&read);
    assert!(allocated <= BYTES[0] * n_bytes as u64 + BYTES[1], "{allocated} bytes of memory for {n_bytes}");
    let job = match result {
        Ok(job) => job,
        Err(error) => {
            assert_error_is_good(&error, MAX_JOB_MESSAGE, has_lines);
            return kind(&error);
        }
    };
    job.validate().expect("what was read is valid");
    let json = job.to_json();
    let again = Job::from_json(&json).unwrap_or_else(|error| panic!("{error}: {json}"));
    assert_eq!(again, job, "{json}");
    assert_eq!(again.to_json(), json);
    let keys = json.matches("\": ").count();
    format!("{} geometries, {keys} keys", job.geometries.len())
}

fn text_of(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn toml_job() {
    let target = Target { name: "job_toml", fixtures: &[], dictionary: WORDS, max_bytes: 4 << 10, executions: 25_000 };
    target.fuzz(
        |_, _| (),
        |bytes| {
            let text = text_of(bytes);
            check(|| Job::from_toml(&text), text.len(), true)
        },
    );
}

#[test]
fn json_job() {
    let target = Target { name: "job_json", fixtures: &[], dictionary: WORDS, max_bytes: 4 << 10, executions: 25_000 };
    target.fuzz(
        |_, _| (),
        |bytes| {
            let text = text_of(bytes);
            check(|| Job::from_json(&text), text.len(), false)
        },
    );
}

#[test]
fn geometry_argument() {
    let target = Target { name: "argument", fixtures: &[], dictionary: WORDS, max_bytes: 2 << 10, executions: 40_000 };
    target.fuzz(
        |_, _| (),
        |bytes| {
            let text = text_of(bytes);
            let read = || {
                let job = set!(Job { geometries: vec![GeometryJob::from_argument(&text)?], ..Job::default() });
                job.validate().map(|()| job)
            };
            check(read, text.len(), false)
        },
    );
}
