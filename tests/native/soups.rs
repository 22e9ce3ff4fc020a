//! Random bodies thrown together: overlapping, touching, nested, degenerate, with corners on centres and lines.
//!
//! Everything follows from a seed by integer arithmetic, so a seed is the same soup on every machine.

use hexcast::geometry::{Facet, Geometry};
use hexcast::lines::Lines;
use hexcast_core::stages::map::Rule;

use super::cases::Case;
use super::models::{self, Facets};

/// A small generator of uniform 64-bit numbers (SplitMix64, Steele, Lea and Flood 2014).
#[derive(Debug, Clone)]
pub(crate) struct Random(u64);

impl Random {
    /// Starts from a seed.
    pub(crate) fn new(seed: u64) -> Random {
        Random(seed)
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number from 0 to `n - 1`; the bias of the remainder does not matter here.
    pub(crate) fn below(&mut self, n: u64) -> u64 {
        self.next() % n
    }

    /// A number from `low` to `high`, both inclusive.
    pub(crate) fn between(&mut self, low: i32, high: i32) -> i32 {
        low + self.below((high - low + 1) as u64) as i32
    }

    /// One of several.
    pub(crate) fn one_of<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[self.below(choices.len() as u64) as usize]
    }

    /// Shuffles in place (Fisher and Yates).
    pub(crate) fn shuffle<T>(&mut self, items: &mut [T]) {
        for i in (1..items.len()).rev() {
            items.swap(i, self.below(i as u64 + 1) as usize);
        }
    }
}

/// A closed body made of four points.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Body {
    /// The tetrahedron of the four points; often flat or a needle.
    Tetrahedron,
    /// The box of the first two points; often without thickness.
    Cuboid,
    /// The octahedron in the box of the first two points.
    Octahedron,
    /// The triangle of the first three points pushed along the fourth.
    Wedge,
    /// A prism along an axis over a four-cornered polygon, often concave or crossing itself: slopes of zero along the axis.
    Prism(usize),
}

/// All kinds of bodies.
pub(crate) const BODIES: [Body; 7] =
    [Body::Tetrahedron, Body::Cuboid, Body::Octahedron, Body::Wedge, Body::Prism(0), Body::Prism(1), Body::Prism(2)];

/// Makes the body of four points.
pub(crate) fn body(kind: Body, points: [[f32; 3]; 4]) -> Facets {
    let [a, b, c, d] = points;
    let low = std::array::from_fn(|axis| a[axis].min(b[axis]));
    let high = std::array::from_fn(|axis| a[axis].max(b[axis]));
    match kind {
        Body::Tetrahedron => models::tetrahedron(points),
        Body::Cuboid => models::cuboid(low, high),
        Body::Octahedron => models::octahedron(low, high),
        Body::Wedge => models::wedge([a, b, c], std::array::from_fn(|axis| d[axis] - a[axis])),
        Body::Prism(axis) => {
            // made upright, then the axes go round until z is the axis of the prism
            let upright = points.map(|mut point| {
                point.rotate_left((axis + 1) % 3);
                point
            });
            let [low, high] = [upright[0][2].min(upright[2][2]), upright[0][2].max(upright[2][2])];
            let facets = models::prism(&upright.map(|[x, y, _]| [x, y]), low, high);
            models::outwards(models::mapped(&facets, |mut corner| {
                corner.rotate_right((axis + 1) % 3);
                corner
            }))
        }
    }
}

/// Shuffles the facets of a surface and where each facet starts. What is inside does not change.
pub(crate) fn shuffled(mut facets: Vec<Facet>, random: &mut Random) -> Facets {
    random.shuffle(&mut facets);
    for facet in &mut facets {
        facet.rotate_left(random.below(3) as usize);
    }
    facets
}

/// Makes the soup of a seed: one to four geometries of one to three bodies over a small domain.
///
/// Corners stand on multiples of a step of 1, 1/2, 1/4 or 1/32 cell, or anywhere; steps of 1/2 hit centres and lines most
/// of the time. They reach up to two cells out of the domain.
pub(crate) fn soup(seed: u64) -> Case {
    let mut random = Random::new(seed);
    let dims = [0; 3].map(|_: i32| random.between(1, 7) as u32);
    let spacing = random.one_of(&[[1.0; 3], [0.5, 2.0, 4.0], [0.1; 3], [1.0 / 3.0, 0.7, 0.01]]);
    let origin = random.one_of(&[[0.0; 3], [-3.0, 8.0, -64.0], [0.1, -0.2, 12.34]]);
    let lines = Lines::new(origin, spacing, dims).expect("sizes are positive");
    let mut geometries = Vec::new();
    for index in 0..random.one_of(&[1, 1, 2, 4]) {
        let mut facets = Vec::new();
        let steps_per_cell = random.one_of(&[1, 2, 2, 2, 4, 32, 1 << 20]);
        for _ in 0..random.between(1, 3) {
            let points = [[0; 3]; 4].map(|point: [i32; 3]| {
                let mut axis = 0;
                point.map(|_| {
                    let reach = 2 * steps_per_cell;
                    let steps = random.between(-reach, dims[axis] as i32 * steps_per_cell + reach);
                    let cells = f64::from(steps) / f64::from(steps_per_cell);
                    axis += 1;
                    (origin[axis - 1] + cells * spacing[axis - 1]) as f32
                })
            });
            let made = body(random.one_of(&BODIES), points);
            let turned = if random.below(4) == 0 { models::flipped(made) } else { made };
            facets.extend(turned);
        }
        let facets = shuffled(facets, &mut random);
        let mut geometry =
            Geometry::new(format!("soup {index}"), 1 + random.below(3) as u8 + 3 * index, facets).unwrap();
        geometry.priority = random.between(-1, 1);
        geometries.push(geometry);
    }
    let rule = random.one_of(&[Rule::Parity, Rule::Nonzero]);
    Case { name: format!("soup-{seed}"), why: "random bodies", geometries, lines, rule }
}

