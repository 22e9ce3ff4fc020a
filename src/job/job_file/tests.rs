use schemars::generate::SchemaSettings;
use serde_json::{Value, json};

use super::*;
use crate::job::tests::{assert_schema_is_committed, in_plain_text};

const SCHEMA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/job.schema.json");
const EXAMPLE: &str = include_str!("../../bin/hexcast/job_example.toml");

/// The schema of what is read: keys that may be left out are not required.
fn schema() -> Value {
    let generator = SchemaSettings::draft2020_12().for_deserialize().into_generator();
    let mut schema = generator.into_root_schema_for::<JobFile>().to_value();
    in_plain_text(&mut schema);
    schema["title"] = "Job file of hexcast".into();
    schema["additionalProperties"] = false.into();
    // schemars does not know that text such as "2GB" is read, too, nor that there must be a geometry
    schema["$defs"]["ByteSize"] = json!({
        "description": "A number of bytes, at least 1, or text such as \"2GB\" or \"512MiB\".",
        "anyOf": [{"type": "integer", "minimum": 1}, {"type": "string"}],
    });
    schema["required"] = json!(["geometries"]);
    schema["$defs"]["GeometryJob"]["required"] = json!(["file"]);
    schema
}

#[test]
fn the_job_schema_in_docs_is_that_of_the_types() {
    assert_schema_is_committed(SCHEMA, &schema(), "job_schema");
}

#[test]
fn the_keys_of_runs_are_those_of_the_struct() {
    let schema = SchemaSettings::draft2020_12().into_generator().into_root_schema_for::<RunJob>().to_value();
    let mut keys: Vec<&str> = schema["properties"].as_object().unwrap().keys().map(String::as_str).collect();
    let mut listed = RUN_KEYS.to_vec();
    keys.sort_unstable();
    listed.sort_unstable();
    assert_eq!(keys, listed);
}

#[test]
fn the_example_parses_and_has_every_key() {
    JobFile::from_toml(EXAMPLE).unwrap().job.validate().unwrap();
    // every alternative that is commented out is a line of TOML of the table that it stands in
    let mut table = String::new();
    let mut keys = Vec::new();
    for line in EXAMPLE.lines() {
        if line.starts_with('[') {
            table = format!("{line}\nfile = \"a.stl\"\n");
        }
        let Some((key, _)) = line.trim_start_matches('#').split_once(" = ") else { continue };
        if key.contains(' ') {
            continue;
        }
        keys.push(format!("{}{key}", if table.is_empty() { "" } else { "geometries." }));
        let alone =
            format!("{}{}", if key == "file" { "[[geometries]]\n" } else { &table }, line.trim_start_matches('#'));
        JobFile::from_toml(&alone).unwrap_or_else(|error| panic!("{alone}: {error}"));
    }
    let schema = schema();
    let of = |keys: &Value, before: &str| {
        keys.as_object().unwrap().keys().map(|key| format!("{before}{key}")).collect::<Vec<_>>()
    };
    let mut expected = of(&schema["properties"], "");
    expected.extend(of(&schema["$defs"]["GeometryJob"]["properties"], "geometries."));
    for key in expected.iter().filter(|key| *key != "geometries") {
        assert_eq!(keys.iter().filter(|found| *found == key).count(), 1, "{key} in the example");
    }
}

#[test]
fn job_files_survive_both_languages_and_errors_name_the_line() {
    let file = JobFile::from_toml(EXAMPLE).unwrap();
    assert!(file.run.output.is_some() && !file.job.geometries.is_empty());
    assert_eq!(JobFile::from_toml(&file.to_toml().unwrap()).unwrap(), file);
    assert_eq!(JobFile::from_json(&file.to_json()).unwrap(), file);
    let error = JobFile::from_toml("cells = 3\nreport = 4\n").unwrap_err().to_string();
    assert!(error.starts_with("report: ") && error.contains("line 2"), "{error}");
    let error = JobFile::from_toml("report = \"a\"\ncels = 4\n").unwrap_err().to_string();
    assert!(error.starts_with("cels: ") && error.contains("line 2"), "{error}");
    assert!(JobFile::from_json("[]").unwrap_err().to_string().contains("not an object"));
}
