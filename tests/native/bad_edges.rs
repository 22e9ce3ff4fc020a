//! Bad edges in reports, against a count of all edges one by one.

use std::collections::BTreeMap;

use hexcast::geometry::{Facet, Geometry};
use hexcast::job::{Job, Open, Rule};
use hexcast::pipeline::Engine;
use hexcast_core::grid::closed::BadEdges;
use hexcast_core::input::edges::BadEdge;
use num_bigint::BigInt;

use super::models::{self, Facets};
use super::open_surfaces::meshed;
use super::oracle;
use super::soups::{BODIES, Random, body, shuffled};

/// Facets of every edge that is not proper, by its kind; corners are those of the snap.
fn bad_edges(facets: &Facets, lines: &hexcast::lines::Lines) -> BTreeMap<BadEdge, Vec<Vec<u64>>> {
    let (snapped, _) = oracle::snapped_facets(&Geometry::new("g", 1, facets.clone()).unwrap(), lines);
    let mut uses: BTreeMap<[Vec<BigInt>; 2], Vec<(u64, bool)>> = BTreeMap::new();
    for (index, facet) in snapped.iter().map(|facet| facet.each_ref().map(|corner| corner.to_vec())).enumerate() {
        let [a, b, c] = facet;
        if a == b || b == c || c == a {
            continue;
        }
        for (from, to) in [(&a, &b), (&b, &c), (&c, &a)] {
            let is_forward = from < to;
            let pair = if is_forward { [from.clone(), to.clone()] } else { [to.clone(), from.clone()] };
            uses.entry(pair).or_default().push((index as u64, is_forward));
        }
    }
    let mut found: BTreeMap<BadEdge, Vec<Vec<u64>>> = BTreeMap::new();
    for uses in uses.values() {
        let kind = match &uses[..] {
            [_] => BadEdge::Open,
            [one, other] if one.1 == other.1 => BadEdge::Flipped,
            [_, _] => continue,
            _ => BadEdge::Nonmanifold,
        };
        found.entry(kind).or_default().push(uses.iter().map(|entry| entry.0).collect());
    }
    found
}

#[test]
fn soups_with_facets_missing_turned_and_doubled_are_counted_edge_by_edge() {
    let job = set!(Job { domain: Some([0.0, 0.0, 0.0, 8.0, 8.0, 8.0]), dims: Some([8, 9, 7]), ..Job::default() });
    let mut kinds = BTreeMap::new();
    for seed in 0..120 {
        let mut random = Random::new(seed);
        let mut facets = Vec::new();
        for _ in 0..random.between(1, 4) {
            let points = [[(); 3]; 4].map(|point| point.map(|()| random.below(17) as f32 / 2.0));
            facets.extend(body(random.one_of(&BODIES), points));
        }
        let mut facets: Vec<Facet> = shuffled(facets, &mut random);
        for _ in 0..random.between(0, 3) {
            let index = random.below(facets.len() as u64) as usize;
            match random.below(3) {
                0 => drop(facets.remove(index)),
                1 => facets[index].swap(0, 1),
                _ => facets.push(facets[index]),
            }
        }
        let (mesh, report) = meshed(std::slice::from_ref(&facets), &job, 0, &mut Engine::cpu()).expect("a mesh");
        let expected = bad_edges(&facets, mesh.lines());
        let n = |kind: BadEdge| expected.get(&kind).map_or(0, |edges| edges.len() as u64);
        let BadEdges { open, flipped, nonmanifold, worst } = &report.geometries[0].bad_edges;
        let counts = [BadEdge::Open, BadEdge::Flipped, BadEdge::Nonmanifold].map(n);
        assert_eq!([*open, *flipped, *nonmanifold], counts, "seed {seed}");
        for group in worst {
            *kinds.entry(group.kind).or_insert(0) += 1;
            let of_kind = &expected[&group.kind];
            assert!(group.edges <= of_kind.len() as u64, "seed {seed}");
            for facet in &group.facets {
                assert!(of_kind.iter().any(|edge| edge.contains(facet)), "seed {seed}: facet {facet} of {group:?}");
            }
        }
        for kind in [BadEdge::Open, BadEdge::Flipped, BadEdge::Nonmanifold] {
            let groups: Vec<_> = worst.iter().filter(|group| group.kind == kind).collect();
            assert_eq!(groups.is_empty(), n(kind) == 0, "seed {seed}");
            if groups.len() < 8 {
                assert_eq!(groups.iter().map(|group| group.edges).sum::<u64>(), n(kind), "seed {seed}");
            }
        }
    }
    assert!(kinds.len() == 3 && kinds.values().all(|n| *n > 20), "{kinds:?}");
}

#[test]
fn edges_that_matter_are_warned_about_with_facets_and_others_are_not() {
    let domain = Some([0.0, 0.0, 0.0, 8.0, 8.0, 8.0]);
    let cube = models::cuboid([1.0; 3], [7.0; 3]);
    let mut turned = cube.clone();
    turned[5].swap(0, 1);
    // the cube and another that has an edge in common with it
    let touching = models::joined([cube.clone(), models::cuboid([7.0, 7.0, 1.0], [8.0, 8.0, 7.0])]);
    let warnings = |facets: &Facets, rule: Rule, open: Open| {
        let job = set!(Job { domain, rule, open, dims: Some([8; 3]), ..Job::default() });
        let (_, report) = meshed(std::slice::from_ref(facets), &job, 0, &mut Engine::cpu()).expect("a mesh");
        (report.geometries[0].bad_edges.clone(), report.warnings)
    };
    for rule in [Rule::Parity, Rule::Nonzero] {
        let (bad, said) = warnings(&touching, rule, Open::Winding);
        assert_eq!((bad.nonmanifold, bad.open, said.len()), (1, 0, 0), "{said:?}");
        assert_eq!((bad.worst[0].length, bad.worst[0].bounds), (6.0, [[7.0, 7.0, 1.0], [7.0; 3]]));
    }
    assert_eq!(warnings(&cube, Rule::Parity, Open::Winding), (BadEdges::default(), vec![]));
    // the rule parity does not look at the direction of facets
    let (bad, said) = warnings(&turned, Rule::Parity, Open::Winding);
    assert_eq!((bad.flipped, said.len()), (3, 0), "{said:?}");
    for (open, decided) in
        [(Open::Winding, "facets turned 1; 3 of them"), (Open::Parity, "the rays of one axis decided")]
    {
        let (bad, said) = warnings(&turned, Rule::Nonzero, open);
        assert_eq!((bad.flipped, bad.open), (3, 0));
        let sentence = said.iter().find(|text| text.contains("edges between facets that face opposite ways 3"));
        let sentence = sentence.unwrap_or_else(|| panic!("{said:?}"));
        assert!(sentence.contains(decided) && sentence.contains("counted from 0 in the file"), "{sentence}");
    }
    let (bad, said) = warnings(&cube[..11].to_vec(), Rule::Parity, Open::Parity);
    assert_eq!(bad.open, 3);
    assert!(
        said[0].contains("is not closed: open edges 3, 3 of them between (1, 1, 7) and (7, 7, 7), of facets "),
        "{said:?}"
    );
}
