use std::collections::BTreeMap;

use super::*;
use crate::testing::{mesh_of, pattern};
use hexcast_core::cells::columns::Columns;
use hexcast_core::grid::frame::Frame;
use hexcast_core::input::geometry::{Facet, Geometry};
use hexcast_core::stages::map::Rule;

/// Flags without any order: background in about half of the cells, else 1 to 4.
fn noise([x, y, z]: [u32; 3]) -> u8 {
    let mixed = x.wrapping_mul(73_856_093) ^ y.wrapping_mul(19_349_663) ^ z.wrapping_mul(83_492_791);
    let mixed = mixed.wrapping_mul(2_654_435_761) >> 24;
    if mixed < 120 { 0 } else { 1 + (mixed % 4) as u8 }
}

fn exact(mesh: &Mesh, cells: Option<CellBox>) -> Skin {
    skin(mesh, usize::MAX, cells, &Control::default()).unwrap()
}

/// How often each face of one cell of the mesh occurs: flag, direction, lowest corner.
type Faces = BTreeMap<(u8, usize, [u32; 3]), u32>;

fn faces_of_skin(skin: &Skin) -> Faces {
    let mut faces = Faces::new();
    for part in &skin.parts {
        assert_eq!((part.positions.len(), part.indices.len()), (12 * part.n_quads(), 6 * part.n_quads()));
        assert_eq!(part.ends[5] as usize, part.n_quads());
        for (quad, corners) in part.positions.chunks(12).enumerate() {
            let corner = |index: usize| [0, 1, 2].map(|axis| corners[3 * index + axis] as u32);
            let all = [0, 1, 2, 3].map(corner);
            let low = [0, 1, 2].map(|axis| all.map(|c| c[axis]).into_iter().min().unwrap());
            let high = [0, 1, 2].map(|axis| all.map(|c| c[axis]).into_iter().max().unwrap());
            let plane = part.direction(quad) / 2;
            assert_eq!(low[plane], high[plane], "a rectangle lies in a plane");
            let range = |axis: usize| low[axis]..if axis == plane { low[axis] + 1 } else { high[axis] };
            for cell in cells_of(&[range(0), range(1), range(2)]) {
                *faces.entry((part.flag, part.direction(quad), cell)).or_default() += 1;
            }
        }
    }
    faces
}

fn cells_of(cells: &CellBox) -> impl Iterator<Item = [u32; 3]> + use<> {
    let [x, y, z] = cells.clone();
    z.flat_map(move |z| {
        let x = x.clone();
        y.clone().flat_map(move |y| x.clone().map(move |x| [x, y, z]))
    })
}

/// Every face of a box, cell by cell.
fn faces_of_cells(cells: &CellBox, flag_of: impl Fn([u32; 3]) -> u8) -> Faces {
    let mut faces = Faces::new();
    for cell in cells_of(cells) {
        for direction in 0..6 {
            let (axis, up) = (direction / 2, direction % 2);
            let mut beside = cell;
            beside[axis] = if up == 1 { cell[axis] + 1 } else { cell[axis].wrapping_sub(1) };
            let other = if cells[axis].contains(&beside[axis]) { flag_of(beside) } else { 0 };
            let flag = flag_of(cell);
            if flag != 0 && flag != other {
                let mut corner = cell;
                corner[axis] += up as u32;
                faces.insert((flag, direction, corner), 1);
            }
        }
    }
    faces
}

/// Volume inside a surface, by the divergence theorem: exact where the corners are whole numbers.
fn volume(part: &SkinPart) -> f64 {
    let corner = |index: &u32| [0, 1, 2].map(|axis| f64::from(part.positions[3 * *index as usize + axis]));
    let six = part.indices.chunks(3).map(|triangle| {
        let [a, b, c] = [corner(&triangle[0]), corner(&triangle[1]), corner(&triangle[2])];
        a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0])
    });
    six.sum::<f64>() / 6.0
}

