//! The text of a file as messages show it.

/// Strips a UTF-8 byte order mark.
pub(super) fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}

/// The beginning of the first line, fit to be shown in a message.
pub(super) fn excerpt(line: &[u8]) -> String {
    let line = line.split(|byte| matches!(byte, b'\n' | b'\r')).next().unwrap_or_default();
    let shown = String::from_utf8_lossy(&line[..line.len().min(120)]);
    let mut short = String::new();
    for character in shown.trim().chars().take(40) {
        match character {
            '\0' => short.push_str("\\0"),
            '"' | '\'' | '\\' => short.extend(['\\', character]),
            _ if character.is_control() => short.extend(character.escape_default()),
            _ => short.push(character),
        }
    }
    if shown.trim().chars().count() > 40 {
        short.push_str("...");
    }
    short
}
