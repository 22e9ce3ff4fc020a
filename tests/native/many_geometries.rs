//! More than 255 geometries, of which several are known by one rank: against the exact oracle, and against what is said of each.

use hexcast::geometry::Geometry;
use hexcast::job::{BackendChoice, FractionsJob, GeometryJob, Job, LinksJob, Open, Rule};
use hexcast::lines::Lines;
use hexcast::links::Link;
use hexcast::pipeline::Engine;
use hexcast::report::MeshFacts;

use super::models::{self, Facets};
use super::open_surfaces::{flags_of, meshed};
use super::soups::{BODIES, Random, body};
use super::{compare, oracle};

const N_CELLS: u32 = 14;

/// Small bodies in a box of cells of size 1: corners on quarters of cells, so that boxes touch, overlap, and have corners on centres.
struct Crowd {
    parts: Vec<Facets>,
    job: Job,
}

impl Crowd {
    fn new(seed: u64, n: usize, rule: Rule) -> Crowd {
        let mut random = Random::new(seed);
        let (mut parts, mut geometries) = (Vec::new(), Vec::new());
        for _ in 0..n {
            let low = [0; 3].map(|_: i32| random.between(-4, 4 * N_CELLS as i32));
            let points = [[0; 3]; 4].map(|_: [i32; 3]| low.map(|low| (low + random.between(0, 9)) as f32 / 4.0));
            parts.push(body(random.one_of(&BODIES), points));
            let flag = random.one_of(&[1, 2, 9]);
            geometries.push(set!(GeometryJob {
                flag: Some(flag),
                priority: random.between(-1, 1),
                ..GeometryJob::default()
            }));
        }
        let side = f64::from(N_CELLS);
        let (dims, domain) = (Some([N_CELLS; 3]), Some([0.0, 0.0, 0.0, side, side, side]));
        Crowd { parts, job: set!(Job { dims, domain, rule, geometries, ..Job::default() }) }
    }

    fn expected(&self) -> Vec<u8> {
        let geometry = |(facets, of): (&Facets, &GeometryJob)| {
            let mut geometry = Geometry::new("", of.flag.unwrap(), facets.clone()).unwrap();
            geometry.priority = of.priority;
            geometry
        };
        let geometries: Vec<Geometry> = self.parts.iter().zip(&self.job.geometries).map(geometry).collect();
        oracle::flags(&geometries, &Lines::new([0.0; 3], [1.0; 3], [N_CELLS; 3]).unwrap(), self.job.rule)
    }

    fn check(&self, label: &str, engine: &mut Engine) {
        let expected = self.expected();
        for axis in 0..3 {
            let (mesh, facts) = meshed(&self.parts, &self.job, axis, engine).unwrap();
            compare::assert_same(&format!("{label}, axis {axis}"), &expected, &flags_of(&mesh), [N_CELLS; 3]);
            assert_eq!((facts.geometries.len(), facts.odd_rays), (self.parts.len(), 0));
        }
    }
}

#[test]
fn the_cells_are_those_of_the_oracle() {
    for (seed, n, rule) in
        [(1, 256, Rule::Parity), (2, 400, Rule::Nonzero), (3, 700, Rule::Parity), (4, 300, Rule::Nonzero)]
    {
        Crowd::new(seed, n, rule).check(&format!("{n} geometries, {rule:?}"), &mut Engine::cpu());
    }
}

#[test]
fn the_gpu_gives_the_same_cells() {
    let mut engine = pollster::block_on(Engine::open(BackendChoice::Gpu, None)).unwrap();
    for (seed, n, rule) in [(5, 300, Rule::Parity), (6, 500, Rule::Nonzero)] {
        Crowd::new(seed, n, rule).check(&format!("{n} geometries, {rule:?}, GPU"), &mut engine);
    }
}

