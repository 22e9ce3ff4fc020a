//! What is measured at surfaces in windows: that of the whole box, bit for bit, in each cell.

use std::collections::BTreeMap;

use hexcast::error::Result;
use hexcast::fractions::{CutSurface, Fraction, Fractions};
use hexcast::geometry::Fill;
use hexcast::job::{FractionsJob, GeometryJob, Job, LinesJob, LinksJob, Stencil};
use hexcast::lines::Lines;
use hexcast::links::Link;
use hexcast::pipeline::Engine;
use hexcast::report::MeshFacts;

use super::models::{self, Facets};
use super::open_surfaces::{flags_of, meshed};
use super::oracle;
use super::soups::{Random, soup};

/// Windows that divide a box at random places.
fn windows(dims: [u32; 3], random: &mut Random) -> Vec<[u32; 6]> {
    let cuts = dims.map(|n| if n == 1 { vec![0, n] } else { vec![0, random.between(1, n as i32 - 1) as u32, n] });
    let mut windows = Vec::new();
    for k in cuts[2].windows(2) {
        for j in cuts[1].windows(2) {
            windows.extend(cuts[0].windows(2).map(|i| [i[0], j[0], k[0], i[1], j[1], k[1]]));
        }
    }
    windows
}

/// Fractions of a flag: of a cell, its faces and edges, and the centre of its part of the cell.
type OfFlag = (f32, [f32; 6], [f32; 12], [f32; 3]);

/// What is measured in a mesh, by cells as the box counts them.
#[derive(Debug, Default, PartialEq)]
struct Measured {
    links: BTreeMap<([i32; 3], u8), Link>,
    fractions: BTreeMap<([i32; 3], u8), OfFlag>,
    surfaces: BTreeMap<([i32; 3], i16), CutSurface>,
}

fn in_box(cell: [u32; 3], origin: [i32; 3]) -> [i32; 3] {
    [0, 1, 2].map(|axis| cell[axis] as i32 + origin[axis])
}

impl Measured {
    /// Takes in what is known of a mesh, none of it twice.
    fn add(&mut self, facts: &MeshFacts) {
        for link in facts.links.iter().flat_map(|links| links.iter().map(|link| (links.origin, *link))) {
            let (origin, link) = link;
            let place = (in_box(link.cell, origin), link.direction);
            assert!(self.links.insert(place, set!(Link { cell: [0; 3], ..link })).is_none(), "twice: {link:?}");
        }
        let Some(fractions) = &facts.fractions else { return };
        let cell = |index: u64| {
            let [nx, ny, _] = fractions.dims.map(u64::from);
            in_box([index % nx, index / nx % ny, index / (nx * ny)].map(|at| at as u32), fractions.origin)
        };
        let (mut faces, mut edges, mut centroids) = (fractions.faces(), fractions.edges(), fractions.centroids());
        for &Fraction { cell: index, flag, fraction, .. } in fractions.iter() {
            let of_faces = if fractions.has_faces { *faces.next().expect("one for each") } else { [0.0; 6] };
            let of_edges = if fractions.has_edges { *edges.next().expect("one for each") } else { [0.0; 12] };
            let centroid = if fractions.has_centroids { *centroids.next().expect("one for each") } else { [0.0; 3] };
            assert!(self.fractions.insert((cell(index), flag), (fraction, of_faces, of_edges, centroid)).is_none());
        }
        for surface in fractions.surfaces() {
            let place = (cell(surface.cell), surface.geometry);
            let mut of_cell = *surface;
            of_cell.cell = 0;
            assert!(self.surfaces.insert(place, of_cell).is_none());
        }
    }
}

fn assert_windows_are_the_whole(label: &str, bodies: &[Facets], job: &Job, random: &mut Random) -> Measured {
    let (mesh, facts) = meshed(bodies, job, 0, &mut Engine::cpu()).unwrap();
    let mut whole = Measured::default();
    whole.add(&facts);
    let windows = windows(mesh.dims(), random);
    let (mut parts, mut volumes, mut areas) = (Measured::default(), vec![0.0; 256], vec![0.0; bodies.len()]);
    for (index, window) in windows.iter().enumerate() {
        let job = set!(Job { window: Some(*window), ..job.clone() });
        let (_, facts) = meshed(bodies, &job, index % 3, &mut Engine::cpu()).unwrap();
        parts.add(&facts);
        if let Some(Fractions { volumes: of_window, areas: of_geometries, .. }) = &facts.fractions {
            volumes.iter_mut().zip(of_window).for_each(|(sum, more)| *sum += more);
            areas.iter_mut().zip(of_geometries.iter().flatten()).for_each(|(sum, more)| *sum += more);
        }
    }
    assert!(parts == whole, "{label}: {windows:?}");
    if let Some(fractions) = &facts.fractions {
        let is_near = |one: &f64, other: &f64| (one - other).abs() <= 1e-9 * other.abs().max(1e-9);
        assert!(volumes.iter().zip(&fractions.volumes).all(|(one, other)| is_near(one, other)), "{label}: volumes");
        let whole = fractions.areas.iter().flatten();
        assert!(areas.iter().zip(whole).all(|(one, other)| is_near(one, other)), "{label}: areas");
    }
    parts
}

