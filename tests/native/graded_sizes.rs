//! The sizes of generated lines, for random jobs with few ends on lines of their own: an oracle reads the lines and the job, and nothing else.

use hexcast::job::{GeometryJob, GradedJob, Job, Padding, PerAxis};
use hexcast::pipeline::prepare;
use hexcast::sources::Source;

use super::models::{self, Facets};
use super::soups::Random;

type Box3 = [[f32; 3]; 2];

/// A job, and the boxes of its geometries, whose corners are multiples of 2^-6.
fn scene(seed: u64) -> (Job, Vec<Box3>) {
    let mut random = Random::new(seed);
    let part =
        |random: &mut Random, low: f64, high: f64| low + (high - low) * (random.below(1 << 20) as f64 / 1048576.0);
    let most = part(&mut random, 0.5, 7.0);
    let least = most * part(&mut random, 0.01, 0.2);
    let (mut boxes, mut geometries) = (Vec::new(), Vec::new());
    for index in 0..1 + random.below(6) {
        let mut bounds: Box3 = [[0.0; 3]; 2];
        for axis in 0..3 {
            let low = random.between(-640, 640);
            // thin ones, flat ones, and what is large
            let length = match random.below(12) {
                0 => 0,
                1..6 => random.between(1, 96),
                _ => random.between(64, 900),
            };
            bounds[0][axis] = low as f32 / 64.0;
            bounds[1][axis] = (low + length) as f32 / 64.0;
        }
        let mut geometry = GeometryJob::new(format!("{index}.stl"));
        if random.below(3) > 0 {
            geometry = set!(GeometryJob { max_size: Some(part(&mut random, least, 1.5 * most)), ..geometry });
        }
        if random.below(3) == 0 {
            geometry = set!(GeometryJob { min_cells: Some(1 + random.below(6) as u32), ..geometry });
        }
        geometries.push(set!(GeometryJob { metal: random.below(4) == 0, ..geometry }));
        boxes.push(bounds);
    }
    let growth = [None, Some(1.2), Some(2.0), Some(5.0)][random.below(4) as usize];
    let absorbing = [None, Some(PerAxis::All(3))][random.below(2) as usize];
    let max_size = match random.below(3) {
        0 => PerAxis::Each([most, 1.5 * most, most]),
        _ => PerAxis::All(most),
    };
    let mut job = set!(Job {
        graded: Some(set!(GradedJob { min_size: Some(least), growth, absorbing, ..GradedJob::new(max_size) })),
        ..Job::new(geometries)
    });
    match random.below(3) {
        0 => {
            job = set!(Job {
                padding: Some(Padding::Length(PerAxis::All(f64::from(random.between(1, 640)) / 64.0))),
                ..job
            })
        }
        1 => job = set!(Job { domain: Some([-8.0, -9.0, -10.0, 8.0, 9.5, 11.0]), ..job }),
        _ => {}
    }
    (job, boxes)
}

/// The ends of the box that is meshed, as the documentation has it.
fn domain(job: &Job, boxes: &[Box3], axis: usize) -> [f64; 2] {
    let around = |side: usize, of: fn(f64, f64) -> f64| {
        boxes.iter().map(|bounds| f64::from(bounds[side][axis])).reduce(of).expect("a box")
    };
    let ends = job.domain.map_or([around(0, f64::min), around(1, f64::max)], |at| [at[axis], at[axis + 3]]);
    let padding = match job.padding {
        Some(Padding::Length(PerAxis::All(length))) => length,
        _ => 0.0,
    };
    [ends[0] - padding, ends[1] + padding]
}

