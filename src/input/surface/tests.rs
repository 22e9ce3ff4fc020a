use super::*;

const O: [f32; 3] = [0.0, 0.0, 0.0];
const X: [f32; 3] = [1.0, 0.0, 0.0];
const Y: [f32; 3] = [0.0, 1.0, 0.0];
const Z: [f32; 3] = [0.0, 0.0, 1.0];

/// Corner of a right angle, outward normals; volume 1/6.
fn tetrahedron() -> Vec<Facet> {
    vec![[O, Y, X], [O, X, Z], [O, Z, Y], [X, Y, Z]]
}

fn moved(facets: &[Facet], by: f32) -> Vec<Facet> {
    facets.iter().map(|facet| facet.map(|[x, y, z]| [x + by, y, z])).collect()
}

/// Turns the facet round.
fn flipped([a, b, c]: Facet) -> Facet {
    [a, c, b]
}

#[test]
fn a_tetrahedron_is_watertight() {
    let found = surface(&tetrahedron());
    assert!(found.watertight && found.closed_oriented && found.closed_parity);
    assert_eq!((found.n_facets, found.shells), (4, 1));
    assert_eq!((found.open_edges, found.nonmanifold_edges, found.flipped_edges), (0, 0, 0));
    assert_eq!((found.zero_area, found.collapsed), (0, 0));
    assert_eq!(found.worst_open_edges, Vec::<[[f32; 3]; 2]>::new());
    assert!((found.area - (1.5 + 0.75f64.sqrt())).abs() < 1e-15);
}

#[test]
fn no_facet_has_no_open_edge() {
    let found = surface(&[]);
    assert!(found.watertight && found.closed_oriented && found.closed_parity);
    assert_eq!((found.n_facets, found.shells, found.area), (0, 0, 0.0));
}

#[test]
fn a_missing_facet_leaves_its_three_edges_open_longest_first() {
    let found = surface(&tetrahedron()[1..]);
    assert_eq!((found.open_edges, found.shells), (3, 1));
    assert!(!found.watertight && !found.closed_oriented && !found.closed_parity);
    assert_eq!(found.worst_open_edges.len(), 3);
    assert!(found.worst_open_edges[0] == [X, Y] || found.worst_open_edges[0] == [Y, X]);
}

#[test]
fn a_gap_of_one_ulp_is_a_gap_and_minus_zero_is_zero() {
    let mut facets = tetrahedron();
    facets[3][0][1] = -0.0;
    facets[1][0] = [-0.0; 3];
    assert!(surface(&facets).watertight);
    facets[3][0][0] = 1f32.next_up();
    let found = surface(&facets);
    assert_eq!((found.open_edges, found.shells), (4, 1));
}

#[test]
fn a_turned_facet_flips_its_edges_and_keeps_the_parity() {
    let mut facets = tetrahedron();
    facets[0] = flipped(facets[0]);
    let found = surface(&facets);
    assert_eq!((found.flipped_edges, found.open_edges, found.nonmanifold_edges), (3, 0, 0));
    assert!(found.closed_parity && !found.closed_oriented && !found.watertight);
}

#[test]
fn all_facets_turned_are_as_watertight_as_before() {
    let facets: Vec<Facet> = tetrahedron().into_iter().map(flipped).collect();
    assert!(surface(&facets).watertight);
}

#[test]
fn a_solid_given_twice_is_closed_but_not_manifold() {
    let found = surface(&[tetrahedron(), tetrahedron()].concat());
    assert_eq!((found.nonmanifold_edges, found.shells), (6, 1));
    assert!(found.closed_oriented && found.closed_parity && !found.watertight);
}

#[test]
fn a_facet_given_twice_is_neither() {
    let found = surface(&[tetrahedron(), vec![tetrahedron()[3]]].concat());
    assert_eq!((found.nonmanifold_edges, found.open_edges), (3, 0));
    assert!(!found.closed_oriented && !found.closed_parity);
}

