//! Faces of cut cells and the surfaces within them, against the clipped tetrahedra of [`super::fractions`], which cast nothing and clip no facet.

use std::collections::BTreeMap;

use hexcast::fractions::{CutSurface, Fraction};
use hexcast::geometry::{Facet, Geometry};
use hexcast::job::FractionsJob;
use hexcast::lines::Lines;

use super::fractions::{Point, bodies, exact, grids, measured_as as measured, minus, triple};
use super::models;

fn cell_of(index: u64, lines: &Lines) -> [u32; 3] {
    let [nx, ny, _] = lines.dims().map(u64::from);
    [index % nx, index / nx % ny, index / (nx * ny)].map(|at| at as u32)
}

fn ends(cell: [u32; 3], lines: &Lines) -> [Point; 2] {
    [0, 1].map(|by| [0, 1, 2].map(|axis| lines.line(axis, cell[axis] + by)))
}

/// The fraction of a face of a cell that a closed surface holds: that of a thin box about it.
fn exact_face(facets: &[Facet], [mut low, mut high]: [Point; 2], face: usize) -> f64 {
    let (axis, at) = (face / 2, if face.is_multiple_of(2) { low[face / 2] } else { high[face / 2] });
    (low[axis], high[axis]) = (at - 1e-5, at + 1e-5);
    let size: f64 = (0..3).map(|axis| high[axis] - low[axis]).product();
    exact(facets, low, high) / size
}

#[test]
fn faces_are_as_near_to_those_of_clipped_tetrahedra_as_is_said() {
    for (name, facets) in bodies() {
        let geometry = Geometry::new(name, 7, facets.clone()).unwrap();
        for lines in grids() {
            let mut known: BTreeMap<(u64, usize), f64> = BTreeMap::new();
            // without rays they are exact: the oracle has a thin box for a face, and corners that are not snapped
            for (rays, most) in [(2, 0.5), (8, 0.125), (0, 1e-3)] {
                let by = (rays > 0).then_some(rays);
                let job = set!(FractionsJob { rays: by, faces: true, ..FractionsJob::default() });
                let found = measured(std::slice::from_ref(&geometry), &lines, job);
                let entries: Vec<(Fraction, [f32; 6])> = found.iter().copied().zip(found.faces().copied()).collect();
                assert_eq!((entries.len(), found.faces().count()), (found.len(), found.len()));
                let (mut sum_of_squares, mut n) = (0.0, 0.0);
                for (entry, faces) in entries.iter().filter(|(entry, _)| entry.flag == 7) {
                    let ends = ends(cell_of(entry.cell, &lines), &lines);
                    for (face, fraction) in faces.iter().enumerate() {
                        let known = *known.entry((entry.cell, face)).or_insert_with(|| exact_face(&facets, ends, face));
                        let off = (f64::from(*fraction) - known).abs();
                        let what = format!("{name}, {rays} rays, cell {}, face {face}", entry.cell);
                        assert!(off < most, "{what}: {fraction} of {known}");
                        (sum_of_squares, n) = (sum_of_squares + off * off, n + 1.0);
                    }
                }
                let off = (sum_of_squares / n).sqrt();
                assert!(n > 300.0 && off < 0.3 * most, "{name}, {rays} rays: {off} on average over {n} faces");
                // those of the background are the rest, and both cells beside a face agree
                for two in entries.chunk_by(|one, other| one.0.cell == other.0.cell) {
                    for face in 0..6usize {
                        let sum: f32 = two.iter().map(|(_, faces)| faces[face]).sum();
                        assert!((sum - 1.0).abs() < 1e-6, "{two:?}");
                    }
                }
                let of_cell: BTreeMap<u64, [f32; 6]> =
                    entries.iter().filter(|(entry, _)| entry.flag == 7).map(|(entry, of)| (entry.cell, *of)).collect();
                let [nx, ny, _] = lines.dims().map(u64::from);
                let mut n = 0;
                for (cell, faces) in &of_cell {
                    for (axis, step) in [1, nx, nx * ny].into_iter().enumerate() {
                        if let Some(next) = of_cell.get(&(cell + step)) {
                            assert_eq!(faces[2 * axis + 1].to_bits(), next[2 * axis].to_bits());
                            n += 1;
                        }
                    }
                }
                assert!(n > 50, "{n} faces between cut cells");
            }
        }
    }
}

