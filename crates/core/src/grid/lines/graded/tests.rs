//! What generated lines promise, checked on the lists alone, for random boxes and sizes.

use proptest::prelude::*;

use super::*;
use crate::input::job::{GeometryJob, Job};
use crate::set;

mod axis;

#[derive(Debug, Clone)]
struct Scene {
    job: GradedJob,
    bodies: Vec<(BoundingBox, Sizing)>,
}

fn bounds() -> impl Strategy<Value = BoundingBox> {
    // on a grid, so that ends meet, with some that nearly do
    let end = prop_oneof![4 => (-40i32..40).prop_map(|at| f64::from(at) * 0.5), 1 => -20.0..20.0f64];
    let side = move || [end.clone(), end.clone(), end.clone()];
    (side(), side()).prop_map(|(one, other)| {
        let low = [0, 1, 2].map(|axis: usize| one[axis].min(other[axis]));
        [low, [0, 1, 2].map(|axis: usize| one[axis].max(other[axis]).max(low[axis] + 0.05))]
    })
}

fn sizing() -> impl Strategy<Value = Sizing> {
    let max_size = prop::option::of(0.05..3.0f64);
    (max_size, prop::option::of(1u32..9), any::<bool>())
        .prop_map(|(max_size, min_cells, metal)| set!(Sizing { max_size, min_cells, metal, ..Sizing::default() }))
}

fn scenes() -> impl Strategy<Value = Scene> {
    let job = (0.3..5.0f64, prop::option::of(0.001..0.02f64), prop::option::of(1.1..2.0f64), 0u32..9);
    let job = job.prop_map(|(size, min_size, growth, layers)| {
        set!(GradedJob {
            min_size,
            growth,
            absorbing: Some(PerAxis::All(layers)),
            ..GradedJob::new(PerAxis::All(size))
        })
    });
    (job, prop::collection::vec((bounds(), sizing()), 1..6)).prop_map(|(job, bodies)| Scene { job, bodies })
}

fn made(scene: &Scene) -> (Domain, Result<(Lines, Vec<Finding>)>) {
    let boxes: Vec<BoundingBox> = scene.bodies.iter().map(|body| body.0).collect();
    let job = set!(Job { geometries: vec![GeometryJob::new("a.stl")], ..Job::default() });
    let domain = Domain::new(&job, &boxes).unwrap();
    let names: Vec<String> = (0..boxes.len()).map(|index| format!("body {index}")).collect();
    let bodies: Vec<Body> =
        scene.bodies.iter().zip(&names).map(|(&(bounds, sizing), name)| Body { name, bounds, sizing }).collect();
    let lines = graded(&scene.job, &domain, &bodies);
    (domain, lines)
}

