use super::*;
use crate::lines::Lines;
use crate::mesh::tests::{pattern, pattern_flag};

/// Runs of the cells of a set along an axis.
fn doubt(axis: usize, dims: [u32; 3], is_in: impl Fn([u32; 3]) -> bool) -> Doubt {
    let rays = Rays::new(axis, dims);
    let mut runs = Vec::new();
    // each cell by itself, the last first
    for ray in (0..rays.n_rays()).rev() {
        let place = [(ray % u64::from(rays.counts[0])) as u32, (ray / u64::from(rays.counts[0])) as u32];
        for start in 0..rays.depth {
            if is_in(rays.cell([place[0], place[1], start])) {
                runs.push(CellRun { ray, start, end: start + 1 });
            }
        }
    }
    Doubt::new(rays, runs)
}

#[test]
fn boxes_cover_each_cell_once_and_are_the_same_along_every_axis() {
    let dims = [13, 11, 12];
    let sets: [&dyn Fn([u32; 3]) -> bool; 6] = [
        &|cell| pattern_flag(cell, 3) != 0,
        &|cell| pattern_flag(cell, 3) == 2,
        &|[x, y, z]| x * x + y * y + z * z < 90,
        &|[x, y, z]| (x + y + z) % 2 == 0,
        &|_| true,
        &|_| false,
    ];
    for (index, is_in) in sets.into_iter().enumerate() {
        let all = [0, 1, 2].map(|axis| doubt(axis, dims, is_in).boxes(usize::MAX));
        assert!(all[0] == all[1] && all[1] == all[2], "set {index}");
        let mut n_boxes_of_cell = vec![0; dims.iter().product::<u32>() as usize];
        for [low, high] in &all[0] {
            for z in low[2]..high[2] {
                for y in low[1]..high[1] {
                    (low[0]..high[0]).for_each(|x| n_boxes_of_cell[(x + dims[0] * (y + dims[1] * z)) as usize] += 1);
                }
            }
        }
        let cell = |index: u32| [index % dims[0], index / dims[0] % dims[1], index / (dims[0] * dims[1])];
        let expected: Vec<i32> = (0..dims.iter().product()).map(|index| is_in(cell(index)).into()).collect();
        assert_eq!(n_boxes_of_cell, expected, "set {index}");
        assert_eq!(doubt(1, dims, is_in).n_cells(), expected.iter().filter(|n| **n == 1).count() as u64);
        let n_of = |[low, high]: &Corners| -> u32 { (0..3).map(|axis| high[axis] - low[axis]).product() };
        assert!(all[0].windows(2).all(|two| n_of(&two[0]) >= n_of(&two[1])));
        for most in [0, 1, 7] {
            let first = &all[0][..most.min(all[0].len())];
            assert!((0..3).all(|axis| doubt(axis, dims, is_in).boxes(most) == first), "set {index}: {most}");
        }
    }
    // rows first, then plates: a body that has two boxes one way and three another
    let step = |[x, y, _]: [u32; 3]| x < 4 || y < 4;
    for axis in 0..3 {
        assert_eq!(doubt(axis, [8, 8, 3], step).boxes(2), [[[0, 0, 0], [8, 4, 3]], [[0, 4, 0], [4, 8, 3]]]);
    }
}

#[test]
fn the_mask_has_the_set_in_every_cell() {
    let dims = [9, 5, 7];
    for axis in 0..3 {
        let mesh = pattern(axis, dims, 3);
        let mask = doubt(axis, dims, |cell| pattern_flag(cell, 3) == 2).mask(&mesh).unwrap();
        assert_eq!((&mask.lines, &mask.unit), (&mesh.lines, &mesh.unit));
        for z in 0..dims[2] {
            for y in 0..dims[1] {
                for x in 0..dims[0] {
                    let is_in = pattern_flag([x, y, z], 3) == 2;
                    assert_eq!(mask.flag([x, y, z]).unwrap(), u8::from(is_in), "{axis}: {x}, {y}, {z}");
                }
            }
        }
        let other = Mesh { lines: Lines { dims: [9, 5, 8], ..mesh.lines }, ..mesh };
        assert_eq!(doubt(axis, dims, |_| true).mask(&other).unwrap_err().code(), "job-conflict");
    }
}