/// A job and bodies of a soup.
fn job_of(seed: u64) -> Option<(Vec<Facets>, Job, Random)> {
    let (case, random) = (soup(seed), Random::new(seed));
    if !oracle::is_closed(&case.geometries, &case.lines, case.rule) {
        return None;
    }
    let geometries = case
        .geometries
        .iter()
        .map(|of| set!(GeometryJob { flag: Some(of.flag), priority: of.priority, ..GeometryJob::default() }));
    let list = |axis: usize| case.lines.list(axis);
    let bodies = case.geometries.iter().map(|of| of.facets.slice().to_vec()).collect();
    let lines = Some(LinesJob { x: list(0), y: list(1), z: list(2) });
    let geometries = geometries.collect();
    Some((bodies, set!(Job { lines, rule: case.rule, geometries, ..Job::default() }), random))
}

#[test]
fn links_and_fractions_of_windows_are_those_of_the_whole() {
    let mut n = [0; 3];
    for seed in 7200..7260 {
        let Some((bodies, mut job, mut random)) = job_of(seed) else { continue };
        let stencil = if seed % 3 == 0 { Stencil::D3Q7 } else { Stencil::D3Q27 };
        if seed % 3 == 0 {
            // cells that differ in size
            let lists = job.lines.as_mut().expect("they are listed");
            for list in [&mut lists.x, &mut lists.y, &mut lists.z] {
                let last = list.len() - 1;
                let mut index = 0;
                list.retain(|_| (index == 0 || index == last || index % 3 != 1, index += 1).0);
            }
        }
        job.links = Some(set!(LinksJob { stencil, ..LinksJob::default() }));
        let is_exact = seed % 2 == 0;
        job.fractions = Some(set!(FractionsJob {
            rays: (!is_exact).then_some(2),
            faces: true,
            surfaces: true,
            edges: is_exact,
            centroids: is_exact,
            ..FractionsJob::default()
        }));
        let found = assert_windows_are_the_whole(&format!("seed {seed}"), &bodies, &job, &mut random);
        n = [n[0] + found.links.len(), n[1] + found.fractions.len(), n[2] + found.surfaces.len()];
    }
    assert!(n[0] > 3000 && n[1] > 1000 && n[2] > 1000, "{n:?} links, fractions, surfaces");
}

#[test]
fn links_of_windows_at_surfaces_that_rays_do_not_decide_are_those_of_the_whole_with_a_halo_and_without() {
    let ball = models::sphere([4.3, 4.6, 5.1], 3.2, 10);
    let holed: Facets = ball.iter().enumerate().filter(|(index, _)| index % 9 != 4).map(|(_, facet)| *facet).collect();
    let thin = models::cuboid([0.2, 6.1, 0.3], [9.8, 6.3, 9.1]);
    let geometries = vec![
        set!(GeometryJob { flag: Some(3), ..GeometryJob::default() }),
        set!(GeometryJob { flag: Some(7), fill: Some(Fill::Separating), ..GeometryJob::default() }),
    ];
    let job = set!(Job {
        dims: Some([10; 3]),
        domain: Some([0.0, 0.0, 0.0, 10.0, 10.0, 10.0]),
        geometries,
        links: Some(set!(LinksJob { stencil: Stencil::D3Q27, ..LinksJob::default() })),
        halo: None,
        ..Job::default()
    });
    let bodies = [holed, thin];
    let (_, facts) = meshed(&bodies, &job, 0, &mut Engine::cpu()).unwrap();
    let mut whole = Measured::default();
    whole.add(&facts);
    let without = whole.links.values().filter(|link| link.facet < 0).count();
    assert!(whole.links.len() > 800 && without > 10, "{} links, {without} without a facet", whole.links.len());
    let mut parts = Measured::default();
    for (index, window) in windows([10; 3], &mut Random::new(3)).into_iter().enumerate() {
        let job = set!(Job { window: Some(window), ..job.clone() });
        let halo = [None, Some(1), Some(2)][index % 3];
        let (mesh, facts) = meshed(&bodies, &set!(Job { halo, ..job }), index % 3, &mut Engine::cpu()).unwrap();
        assert_eq!(facts.links.as_ref().map(|links| links.dims), Some(mesh.dims()));
        parts.add(&facts);
    }
    assert!(parts == whole);
}