/// Every promise about sizes that the lines of an axis break.
fn broken(job: &Job, boxes: &[Box3], list: &[f64], axis: usize) -> Vec<String> {
    let graded = job.graded.as_ref().expect("a job of graded lines");
    let of_axis = |each: PerAxis<f64>| match each {
        PerAxis::All(size) => size,
        PerAxis::Each(sizes) => sizes[axis],
    };
    let (most, least) = (of_axis(graded.max_size), graded.min_size.expect("a smallest size"));
    let growth = graded.growth.unwrap_or(1.3);
    let (slack, mut wrong) = (1.0 + 1e-6, Vec::new());
    let cells: Vec<[f64; 2]> = list.windows(2).map(|two| [two[0], two[1]]).collect();
    for [from, to] in &cells {
        if to - from > most * slack || (to - from) * slack < least {
            wrong.push(format!("a cell of {}, not {least} to {most}", to - from));
        }
    }
    for two in cells.windows(2) {
        let [one, other] = [two[0][1] - two[0][0], two[1][1] - two[1][0]];
        if one.max(other) > one.min(other) * growth * slack {
            wrong.push(format!("neighbours of {one} and {other}: growth {growth}"));
        }
    }
    let [first, last] = domain(job, boxes, axis);
    for (geometry, bounds) in job.geometries.iter().zip(boxes) {
        let [low, high] = [f64::from(bounds[0][axis]).max(first), f64::from(bounds[1][axis]).min(last)];
        let inside = |of: &&[f64; 2]| of[0] < high && low < of[1];
        let largest = cells.iter().filter(inside).map(|[from, to]| to - from).fold(0.0, f64::max);
        if let Some(size) = geometry.max_size.filter(|size| largest > size * slack) {
            wrong.push(format!("{low} to {high}: a cell of {largest}, at most {size}"));
        }
        if low < high
            && let Some(n) = geometry.min_cells
        {
            if largest > (high - low) / f64::from(n) * slack {
                wrong.push(format!("{low} to {high}: a cell of {largest}, and {n} cells wanted"));
            }
            let within = cells.iter().filter(|[from, to]| *from >= low - 1e-9 && *to <= high + 1e-9).count();
            if within < n as usize {
                wrong.push(format!("{low} to {high}: {within} cells, at least {n}"));
            }
        }
    }
    wrong
}

fn facets([low, high]: &Box3) -> Facets {
    models::cuboid(*low, *high)
}

#[test]
fn no_cell_is_larger_than_a_geometry_in_it_wants_in_500_jobs() {
    let [mut n_made, mut n_refused, mut n_lost] = [0; 3];
    let mut broken_of = Vec::new();
    for seed in 26_000..26_500 {
        let (job, boxes) = scene(seed);
        let source =
            |(index, bounds): (usize, &Box3)| Source::from_facets(format!("{index}.stl"), facets(bounds)).unwrap();
        match prepare(&job, boxes.iter().enumerate().map(source).collect()) {
            Ok(prepared) => {
                n_made += 1;
                n_lost += usize::from(prepared.notices.iter().any(|of| of.code == "end-without-line"));
                for axis in 0..3 {
                    let list = prepared.whole.list(axis);
                    let wrong = broken(&job, &boxes, &list, axis);
                    broken_of.extend(wrong.first().map(|wrong| format!("seed {seed}, axis {axis}: {wrong}")));
                }
            }
            Err(error) => {
                n_refused += 1;
                assert!(matches!(error.code(), "lines-no-sizes" | "domain-empty"), "seed {seed}: {error}");
            }
        }
    }
    assert!(broken_of.is_empty(), "{} of {n_made} jobs: {broken_of:#?}", broken_of.len());
    println!("seeds 26000 to 26499: {n_made} made, {n_lost} of them with ends off their lines, {n_refused} refused");
    assert!(n_made > 150 && n_lost > 60, "{n_made} made, {n_lost} with ends off their lines, {n_refused} refused");
}

#[test]
fn the_oracle_finds_cells_that_are_too_large_or_too_few() {
    let graded = set!(GradedJob { min_size: Some(0.5), growth: Some(2.0), ..GradedJob::new(PerAxis::All(4.0)) });
    let geometries = vec![
        set!(GeometryJob { max_size: Some(1.0), min_cells: Some(2), ..GeometryJob::new("0.stl") }),
        GeometryJob::new("1.stl"),
    ];
    let job = set!(Job { graded: Some(graded), ..Job::new(geometries) });
    let boxes = [[[2.0; 3], [4.0; 3]], [[0.0; 3], [8.0; 3]]];
    let wrong = |list: &[f64]| broken(&job, &boxes, list, 0);
    assert!(wrong(&[0.0, 2.0, 3.0, 4.0, 6.0, 8.0]).is_empty());
    let [few, large, alike, growing] = [
        wrong(&[0.0, 1.5, 2.5, 3.5, 4.5, 6.0, 8.0]),
        wrong(&[0.0, 2.0, 4.0, 6.0, 8.0]),
        wrong(&[0.0, 2.0, 3.0, 3.9, 5.4, 8.0]),
        wrong(&[0.0, 2.0, 2.6, 3.2, 4.0, 8.0]),
    ];
    assert!(few.len() == 1 && few[0].contains("1 cells, at least 2"), "{few:?}");
    assert!(large.len() == 3 && large[0].contains("a cell of 2, at most 1"), "{large:?}");
    assert!(alike.iter().any(|text| text.contains("a cell of 1.5")), "{alike:?}");
    assert!(growing.iter().any(|text| text.contains("neighbours")), "{growing:?}");
}
