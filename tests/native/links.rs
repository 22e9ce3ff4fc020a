//! Links from cells to surfaces against an oracle in big integers, which shears nothing and casts nothing.
//!
//! The oracle looks at every link by itself and at every facet. It puts P - (e1, e2, e3), e1 >> e2 >> e3, in place of the centre P, as signs of
//! the first of several integers that is not 0. Whether a geometry holds a cell comes from [`super::oracle`].

use std::collections::BTreeMap;

use hexcast::columns::Columns;
use hexcast::control::Control;
use hexcast::geometry::Geometry;
use hexcast::job::{LinksJob, Rule, Stencil};
use hexcast::links::{Field, Link, Links};
use hexcast_core::grid::frame::Frame;
use hexcast_core::grid::rays::Rays;
use hexcast_core::grid::window::CellWindow;
use hexcast_core::stages::cpu;
use hexcast_core::stages::inside::Kind;
use num_bigint::{BigInt, Sign};

use super::cases::{Case, cases, several, unit_cells};
use super::models;
use super::oracle::{self, Vector};
use super::soups::{Random, soup};

/// A crossing of a link: `q = up / of`, its geometry, facet and the step of the winding number.
struct Crossing {
    up: BigInt,
    of: BigInt,
    geometry: usize,
    facet: usize,
    step: i32,
}

fn minus(a: &Vector, b: &Vector) -> Vector {
    [0, 1, 2].map(|axis| &a[axis] - &b[axis])
}

fn cross(a: &Vector, b: &Vector) -> Vector {
    [0, 1, 2].map(|i: usize| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        &a[j] * &b[k] - &a[k] * &b[j]
    })
}

fn dot(a: &Vector, b: &Vector) -> BigInt {
    &a[0] * &b[0] + &a[1] * &b[1] + &a[2] * &b[2]
}

/// Sign of `value - slope . (e1, e2, e3)`; 0 only where all are 0.
fn sign(value: &BigInt, slope: &Vector) -> i32 {
    let of = |number: &BigInt| match number.sign() {
        Sign::Minus => -1,
        Sign::NoSign => 0,
        Sign::Plus => 1,
    };
    let first = [of(value), -of(&slope[0]), -of(&slope[1]), -of(&slope[2])];
    first.into_iter().find(|&sign| sign != 0).unwrap_or(0)
}

/// Where the segment from P - e to Q - e crosses a facet, if it does.
fn crossing([p, q]: [&Vector; 2], facet: &[Vector; 3]) -> Option<(BigInt, BigInt, i32)> {
    let [a, b, c] = facet;
    let normal = cross(&minus(b, a), &minus(c, a));
    let heights = [p, q].map(|end| dot(&normal, &minus(end, a)));
    let [from, to] = [0, 1].map(|end| sign(&heights[end], &normal));
    if from == to {
        return None;
    }
    let along = minus(q, p);
    let sides = [(a, b), (b, c), (c, a)].map(|(a, b)| {
        // along . ((a - P) x (b - P)), and how it changes with P
        let slope = cross(&minus(b, a), &along).map(|x| -x);
        sign(&dot(&along, &cross(&minus(a, p), &minus(b, p))), &slope)
    });
    if sides[0] == 0 || sides.iter().any(|&side| side != sides[0]) {
        return None;
    }
    let [mut up, mut of] = [heights[0].clone(), &heights[0] - &heights[1]];
    if of.sign() == Sign::Minus {
        (up, of) = (-up, -of);
    }
    // from before the facet to behind it leaves the body
    Some((up, of, if from < 0 { -1 } else { 1 }))
}

/// A link as the oracle has it: q as a fraction, the facets that meet there, flag at the other end.
struct Expected {
    up: BigInt,
    of: BigInt,
    facets: Vec<[usize; 2]>,
    flag: u8,
}

type Key = ([u32; 3], u8);