/// Holds the lines of an axis to the job; an end may be off its line only if a sentence says so.
fn check(
    scene: &Scene,
    domain: &Domain,
    list: &[f64],
    axis: usize,
    findings: &[Finding],
) -> std::result::Result<(), String> {
    let most = scene.job.max_size.each()[axis] * (1.0 + 1e-9);
    let least = scene.job.min_size.unwrap_or(scene.job.max_size.each()[axis] / 1000.0) * (1.0 - 1e-6);
    let growth = scene.job.growth.unwrap_or(1.3) * (1.0 + 1e-6);
    let sizes: Vec<f64> = list.windows(2).map(|two| two[1] - two[0]).collect();
    if let Some(size) = sizes.iter().find(|size| !(least..=most).contains(*size)) {
        return Err(format!("a cell of {size}, not {least} to {most}"));
    }
    if let Some(two) = sizes.windows(2).find(|two| two[0] / two[1] > growth || two[1] / two[0] > growth) {
        return Err(format!("neighbours of {two:?}, growth {growth}"));
    }
    let layers = scene.job.absorbing.unwrap().each()[axis] as usize;
    let n = sizes.len();
    for layer in 0..layers {
        let [first, last] = [sizes[layer] / sizes[layers], sizes[n - 1 - layer] / sizes[n - 1 - layers]];
        if (first - 1.0).abs() > 1e-9 || (last - 1.0).abs() > 1e-9 {
            return Err("absorbing cells differ from those at the ends".into());
        }
    }
    if list[layers] != domain.low[axis] || list[n - layers] != domain.high[axis] {
        return Err("the ends of the domain are not on lines".into());
    }
    for (index, &([low, high], sizing)) in scene.bodies.iter().enumerate() {
        let is_excused = |at: f64| {
            let place = format!("= {at} ");
            findings
                .iter()
                .any(|found| found.sentence.contains(&format!("\"body {index}\"")) && found.sentence.contains(&place))
        };
        let mut has_both = true;
        for (end, outwards) in [(low[axis], -1.0), (high[axis], 1.0)] {
            let after = list.partition_point(|line| *line <= end).min(n);
            let (below, above) = (list[after - 1], list[after]);
            let inside = if outwards > 0.0 { end - below } else { above - end } / (above - below);
            let is_third = sizing.metal && (inside - 1.0 / 3.0).abs() < 1e-6;
            let is_off = !list.contains(&end);
            has_both &= !is_off;
            if is_off && !is_third && !is_excused(end) {
                return Err(format!("the end {end} of body {index} has no line: {below} and {above} are nearest"));
            }
        }
        if let Some(size) = sizing.max_size {
            let within = list.windows(2).filter(|two| (low[axis]..high[axis]).contains(&(0.5 * (two[0] + two[1]))));
            let largest = within.map(|two| two[1] - two[0]).fold(0.0, f64::max);
            let is_cut = findings.iter().any(|found| found.geometry.as_ref().is_some_and(|of| of.index == index));
            if largest > size * (1.0 + 1e-9) && !is_cut && !sizing.metal {
                return Err(format!("a cell of {largest} in body {index}, at most {size}"));
            }
        }
        let n_cells = list.iter().filter(|line| (low[axis]..=high[axis]).contains(*line)).count().saturating_sub(1);
        if let Some(k) = sizing.min_cells.filter(|k| has_both && n_cells < *k as usize) {
            return Err(format!("{n_cells} cells across body {index}, at least {k}"));
        }
    }
    Ok(())
}

#[test]
fn lines_keep_every_promise_for_random_boxes() {
    let [n_made, n_refused, n_thirds] = [const { std::cell::Cell::new(0) }; 3];
    let count = |of: &std::cell::Cell<u32>, more: u32| of.set(of.get() + more);
    let mut runner = prop::test_runner::TestRunner::new(ProptestConfig {
        cases: 600,
        failure_persistence: None,
        ..ProptestConfig::default()
    });
    runner
        .run(&scenes(), |scene| {
            let (domain, found) = made(&scene);
            match found {
                Ok((lines, findings)) => {
                    count(&n_made, 1);
                    for axis in 0..3 {
                        check(&scene, &domain, &lines.list(axis), axis, &findings)
                            .map_err(|problem| TestCaseError::fail(format!("axis {axis}: {problem}; {findings:?}")))?;
                    }
                    let has_metal = scene.bodies.iter().any(|body| body.1.metal);
                    count(&n_thirds, u32::from(has_metal));
                }
                Err(error) => {
                    count(&n_refused, 1);
                    prop_assert_eq!(error.code(), "lines-no-sizes");
                }
            }
            Ok(())
        })
        .unwrap();
    let [n_made, n_refused, n_thirds] = [n_made, n_refused, n_thirds].map(|of| of.get());
    println!("{n_made} made, {n_refused} refused, {n_thirds} with metal");
    assert!(n_made > 10 * n_refused && n_thirds > 100, "{n_made} made, {n_refused} refused, {n_thirds} with metal");
}

