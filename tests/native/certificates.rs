//! Thin walls and overlaps, against what is known of simple bodies and against the meshes of each geometry alone.

use hexcast::geometry::Facet;
use hexcast::job::{GeometryJob, Job, Rule};
use hexcast::pipeline::Engine;
use hexcast::report::CertificateReport;

use super::models::{self, Facets};
use super::open_surfaces::{flags_of, meshed};
use super::soups::Random;

fn job(dims: [u32; 3], rule: Rule) -> Job {
    let domain = Some([0.0, 0.0, 0.0, 8.0, 8.0, 8.0]);
    set!(Job { dims: Some(dims), domain, rule, certify: true, ..Job::default() })
}

fn certificate(parts: &[Facets], job: &Job, axis: usize) -> (CertificateReport, Vec<String>) {
    let (_, report) = meshed(parts, job, axis, &mut Engine::cpu()).expect("a mesh");
    (report.certificate.expect("it was asked for"), report.warnings)
}

/// (axis, rays, lost, cells) of the thin walls of one body.
fn walls(facets: &Facets, dims: [u32; 3], thin_cells: Option<u32>) -> Vec<(&'static str, u64, u64, u32)> {
    let mut all = Vec::new();
    for (axis, rule) in [(0, Rule::Parity), (1, Rule::Nonzero), (2, Rule::Parity)] {
        let job = set!(Job { thin_cells, ..job(dims, rule) });
        let (found, _) = certificate(std::slice::from_ref(facets), &job, axis);
        all.push(found.thin_walls.iter().map(|wall| (wall.axis, wall.rays, wall.lost, wall.cells)).collect::<Vec<_>>());
    }
    assert!(all[0] == all[1] && all[1] == all[2], "neither the rule nor the axis of the rays matters: {all:?}");
    all.remove(0)
}

#[test]
fn walls_are_thin_where_few_centres_lie_across_them() {
    let plate = |low: f32, high: f32| models::cuboid([1.0, 1.0, low], [7.0, 7.0, high]);
    // 6 x 6 rays along z pass it
    assert_eq!(walls(&plate(3.1, 3.3), [8; 3], None), [("z", 36, 36, 0)]);
    assert_eq!(walls(&plate(3.1, 3.9), [8; 3], None), [("z", 36, 0, 1)]);
    assert_eq!(walls(&plate(3.1, 4.9), [8; 3], None), []);
    assert_eq!(walls(&plate(3.1, 4.9), [8; 3], Some(3)), [("z", 36, 0, 2)]);
    // at both ends of the domain, and beyond
    assert_eq!(walls(&plate(0.0, 0.9), [8; 3], None), [("z", 36, 0, 1)]);
    assert_eq!(walls(&plate(7.2, 8.0), [8; 3], None), [("z", 36, 0, 1)]);
    assert_eq!(walls(&plate(-3.0, 0.9), [8; 3], None), []);
    assert_eq!(walls(&plate(7.2, 12.0), [8; 3], None), []);
    // a ball has no walls, though rays at its silhouette are short
    assert_eq!(walls(&models::sphere([4.0; 3], 3.3, 24), [24; 3], None), []);
    // a casing has two along each axis
    let casing =
        models::joined([models::cuboid([1.0; 3], [7.0; 3]), models::flipped(models::cuboid([1.4; 3], [6.6; 3]))]);
    let found = walls(&casing, [8; 3], None);
    assert_eq!(found.iter().map(|wall| (wall.0, wall.3)).collect::<Vec<_>>(), [("x", 0), ("y", 0), ("z", 0)]);
    // of 8 x 8 rays 4 x 4 pass the inside, through two walls each
    assert!(found.iter().all(|wall| wall.1 >= 2 * 16 && wall.2 == wall.1), "{found:?}");
}

