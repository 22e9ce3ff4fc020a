//! Cut cells for OpenFOAM: the polyhedra of one flag as a `polyMesh`.
//!
//! The files and patches are those of whole cells. Faces between cells come first, by owner, then by neighbour; then those of each patch, by owner. All cells are one zone. Cost: the memory of
//! [`Polyhedra`], and 8 bytes a face.

use super::lists::{LONGEST_NAME, MAX_LABEL, PARTS, SIDE_NAMES, file_names, head, list, note, put_label, put_patch};
use crate::export::{
    limits::fluid,
    names::names,
    output::{Export, Files, Out},
    patches::Patches,
    unit::metres,
};
use hexcast_core::base::error::Result;
use hexcast_derived::cut_cells::polyhedra::{Behind, Face, Polyhedra};
use hexcast_derived::mesh::Mesh;
use hexcast_derived::mesh::outline::Outline;

/// About the most bytes that polyhedra take while they are joined: for each cell of the box, of the fluid, and that is cut. As measured around and in one body of 6,000 facets.
const BYTES: [u64; 3] = [13, 720, 4500];

pub(super) fn held_bytes(mesh: &Mesh, outline: &Outline) -> u64 {
    let of_fluid = mesh.columns().cells_per_flag()[usize::from(outline.fluid)];
    BYTES[0] * mesh.n_cells() + BYTES[1] * of_fluid + BYTES[2] * outline.cells.len() as u64
}

pub(super) async fn write(job: &Export<'_>, name: &str, files: &mut dyn Files) -> Result<()> {
    let keeps = job.options.selection(job.mesh, false)?;
    let outline = fluid(job.mesh, &keeps)?;
    let mut is_whole = Vec::with_capacity(job.mesh.n_cells() as usize);
    let mut push = |flags: &[u8]| {
        is_whole.extend(flags.iter().map(|flag| *flag == outline.fluid));
        Ok(())
    };
    job.for_each_slab(1, &mut push).await?;
    let cells = Polyhedra::new(job.mesh.lines(), outline, &is_whole, job.control).await?;
    drop(is_whole);
    job.say(lost_by_cuts(outline, &cells));
    let file_names = file_names(name);
    let case = Case::new(job, &cells);
    for (part, name) in PARTS.into_iter().zip(&file_names) {
        job.control.rest().await?;
        let mut out = Out::create(files, name)?;
        match part {
            "points" => case.points(&mut out)?,
            "faces" => case.faces(&mut out)?,
            "owner" => case.owner(&mut out)?,
            "neighbour" => case.neighbour(&mut out)?,
            "boundary" => case.boundary(&mut out)?,
            _ => case.zone(&mut out, outline.fluid)?,
        }
        out.finish()?;
    }
    file_names.get(6).map_or(Ok(()), |name| Out::create(files, name)?.finish())
}

/// Cut cells whose volume is nearer to that of the fluid, as a part of it, are as they should be.
const MOST_LOST: f64 = 1e-3;

/// What cut cells do not have as it is.
fn lost_by_cuts(outline: &Outline, cells: &Polyhedra) -> impl Iterator<Item = String> {
    let (of, n, volume) = (outline.cells.len(), outline.n_thin(), outline.volume);
    let thin = (n > 0).then(|| {
        format!(
            "in {n} of {of} cut cells an edge is crossed several times, by what is thinner than the cell: there the surface is simpler than it is; use smaller cells to have it"
        )
    });
    let left_out = outline.n_left_out();
    let off = cells.volumes().iter().map(|(volume, _)| volume).sum::<f64>() - volume;
    let lost = (off.abs() > MOST_LOST * volume).then(|| {
        let (percent, than) = (100.0 * off.abs() / volume, if off < 0.0 { "less" } else { "more" });
        let besides = match left_out {
            0 => String::new(),
            n => format!(" ({n} cells that have fluid and no corner in it are left out)"),
        };
        format!(
            "the cells have {percent:.2} % {than} volume than the fluid, {volume:.6e}, as cut cells are flat between their edges{besides}; use smaller cells to come nearer"
        )
    });
    let n_wrong = cells.counts.wrong;
    let wrong = (n_wrong > 0).then(|| {
        format!(
            "{n_wrong} cells are of a shape that checkMesh may call wrong, where parts of the surface or gaps are narrower than some cells; run it, and use smaller cells there"
        )
    });
    [thin, lost, wrong].into_iter().flatten()
}

struct Case<'a> {
    job: &'a Export<'a>,
    cells: &'a Polyhedra,
    patches: Patches<'a>,
    /// Faces between cells.
    internal: u64,
    /// All others: the patch, and the place among the faces; by patch.
    outer: Vec<(u32, u32)>,
}

