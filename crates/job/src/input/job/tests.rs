use proptest::prelude::*;
use serde_json::json;

use super::*;
use crate::base::error::Error;

const TWO: &str = r#"
unit = "mm"
dims = [10, 20, 30]
rule = "nonzero"
axis = "y"
backend = "cpu"
padding = { length = [1, 2, 3] }

[[geometries]]
file = "parts/coil.stl"
flag = 7
priority = 2
name = "copper"
scale = 0.5
rotate = [0, 0, 90]

[[geometries]]
file = 'C:\case.STL'
scale = [1, 2, 3]
translate = [1, 0, 0]
solid = "lid"
"#;

fn error(change: impl Fn(&mut Job)) -> Error {
    let mut job = Job { geometries: vec![GeometryJob::new("a.stl")], ..Job::default() };
    assert_eq!(job.validate(), Ok(()));
    change(&mut job);
    job.validate().unwrap_err()
}

#[test]
fn toml_and_json_give_the_same_job() {
    let job = Job::from_toml(TWO).unwrap();
    assert_eq!(Job::from_json(&job.to_json()).unwrap(), job);
    assert_eq!(Job::from_toml(&toml::to_string(&job).unwrap()).unwrap(), job);
    assert_eq!((job.dims, job.rule, job.axis), (Some([10, 20, 30]), Rule::Nonzero, AxisChoice::Y));
    assert_eq!(job.padding, Some(Padding::Length(PerAxis::Each([1.0, 2.0, 3.0]))));
    let place = job.geometries[0].world_from_file();
    assert_eq!(place.place([2.0, 0.0, 0.0]), [0.0, 1.0, 0.0]);
}

#[test]
fn what_is_no_toml_or_json_is_a_syntax_error() {
    for text in ["cells =", "[[geometries]", "cells = 3 cells = 4"] {
        let error = Job::from_toml(text).unwrap_err();
        assert!(error.code() == "job-syntax" && error.to_string().contains("line 1"), "{error}");
    }
    for text in ["{", "", "{} {}", r#"{"cells": NaN}"#] {
        assert_eq!(Job::from_json(text).unwrap_err().code(), "job-syntax", "{text}");
        assert_eq!(Job::from_plain_json(text).unwrap_err().code(), "job-syntax", "{text}");
    }
}