#[test]
fn the_checker_finds_what_is_wrong() {
    let body = |low: f64, high: f64| ([[low; 3], [high; 3]], Sizing::default());
    let job = set!(GradedJob { absorbing: Some(PerAxis::All(0)), ..GradedJob::new(PerAxis::All(1.0)) });
    let scene = Scene { job, bodies: vec![body(0.0, 4.0), body(1.0, 2.0)] };
    let (domain, ..) = made(&scene);
    let wrong = |list: &[f64]| check(&scene, &domain, list, 0, &[]).unwrap_err();
    assert!(check(&scene, &domain, &[0.0, 1.0, 2.0, 3.0, 4.0], 0, &[]).is_ok());
    assert!(wrong(&[0.0, 1.0, 2.0, 4.0]).contains("a cell of 2"));
    assert!(wrong(&[0.0, 1.0, 2.0, 2.4, 3.0, 4.0]).contains("neighbours"));
    assert!(wrong(&[0.0, 0.8, 1.6, 2.4, 3.2, 4.0]).contains("the end 1 of body 1 has no line"));
    assert!(wrong(&[0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0]).contains("domain"));
}

#[test]
fn a_thin_sheet_gets_its_cells_and_the_rest_grows() {
    let sheet = ([[0.0, 0.0, 5.0], [20.0, 20.0, 5.1]], set!(Sizing { min_cells: Some(4), ..Sizing::default() }));
    let air = ([[0.0; 3], [20.0, 20.0, 20.0]], Sizing::default());
    let job = set!(GradedJob { growth: Some(1.3), ..GradedJob::new(PerAxis::All(2.0)) });
    let (_, found) = made(&Scene { job, bodies: vec![air, sheet] });
    let (lines, findings) = found.unwrap();
    assert!(findings.is_empty() && lines.is_graded());
    assert_eq!([lines.dims()[0], lines.dims()[1]], [10, 10]);
    let z = lines.list(2);
    assert_eq!(z.iter().filter(|line| (5.0..=5.1).contains(*line)).count(), 5);
    // as good as geometric growth from 0.025 to 2: 16 cells a side and the rest of the largest size
    assert!(z.len() < 50, "{} cells along z", z.len() - 1);
}

#[test]
fn ends_that_nearly_meet_share_a_line_and_both_are_named() {
    let job = set!(GradedJob { min_size: Some(0.1), ..GradedJob::new(PerAxis::All(1.0)) });
    let three = set!(Sizing { min_cells: Some(3), ..Sizing::default() });
    let bodies = vec![([[0.0; 3], [4.0; 3]], Sizing::default()), ([[1.0; 3], [3.96, 3.0, 3.0]], three)];
    let (_, found) = made(&Scene { job, bodies });
    let (lines, findings) = found.unwrap();
    assert_eq!(findings.len(), 1);
    let text = &findings[0].sentence;
    for part in ["\"body 1\" at x = 3.96", "that of the domain at 4", "less than the smallest cell, 0.1"] {
        assert!(text.contains(part), "{part} is not in {text}");
    }
    // three cells lie within it, whichever line its end has
    let list = lines.list(0);
    let n_lines = list.iter().filter(|line| (1.0..=3.96).contains(*line)).count();
    assert!(n_lines > 3 && list.contains(&1.0) && list.contains(&4.0), "{list:?}");
}

#[test]
fn edges_of_metal_lie_a_third_inside() {
    let metal = ([[8.0, 8.0, 1.0], [12.0, 14.0, 1.1]], set!(Sizing { metal: true, ..Sizing::default() }));
    let board = ([[0.0; 3], [20.0, 22.0, 1.0]], Sizing::default());
    let job = set!(GradedJob { min_size: Some(0.01), ..GradedJob::new(PerAxis::All(1.0)) });
    let (_, found) = made(&Scene { job, bodies: vec![board, metal] });
    let (lines, findings) = found.unwrap();
    assert!(findings.is_empty(), "{findings:?}");
    for (axis, low, high) in [(0, 8.0, 12.0), (1, 8.0, 14.0)] {
        let list = lines.list(axis);
        for (edge, share) in [(low, 2.0 / 3.0), (high, 1.0 / 3.0)] {
            let after = list.partition_point(|line| *line < edge);
            let at = (edge - list[after - 1]) / (list[after] - list[after - 1]);
            assert!((at - share).abs() < 1e-9, "edge {edge} at {at} of its cell");
        }
    }
    // the sheet is thin along z: its faces are on lines
    assert!(lines.list(2).contains(&1.0) && lines.list(2).contains(&1.1));
}

