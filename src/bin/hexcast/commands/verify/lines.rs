//! The lines that a job asks for, and which cells of the box a mesh has.
//!
//! Of `cells`, `dims` and `cell_size` the lines follow from the job; of `max_cell_size` the size is that of the file, and it is no larger than
//! asked for. Lists are those of the job. Of generated lines there are many that keep what is promised: those of the file shall keep it, or
//! where the file has not all of them those that the mesher generates. Where a box is cut in parts is the mesher's choice, too.

use std::ops::Range;

use glam::DVec3;
use hexcast::job::{DEFAULT_CELLS, GeometryJob, GradedJob, Job, Padding, PerAxis};
use hexcast::mesh::Mesh;
use hexcast::{Error, Result};

const AXES: [&str; 3] = ["x", "y", "z"];
/// Most cells along an axis that can be meshed.
const MOST: f64 = 262_144.0;

pub(super) struct Grid {
    /// All lines of the box, equally spaced or not.
    pub(super) lists: [Vec<f64>; 3],
    /// Size of the smallest cell on each axis.
    pub(super) unit: [f64; 3],
    is_equal: bool,
    /// The cells of the mesh, counted in the box; a halo may reach beyond it.
    pub(super) cells: [Range<i64>; 3],
    /// Sentences about lines that are not those that the job asks for.
    pub(super) wrong: Vec<String>,
}

/// The boxes around geometries.
pub(super) type Boxes<'a> = [([DVec3; 2], &'a GeometryJob)];

impl Grid {
    pub(super) fn new(job: &Job, mesh: &Mesh, boxes: &Boxes, generated: Option<&[Vec<f64>; 3]>) -> Result<Grid> {
        let of_file = || [0, 1, 2].map(|axis| mesh.lines().list(axis));
        let asked = Asked::new(job, mesh, boxes);
        let mut wrong = Vec::new();
        let (lists, is_listed) = match (&job.lines, &job.graded) {
            (Some(lines), _) => ([&lines.x, &lines.y, &lines.z].map(Vec::clone), true),
            (None, Some(graded)) => {
                let lists = generated.cloned().unwrap_or_else(of_file);
                wrong.extend((0..3).filter_map(|axis| asked.broken(&lists[axis], axis, graded, boxes)));
                (lists, true)
            }
            (None, None) => (asked.lists(), false),
        };
        if lists.iter().any(|list| list.len() < 2) {
            return Err(Error::new("lines-wrong", "an axis of the job has no cell", "give two lines along every axis"));
        }
        let even = [0, 1, 2].map(|axis: usize| if is_listed { even(&lists[axis]) } else { None });
        let is_equal = !is_listed || even.iter().all(Option::is_some);
        let smallest = |axis: usize| lists[axis].windows(2).map(|two| two[1] - two[0]).fold(f64::INFINITY, f64::min);
        let unit = match (is_listed, is_equal) {
            (false, _) => asked.size,
            // the lines below hold it to the lists
            (true, true) => mesh.lines().smallest(),
            (true, false) => [0, 1, 2].map(|axis| even[axis].unwrap_or_else(|| smallest(axis))),
        };
        let mut grid = Grid { lists, unit, is_equal, cells: [0..0, 0..0, 0..0], wrong };
        for axis in 0..3 {
            let (first, end) = grid.place(job, mesh, axis);
            grid.cells[axis] = first..end;
            if !grid.has_lines_of(mesh, axis, is_listed) {
                let (n, from) = (mesh.lines().dims()[axis], mesh.lines().origin()[axis]);
                let found =
                    format!("along {} it has {n} cells of {} from {from}", AXES[axis], mesh.lines().smallest()[axis]);
                let (unit, ends) = (grid.unit[axis], [first, end].map(|cell| grid.line(axis, cell)));
                grid.wrong.push(format!(
                    "{found}, the job asks for {} cells of {unit} from {} to {}",
                    end - first,
                    ends[0],
                    ends[1]
                ));
            }
        }
        Ok(grid)
    }

    /// The cells of the mesh along an axis: those that the job names, or of a part those that begin where the file begins.
    fn place(&self, job: &Job, mesh: &Mesh, axis: usize) -> (i64, i64) {
        let (n, halo) = (self.n_cells(axis), i64::from(job.halo.unwrap_or(0)));
        let (first, end) = match (job.window, job.part) {
            (Some(ends), _) => (i64::from(ends[axis]), i64::from(ends[axis + 3])),
            (None, None) => return (0, n),
            (None, Some(part)) => {
                let begins = |first: &i64| self.line(axis, first - halo) == mesh.lines().origin()[axis];
                let first = (0..n).find(begins).unwrap_or(0);
                let before: u32 = part.of[..axis].iter().product();
                let (nth, of) = ((part.index - 1) / before % part.of[axis], part.of[axis]);
                let end = first + i64::from(mesh.lines().dims()[axis]) - 2 * halo;
                // the first part, and no other, begins where the box does; and the last ends there
                let is_nth = (first == 0) == (nth == 0) && (end == n) == (nth + 1 == of);
                if is_nth { (first, end) } else { (0, 0) }
            }
        };
        (first - halo, end + halo)
    }

