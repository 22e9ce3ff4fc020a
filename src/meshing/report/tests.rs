//! The schema of the report, made of the types here, and the file in `docs/` that must be the same.
//!
//! After a change of the report write it with `HEXCAST_BLESS=1 cargo test --lib report_schema`, which is refused where `CI` is set.

use schemars::generate::SchemaSettings;
use serde_json::{Value, json};

use super::Report;
use hexcast_core::testing::{assert_schema_is_committed, in_plain_text};

mod facts;

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/report.schema.json");

fn schema() -> Value {
    let generator = SchemaSettings::draft2020_12().for_serialize().into_generator();
    let mut schema = generator.into_root_schema_for::<Report>().to_value();
    allow_no_other_keys(&mut schema);
    in_plain_text(&mut schema);
    schema["title"] = "Report of hexcast".into();
    schema
}

/// Allows no other keys.
fn allow_no_other_keys(schema: &mut Value) {
    match schema {
        Value::Object(of) => {
            if of.contains_key("properties") {
                of.insert("additionalProperties".into(), false.into());
            }
            of.values_mut().for_each(allow_no_other_keys);
        }
        Value::Array(list) => list.iter_mut().for_each(allow_no_other_keys),
        _ => {}
    }
}

#[test]
fn the_report_schema_in_docs_is_that_of_the_types() {
    assert_schema_is_committed(FILE, &schema(), "report_schema");
}

/// Calls `found` with every key of objects and its description; of a choice between objects of one key each has it.
fn for_each_key(path: &str, schema: &Value, found: &mut impl FnMut(&str, Option<&str>)) {
    match schema {
        Value::Object(of) => {
            let keys = of.get("properties").and_then(Value::as_object);
            for (key, value) in keys.into_iter().flatten() {
                let of_choice = of.get("description").filter(|_| keys.is_some_and(|keys| keys.len() == 1));
                found(&format!("{path}.{key}"), value.get("description").or(of_choice).and_then(Value::as_str));
            }
            of.iter().for_each(|(key, value)| for_each_key(&format!("{path}/{key}"), value, found));
        }
        Value::Array(list) => list.iter().for_each(|value| for_each_key(path, value, found)),
        _ => {}
    }
}

#[test]
fn every_key_of_the_report_schema_is_described_and_no_other_is_allowed() {
    let schema = schema();
    assert_eq!(schema["$schema"], "https://json-schema.org/draft/2020-12/schema");
    let mut n = 0;
    for_each_key("", &schema, &mut |path, description| {
        assert!(description.is_some_and(|text| text.len() > 5), "{path}");
        n += 1;
    });
    assert!(n > 120, "{n} keys");
    // the keys that a report is joined of lie side by side, and all must be there
    let required = schema["required"].as_array().expect("a list");
    for key in ["dims", "flags_sha256", "seconds", "warnings", "job", "doubtful"] {
        assert!(schema["properties"].get(key).is_some() && required.contains(&json!(key)), "{key}");
    }
    assert_eq!(schema["additionalProperties"], false);
}
