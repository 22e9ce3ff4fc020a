//! Leaks, against searches over single cells: connectivity, shortest paths, widest cubes.
//!
//! The reference follows the definitions: a breadth-first search over cells, and over the places of cubes whose cells are
//! looked at one by one.

use std::collections::VecDeque;

use hexcast::columns::Columns;
use hexcast::control::Control;
use hexcast::leak::{Leak, MAX_WIDTH, Question, leak};
use hexcast::lines::Lines;
use hexcast::mesh::Mesh;
use hexcast_core::grid::rays::Rays;
use hexcast_core::testing::band_of;

use super::soups::Random;

/// Flags of a box of cells, x fastest.
pub(super) struct Grid {
    pub(super) dims: [u32; 3],
    pub(super) flags: Vec<u8>,
}

/// Widths that the reference tries; larger cubes take it too long.
const MAX_TRIED: u32 = 7;

impl Grid {
    pub(super) fn filled(dims: [u32; 3], flag: u8) -> Grid {
        Grid { dims, flags: vec![flag; dims.iter().product::<u32>() as usize] }
    }

    pub(super) fn index(&self, [x, y, z]: [u32; 3]) -> usize {
        (x + self.dims[0] * (y + self.dims[1] * z)) as usize
    }

    pub(super) fn set(&mut self, low: [u32; 3], high: [u32; 3], flag: u8) {
        for z in low[2]..high[2] {
            for y in low[1]..high[1] {
                for x in low[0]..high[0] {
                    let index = self.index([x, y, z]);
                    self.flags[index] = flag;
                }
            }
        }
    }

    /// The mesh of these flags with rays along an axis; cells of 1 x 2 x 0.5 from (-1, 0, 10).
    pub(super) fn mesh(&self, axis: usize) -> Mesh {
        let rays = Rays::new(axis, self.dims);
        let band = band_of(&rays, |cell| self.flags[self.index(cell)]);
        let lines = Lines::new([-1.0, 0.0, 10.0], [1.0, 2.0, 0.5], self.dims).unwrap();
        Mesh::new(lines, Columns::new(rays, vec![band]).unwrap(), vec![], None).unwrap()
    }

    fn found(&self, axis: usize, [from, to]: [[u32; 3]; 2], flags: &[u8]) -> Leak {
        let mesh = self.mesh(axis);
        let centre = |cell: [u32; 3]| {
            [0, 1, 2].map(|axis| mesh.lines().line(axis, cell[axis]) + 0.3 * mesh.lines().smallest()[axis])
        };
        let question = Question::new(centre(from), centre(to)).with_flags(flags.to_vec()).with_max_bytes(1 << 30);
        let found = leak(&mesh, &question, &Control::default()).unwrap();
        assert_eq!([found.from.cell, found.to.cell], [from, to]);
        found
    }

    /// Whether a cube of w cells fits where `last` are its last cells, counted from w - 1 cells before the mesh.
    fn fits(&self, last: [u32; 3], w: u32, flags: &[u8]) -> bool {
        let mut cells = (0..w * w * w).map(|k| [k % w, k / w % w, k / (w * w)]);
        cells.all(|offset| {
            let cell = [0, 1, 2].map(|axis| last[axis].checked_sub(offset[axis]).filter(|at| *at < self.dims[axis]));
            let flag = match cell {
                [Some(x), Some(y), Some(z)] => self.flags[self.index([x, y, z])],
                _ => 0,
            };
            flags.contains(&flag)
        })
    }

    /// Steps of a cube of w cells from any place over a cell to each of its places, x fastest; none where it does not come.
    fn steps(&self, from: [u32; 3], w: u32, flags: &[u8]) -> (Grid, Vec<Option<u64>>) {
        let places = Grid::filled(self.dims.map(|n| n + w - 1), 0);
        let mut steps = vec![None; places.flags.len()];
        let mut queue = VecDeque::new();
        for k in 0..w * w * w {
            let offset = [k % w, k / w % w, k / (w * w)];
            let place = [0, 1, 2].map(|axis| from[axis] + offset[axis]);
            if self.fits(place, w, flags) {
                steps[places.index(place)] = Some(0);
                queue.push_back(place);
            }
        }
        while let Some(place) = queue.pop_front() {
            let next = steps[places.index(place)].map(|n| n + 1);
            for side in 0..6 {
                let mut beside = place;
                beside[side / 2] = if side % 2 == 0 { place[side / 2].wrapping_sub(1) } else { place[side / 2] + 1 };
                let is_inside = (0..3).all(|axis| beside[axis] < places.dims[axis]);
                if is_inside && steps[places.index(beside)].is_none() && self.fits(beside, w, flags) {
                    steps[places.index(beside)] = next;
                    queue.push_back(beside);
                }
            }
        }
        (places, steps)
    }

