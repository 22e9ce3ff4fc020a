//! Random jobs of every kind that `mesh` takes: `verify` refuses none, agrees with all, and finds a cell that was changed.
//!
//! `HEXCAST_VERIFY_JOBS=500` checks so many.

use hexcast::job::{Fill, GeometryJob, GradedJob, HaloEdge, Job, LinesJob, Padding, PartJob, PerAxis, Rule};

use super::super::models::{self, Facets};
use super::super::open_surfaces::without;
use super::super::soups::{BODIES, Random, body};
use super::faults::changed;
use super::{AXES, Meshed, OPEN};

/// Corners on a grid of eighths, so that many lie on centres and lines, or anywhere.
fn surface(random: &mut Random) -> Facets {
    let is_on_grid = random.below(3) > 0;
    let mut place = || {
        let eighths = random.between(0, 64) as f32 / 8.0;
        if is_on_grid { eighths } else { eighths + random.between(-999, 999) as f32 / 8192.0 }
    };
    let points = [(); 4].map(|()| [place(), place(), place()]);
    let kind = random.one_of(&BODIES);
    let solid = match random.below(4) {
        0 => models::sphere(points[0], 0.5 + random.below(30) as f32 / 10.0, 5 + random.below(6) as usize),
        1 => models::joined([body(kind, points), models::cuboid([2.0; 3], [5.0, 4.5, 6.0])]),
        _ => body(kind, points),
    };
    let torn = without(&solid, 0.2, random.below(1 << 40));
    if random.below(3) == 0 && !torn.is_empty() { torn } else { solid }
}

fn entry(random: &mut Random) -> GeometryJob {
    let shell = random.below(6) == 0;
    let fill = random.one_of(&[None, None, Some(Fill::Centre), Some(Fill::Separating), Some(Fill::Conservative)]);
    let rotate = random.one_of(&[None, None, None, Some([10.0, 90.0, -33.0])]);
    set!(GeometryJob {
        flag: random.one_of(&[None, None, Some(7), Some(3)]),
        priority: random.between(-1, 1),
        open: random.one_of(&[None, Some(OPEN[0]), Some(OPEN[1]), Some(OPEN[2])]),
        fill: fill.filter(|fill| !(shell && *fill == Fill::Centre)),
        shell,
        invert: !shell && random.below(5) == 0,
        metal: random.below(6) == 0,
        max_size: random.one_of(&[None, None, Some(0.9)]),
        min_cells: random.one_of(&[None, None, None, Some(3)]),
        scale: random.one_of(&[None, None, Some(PerAxis::Each([0.8, -1.0, 1.1]))]),
        rotate,
        about: rotate.and(random.one_of(&[None, Some([0.3, -0.7, 0.45])])),
        ..GeometryJob::new(".")
    })
}

/// Lines of an axis: uneven, or even by chance.
fn list(random: &mut Random) -> Vec<f64> {
    let mut lines = vec![f64::from(random.between(-16, 8)) / 8.0];
    let steps = random.one_of(&[&[0.5][..], &[0.1], &[0.25, 0.5, 0.8], &[0.3, 1.7]]);
    for _ in 0..random.between(1, 24) {
        lines.push(lines[lines.len() - 1] + random.one_of(steps));
    }
    lines
}

fn with_cells(job: Job, random: &mut Random) -> Job {
    let padding = match random.below(4) {
        0 => Some(Padding::Cells(PerAxis::Each([1, 0, 2]))),
        1 => Some(Padding::Length(PerAxis::All(0.4))),
        _ => None,
    };
    let domain = random.one_of(&[None, Some([0.0, 0.0, 0.0, 8.0, 8.0, 8.0]), Some([1.1, -0.7, 2.0, 9.0, 6.5, 7.0])]);
    let job = set!(Job { padding, domain, ..job });
    let sized = |size| Some(PerAxis::All(size));
    match random.below(8) {
        0 => set!(Job { cells: Some(3 + random.below(20) as u32), ..job }),
        1 | 2 => set!(Job { dims: Some([(); 3].map(|()| 1 + random.below(20) as u32)), ..job }),
        3 => set!(Job { cell_size: sized(0.4 + random.below(9) as f64 / 10.0), ..job }),
        4 => set!(Job { max_cell_size: Some(0.9), tolerance: Some(0.3), ..job }),
        5 => {
            let lines = LinesJob { x: list(random), y: list(random), z: list(random) };
            set!(Job { lines: Some(lines), padding: None, domain: None, ..job })
        }
        _ => {
            let max_size = PerAxis::All(0.6 + random.below(9) as f64 / 10.0);
            let graded = set!(GradedJob {
                min_size: random.one_of(&[None, Some(0.05), Some(0.2)]),
                growth: random.one_of(&[None, Some(1.5), Some(3.0)]),
                absorbing: random.one_of(&[None, Some(PerAxis::Each([2, 0, 1]))]),
                ..GradedJob::new(max_size)
            });
            let padding = padding.filter(|padding| matches!(padding, Padding::Length(_)));
            set!(Job { graded: Some(graded), padding, ..job })
        }
    }
}

