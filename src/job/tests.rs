use super::*;

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
    assert_eq!((job.dims, job.rule, job.axis), (Some([10, 20, 30]), Rule::Nonzero, AxisChoice::Y));
    assert_eq!(job.padding, Some(Padding::Length(PerAxis::Each([1.0, 2.0, 3.0]))));
    let place = job.geometries[0].world_from_file();
    assert_eq!(place.transform_point3(glam::DVec3::new(2.0, 0.0, 0.0)).to_array(), [0.0, 1.0, 0.0]);
}

#[test]
fn unknown_keys_and_wrong_types_are_named() {
    for (text, name) in [("cels = 3", "cels"), ("[[geometries]]\nfile = 'a'\nflg = 1", "flg"), ("cells = -1", "cells")]
    {
        let error = Job::from_toml(text).unwrap_err();
        assert_eq!(error.code(), "job-syntax");
        assert!(error.to_string().contains(name), "{error}");
    }
    assert_eq!(Job::from_json("{").unwrap_err().code(), "job-syntax");
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
    let padded = |job: &mut Job| {
        job.domain = Some([0.0, 0.0, 0.0, 1.0, 1.0, 1.0]);
        job.padding = Some(Padding::Cells(PerAxis::All(1)));
    };
    assert_eq!(error(padded).code(), "job-conflict");
    assert_eq!(error(|job| job.geometries.clear()).code(), "job-empty");
    assert_eq!(error(|job| job.geometries.resize(256, GeometryJob::new("a"))).code(), "too-many-geometries");
}

#[test]
fn arguments_of_the_command_line() {
    let full =
        GeometryJob::from_argument("a:b.stl:flag=7,priority=-2,name=copper,scale=0.5,rotate=0/0/90,translate=1/2/-3e1");
    let full = full.unwrap();
    assert_eq!((full.file.as_str(), full.flag, full.priority), ("a:b.stl", Some(7), -2));
    assert_eq!((full.rotate, full.translate), (Some([0.0, 0.0, 90.0]), Some([1.0, 2.0, -30.0])));
    assert_eq!(GeometryJob::from_argument(r"C:\x.stl").unwrap(), GeometryJob::new(r"C:\x.stl"));
    let scaled = GeometryJob::from_argument("x.stl:scale=1/2/3,solid=lid").unwrap();
    assert_eq!((scaled.scale, scaled.solid.as_deref()), (Some(PerAxis::Each([1.0, 2.0, 3.0])), Some("lid")));
    for (argument, name) in [
        ("a.stl:flag=300", "flag=300"),
        ("a.stl:flg=3", "\"flg\""),
        ("a.stl:rotate=90", "rotate=90"),
        ("a.stl:scale=x", "\"x\""),
        ("a.stl:flag=1,oops", "\"oops\""),
    ] {
        let error = GeometryJob::from_argument(argument).unwrap_err();
        assert!(error.code() == "job-value" && error.to_string().contains(name), "{error}");
    }
}