#[test]
fn unknown_keys_and_wrong_types_name_the_key() {
    // the same in both languages; each with the path of the key and a part of what is said about it
    let cases = [
        (json!({"cels": 3}), "cels", "there is no key `cels`; keys are `geometries`, `domain`"),
        (json!({"cells": -1}), "cells", "-1"),
        (json!({"cells": 2.5}), "cells", "2.5"),
        (json!({"domain": [0, 0, 0, 1, 1, 1, 9]}), "domain", "length is 7; give 6 numbers"),
        (json!({"dims": [1, 2]}), "dims", "length is 2; give 3 numbers"),
        (json!({"cell_size": "1"}), "cell_size", "it is the text \"1\"; give a number or a list of three"),
        (json!({"cell_size": [1, 2, 3, 4]}), "cell_size", "length is 4; give a number or a list of three"),
        (json!({"padding": {"cell": 2}}), "padding", "`cell`"),
        (json!({"padding": {"cells": 0.5}}), "padding.cells", "0.5"),
        (json!({"padding": 3}), "padding", "give { cells = N } or { length = L }, of one number or three"),
        (json!({"cells": "many"}), "cells", "it is the text \"many\"; give a whole number from 0 to 4294967295"),
        (json!({"padding": {"cells": 1, "length": 1}}), "padding", ""),
        (json!({"zarr": 4}), "zarr", "it is 4; give a table of its keys"),
        (json!({"zarr": "small"}), "zarr", "it is the text \"small\"; give a table of its keys"),
        (json!({"links": 4}), "links", "it is 4; give a table of its keys"),
        (json!({"fractions": 0.5}), "fractions", "it is 0.5; give a table of its keys"),
        (json!({"background": true}), "background", "it is true; give a table of its keys"),
        (json!({"graded": 4}), "graded", "it is 4; give a table of its keys"),
        (json!({"rule": "even"}), "rule", "it is `even`; give `parity` or `nonzero`"),
        (json!({"geometries": [{"file": "a"}, {"file": "a", "flg": 1}]}), "geometries[1].flg", "there is no key `flg`"),
        (json!({"geometries": [{"file": "a"}, {"file": "a", "flag": 300}]}), "geometries[1].flag", "300"),
        (json!({"geometries": [{"file": "a", "flag": -1}]}), "geometries[0].flag", "it is -1; give a flag: 1 to 255"),
        (
            json!({"geometries": [{"file": "a", "rotate": [1, 2, 3, 4]}]}),
            "geometries[0].rotate",
            "length is 4; give 3 numbers",
        ),
    ];
    for (value, key, said) in cases {
        let text = value.to_string();
        let plain = Job::from_plain_json(&text);
        assert!(!plain.clone().unwrap_err().to_string().contains("line 1"), "{plain:?}");
        let toml = toml::to_string(&value).unwrap();
        for error in [Job::from_json(&text), plain, Job::from_toml(&toml)].map(Result::unwrap_err) {
            let message = error.to_string();
            assert_eq!(error.code(), "job-value", "{text}: {message}");
            assert!(message.starts_with(key) && message.contains(said), "{text}: {message}");
        }
    }
    let error = Job::from_json(r#"{"max_cell_size": 1e999}"#).unwrap_err();
    assert!(error.code() == "job-value" && error.to_string().starts_with("max_cell_size"), "{error}");
}

#[test]
fn values_out_of_range_name_their_key() {
    let named = |key: &str, change: &dyn Fn(&mut Job)| {
        let error = error(change);
        assert_eq!(error.code(), "job-value", "{error}");
        assert!(error.to_string().starts_with(key), "{error}");
    };
    named("geometries[0].flag", &|job| job.geometries[0].flag = Some(0));
    named("geometries[0].file", &|job| job.geometries[0].file.clear());
    named("geometries[0].scale", &|job| job.geometries[0].scale = Some(PerAxis::All(0.0)));
    named("geometries[0].rotate", &|job| job.geometries[0].rotate = Some([f64::NAN, 0.0, 0.0]));
    named("geometries[0].about", &|job| {
        (job.geometries[0].rotate, job.geometries[0].about) = (Some([0.0; 3]), Some([0.0, f64::NAN, 0.0]));
    });
    named("geometries[0].translate", &|job| job.geometries[0].translate = Some([0.0, f64::INFINITY, 0.0]));
    named("cells", &|job| job.cells = Some(0));
    named("dims", &|job| job.dims = Some([1, 0, 1]));
    named("cell_size", &|job| job.cell_size = Some(PerAxis::Each([1.0, -1.0, 1.0])));
    named("max_cell_size", &|job| job.max_cell_size = Some(f64::NAN));
    named("domain", &|job| job.domain = Some([0.0, 0.0, 0.0, 1.0, 0.0, 1.0]));
    named("padding.length", &|job| job.padding = Some(Padding::Length(PerAxis::All(-1.0))));
    named("tolerance", &|job| (job.max_cell_size, job.tolerance) = (Some(1.0), Some(0.6)));
}

#[test]
fn contradictions_are_refused() {
    assert_eq!(error(|job| (job.cells, job.dims) = (Some(1), Some([1; 3]))).code(), "job-conflict");
    assert_eq!(error(|job| job.tolerance = Some(0.1)).code(), "job-conflict");
    let empty_shell = |job: &mut Job| (job.geometries[0].shell, job.geometries[0].fill) = (true, Some(Fill::Centre));
    assert_eq!(error(empty_shell).code(), "job-conflict");
    let outside_of_a_shell = |job: &mut Job| (job.geometries[0].shell, job.geometries[0].invert) = (true, true);
    assert_eq!(error(outside_of_a_shell).code(), "job-conflict");
    let nothing_rotates = error(|job| job.geometries[0].about = Some([1.0; 3]));
    assert_eq!(nothing_rotates.code(), "job-conflict");
    assert!(nothing_rotates.to_string().starts_with("geometries[0].about"), "{nothing_rotates}");
    assert_eq!(error(|job| job.geometries.clear()).code(), "job-empty");
    assert_eq!(error(|job| job.geometries.resize(65_536, GeometryJob::new("a"))).code(), "too-many-geometries");
}

#[test]
fn arguments_of_the_command_line() {
    let full = GeometryJob::from_argument(
        "a:b.stl:flag=7,priority=-2,name=copper,scale=0.5,rotate=0/0/90,about=1/0/-2,translate=1/2/-3e1",
    );
    let full = full.unwrap();
    assert_eq!((full.file.as_str(), full.flag, full.priority), ("a:b.stl", Some(7), -2));
    assert_eq!((full.rotate, full.translate), (Some([0.0, 0.0, 90.0]), Some([1.0, 2.0, -30.0])));
    assert_eq!(full.about, Some([1.0, 0.0, -2.0]));
    assert_eq!(GeometryJob::from_argument(r"C:\x.stl").unwrap(), GeometryJob::new(r"C:\x.stl"));
    let scaled = GeometryJob::from_argument("x.stl:scale=1/2/3,solid=lid").unwrap();
    assert_eq!((scaled.scale, scaled.solid.as_deref()), (Some(PerAxis::Each([1.0, 2.0, 3.0])), Some("lid")));
    for file in [r"C:\run=3\x.stl", "a:1=b.stl", "http://host/a=b.stl"] {
        assert_eq!(GeometryJob::from_argument(file).unwrap(), GeometryJob::new(file));
    }
    let colon = GeometryJob::from_argument(r"C:\run=3\x.stl:name=a:b,flag=2").unwrap();
    assert_eq!((colon.file.as_str(), colon.name.as_deref(), colon.flag), (r"C:\run=3\x.stl", Some("a:b"), Some(2)));
    let wall = GeometryJob::from_argument("x.stl:fill=conservative,shell=true,open=vote").unwrap();
    assert_eq!((wall.fill, wall.shell, wall.open), (Some(Fill::Conservative), true, Some(Open::Vote)));
    assert_eq!(GeometryJob::from_argument("a.stl:flag=1,flag=2").unwrap_err().code(), "job-conflict");
    for (argument, name) in [
        (":flag=1", "no file"),
        ("a.stl:flag=300", "flag=300"),
        ("a.stl:flg=3", "\"flg\""),
        ("a.stl:rotate=90", "rotate=90"),
        ("a.stl:scale=x", "\"x\""),
        ("a.stl:fill=all", "fill=all: write centre, conservative or separating"),
        ("a.stl:shell=1", "shell=1: write true or false"),
        ("a.stl:flag=1,oops", "\"oops\""),
    ] {
        let error = GeometryJob::from_argument(argument).unwrap_err();
        assert!(error.code() == "job-value" && error.to_string().contains(name), "{error}");
    }
}

fn any_per_axis() -> impl Strategy<Value = PerAxis<f64>> {
    prop_oneof![(1e-9f64..1e9).prop_map(PerAxis::All), prop::array::uniform3(1e-9f64..1e9).prop_map(PerAxis::Each)]
}

fn any_geometry() -> impl Strategy<Value = GeometryJob> {
    let three = || prop::option::of(prop::array::uniform3(-1e9f64..1e9));
    let text = "[ -~äß\\n]{1,12}";
    (text, prop::option::of(1u8..), any::<i32>(), prop::option::of(any_per_axis()), three(), three()).prop_map(
        |(file, flag, priority, scale, rotate, translate)| GeometryJob {
            about: rotate.and(translate),
            solid: flag.is_some().then(|| file.clone()),
            split: flag.is_none(),
            file,
            flag,
            priority,
            scale,
            rotate,
            translate,
            ..GeometryJob::default()
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(64) })]

    #[test]
    fn every_job_survives_both_languages(
        geometries in prop::collection::vec(any_geometry(), 1..4),
        size in prop::option::of(any_per_axis()), padding in prop::option::of(any_per_axis()), cells in 0u32..9,
    ) {
        let padding = padding.map(Padding::Length).or(Some(Padding::Cells(PerAxis::All(cells))));
        let unit = Some("µm".to_string());
        let max_memory = Some(ByteSize(u64::from(cells) + 1));
        let job = Job { max_memory, geometries, cell_size: size, padding, axis: AxisChoice::Z, unit, ..Job::default() };
        prop_assert_eq!(&Job::from_toml(&toml::to_string(&job).unwrap()).unwrap(), &job);
        prop_assert_eq!(&Job::from_json(&job.to_json()).unwrap(), &job);
    }

    #[test]
    fn no_argument_makes_it_panic(argument in "[a-z:=,/.0-9]{0,30}") {
        if let Ok(geometry) = GeometryJob::from_argument(&argument) {
            prop_assert!(argument.starts_with(&geometry.file));
        }
    }
}

