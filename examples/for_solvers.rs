//! What solvers ask for: graded lines, links to walls, fractions of cells, flags on a staggered grid and at points. `docs/lines.md`,
//! `links.md`, `fractions.md`, `staggered.md` and `points.md` explain them.
//!
//!     cargo run --example for_solvers -- board.stl patch.stl

use hexcast::files::read_file;
use hexcast::job::{FractionsJob, GradedJob, Padding, PerAxis, Stencil};
use hexcast::picture::lines_svg;
use hexcast::pipeline::prepare;
use hexcast::write::{self, Compress, Format, LinksFormat, Options};
use hexcast::{Control, Error, GeometryJob, Job, Mesher, MesherOptions, Result};

/// Meshes a board and a patch of metal with graded lines, as `.vtr`; also returns `c dt` of the largest stable step.
pub(crate) fn graded(mesher: &mut Mesher, board: &str, patch: &str) -> Result<(Vec<u8>, Option<f64>)> {
    let (mut board, mut patch) = (GeometryJob::new(board), GeometryJob::new(patch));
    board.min_cells = Some(4);
    (patch.metal, patch.max_size) = (true, Some(0.5));
    let mut graded = GradedJob::new(PerAxis::All(2.0));
    (graded.min_size, graded.absorbing) = (Some(0.02), Some(PerAxis::All(8)));
    let mut job = Job::new(vec![board, patch]);
    job.graded = Some(graded);
    job.padding = Some(Padding::Length(PerAxis::All(20.0)));
    job.unit = Some("mm".into());
    let (mesh, report) = mesher.mesh(&job)?;
    let mut vtr = Vec::new();
    write::write(&mesh, Format::Vtr, &Options::default(), &mut vtr, &Control::default())?;
    Ok((vtr, report.mesh.grading.map(|grading| grading.courant_length)))
}

/// Draws the lines of a job, before there is a mesh.
pub(crate) fn drawn(board: &str) -> Result<String> {
    let mut job = Job::new(vec![GeometryJob::new(board)]);
    job.cells = Some(32);
    let prepared = prepare(&job, vec![read_file(board, &Control::default())?])?;
    lines_svg(&prepared.lines, &prepared.geometries)
}

/// Writes the links of D3Q27 as records; also returns the least distance along one.
pub(crate) fn links(mesher: &mut Mesher, body: &str) -> Result<(Vec<u8>, f32)> {
    let mut job = Job::new(vec![GeometryJob::new(body)]);
    job.cells = Some(32);
    job.padding = Some(Padding::Cells(PerAxis::All(2)));
    job.links.get_or_insert_default().stencil = Stencil::D3Q27;
    let (_, report) = mesher.mesh(&job)?;
    let links = report.mesh.links.expect("the job asks for them");
    let nearest = links.iter().map(|link| link.q).fold(1.0, f32::min);
    let mut records = Vec::new();
    write::write_links(&links, LinksFormat::Records, Compress::None, &mut records)?;
    Ok((records, nearest))
}

/// Writes the fractions of cells as an archive; also returns the volume of flag 1.
pub(crate) fn fractions(mesher: &mut Mesher, body: &str) -> Result<(Vec<u8>, f64)> {
    let mut asked = FractionsJob::default();
    asked.surfaces = true;
    let mut job = Job::new(vec![GeometryJob::new(body)]);
    (job.cells, job.fractions) = (Some(32), Some(asked));
    let (_, report) = mesher.mesh(&job)?;
    let fractions = report.mesh.fractions.expect("the job asks for them");
    let mut npz = Vec::new();
    write::write_fractions(&fractions, Compress::Zlib(6), &mut npz)?;
    Ok((npz, fractions.volumes[1]))
}

/// Writes the flags on a staggered grid as an archive; also returns the number of edges along x in the body.
pub(crate) fn staggered(mesher: &mut Mesher, body: &str) -> Result<(Vec<u8>, u64)> {
    let mut job = Job::new(vec![GeometryJob::new(body)]);
    (job.cells, job.staggered) = (Some(32), true);
    let (mesh, report) = mesher.mesh(&job)?;
    let staggered = report.mesh.staggered.expect("the job asks for it");
    // Ex, Ey, Ez, Hx, Hy, Hz
    let in_body = staggered.points[0].n_per_flag()?[1];
    let mut npz = Vec::new();
    write::write_staggered(&staggered, &mesh, Compress::Zlib(6), &mut npz)?;
    Ok((npz, in_body))
}

/// The flags at two points, in the body or not.
pub(crate) fn points(mesher: &Mesher, body: &str) -> Result<Vec<u8>> {
    let mut job = Job::new(vec![GeometryJob::new(body)]);
    job.cells = Some(32);
    let points = mesher.points(&job)?;
    let flags = points.flags(&[[0.0, 0.1, 0.0], [9.0, 0.0, 0.0]], &Control::default())?;
    Ok(flags)
}

fn main() -> Result<()> {
    let names: Vec<String> = std::env::args().skip(1).collect();
    let [board, patch] = &names[..] else {
        return Err(Error::new("job-value", "the names of two STL files are needed", ""));
    };
    let mut mesher = Mesher::new(MesherOptions::default())?;
    println!("{} bytes of lines as .svg", drawn(board)?.len());
    let (vtr, step) = graded(&mut mesher, board, patch)?;
    println!("graded lines: {} bytes of .vtr, c dt at most {step:?}", vtr.len());
    let (records, nearest) = links(&mut mesher, board)?;
    println!("links: {} bytes, the shortest {nearest} of its length", records.len());
    println!("fractions: a volume of {}", fractions(&mut mesher, board)?.1);
    println!("staggered grid: {} edges along x inside", staggered(&mut mesher, board)?.1);
    println!("points: flags {:?}", points(&mesher, board)?);
    Ok(())
}
