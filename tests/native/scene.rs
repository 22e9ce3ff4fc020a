//! Scenes: after every edit the mesh is that of the whole job, and what is said to have changed is what changed.

use hexcast::job::{AxisChoice, BackendChoice, GeometryJob, LinesJob};
use hexcast::mesher::{Mesher, MesherOptions};
use hexcast::pipeline::MeshOptions;
use hexcast::scene::{Scene, Update, Whole};
use hexcast::write::{Format, Options, write};
use hexcast::{Control, Job, Mesh, Source};
use hexcast_core::stages::map::Rule;

use super::models::{self, Facets, sphere};
use super::soups::{BODIES, Random, body};

const DIMS: [u32; 3] = [13, 11, 17];

fn mesher(backend: BackendChoice) -> Mesher {
    Mesher::new(MesherOptions::default().with_backend(backend)).unwrap()
}

fn source(facets: Facets) -> Source {
    Source::from_facets("body", facets).unwrap()
}

fn entry(flag: u8) -> GeometryJob {
    set!(GeometryJob { flag: Some(flag), ..GeometryJob::new("body") })
}

/// A job over the box of so many unit cells.
fn job(n: u8, dims: [u32; 3]) -> Job {
    let [x, y, z] = dims.map(f64::from);
    let geometries = (1..=n).map(entry).collect();
    set!(Job { domain: Some([0.0, 0.0, 0.0, x, y, z]), dims: Some(dims), ..Job::new(geometries) })
}

fn scene(mesher: &mut Mesher, job: Job, sources: Vec<Source>) -> Scene {
    mesher.scene(job, sources, MeshOptions::default(), &Control::default()).unwrap()
}

fn flags(mesh: &Mesh) -> Vec<u8> {
    mesh.box_flags(&mesh.dims().map(|n| 0..n)).unwrap()
}

/// Puts the changes of an update over the flags before it.
fn change(flags: &mut [u8], mesh: &Mesh, update: &Update) {
    let (rays, [nx, ny, _]) = (*mesh.columns().rays(), mesh.dims().map(|n| n as usize));
    let changed = update.changed.as_ref().unwrap();
    assert!(changed.is_sorted() && changed.iter().all(|run| run.start < run.end && run.before != run.after));
    for run in changed {
        let across = [run.ray % u64::from(rays.counts[0]), run.ray / u64::from(rays.counts[0])].map(|at| at as u32);
        for along in run.start..run.end {
            let [x, y, z] = rays.cell([across[0], across[1], along]).map(|at| at as usize);
            let flag = &mut flags[x + nx * (y + ny * z)];
            assert_eq!(*flag, run.before, "{run:?}");
            *flag = run.after;
        }
    }
}

/// Compares the mesh of a scene with that of the whole job, made by another mesher.
fn assert_is_whole(scene: &Scene, update: &Update, before: &Mesh, whole_by: &mut Mesher) {
    let sources = scene.sources().to_vec();
    let made = whole_by.mesh_sources(scene.job(), sources, &MeshOptions::default(), &Control::default());
    let (mesh, report) = made.unwrap();
    assert_eq!(scene.mesh(), &mesh);
    let counts = |mesh: &Mesh| [mesh.columns().n_crossings(), mesh.columns().odd_rays(), mesh.columns().n_runs()];
    assert_eq!(counts(scene.mesh()), counts(&mesh));
    assert_eq!(*scene.cells_per_flag(), mesh.columns().cells_per_flag());
    let is_same_box = before.lines() == mesh.lines() && before.columns().rays() == mesh.columns().rays();
    assert_eq!(update.changed.is_some(), is_same_box);
    if is_same_box {
        let mut flags_before = flags(before);
        change(&mut flags_before, &mesh, update);
        assert_eq!(flags_before, flags(&mesh));
    }
    match update.whole {
        Some(_) => assert_eq!(update.findings, report.mesh.findings),
        None => {
            let is_empty = |of: &&hexcast_core::finding::Finding| of.code.starts_with("no-cell");
            let found: Vec<_> = update.findings.iter().filter(is_empty).collect();
            assert_eq!(found, report.mesh.findings.iter().filter(is_empty).collect::<Vec<_>>());
        }
    }
}

