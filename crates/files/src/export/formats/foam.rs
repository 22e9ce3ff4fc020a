//! OpenFOAM: the cells of some flags as a `polyMesh`.
//!
//! Six files: `points`, `faces`, `owner`, `neighbour`, `boundary`, `cellZones`; beside `NAME.foam`, an empty file by which ParaView opens a case,
//! `constant/polyMesh` is written. Lengths are in metres. Patches are the six sides of the box (`xMin` ... `zMax`, type `patch`) and one for each
//! neighbouring flag that is not kept, of its name (type `wall`), or those of solids ([`patches`](crate::export::patches)); none without faces. Every kept flag is a
//! zone of cells.
//!
//! Faces between kept cells come first, by owner, then by neighbour, and point from the lower number to the higher; then those of each patch, by
//! owner, pointing out. Every list is written by itself: the flags are expanded once for each list and once more for each patch and zone.
//! Source: OpenFOAM user guide, mesh description. Cost: the memory of [`layers`](crate::export::layers).

mod cut;
mod lists;

use crate::export::{
    format::Format,
    layers::{Layer, N_SIDES, SIDES, for_each_layer},
    limits::fluid,
    names::names,
    options::ExportOptions,
    output::{Export, Files, Out},
    patches::Patches,
    unit::metres,
};
use hexcast_core::base::error::{Error, Result};
use hexcast_derived::mesh::Mesh;
use lists::{LONGEST_NAME, MAX_LABEL, PARTS, SIDE_NAMES, file_names, head, list, note, put_label, put_patch};

pub(in crate::export) static FORMAT: Format = Format {
    program: "OpenFOAM",
    about: "a polyMesh",
    on_disk: "constant/polyMesh beside an empty file of that name; or give DIR/constant/polyMesh",
    has_ascii: true,
    cuts: true,
    check_mesh,
    held: ("cut cells", |mesh| mesh.outline().map_or(0, |outline| cut::held_bytes(mesh, outline))),
    longest_name: Some(LONGEST_NAME),
    unit: Some(("OpenFOAM", "metres")),
    file_names,
    ..Format::new(&[".foam", "constant/polyMesh"], |job, name, files| Box::pin(write(job, name, files)))
};

/// Numbers of everything, and the faces of each patch.
#[derive(Default)]
struct Counts {
    points: u64,
    cells: u64,
    internal: u64,
    /// Faces of each patch.
    patches: Vec<u64>,
    zones: Vec<u64>,
}

impl Counts {
    fn faces(&self) -> u64 {
        self.internal + self.patches.iter().sum::<u64>()
    }

    /// Patches with faces: their places in `patches`.
    fn used(&self) -> impl Iterator<Item = usize> {
        (0..self.patches.len()).filter(|&patch| self.patches[patch] > 0)
    }
}

/// Refuses cut cells of a mesh that has the outline of another flag.
fn check_mesh(mesh: &Mesh, _: &ExportOptions, keeps: &[bool; 256]) -> Result<()> {
    mesh.outline().map_or(Ok(()), |_| fluid(mesh, keeps).map(|_| ()))
}

async fn write(job: &Export<'_>, name: &str, files: &mut dyn Files) -> Result<()> {
    if job.mesh.outline().is_some() {
        return cut::write(job, name, files).await;
    }
    let keeps = job.options.selection(job.mesh, false)?;
    let patches = Patches::new(job, &SIDE_NAMES, LONGEST_NAME);
    let counts = count(&patches, job, &keeps).await?;
    let greatest = counts.faces().max(counts.points);
    if greatest > MAX_LABEL {
        let message = format!("{greatest} faces and points: OpenFOAM numbers up to {MAX_LABEL}");
        return Err(Error::new("export-too-large", message, "export fewer flags, or mesh with larger cells"));
    }
    let file_names = file_names(name);
    let case = Case { job, keeps: &keeps, counts: &counts, patches, names: names(job.mesh, LONGEST_NAME, &SIDE_NAMES) };
    for (part, name) in PARTS.into_iter().zip(&file_names) {
        let mut out = Out::create(files, name)?;
        match part {
            "points" => case.points(&mut out).await?,
            "faces" => case.faces(&mut out).await?,
            "owner" => case.owner(&mut out).await?,
            "neighbour" => case.neighbour(&mut out).await?,
            "boundary" => case.boundary(&mut out)?,
            _ => case.zones(&mut out).await?,
        }
        out.finish()?;
    }
    file_names.get(6).map_or(Ok(()), |name| Out::create(files, name)?.finish())
}

