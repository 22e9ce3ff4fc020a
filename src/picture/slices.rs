//! Slices: planes of cells side by side, in one scale.
//!
//! The first of the two axes of a plane points right, the second up. Every pixel has the colour of the cell at its middle. Lines
//! between cells are drawn where cells are wide enough.

use super::canvas::{LINE, Picture, colour, legend_height};
use super::{MARGIN, coordinate, legend};
use crate::error::{Error, Result};
use crate::mesh::Mesh;
use crate::parallel::*;

/// Pixels of a cell from which on lines are drawn.
const WIDE: f64 = 6.0;
/// Pixels of a panel with its texts, at least.
const LEAST: u32 = 280;
const NAMES: [&str; 3] = ["x", "y", "z"];

/// A plane of cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cut {
    /// The axis across it: 0, 1 or 2.
    pub axis: usize,
    /// Index of the cells along this axis.
    pub index: u32,
}

impl Cut {
    /// The plane of cells at a coordinate of an axis; of two that it lies between, the upper one.
    ///
    /// # Errors
    /// `job-value` where there is no such axis, or the mesh does not reach that far.
    pub fn at(mesh: &Mesh, axis: usize, coordinate: f64) -> Result<Cut> {
        if axis > 2 {
            return Err(Error::new("job-value", format!("there is no axis {axis}"), "axes are 0, 1 and 2"));
        }
        let n = mesh.dims()[axis];
        let [low, high] = [0, n].map(|index| mesh.lines.line(axis, index));
        if !(low..=high).contains(&coordinate) {
            let message = format!(
                "{coordinate} is not within the mesh, which reaches from {low} to {high} along {}",
                NAMES[axis]
            );
            return Err(Error::new("job-value", message, "choose a place within the mesh"));
        }
        Ok(Cut { axis, index: cell_at(mesh, axis, coordinate) })
    }
}

/// The cell of an axis that a coordinate lies in; the first or last beyond the mesh.
fn cell_at(mesh: &Mesh, axis: usize, coordinate: f64) -> u32 {
    let (mut low, mut high) = (0, mesh.dims()[axis] - 1);
    while low < high {
        let middle = low + (high - low).div_ceil(2);
        if mesh.lines.line(axis, middle) <= coordinate { low = middle } else { high = middle - 1 }
    }
    low
}

/// One slice on the picture.
struct Panel {
    cut: Cut,
    /// The axes to the right and up.
    across: [usize; 2],
    /// Pixels of the cells.
    size: [u32; 2],
    /// The cell at the middle of each pixel, from the left and from the top.
    cells: [Vec<u32>; 2],
}

impl Panel {
    fn new(mesh: &Mesh, cut: Cut, pixels: f64) -> Panel {
        let across = [[1, 2], [0, 2], [0, 1]][cut.axis];
        let ends = across.map(|axis| [0, mesh.dims()[axis]].map(|index| mesh.lines.line(axis, index)));
        let size = ends.map(|[low, high]| ((high - low) * pixels).round().max(1.0) as u32);
        let cells = [0, 1].map(|side| {
            let [low, high] = ends[side];
            let place = |pixel: u32| low + (f64::from(pixel) + 0.5) / f64::from(size[side]) * (high - low);
            let mut cells: Vec<u32> = (0..size[side]).map(|pixel| cell_at(mesh, across[side], place(pixel))).collect();
            if side == 1 {
                cells.reverse();
            }
            cells
        });
        Panel { cut, across, size, cells }
    }

    /// The flags of all pixels, row after row from the top.
    fn flags(&self, mesh: &Mesh) -> Result<Vec<u8>> {
        let mut flags = vec![0; self.size[0] as usize * self.size[1] as usize];
        flags.par_chunks_mut(self.size[0] as usize).enumerate().try_for_each(|(row, out)| {
            let mut last = None;
            for (&i, flag) in self.cells[0].iter().zip(out) {
                let mut cell = [self.cut.index; 3];
                (cell[self.across[0]], cell[self.across[1]]) = (i, self.cells[1][row]);
                *flag = match last {
                    Some((known, flag)) if known == i => flag,
                    _ => mesh.columns.flag(cell)?,
                };
                last = Some((i, *flag));
            }
            Ok(())
        })?;
        Ok(flags)
    }

