//! Standard output and standard error: the one place where text goes to a terminal.

use std::borrow::Cow;
use std::io::Write;

use hexcast::finding::{Finding, Remedy};
use hexcast::{Error, Result};

/// Prints text for people to standard output.
pub(crate) fn print(text: &str) -> Result<()> {
    print_exact(&escaped(text))
}

/// Prints text for programs, such as JSON, to standard output as it is; a reader that has closed the pipe, as in `| head`, is
/// not a failure.
pub(crate) fn print_exact(text: &str) -> Result<()> {
    match std::io::stdout().write_all(text.as_bytes()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => Err(Error::io("printing", error)),
        _ => Ok(()),
    }
}

/// Prints lines to standard error: warnings, errors, hints. If that fails, there is nowhere left to say so.
pub(crate) fn complain(text: &str) {
    let _ = writeln!(std::io::stderr(), "{}", escaped(text));
}

/// Prints an error and what to do about it.
pub(crate) fn complain_of(error: &Error) {
    complain(&format!("error[{}]: {error}", error.code()));
    if !error.hint().is_empty() {
        complain(&format!("hint: {}", error.hint()));
    }
}

/// Prints a finding as a warning, and the options that help.
pub(crate) fn warn_of(finding: &Finding) {
    complain(&one_line(&format!("warning: {}", finding.sentence)));
    for Remedy { label, option, .. } in &finding.remedies {
        let Some(option) = option else { continue };
        let mut letters = label.chars();
        let first = letters.next().map(|letter| letter.to_lowercase().to_string()).unwrap_or_default();
        complain(&one_line(&format!("hint: {first}{} with {option}", letters.as_str())));
    }
}

/// The text on one line: ends of lines as `\n`.
pub(crate) fn one_line(text: &str) -> Cow<'_, str> {
    if text.contains('\n') { text.replace('\n', "\\n").into() } else { text.into() }
}

/// The text with escapes, such as `\u{1b}`, in place of what a terminal would obey: names come from files of strangers.
fn escaped(text: &str) -> Cow<'_, str> {
    if !text.contains(is_obeyed) {
        return text.into();
    }
    let mut escaped = String::with_capacity(text.len() + 16);
    for letter in text.replace("\r\n", "\n").chars() {
        if is_obeyed(letter) { escaped.extend(letter.escape_unicode()) } else { escaped.push(letter) }
    }
    escaped.into()
}

/// Control characters but the end of a line and the tab, and those that turn the direction of writing.
fn is_obeyed(letter: char) -> bool {
    let turns = matches!(letter, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    turns || letter.is_control() && !matches!(letter, '\n' | '\t')
}

/// The exit code of a run that an error ended.
pub(crate) fn exit_code(error: &Error) -> u8 {
    match error {
        // the name of an output is an argument
        error if error.code() == "output-name" => 2,
        Error::File(_) => 3,
        Error::Caller(_) => 4,
        Error::Limit(_) => 5,
        Error::Device(_) => 6,
        Error::System(_) => 7,
        Error::Cancelled => 130,
        _ => 1,
    }
}