/// The patch of a side of a kept cell; None where the face is between two kept cells.
fn patch_of(patches: &Patches, layer: &Layer, cell: [usize; 2], side: usize) -> Option<usize> {
    let is_internal = layer.neighbour(cell, side).is_some_and(|flag| layer.keeps(flag));
    (!is_internal).then(|| patches.of(layer, cell, side))
}

async fn count(patches: &Patches<'_>, job: &Export<'_>, keeps: &[bool; 256]) -> Result<Counts> {
    let mut counts = Counts { patches: vec![0; patches.len()], zones: vec![0; 256], ..Counts::default() };
    for_each_layer(job, keeps, &mut |layer| {
        layer.for_each_point(|_, _| {
            counts.points += 1;
            Ok(())
        })?;
        layer.for_each_cell(|cell, flag, _| {
            counts.cells += 1;
            counts.zones[usize::from(flag)] += 1;
            for side in 0..N_SIDES {
                match patch_of(patches, layer, cell, side) {
                    Some(patch) => counts.patches[patch] += 1,
                    None => counts.internal += u64::from(side % 2 == 1),
                }
            }
            Ok(())
        })
    })
    .await?;
    Ok(counts)
}

/// A face: the number of its cell, that of the next where it is between two, and its corners.
struct Face {
    owner: u64,
    neighbour: Option<u64>,
    corners: [u64; 4],
}

struct Case<'a> {
    job: &'a Export<'a>,
    keeps: &'a [bool; 256],
    counts: &'a Counts,
    patches: Patches<'a>,
    names: Vec<String>,
}

