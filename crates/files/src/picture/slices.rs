//! Slices: planes of cells side by side, in one scale.
//!
//! The first of the two axes of a plane points right, the second up. Every pixel has the colour of the cell at its middle. Lines
//! between cells are drawn where cells are wide enough.

use super::canvas::{LINE, PIXEL_BYTES, Picture, check_sides, legend_height};
use super::place::{Cut, Place, cell_at, ends};
use super::{Look, MARGIN, check_memory, coordinate};
use hexcast_core::base::control::{Control, at_once};
use hexcast_core::base::error::{Error, Result};
use hexcast_core::base::parallel::*;
use hexcast_core::grid::lines::{AXES, Lines};
use hexcast_derived::mesh::Mesh;

/// Pixels of the longest side of the mesh where nobody says.
const SIZE: u32 = 600;
/// Pixels of a cell from which on lines are drawn.
const WIDE: f64 = 6.0;
/// Pixels of a panel with its texts, at least.
const LEAST: u32 = 280;
/// Pixels that a thread draws between two rests, about.
const AT_ONCE: usize = 1 << 16;

/// Slices to be drawn, and how they look.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct Slices {
    /// The planes, in the order in which they are drawn.
    pub cuts: Vec<Cut>,
    /// Whether lines between cells are drawn, where cells have 6 pixels or more.
    pub has_lines: bool,
    /// Size, flags and colours.
    pub look: Look,
}

impl Slices {
    /// Some planes.
    pub fn new(cuts: Vec<Cut>) -> Slices {
        Slices { cuts, has_lines: true, look: Look::default() }
    }

    /// The planes at places along axes (0, 1, 2): each place along each axis. No axes are all three, no places are the middle.
    ///
    /// # Errors
    /// `job-value` where there is no such axis, or the mesh does not reach that far.
    pub fn at(mesh: &Mesh, axes: &[usize], places: &[Place]) -> Result<Slices> {
        Slices::of_lines(mesh.lines(), axes, places)
    }

    /// The same of a mesh that has these lines, and may not be made yet.
    ///
    /// # Errors
    /// Those of [`Slices::at`].
    pub fn of_lines(lines: &Lines, axes: &[usize], places: &[Place]) -> Result<Slices> {
        let axes = if axes.is_empty() { &[0, 1, 2] } else { axes };
        let places = if places.is_empty() { &[Place::Percent(50.0)] } else { places };
        let cuts = axes.iter().flat_map(|&axis| places.iter().map(move |&place| Cut::of_lines(lines, axis, place)));
        Ok(Slices::new(cuts.collect::<Result<_>>()?))
    }

    /// Draws lines between cells that are wide enough, or none.
    pub fn with_lines(mut self, has_lines: bool) -> Slices {
        self.has_lines = has_lines;
        self
    }

    /// Sets how they look.
    pub fn with_look(mut self, look: Look) -> Slices {
        self.look = look;
        self
    }

    /// Refuses what [`slices()`] would refuse of every mesh that has these lines.
    ///
    /// # Errors
    /// `job-value` and `memory` as for [`slices()`].
    pub fn check(&self, lines: &Lines) -> Result<()> {
        Layout::new(lines, self).map(|_| ())
    }
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
    fn new(lines: &Lines, cut: Cut, pixels: f64) -> Panel {
        let across = [[1, 2], [0, 2], [0, 1]][cut.axis];
        let ends = across.map(|axis| ends(lines, axis));
        let size = ends.map(|[low, high]| ((high - low) * pixels).round().max(1.0) as u32);
        let cells = [0, 1].map(|side| {
            let [low, high] = ends[side];
            let place = |pixel: u32| low + (f64::from(pixel) + 0.5) / f64::from(size[side]) * (high - low);
            let mut cells: Vec<u32> = (0..size[side]).map(|pixel| cell_at(lines, across[side], place(pixel))).collect();
            if side == 1 {
                cells.reverse();
            }
            cells
        });
        Panel { cut, across, size, cells }
    }