fn with_window(job: Job, random: &mut Random) -> Job {
    let halo = random.one_of(&[None, Some(1), Some(3)]);
    let halo_edge = halo.and_then(|_| random.one_of(&[None, Some(HaloEdge::Clamp), Some(HaloEdge::Background)]));
    match random.below(5) {
        0 => {
            let first = [(); 3].map(|()| random.below(3) as u32);
            let end = first.map(|first| first + 1 + random.below(6) as u32);
            let window = Some([first[0], first[1], first[2], end[0], end[1], end[2]]);
            set!(Job { window, halo, halo_edge, ..job })
        }
        1 => {
            let of = [(); 3].map(|()| 1 + random.below(3) as u32);
            let part = PartJob::new(1 + random.below(of.iter().product::<u32>().into()) as u32, of);
            set!(Job { part: Some(part), halo, halo_edge, ..job })
        }
        2 => set!(Job {
            close_gaps: Some(2 + random.below(4) as u32),
            gap_flag: random.one_of(&[None, Some(99)]),
            ..job
        }),
        _ => job,
    }
}

pub(crate) fn job(seed: u64) -> (Vec<Facets>, Job, Random) {
    let mut random = Random::new(seed);
    let surfaces: Vec<Facets> = (0..=random.below(3)).map(|_| surface(&mut random)).collect();
    let job = set!(Job {
        geometries: surfaces.iter().map(|_| entry(&mut random)).collect(),
        rule: random.one_of(&[Rule::Parity, Rule::Nonzero]),
        axis: random.one_of(&AXES),
        open: random.one_of(&OPEN),
        fill: random.one_of(&[Fill::Centre, Fill::Centre, Fill::Separating]),
        ..Job::default()
    });
    let mut job = with_cells(job, &mut random);
    if job.graded.is_none() {
        job.geometries.iter_mut().for_each(GeometryJob::clear_sizing);
    }
    (surfaces, with_window(job, &mut random), random)
}

#[test]
fn random_jobs_are_verified_and_a_changed_cell_is_found() {
    let n_jobs = std::env::var("HEXCAST_VERIFY_JOBS").map_or(60, |n| n.parse().expect("a number of jobs"));
    let (mut n_meshed, mut n_found, mut n_unknown, mut seed) = (0, 0, 0, 0);
    let mut wrong = Vec::new();
    while n_meshed < n_jobs {
        seed += 1;
        let (surfaces, job, mut random) = job(seed);
        let Some(meshed) = Meshed::if_meshed(&surfaces, job) else { continue };
        n_meshed += 1;
        let (code, text) = meshed.verify(&[]);
        if code != Some(0) {
            wrong.push(format!("seed {seed}: {code:?}\n{text}\n{}", meshed.job.to_json()));
            continue;
        }
        let same = changed(&meshed, |_, _| {});
        let cell = random.below(same.n_cells());
        let depth = u64::from(same.columns().rays().depth);
        meshed.write(&changed(&meshed, |ray, flags| {
            if ray == cell / depth {
                flags[(cell % depth) as usize] ^= 64;
            }
        }));
        let (code, found) = meshed.verify(&[]);
        match code {
            Some(9) if found.contains("Wrong cells: 1.") => n_found += 1,
            Some(0) if !found.contains(", of which 0 are too close to call") && found.contains("Doubtful") => {
                n_unknown += 1
            }
            _ => wrong.push(format!("seed {seed}, changed: {code:?}\n{found}")),
        }
    }
    println!("seeds 1 to {seed}: {n_meshed} meshed, {n_found} changes found, {n_unknown} of cells that nobody knows");
    assert!(wrong.is_empty(), "{} of {n_meshed}: {}", wrong.len(), wrong.join("\n"));
    assert!(n_found > n_unknown * 9, "{n_found} found, {n_unknown} of cells that nobody knows");
}
