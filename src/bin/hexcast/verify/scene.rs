//! What a job asks for, made anew: bodies in units of the snap, and what the lines of the mesh must be.
//!
//! A corner w becomes round(((w - origin) / spacing - 1/2) 2^F) in f64, ties to even. F is the largest for which corners and
//! centres, with one cell to spare at both ends, span at most 2^26 units an axis.

use glam::{DMat3, DVec3};
use hexcast::job::{DEFAULT_CELLS, GeometryJob, Job, Open, Padding, PerAxis, Rule};
use hexcast::mesh::Mesh;
use hexcast::{Error, Result};

use super::{ray::Facet, stl::solids, surface::turned};

/// One geometry.
pub(super) struct Body {
    pub(super) file: String,
    pub(super) flag: i16,
    priority: i32,
    /// What decides its cells if it is not closed; None if it is.
    pub(super) open: Option<Open>,
    /// Its part of all facets.
    pub(super) facets: std::ops::Range<usize>,
    /// What closes its small holes, but for rays.
    pub(super) patches: Vec<Facet>,
}

pub(super) struct Scene {
    /// The bodies in the order in which they win, the last over all others.
    pub(super) bodies: Vec<Body>,
    pub(super) facets: Vec<Facet>,
    rule: Rule,
    pub(super) bits: u32,
    /// Sentences about lines that are not those that the job asks for.
    pub(super) wrong_lines: Vec<String>,
}

impl Scene {
    pub(super) fn new(job: &Job, mesh: &Mesh) -> Result<Scene> {
        let wrong = |code, what| Error::new(code, what, "give the job and the files that this mesh was made of");
        let mut bodies: Vec<(Body, Vec<[DVec3; 3]>)> = Vec::new();
        for entry in &job.geometries {
            let (file, place, mut taken) = (&entry.file, placing(entry), solids(&entry.file)?);
            taken.retain(|(name, _)| entry.solid.as_ref().is_none_or(|wanted| wanted == name));
            let placed = |facets: &Vec<[[f32; 3]; 3]>| facets.iter().map(|facet| facet.map(&place)).collect();
            let parts: Vec<Vec<[DVec3; 3]>> = taken.iter().map(|(_, facets)| placed(facets)).collect();
            let solid = entry.solid.as_deref().unwrap_or_default();
            if parts.is_empty() {
                return Err(wrong("job-value", format!("{file} has no solid {solid:?}")));
            }
            let parts = if entry.split { parts } else { vec![parts.concat()] };
            for (nth, facets) in (0..).map(|nth: usize| nth * usize::from(!entry.same_flag)).zip(parts) {
                let flag = entry.flag.map_or(bodies.len() + 1, |flag| usize::from(flag) + nth).min(256) as i16;
                let (file, open, priority) = (file.clone(), entry.open.or(Some(job.open)), entry.priority);
                let body = Body { file, flag, priority, open, facets: 0..0, patches: Vec::new() };
                bodies.push((body, facets));
            }
        }
        let lines = &mesh.lines;
        let in_cells = |world: &DVec3| (*world - DVec3::from(lines.origin())) / DVec3::from(lines.smallest()) - 0.5;
        let corners = bodies.iter().flat_map(|(_, facets)| facets.as_flattened());
        let wrong_lines = wrong_lines(job, mesh, around(corners.clone().copied()));
        let [low, high] = around(corners.map(in_cells));
        let of_axis = |k: usize| (high[k] + 1.0).max(lines.dims()[k].into()) - (low[k] - 1.0).min(-1.0);
        let span = (0..3).map(of_axis).fold(0.0, f64::max);
        let bits = (8..=26).rev().find(|&bits| span * f64::from(1u32 << bits) <= f64::from(1 << 26));
        let too_far = format!("the files span {span} cells of the mesh, 262144 at most");
        let bits = bits.ok_or_else(|| wrong("geometry-too-far", too_far))?;
        let (rule, unit) = (job.rule, f64::from(1u32 << bits));
        let mut scene = Scene { bodies: Vec::new(), facets: Vec::new(), rule, bits, wrong_lines };
        for (mut body, world) in bodies {
            let snap = |at: &DVec3| (in_cells(at) * unit).to_array().map(|u| u.round_ties_even() as i32);
            let facets: Vec<Facet> = world.iter().map(|facet| facet.each_ref().map(snap)).collect();
            let turned = turned(&facets, lines.smallest(), job.rule);
            if turned.is_some() && body.open == Some(Open::Error) {
                let what = format!("{} is not closed, which the job makes an error: no mesh fits it", body.file);
                return Err(wrong("surface-open", what));
            }
            body.open = body.open.filter(|_| turned.is_some());
            let first = scene.facets.len();
            // crossings that are counted as they are need no turning
            let [facets, patches] = turned.filter(|_| body.open != Some(Open::Parity)).unwrap_or([facets, Vec::new()]);
            scene.facets.extend(facets);
            (body.facets, body.patches) = (first..scene.facets.len(), patches);
            scene.bodies.push(body);
        }
        scene.bodies.sort_by_key(|body| (body.priority, body.open.is_none()));
        Ok(scene)
    }

