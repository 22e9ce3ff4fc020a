//! Leaves against a tree of single cells, which is balanced again and again until nothing changes.

use std::collections::BTreeSet;

use super::*;
use hexcast_core::base::control::at_once;
use hexcast_core::cells::columns::Band;
use hexcast_core::grid::rays::Rays;
use proptest::prelude::*;

/// Flags of all cells, x fastest.
struct Dense {
    dims: [u32; 3],
    flags: Vec<u8>,
}

impl Dense {
    fn new(dims: [u32; 3], flag: impl Fn([u32; 3]) -> u8) -> Dense {
        let cells = (0..dims[2]).flat_map(|z| (0..dims[1]).flat_map(move |y| (0..dims[0]).map(move |x| [x, y, z])));
        Dense { dims, flags: cells.map(flag).collect() }
    }

    fn at(&self, [x, y, z]: [u32; 3]) -> u8 {
        self.flags[(x + self.dims[0] * (y + self.dims[1] * z)) as usize]
    }

    fn columns(&self) -> Columns {
        let rays = Rays::new(0, self.dims);
        let (mut runs, mut ends) = (Vec::new(), Vec::new());
        for row in self.flags.chunks(self.dims[0] as usize) {
            let mut before = 0;
            for (x, &flag) in row.iter().enumerate() {
                if flag != before {
                    runs.push((x as u32) << 8 | u32::from(flag));
                }
                before = flag;
            }
            ends.push(runs.len() as u32);
        }
        let mut band = Band::default();
        (band.runs, band.ends) = (runs, ends);
        Columns::new(rays, vec![band]).unwrap()
    }
}

type Leaf = (u8, [u32; 3], u8);

/// All leaves, by cells alone: a cell of a level is halved where it must be, until nothing changes.
fn expected(levels: &[Dense], wanted: &Wanted) -> Vec<Leaf> {
    let last = levels.len() - 1;
    let cells_of = |level: usize| {
        let [nx, ny, nz] = levels[level].dims;
        (0..nz).flat_map(move |z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])))
    };
    let mut halved: Vec<BTreeSet<[u32; 3]>> = vec![BTreeSet::new(); last + 1];
    for level in 1..=last {
        let dense = &levels[level];
        for cell in cells_of(level) {
            for axis in 0..3 {
                for step in [-1, 1] {
                    let mut other = cell.map(i64::from);
                    other[axis] += step;
                    if !(0..i64::from(dense.dims[axis])).contains(&other[axis]) {
                        continue;
                    }
                    let flags = [dense.at(cell), dense.at(other.map(|of| of as u32))];
                    let finest = flags.map(|flag| wanted.level_of_flag[usize::from(flag)]).into_iter().max();
                    if flags[0] != flags[1] && usize::from(finest.unwrap()) == level {
                        halved[level - 1].insert(cell.map(|of| of / 2));
                    }
                }
            }
        }
        for (of, finest) in &wanted.boxes {
            for cell in cells_of(level - 1) {
                if usize::from(*finest) >= level && (0..3).all(|axis| of[axis].contains(&(cell[axis] >> (level - 1)))) {
                    halved[level - 1].insert(cell);
                }
            }
        }
    }
    loop {
        let mut more = Vec::new();
        for level in 1..=last {
            for cell in &halved[level] {
                for around in 0..27_i64 {
                    let other = [0, 1, 2].map(|axis| i64::from(cell[axis]) + around / 3_i64.pow(axis as u32) % 3 - 1);
                    if (0..3).all(|axis| (0..i64::from(levels[level].dims[axis])).contains(&other[axis])) {
                        let parent = other.map(|of| of as u32 / 2);
                        if !halved[level - 1].contains(&parent) {
                            more.push((level - 1, parent));
                        }
                    }
                }
            }
        }
        if more.is_empty() {
            break;
        }
        more.into_iter().for_each(|(level, cell)| {
            halved[level].insert(cell);
        });
    }
    let mut leaves = Vec::new();
    for level in 0..=last {
        for cell in cells_of(level) {
            let is_there = level == 0 || halved[level - 1].contains(&cell.map(|of| of / 2));
            if is_there && !halved[level].contains(&cell) {
                leaves.push((level as u8, cell, levels[level].at(cell)));
            }
        }
    }
    leaves
}

