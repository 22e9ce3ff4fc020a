use std::collections::HashMap;

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

/// What an independent count finds: all edges in a map, shells by relabelling until nothing changes.
fn counted(facets: &[Facet]) -> Surface {
    let key = |corner: [f32; 3]| corner.map(|c| if c == 0.0 { 0 } else { c.to_bits() });
    let mut edges: HashMap<[[u32; 3]; 2], Vec<(usize, bool)>> = HashMap::new();
    let mut found = Surface { n_facets: facets.len() as u64, ..surface(&[]) };
    for (index, facet) in facets.iter().enumerate() {
        let [a, b, c] = facet.map(key);
        found.zero_area += u64::from(doubled_area_vector(facet) == [0.0; 3]);
        if a == b || b == c || c == a {
            found.collapsed += 1;
            continue;
        }
        for (from, to) in [(a, b), (b, c), (c, a)] {
            edges.entry([from.min(to), from.max(to)]).or_default().push((index, from < to));
        }
    }
    let mut open: Vec<(f64, [[u32; 3]; 2])> = Vec::new();
    let mut least: Vec<usize> = (0..facets.len()).collect();
    for (&ends, uses) in &edges {
        let n_forward = uses.iter().filter(|entry| entry.1).count();
        let [f, b] = [n_forward, uses.len() - n_forward];
        found.open_edges += u64::from(f + b == 1);
        found.nonmanifold_edges += u64::from(f + b > 2);
        found.flipped_edges += u64::from(f + b == 2 && f != 1);
        found.closed_oriented &= f == b;
        found.closed_parity &= (f + b) % 2 == 0;
        found.watertight &= f == 1 && b == 1;
        if f + b == 1 {
            let [one, other] = ends.map(|end| end.map(|c| f64::from(f32::from_bits(c))));
            open.push((-(0..3).map(|axis| (one[axis] - other[axis]).powi(2)).sum::<f64>(), ends));
        }
    }
    open.sort_by(|one, other| one.partial_cmp(other).unwrap());
    found.worst_open_edges = open.iter().take(10).map(|(_, ends)| ends.map(|end| end.map(f32::from_bits))).collect();
    loop {
        let before = least.clone();
        for uses in edges.values() {
            let of_all = uses.iter().map(|entry| least[entry.0]).min().unwrap();
            uses.iter().for_each(|entry| least[entry.0] = of_all);
        }
        // the label of a facet is a facet: that one's label is as good, and less
        (0..least.len()).for_each(|index| least[index] = least[least[index]]);
        if least == before {
            break;
        }
    }
    let is_alone = |facet: &Facet| {
        let [a, b, c] = facet.map(key);
        a == b || b == c || c == a
    };
    found.shells = (0..facets.len()).filter(|&index| least[index] == index && !is_alone(&facets[index])).count() as u64;
    found
}

/// Random numbers from a seed.
fn numbers(seed: u64) -> impl FnMut(u64) -> u64 {
    let mut state = seed;
    move |n| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) % n
    }
}

/// Facets whose corners are of so many numbers an axis, among them -0.
fn soup(seed: u64, n_facets: usize, n_numbers: u64) -> Vec<Facet> {
    let mut random = numbers(seed);
    let mut number = || match random(n_numbers) {
        0 => [0.0, -0.0][random(2) as usize],
        other => other as f32 - 2.0,
    };
    (0..n_facets).map(|_| [[(); 3]; 3].map(|corner| corner.map(|()| number()))).collect()
}

/// Two facets for each of n x m squares of a torus, some of them turned, left out, given twice or collapsed.
fn torus([n, m]: [usize; 2], seed: u64) -> Vec<Facet> {
    let mut random = numbers(seed);
    let corner = |i: usize, j: usize| {
        let [u, v] = [(i % n) as f32 / n as f32, (j % m) as f32 / m as f32].map(|turn| turn * std::f32::consts::TAU);
        [u.cos() * (3.0 + v.cos()), u.sin() * (3.0 + v.cos()), v.sin()]
    };
    let square = |i: usize, j: usize| {
        let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
        [[a, b, c], [a, c, d]]
    };
    let facets = (0..n).flat_map(|i| (0..m).flat_map(move |j| square(i, j)));
    let spoiled = facets.flat_map(|facet| match random(5000) {
        0 => vec![flipped(facet)],
        1 => vec![],
        2 => vec![facet, facet],
        3 => vec![facet, [facet[0], facet[1], facet[0]]],
        _ => vec![facet],
    });
    spoiled.collect()
}

