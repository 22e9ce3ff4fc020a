//! Takes the geometries that are decided separately out of a frame: those that are not closed, and those with cells along
//! their surfaces.

use crate::base::control::Control;
use crate::base::error::{Error, Result};
use crate::grid::closed::Closed;
use crate::grid::frame::{Frame, Ranks, SnappedFacet, in_window};
use crate::grid::lines::Lines;
use crate::grid::rays::Rays;
use crate::input::geometry::{Fill, Geometry, Open};
use crate::input::job::Rule;
use crate::open_surfaces::open::{OpenPart, Shift, Surface, Votes};
use crate::open_surfaces::sheet::Sheet;
use crate::stages::axis_crossings::{AxisCasts, n_expected};
use crate::stages::cast::Cast;

/// A part of a geometry that rays of the frame do not decide.
pub struct Part {
    /// Index of the geometry in the job.
    pub(super) geometry: usize,
    pub(super) rank: u8,
    /// Whether its cells are those that it does not decide to be inside.
    pub(super) invert: bool,
    pub(super) kind: Kind,
}

pub(super) enum Kind {
    Open(OpenPart),
    /// A geometry whose rays decide, to be inverted.
    Inverted(Frame),
    Sheet {
        fill: Fill,
        shell: bool,
        facets: Vec<SnappedFacet>,
    },
}

/// What decides a part, for points.
pub(crate) enum Apart {
    Open(OpenPart),
    /// The facets of a geometry whose rays decide, to be inverted.
    Inverted(Vec<SnappedFacet>),
    /// Cells along a surface.
    Along,
}

impl Part {
    pub(crate) fn rank(&self) -> u8 {
        self.rank
    }

    /// Whether it has the places that it does not decide to be inside.
    pub(crate) fn inverts(&self) -> bool {
        self.invert
    }

    pub(crate) fn into_apart(self) -> Apart {
        match self.kind {
            Kind::Open(part) => Apart::Open(part),
            Kind::Inverted(frame) => Apart::Inverted(frame.facets),
            Kind::Sheet { .. } => Apart::Along,
        }
    }

    /// Index of its geometry in the job.
    pub fn geometry(&self) -> usize {
        self.geometry
    }

    /// The rays that decide it, besides those of the mesh.
    pub fn casts(&self, cast: &Cast) -> Vec<AxisCasts> {
        match &self.kind {
            Kind::Open(part) => Votes::casts(part, cast.frame, cast.rays, cast.rule),
            Kind::Sheet { fill, facets, .. } => Sheet::casts(facets, *fill, cast.frame),
            Kind::Inverted(_) => Vec::new(),
        }
    }

    /// The cells that its holes move, of a frame of the lines' box.
    ///
    /// # Errors
    /// `cancelled`.
    pub async fn shifts(&self, frame: &Frame, lines: &Lines, control: &Control) -> Result<Vec<Shift>> {
        match &self.kind {
            Kind::Open(part) => part.shifts(frame, lines.smallest(), control).await,
            _ => Ok(Vec::new()),
        }
    }

    /// The same for some cells of the box: the first, and the end, exclusive.
    pub fn window(&self, cells: [[u32; 3]; 2], whole: &Frame) -> Part {
        let near = |facets: &[SnappedFacet]| -> Vec<SnappedFacet> {
            facets.iter().filter_map(|facet| in_window(facet, cells, whole)).collect()
        };
        let kind = match &self.kind {
            Kind::Open(OpenPart { policy, facets, patches, caps, surface, .. }) => {
                let (caps, surface) = (caps.clone(), surface.clone());
                let first = (cells[0], [0, 1, 2].map(|axis| whole.centre(axis, cells[0][axis])));
                let (facets, patches) = (near(facets), near(patches));
                Kind::Open(OpenPart { policy: *policy, facets, patches, caps, first, surface })
            }
            Kind::Inverted(frame) => Kind::Inverted(frame.window(cells)),
            Kind::Sheet { fill, shell, facets } => Kind::Sheet { fill: *fill, shell: *shell, facets: near(facets) },
        };
        Part { kind, ..*self }
    }