fn expected(case: &Case, job: &LinksJob, inverted: &[bool]) -> BTreeMap<Key, Expected> {
    let Case { geometries, lines, rule, .. } = case;
    let dims = lines.dims();
    let (facets, centres) = oracle::snapped_all(geometries, lines);
    let insides = oracle::insides(geometries, lines, *rule);
    let mut order: Vec<usize> = (0..geometries.len()).collect();
    order.sort_by_key(|&index| geometries[index].priority);
    let at = |[x, y, z]: [u32; 3]| (x + dims[0] * (y + dims[1] * z)) as usize;
    let centre = |cell: [u32; 3]| -> Vector { [0, 1, 2].map(|axis: usize| centres[axis][cell[axis] as usize].clone()) };
    let flag_of = |holds: &dyn Fn(usize) -> bool| {
        order.iter().rev().find(|&&index| holds(index)).map_or(0, |&index| geometries[index].flag)
    };
    let is_held = |winding: i32, index: usize| (winding != 0) != inverted[index];
    let mut links = BTreeMap::new();
    for z in 0..dims[2] {
        for y in 0..dims[1] {
            for x in 0..dims[0] {
                let cell = [x, y, z];
                let start: Vec<i32> = insides.iter().map(|windings| windings[at(cell)]).collect();
                let flag = flag_of(&|index| is_held(start[index], index));
                if !job.fluid.contains(&flag) {
                    continue;
                }
                for (direction, step) in (0u8..).zip(job.stencil.directions()).skip(1) {
                    let other = [0, 1, 2].map(|axis: usize| cell[axis].wrapping_add_signed(step[axis].into()));
                    if (0..3).any(|axis| other[axis] >= dims[axis]) {
                        continue;
                    }
                    let end = flag_of(&|index| is_held(insides[index][at(other)], index));
                    let ends = [centre(cell), centre(other)];
                    let mut crossings = Vec::new();
                    for (geometry, facets) in facets.iter().enumerate() {
                        for (facet, corners) in facets.iter().enumerate() {
                            if let Some((up, of, step)) = crossing([&ends[0], &ends[1]], corners) {
                                crossings.push(Crossing { up, of, geometry, facet, step });
                            }
                        }
                    }
                    crossings.sort_by(|one, two| (&one.up * &two.of).cmp(&(&two.up * &one.of)));
                    let mut windings = start.clone();
                    let mut found = None;
                    for at_once in crossings.chunk_by(|one, two| &one.up * &two.of == &two.up * &one.of) {
                        for crossing in at_once {
                            let winding = &mut windings[crossing.geometry];
                            *winding = if *rule == Rule::Parity { *winding ^ 1 } else { *winding + crossing.step };
                        }
                        let flag = flag_of(&|index| is_held(windings[index], index));
                        if found.is_none() && !job.fluid.contains(&flag) {
                            let facets = at_once.iter().map(|crossing| [crossing.geometry, crossing.facet]).collect();
                            let (up, of) = (at_once[0].up.clone(), at_once[0].of.clone());
                            found = Some(Expected { up, of, facets, flag: end });
                        }
                    }
                    let held = (0..windings.len())
                        .all(|index| is_held(windings[index], index) == is_held(insides[index][at(other)], index));
                    assert!(held, "the oracle itself: {cell:?} to {other:?}");
                    assert!(
                        found.is_some() || job.fluid.contains(&end),
                        "{cell:?} to {other:?}: flags differ without a wall"
                    );
                    if let Some(found) = found {
                        links.insert((cell, direction), found);
                    }
                }
            }
        }
    }
    links
}

fn kinds(case: &Case, inverted: &[bool]) -> (Frame, Vec<Kind>) {
    let frame = Frame::new(&case.geometries, &case.lines).unwrap();
    let kind = |&index: &usize| if inverted[index] { Kind::Inverted } else { Kind::Cast };
    let kinds = frame.ranks.geometry_at.iter().map(kind).collect();
    (frame, kinds)
}