#[test]
fn a_cell_has_six_faces_that_look_outside() {
    for axis in 0..3 {
        let mesh = mesh_of(axis, [3, 4, 5], |cell| if cell == [1, 2, 3] { 9 } else { 0 });
        let skin = exact(&mesh, None);
        assert_eq!((skin.step, skin.n_faces, skin.n_quads(), skin.parts.len()), (1, 6, 6, 1));
        let part = &skin.parts[0];
        assert_eq!((part.flag, part.ends, volume(part)), (9, [1, 2, 3, 4, 5, 6], 1.0));
        let low_z: Vec<_> = part.positions[48..60].chunks(3).map(|c| [c[0], c[1], c[2]]).collect();
        assert_eq!(part.direction(4), 4);
        let expected = [[1.0, 2.0, 3.0], [1.0, 3.0, 3.0], [2.0, 3.0, 3.0], [2.0, 2.0, 3.0]];
        assert_eq!(low_z, expected, "axis {axis}");
        for (triangle, corners) in part.indices.chunks(3).enumerate() {
            let corner = |at: usize| [0, 1, 2].map(|axis| part.positions[3 * corners[at] as usize + axis]);
            let normal = hexcast_core::input::surface::doubled_area_vector(&[corner(0), corner(1), corner(2)]);
            let direction = part.direction(triangle / 2);
            let mut claimed = [0.0; 3];
            claimed[direction / 2] = if direction % 2 == 1 { 1.0 } else { -1.0 };
            assert_eq!(normal, claimed, "triangle {triangle}");
        }
    }
}

#[test]
fn a_block_has_six_rectangles_however_many_rows_it_has() {
    let [nx, ny, nz] = [150, 131, 140];
    for axis in 0..3 {
        let inside = |cell: [u32; 3]| cell.iter().all(|&c| c >= 2) && cell[0] < nx - 1 && cell[1] < ny - 3;
        let skin = exact(&mesh_of(axis, [nx, ny, nz], |cell| u8::from(inside(cell))), None);
        let [x, y, z] = [nx - 3, ny - 5, nz - 2].map(u64::from);
        assert_eq!((skin.n_quads(), skin.n_faces), (6, 2 * (x * y + y * z + z * x)), "axis {axis}");
        assert_eq!(volume(&skin.parts[0]), (x * y * z) as f64);
    }
}

#[test]
fn the_rectangles_cover_exactly_the_faces_of_the_cells() {
    let dims = [11, 70, 9];
    for axis in 0..3 {
        let mesh = mesh_of(axis, dims, noise);
        for cells in [[0..11, 0..70, 0..9], [2..9, 5..69, 3..4], [10..11, 0..66, 1..9], [4..5, 33..34, 2..3]] {
            let skin = exact(&mesh, Some(cells.clone()));
            let expected = faces_of_cells(&cells, noise);
            assert!(faces_of_skin(&skin) == expected, "axis {axis}, box {cells:?}");
            assert_eq!(skin.n_faces, expected.len() as u64);
        }
    }
}

#[test]
fn every_flag_is_closed_and_holds_its_cells() {
    for axis in 0..3 {
        let mesh = mesh_of(axis, [13, 12, 11], noise);
        let cells = mesh.columns.cells_per_flag();
        let skin = exact(&mesh, None);
        assert_eq!(skin.parts.iter().map(|part| part.flag).collect::<Vec<_>>(), [1, 2, 3, 4]);
        for part in &skin.parts {
            assert_eq!(volume(part), cells[usize::from(part.flag)] as f64, "axis {axis}, flag {}", part.flag);
        }
        // every unit edge runs as often one way as the other
        let mut edges: BTreeMap<(u8, [u32; 3], usize), i32> = BTreeMap::new();
        for (flag, direction, corner) in faces_of_skin(&skin).into_keys() {
            let [plane, u, v] = [0, 1, 2].map(|next| (direction / 2 + next) % 3);
            let turn = if direction == 2 * plane + 1 { 1 } else { -1 };
            let beside = |axis: usize| [0, 1, 2].map(|a| corner[a] + u32::from(a == axis));
            *edges.entry((flag, corner, u)).or_default() += turn;
            *edges.entry((flag, beside(v), u)).or_default() -= turn;
            *edges.entry((flag, corner, v)).or_default() -= turn;
            *edges.entry((flag, beside(u), v)).or_default() += turn;
        }
        assert!(edges.len() > 1000 && edges.values().all(|&sum| sum == 0));
    }
}

