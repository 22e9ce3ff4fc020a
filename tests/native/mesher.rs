//! The library without an executor, and with one.

use std::sync::Arc;

use hexcast::Error;
use hexcast::columns::MemoryStore;
use hexcast::control::Control;
use hexcast::geometry::Facet;
use hexcast::job::{BackendChoice, GeometryJob, Job};
use hexcast::mesher::{Mesher, MesherOptions};
use hexcast::pipeline::{self, Engine, MeshOptions, SpillTarget};
use hexcast::sources::Source;

use crate::models::sphere;

fn job(cells: u32) -> Job {
    set!(Job { geometries: vec![GeometryJob::new("sphere")], cells: Some(cells), ..Job::default() })
}

fn facets() -> Vec<Facet> {
    sphere([0.0; 3], 1.0, 16)
}

fn mesher() -> Mesher {
    Mesher::new(MesherOptions::default().with_backend(BackendChoice::Cpu)).unwrap()
}

#[test]
fn executors_may_move_a_mesh_between_their_threads() {
    fn is_send<T: Send>(value: T) -> T {
        value
    }
    let (job, options, control) = (job(8), MeshOptions::default(), Control::default());
    let mut engine = Engine::cpu();
    let sources = vec![Source::from_facets("sphere", facets()).unwrap()];
    let future = is_send(pipeline::mesh(&job, sources, &options, &mut engine, &control));
    let (mesh, _) = pollster::block_on(future).unwrap();
    drop(is_send(Engine::open(BackendChoice::Auto, None)));
    let (same, _) = mesher()
        .mesh_sources(&job, vec![Source::from_facets("sphere", facets()).unwrap()], &options, &control)
        .unwrap();
    assert_eq!(mesh, same);
}

#[test]
fn a_job_with_another_number_of_geometries_than_sources_is_an_error() {
    let source = || Source::from_facets("sphere", facets()).unwrap();
    for sources in [vec![], vec![source(), source()]] {
        let n = sources.len();
        let error = mesher().mesh_sources(&job(8), sources, &MeshOptions::default(), &Control::default()).unwrap_err();
        assert_eq!(error.code(), "job-conflict");
        assert_eq!(error.to_string(), format!("the job has 1 geometries, but there are {n} sources"));
    }
}

#[test]
fn files_are_read_and_errors_name_them() {
    let mut mesher = mesher();
    let of = |file: &str| set!(Job { geometries: vec![GeometryJob::new(file)], cells: Some(16), ..Job::default() });
    let spot = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/fixtures/spot.stl");
    let (mesh, report) = mesher.mesh(&of(spot)).unwrap();
    assert_eq!(mesh.dims().into_iter().max(), Some(16));
    assert!(report.seconds.read > 0.0 && report.mesh.backend == "cpu", "{:?}", report.seconds);
    for (file, code, part) in
        [("nothing.stl", "io", "nothing.stl: there is no such file"), ("src", "io", "src is a folder")]
    {
        let error = mesher.mesh(&of(file)).unwrap_err();
        assert!(error.code() == code && error.to_string() == part, "{error}");
    }
    assert_eq!(mesher.mesh(&Job::default()).unwrap_err().code(), "job-empty");
}

#[test]
fn a_mesh_of_facets_in_memory_resumes_from_the_columns_of_the_same_facets_alone() {
    let store = Arc::new(MemoryStore::default());
    let options = MeshOptions::default().with_spill(SpillTarget::Resumable(store.clone()));
    let resumed = |radius: f32| {
        let sources = vec![Source::from_facets("sphere", sphere([0.0; 3], radius, 16)).unwrap()];
        let job = set!(Job { domain: Some([-2.0, -2.0, -2.0, 2.0, 2.0, 2.0]), ..job(16) });
        let (_, report) = mesher().mesh_sources(&job, sources, &options, &Control::default())?;
        assert_eq!(report.mesh.inputs[0].blake3, None);
        Ok(report.mesh.rays_kept)
    };
    assert_eq!([resumed(1.0), resumed(1.0)], [Ok(0), Ok(256)]);
    assert_eq!(resumed(1.5).map_err(|error: Error| error.code()), Err("columns-other"));
}