fn field<'a>(case: &Case, frame: &'a Frame, kinds: &'a [Kind], columns: &'a Columns) -> Field<'a> {
    let (first, window) = ([0; 3], CellWindow::all(case.lines.dims()));
    Field { frame, rule: case.rule, kinds, columns, first, window, is_plain: true, periodic: [false; 3] }
}

fn links(case: &Case, job: &LinksJob, inverted: &[bool]) -> Links {
    let (frame, kinds) = kinds(case, inverted);
    let rays = Rays::new(0, case.lines.dims());
    let cast = hexcast_core::stages::cast::Cast { frame: &frame, rays: &rays, rule: case.rule };
    let columns = cpu::columns(&cast, &Control::default()).unwrap();
    let field = field(case, &frame, &kinds, &columns);
    pollster::block_on(field.links(job, u64::MAX, &Control::default())).unwrap()
}

/// Whether `q` is the fraction, off by less than 2^-24 of it, or 2^-126 for 0.
fn is_rounded(q: f32, up: &BigInt, of: &BigInt) -> bool {
    if up.sign() == Sign::NoSign {
        return q == f32::MIN_POSITIVE;
    }
    // |q of - up| 2^24 <= up (1 + 2^-20), q as an integer over 2^150
    let q = BigInt::from((f64::from(q) * 2f64.powi(75)) as u128) << 75;
    let exact: BigInt = up << 150;
    let off: BigInt = q * of - &exact;
    let least: BigInt = BigInt::from(off.magnitude().clone()) << 44;
    least <= exact * ((1 << 20) + 1)
}

fn assert_as_the_oracle(label: &str, case: &Case, job: &LinksJob, inverted: &[bool]) -> [usize; 2] {
    let expected = expected(case, job, inverted);
    let found = links(case, job, inverted);
    assert_eq!(found.len(), expected.len(), "{label}: number of links");
    let mut through = 0;
    let [nx, ny, _] = case.lines.dims();
    let place = |link: &Link| (link.cell[0] + nx * (link.cell[1] + ny * link.cell[2]), link.direction);
    assert!(found.iter().is_sorted_by(|one, other| place(one) < place(other)), "{label}: order");
    for link in found.iter() {
        let Some(known) = expected.get(&(link.cell, link.direction)) else { panic!("{label}: no such link: {link:?}") };
        assert!(is_rounded(link.q, &known.up, &known.of), "{label}: {link:?}, q is {} / {}", known.up, known.of);
        assert_eq!(link.flag, known.flag, "{label}: {link:?}");
        let facet = [link.geometry as usize, link.facet as usize];
        assert!(known.facets.contains(&facet), "{label}: {link:?}, facets {:?}", known.facets);
        through += usize::from(job.fluid.contains(&link.flag));
    }
    [found.len(), through]
}

fn all_directions() -> LinksJob {
    set!(LinksJob { stencil: Stencil::D3Q27, ..LinksJob::default() })
}

#[test]
fn links_of_soups_are_those_of_the_oracle() {
    let mut n = [0; 2];
    for seed in 7000..7060 {
        let (case, mut random) = (soup(seed), Random::new(seed));
        if !oracle::is_closed(&case.geometries, &case.lines, case.rule) || case.lines.n_cells() > 700 {
            continue;
        }
        let mut fluid = vec![0];
        fluid.extend(case.geometries.iter().map(|geometry| geometry.flag).filter(|_| random.below(4) == 0));
        let inverted: Vec<bool> = case.geometries.iter().map(|_| random.below(5) == 0).collect();
        let job = set!(LinksJob { fluid, ..all_directions() });
        let more = assert_as_the_oracle(&format!("seed {seed}"), &case, &job, &inverted);
        n = [0, 1].map(|of| n[of] + more[of]);
    }
    assert!(n[0] > 5000 && n[1] > 100, "{n:?} links, and links through walls");
}