impl<'a> Case<'a> {
    fn new(job: &'a Export<'a>, cells: &'a Polyhedra) -> Case<'a> {
        let patches = Patches::new(job, &SIDE_NAMES, LONGEST_NAME);
        let internal = cells.faces.partition_point(|face| matches!(face.behind, Behind::Cell(_)));
        let patch = |face: &Face| match face.behind {
            Behind::Side(side, cell) => patches.of_side(side.into(), cell),
            Behind::Surface(flag, wall) => patches.of_surface(flag, wall),
            Behind::Cell(_) => 0,
        };
        let places = (internal as u32..).zip(&cells.faces[internal..]);
        let mut outer: Vec<(u32, u32)> = places.map(|(place, face)| (patch(face) as u32, place)).collect();
        outer.sort_unstable();
        Case { job, cells, patches, internal: internal as u64, outer }
    }

    /// All faces, in their order.
    fn all(&self) -> impl Iterator<Item = &Face> {
        let outer = self.outer.iter().map(|&(_, place)| &self.cells.faces[place as usize]);
        self.cells.faces[..self.internal as usize].iter().chain(outer)
    }

    fn points(&self, out: &mut Out<'_>) -> Result<()> {
        let unit = metres(self.job.mesh.unit(), "OpenFOAM")?;
        let is_ascii = self.job.options.ascii;
        head(out, is_ascii, ("vectorField", "points"), "")?;
        list(out, is_ascii, self.cells.points.len() as u64)?;
        for point in &self.cells.points {
            let [x, y, z] = point.map(|place| unit.metres(place));
            match is_ascii {
                true => out.text(format_args!("({x:e} {y:e} {z:e})\n"))?,
                false => [x, y, z].iter().try_for_each(|number| out.put(&number.to_le_bytes()))?,
            }
        }
        out.put(b")\n")
    }

    fn faces(&self, out: &mut Out<'_>) -> Result<()> {
        let n = self.cells.faces.len() as u64;
        if self.job.options.ascii {
            head(out, true, ("faceList", "faces"), "")?;
            list(out, true, n)?;
            for face in self.all() {
                let corners = self.cells.corners(face);
                out.text(format_args!("{}(", corners.len()))?;
                corners.iter().enumerate().try_for_each(|(index, corner)| {
                    out.text(format_args!("{}{corner}", if index > 0 { " " } else { "" }))
                })?;
                out.put(b")\n")?;
            }
            return out.put(b")\n");
        }
        head(out, false, ("faceCompactList", "faces"), "")?;
        // where the corners of each face begin, then all corners
        list(out, false, n + 1)?;
        let mut start = 0;
        for face in self.all() {
            put_label(out, false, start)?;
            start += self.cells.corners(face).len() as u64;
        }
        debug_assert!(start <= MAX_LABEL, "checked as they were made");
        put_label(out, false, start)?;
        out.put(b")\n")?;
        list(out, false, start)?;
        for face in self.all() {
            self.cells.corners(face).iter().try_for_each(|&corner| put_label(out, false, corner.into()))?;
        }
        out.put(b")\n")
    }

    fn owner(&self, out: &mut Out<'_>) -> Result<()> {
        let is_ascii = self.job.options.ascii;
        head(out, is_ascii, ("labelList", "owner"), &self.note())?;
        list(out, is_ascii, self.cells.faces.len() as u64)?;
        self.all().try_for_each(|face| put_label(out, is_ascii, face.owner.into()))?;
        out.put(b")\n")
    }

    fn neighbour(&self, out: &mut Out<'_>) -> Result<()> {
        let is_ascii = self.job.options.ascii;
        head(out, is_ascii, ("labelList", "neighbour"), &self.note())?;
        list(out, is_ascii, self.internal)?;
        for face in self.all() {
            if let Behind::Cell(cell) = face.behind {
                put_label(out, is_ascii, cell.into())?;
            }
        }
        out.put(b")\n")
    }

    fn boundary(&self, out: &mut Out<'_>) -> Result<()> {
        head(out, true, ("polyBoundaryMesh", "boundary"), "")?;
        let of_patches = || self.outer.chunk_by(|one, other| one.0 == other.0);
        out.text(format_args!("{}\n(\n", of_patches().count()))?;
        let mut start = self.internal;
        for of_patch in of_patches() {
            let n = of_patch.len() as u64;
            put_patch(out, (&self.patches, of_patch[0].0 as usize), n, start)?;
            start += n;
        }
        out.put(b")\n")
    }

    fn zone(&self, out: &mut Out<'_>, flag: u8) -> Result<()> {
        let (is_ascii, n) = (self.job.options.ascii, u64::from(self.cells.n_cells));
        let names = names(self.job.mesh, LONGEST_NAME, &SIDE_NAMES);
        head(out, is_ascii, ("regIOobject", "cellZones"), "")?;
        let name = &names[usize::from(flag)];
        out.text(format_args!("1\n(\n{name}\n{{\n    type cellZone;\n    cellLabels List<label> "))?;
        list(out, is_ascii, n)?;
        (0..n).try_for_each(|cell| put_label(out, is_ascii, cell))?;
        out.put(b")\n;\n}\n)\n")
    }

    fn note(&self) -> String {
        let Polyhedra { points, faces, n_cells, .. } = self.cells;
        note(points.len() as u64, (*n_cells).into(), faces.len() as u64, self.internal)
    }
}
