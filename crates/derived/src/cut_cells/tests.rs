//! Sums, closure, agreement of neighbours, independence, and an oracle of exact fractions.

pub(super) mod models;
mod oracle;

use std::collections::HashMap;

use self::models::*;
use super::edges::{ACROSS, ends_of};
use super::*;
use hexcast_core::grid::lines::Lines;
use hexcast_core::grid::window::CellWindow;
use hexcast_core::input::job::Rule;
use hexcast_core::stages::inside::Kind;

/// A flag of a cell with all that was measured.
struct Row {
    of: CutFlag,
    faces: [f64; 6],
    face_centroids: [[f64; 2]; 6],
    edges: [f64; 12],
    centroid: [f64; 3],
}

fn rows(found: &CutCells) -> Vec<Row> {
    let n = found.flags().count();
    assert_eq!([found.faces().count(), found.edges().count(), found.centroids().count()], [n; 3]);
    let both = found.flags().zip(found.faces()).zip(found.edges()).zip(found.centroids()).zip(found.face_centroids());
    let row = |((((of, faces), edges), centroid), face_centroids): ((((&CutFlag, &_), &_), &_), &_)| Row {
        of: *of,
        faces: *faces,
        edges: *edges,
        centroid: *centroid,
        face_centroids: *face_centroids,
    };
    both.map(row).collect()
}

fn by_cell(rows: &[Row]) -> impl Iterator<Item = &[Row]> {
    rows.chunk_by(|one, other| one.of.cell == other.of.cell)
}

fn place(cell: u64, lines: &Lines) -> [u32; 3] {
    let [nx, ny, _] = lines.dims().map(u64::from);
    [cell % nx, cell / nx % ny, cell / (nx * ny)].map(|of| of as u32)
}

fn all_models() -> Vec<Model> {
    bodies().into_iter().chain(several().into_iter().map(|(model, _)| model)).collect()
}

const BOX: f64 = 1000.0;

#[test]
fn volumes_add_up_to_that_of_the_surface() {
    for lines in [equal(), graded()] {
        for model in bodies().iter().filter(|model| model.name != "ball beyond the box") {
            let found = model.measured(&lines);
            let off = found.volumes[7] - model.volume(0, &lines);
            assert!(off.abs() < 1e-12 * BOX, "{}: off by {off}", model.name);
            assert!((found.volumes[0] + found.volumes[7] - BOX).abs() < 1e-12 * BOX, "{}", model.name);
            assert_eq!(found.n_sampled, 0, "{}", model.name);
        }
        for (model, volumes) in several() {
            let found = model.measured(&lines);
            for (index, volume) in volumes.iter().enumerate() {
                let off = found.volumes[index + 1] - volume;
                assert!(off.abs() < 1e-12 * BOX, "{}: flag {} is off by {off}", model.name, index + 1);
            }
            assert_eq!(found.n_sampled, 0, "{}", model.name);
        }
    }
}

#[test]
fn areas_of_faces_and_of_the_surface_close() {
    for lines in [equal(), graded()] {
        for model in bodies() {
            let found = model.measured(&lines);
            let surfaces: HashMap<u64, CellSurface> = found.surfaces().map(|of| (of.cell, *of)).collect();
            let mut n_closed = 0;
            for row in rows(&found).iter().filter(|row| row.of.flag == 7) {
                let cell = place(row.of.cell, &lines);
                let size = [0, 1, 2].map(|axis| lines.cell_size(axis, cell[axis]));
                let vector = surfaces.get(&row.of.cell).map_or([0.0; 3], |of| of.area_vector);
                for axis in 0..3 {
                    let area = size[ACROSS[axis][0]] * size[ACROSS[axis][1]];
                    let off = (row.faces[2 * axis + 1] - row.faces[2 * axis]) * area + vector[axis];
                    assert!(off.abs() < 1e-12, "{}, cell {cell:?}: open by {off}", model.name);
                }
                n_closed += 1;
            }
            assert!(n_closed > 10, "{}", model.name);
        }
    }
}

#[test]
fn flags_of_cells_faces_and_edges_add_up_to_one() {
    for model in all_models() {
        let found = model.measured(&graded());
        let rows = rows(&found);
        for of_cell in by_cell(&rows) {
            let limit = 1e-15 * of_cell.len() as f64;
            let sum = |of: &dyn Fn(&Row) -> f64| of_cell.iter().map(of).sum::<f64>();
            let all = [sum(&|row| row.of.fraction)].into_iter();
            let all = all.chain((0..6).map(|face| sum(&|row| row.faces[face])));
            for (index, sum) in all.chain((0..12).map(|edge| sum(&|row| row.edges[edge]))).enumerate() {
                assert!((sum - 1.0).abs() <= limit, "{}: number {index} adds up to {sum}", model.name);
            }
        }
    }
}

