//! The lines of a mesh as a drawing, SVG: seen along z, y and x, with the boxes of all geometries, in the world's proportions.
//!
//! Lines, geometries -> SVG. It needs no mesh, so that lines can be looked at before cells are made.
//! Cost: two pieces of some 20 bytes a line.

use std::fmt::Write;

use crate::colours::colour;
use hexcast_core::base::error::{Error, Result};
use hexcast_core::grid::domain::BoundingBox;
use hexcast_core::grid::lines::{AXES, Lines};
use hexcast_core::input::geometry::Geometry;

/// Most lines of an axis.
const MAX_LINES: u32 = 10_000;
/// Pixels that the drawing has for the sides of boxes, across and down.
const ROOM: [f64; 2] = [880.0, 1000.0];
/// Pixels between views, and for the text above each.
const GAP: f64 = 24.0;
/// Pixels of a line of the legend.
const ROW: f64 = 20.0;

/// A box seen along an axis, and where it is drawn.
struct View {
    /// The axes to the right and up.
    across: [usize; 2],
    /// Its upper left corner.
    place: [f64; 2],
}

struct Drawing<'a> {
    lists: [Vec<f64>; 3],
    geometries: &'a [Geometry],
    /// Pixels of a unit of length.
    scale: f64,
    text: String,
}

/// Draws lines and the boxes of geometries, in the colours of their flags, as SVG.
///
/// # Errors
/// `too-many-cells` where an axis has more than 10,000 lines.
pub fn lines_svg(lines: &Lines, geometries: &[Geometry]) -> Result<String> {
    if let Some(axis) = (0..3).find(|&axis| lines.dims()[axis] >= MAX_LINES) {
        let n = lines.dims()[axis];
        let message = format!("{n} cells along {}: lines are drawn of at most {}", AXES[axis], MAX_LINES - 1);
        return Err(Error::new("too-many-cells", message, "draw those of larger cells, or of a window"));
    }
    let lists = [0, 1, 2].map(|axis| lines.list(axis));
    let extent = [0, 1, 2].map(|axis: usize| lists[axis][lists[axis].len() - 1] - lists[axis][0]);
    let scale = (ROOM[0] / (extent[0] + extent[1])).min(ROOM[1] / (extent[1] + extent[2]));
    let [x, y, z] = extent.map(|extent| extent * scale);
    let views = [
        View { across: [0, 1], place: [GAP, GAP] },
        View { across: [0, 2], place: [GAP, y + 2.0 * GAP] },
        View { across: [1, 2], place: [x + 2.0 * GAP, y + 2.0 * GAP] },
    ];
    let (width, below) = (x + y + 3.0 * GAP, y + z + 3.0 * GAP);
    let height = below + ROW * geometries.len() as f64;
    let mut drawing = Drawing { lists, geometries, scale, text: String::new() };
    drawing.put(format_args!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" width=\"{width:.0}\" font-family=\"sans-serif\" font-size=\"13\">\n\
         <rect width=\"{width:.0}\" height=\"{height:.0}\" fill=\"#fff\"/>\n"
    ));
    views.iter().for_each(|view| drawing.view(view));
    for (index, geometry) in geometries.iter().enumerate() {
        drawing.legend(geometry, below + ROW * index as f64);
    }
    drawing.put(format_args!("</svg>\n"));
    Ok(drawing.text)
}

impl Drawing<'_> {
    fn put(&mut self, what: std::fmt::Arguments) {
        // a text takes everything
        let _ = self.text.write_fmt(what);
    }

    /// Where a place along an axis is in a view, from its left or its top.
    fn at(&self, view: &View, side: usize, place: f64) -> f64 {
        let list = &self.lists[view.across[side]];
        let length = if side == 0 { place - list[0] } else { list[list.len() - 1] - place };
        view.place[side] + length * self.scale
    }

    fn view(&mut self, view: &View) {
        let [right, up] = view.across;
        let [n_right, n_up] = [right, up].map(|axis| self.lists[axis].len() - 1);
        let [left, top] = view.place;
        let name = format!("{} to the right, {} up: {n_right} x {n_up} cells", AXES[right], AXES[up]);
        self.put(format_args!("<text x=\"{left:.2}\" y=\"{:.2}\">{name}</text>\n", top - 6.0));
        for index in 0..self.geometries.len() {
            if let Some(bounds) = self.geometries[index].bounding_box() {
                self.body(view, bounds, index);
            }
        }
        let ends = |axis: usize| [self.lists[axis][0], self.lists[axis][self.lists[axis].len() - 1]];
        let [x0, x1] = ends(right).map(|place| self.at(view, 0, place));
        let [y1, y0] = ends(up).map(|place| self.at(view, 1, place));
        let mut path = String::new();
        for &line in &self.lists[right] {
            let _ = write!(path, "M{:.2} {y0:.2}V{y1:.2}", self.at(view, 0, line));
        }
        for &line in &self.lists[up] {
            let _ = write!(path, "M{x0:.2} {:.2}H{x1:.2}", self.at(view, 1, line));
        }
        self.put(format_args!("<path d=\"{path}\" stroke=\"#234\" stroke-width=\"0.35\" fill=\"none\"/>\n"));
    }

    /// The box of a geometry, as far as it lies within that of the lines.
    fn body(&mut self, view: &View, bounds: BoundingBox, index: usize) {
        let within = |side: usize| {
            let list = &self.lists[view.across[side]];
            let clamped = |end: f64| end.clamp(list[0], list[list.len() - 1]);
            bounds.map(|corner| self.at(view, side, clamped(corner[view.across[side]])))
        };
        let ([x0, x1], [y1, y0]) = (within(0), within(1));
        let colour = colour_of(&self.geometries[index]);
        // a sheet has no thickness: as a rectangle it would not be drawn
        self.put(format_args!(
            "<path d=\"M{x0:.2} {y0:.2}H{x1:.2}V{y1:.2}H{x0:.2}Z\" fill=\"{colour}\" fill-opacity=\"0.4\" stroke=\"{colour}\"/>\n"
        ));
    }

    fn legend(&mut self, geometry: &Geometry, top: f64) {
        let (colour, name) = (colour_of(geometry), escaped(&geometry.name));
        self.put(format_args!(
            "<rect x=\"{GAP}\" y=\"{:.2}\" width=\"12\" height=\"12\" fill=\"{colour}\"/><text x=\"{:.2}\" y=\"{:.2}\">{} {name}</text>\n",
            top - 8.0,
            GAP + 20.0,
            top + 3.0,
            geometry.flag,
        ));
    }
}

fn colour_of(geometry: &Geometry) -> String {
    let [red, green, blue] = colour(geometry.flag);
    format!("#{red:02x}{green:02x}{blue:02x}")
}

/// A name as text of XML, on one line.
fn escaped(name: &str) -> String {
    let one_line: String = name.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    quick_xml::escape::escape(&one_line).into_owned()
}