/// A body of four points on quarters of a cell, up to two cells out of the box; sometimes a sphere, which is cut at will.
fn any_body(random: &mut Random) -> Source {
    let point = |random: &mut Random| DIMS.map(|n| random.between(-8, 4 * n as i32 + 8) as f32 * 0.25);
    if random.below(3) == 0 {
        let centre = point(random);
        return source(sphere(centre, 1.0 + random.below(5) as f32, 8));
    }
    let points = [0; 4].map(|_| point(random));
    source(body(random.one_of(&BODIES), points))
}

/// One random edit. Most move a body.
fn edit(scene: &mut Scene, random: &mut Random) {
    let index = random.below(scene.job().geometries.len() as u64) as usize;
    let kind = random.below(24);
    if kind < 4 {
        scene.sources_mut()[index] = any_body(random);
        return;
    }
    if kind == 4 {
        let facets = models::cuboid([40.0; 3], [42.0; 3]);
        scene.sources_mut()[index] = source(facets);
        return;
    }
    let job = scene.job_mut();
    let quarters = |random: &mut Random, most: i32| [0; 3].map(|_| f64::from(random.between(-most, most)) * 0.25);
    match kind {
        5 | 6 => job.geometries[index].flag = Some(random.between(1, 6) as u8),
        7 | 8 => job.geometries[index].priority = random.between(-1, 1),
        9 => job.geometries[index].rotate = Some([0; 3].map(|_| f64::from(random.between(-180, 180)))),
        10 => job.axis = random.one_of(&[AxisChoice::X, AxisChoice::Y, AxisChoice::Z]),
        11 => job.rule = random.one_of(&[Rule::Parity, Rule::Nonzero]),
        12 if job.lines.is_none() => {
            job.dims = Some(DIMS.map(|n| n - random.below(3) as u32));
        }
        13 if job.lines.is_some() => {
            (job.lines, job.dims) = (None, Some(DIMS));
            job.domain = Some([0.0, 0.0, 0.0, 13.0, 11.0, 17.0]);
        }
        13 => {
            let mut lines = |n: u32| {
                let mut at = 0.0;
                let more = (0..n).map(|_| {
                    at += f64::from(random.between(2, 6)) * 0.25;
                    at
                });
                [vec![0.0], more.collect()].concat()
            };
            job.lines = Some(LinesJob { x: lines(12), y: lines(9), z: lines(10) });
            (job.dims, job.domain) = (None, None);
        }
        14 => job.geometries[index].invert = random.below(3) == 0,
        15 => job.geometries[index].scale = Some(hexcast::job::PerAxis::All(random.between(1, 6) as f64 * 0.25)),
        16 => job.geometries[index].translate = Some(quarters(random, 400)),
        _ => job.geometries[index].translate = Some(quarters(random, 16)),
    }
}

/// Edits some scenes at random; returns how many updates cast some rays only.
fn edits(seed: u64, n: u32, mesher: &mut Mesher, whole_by: &mut Mesher) -> u32 {
    let mut n_local = 0;
    let mut random = Random::new(seed);
    let n_bodies = 2 + random.below(4) as u8;
    let sources = (0..n_bodies).map(|_| any_body(&mut random)).collect();
    let mut scene = scene(mesher, job(n_bodies, DIMS), sources);
    for _ in 0..n {
        let before = scene.mesh().clone();
        for _ in 0..=random.below(3) / 2 {
            edit(&mut scene, &mut random);
        }
        match mesher.update(&mut scene, &Control::default()) {
            Ok(update) => {
                n_local += u32::from(update.whole.is_none());
                assert_is_whole(&scene, &update, &before, whole_by);
            }
            // the whole is refused, too
            Err(error) => {
                let sources = scene.sources().to_vec();
                let whole = whole_by.mesh_sources(scene.job(), sources, &MeshOptions::default(), &Control::default());
                assert_eq!(whole.map(|_| ()).unwrap_err().code(), error.code());
                assert_eq!(scene.mesh(), &before);
            }
        }
    }
    n_local
}

/// How many scenes of 50 edits, unless `HEXCAST_SCENES` says so: with 200 there are 10,000 edits.
fn n_scenes(otherwise: u64) -> u64 {
    std::env::var("HEXCAST_SCENES").ok().and_then(|n| n.parse().ok()).unwrap_or(otherwise)
}