#[test]
fn cells_agree_on_their_faces_and_edges_to_the_last_bit() {
    for lines in [equal(), graded()] {
        for model in all_models() {
            let found = model.measured(&lines);
            let (mut faces, mut edges) = (HashMap::new(), HashMap::new());
            let mut n_shared = [0; 2];
            for of_cell in by_cell(&rows(&found)) {
                let cell = place(of_cell[0].of.cell, &lines);
                for face in 0..6 {
                    let mut at = cell;
                    at[face / 2] += face as u32 % 2;
                    let some = of_cell.iter().filter(|row| row.faces[face] > 0.0);
                    let numbers =
                        |row: &Row| [row.faces[face], row.face_centroids[face][0], row.face_centroids[face][1]];
                    let own: Vec<_> = some.map(|row| (row.of.flag, numbers(row).map(f64::to_bits))).collect();
                    let known = faces.entry((face / 2, at)).or_insert_with(|| own.clone());
                    assert_eq!(*known, own, "{}, face {face} of {cell:?}", model.name);
                    n_shared[0] += 1;
                }
                for edge in 0..12 {
                    let corner = ends_of(edge)[0];
                    let at = [0, 1, 2].map(|axis| cell[axis] + (corner >> axis & 1) as u32);
                    let some = of_cell.iter().filter(|row| row.edges[edge] > 0.0);
                    let own: Vec<_> = some.map(|row| (row.of.flag, row.edges[edge].to_bits())).collect();
                    let known = edges.entry((edge / 4, at)).or_insert_with(|| own.clone());
                    assert_eq!(*known, own, "{}, edge {edge} of {cell:?}", model.name);
                    n_shared[1] += 1;
                }
            }
            assert!(n_shared[0] > faces.len() && n_shared[1] > edges.len(), "{}", model.name);
        }
    }
}

#[test]
fn what_is_on_lines_belongs_to_what_is_above_them() {
    let model = &bodies()[4];
    let found = model.measured(&equal());
    for row in rows(&found) {
        assert!([0.0, 1.0].contains(&row.of.fraction) && row.faces.iter().all(|face| [0.0, 1.0].contains(face)));
        let cell = place(row.of.cell, &equal());
        // from x = -2, y = -1, z = -4 up to 1, 3, 2
        let is_within = (3..6).contains(&cell[0]) && (4..8).contains(&cell[1]) && (1..7).contains(&cell[2]);
        assert_eq!(row.of.fraction == 1.0, is_within == (row.of.flag == 7), "{cell:?}");
        if is_within && cell[0] == 3 && row.of.flag == 7 {
            assert_eq!(row.faces[..2], [0.0, 1.0], "{cell:?}");
        }
    }
    assert_eq!(found.volumes[7], 3.0 * 4.0 * 6.0);
    assert_eq!(found.areas.as_ref().unwrap()[0], 2.0 * (12.0 + 18.0 + 24.0));
}

#[test]
fn centres_are_those_of_a_known_body() {
    let model = Model::of_one("corner", cuboid([-2.0, -2.0, -2.0], [-0.75, -0.5, -0.875]));
    let found = model.measured(&equal());
    let rows = rows(&found);
    let row = rows.iter().find(|row| place(row.of.cell, &equal()) == [4, 4, 4] && row.of.flag == 7).unwrap();
    assert!((row.of.fraction - 0.25 * 0.5 * 0.125).abs() < 1e-15);
    let off = [0.125, 0.25, 0.0625].iter().zip(row.centroid).map(|(known, of)| (known - of).abs()).fold(0.0, f64::max);
    assert!(off < 1e-14, "{:?}", row.centroid);
    let own = row.faces.iter().chain(&row.face_centroids[0]).chain(&row.edges);
    let known = [
        0.0625, 0.0, 0.03125, 0.0, 0.125, 0.0, 0.25, 0.0625, 0.25, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.125, 0.0, 0.0,
        0.0,
    ];
    assert_eq!(own.clone().count(), known.len());
    assert!(own.zip(known).all(|(own, known)| (own - known).abs() < 1e-15), "{:?}", row.faces);
    let rest = rows.iter().find(|row| place(row.of.cell, &equal()) == [4, 4, 4] && row.of.flag == 0).unwrap();
    let moment = |axis: usize| row.centroid[axis] * row.of.fraction + rest.centroid[axis] * rest.of.fraction;
    (0..3).for_each(|axis| assert!((moment(axis) - 0.5).abs() < 1e-15));
}

