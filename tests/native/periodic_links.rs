//! Links through periodic sides: those of the middle of a body that is repeated, in a mesh that holds its repetitions.

use hexcast::job::{Axis, GeometryJob, Job, LinesJob, LinksJob, Rule, Stencil};
use hexcast::links::Link;
use hexcast::pipeline::Engine;

use super::models::{self, Facets};
use super::open_surfaces::meshed;
use super::soups::Random;

/// Links by cell and direction, with q as bits, what they meet and the flag at the end.
type Found = Vec<([i64; 3], u8, u32, i32, i16, u8)>;

fn found(links: impl Iterator<Item = Link>, first: [i64; 3]) -> Found {
    let of = |link: Link| {
        let cell = [0, 1, 2].map(|axis| i64::from(link.cell[axis]) - first[axis]);
        (cell, link.direction, link.q.to_bits(), link.facet, link.geometry, link.flag)
    };
    links.map(of).collect()
}

fn lines(first: i64, end: i64) -> Vec<f64> {
    (first..=end).map(|line| line as f64).collect()
}

/// A body of coordinates that many boxes hold exactly, less than a box long along each axis.
fn body(random: &mut Random, n: [i64; 3]) -> Facets {
    let most = n.map(|n| n as u64 * 64 - 8);
    let corner = |random: &mut Random| [0, 1, 2].map(|axis| random.below(most[axis]) as f32 / 64.0 + 0.0625);
    match random.below(3) {
        0 => models::tetrahedron(std::array::from_fn(|_| corner(random))),
        1 => {
            let ends = [corner(random), corner(random)];
            let [low, high] = [f32::min, f32::max].map(|pick| [0, 1, 2].map(|axis| pick(ends[0][axis], ends[1][axis])));
            models::octahedron(low, high.map(|high| high + 0.015625))
        }
        _ => {
            let ends = [corner(random), corner(random)];
            let [low, high] = [f32::min, f32::max].map(|pick| [0, 1, 2].map(|axis| pick(ends[0][axis], ends[1][axis])));
            models::cuboid(low, high.map(|high| high + 0.015625))
        }
    }
}

/// A body, moved anywhere, and all repetitions of it along some axes that a mesh of three boxes and their neighbours may meet.
fn repeated(body: &Facets, n: [i64; 3], is_periodic: [bool; 3]) -> Facets {
    let steps = is_periodic.map(|is_periodic| if is_periodic { -3..=3 } else { 0..=0 });
    let mut all = Vec::new();
    for (i, j) in steps[0].clone().flat_map(|i| steps[1].clone().map(move |j| (i, j))) {
        for k in steps[2].clone() {
            let by = [i, j, k].map(|step: i64| step as f32);
            let moved = |corner: &[f32; 3]| [0, 1, 2].map(|axis| corner[axis] + by[axis] * n[axis] as f32);
            all.extend(body.iter().map(|facet| facet.each_ref().map(moved)));
        }
    }
    all
}