#[test]
fn a_background_is_read_from_an_argument() {
    let background: BackgroundJob = "name=air, eps_r=1.0006,pec=false,E=2e9".parse().unwrap();
    let material = Material { eps_r: Some(1.0006), youngs_modulus: Some(2e9), ..Material::default() };
    assert_eq!(background, BackgroundJob { name: Some("air".into()), material });
    for (text, code, says) in [
        (
            "eps=1",
            "job-value",
            "background: there is no key \"eps\"; keys are name, eps_r, mu_r, sigma, pec, density, E, nu",
        ),
        ("air", "job-value", "background: \"air\" is not key=value"),
        ("eps_r=one", "job-value", "background: eps_r: \"one\" is not a number"),
        ("pec=yes", "job-value", "background: pec=yes: write true or false"),
        ("nu=0.1,nu=0.2", "job-conflict", "background: nu is given twice"),
    ] {
        let error = text.parse::<BackgroundJob>().unwrap_err();
        assert_eq!(error.code(), code, "{text}");
        assert!(error.to_string().starts_with(says), "{error}");
    }
}

#[test]
fn materials_are_keys_of_a_geometry_and_of_the_background() {
    let text = "[background]\nname = \"air\"\nmaterial = { eps_r = 1 }\n[[geometries]]\nfile = \"a.stl\"\nmaterial = { sigma = 5.8e7, E = 1e11, nu = -0.5 }\n";
    let job = Job::from_toml(text).unwrap();
    assert_eq!(Job::from_json(&job.to_json()).unwrap(), job);
    let copper = job.geometries[0].material;
    assert_eq!(
        (copper.sigma, copper.youngs_modulus, copper.nu, copper.pec),
        (Some(5.8e7), Some(1e11), Some(-0.5), false)
    );
    assert_eq!(GeometryJob::from_argument("a.stl:sigma=5.8e7,E=1e11,nu=-0.5").unwrap(), job.geometries[0]);
    assert!(GeometryJob::from_argument("a.stl:pec=true").unwrap().material.pec);
    for (key, value) in
        [("eps_r", 0.0), ("mu_r", -1.0), ("sigma", f64::INFINITY), ("density", f64::NAN), ("E", 0.0), ("nu", 0.5)]
    {
        let found = error(|job| *job.geometries[0].material.number_mut(key).unwrap() = Some(value));
        let message = found.to_string();
        assert!(
            found.code() == "job-value" && message.starts_with(&format!("geometries[0].material.{key} is ")),
            "{message}"
        );
    }
    let wrong = Job::from_toml("[[geometries]]\nfile = \"a.stl\"\nmaterial = { eps = 1 }\n").unwrap_err();
    assert!(wrong.code() == "job-value" && wrong.to_string().contains("eps"), "{wrong}");
}