#[test]
fn sizes_that_cannot_be_are_refused_with_the_place() {
    let body = |low: f64, high: f64| ([[low, 0.0, 0.0], [high, 4.0, 4.0]], Sizing::default());
    let job = set!(GradedJob { min_size: Some(1.0), growth: Some(1.2), ..GradedJob::new(PerAxis::All(2.0)) });
    let (_, found) = made(&Scene { job, bodies: vec![body(0.0, 1.0), body(1.0, 2.5), body(2.5, 3.5)] });
    let error = found.unwrap_err();
    assert_eq!(error.code(), "lines-no-sizes");
    assert!(error.to_string().contains("cells of at least 1 along x"), "{error}");
    assert!(error.to_string().contains("between the ends at 0 and 1"), "{error}");
}

#[test]
fn sizes_hold_where_ends_have_no_line_of_their_own() {
    let found = |most: f64, least: f64, ends: &[[f64; 2]], sizing: Sizing| {
        let job = set!(GradedJob { min_size: Some(least), ..GradedJob::new(PerAxis::All(most)) });
        let air = ([[0.0; 3], [20.0; 3]], Sizing::default());
        let of = |(index, &[low, high]): (usize, &[f64; 2])| {
            let sizing = if index == 0 { sizing } else { Sizing::default() };
            ([[low, 0.0, 0.0], [high, 20.0, 20.0]], sizing)
        };
        let bodies = std::iter::once(air).chain(ends.iter().enumerate().map(of)).collect();
        made(&Scene { job, bodies }).1.map(|(lines, _)| lines.list(0))
    };
    let largest = |list: &[f64], [low, high]: [f64; 2]| {
        let cells = list.windows(2).filter(|two| two[0] < high && two[1] > low);
        cells.map(|two| two[1] - two[0]).fold(0.0, f64::max)
    };
    let size = set!(Sizing { max_size: Some(2.62), ..Sizing::default() });
    // both ends on one line; one on that of another geometry; both within the cell before the end of the domain
    for ends in [&[[6.0, 7.0]][..], &[[6.0, 9.0], [2.0, 8.5]], &[[18.6, 19.5]]] {
        let list = found(6.63, 1.5166, ends, size).unwrap();
        assert!(largest(&list, ends[0]) <= 2.62 * (1.0 + 1e-9), "{ends:?}: {list:?}");
    }
    let cells = set!(Sizing { min_cells: Some(3), ..Sizing::default() });
    let list = found(6.0, 0.5, &[[6.0, 9.0], [2.0, 8.7]], cells).unwrap();
    let n_lines = list.iter().filter(|line| (6.0..=9.0).contains(*line)).count();
    assert!(n_lines > 3 && largest(&list, [6.0, 9.0]) <= 1.0 + 1e-9, "{list:?}");
    // thinner than the smallest cell
    let error = found(6.0, 0.5, &[[6.0, 6.4]], cells).unwrap_err();
    assert_eq!(error.code(), "lines-no-sizes");
    assert!(error.to_string().contains("\"body 1\" wants cells of at most 0.13"), "{error}");
    // a plane has no cells across it
    assert!(found(6.0, 0.5, &[[6.0, 6.0]], cells).is_ok());
}

#[test]
fn cells_that_would_be_too_small_at_a_line_are_made_alike() {
    // 3 cells of 1.528 fit where sizes that grow from 1.6 would begin below the smallest
    let job = set!(GradedJob { min_size: Some(1.5166), ..GradedJob::new(PerAxis::All(6.0)) });
    let size = set!(Sizing { max_size: Some(1.6), ..Sizing::default() });
    let bodies = vec![([[0.0; 3], [4.585; 3]], Sizing::default()), ([[0.0; 3], [1.0, 4.0, 4.0]], size)];
    let (lines, _) = made(&Scene { job, bodies }).1.unwrap();
    assert_eq!(lines.dims()[0], 3);
}
