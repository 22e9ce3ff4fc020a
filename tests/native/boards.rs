//! Boards and antennas of several kinds, made here: generated lines suit them as they come, with fewer cells than equal ones need.
//!
//! Lengths are in mm. Equal cells are given what suits them: on each axis the largest size, at most that of the generated lines, which
//! puts all ends within a twentieth of a cell of a line. Generated lines have all ends on lines, but for the edges of metal, which lie at
//! a third of a cell on purpose.

use hexcast::control::Control;
use hexcast::job::{GeometryJob, GradedJob, Job, Padding, PerAxis};
use hexcast::lines::lines;
use hexcast::pipeline::{Engine, MeshOptions, mesh, prepare};
use hexcast::sources::Source;
use hexcast_core::grid::domain::Domain;

use super::models::{Facets, cuboid, prism};

/// Copper of 35 micrometres.
const COPPER: f32 = 0.035;

struct Part {
    name: String,
    facets: Facets,
    is_metal: bool,
    min_cells: Option<u32>,
}

struct Board {
    name: &'static str,
    parts: Vec<Part>,
    max_size: f64,
    air: f64,
}

fn part(name: impl Into<String>, facets: Facets) -> Part {
    Part { name: name.into(), facets, is_metal: false, min_cells: None }
}

fn metal(name: impl Into<String>, facets: Facets) -> Part {
    Part { is_metal: true, ..part(name, facets) }
}

fn layer(name: impl Into<String>, facets: Facets, min_cells: u32) -> Part {
    Part { min_cells: Some(min_cells), ..part(name, facets) }
}

/// A sheet of copper on a board at a height.
fn sheet(name: impl Into<String>, [x0, y0, x1, y1]: [f32; 4], z: f32) -> Part {
    metal(name, cuboid([x0, y0, z], [x1, y1, z + COPPER]))
}

/// A round rod along z.
fn rod([x, y]: [f32; 2], radius: f32, [low, high]: [f32; 2]) -> Facets {
    let corner = |k: u32| {
        let (sine, cosine) = (k as f32 * std::f32::consts::TAU / 24.0).sin_cos();
        [x + radius * cosine, y + radius * sine]
    };
    prism(&(0..24).map(corner).collect::<Vec<[f32; 2]>>(), low, high)
}

fn boards() -> Vec<Board> {
    let substrate = |size: [f32; 2], height: f32| layer("substrate", cuboid([0.0; 3], [size[0], size[1], height]), 4);
    let ground = |size: [f32; 2]| part("ground", cuboid([0.0, 0.0, -COPPER], [size[0], size[1], 0.0]));
    let comb = (0..5u8).map(|k| {
        let x = 6.0 + 2.3 * f32::from(k);
        let y = if k % 2 == 0 { 2.0 } else { 3.2 };
        sheet(format!("finger {k}"), [x, y, x + 1.4, y + 14.0], 0.8)
    });
    let traces = (0..6u8).map(|k| {
        let y = 3.0 + 1.7 * f32::from(k);
        sheet(format!("trace {k}"), [0.0, y, 30.0, y + 0.31], 0.4)
    });
    let layers = [0.1f32, 0.25, 0.05, 0.4, 0.15, 0.3].iter().scan(0.0, |z, thick| {
        let low = *z;
        *z += thick;
        Some((low, *z))
    });
    let stack = layers
        .enumerate()
        .map(|(k, (low, high))| layer(format!("layer {k}"), cuboid([0.0, 0.0, low], [25.0, 18.0, high]), 2));
    let board = |name, max_size, air, parts: Vec<Part>| Board { name, parts, max_size, air };
    vec![
        board(
            "patch",
            2.0,
            20.0,
            vec![
                substrate([60.0, 60.0], 1.6),
                ground([60.0, 60.0]),
                sheet("patch", [11.4, 15.8, 48.6, 44.2], 1.6),
                sheet("feed", [28.5, 0.0, 31.5, 15.8], 1.6),
            ],
        ),
        board(
            "coupled lines",
            1.0,
            8.0,
            vec![
                substrate([40.0, 20.0], 0.8),
                ground([40.0, 20.0]),
                sheet("first line", [0.0, 8.3, 22.0, 9.45], 0.8),
                sheet("second line", [18.0, 9.8, 40.0, 10.95], 0.8),
            ],
        ),
        board("comb", 1.0, 6.0, [substrate([24.0, 20.0], 0.8), ground([24.0, 20.0])].into_iter().chain(comb).collect()),
        board(
            "stripline",
            1.0,
            4.0,
            [
                layer("board", cuboid([0.0; 3], [30.0, 17.0, 0.835]), 6),
                part("lower plane", cuboid([0.0, 0.0, -COPPER], [30.0, 17.0, 0.0])),
                part("upper plane", cuboid([0.0, 0.0, 0.835], [30.0, 17.0, 0.835 + COPPER])),
            ]
            .into_iter()
            .chain(traces)
            .collect(),
        ),
        board("dielectric stack", 1.5, 5.0, stack.collect()),
        board(
            "coax",
            0.5,
            1.0,
            vec![
                part("shield", rod([0.0; 2], 4.3, [0.0, 30.0])),
                part("dielectric", rod([0.0; 2], 3.6, [0.0, 30.0])),
                part("conductor", rod([0.0; 2], 1.05, [0.0, 30.0])),
            ],
        ),
        board(
            "horn",
            3.0,
            25.0,
            vec![
                part("guide", cuboid([-11.43, -5.08, -40.0], [11.43, 5.08, 0.0])),
                part("guide wall", cuboid([-12.7, -6.35, -41.27], [12.7, 6.35, 0.0])),
                part("flare", prism(&[[-35.0, -24.0], [35.0, -24.0], [35.0, 24.0], [-35.0, 24.0]], 0.0, 50.0)),
                part("flange", cuboid([-20.7, -20.7, -41.27], [20.7, 20.7, -37.0])),
            ],
        ),
        board(
            "dipole",
            4.0,
            40.0,
            vec![
                part("lower arm", rod([0.0; 2], 0.5, [-36.5, -0.4])),
                part("upper arm", rod([0.0; 2], 0.5, [0.4, 36.5])),
            ],
        ),
        board(
            "inverted F",
            2.0,
            15.0,
            vec![
                substrate([50.0, 30.0], 1.0),
                part("ground", cuboid([0.0, 0.0, -COPPER], [50.0, 22.0, 0.0])),
                sheet("arm", [4.0, 26.4, 27.0, 27.9], 1.0),
                sheet("short", [4.0, 22.0, 5.2, 26.4], 1.0),
                sheet("feed", [9.1, 22.0, 10.3, 26.4], 1.0),
            ],
        ),
        board(
            "via",
            0.6,
            3.0,
            vec![
                substrate([12.0, 12.0], 1.55),
                ground([12.0, 12.0]),
                sheet("trace", [0.0, 5.65, 6.0, 6.35], 1.55),
                part("barrel", rod([6.0; 2], 0.3, [-COPPER, 1.55 + COPPER])),
                part("pad", rod([6.0; 2], 0.55, [1.55, 1.55 + COPPER])),
            ],
        ),
    ]
}