#[test]
fn what_is_open_inverted_or_filled_keeps_its_place_among_them() {
    // 300 bodies in a row of the box, then one that takes all but itself, and bodies of a higher priority
    let mut crowd = Crowd::new(7, 300, Rule::Parity);
    let plain = crowd.expected();
    let block = models::cuboid([2.25; 3], [9.75; 3]);
    crowd.parts.push(block.clone());
    crowd.job.geometries.push(set!(GeometryJob { flag: Some(7), priority: 0, invert: true, ..GeometryJob::default() }));
    let (mesh, _) = meshed(&crowd.parts, &crowd.job, 0, &mut Engine::cpu()).unwrap();
    let over = Crowd { parts: crowd.parts[..300].to_vec(), job: crowd.job.clone() };
    // those of a higher priority alone
    let is_over = |index: &usize| crowd.job.geometries[*index].priority > 0;
    let indices: Vec<usize> = (0..300).filter(is_over).collect();
    let parts = indices.iter().map(|&index| over.parts[index].clone()).collect();
    let geometries = indices.iter().map(|&index| over.job.geometries[index].clone()).collect();
    let above = Crowd { parts, job: set!(Job { geometries, ..over.job.clone() }) }.expected();
    let n = N_CELLS as usize;
    let is_in_block = |cell: usize| [cell % n, cell / n % n, cell / n / n].iter().all(|&at| (2..10).contains(&at));
    let expected: Vec<u8> = (0..plain.len())
        .map(|cell| {
            if above[cell] != 0 {
                above[cell]
            } else if is_in_block(cell) {
                plain[cell]
            } else {
                7
            }
        })
        .collect();
    compare::assert_same("inverted", &expected, &flags_of(&mesh), [N_CELLS; 3]);
    // as a shell it has the cells along its surface only
    let last = crowd.job.geometries.pop().unwrap();
    crowd.job.geometries.push(set!(GeometryJob { invert: false, shell: true, ..last.clone() }));
    let (mesh, facts) = meshed(&crowd.parts, &crowd.job, 1, &mut Engine::cpu()).unwrap();
    let is_inner = |cell: usize| [cell % n, cell / n % n, cell / n / n].iter().all(|&at| (3..9).contains(&at));
    for (cell, flag) in
        flags_of(&mesh).into_iter().enumerate().filter(|(cell, _)| is_inner(*cell) || !is_in_block(*cell))
    {
        assert_eq!(flag, plain[cell], "cell {cell}");
    }
    assert_eq!((facts.filled.len(), &facts.filled[0].geometry[..]), (1, "300"));
    // an open one is found, and named
    let open = block[1..].to_vec();
    crowd.parts[300] = open;
    crowd.job.geometries[300] = set!(GeometryJob { flag: Some(7), priority: 2, ..GeometryJob::default() });
    let (mesh, facts) = meshed(&crowd.parts, &crowd.job, 2, &mut Engine::cpu()).unwrap();
    let expected: Vec<u8> = (0..plain.len()).map(|cell| if is_in_block(cell) { 7 } else { plain[cell] }).collect();
    compare::assert_same("open", &expected, &flags_of(&mesh), [N_CELLS; 3]);
    assert_eq!((facts.open.len(), &facts.open[0].geometry[..]), (1, "300"));
    crowd.job.geometries[300].open = Some(Open::Parity);
    let odd_rays = [0, 1, 2].map(|axis| {
        let (_, facts) = meshed(&crowd.parts, &crowd.job, axis, &mut Engine::cpu()).unwrap();
        assert!(facts.open.is_empty());
        facts.odd_rays
    });
    assert!(odd_rays.iter().sum::<u64>() > 0, "{odd_rays:?}");
}