#[test]
fn a_slanted_wall_is_found_along_the_axis_nearest_to_its_normal_with_a_place_in_it() {
    // a plate in the plane z = x / 2 + 2, 0.4 thick along z
    let at = |x: f32, y: f32, up: f32| [x, y, 0.5 * x + 2.0 + up];
    let [a, b, c, d] = [at(1.0, 1.0, 0.0), at(7.0, 1.0, 0.0), at(7.0, 7.0, 0.0), at(1.0, 7.0, 0.0)];
    let plate = models::joined([models::wedge([a, b, c], [0.0, 0.0, 0.4]), models::wedge([a, c, d], [0.0, 0.0, 0.4])]);
    let (found, warnings) = certificate(&[plate], &job([16; 3], Rule::Nonzero), 0);
    let [wall] = &found.thin_walls[..] else { panic!("{found:?}") };
    assert_eq!((wall.axis, wall.rays), ("z", 144));
    let [x, y, z] = wall.place;
    assert!((1.0..7.0).contains(&x) && (1.0..7.0).contains(&y), "{wall:?}");
    assert!((z - (0.5 * x + 2.2)).abs() < 0.5, "{wall:?}");
    assert!(
        warnings.iter().any(|warning| warning.contains("has walls of fewer than 2 cells along z: 144")),
        "{warnings:?}"
    );
}

/// (flags, axis, number of cells, centre of the first, box) of background cells between two flags, cell by cell.
type Gaps = Vec<([u8; 2], &'static str, u64, [f64; 3], [[f64; 3]; 2])>;

fn gaps_of(flags: &[u8], [nx, ny, nz]: [u32; 3]) -> Gaps {
    let at = |[x, y, z]: [u32; 3]| flags[(x + nx * (y + ny * z)) as usize];
    let mut found = Gaps::new();
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        for index in 0..nx * ny * nz {
            let cell = [index % nx, index / nx % ny, index / (nx * ny)];
            if at(cell) != 0 || cell[axis] == 0 || cell[axis] + 1 == [nx, ny, nz][axis] {
                continue;
            }
            let beside = |by: i32| {
                let mut other = cell;
                other[axis] = other[axis].wrapping_add_signed(by);
                at(other)
            };
            let pair = [beside(-1).min(beside(1)), beside(-1).max(beside(1))];
            if pair[0] == 0 || pair[0] == pair[1] {
                continue;
            }
            let (low, high) = (cell.map(f64::from), cell.map(|c| f64::from(c) + 1.0));
            match found.iter_mut().find(|gap| (gap.0, gap.1) == (pair, name)) {
                Some((_, _, n, _, [lows, highs])) => {
                    *n += 1;
                    for axis in 0..3 {
                        lows[axis] = lows[axis].min(low[axis]);
                        highs[axis] = highs[axis].max(high[axis]);
                    }
                }
                None => found.push((pair, name, 1, cell.map(|c| f64::from(c) + 0.5), [low, high])),
            }
        }
    }
    found.sort_by_key(|gap| (gap.0, gap.1));
    found
}