#[test]
fn two_flags_that_touch_both_own_the_face_between_them() {
    for axis in 0..3 {
        for across in 0..3 {
            let mut dims = [1; 3];
            dims[across] = 2;
            let skin = exact(&mesh_of(axis, dims, |cell| 3 + 2 * cell[across] as u8), None);
            assert_eq!((skin.n_faces, skin.n_quads()), (12, 12));
            assert_eq!(
                skin.parts.iter().map(|part| (part.flag, volume(part))).collect::<Vec<_>>(),
                [(3, 1.0), (5, 1.0)]
            );
        }
    }
}

#[test]
fn the_ray_axis_and_the_threads_do_not_change_the_surface() {
    let skins = [0, 1, 2].map(|axis| faces_of_skin(&exact(&pattern(axis, [30, 70, 20], 5), None)));
    assert!(!skins[0].is_empty() && skins[0] == skins[1] && skins[1] == skins[2]);
    let mesh = mesh_of(1, [80, 7, 150], noise);
    let on =
        |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(|| exact(&mesh, None));
    assert!(on(1) == on(3));
}

/// The flags of the coarse cells of a box that have any, from their definition.
fn coarse_flags(step: u32, cells: &CellBox, n_cells: &[u64; 256]) -> BTreeMap<[u32; 3], u8> {
    let mut coarse = BTreeMap::new();
    for cell in cells_of(cells) {
        let flag = noise_with_gaps(cell);
        if flag != 0 {
            let rarest = coarse.entry(cell.map(|c| c / step)).or_insert(flag);
            let key = |flag: u8| (n_cells[usize::from(flag)], flag);
            *rarest = if key(flag) < key(*rarest) { flag } else { *rarest };
        }
    }
    coarse
}

/// [`noise`] with empty regions.
fn noise_with_gaps(cell: [u32; 3]) -> u8 {
    if cell.iter().any(|&c| c / 3 % 2 == 0) { 0 } else { noise(cell) }
}

#[test]
fn coarse_cells_take_the_rarest_flag_in_them() {
    for axis in 0..3 {
        let mesh = mesh_of(axis, [25, 27, 22], noise_with_gaps);
        let n_cells = mesh.columns.cells_per_flag();
        for cells in [[0..25, 0..27, 0..22], [3..22, 5..27, 7..16]] {
            let mut steps = Vec::new();
            for max_quads in [1300, 600, 100, 20, 5] {
                let skin = skin(&mesh, max_quads, Some(cells.clone()), &Control::default()).unwrap();
                let flags = coarse_flags(skin.step, &cells, &n_cells);
                let flag = |cell: [u32; 3]| flags.get(&cell.map(|c| c / skin.step)).copied().unwrap_or(0);
                let expected = faces_of_cells(&cells, flag);
                assert!(faces_of_skin(&skin) == expected, "axis {axis}, box {cells:?}, step {}", skin.step);
                assert!(skin.n_quads() <= max_quads || (skin.step, skin.n_quads()) == (32, 6), "{}", skin.n_quads());
                steps.push(skin.step);
            }
            steps.dedup();
            assert!(steps.is_sorted() && steps.len() >= 3 && steps.iter().all(|s| s.is_power_of_two()), "{steps:?}");
        }
    }
}

#[test]
fn thin_parts_stay_where_the_mesh_is_coarsened() {
    for axis in 0..3 {
        // a sheet of copper inside a board, and a wire on it
        let flag = |[x, y, z]: [u32; 3]| {
            if z == 21 { 2 } else { u8::from((10..30).contains(&z)) + 3 * u8::from(y == 5 && x == z) }
        };
        let skin = skin(&mesh_of(axis, [64, 64, 64], flag), 300, None, &Control::default()).unwrap();
        assert!(skin.step > 1 && skin.n_quads() <= 300);
        let copper = skin.parts.iter().find(|part| part.flag == 2).unwrap();
        assert!(volume(copper) >= 0.9 * f64::from(64 * 64 * skin.step));
        assert!(skin.parts.iter().any(|part| part.flag >= 3));
    }
}

#[test]
fn a_limit_that_is_met_exactly_is_no_reason_to_coarsen() {
    let mesh = mesh_of(0, [20, 90, 20], noise);
    let n_quads = exact(&mesh, None).n_quads();
    let step = |max_quads| skin(&mesh, max_quads, None, &Control::default()).unwrap().step;
    assert_eq!(step(n_quads), 1);
    assert!(step(n_quads - 1) > 1);
    assert!(step(0) == 128, "a single cell is always taken");
}