    /// Whether so many crossings, or a winding number, mean inside.
    pub(super) fn is_inside(&self, count: i64) -> bool {
        if self.rule == Rule::Parity { count % 2 != 0 } else { count != 0 }
    }
}

/// The function from a corner of a file to the world: scaled, turned about x, y and z, moved; products summed from left to right.
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
    let (turn, by) = (about_z * about_y * about_x * scale, DVec3::from(entry.translate.unwrap_or_default()));
    move |corner| turn * DVec3::from(corner.map(f64::from)) + by
}

fn around(points: impl Iterator<Item = DVec3>) -> [DVec3; 2] {
    points.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], point| [low.min(point), high.max(point)])
}

/// Holds origin, sizes and numbers of cells to the job.
fn wrong_lines(job: &Job, mesh: &Mesh, around: [DVec3; 2]) -> Vec<String> {
    let length = if let Some(Padding::Length(length)) = job.padding { length.each() } else { [0.0; 3] };
    let cells = if let Some(Padding::Cells(cells)) = job.padding { cells.each() } else { [0; 3] };
    let low = [0, 1, 2].map(|axis| job.domain.map_or(around[0][axis], |ends| ends[axis]) - length[axis]);
    let high = [0, 1, 2].map(|axis| job.domain.map_or(around[1][axis], |ends| ends[axis + 3]) + length[axis]);
    let extent = [0, 1, 2].map(|axis| high[axis] - low[axis]);
    let longest = extent.into_iter().fold(0.0, f64::max);
    let about = |axis: usize| {
        let (n, size, start) = (mesh.lines.dims()[axis], mesh.lines.smallest()[axis], mesh.lines.origin()[axis]);
        let (asked, slack) = match (job.dims, job.cell_size, job.max_cell_size) {
            (Some(dims), ..) => (extent[axis] / f64::from(dims[axis]), 0.001),
            (_, Some(size), _) => (size.each()[axis], 0.011),
            // that it is as large as can be is not checked
            (.., Some(most)) => (size.min(most * (1.0 + 1e-12)), 0.501),
            _ => (longest / f64::from(job.cells.unwrap_or(DEFAULT_CELLS)), 0.011),
        };
        let begin = low[axis] - f64::from(cells[axis]) * asked;
        // the last cell holds the end, which the mesher may round
        let inner = f64::from(n) - 2.0 * f64::from(cells[axis]);
        let over = inner - extent[axis] / asked;
        let is_covered = over >= -slack && over < job.dims.map_or(1.0, |_| slack) || inner == 1.0 && over >= 0.0;
        (size != asked || start != begin || !is_covered).then(|| {
            let found = format!("along {} it has {n} cells of {size} from {start}", ["x", "y", "z"][axis]);
            format!("{found}, the job asks for cells of {asked} from {begin} to {}", high[axis])
        })
    };
    (0..3).filter_map(about).collect()
}
