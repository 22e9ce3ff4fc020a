//! A window of a mesh has the cells that the whole mesh has there: on random windows of closed and open models, along every axis, on both
//! backends, whatever is filled, inverted or a shell.

use hexcast::gpu::Gpu;
use hexcast::job::{Fill, GeometryJob, Job, Open, Rule};
use hexcast::pipeline::Engine;

use super::kernels;
use crate::models::{self, Facets};
use crate::open_surfaces::{flags_of, meshed, without};
use crate::soups::Random;

/// Windows of each mesh, on the CPU and on the GPU.
const WINDOWS: [usize; 2] = [96, 4];
const MESHES: u64 = 100;

/// A job of up to three geometries; every third has holes.
fn random_job(random: &mut Random, seed: u64) -> (Vec<Facets>, Job) {
    let n = 1 + random.below(3);
    let mut parts = Vec::new();
    let mut geometries = Vec::new();
    for index in 0..n {
        let at = [0, 1, 2].map(|_| random.below(40) as f32 / 10.0);
        let whole = match random.below(3) {
            0 => models::sphere(at, 1.0 + random.below(20) as f32 / 10.0, 12),
            1 => models::torus(at, [2.0, 0.7], 14),
            _ => models::cuboid(at, [at[0] + 1.7, at[1] + 2.9, at[2] + 0.8]),
        };
        let is_open = random.below(3) == 0;
        parts.push(if is_open { without(&whole, 0.1, seed + index) } else { whole });
        let fill = [Fill::Centre, Fill::Centre, Fill::Conservative, Fill::Separating][random.below(4) as usize];
        let shell = fill != Fill::Centre && random.below(3) == 0;
        let invert = !shell && random.below(8) == 0;
        geometries.push(set!(GeometryJob {
            fill: Some(fill),
            shell,
            invert,
            priority: -i32::from(invert),
            ..Default::default()
        }));
    }
    let dims = [0, 1, 2].map(|_| 3 + random.below(22) as u32);
    let rule = if random.below(2) == 0 { Rule::Parity } else { Rule::Nonzero };
    let open = [Open::Winding, Open::Vote][random.below(2) as usize];
    // the domain is smaller than the models in some, so that facets lie beyond it
    let domain = (random.below(2) == 0).then_some([0.3, 0.1, 0.2, 4.1, 4.4, 3.9]);
    (parts, set!(Job { geometries, dims: Some(dims), rule, open, domain, ..Job::default() }))
}

fn random_window(random: &mut Random, dims: [u32; 3]) -> [u32; 6] {
    let mut window = [0; 6];
    for axis in 0..3 {
        let [one, other] = [0, 1].map(|_| random.below(u64::from(dims[axis])) as u32);
        window[axis] = one.min(other);
        window[axis + 3] = one.max(other) + 1;
    }
    window
}

#[test]
fn ten_thousand_windows_have_the_cells_of_the_whole() {
    let gpu = pollster::block_on(Gpu::open(Some(&kernels::gpu().facts.name))).expect("it was opened before");
    let mut engines = [Engine::cpu(), Engine::with_gpu(gpu)];
    let mut random = Random::new(77);
    let mut n_flagged = 0;
    for seed in 0..MESHES {
        let (parts, job) = random_job(&mut random, seed);
        let whole = match meshed(&parts, &job, 0, &mut engines[0]) {
            Ok((mesh, _)) => mesh,
            Err(error) => panic!("mesh {seed}: {error}"),
        };
        for (engine, n_windows) in engines.iter_mut().zip(WINDOWS) {
            for index in 0..n_windows {
                let window = random_window(&mut random, whole.dims());
                let [i0, j0, k0, i1, j1, k1] = window;
                let expected = whole.box_flags(&[i0..i1, j0..j1, k0..k1]).expect("columns in memory");
                let job = set!(Job { window: Some(window), ..job.clone() });
                let (mesh, facts) = meshed(&parts, &job, index % 3, engine).expect("a window");
                assert_eq!(flags_of(&mesh), expected, "mesh {seed}, window {window:?}, {}: {job:?}", engine.backend());
                assert_eq!(facts.window.map(|window| window.of), Some(whole.dims()));
                assert_eq!(mesh.lines().origin(), [0, 1, 2].map(|axis| whole.lines().line(axis, window[axis])));
                n_flagged += expected.iter().filter(|&&flag| flag > 0).count();
            }
        }
    }
    assert!(n_flagged > 500_000, "{n_flagged} cells of geometries");
}

#[test]
fn a_window_beyond_the_box_is_refused_and_so_is_what_needs_more() {
    let parts = [models::cuboid([0.0; 3], [1.0; 3])];
    let refused = |window: [u32; 6], job: Job| {
        let job = set!(Job { window: Some(window), dims: Some([5, 6, 7]), ..job });
        meshed(&parts, &job, 0, &mut Engine::cpu()).map(|_| ()).expect_err("it is refused")
    };
    let error = refused([0, 0, 0, 5, 7, 7], Job::default());
    assert_eq!(error.code(), "job-value");
    assert!(error.to_string().contains("window ends at cell 5, 7, 7: the box has 5 x 6 x 7"), "{error}");
    let error = refused([0, 3, 0, 5, 3, 7], Job::default());
    assert!(error.code() == "job-value" && error.to_string().contains("cells 3 to 3 along y"), "{error}");
    let open = vec![without(&models::sphere([0.0; 3], 1.0, 12), 0.1, 1)];
    let window = Some([0, 0, 0, 2, 2, 2]);
    let job = set!(Job { window, open: Open::Parity, dims: Some([5, 6, 7]), ..Job::default() });
    let error = meshed(&open, &job, 0, &mut Engine::cpu()).map(|_| ()).expect_err("it needs whole rays");
    assert_eq!(error.code(), "surface-open");
    let error = refused([0, 0, 0, 5, 6, 7], set!(Job { close_gaps: Some(2), ..Job::default() }));
    assert_eq!(error.code(), "job-conflict");
}
