//! Fuzzing of every reader of bytes from outside: STL, files of polygons and of scenes, job files, arguments of geometries, column files.
//!
//! Each target changes the files of its corpus, `tests/corpus/`, at random and checks properties of what the reader does with
//! them. The seed is fixed and the number of executions too, so that a test run is the same every time.
//! `HEXCAST_FUZZ_SECONDS=60` fuzzes each target for so long instead, with the seed of `HEXCAST_FUZZ_SEED`. What fails is
//! written to a file: once it is fixed, it belongs in the corpus.

mod checksums;
mod column_files;
mod harness;
mod jobs;
mod mutate;
mod polygons;
mod scenes;
mod stl;

use hexcast::Error;
use hexcast::error::CODES;

/// The most characters of a message, that of a job file apart, which quotes a line of it.
const MAX_MESSAGE: usize = 300;
/// The most characters of a message about a job: what it quotes, in two parts, and the sentence around it.
const MAX_JOB_MESSAGE: usize = 1300;

/// Checks an error: a code of the list, a sentence that can be shown. Only the errors of TOML have several lines.
#[track_caller]
fn assert_error_is_good(error: &Error, most: usize, may_have_lines: bool) {
    let message = error.to_string();
    assert!(CODES.iter().any(|(code, ..)| *code == error.code()), "{} is not a code", error.code());
    assert!(!message.trim().is_empty(), "{}: no message", error.code());
    for text in [message.as_str(), error.hint()] {
        let is_odd = |c: char| c.is_control() && !(may_have_lines && matches!(c, '\n' | '\t'));
        assert!(!text.chars().any(is_odd), "control characters in {text:?}");
        assert!(text.chars().count() <= most, "{} characters: {text}", text.chars().count());
    }
}

/// What a result was like, without its numbers and quotations: inputs with a new one are changed further.
fn kind(error: &Error) -> String {
    let message = error.to_string();
    // the last line of an error of TOML, and its end, are the reader's own words
    let line = message.lines().last().unwrap_or_default();
    let words = line.split('"').step_by(2).flat_map(str::chars).filter(char::is_ascii_alphabetic);
    let words: Vec<char> = words.collect();
    format!("{}: {}", error.code(), words[words.len().saturating_sub(60)..].iter().collect::<String>())
}

/// Runs something and says how many bytes it had allocated at most on this thread.
fn measured<T>(run: impl FnOnce() -> T) -> (T, u64) {
    let mut result = None;
    let allocated = allocation_counter::measure(|| result = Some(run()));
    (result.expect("it was run"), allocated.bytes_max)
}