    fn has_lines_of(&self, mesh: &Mesh, axis: usize, is_listed: bool) -> bool {
        let (first, n) = (self.cells[axis].start, self.cells[axis].end - self.cells[axis].start);
        let is_line = |line: u32| mesh.lines().line(axis, line) == self.line(axis, first + i64::from(line));
        let has_lines = match self.is_equal {
            false => (0..=mesh.lines().dims()[axis]).all(is_line),
            true => mesh.lines().spacing().is_some_and(|size| size[axis] == self.unit[axis]) && is_line(0),
        };
        let gives = |(index, line): (usize, &f64)| *line == self.line(axis, index as i64);
        let is_even = !(is_listed && self.is_equal) || self.lists[axis].iter().enumerate().all(gives);
        i64::from(mesh.lines().dims()[axis]) == n && has_lines && is_even
    }

    pub(super) fn n_cells(&self, axis: usize) -> i64 {
        self.lists[axis].len() as i64 - 1
    }

    /// A line, also beyond the box, where cells are as large as the last.
    fn line(&self, axis: usize, index: i64) -> f64 {
        let list = &self.lists[axis];
        if self.is_equal {
            return list[0] + index as f64 * self.unit[axis];
        }
        let cell = index.clamp(0, list.len() as i64 - 2) as usize;
        match usize::try_from(index).ok().and_then(|index| list.get(index)) {
            Some(line) => *line,
            None => list[cell] + (index - cell as i64) as f64 * (list[cell + 1] - list[cell]),
        }
    }

    /// A place from the centre of cell 0, in the smallest cells.
    pub(super) fn in_cells(&self, axis: usize, world: f64) -> f64 {
        let list = &self.lists[axis];
        let first = if self.is_equal { 1.0 } else { (list[1] - list[0]) / self.unit[axis] };
        (world - list[0]) / self.unit[axis] - 0.5 * first
    }

    /// Centres and faces of the cells of the mesh that are in the box, in units of which the smallest cell has 2^bits.
    pub(super) fn places(&self, axis: usize, bits: u32) -> [Vec<i32>; 2] {
        let cells = self.cells[axis].start.max(0) as usize..self.cells[axis].end.clamp(0, self.n_cells(axis)) as usize;
        let (list, cell) = (&self.lists[axis], f64::from(1u32 << bits));
        let place = |world: f64| (self.in_cells(axis, world) * cell).round_ties_even() as i32;
        if self.is_equal {
            let centre = |index: usize| (index as i32) << bits;
            let face = |index: usize| centre(index) - (1 << bits >> 1);
            return [cells.clone().map(centre).collect(), (cells.start..=cells.end).map(face).collect()];
        }
        let centre = |index: usize| place(0.5 * (list[index] + list[index + 1]));
        [cells.clone().map(centre).collect(), list[cells.start..=cells.end].iter().map(|&line| place(line)).collect()]
    }

    /// The middle of the last cell, as [`Grid::in_cells`].
    pub(super) fn last_centre(&self, axis: usize) -> f64 {
        let list = &self.lists[axis];
        let last = list.len() - 2;
        if self.is_equal { last as f64 } else { self.in_cells(axis, 0.5 * (list[last] + list[last + 1])) }
    }
}

/// What a job asks for in equal cells: the box, sizes and numbers; and the ends of the box of others.
struct Asked {
    low: [f64; 3],
    high: [f64; 3],
    size: [f64; 3],
    n: [f64; 3],
    padding: [u32; 3],
}

impl Asked {
    fn new(job: &Job, mesh: &Mesh, boxes: &Boxes) -> Asked {
        let around = |[low, high]: [DVec3; 2], of: &([DVec3; 2], _)| [low.min(of.0[0]), high.max(of.0[1])];
        let around = boxes.iter().fold([DVec3::INFINITY, DVec3::NEG_INFINITY], around);
        let length = if let Some(Padding::Length(length)) = job.padding { length.each() } else { [0.0; 3] };
        let padding = if let Some(Padding::Cells(cells)) = job.padding { cells.each() } else { [0; 3] };
        let low = [0, 1, 2].map(|axis| job.domain.map_or(around[0][axis], |ends| ends[axis]) - length[axis]);
        let high = [0, 1, 2].map(|axis| job.domain.map_or(around[1][axis], |ends| ends[axis + 3]) + length[axis]);
        let extent = [0, 1, 2].map(|axis| high[axis] - low[axis]);
        let longest = extent.into_iter().fold(0.0, f64::max);
        let size = [0, 1, 2].map(|axis| match (job.dims, job.cell_size, job.max_cell_size) {
            (Some(dims), ..) => extent[axis] / f64::from(dims[axis]),
            (_, Some(size), _) => size.each()[axis],
            // that it is as large as can be is not checked
            (.., Some(most)) => mesh.lines().smallest()[axis].min(most * (1.0 + 1e-12)),
            _ => longest / f64::from(job.cells.unwrap_or(DEFAULT_CELLS)),
        });
        let n = [0, 1, 2].map(|axis| {
            let ratio = extent[axis] / size[axis];
            // what coordinates of files may be off
            let greatest = around[0][axis].abs().max(around[1][axis].abs()) * f64::from(f32::EPSILON);
            let rounding = if job.domain.is_some() { 0.0 } else { (greatest / size[axis]).min(0.01) };
            let n = match (job.dims, job.max_cell_size) {
                (Some(dims), _) => dims[axis].into(),
                (None, Some(_)) => ratio.round(),
                (None, None) => (ratio - 1e-9 - rounding).ceil(),
            };
            (n.max(1.0) + 2.0 * f64::from(padding[axis])).min(MOST)
        });
        Asked { low, high, size, n, padding }
    }

