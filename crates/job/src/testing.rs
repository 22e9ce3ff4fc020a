//! What tests of several crates use: schemas that are held to files.

use serde_json::Value;

/// Makes plain text of links to Rust's documentation, in the descriptions of a schema.
pub fn in_plain_text(schema: &mut Value) {
    match schema {
        Value::Object(of) => {
            if let Some(Value::String(text)) = of.get_mut("description") {
                *text = text.replace("[`", "`").replace("`]", "`").replace('\n', " ");
            }
            of.values_mut().for_each(in_plain_text);
        }
        Value::Array(list) => list.iter_mut().for_each(in_plain_text),
        _ => {}
    }
}

/// Holds a schema in `docs/` to that of the types, or writes it where that is asked for.
pub fn assert_schema_is_committed(file: &str, schema: &Value, test: &str) {
    let text = format!("{schema:#}\n");
    if std::env::var_os("HEXCAST_BLESS").is_some() {
        assert!(std::env::var_os("CI").is_none(), "the schema is written by people, who read the difference");
        std::fs::write(file, &text).unwrap();
    }
    let committed = std::fs::read_to_string(file).unwrap_or_default();
    assert_eq!(committed, text, "run HEXCAST_BLESS=1 cargo test --workspace --lib {test}, and read the difference");
}