#[test]
fn overlaps_thin_walls_and_shells_are_told_of_the_geometries_that_have_them() {
    // 17 x 17 blocks that lie apart, of which two overlap, one is thin, and one has two shells
    let mut parts: Vec<Facets> = (0..289)
        .map(|index| {
            let [x, y] = [index % 17, index / 17].map(|at| 2.0 * at as f32 + 0.25);
            models::cuboid([x, y, 1.0], [x + 1.5, y + 1.5, 4.0])
        })
        .collect();
    parts[40] = models::moved(&parts[41], [0.5, 0.0, 0.0]);
    parts[100] = models::mapped(&parts[100], |[x, y, z]| [x, y, if z > 2.0 { 1.6 } else { z }]);
    parts[200] = models::joined([parts[200].clone(), models::moved(&parts[200], [0.25, 0.25, 0.5])]);
    let geometries = vec![set!(GeometryJob { flag: Some(3), ..GeometryJob::default() }); 289];
    let domain = Some([0.0, 0.0, 0.0, 34.0, 34.0, 5.0]);
    let job = set!(Job { dims: Some([68, 68, 10]), domain, geometries, certify: true, ..Job::default() });
    let (_, facts) = meshed(&parts, &job, 0, &mut Engine::cpu()).unwrap();
    let certificate = facts.certificate.unwrap();
    let overlaps: Vec<[usize; 2]> = certificate.overlaps.iter().map(|of| of.indices).collect();
    assert_eq!(overlaps, [[41, 40]]);
    assert!(
        certificate.thin_walls.iter().any(|wall| (wall.index, wall.axis) == (100, "z")),
        "{:?}",
        certificate.thin_walls
    );
    // between the two shells parity leaves thin walls
    assert!(certificate.thin_walls.iter().all(|wall| [100, 200].contains(&wall.index)));
    let shells: Vec<&String> = facts.warnings.iter().filter(|text| text.contains("shells")).collect();
    assert!(shells.len() == 1 && shells[0].contains("\"200\""), "{:?}", facts.warnings);
    assert_eq!(facts.flags[0].name.split(" + ").count(), 65);
    assert!(facts.flags[0].name.ends_with(" + 225 more"), "{}", facts.flags[0].name);
}

#[test]
fn bricks_of_one_flag_that_touch_are_taken_together() {
    // also beside such of another flag
    let places = (0..512).map(|at| [at % 8, at / 8 % 8, at / 64].map(|at| 2.0 * at as f32));
    let bricks: Vec<Facets> = places.map(|low| models::cuboid(low, low.map(|at| at + 2.0))).collect();
    let of_layer = |at: usize| if at / 64 < 5 { 1 } else { 2 };
    let geometries = (0..512).map(|at| set!(GeometryJob { flag: Some(of_layer(at)), ..GeometryJob::default() }));
    let domain = Some([0.0, 0.0, 0.0, 16.0, 16.0, 16.0]);
    let job = set!(Job { dims: Some([16; 3]), domain, geometries: geometries.collect(), ..Job::default() });
    for axis in 0..3 {
        let (mesh, facts) = meshed(&bricks, &job, axis, &mut Engine::cpu()).unwrap();
        let expected: Vec<u8> = (0..4096).map(|cell| if cell / 256 < 10 { 1 } else { 2 }).collect();
        assert!(flags_of(&mesh) == expected && facts.odd_rays == 0, "axis {axis}: {:?}", facts.flags);
    }
}

#[test]
fn geometries_that_cannot_be_taken_together_are_refused_with_their_number() {
    let nested: Vec<Facets> =
        (0..256).map(|at| models::cuboid([0.01 * at as f32; 3], [10.0 - 0.01 * at as f32; 3])).collect();
    let geometries = vec![set!(GeometryJob { flag: Some(1), ..GeometryJob::default() }); 256];
    let job = set!(Job { geometries, cells: Some(10), ..Job::default() });
    let error = meshed(&nested, &job, 0, &mut Engine::cpu()).unwrap_err();
    assert_eq!(error.code(), "too-many-geometries");
    assert!(
        error.to_string().starts_with("256 geometries overlap so that a ray would have to tell more than 255 apart"),
        "{error}"
    );
    meshed(&nested[1..], &set!(Job { geometries: job.geometries[1..].to_vec(), ..job.clone() }), 0, &mut Engine::cpu())
        .unwrap();
    // links number them with 16 bits
    let many = vec![vec![[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]]; 32_769];
    let geometries = vec![set!(GeometryJob { flag: Some(1), ..GeometryJob::default() }); many.len()];
    let links = Some(LinksJob::default());
    let error = meshed(&many, &set!(Job { geometries, links, ..job }), 0, &mut Engine::cpu()).unwrap_err();
    assert_eq!(error.code(), "too-many-geometries");
    assert!(error.to_string().starts_with("there are 32769 geometries: links and fractions work with at most 32768"));
}