#[test]
fn order_of_facets_corners_and_threads_does_not_matter() {
    for model in all_models() {
        for lines in [equal(), graded()] {
            let known = model.measured(&lines);
            let surfaces = model.surfaces.iter().map(|(flag, facets)| {
                let (half, rest) = facets.split_at(facets.len() / 2);
                let turned = rest.iter().rev().chain(half).map(|&[a, b, c]| [b, c, a]);
                (*flag, turned.collect())
            });
            let other = Model { name: model.name, surfaces: surfaces.collect() };
            let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
            assert!(pool.install(|| other.measured(&lines)) == known, "{}", model.name);
        }
    }
}

#[test]
fn windows_have_what_the_whole_has() {
    for model in all_models() {
        for lines in [equal(), graded()] {
            let known = model.measured(&lines);
            let (first, end) = ([3, 2, 4], [7, 9, 8]);
            let window = CellWindow { first, end, halo: 0 };
            let found = measured(&model.frame(&lines), &lines, window, Rule::Nonzero);
            let all = rows(&known);
            let of_whole: Vec<&Row> = all
                .iter()
                .filter(|row| (0..3).all(|axis| (first[axis]..end[axis]).contains(&place(row.of.cell, &lines)[axis])))
                .collect();
            let of_window = rows(&found);
            assert_eq!(of_window.len(), of_whole.len(), "{}", model.name);
            for (one, other) in of_window.iter().zip(of_whole) {
                assert_eq!(
                    window.cell(one.of.cell),
                    [0, 1, 2].map(|axis| place(other.of.cell, &lines)[axis] - first[axis])
                );
                let bits = |row: &Row| {
                    let of_faces = row.face_centroids.iter().flatten();
                    let numbers = row.faces.iter().chain(&row.edges).chain(&row.centroid).chain(of_faces);
                    let numbers = numbers.chain([&row.of.fraction]).map(|of| of.to_bits());
                    (row.of.flag, row.of.is_sampled, numbers.collect::<Vec<u64>>())
                };
                assert_eq!(bits(one), bits(other), "{}", model.name);
            }
        }
    }
}

/// Lines among which facets cross many cells from side to side.
fn fine() -> Lines {
    Lines::new([-5.0; 3], [0.25; 3], [40; 3]).unwrap()
}

#[test]
fn volumes_alone_are_those_beside_all_else() {
    for model in all_models() {
        for lines in [equal(), graded(), fine()] {
            let known = model.measured(&lines);
            let found = measured_alone(&model.frame(&lines), &lines, CellWindow::all(lines.dims()));
            assert_eq!(found.n_cells, known.n_cells, "{}", model.name);
            // slivers at a corner of several facets: a cell or two of thousands, which edges of facets may say are one sheet
            assert!(found.n_sampled <= known.n_sampled && known.n_sampled <= 2, "{}", model.name);
            let sampled: Vec<u64> = known.flags().filter(|of| of.is_sampled).map(|of| of.cell).collect();
            let of = |found: &CutCells| -> HashMap<(u64, u8), f64> {
                let exact = found.flags().filter(|of| !sampled.contains(&of.cell));
                exact.map(|of| ((of.cell, of.flag), of.fraction)).collect()
            };
            let [found, known] = [&found, &known].map(of);
            assert!(!found.is_empty(), "{}", model.name);
            for key in found.keys().chain(known.keys()) {
                let [one, other] = [&found, &known].map(|of| of.get(key).copied().unwrap_or(0.0));
                assert!((one - other).abs() < 1e-14, "{}, {key:?}: {one}, not {other}", model.name);
            }
        }
    }
}

#[test]
fn volumes_alone_are_the_same_in_any_order_and_window() {
    let (lines, all) = (fine(), CellWindow::all(fine().dims()));
    for model in all_models() {
        let known = measured_alone(&model.frame(&lines), &lines, all);
        let surfaces = model.surfaces.iter().map(|(flag, facets)| {
            let (half, rest) = facets.split_at(facets.len() / 2);
            (*flag, rest.iter().rev().chain(half).map(|&[a, b, c]| [b, c, a]).collect())
        });
        let other = Model { name: model.name, surfaces: surfaces.collect() }.frame(&lines);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
        assert!(pool.install(|| measured_alone(&other, &lines, all)) == known, "{}", model.name);
        let window = CellWindow { first: [13, 9, 17], end: [29, 37, 30], halo: 0 };
        let place = |cell: u64| place(cell, &lines);
        let is_within =
            |of: &&CutFlag| (0..3).all(|axis| (window.first[axis]..window.end[axis]).contains(&place(of.cell)[axis]));
        let of_whole: Vec<([u32; 3], u8, u64)> =
            known.flags().filter(is_within).map(|of| (place(of.cell), of.flag, of.fraction.to_bits())).collect();
        let found = measured_alone(&other, &lines, window);
        let at = |cell: u64| {
            let at = window.cell(cell);
            [0, 1, 2].map(|axis| at[axis] + window.first[axis])
        };
        let of_window: Vec<([u32; 3], u8, u64)> =
            found.flags().map(|of| (at(of.cell), of.flag, of.fraction.to_bits())).collect();
        assert!(of_window == of_whole && !of_whole.is_empty(), "{}", model.name);
    }
}

