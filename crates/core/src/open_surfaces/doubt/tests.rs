use super::*;
use crate::testing::pattern_flag;

/// The cells of a set from runs along an axis, of which at most so many boxes are kept.
fn doubt(axis: usize, dims: [u32; 3], most: usize, is_in: impl Fn([u32; 3]) -> bool) -> Doubtful {
    let rays = Rays::new(axis, dims);
    let mut doubt = Doubt::new(rays, most, Some(u64::MAX));
    let n_rows = rays.counts[1];
    let part = |rows: Range<u32>| {
        let mut runs = Vec::new();
        // each cell by itself, the last first
        for row in rows.clone().rev() {
            for place in (0..rays.counts[0]).rev() {
                let ray = u64::from(row) * u64::from(rays.counts[0]) + u64::from(place);
                let starts = (0..rays.depth).filter(|&start| is_in(rays.cell([place, row, start])));
                runs.extend(starts.map(|start| CellRun { ray, start, end: start + 1 }));
            }
        }
        (rows, runs)
    };
    // a row is added twice, and the last ones are not
    let n_with = (0..n_rows).rev().find(|&row| !part(row..row + 1).1.is_empty()).map_or(0, |last| last + 1);
    doubt.add(vec![part(0..n_with / 3), part(n_with / 3..n_with / 2)]).unwrap();
    doubt.add(vec![part((n_with / 2).saturating_sub(1)..n_with)]).unwrap();
    doubt.finish().unwrap()
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
        let all = [0, 1, 2].map(|axis| doubt(axis, dims, usize::MAX, is_in).boxes);
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
        assert_eq!(doubt(1, dims, 0, is_in).n_cells, expected.iter().filter(|n| **n == 1).count() as u64);
        let n_of = |[low, high]: &Corners| -> u32 { (0..3).map(|axis| high[axis] - low[axis]).product() };
        assert!(all[0].windows(2).all(|two| n_of(&two[0]) >= n_of(&two[1])));
        for most in [0, 1, 7] {
            let first = &all[0][..most.min(all[0].len())];
            assert!((0..3).all(|axis| doubt(axis, dims, most, is_in).boxes == first), "set {index}: {most}");
        }
    }
    // rows first, then plates: a body that has two boxes one way and three another
    let step = |[x, y, _]: [u32; 3]| x < 4 || y < 4;
    for axis in 0..3 {
        assert_eq!(doubt(axis, [8, 8, 3], 2, step).boxes, [[[0, 0, 0], [8, 4, 3]], [[0, 4, 0], [4, 8, 3]]]);
    }
}

#[test]
fn the_mask_has_the_set_in_every_cell() {
    let dims = [9, 5, 7];
    for axis in 0..3 {
        let mask = doubt(axis, dims, 1, |cell| pattern_flag(cell, 3) == 2).mask.unwrap();
        for z in 0..dims[2] {
            for y in 0..dims[1] {
                for x in 0..dims[0] {
                    let is_in = pattern_flag([x, y, z], 3) == 2;
                    assert_eq!(mask.flag([x, y, z]).unwrap(), u8::from(is_in), "{axis}: {x}, {y}, {z}");
                }
            }
        }
    }
}

#[test]
fn a_mask_that_takes_more_than_it_may_is_an_error() {
    let rays = Rays::new(0, [64, 64, 64]);
    let mut doubt = Doubt::new(rays, 10, Some(1000));
    let runs = (0..64 * 64).flat_map(|ray| (0..32).map(move |n| CellRun { ray, start: 2 * n, end: 2 * n + 1 }));
    assert_eq!(doubt.add(vec![(0..64, runs.collect())]).unwrap_err().code(), "memory");
}
