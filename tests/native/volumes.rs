//! The bound of the volume: never violated, by winding numbers at every centre in big integers, and not far from the error.

use hexcast::geometry::Geometry;
use hexcast::job::{GeometryJob, Job, Rule};
use hexcast::lines::Lines;
use hexcast::pipeline::Engine;
use hexcast::report::MeshFacts;
use hexcast_core::grid::frame::Frame;
use hexcast_core::grid::volume_bound::volume_bound;

use super::cases::cases;
use super::models::{self, Facets};
use super::open_surfaces::meshed;
use super::oracle;
use super::soups::{crumbs, soup};

/// Centres times facets that the oracle does in a fraction of a second.
const ORACLE_LIMIT: i64 = 400_000;

/// The error of the volume over its bound; None where it is too much for the oracle, or there is no volume.
fn error_over_bound(geometry: &Geometry, lines: &Lines) -> Option<f64> {
    let alone = std::slice::from_ref(geometry);
    if !oracle::is_closed(alone, lines, Rule::Nonzero) {
        return None;
    }
    let frame = Frame::new(alone, lines).expect("a frame");
    let corners = frame.facets.as_flattened();
    // centres of cells around the surface, also where the mesh has none
    let range = [0, 1, 2].map(|axis: usize| {
        let along = corners.iter().map(|corner| corner[axis] >> frame.fraction_bits);
        along.clone().min().unwrap_or(0) - 1..=along.max().unwrap_or(0) + 1
    });
    let n_cells: i64 = range.iter().map(|of_axis| i64::from(of_axis.end() - of_axis.start() + 1)).product();
    if n_cells * frame.facets.len() as i64 > ORACLE_LIMIT {
        return None;
    }
    let winding = oracle::sum_of_windings(geometry, lines, range);
    let of_cells = winding as f64 * lines.cell_volume().unwrap();
    let of_surface = models::signed_volume(geometry.facets.slice()) * geometry.world_from_file.determinant();
    let bound = volume_bound(&frame.facets, frame.fraction_bits, lines.cell_volume().unwrap(), of_surface.abs());
    let error = (of_cells - of_surface).abs();
    // both sums of volumes are in f64
    assert!(
        error <= bound + 1e-12 * of_surface.abs(),
        "{}: {of_cells} and {of_surface}: beyond {bound}",
        geometry.name
    );
    (error > 0.0).then_some(error / bound)
}

#[test]
fn no_case_and_no_soup_of_closed_bodies_is_beyond_the_bound() {
    let soups = (0..400).map(soup).chain((0..6).map(crumbs));
    let ratios: Vec<f64> = cases()
        .into_iter()
        .chain(soups)
        .flat_map(|case| {
            let ratio = |geometry: &Geometry| error_over_bound(geometry, &case.lines);
            case.geometries.iter().filter_map(ratio).collect::<Vec<f64>>()
        })
        .collect();
    assert!(ratios.len() > 300, "{} bodies had an error", ratios.len());
    // a bound that is never nearly reached could be smaller
    assert!(ratios.iter().any(|ratio| *ratio > 0.6), "{:?}", ratios.iter().copied().reduce(f64::max));
}

fn facts(facets: &Facets, job: &Job) -> MeshFacts {
    meshed(std::slice::from_ref(facets), job, 0, &mut Engine::cpu()).expect("a mesh").1
}

#[test]
fn reports_of_spheres_and_turned_boxes_keep_the_bound_which_shrinks_with_the_cells() {
    let mut last = f64::INFINITY;
    for cells in [8, 16, 32, 64, 128] {
        let job = |rotate: Option<[f64; 3]>| {
            set!(Job {
                geometries: vec![set!(GeometryJob { rotate, ..GeometryJob::default() })],
                cells: Some(cells),
                ..Job::default()
            })
        };
        let turned = Some([17.0, 38.0, 61.0]);
        for (facets, job) in [
            (models::sphere([0.3, 0.1, -0.2], 3.3, 48), job(None)),
            (models::cuboid([0.0; 3], [3.0, 1.0, 2.0]), job(turned)),
            (models::torus([0.0; 3], [3.0, 1.0], 24), job(turned)),
        ] {
            let report = facts(&facets, &job);
            let flag = &report.flags[0];
            let (bound, surface) = (flag.volume_bound.expect("closed"), flag.mesh_volume.expect("closed"));
            assert!((flag.volume - surface).abs() <= bound, "{cells} cells, {turned:?}: {flag:?}");
            // the areas seen along three axes are at most 3^(1/2) times the area, and this is half of them and little more
            let area: f64 = hexcast::surface::surface(&facets).area;
            let most = 0.5 * 3f64.sqrt() * area * report.spacing.unwrap()[0];
            assert!(bound < 1.35 * most, "{cells} cells: {bound} and {most}");
            if facets.len() == 12 {
                assert!(bound < 0.7 * last, "{bound} after {last}");
                last = bound;
            }
        }
    }
}

#[test]
fn there_is_no_bound_where_the_cells_are_not_those_within_the_surface() {
    let domain = Some([0.0, 0.0, 0.0, 8.0, 8.0, 8.0]);
    let body = models::cuboid([1.0; 3], [6.9; 3]);
    let job =
        |geometry: GeometryJob| set!(Job { geometries: vec![geometry], cells: Some(16), domain, ..Job::default() });
    let plain = GeometryJob::default;
    let compared = |facets: &Facets, geometry: GeometryJob| {
        let flag = facts(facets, &job(geometry)).flags.remove(0);
        assert_eq!(flag.volume_bound.is_some(), flag.mesh_volume.is_some());
        flag.volume_bound.is_some()
    };
    assert!(compared(&body, plain()));
    assert!(!compared(&body[1..].to_vec(), plain()), "open");
    assert!(!compared(&models::moved(&body, [4.0, 0.0, 0.0]), plain()), "cut by the domain");
    assert!(!compared(&body, set!(GeometryJob { shell: true, ..plain() })), "a shell");
    assert!(!compared(&body, set!(GeometryJob { invert: true, ..plain() })), "inverted");
    let mut turned = body;
    turned[0].swap(0, 1);
    assert!(!compared(&turned, plain()), "facets that do not agree: closed by parity, without a volume");
}
