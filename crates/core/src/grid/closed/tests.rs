use super::*;
use crate::base::control::Control;
use crate::base::error::Result;
use crate::base::memory::Memory;
use crate::grid::frame::Frame;
use crate::grid::lines::Lines;
use crate::input::geometry::Geometry;

const O: [i32; 3] = [0, 0, 0];
const X: [i32; 3] = [64, 0, 0];
const Y: [i32; 3] = [0, 64, 0];
const Z: [i32; 3] = [0, 0, 64];

fn tetrahedron() -> Vec<SnappedFacet> {
    vec![[O, Y, X], [O, X, Z], [O, Z, Y], [X, Y, Z]]
}

/// The definition, edge by edge.
fn brute_force(facets: &[SnappedFacet]) -> Closed {
    let mut counts: std::collections::BTreeMap<[[i32; 3]; 2], [u32; 2]> = Default::default();
    for facet in facets.iter().filter(|[a, b, c]| a != b && b != c && c != a) {
        for (from, to) in [(0, 1), (1, 2), (2, 0)] {
            let (from, to) = (facet[from], facet[to]);
            if from != to {
                counts.entry([from.min(to), from.max(to)]).or_default()[usize::from(from > to)] += 1;
            }
        }
    }
    Closed {
        parity: counts.values().all(|[f, b]| (f + b) % 2 == 0),
        nonzero: counts.values().all(|[f, b]| f == b),
        is_proper: counts.values().all(|uses| *uses == [1, 1]),
    }
}

#[test]
fn closedness_is_that_of_every_edge() {
    let turned = |[a, b, c]: SnappedFacet| [a, c, b];
    let whole = tetrahedron();
    let mut one_turned = whole.clone();
    one_turned[2] = turned(one_turned[2]);
    let twice = [whole.clone(), whole.clone()].concat();
    let both_ways: Vec<SnappedFacet> = whole.iter().map(|&facet| turned(facet)).chain(whole.clone()).collect();
    let all_turned = whole.iter().map(|&facet| turned(facet)).collect();
    let collapsed = [whole.clone(), vec![[O, O, X], [Y, Z, Y]]].concat();
    for facets in [vec![], whole.clone(), whole[1..].to_vec(), one_turned, twice, both_ways, all_turned, collapsed] {
        assert_eq!(Closed::of(&facets), brute_force(&facets), "{facets:?}");
    }
}

#[test]
fn one_edge_of_many_that_comes_twice_is_found() {
    // a strip of tetrahedra, each beside the last: 240,000 facets in several chunks, whose hashes are compared in several groups
    let moved = |by: i32| tetrahedron().into_iter().map(move |facet| facet.map(|[x, y, z]| [x + by, y, z]));
    let mut facets: Vec<SnappedFacet> = (0..60_000).flat_map(|index| moved(100 * index)).collect();
    assert_eq!(Closed::of(&facets), brute_force(&facets));
    assert!(Closed::of(&facets).is_proper);
    // one more, which has an edge in common with one far away
    facets.extend(tetrahedron().into_iter().map(|facet| facet.map(|[x, y, z]| [x + 1_500_000, -y, -z])));
    let found = Closed::of(&facets);
    assert_eq!(found, brute_force(&facets));
    assert!(found.parity && found.nonzero && !found.is_proper);
}

#[test]
fn hashes_of_the_edges_of_a_grid_are_distinct_and_all_their_bits_even() {
    let mut hashes = Vec::new();
    for [x, y, z] in (0..64).flat_map(|x| (0..64).flat_map(move |y| (0..16).map(move |z| [x - 32, y, 64 * z]))) {
        let corner = corner_hash(&[x, y, z]);
        for other in [[x + 1, y, z], [x, y + 1, z], [x, y, z + 64], [x + 1, y + 1, z]] {
            hashes.push(edge_hash(corner, corner_hash(&other)));
        }
    }
    for word in 0..2 {
        let mut words: Vec<u64> = hashes.iter().map(|hash| hash[word]).collect();
        for bit in 0..64 {
            let share = words.iter().filter(|word| *word >> bit & 1 == 1).count() as f64 / words.len() as f64;
            // four times the deviation of coins
            assert!((share - 0.5).abs() < 4.0 * 0.5 / (words.len() as f64).sqrt(), "bit {bit} of word {word}: {share}");
        }
        words.sort_unstable();
        assert!(words.windows(2).all(|two| two[0] != two[1]));
    }
}

