//! MagicaVoxel (`.vox`): the cells of some flags as coloured cubes, to look at.
//!
//! A model has at most 256 cells along an axis, so a mesh is as many models as it needs, which a scene puts side by side; those without a cell
//! are left out. The number of a colour is the flag. The file says how long its parts are before they come, so every model is expanded twice.
//! Source: MagicaVoxel's file format and its extension for scenes. Cost: the flags of a slab of a model.

use crate::colours::colour;
use crate::export::{
    format::Format,
    limits::equal_cells,
    options::ExportOptions,
    output::{Export, Files, Out},
};
use hexcast_core::base::error::{Error, Result};
use hexcast_core::cells::flags::{CellBox, slabs_of_box};
use hexcast_derived::mesh::Mesh;

pub(in crate::export) static FORMAT: Format = Format {
    program: "MagicaVoxel",
    about: "coloured cubes, to look at",
    check_lines: |lines| equal_cells(lines, ".vox").map(|_| ()),
    check_flags,
    check_mesh,
    held_planes: None,
    ..Format::new(&[".vox"], |job, name, files| Box::pin(write(job, name, files)))
};

/// Most cells of a model along an axis.
const MAX_SIDE: u32 = 256;
const VERSION: u32 = 150;
/// Most bytes of a part of a file: readers take the number as one with a sign.
const MAX_BYTES: u64 = i32::MAX as u64;

/// A part of the mesh with cells to show.
struct Model {
    cells: CellBox,
    n_shown: u64,
}

/// Refuses flag 0 as a flag to export.
fn check_flags(flags: &[u8]) -> Result<()> {
    if flags.contains(&0) {
        let message = "flag 0 is to be exported, and colour 0 of .vox is no cell";
        return Err(Error::new("job-conflict", message, "leave out flag 0 (--export-flags), or write .binvox"));
    }
    Ok(())
}

fn check_mesh(mesh: &Mesh, _: &ExportOptions, keeps: &[bool; 256]) -> Result<()> {
    let n_shown: u64 = (0..256).filter(|&flag| keeps[flag]).map(|flag| mesh.columns().cells_per_flag()[flag]).sum();
    if 4 * n_shown > MAX_BYTES {
        let message = format!("{n_shown} cells take {} bytes, and .vox holds up to {MAX_BYTES}", 4 * n_shown);
        return Err(Error::new("export-too-large", message, "export fewer flags, or mesh with larger cells"));
    }
    Ok(())
}

async fn write(job: &Export<'_>, name: &str, files: &mut dyn Files) -> Result<()> {
    let keeps = job.options.selection(job.mesh, false)?;
    let models = models(job, &keeps).await?;
    let scene = scene(&models);
    let n_bytes = models.iter().map(|model| 24 + 16 + 4 * model.n_shown).sum::<u64>() + scene.len() as u64;
    if n_bytes > MAX_BYTES {
        let message = format!("{} models take {n_bytes} bytes, and .vox holds up to {MAX_BYTES}", models.len());
        return Err(Error::new("export-too-large", message, "export fewer flags, or mesh with larger cells"));
    }
    let mut out = Out::create(files, name)?;
    out.put(b"VOX ")?;
    out.put(&VERSION.to_le_bytes())?;
    // sizes fit: all of them are below MAX_BYTES
    out.put(&head(b"MAIN", 0, n_bytes as u32))?;
    for model in &models {
        out.put(&head(b"SIZE", 12, 0))?;
        model.cells.iter().try_for_each(|range| out.put(&(range.len() as u32).to_le_bytes()))?;
        out.put(&head(b"XYZI", 4 + 4 * model.n_shown as u32, 0))?;
        out.put(&(model.n_shown as u32).to_le_bytes())?;
        for_each_shown(job, &keeps, &model.cells, &mut |place, flag| {
            let [x, y, z] = place.map(|n| n as u8);
            out.put(&[x, y, z, flag])
        })
        .await?;
    }
    out.put(&scene)?;
    out.finish()
}

