//! Shells that have no cell, or another volume than their surface, against counts of centres along each axis: of boxes, whose cells are the product
//! of these; and of other bodies against winding numbers at every centre in big integers.

use hexcast::geometry::{Facet, Geometry};
use hexcast::job::{Fill, GeometryJob, Job, LinesJob, PartJob, Rule};
use hexcast::lines::Lines;
use hexcast::pipeline::Engine;
use hexcast::report::{MeshFacts, ShellReport};

use super::models::{self, Facets};
use super::open_surfaces::meshed;
use super::oracle;
use super::soups::{BODIES, Random, body};

/// A box, and whether it is turned inwards.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Shell {
    ends: [[f32; 3]; 2],
    is_cavity: bool,
}

/// What a shell has in cells: their number and volume, with its sign, and its own volume; and along which axes its ends hold centres.
#[derive(Debug)]
struct Known {
    cells: i64,
    volume: f64,
    mesh_volume: f64,
    holds: [bool; 3],
}

impl Shell {
    fn facets(&self) -> Facets {
        let facets = models::cuboid(self.ends[0], self.ends[1]);
        if self.is_cavity { models::flipped(facets) } else { facets }
    }

    /// Lengths along an axis of the cells whose centres lie within.
    fn sizes(&self, lines: &[f64], axis: usize) -> Vec<f64> {
        let [low, high] = self.ends.map(|end| f64::from(end[axis]));
        // a centre on an end stands for a place a little below
        let within = |two: &&[f64]| {
            let centre = 0.5 * (two[0] + two[1]);
            low < centre && centre <= high
        };
        lines.windows(2).filter(within).map(|two| two[1] - two[0]).collect()
    }

    fn known(&self, lines: &[Vec<f64>; 3]) -> Known {
        let sizes = [0, 1, 2].map(|axis| self.sizes(&lines[axis], axis));
        let sign = if self.is_cavity { -1 } else { 1 };
        let extent = |axis: usize| f64::from(self.ends[1][axis]) - f64::from(self.ends[0][axis]);
        Known {
            cells: sign * sizes.iter().map(|of| of.len() as i64).product::<i64>(),
            volume: sign as f64 * sizes.iter().map(|of| of.iter().sum::<f64>()).product::<f64>(),
            mesh_volume: sign as f64 * extent(0) * extent(1) * extent(2),
            holds: sizes.map(|of| !of.is_empty()),
        }
    }

    fn is_where(&self, lines: &[Vec<f64>; 3], is: impl Fn([f64; 2], &[f64]) -> bool) -> [bool; 3] {
        [0, 1, 2].map(|axis| is(self.ends.map(|end| f64::from(end[axis])), &lines[axis]))
    }

    fn meets(&self, lines: &[Vec<f64>; 3]) -> bool {
        self.is_where(lines, |[low, high], of| low < of[of.len() - 1] && high > of[0]) == [true; 3]
    }

    /// Whether it holds centres that cells beyond the box would have, as large as those at its ends.
    fn is_cut(&self, lines: &[Vec<f64>; 3]) -> bool {
        let is_cut = |[low, high]: [f64; 2], of: &[f64]| {
            let n = of.len();
            low < of[0] - 0.5 * (of[1] - of[0]) || high > of[n - 1] + 0.5 * (of[n - 1] - of[n - 2])
        };
        self.is_where(lines, is_cut).contains(&true)
    }

    /// Whether lines through centres cross it within the box.
    fn is_crossed(&self, lines: &[Vec<f64>; 3]) -> bool {
        let holds = self.known(lines).holds;
        let has_end = self.is_where(lines, |ends, of| ends.iter().any(|end| (of[0]..of[of.len() - 1]).contains(end)));
        (0..3).any(|axis| has_end[axis] && holds[(axis + 1) % 3] && holds[(axis + 2) % 3])
    }
}

fn is_off(volume: f64, mesh_volume: f64) -> bool {
    (volume - mesh_volume).abs() > 0.05 * mesh_volume.abs()
}