#[test]
fn shells_hang_together_by_edges_not_by_vertices() {
    let apart = surface(&[tetrahedron(), moved(&tetrahedron(), 5.0)].concat());
    assert_eq!(apart.shells, 2);
    let touching_in_a_vertex = surface(&[tetrahedron(), moved(&tetrahedron(), 1.0)].concat());
    assert_eq!((touching_in_a_vertex.shells, touching_in_a_vertex.watertight), (2, true));
}

#[test]
fn collapsed_facets_are_counted_and_otherwise_ignored() {
    let found = surface(&[tetrahedron(), vec![[X, X, Y], [Z, Z, Z]]].concat());
    assert_eq!((found.n_facets, found.collapsed, found.zero_area, found.shells), (6, 2, 2, 1));
    assert!(found.watertight);
    let alone = surface(&[[X, Y, X]]);
    assert_eq!((alone.collapsed, alone.shells, alone.open_edges), (1, 0, 0));
}

#[test]
fn a_facet_without_area_has_edges_unless_it_is_collapsed() {
    let found = surface(&[[O, X, [2.0, 0.0, 0.0]]]);
    assert_eq!((found.zero_area, found.collapsed, found.open_edges, found.shells), (1, 0, 3, 1));
}

#[test]
fn at_most_ten_open_edges_are_listed_longest_first() {
    let facets: Vec<Facet> = (1..=20).map(|i| [O, [i as f32, 100.0, 0.0], [0.0, 0.0, -(i as f32)]]).collect();
    let found = surface(&facets);
    assert_eq!(found.open_edges, 60);
    assert_eq!(found.worst_open_edges.len(), MAX_WORST_OPEN_EDGES);
    let squared = |[a, b]: [[f32; 3]; 2]| (0..3).map(|i| f64::from(a[i] - b[i]).powi(2)).sum::<f64>();
    assert!(found.worst_open_edges.windows(2).all(|two| squared(two[0]) >= squared(two[1])));
    assert_eq!(squared(found.worst_open_edges[0]), 10_000.0 + 800.0);
}

/// The edges counted one by one, without sorting.
fn brute_force(facets: &[Facet]) -> (u64, u64, u64, bool, bool) {
    let mut edges: Vec<([[f32; 3]; 2], u64, u64)> = Vec::new();
    for &[a, b, c] in facets.iter().filter(|[a, b, c]| a != b && b != c && c != a) {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            if let Some(edge) = edges.iter_mut().find(|edge| edge.0 == [from, to]) {
                edge.1 += 1;
            } else if let Some(edge) = edges.iter_mut().find(|edge| edge.0 == [to, from]) {
                edge.2 += 1;
            } else {
                edges.push(([from, to], 1, 0));
            }
        }
    }
    let count = |test: &dyn Fn(u64, u64) -> bool| edges.iter().filter(|edge| test(edge.1, edge.2)).count() as u64;
    (
        count(&|f, b| f + b == 1),
        count(&|f, b| f + b > 2),
        count(&|f, b| f + b == 2 && f != 1),
        count(&|f, b| f != b) == 0,
        count(&|f, b| (f + b) % 2 == 1) == 0,
    )
}

#[test]
fn random_soups_count_like_brute_force_in_any_order() {
    for seed in 0..60u64 {
        let mut state = seed;
        let mut random = |n: u64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) % n
        };
        let n_facets = 1 + random(60) as usize;
        let mut facets: Vec<Facet> =
            (0..n_facets).map(|_| [[(); 3]; 3].map(|corner| corner.map(|()| random(2) as f32 - 0.5))).collect();
        let found = surface(&facets);
        let counted = (
            found.open_edges,
            found.nonmanifold_edges,
            found.flipped_edges,
            found.closed_oriented,
            found.closed_parity,
        );
        assert_eq!(counted, brute_force(&facets), "seed {seed}");
        for index in (1..facets.len()).rev() {
            facets.swap(index, random(index as u64 + 1) as usize);
        }
        let shuffled = surface(&facets);
        let area = shuffled.area;
        assert!((area - found.area).abs() <= 1e-12 * area, "seed {seed}");
        assert_eq!(Surface { area: found.area, ..shuffled }, found, "seed {seed}");
    }
}