#[test]
fn a_wall_in_the_plane_of_faces_holds_those_of_the_cells_above_it() {
    // a centre stands for what is below it by little: so does a face
    let facets = models::cuboid([0.0, 0.25, -9.0], [1.0, 9.0, 9.0]);
    let lines = Lines::new([-1.0, 0.0, 0.0], [1.0; 3], [3, 1, 1]).unwrap();
    let found = measured(
        &[Geometry::new("g", 1, facets).unwrap()],
        &lines,
        set!(FractionsJob { rays: Some(4), faces: true, ..FractionsJob::default() }),
    );
    let entries: Vec<(u64, u8, [f32; 6])> =
        found.iter().zip(found.faces()).map(|(of, faces)| (of.cell, of.flag, *faces)).collect();
    let [open, solid] = [[1.0, 0.25, 1.0, 0.0, 0.25, 0.25], [0.0, 0.75, 0.0, 1.0, 0.75, 0.75]];
    // the cell above has entries for its face alone
    let above = [(2, 0, [0.25, 1.0, 1.0, 1.0, 1.0, 1.0]), (2, 1, [0.75, 0.0, 0.0, 0.0, 0.0, 0.0])];
    assert_eq!(entries, [&[(1, 0, open), (1, 1, solid)][..], &above].concat());
    let fractions: Vec<f32> = found.iter().map(|of| of.fraction).collect();
    assert_eq!(fractions, [0.25, 0.75, 1.0, 0.0]);
}