    fn lists(&self) -> [Vec<f64>; 3] {
        [0, 1, 2].map(|axis| {
            let first = self.low[axis] - f64::from(self.padding[axis]) * self.size[axis];
            (0..=self.n[axis] as u32).map(|line| first + f64::from(line) * self.size[axis]).collect()
        })
    }

    /// What generated lines do not keep of what is promised.
    fn broken(&self, list: &[f64], axis: usize, job: &GradedJob, boxes: &Boxes) -> Option<String> {
        let (most, layers) =
            (job.max_size.each()[axis], job.absorbing.map_or(0, |cells| PerAxis::each(cells)[axis]) as usize);
        let (least, growth) = (job.min_size.unwrap_or(most * 1e-3), job.growth.unwrap_or(hexcast::job::DEFAULT_GROWTH));
        let (low, high, slack) = (self.low[axis], self.high[axis], 1.0 + 1e-9);
        let says = |what: String| Some(format!("along {} {what}", AXES[axis]));
        let inner = list.get(layers..list.len().saturating_sub(layers)).unwrap_or_default();
        if inner.first() != Some(&low) || inner.last() != Some(&high) {
            return says(format!("they do not reach from {low} to {high}, with {layers} cells beyond"));
        }
        let sizes: Vec<f64> = list.windows(2).map(|two| two[1] - two[0]).collect();
        if let Some(size) = sizes.iter().find(|&&size| size * slack < least || size > most * slack) {
            return says(format!("a cell is {size} long, not {least} to {most}"));
        }
        if let Some(two) = sizes.windows(2).find(|two| two[0].max(two[1]) > two[0].min(two[1]) * growth * slack) {
            return says(format!("cells of {} and {} are neighbours, with a growth of {growth}", two[0], two[1]));
        }
        let has_metal = boxes.iter().any(|(_, entry)| entry.metal);
        let broken = |([from, to], entry): &([DVec3; 2], &GeometryJob)| {
            let (from, to) = (from[axis], to[axis]);
            let ends = [(from, 2.0 / 3.0), (to, 1.0 / 3.0)].into_iter().filter(|(end, _)| low < *end && *end < high);
            let lost = ends.filter(|(end, third)| {
                let after = list.partition_point(|line| line < end).clamp(1, list.len() - 1);
                let [before, behind] = [list[after - 1], list[after]];
                // ends that nearly meet are one, and an edge of metal lies at a third of a cell
                let is_third = has_metal && (before + third * (behind - before) - end).abs() < least;
                (end - before).min(behind - end) >= least && !is_third
            });
            let n_across = list.windows(2).filter(|two| two[0] < to && two[1] > from).count();
            let is_within = low <= from && to <= high && to - from >= least;
            let few = entry.min_cells.filter(|&min| is_within && n_across < min as usize);
            let within = list.windows(2).filter(|two| two[0] >= from && two[1] <= to).map(|two| two[1] - two[0]);
            let large = within.filter(|&size| entry.max_size.is_some_and(|most| size > most * slack));
            let lost = lost.map(|(end, _)| format!("the end of {} at {end} has no line", entry.file));
            let few = few.map(|min| format!("{} has {n_across} cells across it, not {min}", entry.file));
            lost.chain(few).chain(large.map(|size| format!("a cell within {} is {size} long", entry.file))).next()
        };
        boxes.iter().find_map(broken).and_then(says)
    }
}

/// The spacing of lines that are equally spaced to the last bit: the shortest number that gives them all, else one beside the mean.
fn even(lines: &[f64]) -> Option<f64> {
    let gives = |size: &f64| lines.iter().enumerate().all(|(index, line)| lines[0] + index as f64 * size == *line);
    let mean = (lines[lines.len() - 1] - lines[0]) / (lines.len() - 1) as f64;
    let short = (0..17).filter_map(|digits| format!("{mean:.digits$e}").parse().ok());
    let beside = (-4..=4).map(|off| f64::from_bits(mean.to_bits().wrapping_add_signed(off)));
    short.chain(beside).chain([lines[1] - lines[0]]).find(gives)
}