    /// Whether a cube passes from one cell to another.
    fn passes(&self, [from, to]: [[u32; 3]; 2], w: u32, flags: &[u8]) -> bool {
        let (places, steps) = self.steps(from, w, flags);
        let mut offsets = (0..w * w * w).map(|k| [k % w, k / w % w, k / (w * w)]);
        offsets.any(|offset| steps[places.index([0, 1, 2].map(|axis| to[axis] + offset[axis]))].is_some())
    }
}

/// Holds what was found against the reference.
fn check(name: &str, grid: &Grid, ends: [[u32; 3]; 2], flags: &[u8]) {
    let (_, steps) = grid.steps(ends[0], 1, flags);
    let n_steps = steps[grid.index(ends[1])];
    let n_reached = steps.iter().flatten().count() as u64;
    let width = (1..=MAX_TRIED).take_while(|&w| grid.passes(ends, w, flags)).last().unwrap_or(0);
    for axis in 0..3 {
        let name = format!("{name}, rays along {axis}");
        let found = grid.found(axis, ends, flags);
        assert_eq!(found.from.n_cells, n_reached, "{name}: cells reached");
        assert_eq!(found.path.as_ref().map(|path| path.steps), n_steps, "{name}: steps");
        let Some(path) = found.path else {
            assert_eq!((found.narrowest, width), (None, 0), "{name}");
            continue;
        };
        assert_eq!(found.to.n_cells, n_reached, "{name}: cells reached from the end");
        check_path(&name, grid, ends, flags, &path);
        let found_width = found.narrowest.as_ref().map_or(MAX_WIDTH, |place| place.width);
        assert_eq!(found_width.min(MAX_TRIED), width, "{name}: width");
        if let Some(place) = found.narrowest.filter(|place| place.width < MAX_TRIED) {
            check_narrowest(&name, grid, ends[0], flags, place.width, place.cells);
        }
    }
}

/// A path must go over faces of open cells from one end to the other, in as many steps as it says.
fn check_path(name: &str, grid: &Grid, ends: [[u32; 3]; 2], flags: &[u8], path: &hexcast::leak::Path) {
    assert_eq!([path.cells[0], *path.cells.last().unwrap()], ends, "{name}");
    assert_eq!(path.cells.len(), path.points.len(), "{name}");
    let (mut n, mut length) = (0, 0.0);
    for pair in path.cells.windows(2) {
        let axes: Vec<usize> = (0..3).filter(|&axis| pair[0][axis] != pair[1][axis]).collect();
        assert_eq!(axes.len(), 1, "{name}: {pair:?} is not a straight piece");
        let [low, high] = [0, 1].map(|side| {
            [0, 1, 2]
                .map(|axis| if side == 0 { pair[0][axis].min(pair[1][axis]) } else { pair[0][axis].max(pair[1][axis]) })
        });
        let n_cells = high[axes[0]] - low[axes[0]];
        for step in 0..=n_cells {
            let mut cell = low;
            cell[axes[0]] += step;
            assert!(flags.contains(&grid.flags[grid.index(cell)]), "{name}: {cell:?} is not open");
        }
        n += u64::from(n_cells);
        length += f64::from(n_cells) * [1.0, 2.0, 0.5][axes[0]];
    }
    assert_eq!((n, length), (path.steps, path.length), "{name}");
    for (cell, point) in path.cells.iter().zip(&path.points) {
        let centre = [-0.5 + f64::from(cell[0]), 1.0 + 2.0 * f64::from(cell[1]), 10.25 + 0.5 * f64::from(cell[2])];
        assert_eq!(*point, centre, "{name}: {cell:?}");
    }
}

/// The cube must be where it comes from the start, and where no wider one that comes from the start holds it.
fn check_narrowest(name: &str, grid: &Grid, from: [u32; 3], flags: &[u8], w: u32, [low, high]: [[u32; 3]; 2]) {
    // places of the cube that have these cells in the mesh: more than one where it hangs over
    let (places, steps) = grid.steps(from, w, flags);
    let (wider, wider_steps) = grid.steps(from, w + 1, flags);
    let is_here = |place: [u32; 3]| {
        (0..3).all(|axis| {
            place[axis].saturating_sub(w - 1) == low[axis] && (place[axis] + 1).min(grid.dims[axis]) == high[axis]
        })
    };
    let is_free = |place: [u32; 3]| {
        (0..8).all(|corner: u32| {
            let own = [0, 1, 2].map(|axis: usize| place[axis] + (corner >> axis & 1));
            wider_steps[wider.index(own)].is_none()
        })
    };
    let [nx, ny, nz] = places.dims;
    let mut all = (0..nx * ny * nz).map(|k| [k % nx, k / nx % ny, k / (nx * ny)]);
    let is_right = all.any(|place| is_here(place) && steps[places.index(place)].is_some() && is_free(place));
    assert!(is_right, "{name}: a cube of {w} cells at {low:?} to {high:?}");
}