fn length(of: Point) -> f64 {
    of.iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn normal_of([a, b, c]: [Point; 3]) -> Point {
    let (u, v) = (minus(b, a), minus(c, a));
    [0, 1, 2].map(|i: usize| 0.5 * (u[(i + 1) % 3] * v[(i + 2) % 3] - u[(i + 2) % 3] * v[(i + 1) % 3]))
}

/// Place of a surface in the world.
fn place(surface: &CutSurface, lines: &Lines) -> Point {
    let [low, high] = ends(cell_of(surface.cell, lines), lines);
    [0, 1, 2].map(|axis| low[axis] + f64::from(surface.point[axis]) * (high[axis] - low[axis]))
}

#[test]
fn surfaces_in_cells_close_what_their_faces_leave_open() {
    for (name, facets) in bodies() {
        let corners: Vec<[Point; 3]> = facets.iter().map(|facet| facet.map(|corner| corner.map(f64::from))).collect();
        let geometry = Geometry::new(name, 7, facets.clone()).unwrap();
        for lines in grids() {
            let job = set!(FractionsJob { rays: Some(4), surfaces: true, ..FractionsJob::default() });
            let found = measured(std::slice::from_ref(&geometry), &lines, job);
            let surfaces: Vec<CutSurface> = found.surfaces().copied().collect();
            assert!(surfaces.is_sorted_by(|one, other| one.cell < other.cell));
            let (mut area, mut moments) = (0.0, [0.0; 3]);
            for surface in &surfaces {
                let ends @ [low, high] = ends(cell_of(surface.cell, &lines), &lines);
                let size = minus(high, low);
                // what leaves a closed body through the faces of the cell leaves it through its surface the other way
                let mut open = [0.0; 3];
                for face in 0..6usize {
                    let axis = face / 2;
                    let of_face = exact_face(&facets, ends, face) * size[(axis + 1) % 3] * size[(axis + 2) % 3];
                    open[axis] += if face.is_multiple_of(2) { of_face } else { -of_face };
                }
                let norm = length(open);
                let of = f64::from(surface.area);
                assert!(norm < of * 1.0001 + 1e-4, "{name}, cell {}: {norm} of {of}", surface.cell);
                if norm > 0.05 * length(size) {
                    let along: f64 = (0..3).map(|axis| open[axis] / norm * f64::from(surface.normal[axis])).sum();
                    assert!(along > 1.0 - 2e-4, "{name}, cell {}: {open:?}, {surface:?}", surface.cell);
                }
                let at = place(surface, &lines);
                area += of;
                moments = [0, 1, 2].map(|axis| moments[axis] + of * at[axis]);
            }
            let (mut known, mut known_moments) = (0.0, [0.0; 3]);
            for facet in &corners {
                let of = length(normal_of(*facet));
                known += of;
                known_moments = [0, 1, 2]
                    .map(|axis| known_moments[axis] + of * (facet[0][axis] + facet[1][axis] + facet[2][axis]) / 3.0);
            }
            assert!((area / known - 1.0).abs() < 1e-6, "{name}: {area} of {known}");
            assert!((found.areas.as_ref().unwrap()[0] / known - 1.0).abs() < 1e-6, "{name}");
            assert!((0..3).all(|axis| (moments[axis] - known_moments[axis]).abs() < 1e-5 * known), "{name}");
        }
    }
}

#[test]
fn the_surface_of_a_plane_is_in_the_plane_and_that_of_a_ball_near_it() {
    // planes at angles: the sides of a large tetrahedron
    let far = models::tetrahedron([[-9.0, -8.0, -7.0], [8.5, -6.0, -5.0], [-1.0, 9.5, -4.0], [0.5, 1.0, 9.0]]);
    let [grid, graded] = grids();
    for lines in [&grid, &graded] {
        let geometry = Geometry::new("g", 1, far.clone()).unwrap();
        let found = measured(
            &[geometry],
            lines,
            set!(FractionsJob { rays: Some(4), surfaces: true, ..FractionsJob::default() }),
        );
        let mut n = 0;
        for surface in found.surfaces() {
            let at = place(surface, lines);
            let is_of = |facet: &Facet| {
                let corners = facet.map(|corner| corner.map(f64::from));
                let normal = normal_of(corners).map(|of| of / length(normal_of(corners)));
                let along: f64 = (0..3).map(|axis| normal[axis] * f64::from(surface.normal[axis])).sum();
                let height =
                    triple(minus(at, corners[0]), minus(corners[1], corners[0]), minus(corners[2], corners[0]));
                along > 1.0 - 1e-6 && (0.5 * height / length(normal_of(corners))).abs() < 1e-5
            };
            n += usize::from(far.iter().any(is_of));
        }
        let all = found.surfaces().count();
        assert!(n > 200 && all < 2 * n, "{n} of {all} cells have a single plane");
    }
    let (centre, radius) = ([0.1, -0.2, 0.3], 3.1);
    let geometry = Geometry::new("ball", 1, models::sphere(centre, radius, 64)).unwrap();
    let found =
        measured(&[geometry], &grid, set!(FractionsJob { rays: Some(4), surfaces: true, ..FractionsJob::default() }));
    for surface in found.surfaces() {
        let from = minus(place(surface, &grid), centre.map(f64::from));
        // half of the diagonal of a cell makes a cap of that height at most, and facets are a little inside
        let depth = f64::from(radius) - length(from);
        assert!((-1e-5..0.75 / (2.0 * f64::from(radius)) + 0.005).contains(&depth), "{surface:?}: {depth}");
        let along: f64 = (0..3).map(|axis| from[axis] / length(from) * f64::from(surface.normal[axis])).sum();
        assert!(along > 0.99 && surface.geometry == 0, "{surface:?}: {along}");
    }
}

#[test]
fn a_wall_between_cells_belongs_to_those_below() {
    let facets = models::cuboid([1.0; 3], [2.0; 3]);
    let lines = Lines::new([0.0; 3], [1.0; 3], [3; 3]).unwrap();
    let found = measured(
        &[Geometry::new("g", 1, facets).unwrap()],
        &lines,
        set!(FractionsJob { rays: Some(4), surfaces: true, ..FractionsJob::default() }),
    );
    assert_eq!(found.len(), 0, "no cell is cut");
    let surfaces: Vec<(u64, f32, [f32; 3], [f32; 3])> =
        found.surfaces().map(|of| (of.cell, of.area, of.point, of.normal)).collect();
    let (inner, third) = (13, 1.0 / f32::sqrt(3.0));
    let expected = [
        (4, 1.0, [0.5, 0.5, 1.0], [0.0, 0.0, -1.0]),
        (10, 1.0, [0.5, 1.0, 0.5], [0.0, -1.0, 0.0]),
        (12, 1.0, [1.0, 0.5, 0.5], [-1.0, 0.0, 0.0]),
        (inner, 3.0, [2.0 / 3.0; 3], [third; 3]),
    ];
    assert_eq!(surfaces.len(), 4);
    for (found, known) in surfaces.iter().zip(expected) {
        assert_eq!((found.0, found.1), (known.0, known.1));
        for axis in 0..3 {
            assert!((found.2[axis] - known.2[axis]).abs() < 1e-6 && (found.3[axis] - known.3[axis]).abs() < 1e-6);
        }
    }
}

#[test]
fn surfaces_at_the_ends_of_the_box_are_found() {
    // in f64 the last line is not where f32 corners are
    for (low, high, n) in [(0.0f32, 1.0f32, 10), (0.7, 1.7, 50), (-1.0, 1.0, 20)] {
        let geometry = Geometry::new("cube", 1, models::cuboid([low; 3], [high; 3])).unwrap();
        let side = f64::from(high) - f64::from(low);
        let lines = Lines::new([f64::from(low); 3], [side / f64::from(n); 3], [n; 3]).unwrap();
        let found = measured(
            &[geometry],
            &lines,
            set!(FractionsJob { rays: Some(4), surfaces: true, ..FractionsJob::default() }),
        );
        let area = found.areas.as_ref().expect("areas")[0];
        assert!((area / (6.0 * side * side) - 1.0).abs() < 1e-6, "{low} to {high}: {area}");
        let of_cells: f64 = found.surfaces().map(|surface| f64::from(surface.area)).sum();
        assert!((of_cells / area - 1.0).abs() < 1e-5, "{of_cells} of {area}");
    }
}

#[test]
fn normals_point_out_of_bodies_that_are_mirrored_or_turned() {
    let centre = [0.3f32, 0.2, 0.1];
    let ball = models::sphere(centre, 1.0, 24);
    let lines = Lines::new([-1.0, -1.1, -1.2], [0.25; 3], [11; 3]).unwrap();
    let mirrored = models::mapped(&ball, |[x, y, z]| [2.0 * centre[0] - x, y, z]);
    for facets in [ball.clone(), mirrored, models::flipped(ball)] {
        let geometry = Geometry::new("ball", 1, facets).unwrap();
        let found = measured(
            &[geometry],
            &lines,
            set!(FractionsJob { rays: Some(4), surfaces: true, ..FractionsJob::default() }),
        );
        assert!(found.surfaces().count() > 100);
        for surface in found.surfaces() {
            let [low, high] = ends(cell_of(surface.cell, &lines), &lines);
            let place = [0, 1, 2].map(|axis| low[axis] + f64::from(surface.point[axis]) * (high[axis] - low[axis]));
            let out = minus(place, centre.map(f64::from));
            let along: f64 = (0..3).map(|axis| out[axis] * f64::from(surface.normal[axis])).sum();
            assert!(along > 0.5, "{surface:?}");
        }
    }
}