#[test]
fn what_is_measured_of_them_is_that_of_one_geometry_for_each_flag() {
    let at = |index: usize| [0, 1, 2].map(|axis: u32| 2.5 * (index / 8usize.pow(axis) % 8) as f32);
    let cubes: Vec<Facets> = (0..400).map(|index| models::cube(at(index), 1.75)).collect();
    let flag = |index: usize| 1 + (index % 3) as u8;
    let of_flag = |flag: u8| set!(GeometryJob { flag: Some(flag), ..GeometryJob::default() });
    let job = set!(Job {
        dims: Some([20; 3]),
        domain: Some([0.0, 0.0, 0.0, 20.0, 20.0, 20.0]),
        geometries: (0..400).map(|index| of_flag(flag(index))).collect(),
        links: Some(LinksJob::default()),
        fractions: Some(set!(FractionsJob { rays: Some(4), surfaces: true, ..FractionsJob::default() })),
        staggered: true,
        ..Job::default()
    });
    let of = |of: u8| cubes.iter().enumerate().filter(move |(index, _)| flag(*index) == of).map(|(_, cube)| cube);
    let joined = |flag: u8| of(flag).flatten().copied().collect::<Facets>();
    let three = [1, 2, 3].map(joined);
    let of_three = set!(Job { geometries: [1, 2, 3].map(of_flag).to_vec(), ..job.clone() });
    let (_, many) = meshed(&cubes, &job, 0, &mut Engine::cpu()).unwrap();
    let (_, few) = meshed(&three, &of_three, 0, &mut Engine::cpu()).unwrap();
    assert_eq!(many.flags_hash, few.flags_hash);
    // a cube is the cube / 3 of its flag, and has 12 facets
    let links = |of: &MeshFacts| of.links.clone().expect("they were asked for");
    let (many_links, few_links) = (links(&many), links(&few));
    assert!(many_links.len() > 2000 && many_links.len() == few_links.len());
    for (one, other) in many_links.iter().zip(few_links.iter()) {
        let (facet, geometry) = (12 * (i32::from(one.geometry) / 3) + one.facet, one.geometry % 3);
        assert_eq!(*other, set!(Link { facet: facet, geometry: geometry, ..*one }));
    }
    let (many_fractions, few_fractions) = (many.fractions.expect("asked for"), few.fractions.expect("asked for"));
    assert!(many_fractions.len() > 2000 && many_fractions.iter().eq(few_fractions.iter()));
    assert_eq!(many_fractions.volumes, few_fractions.volumes);
    let surfaces: Vec<_> = few_fractions.surfaces().collect();
    assert!(many_fractions.surfaces().count() >= surfaces.len());
    for area in [&many_fractions.areas, &few_fractions.areas] {
        let area: f64 = area.as_ref().expect("asked for").iter().sum();
        // all of 6 sides of each
        assert!((area - 400.0 * 6.0 * 1.75 * 1.75).abs() < 1e-6, "{area}");
    }
    assert_eq!(many_fractions.areas.as_ref().map(Vec::len), Some(400));
    let (many, few) = (many.staggered.expect("asked for"), few.staggered.expect("asked for"));
    for (one, other) in many.points.iter().zip(&few.points) {
        let all = one.dims().map(|n| 0..n);
        assert!(one.flags(&all).unwrap() == other.flags(&all).unwrap(), "{}", one.name);
    }
}

#[test]
fn a_window_has_the_cells_of_the_whole() {
    let crowd = Crowd::new(8, 400, Rule::Nonzero);
    let expected = crowd.expected();
    let job = set!(Job { window: Some([3, 2, 5, 12, 13, 9]), ..crowd.job.clone() });
    let (mesh, _) = meshed(&crowd.parts, &job, 0, &mut Engine::cpu()).unwrap();
    let n = N_CELLS as usize;
    let cells = (5..9).flat_map(|z| (2..13).flat_map(move |y| (3..12).map(move |x| x + n * (y + n * z))));
    let expected: Vec<u8> = cells.map(|cell| expected[cell]).collect();
    compare::assert_same("window", &expected, &flags_of(&mesh), [9, 11, 4]);
}