fn job(board: &Board) -> Job {
    let geometry = |part: &Part| {
        set!(GeometryJob {
            name: Some(part.name.clone()),
            metal: part.is_metal,
            min_cells: part.min_cells,
            ..GeometryJob::new(format!("{}.stl", part.name))
        })
    };
    set!(Job {
        geometries: board.parts.iter().map(geometry).collect(),
        graded: Some(set!(GradedJob { min_size: Some(0.005), ..GradedJob::new(PerAxis::All(board.max_size)) })),
        padding: Some(Padding::Length(PerAxis::All(board.air))),
        unit: Some("mm".into()),
        ..Job::default()
    })
}

fn sources(board: &Board) -> Vec<Source> {
    let source = |part: &Part| Source::from_facets(format!("{}.stl", part.name), part.facets.clone()).unwrap();
    board.parts.iter().map(source).collect()
}

/// Cells of equal size that meet all ends nearly.
fn n_equal(board: &Board, domain: &Domain) -> u64 {
    let largest = (0..30).map(|k| board.max_size * 0.8f64.powi(k));
    let found = largest.filter_map(|size| {
        let job = set!(Job { max_cell_size: Some(size), graded: None, ..job(board) });
        lines(&job, domain).ok()
    });
    found.map(|lines| lines.n_cells()).min().expect("some size meets all ends")
}

#[test]
fn boards_and_antennas_need_no_edit_and_at_most_seven_tenths_of_the_cells() {
    let boards = boards();
    assert_eq!(boards.len(), 10);
    for board in boards {
        let name = board.name;
        let prepared = prepare(&job(&board), sources(&board)).unwrap_or_else(|error| panic!("{name}: {error}"));
        let [n, most] = [prepared.whole.n_cells(), n_equal(&board, &prepared.domain)];
        println!("{name}: {:?} = {n} cells, {most} equal ones; {:?}", prepared.whole.dims(), prepared.notices);
        assert!(10 * n <= 7 * most, "{name}: {n} cells, {most} equal ones");
        // edges of metal that others share lie on lines, and that is said; no end is off its line
        assert!(prepared.notices.iter().all(|notice| notice.code == "edge-on-line"), "{name}: {:?}", prepared.notices);
        for (axis, residuals) in hexcast::lines::residuals(&prepared.whole, &prepared.domain).iter().enumerate() {
            for residual in residuals {
                let off = residual.cells.abs();
                let is_edge = (off - 1.0 / 3.0).abs() < 1e-6;
                assert!(off == 0.0 || is_edge, "{name}, axis {axis}: {residual:?}");
            }
        }
    }
}

#[test]
fn boxes_of_a_stack_have_their_volume() {
    let board = boards().swap_remove(4);
    let (options, control) = (MeshOptions::default(), Control::default());
    let (job, mut engine) = (job(&board), Engine::cpu());
    let (_, facts) = pollster::block_on(mesh(&job, sources(&board), &options, &mut engine, &control)).unwrap();
    for flag in &facts.flags {
        let volume = facts.geometries[usize::from(flag.flag) - 1].mesh_volume;
        assert!((flag.volume / volume - 1.0).abs() < 1e-9, "{}: {} of {volume}", flag.name, flag.volume);
    }
    let grading = facts.grading.expect("cells differ");
    assert!(grading.ratio.iter().all(|ratio| *ratio <= 1.3 + 1e-9), "{:?}", grading.ratio);
    assert!(grading.courant_seconds.is_some());
}