    /// Draws the cells below a corner.
    fn draw(&self, picture: &mut Picture, [left, top]: [u32; 2], flags: &[u8]) {
        let lines: [Vec<bool>; 2] = [0, 1].map(|side| {
            let cells = &self.cells[side];
            let n = 1 + cells[0].abs_diff(cells[cells.len() - 1]);
            let is_wide = f64::from(self.size[side]) / f64::from(n) >= WIDE;
            (0..cells.len()).map(|pixel| is_wide && pixel > 0 && cells[pixel] != cells[pixel - 1]).collect()
        });
        for (row, flags) in flags.chunks(self.size[0] as usize).enumerate() {
            for (column, &flag) in flags.iter().enumerate() {
                let darker = |channel: u8| (u32::from(channel) * 3 / 4) as u8;
                let is_line = lines[0][column] || lines[1][row];
                let rgb = if is_line { colour(flag).map(darker) } else { colour(flag) };
                picture.set(left + column as u32, top + row as u32, rgb);
            }
        }
    }

    /// What is written above and below it.
    fn texts(&self, mesh: &Mesh) -> [String; 3] {
        let (axis, index) = (self.cut.axis, self.cut.index);
        let middle = 0.5 * (mesh.lines.line(axis, index) + mesh.lines.line(axis, index + 1));
        let range = |axis: usize| {
            let [low, high] = [0, mesh.dims()[axis]].map(|index| coordinate(mesh, mesh.lines.line(axis, index)));
            format!("{}: {low} .. {high}", NAMES[axis])
        };
        let n = mesh.dims()[axis];
        let above = format!("{} = {} (cell {index} of {n})", NAMES[axis], coordinate(mesh, middle));
        let [right, up] = self.across.map(range);
        [above, format!("right {right}"), format!("up {up}")]
    }
}

/// Draws slices side by side, the longest side of the mesh in `size` pixels, with a legend of the flags on them.
///
/// # Errors
/// `job-value` where there is no slice, one lies beyond the mesh, or the picture would be larger than 32,768 pixels; `io` where the columns
/// are in a store that fails.
pub fn slices(mesh: &Mesh, cuts: &[Cut], size: u32) -> Result<Picture> {
    if cuts.is_empty() || cuts.iter().any(|cut| cut.axis > 2 || cut.index >= mesh.dims()[cut.axis]) {
        let message = format!("planes {cuts:?} of a mesh of {:?} cells", mesh.dims());
        return Err(Error::new("job-value", message, "name at least one plane of cells, counted from 0"));
    }
    let length = |axis: usize| mesh.lines.line(axis, mesh.dims()[axis]) - mesh.lines.line(axis, 0);
    let longest = length(0).max(length(1)).max(length(2));
    let panels: Vec<Panel> = cuts.iter().map(|&cut| Panel::new(mesh, cut, f64::from(size) / longest)).collect();
    // three in a row, or of more as many as there are rows
    let n_columns = if panels.len() <= 3 { panels.len() } else { (2..).find(|n| n * n >= panels.len()).unwrap_or(2) };
    let flags: Vec<Vec<u8>> = panels.iter().map(|panel| panel.flags(mesh)).collect::<Result<_>>()?;
    let shown: Vec<u8> = flags.iter().flat_map(|flags| flags.chunk_by(u8::eq).map(|equal| equal[0])).collect();
    let legend = legend(mesh, shown);
    let widths = |row: &[Panel]| row.iter().map(|panel| panel.size[0].max(LEAST) + MARGIN).sum::<u32>() + MARGIN;
    let height = |row: &[Panel]| row.iter().map(|panel| panel.size[1]).max().unwrap_or(0) + 3 * LINE + MARGIN;
    let width = panels.chunks(n_columns).map(widths).max().unwrap_or(1);
    let heights: u32 = panels.chunks(n_columns).map(height).sum();
    let mut picture = Picture::new(width, MARGIN + heights + legend_height(width, &legend) + MARGIN)?;
    let mut top = MARGIN;
    let mut of_panel = flags.iter();
    for row in panels.chunks(n_columns) {
        let mut left = MARGIN;
        for panel in row {
            let [above, right, up] = panel.texts(mesh);
            let own = panel.size[0].max(LEAST);
            picture.text([left, top], &above, own);
            panel.draw(&mut picture, [left, top + LINE], of_panel.next().map_or(&[], Vec::as_slice));
            let below = top + LINE + panel.size[1] + 3;
            picture.text([left, below], &right, own);
            picture.text([left, below + LINE], &up, own);
            left += own + MARGIN;
        }
        top += height(row);
    }
    picture.legend(top, &legend);
    Ok(picture)
}