/// Makes the crumbs of a seed: bodies of a few units of the snap about centres, where a facet's height misses a centre by
/// less than a unit. A far body keeps the snap at 2^-8 cell, where such heights can be told apart only exactly.
pub(crate) fn crumbs(seed: u64) -> Case {
    let mut random = Random::new(seed);
    let dims = [5, 4, 6];
    let far = models::tetrahedron([[2e5, 3.0, 4.0], [2e5, 9.0, 4.0], [2e5, 3.0, 8.0], [2.1e5, 4.0, 5.0]]);
    let mut facets = far;
    for _ in 0..80 {
        let centre = dims.map(|n| random.below(n) as f32 + 0.5);
        let points = [[0; 3]; 4].map(|point: [i32; 3]| {
            let mut axis = 0;
            point.map(|_| {
                axis += 1;
                centre[axis - 1] + random.between(-5, 5) as f32 / 256.0
            })
        });
        facets.extend(body(random.one_of(&BODIES), points));
    }
    let lines = Lines::new([0.0; 3], [1.0; 3], dims.map(|n| n as u32)).expect("sizes are positive");
    let geometry = Geometry::new("crumbs", 1, shuffled(facets, &mut random)).unwrap();
    Case { name: format!("crumbs-{seed}"), why: "near misses", geometries: vec![geometry], lines, rule: Rule::Parity }
}

/// Makes the stack of a seed: bodies across a few rays, one above the other or through each other, with up to some 5,000 crossings a
/// ray; one to forty geometries, either rule.
#[cfg(feature = "gpu")]
pub(crate) fn stack(seed: u64) -> Case {
    let mut random = Random::new(seed);
    let dims = [random.between(1, 4), random.between(1, 4), random.one_of(&[5, 40, 300, 3000])];
    let n_bodies = random.one_of(&[3, 30, 200, 700, 4000]);
    let n_geometries = random.one_of(&[1, 2, 40]);
    let mut bodies = vec![Vec::new(); n_geometries];
    for _ in 0..random.between(1, n_bodies) {
        // low and high corners in eighths of a cell, so that many faces go through centres
        let low = random.between(-8, 8 * dims[2]);
        let high = low + random.between(1, 40);
        let across = [0, 1].map(|axis| [random.between(-8, 4), random.between(4, 8 * dims[axis] + 8)]);
        let corner = |side: usize, z: i32| [across[0][side], across[1][side], z].map(|eighths| eighths as f32 / 8.0);
        let tilted = [corner(0, low), corner(1, high), corner(0, high), corner(1, low)];
        let made = body(random.one_of(&[Body::Cuboid, Body::Cuboid, Body::Octahedron, Body::Tetrahedron]), tilted);
        let turned = if random.below(4) == 0 { models::flipped(made) } else { made };
        bodies[random.below(n_geometries as u64) as usize].extend(turned);
    }
    let geometry = |(index, facets)| Geometry::new(format!("stack {index}"), 1 + (index % 7) as u8, facets).unwrap();
    let geometries = bodies.into_iter().enumerate().map(geometry).collect();
    let lines = Lines::new([0.0; 3], [1.0; 3], dims.map(|n| n as u32)).expect("sizes are positive");
    let rule = random.one_of(&[Rule::Parity, Rule::Nonzero]);
    Case { name: format!("stack-{seed}"), why: "many crossings a ray", geometries, lines, rule }
}

/// Some of the lines of equal cells, with the first and the last: cells differ in size, and centres still meet corners.
pub(crate) fn thinned(lines: &Lines, random: &mut Random) -> Lines {
    let kept = |axis: usize| {
        let list = lines.list(axis);
        let last = list.len() - 1;
        let mut is_kept = |index: usize| index == 0 || index == last || random.below(3) > 0;
        let places: Vec<usize> = (0..=last).filter(|&index| is_kept(index)).collect();
        places.into_iter().map(|index| list[index]).collect::<Vec<f64>>()
    };
    Lines::from_lists([0, 1, 2].map(kept)).unwrap()
}

/// Lines anywhere over the same box.
pub(crate) fn anywhere(lines: &Lines, random: &mut Random) -> Lines {
    let list = |axis: usize| {
        let [low, high] = [lines.line(axis, 0), lines.line(axis, lines.dims()[axis])];
        let inner = (0..random.below(6)).map(|_| low + (high - low) * random.below(4001) as f64 / 4000.0);
        let mut list: Vec<f64> = inner.chain([low, high]).collect();
        list.sort_by(f64::total_cmp);
        list.dedup();
        list
    };
    Lines::from_lists([0, 1, 2].map(list)).unwrap()
}