#[test]
fn after_random_edits_the_mesh_is_that_of_the_whole_job() {
    let (mut mesher, mut whole_by) = (mesher(BackendChoice::Cpu), mesher(BackendChoice::Cpu));
    let (mut n_local, n) = (0, n_scenes(8));
    for seed in 0..n {
        println!("seed {seed}");
        n_local += edits(seed, 50, &mut mesher, &mut whole_by);
    }
    println!("{n_local} of {} edits cast some rays only", 50 * n);
    assert!(u64::from(n_local) > 50 * n / 10, "{n_local}");
}

#[cfg(feature = "gpu")]
mod gpu {
    use super::*;

    #[test]
    fn after_random_edits_the_mesh_is_that_of_the_cpu() {
        let (mut mesher, mut whole_by) = (mesher(BackendChoice::Gpu), mesher(BackendChoice::Cpu));
        let (mut n_local, n) = (0, n_scenes(1));
        for seed in 7..7 + n {
            println!("seed {seed}");
            n_local += edits(seed, 50, &mut mesher, &mut whole_by);
        }
        println!("{n_local} of {} edits cast some rays only", 50 * n);
        assert!(u64::from(n_local) > 50 * n / 10, "{n_local}");
    }
}

#[test]
fn a_body_that_moves_changes_its_own_rays() {
    let mut mesher = mesher(BackendChoice::Cpu);
    let (ball, block) = (source(sphere([4.0; 3], 2.0, 12)), source(models::cuboid([0.0; 3], [16.0, 16.0, 3.0])));
    let mut scene = scene(&mut mesher, job(2, [16; 3]), vec![ball, block]);
    assert_eq!(scene.mesh().columns().rays().axis, 0);
    let before = scene.mesh().clone();
    scene.job_mut().geometries[0].translate = Some([1.0, 0.0, 0.0]);
    let update = mesher.update(&mut scene, &Control::default()).unwrap();
    assert_eq!(update.whole, None);
    // those through the ball
    assert!((9..=25).contains(&update.rays), "{}", update.rays);
    assert_is_whole(&scene, &update, &before, &mut self::mesher(BackendChoice::Cpu));
    // the file does not tell how the mesh came about
    let bytes = |mesh: &Mesh| {
        let mut bytes = Vec::new();
        write(mesh, Format::Columns, &Options::default(), &mut bytes, &Control::default()).unwrap();
        bytes
    };
    let (whole, _) = mesher
        .mesh_sources(scene.job(), scene.sources().to_vec(), &MeshOptions::default(), &Control::default())
        .unwrap();
    assert_eq!(bytes(scene.mesh()), bytes(&whole));
    // nothing was edited
    let update = mesher.update(&mut scene, &Control::default()).unwrap();
    assert_eq!((update.rays, update.changed), (0, Some(vec![])));
}

#[test]
fn a_flag_changes_the_rays_of_its_body_and_its_name() {
    let mut mesher = mesher(BackendChoice::Cpu);
    let balls = [4.0, 12.0].map(|x| source(sphere([x, 8.0, 8.0], 2.0, 12))).to_vec();
    let mut scene = scene(&mut mesher, job(2, [16; 3]), balls);
    let before = scene.mesh().clone();
    let n = scene.cells_per_flag()[2];
    scene.job_mut().geometries[1].flag = Some(9);
    let update = mesher.update(&mut scene, &Control::default()).unwrap();
    assert_eq!((update.whole, scene.cells_per_flag()[2], scene.cells_per_flag()[9]), (None, 0, n));
    assert!(update.changed.iter().flatten().all(|run| (run.before, run.after) == (2, 9)));
    assert_is_whole(&scene, &update, &before, &mut self::mesher(BackendChoice::Cpu));
}

#[test]
fn a_geometry_that_loses_its_cells_is_named() {
    let mut mesher = mesher(BackendChoice::Cpu);
    let balls = [4.0, 12.0].map(|x| source(sphere([x, 8.0, 8.0], 2.0, 12))).to_vec();
    let mut scene = scene(&mut mesher, job(2, [16; 3]), balls);
    scene.job_mut().geometries[1].translate = Some([0.0, 0.0, 20.0]);
    let update = mesher.update(&mut scene, &Control::default()).unwrap();
    let codes: Vec<&str> = update.findings.iter().map(|finding| finding.code).collect();
    assert_eq!((update.whole, codes), (None, vec!["no-cell-outside"]));
}