/// The flags of the points of a component, and the faces of sheets, as the box counts them.
type Points = BTreeMap<(usize, [u32; 3]), u8>;

fn points(facts: &MeshFacts) -> (Points, Points) {
    let staggered = facts.staggered.as_ref().expect("it was asked for");
    let (mut points, at) = (Points::new(), staggered.origin);
    for (component, of) in staggered.points.iter().enumerate() {
        let [nx, ny, nz] = of.dims();
        let flags = of.flags(&[0..nx, 0..ny, 0..nz]).unwrap();
        let mut n_per_flag = [0; 256];
        flags.iter().for_each(|flag| n_per_flag[usize::from(*flag)] += 1);
        assert_eq!(n_per_flag, of.n_per_flag().unwrap());
        for (index, flag) in (0u32..).zip(flags) {
            let point = [index % nx + at[0], index / nx % ny + at[1], index / (nx * ny) + at[2]];
            points.insert((component, point), flag);
        }
    }
    let face = |of: [u32; 3]| [0, 1, 2].map(|axis| of[axis] + at[axis]);
    let sheets = staggered.sheets.iter().map(|of| ((usize::from(of.axis), face(of.face)), of.flag)).collect();
    (points, sheets)
}

#[test]
fn staggered_grids_of_windows_are_cut_out_of_that_of_the_whole() {
    let mut n = [0; 2];
    for seed in 7300..7330 {
        let Some((mut bodies, mut job, mut random)) = job_of(seed) else { continue };
        job.staggered = true;
        let lists = job.lines.as_ref().expect("they are listed");
        let lines = Lines::from_lists([lists.x.clone(), lists.y.clone(), lists.z.clone()]).unwrap();
        let ends = [0, 1, 2].map(|axis| [lines.line(axis, 0) as f32, lines.line(axis, lines.dims()[axis]) as f32]);
        // a sheet across the box, in a line as a rule
        let axis = seed as usize % 3;
        let at = lines.line(axis, lines.dims()[axis] / 2) as f32;
        let corner = |a: usize, b: usize| {
            let mut corner = [0.0; 3];
            (corner[axis], corner[(axis + 1) % 3], corner[(axis + 2) % 3]) =
                (at, ends[(axis + 1) % 3][a], ends[(axis + 2) % 3][b]);
            corner
        };
        bodies.push(vec![[corner(0, 0), corner(1, 0), corner(1, 1)], [corner(0, 0), corner(1, 1), corner(0, 1)]]);
        job.geometries.push(set!(GeometryJob { flag: Some(99), priority: 0, ..GeometryJob::default() }));
        let (mesh, facts) = meshed(&bodies, &job, 0, &mut Engine::cpu()).unwrap();
        let (whole, sheets) = points(&facts);
        for (index, window) in windows(mesh.dims(), &mut random).into_iter().enumerate() {
            let job = set!(Job { window: Some(window), ..job.clone() });
            let (cut, facts) = meshed(&bodies, &job, index % 3, &mut Engine::cpu()).unwrap();
            assert!(flags_of(&cut).len() < flags_of(&mesh).len() || window[3..] == mesh.dims());
            let (found, of_window) = points(&facts);
            let [first, end] = [[window[0], window[1], window[2]], [window[3], window[4], window[5]]];
            // a point on a line belongs to the cells on both sides
            let moved = |component: usize| hexcast::staggered::COMPONENTS[component].1;
            let is_in = |component: usize, point: &[u32; 3]| {
                (0..3).all(|axis| (first[axis]..end[axis] + u32::from(moved(component)[axis])).contains(&point[axis]))
            };
            let expected: Points =
                whole.iter().filter(|((of, point), _)| is_in(*of, point)).map(|(at, flag)| (*at, *flag)).collect();
            assert!(found == expected, "seed {seed}, {window:?}");
            // faces are moved as the points of H are
            let faces: Points =
                sheets.iter().filter(|((of, face), _)| is_in(3 + *of, face)).map(|(at, flag)| (*at, *flag)).collect();
            assert!(of_window == faces, "seed {seed}, {window:?}: sheets");
            n = [n[0] + found.len(), n[1] + faces.len()];
        }
    }
    assert!(n[0] > 10_000 && n[1] > 200, "{n:?} points and faces of sheets");
}

#[test]
fn what_a_window_cannot_have_is_refused() {
    let cube = [models::cube([1.0; 3], 2.0)];
    let refused = |job: Job| -> Result<()> { meshed(&cube, &job, 0, &mut Engine::cpu()).map(|_| ()) };
    let job = set!(Job { cells: Some(8), window: Some([0, 0, 0, 4, 4, 4]), halo: Some(1), ..Job::default() });
    let error = refused(set!(Job { staggered: true, ..job })).unwrap_err();
    assert_eq!(error.code(), "job-conflict", "{error}");
}
