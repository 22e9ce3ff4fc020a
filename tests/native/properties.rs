//! The laws of the definition, each on random bodies: what must not change the result, and what must change it just so.
//!
//! Bodies stand on quarters of a cell, so that moving and joining them is exact and ties are everywhere; where a law holds
//! for any numbers it is tried on soups in general position too. A failure prints the bodies, or the seed in the name.

use hexcast::geometry::Geometry;
use hexcast::lines::Lines;
use hexcast_core::stages::map::Rule;
use proptest::prelude::*;

use super::backends::{Backend, cpu_flags, flags, mesh};
use super::cases::{Case, lines, several, unit_cells};
use super::compare::difference;
use super::models::{self, Facets};
use super::soups::{self, BODIES, Random, soup};

const DIMS: [u32; 3] = [6, 5, 7];

/// A body of four points on quarters of a cell, up to two cells out of the domain.
fn bodies(count: std::ops::Range<usize>) -> impl Strategy<Value = Vec<Facets>> {
    let quarter = (-8i32..36).prop_map(|quarters| quarters as f32 * 0.25);
    let points = prop::array::uniform4(prop::array::uniform3(quarter));
    let body = (0..BODIES.len(), points).prop_map(|(kind, points)| soups::body(BODIES[kind], points));
    prop::collection::vec(body, count)
}

fn rules() -> impl Strategy<Value = Rule> {
    prop_oneof![Just(Rule::Parity), Just(Rule::Nonzero)]
}

fn soups_of_any_seed() -> impl Strategy<Value = Case> {
    any::<u64>().prop_map(soup)
}

/// One geometry with flag 1.
fn file(facets: Facets, rule: Rule) -> Case {
    files(vec![facets], rule)
}

/// Several geometries with flag 1.
fn files(files: Vec<Facets>, rule: Rule) -> Case {
    let geometries = files.into_iter().map(|facets| Geometry::new("body", 1, facets).unwrap()).collect();
    Case { rule, ..several("bodies", "a law", unit_cells(DIMS), geometries) }
}

/// Fails the law if the flags differ.
fn same(expected: &[u8], actual: &[u8], dims: [u32; 3], law: &str) -> Result<(), TestCaseError> {
    match difference(expected, actual, dims) {
        Some(difference) => Err(TestCaseError::fail(format!("{law}: {difference}"))),
        None => Ok(()),
    }
}

/// Fails the law if two cases over the same cells differ, with z rays.
fn same_cases(expected: &Case, actual: &Case, law: &str) -> Result<(), TestCaseError> {
    same(&cpu_flags(expected, 2), &cpu_flags(actual, 2), expected.lines.dims(), law)
}

/// Applies a function to every corner of a case.
fn with_corners(case: &Case, place: impl Fn(models::Point) -> models::Point) -> Case {
    let mut placed = case.clone();
    for geometry in &mut placed.geometries {
        geometry.facets = models::mapped(geometry.facets.slice(), &place).into();
    }
    placed
}

fn with_lines(case: &Case, lines: Lines) -> Case {
    Case { lines, ..case.clone() }
}