#[test]
fn empty_meshes_and_boxes_have_no_parts() {
    let mesh = mesh_of(2, [5, 6, 7], |_| 0);
    assert_eq!(exact(&mesh, None), Skin { step: 1, n_faces: 0, parts: vec![] });
    let mesh = mesh_of(2, [5, 6, 7], |_| 1);
    assert_eq!(exact(&mesh, Some([0..5, 3..3, 0..7])).parts, []);
}

#[test]
fn what_lies_outside_is_an_error_and_cancel_stops() {
    let (mesh, control) = (mesh_of(2, [5, 6, 7], noise), Control::default());
    assert_eq!(skin(&mesh, 9, Some([0..5, 0..7, 0..7]), &control).unwrap_err().code(), "job-value");
    #[expect(clippy::reversed_empty_ranges, reason = "what a careless caller hands in")]
    let reversed = [3..1, 0..6, 0..7];
    assert_eq!(skin(&mesh, 9, Some(reversed), &control).unwrap_err().code(), "job-value");
    assert_eq!(slice(&mesh, 1, 6, [9, 9]).unwrap_err().code(), "job-value");
    assert_eq!(slice(&mesh, 3, 0, [9, 9]).unwrap_err().code(), "job-value");
    control.cancel.cancel();
    assert_eq!(skin(&mesh, 9, None, &control), Err(Error::Cancelled));
}

#[test]
fn slices_show_the_flags_of_their_cells() {
    let dims = [9, 14, 11];
    for (ray_axis, axis) in (0..3).flat_map(|ray_axis| (0..3).map(move |axis| (ray_axis, axis))) {
        let mesh = mesh_of(ray_axis, dims, noise);
        let [first, second] = [[1, 2], [0, 2], [0, 1]][axis];
        for (out_max, step) in [([14, 14], 1), ([100, 6], 3), ([3, 100], 5), ([1, 1], 14), ([0, 0], 14)] {
            let slice = slice(&mesh, axis, 4, out_max).unwrap();
            assert!(slice.step <= step && slice.width <= out_max[0].max(1) && slice.height <= out_max[1].max(1));
            assert_eq!([slice.width, slice.height], [first, second].map(|axis| dims[axis].div_ceil(slice.step)));
            assert_eq!(slice.flags.len(), (slice.width * slice.height) as usize);
            for (pixel, &flag) in slice.flags.iter().enumerate() {
                let shown = |at: u32, axis: usize| (at * slice.step + slice.step / 2).min(dims[axis] - 1);
                let mut cell = [4; 3];
                cell[first] = shown(pixel as u32 % slice.width, first);
                cell[second] = shown(pixel as u32 / slice.width, second);
                assert_eq!(flag, noise(cell), "rays {ray_axis}, slice across {axis}, pixel {pixel}");
            }
        }
    }
}

#[test]
fn a_surface_meshes_to_the_same_cells() {
    let mesh = mesh_of(2, [9, 12, 10], noise);
    let skin = exact(&mesh, None);
    for part in &skin.parts {
        let again = meshed_again(part, &mesh);
        let expected = mesh_of(2, [9, 12, 10], |cell| u8::from(noise(cell) == part.flag));
        assert_eq!(again, expected.columns, "flag {}", part.flag);
        assert_eq!(again.odd_rays(), 0);
    }
}

/// Meshes a surface over the lines of its mesh, as flag 1.
fn meshed_again(part: &SkinPart, mesh: &Mesh) -> Columns {
    let corner = |&corner: &u32| {
        // positions are whole numbers of lines
        let line = |axis: usize| part.positions[3 * corner as usize + axis] as u32;
        [0, 1, 2].map(|axis| mesh.lines.line(axis, line(axis)) as f32)
    };
    let facet = |corners: &[u32]| [corner(&corners[0]), corner(&corners[1]), corner(&corners[2])];
    let facets: Vec<Facet> = part.indices.chunks_exact(3).map(facet).collect();
    assert_eq!(facets.len(), 2 * part.n_quads());
    let frame = Frame::new(&[Geometry::new("skin", 1, facets).unwrap()], &mesh.lines).unwrap();
    hexcast_core::stages::cpu::columns(
        &hexcast_core::stages::cast::Cast { frame: &frame, rays: mesh.columns.rays(), rule: Rule::default() },
        &Control::default(),
    )
    .unwrap()
}