fn found_in(facets: Vec<SnappedFacet>, pieces: Vec<[u64; 2]>) -> BadEdges {
    found_with(facets, pieces, &Control::default()).unwrap()
}

fn found_with(facets: Vec<SnappedFacet>, pieces: Vec<[u64; 2]>, control: &Control) -> Result<BadEdges> {
    let lines = Lines::new([10.0, 20.0, 30.0], [0.5; 3], [4; 3]).unwrap();
    let mut geometry = Geometry::new("g", 1, vec![[[0.0; 3]; 3]]).unwrap();
    geometry.pieces_in_file = pieces;
    let frame = Frame::new(std::slice::from_ref(&geometry), &lines).unwrap();
    let frame = Frame { fraction_bits: 6, ..frame.with_facets(facets) };
    let closed = [Closed::of(&frame.facets)];
    let found = BadEdges::of_geometries(&frame, &closed, &lines, &[geometry], (&Memory::default(), control));
    found.map(|mut found| found.remove(0))
}

#[test]
fn a_search_for_bad_edges_ends_where_it_is_cancelled() {
    let control = Control::default();
    control.cancel.cancel();
    let found = found_with(tetrahedron()[..3].to_vec(), vec![], &control);
    assert_eq!(found.unwrap_err().code(), "cancelled");
}

#[test]
fn bad_edges_are_counted_and_the_worst_groups_listed_with_facets_as_in_the_file() {
    assert_eq!(found_in(tetrahedron(), vec![]), BadEdges::default());
    // the slope is gone: its three edges are open, of facets 0, 1 and 2
    let found = found_in(tetrahedron()[..3].to_vec(), vec![]);
    assert_eq!((found.open, found.flipped, found.nonmanifold), (3, 0, 0));
    let [group] = &found.worst[..] else { panic!("{found:?}") };
    assert_eq!((group.kind, group.edges, &group.facets[..]), (crate::input::edges::BadEdge::Open, 3, &[0, 1, 2][..]));
    // the centre of cell 0 is at 10.25, 20.25, 30.25, and 64 units are a cell
    assert_eq!(group.bounds, [[10.25, 20.25, 30.25], [10.75, 20.75, 30.75]]);
    assert!((group.length - 3.0 * 0.5f64.sqrt()).abs() < 1e-12, "{group:?}");
    // facets 0 and 1 come from another place of the file than 2
    let found = found_in(tetrahedron()[..3].to_vec(), vec![[0, 7], [2, 40]]);
    assert_eq!(found.worst[0].facets, [7, 8, 40]);
}

#[test]
fn groups_are_listed_by_kind_and_length() {
    let at = |by: i32, scale: i32| move |facet: SnappedFacet| facet.map(|corner| corner.map(|c| c * scale + by));
    let mut facets: Vec<SnappedFacet> = Vec::new();
    // ten tetrahedra without their first facets, each larger than the one before
    for index in 1..=10 {
        facets.extend(tetrahedron()[1..].iter().copied().map(at(1000 * index, index)));
    }
    // one with a turned facet, and two that are the same
    let turned = |[a, b, c]: SnappedFacet| [a, c, b];
    facets.extend(tetrahedron().into_iter().map(at(-5000, 1)));
    let last = facets.len() - 1;
    facets[last] = turned(facets[last]);
    facets.extend([tetrahedron(), tetrahedron()].concat().into_iter().map(at(-9000, 1)));
    let found = found_in(facets, vec![]);
    assert_eq!((found.open, found.flipped, found.nonmanifold), (30, 3, 6));
    let kinds: Vec<_> = found.worst.iter().map(|group| (group.kind as u8, group.edges)).collect();
    assert_eq!(kinds, [vec![(0, 3); 8], vec![(1, 3), (2, 6)]].concat());
    assert!(found.worst[..8].windows(2).all(|two| two[0].length > two[1].length));
    assert_eq!(found.worst[0].facets, [27, 28, 29]);
}