#[test]
fn a_geometry_rotates_about_the_point_that_is_given_once_it_is_scaled() {
    let placed = |text: &str, point: [f64; 3]| {
        let job = GeometryJob::from_argument(&format!("a.stl:{text}")).unwrap();
        job.world_from_file().place(point)
    };
    // quarter turns of small numbers are exact
    assert_eq!(placed("rotate=0/0/90,about=10/20/30", [11.0, 20.0, 5.0]), [10.0, 21.0, 5.0]);
    assert_eq!(placed("rotate=90/0/0,about=10/20/30", [7.0, 21.0, 30.0]), [7.0, 20.0, 31.0]);
    assert_eq!(placed("rotate=0/-90/0,about=1/2/3,translate=0/0/100", [2.0, 7.0, 3.0]), [1.0, 7.0, 104.0]);
    assert_eq!(placed("scale=2,rotate=0/0/180,about=10/0/0", [6.0, 1.0, 4.0]), [8.0, -2.0, 8.0]);
    assert_eq!(placed("rotate=0/0/0,about=0.1/0.2/0.3", [0.7, 0.1, 0.3]), [0.7, 0.1, 0.3]);
    let plain = placed("scale=0.3,rotate=10/20/30,translate=1/2/3", [0.1, 0.2, 0.3]);
    assert_eq!(placed("scale=0.3,rotate=10/20/30,about=0/0/0,translate=1/2/3", [0.1, 0.2, 0.3]), plain);
    // the point stays where it is, whatever the angles
    let at = placed("rotate=33/-71/105.5,about=0.1/-4/2.5", [0.1, -4.0, 2.5]);
    assert!([0.1, -4.0, 2.5].iter().zip(at).all(|(a, b)| (a - b).abs() < 1e-14), "{at:?}");
}