#[test]
fn links_of_small_cases_are_those_of_the_oracle() {
    let mut n_cases = 0;
    for case in cases() {
        let work = case.lines.n_cells() as usize * case.n_facets();
        if work > 6000 || !oracle::is_closed(&case.geometries, &case.lines, case.rule) {
            continue;
        }
        assert_as_the_oracle(&case.name, &case, &all_directions(), &vec![false; case.geometries.len()]);
        n_cases += 1;
    }
    assert!(n_cases > 20, "{n_cases} cases");
}

#[test]
fn links_over_faces_of_cells_that_differ_in_size_are_those_of_the_oracle() {
    let mut n = 0;
    for seed in 7100..7130 {
        let mut case = soup(seed);
        let lists = [0, 1, 2].map(|axis| {
            let all = case.lines.list(axis);
            let last = all.len() - 1;
            let kept = all.into_iter().enumerate().filter(|(index, _)| *index == 0 || *index == last || index % 3 != 1);
            kept.map(|(_, line)| line).collect::<Vec<f64>>()
        });
        case.lines = hexcast::lines::Lines::from_lists(lists).unwrap();
        if !oracle::is_closed(&case.geometries, &case.lines, case.rule) {
            continue;
        }
        let job = set!(LinksJob { stencil: Stencil::D3Q7, ..LinksJob::default() });
        n += assert_as_the_oracle(&format!("seed {seed}"), &case, &job, &vec![false; case.geometries.len()])[0];
    }
    assert!(n > 200, "{n} links");
}

#[test]
fn diagonal_links_need_equal_cells() {
    let mut case =
        several("box", "", unit_cells([4; 3]), vec![Geometry::new("g", 1, models::cube([1.0; 3], 2.0)).unwrap()]);
    case.lines = hexcast::lines::Lines::from_lists([vec![0.0, 1.0, 4.0], vec![0.0, 2.0], vec![0.0, 2.0]]).unwrap();
    let (frame, kinds) = kinds(&case, &[false]);
    let rays = Rays::new(0, case.lines.dims());
    let cast = hexcast_core::stages::cast::Cast { frame: &frame, rays: &rays, rule: case.rule };
    let columns = cpu::columns(&cast, &Control::default()).unwrap();
    let field = field(&case, &frame, &kinds, &columns);
    let refused = pollster::block_on(field.links(&LinksJob::default(), u64::MAX, &Control::default())).unwrap_err();
    assert_eq!(refused.code(), "lines-graded");
}

/// Of a plane between two centres every direction has the same q.
#[test]
fn the_links_of_a_box_are_known() {
    let facets = models::cuboid([2.25, -9.0, -9.0], [99.0, 99.0, 99.0]);
    let case = several("half", "", unit_cells([4, 3, 3]), vec![Geometry::new("g", 3, facets).unwrap()]);
    let found = links(&case, &all_directions(), &[false]);
    // of 9 cells before the wall, the neighbours beyond it that lie in the box
    assert_eq!(found.len(), 49);
    assert!(found.iter().all(|link| link.q == 0.75 && link.flag == 3 && link.cell[0] == 1 && link.geometry == 0));
}

#[test]
fn links_that_exceed_the_memory_are_refused() {
    let case =
        several("ball", "", unit_cells([9; 3]), vec![Geometry::new("g", 1, models::sphere([4.5; 3], 3.0, 8)).unwrap()]);
    let (frame, kinds) = kinds(&case, &[false]);
    let rays = Rays::new(0, case.lines.dims());
    let cast = hexcast_core::stages::cast::Cast { frame: &frame, rays: &rays, rule: case.rule };
    let columns = cpu::columns(&cast, &Control::default()).unwrap();
    let field = field(&case, &frame, &kinds, &columns);
    let refused = pollster::block_on(field.links(&LinksJob::default(), 1000, &Control::default())).unwrap_err();
    assert_eq!(refused.code(), "memory");
}