    /// Bytes that deciding it takes, about.
    pub fn n_bytes(&self, rays: &Rays, frame: &Frame) -> u64 {
        match &self.kind {
            Kind::Open(part) => part.n_bytes(rays, frame),
            Kind::Sheet { fill: Fill::Separating, facets, .. } => {
                let n_crossings: f64 = (0..3).map(|axis| n_expected(facets, axis, frame)).sum();
                36 * facets.len() as u64 + 16 * n_crossings as u64
            }
            Kind::Inverted(frame) => 38 * frame.facets.len() as u64,
            Kind::Sheet { facets, .. } => 80 * facets.len() as u64,
        }
    }
}

/// Takes out of a frame the geometries that are not closed, unless their rays shall decide as they are ([`Open::Parity`]), and the
/// shells, and those that are inverted; notes the surfaces that are filled. `geometries` are those of the frame, `closed` is known of each
/// position.
///
/// # Errors
/// `surface-open` where a geometry is open that must not be ([`Open::Error`]), or not for a window ([`Open::Parity`]); `cancelled`.
pub async fn split(
    frame: Frame,
    closed: &[Closed],
    (rule, is_for_window): (Rule, bool),
    (lines, geometries): (&Lines, &[Geometry]),
    control: &Control,
) -> Result<(Frame, Vec<Part>)> {
    let (mut parts, mut gone) = (Vec::new(), Vec::new());
    for (position, &geometry) in frame.ranks.geometry_at.iter().enumerate() {
        let Geometry { open, fill, shell, invert, ref name, .. } = geometries[geometry];
        let range = frame.range_at(position);
        let facets = &frame.facets[range.clone()];
        let rank = frame.ranks.rank_at[position];
        if fill != Fill::Centre {
            parts.push(Part {
                geometry,
                rank,
                invert: false,
                kind: Kind::Sheet { fill, shell, facets: facets.to_vec() },
            });
        }
        if shell {
            gone.push(range);
            continue;
        }
        let is_closed = closed[position].by(rule);
        if open == Open::Parity && is_for_window && !is_closed {
            // cells up to the last pair of crossings: a pair beyond the window would not be told from none
            let message =
                format!("geometry \"{name}\" is not closed, and open = \"parity\" needs whole rays to decide it");
            let hint = "let open = \"winding\" (--open winding) decide it, or mesh without a window (--window)";
            return Err(Error::new("surface-open", message, hint));
        }
        if open != Open::Parity && !is_closed {
            let part = OpenPart::new(open, facets, (frame.fraction_bits, lines), control).await?;
            if open == Open::Error {
                return Err(refused(name, &part.surface, lines));
            }
            parts.push(Part { geometry, rank, invert, kind: Kind::Open(part) });
            gone.push(range);
        } else if invert {
            parts.push(Part { geometry, rank, invert, kind: Kind::Inverted(frame.with_facets(facets.to_vec())) });
            gone.push(range);
        }
    }
    if parts.is_empty() {
        return Ok((frame, parts));
    }
    let is_left = |facet: usize| !gone.iter().any(|range| range.contains(&facet));
    let left: Vec<usize> = (0..frame.facets.len()).filter(|&facet| is_left(facet)).collect();
    let rest = Frame {
        facets: left.iter().map(|&facet| frame.facets[facet]).collect(),
        position_of_facet: left.iter().map(|&facet| frame.position_of_facet[facet]).collect(),
        ranks: Ranks { flag_of_rank: (1..=frame.ranks.flag_of_rank.len() as u8).collect(), ..frame.ranks },
        ..frame
    };
    Ok((rest, parts))
}

fn refused(name: &str, surface: &Surface, lines: &Lines) -> Error {
    let at = lines.text_of(surface.longest_at);
    let message = format!(
        "geometry \"{name}\" is not closed: open edges {}, loops {}, the longest edge at {at}",
        surface.open_edges, surface.holes
    );
    Error::new(
        "surface-open",
        message,
        "close it, or mesh it with open = \"winding\", which decides its cells by the winding number",
    )
}
