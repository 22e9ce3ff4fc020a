//! Convergence: a job meshed at several sizes of cells -> how far volumes and areas are from those of the surfaces, and what each size costs.
//!
//! The area of the stair-step surface does not become that of a smooth one, however small cells are: that of a ball stays 1.5 times too large.
//! What converges is the area seen along each axis: the faces across an axis, and the facets' areas projected on it. The error here is that of
//! the sum over the three axes. Cost: that of each mesh, and O(cells) for its faces.

use serde::Serialize;

use crate::meshing::pipeline::{self, Engine, MeshOptions};
use hexcast_core::base::control::Control;
use hexcast_core::base::error::{Error, Result};
use hexcast_core::input::geometry::Geometry;
use hexcast_core::input::job::Job;
use hexcast_core::input::sources::{Source, geometries};
use hexcast_core::set;
use hexcast_derived::mesh::Mesh;
use hexcast_files::write::{Compress, Format, Options, Sink, column_file, exact_size};

/// Flags that are looked at at a time.
const SLAB: usize = 1 << 26;

/// What one size of cells gives.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Level {
    /// Cells along each axis.
    pub dims: [u32; 3],
    /// Size of a cell along each axis.
    pub spacing: [f64; 3],
    /// From the files in memory to the mesh.
    pub seconds: f64,
    /// Bytes of the mesh as a column file (.hxc).
    pub column_bytes: u64,
    /// Bytes of its flags, one a cell.
    pub flag_bytes: u64,
    /// Each flag of the job.
    pub flags: Vec<FlagLevel>,
}

/// What one size of cells gives for a flag.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct FlagLevel {
    /// The flag.
    pub flag: u8,
    /// Names of its geometries, joined by " + ".
    pub name: String,
    /// Number of cells.
    pub cells: u64,
    /// Their volume.
    pub volume: f64,
    /// That of the surfaces; null where they enclose none (open, cut by the domain), or cells are not those whose centres lie inside.
    pub mesh_volume: Option<f64>,
    /// `volume` is so many times that of the surfaces, less 1; null without that.
    pub volume_error: Option<f64>,
    /// Area of the faces across x, y and z between cells of the flag and others, and at the sides of the box.
    pub areas: [f64; 3],
    /// Areas of the facets projected on planes across x, y and z.
    pub mesh_areas: [f64; 3],
    /// The sum of `areas` is so many times that of `mesh_areas`, less 1; null where `mesh_volume` is.
    pub area_error: Option<f64>,
}

/// Meshes a job with so many cells along the longest side of its box, for each of `sizes`.
///
/// # Errors
/// `job-conflict` where the job chooses its cells itself, or asks for a window, a part or graded lines; those of [`pipeline::mesh`].
pub async fn converge(
    job: &Job,
    sources: &[Source],
    sizes: &[u32],
    engine: &mut Engine,
    control: &Control,
) -> Result<Vec<Level>> {
    let chosen = [
        ("cells", job.cells.is_some()),
        ("dims", job.dims.is_some()),
        ("cell_size", job.cell_size.is_some()),
        ("max_cell_size", job.max_cell_size.is_some()),
        ("lines", job.lines.is_some()),
        ("graded", job.graded.is_some()),
        ("window", job.window.is_some()),
        ("part", job.part.is_some()),
    ];
    if let Some((key, _)) = chosen.iter().find(|(_, is_given)| *is_given) {
        let message = format!("{key} is given, but the sizes to compare decide the cells");
        return Err(Error::new("job-conflict", message, format!("leave out {key}")));
    }
    let of_job = geometries(job, sources.to_vec())?;
    let mut levels = Vec::new();
    for &cells in sizes {
        let job = set!(Job { cells: Some(cells), ..job.clone() });
        let (mesh, facts) = pipeline::mesh(&job, sources.to_vec(), &MeshOptions::default(), engine, control).await?;
        let areas = areas(&mesh, control).await?;
        let flags = facts.flags.iter().map(|found| {
            let areas = areas[usize::from(found.flag)];
            let mesh_areas = projected(of_job.iter().filter(|geometry| geometry.flag == found.flag))?;
            let error =
                |ours: f64, theirs: f64| found.mesh_volume.filter(|_| theirs != 0.0).map(|_| ours / theirs - 1.0);
            Ok(FlagLevel {
                flag: found.flag,
                name: found.name.clone(),
                cells: found.cells,
                volume: found.volume,
                mesh_volume: found.mesh_volume,
                volume_error: error(found.volume, found.mesh_volume.unwrap_or(0.0)),
                areas,
                mesh_areas,
                area_error: error(areas.iter().sum(), mesh_areas.iter().sum()),
            })
        });
        let flags = flags.collect::<Result<_>>()?;
        let seconds = facts.seconds.lines + facts.seconds.snap + facts.seconds.columns;
        let column_bytes = column_bytes(&mesh, control).await?;
        let flag_bytes = exact_size(&mesh, Format::Raw, &Options::default()).unwrap_or(mesh.n_cells());
        let spacing = mesh.lines().smallest();
        levels.push(Level { dims: mesh.dims(), spacing, seconds, column_bytes, flag_bytes, flags });
    }
    Ok(levels)
}