    /// Pixels of it with its texts.
    fn own_width(&self) -> u32 {
        self.size[0].max(LEAST)
    }

    /// The flags of all pixels, row after row from the top.
    async fn flags(&self, mesh: &Mesh, control: &Control) -> Result<Vec<u8>> {
        let width = self.size[0] as usize;
        let mut flags = vec![0; width * self.size[1] as usize];
        let n_rows = (AT_ONCE * current_num_threads() / width).max(1);
        for (block, rows) in flags.chunks_mut(n_rows * width).enumerate() {
            let of_row = |(row, out)| self.row_flags(mesh, block * n_rows + row, out);
            rows.par_chunks_mut(width).enumerate().try_for_each(of_row)?;
            control.rest().await?;
        }
        Ok(flags)
    }

    /// The flags of a row of pixels.
    fn row_flags(&self, mesh: &Mesh, row: usize, out: &mut [u8]) -> Result<()> {
        let mut last = None;
        for (&i, flag) in self.cells[0].iter().zip(out) {
            let mut cell = [self.cut.index; 3];
            (cell[self.across[0]], cell[self.across[1]]) = (i, self.cells[1][row]);
            *flag = match last {
                Some((known, flag)) if known == i => flag,
                _ => mesh.columns().flag(cell)?,
            };
            last = Some((i, *flag));
        }
        Ok(())
    }

    /// Draws the cells below a corner.
    async fn draw(
        &self,
        (picture, [left, top]): (&mut Picture, [u32; 2]),
        flags: &[u8],
        slices: &Slices,
        control: &Control,
    ) -> Result<()> {
        let colours = slices.look.colours();
        let lines: [Vec<bool>; 2] = [0, 1].map(|side| {
            let cells = &self.cells[side];
            let n = 1 + cells[0].abs_diff(cells[cells.len() - 1]);
            let is_wide = slices.has_lines && f64::from(self.size[side]) / f64::from(n) >= WIDE;
            (0..cells.len()).map(|pixel| is_wide && pixel > 0 && cells[pixel] != cells[pixel - 1]).collect()
        });
        let width = self.size[0] as usize;
        for (row, flags) in flags.chunks(width).enumerate() {
            if row % (AT_ONCE / width).max(1) == 0 {
                control.rest().await?;
            }
            for (column, &flag) in flags.iter().enumerate() {
                let darker = |channel: u8| (u32::from(channel) * 3 / 4) as u8;
                let is_line = lines[0][column] || lines[1][row];
                let rgb = colours[usize::from(flag)];
                let rgb = if is_line { rgb.map(darker) } else { rgb };
                picture.set(left + column as u32, top + row as u32, rgb);
            }
        }
        Ok(())
    }

    /// What is written above and below it.
    fn texts(&self, mesh: &Mesh) -> [String; 3] {
        let (axis, index) = (self.cut.axis, self.cut.index);
        let middle = 0.5 * (mesh.lines().line(axis, index) + mesh.lines().line(axis, index + 1));
        let range = |axis: usize| {
            let [low, high] = ends(mesh.lines(), axis).map(|end| coordinate(mesh, end));
            format!("{}: {low} .. {high}", AXES[axis])
        };
        let n = mesh.dims()[axis];
        let above = format!("{} = {} (cell {index} of {n})", AXES[axis], coordinate(mesh, middle));
        let [right, up] = self.across.map(range);
        [above, format!("right {right}"), format!("up {up}")]
    }
}

/// Where slices are on a picture: side by side, three in a row, or of more as many as there are rows.
struct Layout {
    panels: Vec<Panel>,
    /// Slices in a row.
    n_columns: usize,
    /// Pixels of the cells of all slices.
    n_pixels: u64,
    /// Pixels of the picture, without the legend.
    size: [u32; 2],
}

