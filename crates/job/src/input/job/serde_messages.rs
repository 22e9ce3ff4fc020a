//! Rewords serde's errors about wrong values: they name Rust's types, which a job does not have.

/// Types of Rust and what a job calls them.
const TYPES: &[(&str, &str)] = &[
    ("u8", "a whole number from 0 to 255"),
    ("u16", "a whole number from 0 to 65535"),
    ("u32", "a whole number from 0 to 4294967295"),
    ("u64", "a whole number of at least 0"),
    ("i32", "a whole number from -2147483648 to 2147483647"),
    ("i64", "a whole number"),
    ("f64", "a number"),
    ("a string", "a text"),
    ("a boolean", "true or false"),
    ("a sequence", "a list"),
];

/// The message with every line of serde's in words.
pub(super) fn in_words(key: &str, message: &str) -> String {
    let words = message.lines().map(line_in_words).collect::<Vec<String>>().join("\n");
    // of an enum serde does not say what is expected
    let is_of_enum = words.contains("wanted string or table") || words.starts_with("expected value");
    let words = if words.starts_with("expected value") { "it is something else".into() } else { words };
    match key {
        "padding" => {
            let found = words.split("; give ").next().unwrap_or_default();
            format!("{found}; give {{ cells = N }} or {{ length = L }}, of one number or three")
        }
        _ if is_of_enum => format!("{words}; give one of its words as a text"),
        _ => words,
    }
}

fn line_in_words(line: &str) -> String {
    let parts = |prefix: &str| line.strip_prefix(prefix)?.rsplit_once(", expected ");
    if let Some((found, expected)) = parts("invalid type: ").or_else(|| parts("invalid value: ")) {
        let expected = TYPES.iter().find(|(name, _)| *name == expected).map_or(expected, |(_, words)| words);
        let expected = if expected.starts_with("struct ") { "a table of its keys" } else { expected };
        return format!("it is {}; give {expected}", found_in_words(found));
    }
    if let Some((length, expected)) = parts("invalid length ") {
        return format!("its length is {length}; give {expected}");
    }
    if let Some((key, expected)) = line.strip_prefix("unknown field ").and_then(|rest| rest.split_once(", expected ")) {
        return format!("there is no key {key}; keys are {}", expected.trim_start_matches("one of "));
    }
    if let Some((word, expected)) =
        line.strip_prefix("unknown variant ").and_then(|rest| rest.split_once(", expected "))
    {
        return format!("it is {word}; give {}", expected.replace("one of ", "one of: "));
    }
    line.replace("missing field ", "there is no key ")
}

/// `integer `3`` as 3, `string "much"` as the text "much", `sequence` as a list.
fn found_in_words(found: &str) -> String {
    let kinds = [
        ("integer ", ""),
        ("floating point ", ""),
        ("boolean ", ""),
        ("string ", "the text "),
        ("sequence", "a list"),
        ("map", "a table"),
        ("null", "null"),
    ];
    let kind = kinds.iter().find_map(|(kind, word)| found.strip_prefix(kind).map(|rest| format!("{word}{rest}")));
    kind.map_or(found.into(), |words| words.replace('`', ""))
}