fn shuffle<T>(list: &mut [T], seed: u64) {
    let mut random = numbers(seed);
    (1..list.len()).rev().for_each(|index| list.swap(index, random(index as u64 + 1) as usize));
}

/// Compares all but the area, whose last bits depend on the order.
fn assert_counted(facets: &[Facet], expected: &Surface, what: &str) {
    let found = surface(facets);
    assert!((found.area - expected.area).abs() <= 1e-9 * expected.area || expected.area == 0.0, "{what}");
    assert_eq!(&Surface { area: expected.area, ..found }, expected, "{what}");
}

#[test]
fn chunks_and_what_lies_between_them_count_like_a_map_of_all_edges_in_any_order() {
    let sizes = [1, 2, 1000, FACETS - 1, FACETS, FACETS + 1, 3 * FACETS + 7];
    let of_few = sizes.map(|n| (format!("{n} facets of few corners"), soup(n as u64, n, 5)));
    let of_many = sizes.map(|n| (format!("{n} facets of many corners"), soup(n as u64, n, 40)));
    let of_row = sizes.map(|n| (format!("{n} facets in order"), (torus([n.div_ceil(1000), 500], 1))));
    for (what, mut facets) in of_few.into_iter().chain(of_many).chain(of_row) {
        let expected = Surface { area: surface(&facets).area, ..counted(&facets) };
        assert_counted(&facets, &expected, &what);
        shuffle(&mut facets, 7);
        assert_counted(&facets, &expected, &format!("{what}, shuffled"));
    }
}

#[test]
fn a_hub_in_all_chunks_has_all_its_edges() {
    // a fan around one corner, closed by a fan around another
    let n = 2 * FACETS;
    let rim = |i: usize| [(i % n) as f32, ((i % n) as f32).powi(2), 0.0];
    let fan = |hub: [f32; 3], is_up: bool| {
        (0..n).map(move |i| if is_up { [hub, rim(i), rim(i + 1)] } else { [hub, rim(i + 1), rim(i)] })
    };
    let mut facets: Vec<Facet> = fan([0.0, 0.0, 1.0], true).chain(fan([0.0, 0.0, -1.0], false)).collect();
    for _ in 0..2 {
        let found = surface(&facets);
        assert!(found.watertight);
        assert_eq!((found.shells, found.open_edges, found.collapsed), (1, 0, 0));
        shuffle(&mut facets, 3);
    }
}

#[test]
fn classes_have_each_edge_between_chunks_once() {
    let facets = soup(1, 3 * FACETS, 12);
    let control = Control::default().on_share(|share| assert!((0.0..1.0).contains(&share)));
    let mut check = Check::new(&facets, &control);
    at_once(check.make_chunks()).unwrap();
    let first_numbers = at_once(check.number_shared()).unwrap();
    at_once(check.look_at_own(first_numbers)).unwrap();
    assert!(check.bytes_of_chunks <= check.room.n_bytes());
    let n_uses: usize = check.chunks.iter().map(Chunk::n_shared_uses).sum();
    let all = shared::uses_of_class(&check.chunks, 0, 1);
    assert_eq!(all.len(), n_uses);
    let of_classes: Vec<_> = (0..4).map(|class| shared::uses_of_class(&check.chunks, class, 4)).collect();
    assert!(of_classes.iter().all(|uses| uses.is_sorted() && uses.len() > n_uses / 8));
    let mut together = of_classes.concat();
    together.sort_unstable();
    assert_eq!(together, all);
    let n_edges: usize = of_classes.iter().map(|uses| each(uses).count()).sum();
    assert_eq!(n_edges, each(&all).count());
}

#[test]
fn neither_the_area_nor_anything_else_depends_on_the_number_of_threads() {
    let facets = torus([200, 500], 3);
    let in_pool = |n_threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap();
        pool.install(|| surface(&facets))
    };
    let alone = in_pool(1);
    assert!(alone.open_edges > 0 && alone.flipped_edges > 0 && alone.nonmanifold_edges > 0 && alone.collapsed > 0);
    assert_eq!(in_pool(2), alone);
    assert_eq!(in_pool(5), alone);
}