/// Bytes of a mesh as a column file.
async fn column_bytes(mesh: &Mesh, control: &Control) -> Result<u64> {
    let mut nowhere = std::io::sink();
    let mut sink = Sink::new(&mut nowhere, "the columns");
    column_file::write(mesh, Compress::None, &mut sink, control).await?;
    sink.finish()
}

/// Area of the facets of geometries, projected on planes across x, y and z.
fn projected<'a>(geometries: impl Iterator<Item = &'a Geometry>) -> Result<[f64; 3]> {
    let mut areas = [0.0; 3];
    for geometry in geometries {
        let place = geometry.world_from_file.of_corners();
        geometry.facets.for_each(|facet| {
            let [a, b, c] = facet.map(&place).map(glam::DVec3::from);
            let doubled = (b - a).cross(c - a).to_array();
            (0..3).for_each(|axis| areas[axis] += doubled[axis].abs() / 2.0);
        })?;
    }
    Ok(areas)
}

/// Area of the faces across x, y and z of each flag, towards other flags and at the sides of the box.
///
/// # Errors
/// `lines-graded` where cells differ in size; those of [`Mesh::for_each_slab`].
pub async fn areas(mesh: &Mesh, control: &Control) -> Result<Vec<[f64; 3]>> {
    let Some(spacing) = mesh.lines().spacing() else {
        let message = "cells differ in size, and faces are counted between equal ones";
        return Err(Error::new("lines-graded", message, "use equal cells (cells, dims, cell_size)"));
    };
    let [nx, ny, _] = mesh.dims().map(|n| n as usize);
    let mut faces = Faces { counts: vec![[0; 3]; 256] };
    // the row and the plane before, of flag 0 before the first and after the last
    let outside = vec![0; nx];
    let mut plane = vec![0; nx * ny];
    let mut row_in_plane = 0;
    let count = &mut |flags: &[u8]| {
        for row in flags.chunks_exact(nx) {
            let at = row_in_plane * nx;
            faces.along(row);
            faces.between(row, &plane[at..at + nx], 2);
            let before = if row_in_plane == 0 { &outside[..] } else { &plane[at - nx..at] };
            faces.between(row, before, 1);
            plane[at..at + nx].copy_from_slice(row);
            row_in_plane = (row_in_plane + 1) % ny;
            if row_in_plane == 0 {
                faces.between(row, &outside, 1);
            }
        }
        Ok(())
    };
    mesh.for_each_slab_with_rests(SLAB, control, count).await?;
    plane.chunks_exact(nx).for_each(|row| faces.between(row, &outside, 2));
    let [x, y, z] = spacing;
    let face = [y * z, x * z, x * y];
    Ok(faces.counts.iter().map(|counts| [0, 1, 2].map(|axis| counts[axis] as f64 * face[axis])).collect())
}

/// Numbers of faces of each flag, across x, y and z.
struct Faces {
    counts: Vec<[u64; 3]>,
}

impl Faces {
    /// Counts the faces across x in a row.
    fn along(&mut self, row: &[u8]) {
        let mut before = 0;
        for &flag in row.iter().chain([&0]) {
            self.count(before, flag, 0);
            before = flag;
        }
    }

    /// Counts the faces between two rows.
    fn between(&mut self, row: &[u8], other: &[u8], axis: usize) {
        if row != other {
            row.iter().zip(other).for_each(|(&one, &other)| self.count(one, other, axis));
        }
    }

    fn count(&mut self, one: u8, other: u8, axis: usize) {
        if one != other {
            self.counts[usize::from(one)][axis] += 1;
            self.counts[usize::from(other)][axis] += 1;
        }
    }
}
