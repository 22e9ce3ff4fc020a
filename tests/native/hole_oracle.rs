//! Holes of few edges by their definition: of all ways of open edges that come back, those that share no edge with another, the shortest
//! first; and of the fans around their corners, that which bends the surface least.

use std::collections::BTreeSet;

use super::open_surfaces::Exact;

/// How often facets use an edge more in its direction than against it, by the numbers of its corners.
type Surplus = Vec<Vec<i32>>;

/// The facets that are missing, and the triangles that close the other holes of at most 8 edges. `sizes` are those of the snap's unit.
pub(crate) fn closing(facets: &[[Exact; 3]], sizes: [f64; 3]) -> (Vec<[Exact; 3]>, Vec<[Exact; 3]>) {
    let corners: Vec<&Exact> = facets.iter().flatten().collect::<BTreeSet<_>>().into_iter().collect();
    let number = |corner: &Exact| corners.binary_search(&corner).expect("it is one of them");
    let facets: Vec<[usize; 3]> = facets.iter().map(|facet| facet.each_ref().map(number)).collect();
    let mut surplus = vec![vec![0; corners.len()]; corners.len()];
    for [a, b, c] in facets.iter().copied() {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            surplus[from][to] += 1;
            surplus[to][from] -= 1;
        }
    }
    let place = |at: usize| -> [f64; 3] {
        std::array::from_fn(|k| sizes[k] * i64::try_from(&corners[at][k]).expect("26 bits") as f64)
    };
    let (mut missing, mut patches) = (Vec::new(), Vec::new());
    for n_edges in 3..=8 {
        let mut ways = Vec::new();
        (0..corners.len()).for_each(|first| walk(&surplus, &mut vec![first], n_edges, &mut ways));
        let is_facet =
            |way: &[usize]| facets.iter().any(|facet| BTreeSet::from(*facet) == way.iter().copied().collect());
        ways.retain(|way| n_edges > 3 || !is_facet(way));
        let shares =
            |one: &[usize], other: &[usize]| one != other && edges(one).any(|edge| edges(other).any(|e| e == edge));
        let alone: Vec<_> = ways.iter().filter(|one| !ways.iter().any(|other| shares(one, other))).collect();
        for way in alone {
            edges(way).for_each(|(from, to)| {
                surplus[from][to] -= 1;
                surplus[to][from] += 1;
            });
            let triangles = least_bent(way, &facets, &place);
            let exact = triangles.iter().map(|triangle| triangle.map(|at| corners[at].clone()));
            if n_edges == 3 { missing.extend(exact) } else { patches.extend(exact) }
        }
    }
    (missing, patches)
}

/// Ways on over open edges that come back to the first corner, the lowest, after so many.
fn walk(surplus: &Surplus, way: &mut Vec<usize>, n_edges: usize, found: &mut Vec<Vec<usize>>) {
    let (first, at) = (way[0], way[way.len() - 1]);
    let next: Vec<usize> = (0..surplus.len()).filter(|&to| surplus[at][to] > 0).collect();
    if n_edges > 3 && next.len() > 3 {
        return;
    }
    if way.len() == n_edges {
        found.extend(next.contains(&first).then(|| way.clone()));
        return;
    }
    for to in next {
        if to > first && !way.contains(&to) {
            way.push(to);
            walk(surplus, way, n_edges, found);
            way.pop();
        }
    }
}

fn edges(way: &[usize]) -> impl Iterator<Item = (usize, usize)> {
    (0..way.len()).map(|at| (way[at], way[(at + 1) % way.len()]))
}

/// The least bent of the fans around the corners of a hole; of equally bent ones the first.
fn least_bent(way: &[usize], facets: &[[usize; 3]], place: &impl Fn(usize) -> [f64; 3]) -> Vec<[usize; 3]> {
    let n = way.len();
    let fan = |at: usize| -> Vec<[usize; 3]> {
        (1..n - 1).map(|k| [way[at], way[(at + n - k) % n], way[(at + n - k - 1) % n]]).collect()
    };
    let bends: Vec<f64> = (0..n).map(|at| bend(&fan(at), way, facets, place)).collect();
    let better = |best: usize, at: usize| if (bends[at] as f32) < bends[best] as f32 { at } else { best };
    fan((0..n).reduce(better).expect("there is one"))
}

/// The sum over edges of length times the distance of the unit normals on both sides.
fn bend(triangles: &[[usize; 3]], way: &[usize], facets: &[[usize; 3]], place: &impl Fn(usize) -> [f64; 3]) -> f64 {
    let mut sum = 0.0;
    for &a in way {
        for &b in way.iter().filter(|&&b| b > a) {
            let at_edge = triangles.iter().filter(|triangle| triangle.contains(&a) && triangle.contains(&b));
            let mut normals: Vec<[f64; 3]> = at_edge.map(|triangle| normal(triangle.map(place))).collect();
            if normals.len() == 1 {
                // the first facet that uses the side, in the direction of the way
                let side =
                    edges(way).find(|&edge| edge == (a, b) || edge == (b, a)).expect("one triangle is at a side");
                let uses = |facet: &&[usize; 3]| edges(&facet[..]).any(|edge| edge == side);
                normals.push(normal(facets.iter().find(uses).expect("the edge is open").map(place)));
            }
            if let [one, other] = normals[..] {
                sum += distance(place(a), place(b)) * distance(one, other);
            }
        }
    }
    sum
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

/// The unit normal; zero of a triangle without area.
fn normal([a, b, c]: [[f64; 3]; 3]) -> [f64; 3] {
    let (u, v): ([f64; 3], [f64; 3]) = (std::array::from_fn(|k| b[k] - a[k]), std::array::from_fn(|k| c[k] - a[k]));
    let cross: [f64; 3] = std::array::from_fn(|k| u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3]);
    let length = distance(cross, [0.0; 3]);
    if length == 0.0 { cross } else { cross.map(|component| component / length) }
}
