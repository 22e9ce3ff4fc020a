//! Every backend, along every axis, against the oracle: cell by cell.

use hexcast_core::stages::map::Rule;

use super::backends::{BACKENDS, Backend, cpu_flags, flags, mesh};
use super::cases::{Case, cases, moved_by};
use super::compare::{assert_same, difference};
use super::oracle;
use super::soups::{crumbs, soup};

/// Cells times facets that the oracle does in a fraction of a second.
const ORACLE_LIMIT: u64 = 2_000_000;

fn oracle_flags(case: &Case) -> Vec<u8> {
    oracle::flags(&case.geometries, &case.lines, case.rule)
}

/// Most facets that a backend may project, those of each bin row by themselves: more would prove the same, in minutes.
const MOST_PROJECTED: u64 = 400_000;

fn is_closed(case: &Case) -> bool {
    oracle::is_closed(&case.geometries, &case.lines, case.rule)
}

#[test]
fn hundreds_of_soups_agree_with_the_oracle_along_every_axis() {
    let mut n_filled = [0; 2];
    for seed in 1000..1400 {
        let case = soup(seed);
        assert!(is_closed(&case), "seed {seed} is not closed");
        let expected = oracle_flags(&case);
        n_filled[usize::from(case.rule == Rule::Nonzero)] += usize::from(expected.iter().any(|&flag| flag != 0));
        for axis in 0..3 {
            let columns = mesh(Backend::Cpu, &case, axis);
            assert_same(&format!("seed {seed}, axis {axis}"), &expected, &flags(&columns), case.lines.dims());
            assert_eq!(columns.odd_rays(), 0, "seed {seed}, axis {axis}: odd rays on a closed surface");
        }
    }
    // soups of flat bodies alone would prove nothing
    assert!(n_filled.iter().all(|&n| n > 100), "soups with cells: {n_filled:?}");
}

#[test]
fn crumbs_agree_with_the_oracle_along_every_axis() {
    let mut n_inside = 0;
    for seed in 0..12 {
        let case = crumbs(seed);
        let expected = oracle_flags(&case);
        n_inside += expected.iter().filter(|&&flag| flag != 0).count();
        for axis in 0..3 {
            assert_same(&format!("seed {seed}, axis {axis}"), &expected, &cpu_flags(&case, axis), case.lines.dims());
        }
    }
    assert!(n_inside > 100, "{n_inside} crumbs hold a centre");
}

#[test]
fn closed_cases_agree_with_the_oracle() {
    let mut n_cases = 0;
    for case in cases() {
        if case.lines.n_cells() * case.n_facets() as u64 > ORACLE_LIMIT || !is_closed(&case) {
            continue;
        }
        let expected = oracle_flags(&case);
        for axis in 0..3 {
            assert_same(&format!("{}, axis {axis}", case.name), &expected, &cpu_flags(&case, axis), case.lines.dims());
        }
        n_cases += 1;
    }
    assert!(n_cases >= 70, "the oracle judged {n_cases} cases");
}

#[test]
fn backends_and_axes_agree_on_every_case() {
    let mut n_meshes = 0;
    for case in cases() {
        for axis in 0..3 {
            let expected = mesh(BACKENDS[0], &case, axis);
            for &backend in BACKENDS[1..].iter().filter(|backend| backend.n_projected(&case, axis) <= MOST_PROJECTED) {
                n_meshes += 1;
                let actual = mesh(backend, &case, axis);
                let label = format!("{}, axis {axis}, {backend:?}", case.name);
                assert_same(&label, &flags(&expected), &flags(&actual), case.lines.dims());
                assert!(expected == actual, "{label}: runs differ where flags do not");
                let counts = [&expected, &actual].map(|c| (c.odd_rays(), c.n_crossings()));
                assert_eq!(counts[0], counts[1], "{label}: odd rays and crossings");
            }
        }
    }
    assert!(n_meshes > 1000, "{n_meshes} meshes were compared");
}

#[test]
fn closed_cases_have_even_rays_and_the_same_flags_along_every_axis() {
    let mut n_open = 0;
    for case in cases() {
        let along = [0, 1, 2].map(|axis| mesh(BACKENDS[0], &case, axis));
        if is_closed(&case) {
            for axis in 0..3 {
                assert_eq!(along[axis].odd_rays(), 0, "{}, axis {axis}", case.name);
                let label = format!("{}, axes 0 and {axis}", case.name);
                assert_same(&label, &flags(&along[0]), &flags(&along[axis]), case.lines.dims());
            }
        } else {
            let odd_rays = along.each_ref().map(|columns| columns.odd_rays());
            assert!(odd_rays.iter().any(|&n| n > 0), "{} is open, and no axis sees it", case.name);
            n_open += 1;
        }
    }
    assert!(n_open >= 8, "{n_open} open cases");
}

#[test]
fn the_oracle_can_disagree() {
    let case = cases().into_iter().find(|case| case.name == "nested-shells-parity").unwrap();
    let other_rule = oracle::flags(&case.geometries, &case.lines, Rule::Nonzero);
    assert!(difference(&other_rule, &cpu_flags(&case, 2), case.lines.dims()).is_some());
    let mut moved = case.clone();
    moved.lines = moved_by(&moved.lines, -1.0);
    assert!(difference(&oracle_flags(&moved), &cpu_flags(&case, 2), case.lines.dims()).is_some());
}