#[test]
fn axes_may_be_swapped() {
    let lines = graded();
    for model in all_models() {
        let known = model.measured(&lines);
        let turned = model
            .surfaces
            .iter()
            .map(|(flag, facets)| (*flag, facets.iter().map(|facet| facet.map(|[x, y, z]| [z, x, y])).collect()));
        let other = Model { name: model.name, surfaces: turned.collect() }.measured(&lines);
        let [nx, ny, _] = lines.dims().map(u64::from);
        let fractions: HashMap<(u64, u8), f64> = known.flags().map(|of| ((of.cell, of.flag), of.fraction)).collect();
        for of in other.flags().filter(|of| of.fraction > 0.0) {
            let [z, x, y] = place(of.cell, &lines).map(u64::from);
            let index = x + nx * (y + ny * z);
            let off = of.fraction - fractions.get(&(index, of.flag)).unwrap_or(&0.0);
            // ties go by axes: what lies on lines alone
            let is_on_lines = model.name.contains("lines") && !fractions.contains_key(&(index, of.flag));
            assert!(off.abs() < 1e-13 || is_on_lines, "{}: off by {off}", model.name);
        }
    }
}

#[test]
fn a_surface_through_itself_is_sampled_and_marked() {
    let both = [sphere(20, 1.7, [-0.6, 0.1, 0.0]), sphere(20, 1.6, [0.9, -0.2, 0.3])];
    let joined = Model::of_one("two in one", both.concat());
    let apart = Model { name: "two", surfaces: both.iter().map(|facets| (7, facets.clone())).collect() };
    for lines in [equal(), graded()] {
        let (found, known) = (joined.measured(&lines), apart.measured(&lines));
        assert_eq!(known.n_sampled, 0);
        assert!(found.n_sampled > 4 && found.n_sampled < found.n_cells / 2, "{} of {}", found.n_sampled, found.n_cells);
        let of = |found: &CutCells| -> HashMap<u64, (f64, bool)> {
            found.flags().filter(|of| of.flag == 7).map(|of| (of.cell, (of.fraction, of.is_sampled))).collect()
        };
        let (of_found, of_known) = (of(&found), of(&known));
        for (cell, (fraction, is_sampled)) in of_found {
            let off = (fraction - of_known[&cell].0).abs();
            assert!(off < if is_sampled { 0.02 } else { 1e-12 }, "cell {cell}: off by {off}, sampled: {is_sampled}");
        }
    }
}

#[test]
fn facets_that_face_the_wrong_side_are_sampled_under_parity() {
    let ball = sphere(16, 3.0, [0.1, 0.2, 0.3]);
    let mut flipped = ball.clone();
    flipped.iter_mut().step_by(5).for_each(|facet| facet.swap(0, 1));
    let (lines, window) = (equal(), CellWindow::all([10; 3]));
    let [found, known] = [flipped, ball]
        .map(|facets| measured(&Model::of_one("ball", facets).frame(&lines), &lines, window, Rule::Parity));
    assert_eq!((known.n_sampled, found.n_sampled), (0, found.n_cells));
    let off = found.volumes[7] - known.volumes[7];
    assert!(off.abs() < 1e-2, "{off}");
    for (one, other) in rows(&found).iter().zip(rows(&known)) {
        assert_eq!(one.edges, other.edges);
        (0..6).for_each(|face| assert!((one.faces[face] - other.faces[face]).abs() < 0.05));
    }
}

#[test]
fn what_is_inverted_is_the_rest() {
    let model = &bodies()[0];
    let (lines, window) = (graded(), CellWindow::all(graded().dims()));
    let [found, known] = [Kind::Inverted, Kind::Cast]
        .map(|kind| measured_as(&model.frame(&lines), &lines, window, (Rule::Nonzero, &[kind])));
    assert!((found.volumes[0] - known.volumes[7]).abs() < 1e-12 && (found.volumes[7] - known.volumes[0]).abs() < 1e-12);
    let swapped: Vec<(u64, f64)> = known.flags().map(|of| (of.cell, 1.0 - of.fraction)).collect();
    for (one, (cell, fraction)) in found.flags().zip(swapped) {
        assert!(one.cell == cell && (one.fraction - fraction).abs() < 1e-15);
    }
}
