//! The text of a file as messages show it.

/// Characters that are shown of a line, with those of escapes.
const MAX_SHOWN: usize = 40;

/// Strips a UTF-8 byte order mark.
pub(super) fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}

/// The beginning of the first line, fit to be shown in a message.
pub(super) fn excerpt(line: &[u8]) -> String {
    let line = line.split(|byte| matches!(byte, b'\n' | b'\r')).next().unwrap_or_default();
    shown(&String::from_utf8_lossy(&line[..line.len().min(120)]), MAX_SHOWN)
}

/// A text of so many characters at most, fit to be shown in a message.
pub(super) fn shown(text: &str, most: usize) -> String {
    let mut short = String::new();
    let mut n_shown = 0;
    for character in text.trim().chars() {
        let text = match character {
            '\0' => "\\0".into(),
            '"' | '\'' | '\\' => String::from_iter(['\\', character]),
            _ if character.is_control() => character.escape_default().to_string(),
            _ => character.to_string(),
        };
        n_shown += text.chars().count();
        if n_shown > most {
            return short + "...";
        }
        short.push_str(&text);
    }
    short
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_shown_with_escapes_up_to_a_length() {
        for (text, most, expected) in [
            ("  abc\n", 3, "abc"),
            ("abcd", 3, "abc..."),
            ("a\"b'c\\d", 20, "a\\\"b\\'c\\\\d"),
            ("a\0b\tc\u{7}d", 20, "a\\0b\\tc\\u{7}d"),
            // an escape counts as long as it is, and is never cut
            ("a\0bc", 4, "a\\0b..."),
            ("a\0\0", 4, "a\\0..."),
            ("äöü", 3, "äöü"),
        ] {
            assert_eq!(shown(text, most), expected, "{text:?}, {most}");
        }
        assert_eq!(excerpt(b"one\rtwo\nthree"), "one");
        assert_eq!(excerpt(&[b'x'; 200]), "x".repeat(40) + "...");
    }
}