#[test]
fn gaps_of_one_cell_between_flags_are_those_of_every_cell_along_every_axis() {
    let mut random = Random::new(8);
    let mut axes = std::collections::BTreeMap::new();
    for round in 0..250 {
        let dims = [0; 3].map(|_: i32| random.between(1, 9) as u32);
        let mut place = |n: u32| random.below(2 * u64::from(n) + 1) as f32 / 2.0;
        let bodies: Vec<Vec<Facet>> = (0..6)
            .map(|_| {
                let (one, other) = (dims.map(&mut place), dims.map(&mut place));
                let corner = |pick: fn(f32, f32) -> f32| [0, 1, 2].map(|axis: usize| pick(one[axis], other[axis]));
                models::cuboid(corner(f32::min), corner(f32::max))
            })
            .collect();
        let geometries =
            (0..6).map(|_| set!(GeometryJob { flag: Some(1 + random.below(4) as u8), ..GeometryJob::default() }));
        let domain = Some([0.0, 0.0, 0.0, f64::from(dims[0]), f64::from(dims[1]), f64::from(dims[2])]);
        let job = set!(Job { geometries: geometries.collect(), domain, ..job(dims, Rule::Parity) });
        for axis in 0..3 {
            let (mesh, report) = meshed(&bodies, &job, axis, &mut Engine::cpu()).expect("a mesh");
            let gaps = report.certificate.expect("it was asked for").gaps;
            let found: Gaps = gaps.iter().map(|gap| (gap.flags, gap.axis, gap.cells, gap.place, gap.bounds)).collect();
            assert_eq!(found, gaps_of(&flags_of(&mesh), dims), "round {round}, rays along {axis}");
            for gap in gaps {
                *axes.entry(gap.axis).or_insert(0) += 1;
                let sentence = report.warnings.iter().find(|text| {
                    text.starts_with(&format!("{} single background cells lie between", gap.cells))
                        && text.contains(&format!("(flag {}) along {}", gap.flags[1], gap.axis))
                });
                assert!(sentence.is_some_and(|text| text.contains(&gap.names[0])), "{gap:?}: {:?}", report.warnings);
            }
        }
    }
    assert!(axes.len() == 3 && axes.values().all(|n| *n > 10), "{axes:?}");
}

#[test]
fn overlaps_are_the_cells_that_each_geometry_has_alone() {
    let mut random = Random::new(3);
    for round in 0..12 {
        let mut place = |scale: u64| random.below(scale * 8) as f32 / 8.0;
        let bodies: Vec<Vec<Facet>> = (0..4)
            .map(|kind| match (kind + round) % 3 {
                0 => models::cuboid([place(4), place(4), place(4)], [4.0 + place(4), 4.0 + place(4), 4.5 + place(3)]),
                1 => models::sphere([2.0 + place(4), 2.0 + place(4), 2.0 + place(4)], 2.3, 8),
                _ => models::octahedron([place(3), place(3), place(3)], [5.0 + place(3), 5.5, 5.0 + place(3)]),
            })
            .collect();
        let priorities = [1, 0, 0, -1];
        let geometries = priorities.map(|priority| set!(GeometryJob { priority, ..GeometryJob::default() })).to_vec();
        let rule = [Rule::Parity, Rule::Nonzero][round % 2];
        let job = set!(Job { geometries, ..job([9, 8, 10], rule) });
        let (found, _) = certificate(&bodies, &job, round % 3);
        let alone: Vec<Vec<u8>> = bodies
            .iter()
            .map(|body| {
                let job = set!(Job { geometries: vec![], certify: false, ..job.clone() });
                flags_of(&meshed(std::slice::from_ref(body), &job, 0, &mut Engine::cpu()).expect("a mesh").0)
            })
            .collect();
        let mut expected = Vec::new();
        for (winner, loser) in [(1, 3), (2, 3), (0, 3), (2, 1), (0, 1), (0, 2)] {
            let cells = alone[winner].iter().zip(&alone[loser]).filter(|(a, b)| **a != 0 && **b != 0).count() as u64;
            if cells > 0 {
                expected.push((winner.to_string(), loser.to_string(), cells));
            }
        }
        for overlap in &found.overlaps {
            let [winner, loser] =
                [&overlap.winner, &overlap.loser].map(|name| name.parse::<usize>().expect("a number"));
            let [x, y, z] = [9.0, 8.0, 10.0].map(|n| n / 8.0);
            let [x, y, z] = [x * overlap.place[0], y * overlap.place[1], z * overlap.place[2]].map(|at| at as usize);
            let at = x + 9 * (y + 8 * z);
            assert!(alone[winner][at] != 0 && alone[loser][at] != 0, "round {round}: {overlap:?}");
        }
        let mut found: Vec<_> =
            found.overlaps.into_iter().map(|overlap| (overlap.winner, overlap.loser, overlap.cells)).collect();
        found.sort();
        expected.sort();
        assert_eq!(found, expected, "round {round}");
    }
}
