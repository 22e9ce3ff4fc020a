//! Plates, geometries without thickness, against their rectangles: which faces of cells they are, in whole boxes and in windows.

use hexcast::control::Control;
use hexcast::cut::cut;
use hexcast::job::{Fill, GeometryJob, Job, LinesJob};
use hexcast::pipeline::Engine;
use hexcast::staggered::SheetFace;

use super::models::{self, Facets};
use super::open_surfaces::meshed;
use super::soups::Random;

/// A rectangle across an axis, from corner to corner of the two other axes in their order.
fn rectangle(axis: usize, at: f32, [low, high]: [[f32; 2]; 2]) -> Facets {
    let corner = |[u, v]: [f32; 2]| {
        let mut corner = [at; 3];
        let [first, second] = [[1, 2], [0, 2], [0, 1]][axis];
        (corner[first], corner[second]) = (u, v);
        corner
    };
    let [a, b, c, d] = [low, [high[0], low[1]], high, [low[0], high[1]]].map(corner);
    vec![[a, b, c], [a, c, d]]
}

fn list(n: usize, sizes: &[f64]) -> Vec<f64> {
    let step = |line: &mut f64, cell: usize| {
        *line += sizes[cell % sizes.len()];
        Some(*line)
    };
    [0.0].into_iter().chain((0..n).scan(0.0, step)).collect()
}