#[test]
fn what_is_not_decided_ray_by_ray_is_meshed_whole_and_says_why() {
    let mut mesher = mesher(BackendChoice::Cpu);
    let ball = || sphere([8.0; 3], 4.0, 12);
    let mut scene = scene(&mut mesher, job(1, [16; 3]), vec![source(ball())]);
    let mut why = |edit: &dyn Fn(&mut Scene)| {
        edit(&mut scene);
        let before = scene.mesh().clone();
        let update = mesher.update(&mut scene, &Control::default()).unwrap();
        assert_eq!(scene.report().is_some(), update.whole.is_some());
        assert_is_whole(&scene, &update, &before, &mut self::mesher(BackendChoice::Cpu));
        update.whole
    };
    let moved = |x: f64| move |scene: &mut Scene| scene.job_mut().geometries[0].translate = Some([x, 0.0, 0.0]);
    assert_eq!(why(&moved(1.0)), None);
    assert_eq!(why(&|scene| scene.sources_mut()[0] = source(ball()[1..].to_vec())), Some(Whole::Surface));
    // it was open before
    assert_eq!(why(&|scene| scene.sources_mut()[0] = source(ball())), Some(Whole::Surface));
    assert_eq!(why(&moved(2.0)), None);
    assert_eq!(why(&|scene| scene.job_mut().geometries[0].shell = true), Some(Whole::Surface));
    assert_eq!(why(&|scene| scene.job_mut().geometries[0].shell = false), Some(Whole::Surface));
    assert_eq!(why(&|scene| scene.job_mut().close_gaps = Some(3)), Some(Whole::Asked));
    assert_eq!(why(&|scene| scene.job_mut().close_gaps = None), Some(Whole::Asked));
    assert_eq!(why(&|scene| scene.job_mut().window = Some([1, 1, 1, 9, 9, 9])), Some(Whole::Asked));
    assert_eq!(why(&|scene| scene.job_mut().window = None), Some(Whole::Asked));
    assert_eq!(why(&|scene| scene.job_mut().dims = Some([15; 3])), Some(Whole::Box));
    // far outside of the box corners are snapped less finely
    assert_eq!(why(&moved(1000.0)), Some(Whole::Box));
    assert_eq!(why(&moved(1001.0)), None);
}

#[test]
fn after_an_error_the_mesh_stays_and_the_edit_can_be_changed() {
    let mut mesher = mesher(BackendChoice::Cpu);
    let mut scene = scene(&mut mesher, job(1, [16; 3]), vec![source(sphere([8.0; 3], 4.0, 12))]);
    let before = scene.mesh().clone();
    let wrong = [f64::NAN, 1e9];
    for (x, code) in wrong.into_iter().zip(["job-value", "geometry-too-far"]) {
        scene.job_mut().geometries[0].translate = Some([x, 0.0, 0.0]);
        assert_eq!(mesher.update(&mut scene, &Control::default()).unwrap_err().code(), code);
        assert_eq!(scene.mesh(), &before);
    }
    scene.job_mut().geometries[0].translate = Some([2.0, 0.0, 0.0]);
    let control = Control::default();
    control.cancel.cancel();
    assert_eq!(mesher.update(&mut scene, &control).unwrap_err().code(), "cancelled");
    let update = mesher.update(&mut scene, &Control::default()).unwrap();
    assert_eq!(update.whole, None);
    assert_is_whole(&scene, &update, &before, &mut self::mesher(BackendChoice::Cpu));
}

#[test]
fn of_more_bodies_than_ranks_some_move() {
    let mut mesher = mesher(BackendChoice::Cpu);
    let ball = |index: u32| {
        let at = [index % 10, index / 10 % 10, index / 100].map(|n| 3.0 * n as f32 + 1.5);
        source(sphere(at, 1.2, 6))
    };
    let mut job = job(1, [30, 30, 9]);
    job.geometries = vec![entry(1); 300];
    let mut scene = scene(&mut mesher, job, (0..300).map(ball).collect());
    for (index, by) in [(7, [0.5, 0.0, 0.0]), (7, [3.0, 0.0, 0.0]), (150, [0.0, 6.0, 0.0])] {
        let before = scene.mesh().clone();
        scene.job_mut().geometries[index].translate = Some(by);
        let update = mesher.update(&mut scene, &Control::default()).unwrap();
        assert_eq!(update.whole, None);
        assert_is_whole(&scene, &update, &before, &mut self::mesher(BackendChoice::Cpu));
    }
}