fn config() -> ProptestConfig {
    // failures are pinned as cases, by seed, not in files beside the tests
    ProptestConfig { cases: 96, failure_persistence: None, ..ProptestConfig::default() }
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn the_order_of_facets_and_corners_changes_nothing(case in soups_of_any_seed(), seed in any::<u64>()) {
        let mut random = Random::new(seed);
        let mut shuffled = case.clone();
        for geometry in &mut shuffled.geometries {
            geometry.facets = soups::shuffled(geometry.facets.slice().to_vec(), &mut random).into();
        }
        same_cases(&case, &shuffled, "shuffled")?;
    }

    #[test]
    fn turning_facets_changes_nothing_for_parity(case in soups_of_any_seed(), seed in any::<u64>()) {
        let mut random = Random::new(seed);
        let case = Case { rule: Rule::Parity, ..case };
        let mut turned = case.clone();
        for geometry in &mut turned.geometries {
            let mut facets = geometry.facets.slice().to_vec();
            for facet in &mut facets {
                if random.below(2) == 0 {
                    facet.swap(1, 2);
                }
            }
            geometry.facets = facets.into();
        }
        same_cases(&case, &turned, "turned")?;
    }

    #[test]
    fn turning_whole_geometries_changes_nothing(case in soups_of_any_seed()) {
        let mut turned = case.clone();
        for geometry in &mut turned.geometries {
            geometry.facets = models::flipped(geometry.facets.slice().to_vec()).into();
        }
        same_cases(&case, &turned, "inside out")?;
    }

    #[test]
    fn the_ray_axis_changes_nothing_and_rays_are_even(case in soups_of_any_seed()) {
        let along = [0, 1, 2].map(|axis| mesh(Backend::Cpu, &case, axis));
        for axis in 0..3 {
            prop_assert_eq!(along[axis].odd_rays(), 0, "axis {}", axis);
            same(&flags(&along[0]), &flags(&along[axis]), case.lines.dims(), &format!("axis {axis}"))?;
        }
    }

    #[test]
    fn strips_and_bins_change_nothing(
        case in soups_of_any_seed(), axis in 0..3usize, rows in 1..9u32, bin in prop::array::uniform2(1..9u32)
    ) {
        let whole = mesh(Backend::Cpu, &case, axis);
        for backend in [Backend::CpuInStrips(rows), Backend::CpuInBins(bin)] {
            let parts = mesh(backend, &case, axis);
            same(&flags(&whole), &flags(&parts), case.lines.dims(), &format!("{backend:?}"))?;
            prop_assert_eq!(whole.n_crossings(), parts.n_crossings());
        }
    }

    #[test]
    fn moving_body_and_domain_by_whole_cells_changes_nothing(
        bodies in bodies(1..4), rule in rules(), by in prop::array::uniform3(-1000i32..1000)
    ) {
        let case = file(bodies.concat(), rule);
        let moved = with_corners(&case, |corner| std::array::from_fn(|axis| corner[axis] + by[axis] as f32));
        let moved = with_lines(&moved, lines(by.map(f64::from), [1.0; 3], DIMS));
        same_cases(&case, &moved, "moved together")?;
    }

    #[test]
    fn moving_the_domain_by_whole_cells_shows_other_cells(
        bodies in bodies(1..4), rule in rules(), from in prop::array::uniform3(0..4u32)
    ) {
        let case = file(bodies.concat(), rule);
        let whole = mesh(Backend::Cpu, &case, 0);
        let dims: [u32; 3] = std::array::from_fn(|axis| DIMS[axis] - from[axis]);
        let window = with_lines(&case, lines(from.map(f64::from), [1.0; 3], dims));
        let cells = std::array::from_fn(|axis| from[axis]..DIMS[axis]);
        same(&hexcast_core::cells::flags::flags_of_box(&whole, &cells).expect("columns in memory"), &cpu_flags(&window, 1), dims, "window")?;
    }

    #[test]
    fn scaling_everything_by_a_power_of_two_changes_nothing(case in soups_of_any_seed(), power in -40i32..40) {
        let scale = |x: f64| libm::ldexp(x, power);
        let scaled = with_corners(&case, |corner| corner.map(|x| libm::ldexpf(x, power)));
        let (origin, spacing, dims) = (case.lines.origin(), case.lines.smallest(), case.lines.dims());
        let scaled = with_lines(&scaled, lines(origin.map(scale), spacing.map(scale), dims));
        same_cases(&case, &scaled, "scaled")?;
    }

    #[test]
    fn two_bodies_with_a_common_facet_are_the_same_in_one_file_and_in_two(
        points in prop::array::uniform5(prop::array::uniform3(-8i32..36)), rule in rules()
    ) {
        let points = points.map(|point| point.map(|quarters| quarters as f32 * 0.25));
        let [a, b, c, d, mut e] = points;
        let side = |apex| models::signed_volume(&[[b, a, c], [a, b, apex], [b, c, apex], [c, a, apex]]);
        if side(d) * side(e) > 0.0 {
            // to the other side of the common facet
            e = std::array::from_fn(|axis| 2.0 * a[axis] - e[axis]);
        }
        let [first, second] = [d, e].map(|apex| models::tetrahedron([a, b, c, apex]));
        let one = file([first.clone(), second.clone()].concat(), rule);
        let two = files(vec![first, second], rule);
        same_cases(&one, &two, "tetrahedra")?;
    }

    #[test]
    fn winding_unites_the_bodies_of_a_file(bodies in bodies(2..4)) {
        // prisms over polygons that cross themselves wind both ways: made simple here by their boxes
        let boxes: Vec<Facets> = bodies.iter().map(|body| {
            let (low, high) = bounds(body);
            models::octahedron(low, high)
        }).collect();
        let one = file(boxes.concat(), Rule::Nonzero);
        same_cases(&one, &files(boxes, Rule::Nonzero), "union")?;
    }

    #[test]
    fn parity_is_the_exclusive_or_of_the_bodies_of_a_file(bodies in bodies(1..5)) {
        let mut expected = vec![0; DIMS.iter().product::<u32>() as usize];
        for body in &bodies {
            let one = cpu_flags(&file(body.clone(), Rule::Parity), 0);
            expected.iter_mut().zip(one).for_each(|(flag, other)| *flag ^= other);
        }
        same(&expected, &cpu_flags(&file(bodies.concat(), Rule::Parity), 2), DIMS, "exclusive or")?;
    }

    #[test]
    fn a_body_cut_in_four_gives_every_cell_to_exactly_one_part(
        points in prop::array::uniform4(prop::array::uniform3(-8i32..36)), weights in prop::array::uniform3(1..3i32)
    ) {
        // an inner point with weights of eighths: exact in f32
        let weights = [weights[0], weights[1], weights[2], 8 - weights.iter().sum::<i32>()];
        let corners = points.map(|point| point.map(|quarters| quarters as f32 * 0.25));
        let inner = std::array::from_fn(|axis| (0..4).map(|k| weights[k] as f32 * corners[k][axis]).sum::<f32>() / 8.0);
        let whole = cpu_flags(&file(models::tetrahedron(corners), Rule::Parity), 2);
        let mut covered = vec![0; whole.len()];
        for part in 0..4 {
            let mut part_corners = corners;
            part_corners[part] = inner;
            let flags = cpu_flags(&file(models::tetrahedron(part_corners), Rule::Parity), part % 3);
            covered.iter_mut().zip(flags).for_each(|(sum, flag)| *sum += flag);
        }
        same(&whole, &covered, DIMS, "partition")?;
    }

    #[test]
    fn several_geometries_are_painted_over_each_other_by_priority(
        bodies in bodies(1..5), priorities in prop::array::uniform4(-1i32..2), rule in rules()
    ) {
        let geometries: Vec<Geometry> = bodies.into_iter().enumerate().map(|(index, facets)| {
            set!(Geometry { priority: priorities[index], ..Geometry::new("body", index as u8 + 1, facets).unwrap() })
        }).collect();
        let mut painted = vec![0; DIMS.iter().product::<u32>() as usize];
        for priority in -1..2 {
            for geometry in geometries.iter().filter(|geometry| geometry.priority == priority) {
                let alone = Case { rule, ..several("alone", "a law", unit_cells(DIMS), vec![geometry.clone()]) };
                let flags = cpu_flags(&alone, 0);
                painted.iter_mut().zip(flags).filter(|(_, flag)| *flag != 0).for_each(|(cell, flag)| *cell = flag);
            }
        }
        let together = Case { rule, ..several("together", "a law", unit_cells(DIMS), geometries) };
        same(&painted, &cpu_flags(&together, 1), DIMS, "painted")?;
    }
}

fn bounds(facets: &Facets) -> (models::Point, models::Point) {
    let corners = || facets.iter().flatten();
    let extreme = |pick: fn(f32, f32) -> f32, axis: usize| corners().map(|c| c[axis]).reduce(pick).unwrap_or(0.0);
    (std::array::from_fn(|axis| extreme(f32::min, axis)), std::array::from_fn(|axis| extreme(f32::max, axis)))
}

#[test]
fn a_broken_law_fails() {
    let flags = [[1u8; 4], [1, 1, 0, 1]];
    assert!(same(&flags[0], &flags[1], [2, 2, 1], "law").is_err());
    assert!(same(&flags[0], &flags[0], [2, 2, 1], "law").is_ok());
}