fn found(tree: &Octree) -> Vec<Leaf> {
    let mut leaves = Vec::new();
    for level in 0..tree.n_levels() {
        let before = leaves.len();
        for z in 0..tree.dims(level)[2] {
            let add = |y: u32, run: &LeafRun| {
                leaves.extend((run.start..run.end).map(|x| (level as u8, [x, y, z], run.flag)));
            };
            tree.for_plane(level, z, add).unwrap();
        }
        assert_eq!((leaves.len() - before) as u64, tree.n_leaves(level), "level {level}");
    }
    leaves
}

fn tree_of(levels: &[Dense], wanted: &Wanted) -> Octree {
    let columns = levels.iter().map(Dense::columns).collect();
    at_once(Octree::new(columns, wanted, u64::MAX, &Control::default())).unwrap()
}

fn compare(levels: &[Dense], wanted: &Wanted) -> Vec<Leaf> {
    let tree = tree_of(levels, wanted);
    let leaves = found(&tree);
    assert!(leaves == expected(levels, wanted), "{wanted:?}");
    // each finest cell is in one leaf
    let last = levels.len() as u32 - 1;
    let volume: u64 = leaves.iter().map(|leaf| 1 << (3 * (last - u32::from(leaf.0)))).sum();
    assert_eq!(volume, levels[last as usize].flags.len() as u64);
    for n_threads in [1, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap();
        assert_eq!(pool.install(|| tree_of(levels, wanted)).halved, tree.halved);
    }
    leaves
}

/// Levels of a shape, whose flag at a place in cells of level 0 is known.
fn levels_of(dims: [u32; 3], n_levels: u32, flag: impl Fn([f64; 3]) -> u8) -> Vec<Dense> {
    let of = |level: u32| {
        let size = 1.0 / f64::from(1 << level);
        Dense::new(dims.map(|n| n << level), |cell| flag(cell.map(|at| (f64::from(at) + 0.5) * size)))
    };
    (0..=n_levels).map(of).collect()
}

#[test]
fn leaves_are_those_of_a_tree_of_single_cells() {
    let ball = |centre: [f64; 3], radius: f64| {
        move |at: [f64; 3]| (0..3).map(|axis| (at[axis] - centre[axis]).powi(2)).sum::<f64>() < radius * radius
    };
    let (one, other) = (ball([3.1, 2.2, 2.9], 1.7), ball([4.4, 3.0, 1.0], 1.1));
    let balls = move |at: [f64; 3]| if one(at) { 1 } else { 2 * u8::from(other(at)) };
    let plate = |at: [f64; 3]| u8::from((1.0..1.2).contains(&at[2]) && at[0] > 2.0);
    for n_levels in 0..=3 {
        let levels = levels_of([7, 5, 4], n_levels, balls);
        let leaves = compare(&levels, &Wanted::surfaces(n_levels as u8));
        assert!(n_levels < 3 || leaves.len() < levels[3].flags.len() / 2);
        compare(&levels_of([5, 3, 2], n_levels, plate), &Wanted::surfaces(n_levels as u8));
        // nothing there
        assert_eq!(compare(&levels_of([4, 3, 5], n_levels, |_| 0), &Wanted::surfaces(n_levels as u8)).len(), 60);
        // surfaces of one flag alone, of another level each, and a box
        for level in 0..=n_levels as u8 {
            let mut wanted = Wanted::surfaces(n_levels as u8);
            wanted.level_of_flag[2] = level;
            compare(&levels, &wanted);
            wanted.level_of_flag[1] = 0;
            wanted.boxes.push(([5..7, 0..1, 2..4], n_levels as u8));
            wanted.boxes.push(([0..2, 1..4, 0..4], level));
            compare(&levels, &wanted);
        }
    }
}