impl Layout {
    fn new(lines: &Lines, Slices { cuts, look, .. }: &Slices) -> Result<Layout> {
        if cuts.is_empty() || cuts.iter().any(|cut| cut.axis > 2 || cut.index >= lines.dims()[cut.axis]) {
            let message = format!("planes {cuts:?} of a mesh of {:?} cells", lines.dims());
            return Err(Error::new("job-value", message, "name at least one plane of cells, counted from 0"));
        }
        let size = look.size.unwrap_or(SIZE);
        check_sides([size; 2])?;
        let lengths = [0, 1, 2].map(|axis| ends(lines, axis)).map(|[low, high]| high - low);
        let pixels = f64::from(size) / lengths.into_iter().fold(0.0, f64::max);
        let panels: Vec<Panel> = cuts.iter().map(|&cut| Panel::new(lines, cut, pixels)).collect();
        let n_pixels = panels.iter().map(|panel| u64::from(panel.size[0]) * u64::from(panel.size[1])).sum();
        let n = panels.len();
        let n_columns = if n <= 3 { n } else { (2..).find(|columns| columns * columns >= n).unwrap_or(2) };
        let widths = |row: &[Panel]| row.iter().map(|panel| panel.own_width() + MARGIN).sum::<u32>() + MARGIN;
        let width = panels.chunks(n_columns).map(widths).max().unwrap_or(1);
        let height = 2 * MARGIN + panels.chunks(n_columns).map(row_height).sum::<u32>();
        check_sides([width, height])?;
        // the flag of each, and what becomes of it; what the legend needs follows from what is seen
        let n_bytes = n_pixels + PIXEL_BYTES * u64::from(width) * u64::from(height);
        check_memory(&format!("a picture of {width} x {height} pixels"), n_bytes, look.max_bytes)?;
        Ok(Layout { panels, n_columns, n_pixels, size: [width, height] })
    }
}

/// Pixels from a row of slices to the next.
fn row_height(row: &[Panel]) -> u32 {
    row.iter().map(|panel| panel.size[1]).max().unwrap_or(0) + 3 * LINE + MARGIN
}

/// Draws slices side by side, in one scale, with a legend of the flags on them.
///
/// # Errors
/// `job-value` where there is no slice, one lies beyond the mesh, or the picture would have no pixel or more than 32,768 on a side; `memory`
/// where it takes more than is allowed; `io` where the columns are in a store that fails; `cancelled`.
pub fn slices(mesh: &Mesh, slices: &Slices, control: &Control) -> Result<Picture> {
    at_once(slices_with_rests(mesh, slices, &control.without_pauses()))
}

/// Like [`slices()`], with a rest every some rows of pixels ([`Control::rest`]).
///
/// # Errors
/// Those of [`slices()`].
pub async fn slices_with_rests(mesh: &Mesh, slices: &Slices, control: &Control) -> Result<Picture> {
    let look = &slices.look;
    let Layout { panels, n_columns, n_pixels, size: [width, height] } = Layout::new(mesh.lines(), slices)?;
    let mut flags = Vec::new();
    let mut has = [false; 256];
    for panel in &panels {
        let of_panel = panel.flags(mesh, control).await?;
        of_panel.chunk_by(u8::eq).for_each(|equal| has[usize::from(equal[0])] = true);
        flags.push(of_panel);
    }
    let legend = look.legend(mesh, &has);
    let tall = height + legend_height(width, &legend);
    let mut picture = Picture::new(width, tall, look.max_bytes.saturating_sub(n_pixels))?;
    let mut top = MARGIN;
    let mut of_panel = flags.iter();
    for row in panels.chunks(n_columns) {
        let mut left = MARGIN;
        for panel in row {
            let [above, right, up] = panel.texts(mesh);
            let own = panel.own_width();
            picture.text([left, top], &above, own);
            let flags = of_panel.next().map_or(&[][..], Vec::as_slice);
            panel.draw((&mut picture, [left, top + LINE]), flags, slices, control).await?;
            let below = top + LINE + panel.size[1] + 3;
            picture.text([left, below], &right, own);
            picture.text([left, below + LINE], &up, own);
            left += own + MARGIN;
        }
        top += row_height(row);
    }
    picture.legend(top, &legend);
    Ok(picture)
}
