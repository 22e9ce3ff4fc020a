//! Surfaces with holes have the same cells on every backend.

use hexcast::gpu::Gpu;
use hexcast::job::{Fill, GeometryJob, Job, Rule};
use hexcast::pipeline::Engine;

use super::kernels;
use crate::models;
use crate::open_surfaces::{flags_of, meshed, without};
use crate::soups::{Random, shuffled};

#[test]
fn cells_along_surfaces_are_the_same_on_every_backend() {
    let gpu = pollster::block_on(Gpu::open(Some(&kernels::gpu().facts.name))).expect("it was opened before");
    let mut engines = [Engine::cpu(), Engine::with_gpu(gpu)];
    let parts = [
        models::sphere([4.0; 3], 3.4, 40),
        without(&models::torus([4.5; 3], [2.4, 1.1], 40), 0.02, 2),
        models::cuboid([2.0; 3], [6.0, 5.0, 7.0]),
    ];
    let geometry = |fill: Fill, shell: bool| set!(GeometryJob { fill: Some(fill), shell, ..GeometryJob::default() });
    let outside = set!(GeometryJob { invert: true, priority: -1, ..geometry(Fill::Separating, false) });
    let geometries = vec![geometry(Fill::Separating, true), geometry(Fill::Conservative, false), outside];
    let job = set!(Job { dims: Some([70, 67, 130]), geometries, ..Job::default() });
    let mut all = Vec::new();
    for axis in 0..3 {
        for engine in &mut engines {
            let (mesh, report) = meshed(&parts, &job, axis, engine).expect("a mesh");
            let added: Vec<u64> = report.filled.iter().map(|filled| filled.added_cells).collect();
            assert!(added.iter().all(|&added| added > 1000), "{added:?}");
            all.push((flags_of(&mesh), added));
        }
    }
    assert!(all.windows(2).all(|pair| pair[0] == pair[1]), "axes and backends agree");
}

#[test]
fn the_axis_the_backend_and_the_order_of_facets_change_nothing() {
    let gpu = pollster::block_on(Gpu::open(Some(&kernels::gpu().facts.name))).expect("it was opened before");
    let mut engines = [Engine::cpu(), Engine::with_gpu(gpu)];
    let mut random = Random::new(5);
    let ball = without(&models::sphere([4.0; 3], 3.4, 40), 0.05, 1);
    let ring = without(&models::torus([4.5; 3], [2.4, 1.1], 40), 0.02, 2);
    let whole = models::cuboid([2.0; 3], [6.0, 5.0, 7.0]);
    let parts = [ball, whole, ring];
    for rule in [Rule::Parity, Rule::Nonzero] {
        let job = set!(Job { dims: Some([70, 67, 130]), rule, ..Job::default() });
        let (first, of_first) = meshed(&parts, &job, 0, &mut engines[0]).expect("a mesh");
        let flags = flags_of(&first);
        assert!(of_first.doubtful.cells > 1000 && of_first.doubtful.boxes.len() > 100, "{:?}", of_first.doubtful.cells);
        assert!((1..=3).all(|flag| flags.contains(&flag)), "every geometry has cells");
        for axis in 0..3 {
            for engine in &mut engines {
                let (mesh, report) = meshed(&parts, &job, axis, engine).expect("a mesh");
                assert_eq!(flags_of(&mesh), flags, "axis {axis}, {}", engine.backend());
                assert_eq!(report.open.len(), 2);
                // rays of the mesh, and of three axes at the open ones
                let checked = report.device_check.map_or(0, |check| check.rays);
                let least = if engine.backend() == "gpu" { 3 * 64 } else { 0 };
                assert!(checked >= least && (checked > 0) == (engine.backend() == "gpu"), "{checked} rays");
                assert_eq!(report.doubtful, of_first.doubtful, "axis {axis}, {}", engine.backend());
            }
        }
        let other = parts.clone().map(|facets| shuffled(facets, &mut random));
        let (mesh, _) = meshed(&other, &job, 1, &mut engines[0]).expect("a mesh");
        assert_eq!(flags_of(&mesh), flags, "facets in another order");
    }
}