/// Lines of an axis from 0, equal or not, no centre of which is a multiple of 1/64.
fn lines(random: &mut Random, is_graded: bool) -> Vec<f64> {
    let n = random.one_of(&[3, 6, 11, 40]);
    let size = |random: &mut Random| f64::from(random.between(20, 70)) / 64.0 + 1.0 / 512.0;
    let equal = size(random);
    let mut at = 0.0;
    let mut all = vec![0.0];
    for index in 0..n {
        at = if is_graded { at + size(random) } else { f64::from(index + 1) * equal };
        all.push(at);
    }
    all
}

fn shell(random: &mut Random, lines: &[Vec<f64>; 3]) -> Shell {
    let kind = random.below(8);
    let mut ends = [[0.0; 3]; 2];
    for axis in 0..3 {
        let length = (64.0 * lines[axis][lines[axis].len() - 1]) as i32;
        // plates, needles, crumbs
        let is_thin = kind >> axis & 1 == 1;
        let low = random.between(-length / 8, length);
        let high = low + if is_thin { random.between(1, 40) } else { random.between(8, length.max(9)) };
        // off the multiples of 1/64, where ends of others and centres may be
        let off = random.between(1, 7) as f32 / 4096.0;
        (ends[0][axis], ends[1][axis]) = (low as f32 / 64.0 + off, high as f32 / 64.0 + off);
    }
    Shell { ends, is_cavity: random.below(6) == 0 }
}

struct Sample {
    lines: [Vec<f64>; 3],
    /// The lines of the cells whose shells are looked at.
    near: [Vec<f64>; 3],
    job: Job,
    parts: Vec<Vec<Shell>>,
    facets: Vec<Facets>,
    axis: usize,
}

fn sample(seed: u64) -> Sample {
    let mut random = Random::new(seed);
    let is_graded = random.below(2) == 0;
    let lines = [0, 1, 2].map(|_| lines(&mut random, is_graded));
    let fills = [Fill::Centre, Fill::Centre, Fill::Centre, Fill::Separating];
    let n_parts = 1 + random.below(3);
    let (mut parts, mut facets, mut geometries) = (Vec::new(), Vec::new(), Vec::new());
    for _ in 0..n_parts {
        let n = random.one_of(&[1, 1, 2, 5, 12]);
        let mut shells: Vec<Shell> = (0..n).map(|_| shell(&mut random, &lines)).collect();
        let mut all: Vec<(Facet, usize)> = shells
            .iter()
            .enumerate()
            .flat_map(|(of, shell)| shell.facets().into_iter().map(move |f| (f, of)))
            .collect();
        if random.below(2) == 0 {
            random.shuffle(&mut all);
            // numbers follow the first facets
            let mut order: Vec<usize> = Vec::new();
            all.iter().for_each(|(_, of)| {
                if !order.contains(of) {
                    order.push(*of)
                }
            });
            shells = order.into_iter().map(|of| shells[of]).collect();
        }
        facets.push(all.into_iter().map(|(facet, _)| facet).collect());
        parts.push(shells);
        geometries.push(set!(GeometryJob { fill: Some(random.one_of(&fills)), ..GeometryJob::default() }));
    }
    let rule = random.one_of(&[Rule::Parity, Rule::Nonzero]);
    let [x, y, z] = lines.clone();
    let mut job = set!(Job { geometries, rule, lines: Some(LinesJob { x, y, z }), ..Job::default() });
    let mut near = lines.clone();
    match random.below(5) {
        0 => {
            let ends = [0, 1, 2].map(|axis: usize| {
                let n = lines[axis].len() as u64 - 1;
                let first = random.below(n);
                let end = first + 1 + random.below(n - first);
                near[axis] = lines[axis][first as usize..=end as usize].to_vec();
                [first, end].map(|line| line as u32)
            });
            job.window = Some([0, 1, 2, 3, 4, 5].map(|at| ends[at % 3][at / 3]));
        }
        // a part says of all shells what the whole says
        1 => job.part = Some(PartJob::new(1 + random.below(4) as u32, [2, 1, 2])),
        _ => {}
    }
    Sample { lines, near, job, parts, facets, axis: random.below(3) as usize }
}

/// What is listed of a geometry: number, box, number of cells and whether it has none, in the order of numbers.
type Listed = Vec<(u64, [[f64; 3]; 2], i64, bool)>;

