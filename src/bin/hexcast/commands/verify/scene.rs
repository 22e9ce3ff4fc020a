//! What a job asks for, made anew: bodies in units of the snap, and the cells of the mesh.
//!
//! A corner w becomes round(((w - origin) / spacing - half) 2^F) in f64, ties to even, with half the size of cell 0, in the smallest cells.
//! F is the largest for which corners and centres, with one cell to spare at both ends, span at most 2^26 units an axis.

use glam::{DMat3, DVec3};
use hexcast::job::{Fill, GeometryJob, Job, Open, PerAxis, Rule};
use hexcast::mesh::Mesh;
use hexcast::{Error, Result};

use super::lines::Grid;
use super::{ray::Facet, stl::Solid, surface::turned};

/// One geometry.
pub(super) struct Body {
    pub(super) file: String,
    pub(super) flag: i16,
    priority: i32,
    /// What decides its cells if it is not closed; None if it is.
    pub(super) open: Option<Open>,
    /// Which cells along its surface it has, whether it has no others, and whether the others are those outside.
    pub(super) fill: Fill,
    pub(super) shell: bool,
    pub(super) invert: bool,
    /// Its part of all facets; those that were missing are behind its own.
    pub(super) facets: std::ops::Range<usize>,
    pub(super) n_own: usize,
    /// What closes its small holes, but for rays.
    pub(super) patches: Vec<Facet>,
}

pub(super) struct Scene {
    /// The bodies in the order in which they win, the last over all others.
    pub(super) bodies: Vec<Body>,
    pub(super) facets: Vec<Facet>,
    rule: Rule,
    pub(super) bits: u32,
    pub(super) grid: Grid,
    /// Openings of fewer cells get a flag.
    pub(super) gaps: Option<(u32, i16)>,
}

/// The facets of a body where the job puts them.
type Placed<'a> = (Body, &'a GeometryJob, Vec<[DVec3; 3]>);

impl Scene {
    /// `files` has the solids of each entry of the job; `generated` the lines of the box, where the mesh has not all of them.
    pub(super) fn new(
        job: &Job,
        mesh: &Mesh,
        files: &[Vec<Solid>],
        generated: Option<&[Vec<f64>; 3]>,
    ) -> Result<Scene> {
        let placed = placed(job, files)?;
        let corners = |of: &Placed| of.2.iter().flatten().fold([DVec3::INFINITY, DVec3::NEG_INFINITY], widened);
        let boxes: Vec<_> = placed.iter().map(|of| (corners(of), of.1)).collect();
        let grid = Grid::new(job, mesh, &boxes, generated)?;
        let in_cells = |world: &DVec3| DVec3::from([0, 1, 2].map(|axis| grid.in_cells(axis, world[axis])));
        let ends = boxes.iter().flat_map(|(ends, _)| ends).map(in_cells);
        let [low, high] = ends.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |ends, end| widened(ends, &end));
        let of_axis = |k: usize| (high[k].max(grid.last_centre(k)) + 1.0) - (low[k].min(0.0) - 1.0);
        let span = (0..3).map(of_axis).fold(0.0, f64::max);
        let bits = (8..=26).rev().find(|&bits| span * f64::from(1u32 << bits) <= f64::from(1 << 26));
        let too_far = format!("the files span {span} cells of the mesh, 262144 at most");
        let bits = bits.ok_or_else(|| wrong("geometry-too-far", too_far))?;
        let (rule, unit) = (job.rule, f64::from(1u32 << bits));
        let greatest = placed.iter().map(|(body, ..)| body.flag).max().unwrap_or(0);
        let gaps = job.close_gaps.map(|width| (width, job.gap_flag.map_or(greatest + 1, i16::from)));
        let mut scene = Scene { bodies: Vec::new(), facets: Vec::new(), rule, bits, grid, gaps };
        for (mut body, _, world) in placed {
            let snap = |at: &DVec3| {
                [0, 1, 2].map(|axis| (scene.grid.in_cells(axis, at[axis]) * unit).round_ties_even() as i32)
            };
            let facets: Vec<Facet> = world.iter().map(|facet| facet.each_ref().map(snap)).collect();
            let turned = if body.shell { None } else { turned(&facets, scene.grid.unit, job.rule) };
            if turned.is_some() && body.open == Some(Open::Error) {
                let what = format!("{} is not closed, which the job makes an error: no mesh fits it", body.file);
                return Err(wrong("surface-open", what));
            }
            body.open = body.open.filter(|_| turned.is_some());
            let first = scene.facets.len();
            body.n_own = facets.len();
            // crossings that are counted as they are need no turning
            let [facets, patches] = turned.filter(|_| body.open != Some(Open::Parity)).unwrap_or([facets, Vec::new()]);
            scene.facets.extend(facets);
            (body.facets, body.patches) = (first..scene.facets.len(), patches);
            scene.bodies.push(body);
        }
        // an open surface loses against closed ones, unless nothing is inside it
        let Scene { bodies, facets, .. } = &mut scene;
        let is_flat = |body: &Body| {
            let mut corners = facets[body.facets.clone()].as_flattened().iter();
            corners.next().is_none_or(|first| (0..3).any(|k| corners.clone().all(|corner| corner[k] == first[k])))
        };
        bodies.sort_by_key(|body| (body.priority, body.open.is_none() || is_flat(body)));
        Ok(scene)
    }

    /// Whether so many crossings, or a winding number, mean inside.
    pub(super) fn is_inside(&self, count: i64) -> bool {
        if self.rule == Rule::Parity { count % 2 != 0 } else { count != 0 }
    }
}