/// The models of a mesh, x fastest.
async fn models(job: &Export<'_>, keeps: &[bool; 256]) -> Result<Vec<Model>> {
    let [nx, ny, nz] = job.mesh.dims();
    let parts =
        |n: u32| (0..n).step_by(MAX_SIDE as usize).map(move |start| start..start.saturating_add(MAX_SIDE).min(n));
    let mut models = Vec::new();
    for z in parts(nz) {
        for y in parts(ny) {
            for x in parts(nx) {
                let cells = [x, y.clone(), z.clone()];
                let mut n_shown = 0;
                for_each_shown(job, keeps, &cells, &mut |_, _| {
                    n_shown += 1;
                    Ok(())
                })
                .await?;
                if n_shown > 0 {
                    models.push(Model { cells, n_shown });
                }
            }
        }
    }
    Ok(models)
}

/// Calls `visit` with the place in the model and the flag of each cell that is shown.
async fn for_each_shown(
    job: &Export<'_>,
    keeps: &[bool; 256],
    model: &CellBox,
    visit: &mut dyn FnMut([u32; 3], u8) -> Result<()>,
) -> Result<()> {
    for slab in slabs_of_box(model, job.options.slab_bytes) {
        job.control.rest().await?;
        let flags = job.mesh.box_flags(&slab)?;
        let [nx, ny] = [slab[0].len(), slab[1].len()];
        for (index, &flag) in flags.iter().enumerate().filter(|(_, flag)| keeps[usize::from(**flag)]) {
            let place = [index % nx, index / nx % ny, index / (nx * ny)];
            visit([0, 1, 2].map(|axis| slab[axis].start - model[axis].start + place[axis] as u32), flag)?;
        }
    }
    Ok(())
}

/// The nodes that put the models in their places, and the colours.
fn scene(models: &[Model]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let group: Vec<u32> = (0..models.len() as u32).map(|model| 2 + 2 * model).collect();
    transform(&mut bytes, 0, 1, u32::MAX, None);
    let mut content = words(&[1, 0, group.len() as u32]);
    content.extend(words(&group));
    node(&mut bytes, b"nGRP", &content);
    for (index, model) in (0u32..).zip(models) {
        // the place of a model is that of its cell floor(size / 2)
        let middle = model.cells.clone().map(|range| (range.start + range.len() as u32 / 2).to_string());
        transform(&mut bytes, 2 + 2 * index, 3 + 2 * index, 0, Some(&middle.join(" ")));
        node(&mut bytes, b"nSHP", &words(&[3 + 2 * index, 0, 1, index, 0]));
    }
    let colours = (1..=255u8).flat_map(|flag| colour(flag).into_iter().chain([255])).chain([0; 4]);
    node(&mut bytes, b"RGBA", &colours.collect::<Vec<u8>>());
    bytes
}

/// A node that moves another, in one frame; layers and reserved numbers are -1 where there are none.
fn transform(bytes: &mut Vec<u8>, id: u32, child: u32, layer: u32, to: Option<&str>) {
    let mut content = words(&[id, 0, child, u32::MAX, layer, 1, to.is_some().into()]);
    if let Some(to) = to {
        for text in ["_t", to] {
            content.extend(words(&[text.len() as u32]));
            content.extend(text.as_bytes());
        }
    }
    node(bytes, b"nTRN", &content);
}

fn node(bytes: &mut Vec<u8>, id: &[u8; 4], content: &[u8]) {
    bytes.extend(head(id, content.len() as u32, 0));
    bytes.extend(content);
}

/// The head of a part: its name, and the bytes of its content and of the parts in it.
fn head(id: &[u8; 4], content: u32, children: u32) -> Vec<u8> {
    [&id[..], &content.to_le_bytes(), &children.to_le_bytes()].concat()
}

fn words(numbers: &[u32]) -> Vec<u8> {
    numbers.iter().flat_map(|number| number.to_le_bytes()).collect()
}