fn listed(of: &[ShellReport]) -> Listed {
    let mut all: Listed = of.iter().map(|of| (of.shell, of.bounding_box, of.cells, of.is_lost)).collect();
    all.sort_by_key(|of| of.0);
    all
}

/// Compares the checks of all shells of a sample with what is known; returns numbers of shells without cells, and of those that are off.
fn compared(seed: u64) -> [usize; 2] {
    let Sample { lines, near, job, parts, facets, axis } = sample(seed);
    let (_, facts) =
        meshed(&facets, &job, axis, &mut Engine::cpu()).unwrap_or_else(|error| panic!("seed {seed}: {error}"));
    let mut n = [0; 2];
    for (index, shells) in parts.iter().enumerate() {
        let is_filled = job.geometries[index].fill == Some(Fill::Separating);
        let mut expected = Listed::new();
        for (number, shell) in (0u64..).zip(shells).filter(|(_, shell)| shell.meets(&near)) {
            let known = shell.known(&lines);
            let is_lost = known.cells == 0 && !(is_filled && shell.is_crossed(&lines));
            let is_off = !is_filled && !shell.is_cut(&lines) && is_off(known.volume, known.mesh_volume);
            if is_lost || is_off {
                expected.push((number, shell.ends.map(|end| end.map(f64::from)), known.cells, is_lost));
                n[usize::from(!is_lost)] += 1;
            }
        }
        let report = &facts.geometries[index];
        let check = report.shells.as_ref().expect("a check");
        assert_eq!(listed(&check.listed), expected, "seed {seed}, geometry {index}");
        let n_lost = expected.iter().filter(|of| of.3).count() as u64;
        assert_eq!((check.without_cells, check.off), (n_lost, expected.len() as u64 - n_lost), "seed {seed}");
        assert_eq!(check.shells, shells.len() as u64, "seed {seed}");
        for (number, known) in check.listed.iter().map(|of| (of, shells[of.shell as usize].known(&lines))) {
            assert!((number.volume - known.volume).abs() <= 1e-9 * known.volume.abs(), "seed {seed}: {known:?}");
            assert!((number.mesh_volume - known.mesh_volume).abs() <= 1e-9 * known.mesh_volume.abs(), "{known:?}");
        }
        let sum = |of: fn(&Known) -> f64| shells.iter().map(|shell| of(&shell.known(&lines))).sum::<f64>();
        let (volume, surface) = (sum(|known| known.volume).abs(), sum(|known| known.mesh_volume).abs());
        let is_whole = shells.iter().all(|shell| shell.meets(&near) && !shell.is_cut(&lines));
        let all_off = is_whole && !is_filled && is_off(volume, surface);
        if let Some(found) = check.volume {
            assert!(
                is_whole && !is_filled && (found - volume).abs() <= 1e-9 * surface,
                "seed {seed}: {found} {volume}"
            );
        } else {
            assert!(!all_off, "seed {seed}, geometry {index}: {volume} and {surface}");
        }
        assert_findings(&facts, index, [n_lost > 0, check.off > 0 || all_off && n_lost < check.shells], seed);
    }
    n
}

/// There is a finding about shells without cells, and about volumes, where there should be one.
#[track_caller]
fn assert_findings(facts: &MeshFacts, index: usize, expected: [bool; 2], seed: u64) {
    let of = |code: &str| {
        let of_geometry = facts.findings.iter().filter(|of| of.geometry.as_ref().is_some_and(|of| of.index == index));
        of_geometry.filter(|of| of.code.starts_with(code)).count()
    };
    let has_none = of("no-cell") > 0;
    // a window does not say that a geometry has no cell at all
    let found = [of("shell-lost") == 1, of("volume-off") == 1];
    assert_eq!(found, [expected[0] && !has_none, expected[1]], "seed {seed}, geometry {index}: {:?}", facts.warnings);
}

/// Jobs of the sweep: more where a variable says so.
fn n_jobs() -> u64 {
    std::env::var("HEXCAST_SWEEP_JOBS").ok().and_then(|n| n.parse().ok()).unwrap_or(120)
}