/// A window with one cell of level 0 around it.
#[test]
fn leaves_of_a_window_are_those_of_the_whole() {
    let centres = [[2.6, 2.4, 2.2], [4.8, 1.2, 3.3], [1.1, 3.6, 0.7], [6.2, 4.4, 1.4]];
    let flag = |at: [f64; 3]| {
        let is_in = |centre: &[f64; 3]| (0..3).map(|axis| (at[axis] - centre[axis]).powi(2)).sum::<f64>() < 0.3;
        centres.iter().position(is_in).map_or(0, |index| index as u8 + 1)
    };
    for n_levels in 1..=4_u8 {
        let wanted = Wanted::surfaces(n_levels);
        let whole = found(&tree_of(&levels_of([7, 5, 4], n_levels.into(), flag), &wanted));
        for window in [[2_u32..4, 1..3, 1..3], [1..5, 2..3, 2..4], [0..2, 0..5, 0..1], [6..7, 4..5, 1..3]] {
            let low = [0, 1, 2].map(|axis: usize| window[axis].start.saturating_sub(1));
            let end = [0, 1, 2].map(|axis: usize| (window[axis].end + 1).min([7, 5, 4][axis]));
            let dims = [0, 1, 2].map(|axis| end[axis] - low[axis]);
            let within = |at: [f64; 3]| flag([0, 1, 2].map(|axis| at[axis] + f64::from(low[axis])));
            let of_window = found(&tree_of(&levels_of(dims, n_levels.into(), within), &wanted));
            let is_in = |level: u8, cell: [u32; 3]| (0..3).all(|axis| window[axis].contains(&(cell[axis] >> level)));
            let moved = of_window
                .into_iter()
                .map(|(level, cell, flag)| (level, [0, 1, 2].map(|axis| cell[axis] + (low[axis] << level)), flag));
            let moved: Vec<Leaf> = moved.filter(|(level, cell, _)| is_in(*level, *cell)).collect();
            let expected: Vec<Leaf> = whole.iter().copied().filter(|(level, cell, _)| is_in(*level, *cell)).collect();
            assert!(moved == expected, "{n_levels} levels, {window:?}");
        }
    }
}

#[test]
fn what_cannot_be_is_refused() {
    let levels = levels_of([4, 3, 2], 1, |_| 0);
    let columns = |of: &[usize]| of.iter().map(|level| levels[*level].columns()).collect::<Vec<_>>();
    let code = |columns, wanted: &Wanted, max_bytes| {
        at_once(Octree::new(columns, wanted, max_bytes, &Control::default())).unwrap_err().code()
    };
    let one = Wanted::surfaces(1);
    assert_eq!(code(vec![], &one, u64::MAX), "job-conflict");
    assert_eq!(code(columns(&[0, 0]), &one, u64::MAX), "job-conflict");
    assert_eq!(code(columns(&[0, 1]), &Wanted::surfaces(2), u64::MAX), "job-value");
    for outside in [[0..5, 0..1, 0..1], [2..2, 0..1, 0..1]] {
        let boxes = vec![(outside, 1)];
        assert_eq!(code(columns(&[0, 1]), &Wanted { boxes, ..one.clone() }, u64::MAX), "job-value");
    }
    assert_eq!(code(columns(&[0, 1]), &one, 1), "memory");
    let control = Control::default();
    control.cancel.cancel();
    assert_eq!(at_once(Octree::new(columns(&[0, 1]), &one, u64::MAX, &control)).unwrap_err(), Error::Cancelled);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    /// Each level by itself at random: coarse cells need not be like the fine ones in them.
    #[test]
    fn random_flags_give_the_leaves_of_single_cells(
        seed in any::<u64>(), n_levels in 1..4_u32, n in [1..4_u32, 1..4, 1..4], rare in 1..60_u64, of_flags in [0..4_u8, 0..4, 0..4],
    ) {
        let number = |level: u32, cell: [u32; 3]| {
            let at = cell.iter().fold(u64::from(level) + 1, |sum, at| sum.wrapping_mul(1_000_003).wrapping_add(u64::from(*at)));
            let mixed = (at ^ seed).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            (mixed ^ mixed >> 29).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 33
        };
        let flag = |level, cell| if number(level, cell) % (2 * rare) == 0 { 1 + (number(level, cell) / 1000 % 3) as u8 } else { 0 };
        let levels: Vec<Dense> = (0..=n_levels).map(|level| Dense::new(n.map(|n| n << level), |cell| flag(level, cell))).collect();
        let mut wanted = Wanted::surfaces(n_levels as u8);
        compare(&levels, &wanted);
        for (index, level) in of_flags.into_iter().enumerate() {
            wanted.level_of_flag[index + 1] = level.min(n_levels as u8);
        }
        compare(&levels, &wanted);
    }
}