#[test]
fn paths_are_those_of_a_search_over_cells_whatever_the_ray_axis() {
    let mut random = Random::new(4711);
    let (mut n_leaks, mut n_tight) = (0, 0);
    for number in 0..160 {
        let most = if number % 16 == 0 { 24 } else { 8 };
        let dims = [0; 3].map(|_| 1 + random.below(most) as u32);
        let mut grid = Grid::filled(dims, 0);
        // from scattered cells to a labyrinth
        let closed = 10 + random.below(50);
        for flag in &mut grid.flags {
            *flag = if random.below(100) < closed { 1 + random.below(2) as u8 } else { 0 };
        }
        let flags: &[u8] = random.one_of(&[&[0][..], &[0, 2], &[1, 2], &[0]]);
        let open: Vec<usize> = (0..grid.flags.len()).filter(|&index| flags.contains(&grid.flags[index])).collect();
        if open.is_empty() {
            continue;
        }
        let ends = [0; 2].map(|_| {
            let index = open[random.below(open.len() as u64) as usize] as u32;
            [index % dims[0], index / dims[0] % dims[1], index / (dims[0] * dims[1])]
        });
        check(&format!("grid {number} of seed 4711, {dims:?}, {ends:?}, {flags:?}"), &grid, ends, flags);
        match grid.found(0, ends, flags).path {
            Some(_) => n_leaks += 1,
            None => n_tight += 1,
        }
    }
    assert!(n_leaks > 40 && n_tight > 20, "{n_leaks} leaks, {n_tight} tight");
}

#[test]
fn walls_with_holes_are_passed_by_the_cube_that_fits() {
    let mut random = Random::new(11);
    for number in 0..24 {
        let dims = [0; 3].map(|_| 8 + random.below(5) as u32);
        let mut grid = Grid::filled(dims, 0);
        // one or two walls, each with a hole of its own size
        for wall in 0..1 + number % 2 {
            let axis = random.below(3) as usize;
            let at = 2 + 3 * wall + random.below(2) as u32;
            let (mut low, mut high) = ([0; 3], dims);
            (low[axis], high[axis]) = (at, at + 1 + random.below(2) as u32);
            grid.set(low, high, 1);
            for across in (0..3).filter(|&across| across != axis) {
                low[across] = random.below(u64::from(dims[across]) - 4) as u32;
                high[across] = low[across] + 1 + random.below(4) as u32;
            }
            grid.set(low, high, 0);
        }
        let corners = [[0; 3], dims.map(|n| n - 1)];
        if corners.iter().all(|corner| grid.flags[grid.index(*corner)] == 0) {
            check(&format!("walls {number} of seed 11"), &grid, corners, &[0]);
        }
    }
}

/// A casing of walls 2 cells thick around 8^3 cells, in a box with 3 cells around it.
fn casing() -> Grid {
    let mut grid = Grid::filled([18; 3], 0);
    grid.set([3; 3], [15; 3], 5);
    grid.set([5; 3], [13; 3], 0);
    grid
}

#[test]
fn a_tight_casing_has_no_path() {
    for axis in 0..3 {
        let found = casing().found(axis, [[7, 8, 9], [0, 17, 0]], &[]);
        assert_eq!((found.path, found.narrowest, found.flags), (None, None, vec![0]));
        assert_eq!([found.from.n_cells, found.to.n_cells], [512, 18 * 18 * 18 - 12 * 12 * 12]);
        // the wall is a passage, too
        let found = casing().found(axis, [[3, 3, 3], [14, 14, 14]], &[]);
        assert_eq!((found.path.unwrap().steps, found.flags), (33, vec![5]));
    }
}

#[test]
fn the_hole_of_a_casing_is_found_where_it_is() {
    let ends = [[9, 9, 9], [0, 0, 0]];
    for (low, high, width, through, middle) in [
        // a cell through the wall of high x, 2 cells thick: the first of the two
        ([13, 6, 11], [15, 7, 12], 1, 0, 13),
        // 3 x 4 cells through that of low y: the cube is on its way from 4 to 1 when no wider one holds it
        ([6, 3, 7], [9, 5, 11], 3, 1, 3),
    ] {
        for axis in 0..3 {
            let mut grid = casing();
            grid.set(low, high, 0);
            let place = grid.found(axis, ends, &[]).narrowest.unwrap();
            assert_eq!((place.width, place.cells[0][through]), (width, middle), "rays along {axis}: {place:?}");
            for across in (0..3).filter(|&across| across != through) {
                let is_inside = place.cells[0][across] >= low[across] && place.cells[1][across] <= high[across];
                assert!(is_inside, "rays along {axis}: {place:?}");
            }
        }
    }
}

