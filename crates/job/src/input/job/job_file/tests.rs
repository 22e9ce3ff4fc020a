use schemars::generate::SchemaSettings;
use serde_json::{Value, json};

use super::*;
use crate::input::job::PlaceJob;
use crate::testing::{assert_schema_is_committed, in_plain_text};

const SCHEMA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/job.schema.json");
const EXAMPLE: &str = include_str!("../../../../../../src/bin/hexcast/commands/job_example.toml");

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
    let mut listed = names::<RunJob>().to_vec();
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
    for (text, says) in [
        ("[]", "the job: line 1, column 0: it is a list; give the keys of a job in { }"),
        ("{\"cells\": 3,\n \"report\": 4}", "report: line 2, column 12: it is 4; give a text"),
        (
            "{\n\"geometries\": [\n{\"file\": \"a\", \"flag\": 300}]}",
            "geometries[0].flag: line 3, column 26: it is 300; give a flag: 1 to 255",
        ),
        (
            "{\"report\": \"a\",\n\n \"cels\": 4}",
            "the job: line 3, column 7: there is no key `cels`; keys are `geometries`",
        ),
        ("{\"cells\": 3,\n\"cells\": 4}", "the job: line 2, column 7: duplicate field `cells`"),
        (
            "{\"geometries\": [],\n\"padding\": 3}",
            "padding: line 2, column 12: it is something else; give { cells = N }",
        ),
        ("{\"view\": {\"direction\": [1]}}", "view.direction: line 1, column 27: its length is 1; give 2 numbers"),
    ] {
        let error = JobFile::from_json(text).unwrap_err();
        assert_eq!(error.code(), "job-value");
        assert!(error.to_string().starts_with(says), "{error}");
    }
    let text = "{\"report\": 4, \"cells\": \"x\", \"unit\": \"mm\"}";
    let file = JobFile::from_json_without(text, &["report", "cells"]).unwrap();
    assert_eq!((file.run.report, file.job.cells, file.job.unit.as_deref()), (None, None, Some("mm")));
    let error = JobFile::from_json("{\"cells\": 3,\n \"report\" 4}").unwrap_err();
    assert!(error.code() == "job-syntax" && error.to_string().contains("at line 2"), "{error}");
}

#[test]
fn pictures_survive_both_languages_whatever_their_number() {
    let of = |text: &str| JobFile::from_toml(text).unwrap();
    let file = of("cells = 3\nslice = { output = \"a.png\", axis = \"x\", at = 0.5, colours = { 1 = \"00ff00\" } }\n\
                   view = [{ output = \"b.png\" }, { output = \"c.png\", direction = [1, 2], window = [0, 0, 0, 1, 2, 3] }]\n\
                   [[geometries]]\nfile = \"a.stl\"\n");
    let slice = &file.run.slice.as_ref().unwrap().0[0];
    assert_eq!(slice.axis, Some(Several(vec!["x".into()])));
    assert_eq!(slice.at, Some(Several(vec![PlaceJob::Coordinate(0.5)])));
    assert_eq!(file.run.view.as_ref().unwrap().0.len(), 2);
    assert_eq!(of(&file.to_toml().unwrap()), file);
    assert_eq!(JobFile::from_json(&file.to_json()).unwrap(), file);
    // a list with an entry stands for that entry, also as arguments
    assert_eq!(
        of("slice = [{ output = \"a.png\", axis = [\"x\"] }]").run,
        of("slice = { output = \"a.png\", axis = \"x\" }").run
    );
    let text = "a.png:axis=x/z,at=25%/0.5,lines=false,size=300,flags=0/7,colours=1=00ff00/2=#0000ff";
    let slice: SliceJob = text.parse().unwrap();
    let json = serde_json::to_string(&slice).unwrap();
    assert_eq!(json.parse::<SliceJob>().unwrap(), slice, "{json}");
    let expected =
        of("slice = { output = \"a.png\", axis = [\"x\", \"z\"], at = [\"25%\", \"0.5\"], lines = false, size = 300, \
                       flags = [0, 7], colours = { 1 = \"00ff00\", 2 = \"#0000ff\" } }");
    assert_eq!(expected.run.slice.unwrap().0[0], slice);
    let view: ViewJob = "C:\\a=1\\b:c.png:direction=-30/20.5,window=0/0/0/1/2/3".parse().unwrap();
    assert_eq!((view.output.as_str(), view.direction), ("C:\\a=1\\b:c.png", Some([-30.0, 20.5])));
    assert_eq!(view.window, Some([0, 0, 0, 1, 2, 3]));
    for (text, says) in [
        ("a.png:foo=1", "a.png: there is no key \"foo\"; keys are axis, at, lines, size, flags, colours"),
        ("a.png:size=2.5", "a.png: size=2.5 is not a whole number"),
        ("a.png:size=3,size=4", "a.png: size is given twice"),
        ("a.png:flags=1/300", "a.png: flags=1/300: numbers from 0 to 255 joined by / are needed"),
        ("a.png:colours=red", "a.png: colours=red: FLAG=RRGGBB joined by / are needed"),
        ("a.png:output=b.png", "a.png: output is the name before the colon"),
        ("a.png:lines=no", "a.png: lines=no: write true or false"),
    ] {
        let error = text.parse::<SliceJob>().unwrap_err().to_string();
        assert!(error.starts_with(says), "{error}");
    }
    let error = "a.png:direction=30".parse::<ViewJob>().unwrap_err().to_string();
    assert!(error.starts_with("a.png: direction=30: 2 numbers joined by / are needed, as in 30/20"), "{error}");
}