impl Case<'_> {
    async fn points(&self, out: &mut Out<'_>) -> Result<()> {
        let unit = metres(self.job.mesh.unit(), "OpenFOAM")?;
        let lines = [0, 1, 2]
            .map(|axis| self.job.mesh.lines().list(axis).into_iter().map(|line| unit.metres(line)).collect::<Vec<_>>());
        self.head(out, "vectorField", "points", "")?;
        self.list(out, self.counts.points)?;
        for_each_layer(self.job, self.keeps, &mut |layer| {
            let z = lines[2][layer.z as usize];
            layer.for_each_point(|[x, y], _| match self.is_ascii() {
                true => out.text(format_args!("({:e} {:e} {z:e})\n", lines[0][x], lines[1][y])),
                false => [lines[0][x], lines[1][y], z].iter().try_for_each(|number| out.put(&number.to_le_bytes())),
            })
        })
        .await?;
        out.put(b")\n")
    }

    async fn faces(&self, out: &mut Out<'_>) -> Result<()> {
        let n = self.counts.faces();
        if self.is_ascii() {
            self.head(out, "faceList", "faces", "")?;
            self.list(out, n)?;
            self.for_each_face(&mut |face| {
                let [a, b, c, d] = face.corners;
                out.text(format_args!("4({a} {b} {c} {d})\n"))
            })
            .await?;
            return out.put(b")\n");
        }
        self.head(out, "faceCompactList", "faces", "")?;
        if 4 * n > MAX_LABEL {
            let message =
                format!("{n} faces: their corners are {} numbers, and OpenFOAM counts up to {MAX_LABEL}", 4 * n);
            return Err(Error::new("export-too-large", message, "write text (--ascii), or export fewer flags"));
        }
        // where the corners of each face begin, then all corners
        self.list(out, n + 1)?;
        (0..=n).try_for_each(|face| self.label(out, 4 * face))?;
        out.put(b")\n")?;
        self.list(out, 4 * n)?;
        self.for_each_face(&mut |face| face.corners.iter().try_for_each(|corner| self.label(out, *corner))).await?;
        out.put(b")\n")
    }

    async fn owner(&self, out: &mut Out<'_>) -> Result<()> {
        self.head(out, "labelList", "owner", &self.note())?;
        self.list(out, self.counts.faces())?;
        self.for_each_face(&mut |face| self.label(out, face.owner)).await?;
        out.put(b")\n")
    }

    async fn neighbour(&self, out: &mut Out<'_>) -> Result<()> {
        self.head(out, "labelList", "neighbour", &self.note())?;
        self.list(out, self.counts.internal)?;
        self.for_each_internal(&mut |face| face.neighbour.map_or(Ok(()), |cell| self.label(out, cell))).await?;
        out.put(b")\n")
    }

    fn boundary(&self, out: &mut Out) -> Result<()> {
        self.head(out, "polyBoundaryMesh", "boundary", "")?;
        out.text(format_args!("{}\n(\n", self.counts.used().count()))?;
        let mut start = self.counts.internal;
        for patch in self.counts.used() {
            let n = self.counts.patches[patch];
            put_patch(out, (&self.patches, patch), n, start)?;
            start += n;
        }
        out.put(b")\n")
    }

    async fn zones(&self, out: &mut Out<'_>) -> Result<()> {
        self.head(out, "regIOobject", "cellZones", "")?;
        let flags = || (0..256).filter(|&flag| self.counts.zones[flag] > 0);
        out.text(format_args!("{}\n(\n", flags().count()))?;
        for zone in flags() {
            out.text(format_args!("{}\n{{\n    type cellZone;\n    cellLabels List<label> ", self.names[zone]))?;
            self.list(out, self.counts.zones[zone])?;
            for_each_layer(self.job, self.keeps, &mut |layer| {
                layer.for_each_cell(
                    |_, flag, cell| if usize::from(flag) == zone { self.label(out, cell) } else { Ok(()) },
                )
            })
            .await?;
            out.put(b")\n;\n}\n")?;
        }
        out.put(b")\n")
    }

    /// All faces, in their order.
    async fn for_each_face(&self, visit: &mut dyn FnMut(Face) -> Result<()>) -> Result<()> {
        self.for_each_internal(visit).await?;
        for wanted in self.counts.used() {
            for_each_layer(self.job, self.keeps, &mut |layer| {
                layer.for_each_cell(|cell, _, owner| {
                    for side in (0..N_SIDES).filter(|&side| patch_of(&self.patches, layer, cell, side) == Some(wanted))
                    {
                        let corners = layer.corners(cell);
                        visit(Face { owner, neighbour: None, corners: SIDES[side].map(|corner| corners[corner]) })?;
                    }
                    Ok(())
                })
            })
            .await?;
        }
        Ok(())
    }

    async fn for_each_internal(&self, visit: &mut dyn FnMut(Face) -> Result<()>) -> Result<()> {
        for_each_layer(self.job, self.keeps, &mut |layer| {
            layer.for_each_cell(|cell, _, owner| {
                // the neighbours along +x, +y and +z have ascending numbers
                for side in [1, 3, 5].into_iter().filter(|&side| patch_of(&self.patches, layer, cell, side).is_none()) {
                    let (corners, neighbour) = (layer.corners(cell), Some(layer.next(cell, side)));
                    visit(Face { owner, neighbour, corners: SIDES[side].map(|corner| corners[corner]) })?;
                }
                Ok(())
            })
        })
        .await
    }

    fn is_ascii(&self) -> bool {
        self.job.options.ascii
    }

    fn note(&self) -> String {
        let Counts { points, cells, internal, .. } = self.counts;
        note(*points, *cells, self.counts.faces(), *internal)
    }

    fn head(&self, out: &mut Out, class: &str, object: &str, note: &str) -> Result<()> {
        head(out, self.is_ascii(), (class, object), note)
    }

    fn list(&self, out: &mut Out, n: u64) -> Result<()> {
        list(out, self.is_ascii(), n)
    }

    fn label(&self, out: &mut Out, label: u64) -> Result<()> {
        // at most MAX_LABEL: all were counted
        put_label(out, self.is_ascii(), label)
    }
}
