//! What an error quotes of a job: the line around the place, never all of a long one, and no control characters.

/// Characters of a line that are quoted before and after the place.
const AROUND: usize = 40;
/// Longest message that is left as it is, in bytes.
const MAX_MESSAGE: usize = 600;
/// Characters of a longer message that are left at its start, and at its end.
const KEPT: [usize; 2] = [100, 300];

/// Describes an error of TOML, with line, column and a caret under the place.
pub(super) fn toml_problem(text: &str, error: &toml::de::Error) -> String {
    let whole = error.to_string();
    let Some(span) = error.span().filter(|_| whole.len() > MAX_MESSAGE) else { return shortened(&whole) };
    let (before, after) = text.split_at(text.floor_char_boundary(span.start));
    let n_line = before.matches('\n').count() + 1;
    let before = before.rsplit('\n').next().unwrap_or_default();
    let after = after.lines().next().unwrap_or_default();
    let column = before.chars().count();
    let start = before.char_indices().rev().nth(AROUND).map_or(0, |(index, first)| index + first.len_utf8());
    let end = after.char_indices().nth(AROUND).map_or(after.len(), |(index, _)| index);
    let dots = |is_cut: bool| if is_cut { "..." } else { "" };
    let (left, right) = (&before[start..], &after[..end]);
    let quoted = format!("{}{left}{right}{}", dots(start > 0), dots(end < after.len()));
    let margin = " ".repeat(n_line.to_string().len());
    let caret = " ".repeat(dots(start > 0).len() + left.chars().count());
    let message = shortened(error.message());
    let column = column + 1;
    format!(
        "TOML parse error at line {n_line}, column {column}\n{margin} |\n{n_line} | {quoted}\n{margin} | {caret}^\n{message}"
    )
}

/// A text on one line, short, with escapes such as `\u{1b}` in place of control characters.
pub(super) fn on_one_line(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        if c.is_control() { escaped.extend(c.escape_default()) } else { escaped.push(c) }
    }
    shortened(&escaped)
}

/// A text of several lines with U+FFFD in place of other control characters: a caret under one stays where it is.
pub(super) fn in_lines(text: &str) -> String {
    let is_odd = |c: char| c.is_control() && !matches!(c, '\n' | '\t');
    text.replace("\r\n", "\n").replace(is_odd, "\u{fffd}")
}

/// A number, in few characters also where it is very large or small.
pub fn short_number(number: f64) -> String {
    let is_plain = number == 0.0 || (1e-5..1e16).contains(&number.abs());
    if is_plain { format!("{number}") } else { format!("{number:?}") }
}

/// A message without its middle, if it is long: a value that it repeats stands there.
pub(super) fn shortened(message: &str) -> String {
    if message.len() <= MAX_MESSAGE {
        return message.into();
    }
    let [first, last] = KEPT;
    let start = message.char_indices().nth(first).map_or(message.len(), |(index, _)| index);
    let end = message.char_indices().rev().nth(last).map_or(0, |(index, _)| index);
    if start >= end { message.into() } else { format!("{}...{}", &message[..start], &message[end..]) }
}