#[test]
fn links_through_periodic_sides_are_those_of_a_mesh_of_the_repeated_body() {
    let stencils = [Stencil::D3Q7, Stencil::D3Q15, Stencil::D3Q19, Stencil::D3Q27];
    let (mut n_links, mut n_through) = (0, 0);
    for seed in 0..96u64 {
        let mut random = Random::new(900 + seed);
        let is_periodic = [0, 1, 2].map(|axis| ((seed % 7 + 1) >> axis) & 1 == 1);
        // one layer, too
        let n = [[5, 4, 6], [4, 1, 5], [6, 5, 1], [1, 1, 4]][seed as usize % 4];
        let bodies: Vec<Facets> = (0..2).map(|_| repeated(&body(&mut random, n), n, is_periodic)).collect();
        let links = set!(LinksJob {
            stencil: stencils[seed as usize / 3 % 4],
            fluid: vec![[0, 1][seed as usize % 2]],
            ..LinksJob::default()
        });
        let geometries = vec![GeometryJob::default(); 2];
        let job = |first: [i64; 3], end: [i64; 3], periodic: Vec<Axis>| {
            let [x, y, z] = [0, 1, 2].map(|axis| lines(first[axis], end[axis]));
            let lines = Some(LinesJob { x, y, z });
            let rule = [Rule::Parity, Rule::Nonzero][seed as usize / 2 % 2];
            set!(Job {
                lines,
                rule,
                periodic,
                links: Some(links.clone()),
                geometries: geometries.clone(),
                ..Job::default()
            })
        };
        let axes = [Axis::X, Axis::Y, Axis::Z];
        let periodic: Vec<Axis> = (0..3).filter(|&axis| is_periodic[axis]).map(|axis| axes[axis]).collect();
        let mesh = |job: &Job| {
            let (_, facts) = meshed(&bodies, job, seed as usize % 3, &mut Engine::cpu()).unwrap();
            facts.links.expect("it was asked for")
        };
        let of_box = mesh(&job([0; 3], n, periodic));
        let around = |axis: usize| if is_periodic[axis] { n[axis] } else { 0 };
        let (first, end) = ([0, 1, 2].map(|axis| -around(axis)), [0, 1, 2].map(|axis| n[axis] + around(axis)));
        let of_all = mesh(&job(first, end, Vec::new()));
        let of_middle = found(of_all.iter().copied(), first.map(|first| -first)).into_iter();
        let mut of_middle: Found =
            of_middle.filter(|(cell, ..)| (0..3).all(|axis| (0..n[axis]).contains(&cell[axis]))).collect();
        let mut of_box = found(of_box.iter().copied(), [0; 3]);
        assert!(of_box.is_sorted_by_key(|&([x, y, z], direction, ..)| (z, y, x, direction)), "seed {seed}");
        n_links += of_box.len();
        let directions = links.stencil.directions();
        let leads_out = |&(cell, direction, ..): &([i64; 3], u8, u32, i32, i16, u8)| {
            (0..3)
                .any(|axis| !(0..n[axis]).contains(&(cell[axis] + i64::from(directions[usize::from(direction)][axis]))))
        };
        n_through += of_box.iter().filter(|link| leads_out(link)).count();
        // what lies beyond a side is another repetition of the same facet there
        for found in [&mut of_middle, &mut of_box] {
            found
                .iter_mut()
                .filter(|link| leads_out(link))
                .for_each(|link| link.3 %= bodies[link.4.max(0) as usize].len() as i32);
            found.iter_mut().for_each(|link| link.3 = link.3.min(0));
        }
        assert_eq!(of_box, of_middle, "seed {seed}, {is_periodic:?}");
    }
    assert!(n_links > 3000 && n_through > 700, "{n_links} links, {n_through} through sides");
}

#[test]
fn a_pipe_of_one_layer_has_all_its_links() {
    // a cylinder of fluid through a block of metal; its ends lie on the sides, or beyond, or there are many layers
    let turn = |at: usize| (at as f32 * std::f32::consts::TAU / 32.0).sin_cos();
    let pipe = |low: f32, high: f32| -> Facets {
        let corner = |at: usize, z: f32| [6.5 + 4.3 * turn(at % 32).1, 6.5 + 4.3 * turn(at % 32).0, z];
        (0..32)
            .flat_map(|at| {
                let [a, b, c, d] = [corner(at, low), corner(at + 1, low), corner(at + 1, high), corner(at, high)];
                [[a, b, c], [a, c, d], [[6.5, 6.5, low], b, a], [[6.5, 6.5, high], d, c]]
            })
            .collect()
    };
    let n = |body: Facets, layers: i64, periodic: Vec<Axis>| {
        let links = Some(set!(LinksJob { fluid: vec![1], ..LinksJob::default() }));
        let lines = Some(LinesJob { x: lines(0, 13), y: lines(0, 13), z: lines(0, layers) });
        let job = set!(Job { geometries: vec![GeometryJob::default()], links, lines, periodic, ..Job::default() });
        let (_, facts) = meshed(&[body], &job, 2, &mut Engine::cpu()).unwrap();
        let links = facts.links.expect("it was asked for");
        links.iter().filter(|link| i64::from(link.cell[2]) == layers / 2).count()
    };
    let expected = n(pipe(-1.0, 6.0), 5, Vec::new());
    let without = n(pipe(0.0, 1.0), 1, Vec::new());
    assert!(without < expected && expected > 150, "{without} of {expected}");
    for (low, high) in [(0.0, 1.0), (-1.0, 2.0), (-0.25, 1.0)] {
        assert_eq!(n(pipe(low, high), 1, vec![Axis::Z]), expected, "from {low} to {high}");
    }
}

#[test]
fn periodic_sides_without_links_or_of_a_window_are_refused() {
    let periodic = vec![Axis::X];
    let geometries = vec![GeometryJob::new("a.stl")];
    let job = set!(Job { geometries, periodic, ..Job::default() });
    assert_eq!(job.validate().unwrap_err().code(), "job-conflict");
    let job = set!(Job { links: Some(LinksJob::default()), ..job });
    assert!(job.validate().is_ok());
    assert_eq!(set!(Job { window: Some([0, 0, 0, 1, 1, 1]), ..job }).validate().unwrap_err().code(), "job-conflict");
}