fn wrong(code: &'static str, what: String) -> Error {
    Error::new(code, what, "give the job and the files that this mesh was made of")
}

fn widened([low, high]: [DVec3; 2], point: &DVec3) -> [DVec3; 2] {
    [low.min(*point), high.max(*point)]
}

/// The bodies, those that win last, and their facets in the world.
fn placed<'a>(job: &'a Job, files: &[Vec<Solid>]) -> Result<Vec<Placed<'a>>> {
    let mut bodies: Vec<Placed> = Vec::new();
    for (entry, solids) in job.geometries.iter().zip(files) {
        let (file, place) = (&entry.file, placing(entry));
        let taken = solids.iter().filter(|(name, _)| entry.solid.as_ref().is_none_or(|wanted| wanted == name));
        let parts: Vec<Vec<[DVec3; 3]>> =
            taken.map(|(_, facets)| facets.iter().map(|facet| facet.map(&place)).collect()).collect();
        let solid = entry.solid.as_deref().unwrap_or_default();
        if parts.is_empty() {
            return Err(wrong("job-value", format!("{file} has no solid {solid:?}")));
        }
        let parts = if entry.split || job.split { parts } else { vec![parts.concat()] };
        for (nth, facets) in (0..).map(|nth: usize| nth * usize::from(!entry.same_flag)).zip(parts) {
            let flag = entry.flag.map_or(bodies.len() + 1, |flag| usize::from(flag) + nth).min(256) as i16;
            let fill = match entry.fill.unwrap_or(job.fill) {
                Fill::Centre if entry.shell => Fill::Separating,
                fill => fill,
            };
            let (shell, invert, open) = (entry.shell, entry.invert || job.invert, entry.open.or(Some(job.open)));
            let (file, priority, patches) = (file.clone(), entry.priority, Vec::new());
            let body = Body { file, flag, priority, open, fill, shell, invert, facets: 0..0, n_own: 0, patches };
            bodies.push((body, entry, facets));
        }
    }
    bodies.sort_by_key(|(body, ..)| body.priority);
    Ok(bodies)
}

/// The function from a corner of a file to the world: scaled, turned about x, y and z, around a point, moved; products summed from left to right.
fn placing(entry: &GeometryJob) -> impl Fn([f32; 3]) -> DVec3 + use<> {
    let [x, y, z] = entry.rotate.unwrap_or_default().map(|degrees: f64| {
        // what is left of whole quarter turns
        let quarters = ((degrees % 360.0) / 90.0).round_ties_even();
        let (sine, cosine) = libm::sincos((degrees % 360.0 - 90.0 * quarters).to_radians());
        [(sine, cosine), (cosine, -sine), (-sine, -cosine), (-cosine, sine)][quarters.rem_euclid(4.0) as usize]
    });
    let about_x = DMat3::from_cols_array(&[1.0, 0.0, 0.0, 0.0, x.1, x.0, 0.0, -x.0, x.1]);
    let about_y = DMat3::from_cols_array(&[y.1, 0.0, -y.0, 0.0, 1.0, 0.0, y.0, 0.0, y.1]);
    let about_z = DMat3::from_cols_array(&[z.1, z.0, 0.0, -z.0, z.1, 0.0, 0.0, 0.0, 1.0]);
    let scale = DMat3::from_diagonal(entry.scale.map_or([1.0; 3], PerAxis::each).into());
    let turn = about_z * about_y * about_x;
    let centre = DVec3::from(entry.about.unwrap_or_default());
    let by = DVec3::from(entry.translate.unwrap_or_default()) + (centre - turn * centre);
    let turn = turn * scale;
    move |corner| turn * DVec3::from(corner.map(f64::from)) + by
}