#[test]
fn the_faces_of_a_plate_are_those_between_whose_cells_it_lies() {
    let (mut n_faces, mut n_covered) = (0, 0);
    for seed in 0..60u64 {
        let mut random = Random::new(seed);
        let sizes: &[f64] = if seed % 2 == 0 { &[1.0] } else { &[0.5, 1.0, 0.75] };
        let lines = [10, 9, 11].map(|n| list(n, sizes));
        let axis = seed as usize % 3;
        // no place is that of a centre
        let mut place = |most: f64| (random.below((most * 64.0) as u64) as f32 + 0.37) / 64.0;
        let [first, second] = [[1, 2], [0, 2], [0, 1]][axis];
        let ends = [first, second, axis].map(|of| lines[of][lines[of].len() - 1]);
        let corners = [[place(ends[0]), place(ends[1])], [place(ends[0]), place(ends[1])]];
        let [low, high] = [f32::min as fn(f32, f32) -> f32, f32::max]
            .map(|pick| [0, 1].map(|of| pick(corners[0][of], corners[1][of])));
        let at = place(ends[2]);
        let solid = ([0.6f32, 0.7, 0.8], [4.1f32, 5.2, 6.3]);
        let bodies = [rectangle(axis, at, [low, high]), models::cuboid(solid.0, solid.1)];
        let priority = [0, -1][seed as usize / 2 % 2];
        let geometries = vec![GeometryJob::default(), set!(GeometryJob { priority, ..GeometryJob::default() })];
        let [x, y, z] = lines.clone();
        let job = set!(Job { geometries, lines: Some(LinesJob { x, y, z }), ..Job::default() });
        let (mesh, facts) = meshed(&bodies, &job, seed as usize / 3 % 3, &mut Engine::cpu()).unwrap();
        let centre = |of: usize, cell: usize| (lines[of][cell] + lines[of][cell + 1]) / 2.0;
        let (mut expected, mut covered) = (Vec::new(), 0);
        let n = [0, 1, 2].map(|of| lines[of].len() - 1 + usize::from(of == axis));
        for (k, j) in (0..n[2]).flat_map(|k| (0..n[1]).map(move |j| (k, j))) {
            for i in 0..n[0] {
                let face = [i, j, k];
                let beside = [face[axis].saturating_sub(1), face[axis].min(lines[axis].len() - 2)];
                let below = if face[axis] == 0 { f64::NEG_INFINITY } else { centre(axis, beside[0]) };
                let above = if face[axis] == lines[axis].len() - 1 { f64::INFINITY } else { centre(axis, beside[1]) };
                let within = [(first, 0), (second, 1)]
                    .iter()
                    .all(|&(of, to)| (f64::from(low[to])..f64::from(high[to])).contains(&centre(of, face[of])));
                if !within || !(below..above).contains(&f64::from(at)) {
                    continue;
                }
                let is_covered = beside.iter().all(|&cell| {
                    let mut place = [0, 1, 2].map(|of| if of == axis { 0.0 } else { centre(of, face[of]) });
                    place[axis] = centre(axis, cell);
                    (0..3).all(|of| (f64::from(solid.0[of])..f64::from(solid.1[of])).contains(&place[of]))
                });
                // the solid is the later one
                if is_covered && priority == 0 {
                    covered += 1;
                } else {
                    expected.push(SheetFace::new(axis as u8, face.map(|at| at as u32), 1));
                }
            }
        }
        assert_eq!(mesh.plates(), expected, "seed {seed}");
        let found = facts.findings.iter().filter(|finding| finding.code == "plate-covered").count();
        assert_eq!(found, usize::from(covered > 0), "seed {seed}: {:?}", facts.findings);
        n_faces += expected.len();
        n_covered += covered;

        // a window has those in its cells, with a halo those of that, too
        let halo = (seed % 3) as u32;
        let window = set!(Job { window: Some([2, 1, 3, 8, 9, 9]), halo: Some(halo), ..job.clone() });
        let (part, _) = meshed(&bodies, &window, 0, &mut Engine::cpu()).unwrap();
        let ends = [[2, 1, 3], [8, 9, 9]];
        let moved = |of: &SheetFace| {
            let mut face = [0; 3];
            for (to, place) in face.iter_mut().enumerate() {
                let start = ends[0][to] as i64 - i64::from(halo);
                // beyond the box there are no cells to have one
                let low = start.max(0);
                let high = (ends[1][to] as i64 + i64::from(halo)).min(lines[to].len() as i64 - 1);
                let at = i64::from(of.face[to]);
                if at < low || at >= high + i64::from(to == axis) {
                    return None;
                }
                *place = (at - start) as u32;
            }
            Some(SheetFace::new(of.axis, face, of.flag))
        };
        assert_eq!(part.plates(), expected.iter().filter_map(moved).collect::<Vec<_>>(), "seed {seed}, window");
        let cells = [2..8, 1..9, 3..9];
        let closer = cut(&mesh, &cells, [1; 3], u64::MAX, &Control::default()).unwrap();
        let of_cut = |of: &SheetFace| {
            let within = (0..3).all(|to| (ends[0][to]..ends[1][to] + u32::from(to == axis)).contains(&of.face[to]));
            within.then(|| SheetFace::new(of.axis, [0, 1, 2].map(|to| of.face[to] - ends[0][to]), of.flag))
        };
        assert_eq!(closer.plates(), expected.iter().filter_map(of_cut).collect::<Vec<_>>(), "seed {seed}, cut");
    }
    assert!(n_faces > 500 && n_covered > 30, "{n_faces} faces, {n_covered} covered");
}

#[test]
fn what_is_filled_inverted_or_closed_is_no_plate() {
    let lines = || list(8, &[1.0]);
    let job = |geometry: GeometryJob| {
        let lines = Some(LinesJob { x: lines(), y: lines(), z: lines() });
        set!(Job { geometries: vec![geometry], lines, ..Job::default() })
    };
    let plate = rectangle(2, 4.0, [[1.0, 1.0], [6.0, 5.0]]);
    let n = |body: &Facets, geometry: GeometryJob| {
        meshed(std::slice::from_ref(body), &job(geometry), 2, &mut Engine::cpu()).unwrap().0.plates().len()
    };
    assert_eq!(n(&plate, GeometryJob::default()), 20);
    assert_eq!(n(&plate, set!(GeometryJob { fill: Some(Fill::Separating), ..GeometryJob::default() })), 0);
    assert_eq!(n(&plate, set!(GeometryJob { invert: true, ..GeometryJob::default() })), 0);
    assert_eq!(n(&models::cuboid([1.0; 3], [5.0; 3]), GeometryJob::default()), 0);
}