#[test]
fn shells_of_boxes_have_the_cells_that_their_ends_say() {
    let mut n = [0; 2];
    for seed in 0..n_jobs() {
        let more = compared(seed);
        n = [0, 1].map(|kind| n[kind] + more[kind]);
    }
    println!("seeds 0 to {}: {} shells without cells, {} off", n_jobs() - 1, n[0], n[1]);
    assert!(n.iter().all(|n| *n as u64 > n_jobs() / 4), "{n:?}");
}

/// Shells that are none of the boxes, of one geometry.
fn bodies(random: &mut Random) -> Vec<Facets> {
    let point = |random: &mut Random| [0, 1, 2].map(|_: usize| random.between(-16, 7 * 16) as f32 / 16.0 + 0.013);
    let n = 1 + random.below(4);
    (0..n)
        .map(|_| {
            let first = point(random);
            let near = |random: &mut Random| first.map(|c| c + random.between(1, 40) as f32 / 16.0);
            let points = [first, near(random), near(random), near(random)];
            models::outwards(body(random.one_of(&BODIES), points))
        })
        .collect()
}

#[test]
fn shells_of_any_bodies_have_the_winding_numbers_of_the_oracle() {
    let mut n = [0; 2];
    for seed in 0..n_jobs() / 4 {
        let mut random = Random::new(9000 + seed);
        let shells = bodies(&mut random);
        let all: Facets = shells.concat();
        if hexcast::surface::surface(&all).shells != shells.len() as u64 {
            continue;
        }
        let dims = [0, 1, 2].map(|_: usize| 3 + random.below(5) as u32);
        let rule = random.one_of(&[Rule::Parity, Rule::Nonzero]);
        let lines = Lines::new([0.0; 3], dims.map(|n| 7.0 / f64::from(n)), dims).expect("lines");
        let domain = Some([0.0, 0.0, 0.0, 7.0, 7.0, 7.0]);
        let job = set!(Job { domain, dims: Some(dims), rule, ..Job::default() });
        let (_, facts) =
            meshed(std::slice::from_ref(&all), &job, seed as usize % 3, &mut Engine::cpu()).expect("a mesh");
        let geometries: Vec<Geometry> =
            shells.iter().map(|facets| Geometry::new("shell", 1, facets.clone()).expect("facets")).collect();
        let windings = oracle::insides(&geometries, &lines, Rule::Nonzero);
        let insides = oracle::insides(&geometries, &lines, rule);
        let check = facts.geometries[0].shells.as_ref().expect("a check");
        for (number, shell) in geometries.iter().enumerate() {
            let [low, high] = shell.bounding_box().expect("facets");
            let meets = (0..3).all(|axis| low[axis] < 7.0 && high[axis] > 0.0);
            let is_lost = meets && insides[number].iter().all(|inside| *inside == 0);
            let found = check.listed.iter().find(|of| of.shell == number as u64);
            assert_eq!(found.is_some_and(|of| of.is_lost), is_lost, "seed {seed}, shell {number}: {check:?}");
            n[0] += usize::from(is_lost);
            let Some(found) = found else { continue };
            let winding: i64 = windings[number].iter().map(|winding| i64::from(*winding)).sum();
            assert_eq!(found.cells, winding, "seed {seed}, shell {number}");
            n[1] += 1;
        }
    }
    assert!(n[0] > 3 && n[1] > n[0], "{n:?}");
}

#[test]
fn a_shell_without_volume_has_no_cell_and_is_counted() {
    let [a, b, c, d] = [[3.0, 1.0, 1.0], [3.0, 4.0, 1.0], [3.0, 4.0, 4.0], [3.0, 1.0, 4.0]];
    let flat: Facets = vec![[a, b, c], [a, c, d], [a, c, b], [a, d, c]];
    let domain = Some([0.0, 0.0, 0.0, 7.0, 7.0, 7.0]);
    let job = set!(Job { domain, dims: Some([7; 3]), ..Job::default() });
    let (_, facts) = meshed(&[flat], &job, 0, &mut Engine::cpu()).expect("a mesh");
    let check = facts.geometries[0].shells.as_ref().expect("a check");
    assert_eq!((check.shells, check.without_cells, check.listed.len()), (1, 1, 1), "{check:?}");
}