#[test]
fn of_two_holes_the_path_takes_the_nearer_and_the_cube_the_wider() {
    let mut grid = casing();
    grid.set([13, 9, 9], [15, 10, 10], 0);
    grid.set([3, 6, 6], [5, 10, 10], 0);
    for axis in 0..3 {
        let found = grid.found(axis, [[12, 9, 9], [17, 9, 9]], &[]);
        let (path, place) = (found.path.unwrap(), found.narrowest.unwrap());
        assert_eq!((path.steps, path.cells), (5, vec![[12, 9, 9], [17, 9, 9]]));
        assert_eq!(place.width, 4);
        assert!(place.cells[1][0] <= 8, "{place:?}");
    }
}

#[test]
fn without_walls_nothing_is_narrow() {
    let found = Grid::filled([9, 1, 4], 0).found(0, [[0, 0, 3], [8, 0, 0]], &[]);
    assert_eq!((found.path.unwrap().steps, found.narrowest), (11, None));
    // but beyond the mesh there is background only
    let found = Grid::filled([9, 2, 4], 3).found(0, [[0, 0, 3], [8, 0, 0]], &[]);
    assert_eq!(found.narrowest.unwrap().width, 2);
}

#[test]
fn a_path_may_have_no_steps() {
    let found = Grid::filled([3; 3], 2).found(1, [[1; 3]; 2], &[]);
    let path = found.path.unwrap();
    assert_eq!((path.steps, path.length, path.cells), (0, 0.0, vec![[1; 3]]));
}

#[test]
fn points_outside_and_other_flags_are_errors() {
    let mesh = casing().mesh(0);
    let asked = |from: [f64; 3], to: [f64; 3], flags: &[u8]| {
        let question = Question::new(from, to).with_flags(flags.to_vec()).with_max_bytes(1 << 30);
        let error = leak(&mesh, &question, &Control::default()).unwrap_err();
        assert!(!error.hint().is_empty(), "{error}");
        (error.code(), error.to_string())
    };
    let (inside, wall) = ([8.5, 18.5, 14.0], [2.5, 18.5, 14.0]);
    let (code, text) = asked(inside, [17.5, 0.0, 10.0], &[]);
    assert_eq!(
        (code, &*text),
        ("job-value", "the end (17.5, 0, 10) lies outside of the mesh, which reaches from (-1, 0, 10) to (17, 36, 19)")
    );
    assert_eq!(asked([f64::NAN, 0.0, 12.0], inside, &[]).0, "job-value");
    let (code, text) = asked(inside, wall, &[]);
    assert_eq!(code, "job-conflict");
    assert_eq!(
        text,
        "the start (8.5, 18.5, 14) is in cell (9, 9, 8) of flag 0, but the end (2.5, 18.5, 14) is in cell (3, 9, 8) of flag 5"
    );
    let (code, text) = asked(inside, wall, &[0, 3]);
    assert_eq!(code, "job-value");
    assert!(text.ends_with("of flag 5, and a path may only use flags 0, 3"), "{text}");
    let small = Question::new(inside, inside).with_max_bytes(1000);
    assert_eq!(leak(&mesh, &small, &Control::default()).unwrap_err().code(), "memory");
    let cancelled = Control::default();
    cancelled.cancel.cancel();
    let question = small.with_max_bytes(1 << 30);
    assert_eq!(leak(&mesh, &question, &cancelled).unwrap_err().code(), "cancelled");
}

#[test]
fn points_on_lines_belong_to_the_cell_above_and_on_the_last_to_the_one_below() {
    let mesh = Grid::filled([3, 4, 5], 0).mesh(2);
    let question = Question::new([-1.0, 0.0, 10.0], [2.0, 8.0, 12.5]).with_max_bytes(1 << 30);
    let found = leak(&mesh, &question, &Control::default()).unwrap();
    assert_eq!([found.from.cell, found.to.cell], [[0; 3], [2, 3, 4]]);
    let question = set!(Question { from: [1.0, 2.0, 11.0], ..question });
    assert_eq!(leak(&mesh, &question, &Control::default()).unwrap().from.cell, [2, 1, 2]);
}
