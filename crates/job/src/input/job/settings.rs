//! Settings of an argument, `key=value,...`.

use super::quoted::on_one_line;
use crate::base::error::{Error, Result};

/// Splits `NAME:key=value,...` at the first colon that a word and `=` follow, so that other colons belong to the name, as in
/// `C:\run=3\part.stl`. None where there are no settings.
pub(super) fn name_and_settings(argument: &str) -> Option<(&str, &str)> {
    let begins_with_key = |rest: &str| {
        let key = rest.split_once('=').map(|(key, _)| key.trim());
        key.is_some_and(|key| !key.is_empty() && key.chars().all(|c| c.is_ascii_alphabetic() || c == '_' || c == '-'))
    };
    let mut colons = argument.match_indices(':').map(|(at, _)| (&argument[..at], &argument[at + 1..]));
    colons.find(|(_, rest)| begins_with_key(rest))
}

/// Calls `set` with the key and the value of each setting; `what` and `hint` are for errors.
///
/// # Errors
/// `job-value` where one is not `key=value`, or `set` says what is wrong with it; `job-conflict` where a key is given twice.
pub(super) fn for_each(
    settings: &str,
    (what, hint): (&str, &str),
    mut set: impl FnMut(&str, &str) -> std::result::Result<(), String>,
) -> Result<()> {
    let wrong =
        |code, problem: &str, hint| Error::new(code, format!("{}: {}", on_one_line(what), on_one_line(problem)), hint);
    let mut seen = Vec::new();
    for setting in settings.split(',') {
        let Some((key, value)) = setting.split_once('=').map(|(key, value)| (key.trim(), value.trim())) else {
            return Err(wrong("job-value", &format!("\"{setting}\" is not key=value"), hint));
        };
        if seen.contains(&key) {
            return Err(wrong("job-conflict", &format!("{key} is given twice"), "keep one of them"));
        }
        seen.push(key);
        set(key, value).map_err(|problem| wrong("job-value", &problem, hint))?;
    }
    Ok(())
}

/// Reads true or false.
pub(super) fn yes_or_no(key: &str, text: &str) -> std::result::Result<bool, String> {
    text.parse().map_err(|_| format!("{key}={text}: write true or false"))
}

/// Reads a number.
pub(super) fn number(key: &str, text: &str) -> std::result::Result<f64, String> {
    text.parse().map_err(|_| format!("{key}: \"{text}\" is not a number"))
}

/// Reads N numbers joined by `/`, such as the example.
pub(super) fn joined<T: std::str::FromStr, const N: usize>(
    (key, text): (&str, &str),
    example: &str,
) -> std::result::Result<[T; N], String> {
    let numbers = text.split('/').map(|part| part.trim().parse().ok()).collect::<Option<Vec<T>>>();
    let numbers = numbers.and_then(|numbers| <[T; N]>::try_from(numbers).ok());
    numbers.ok_or_else(|| format!("{key}={text}: {N} numbers joined by / are needed, as in {example}"))
}
