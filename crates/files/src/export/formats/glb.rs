//! GLB, the binary form of glTF 2.0: the closed surfaces of some flags, each a mesh with its name and colour, to show a mesh anywhere.
//!
//! The format is in metres with y up: a node on top scales the unit of the mesh to metres, if that is known, and turns z up. Coordinates are counted
//! from the first lines of the mesh, so that they have all digits of f32; the node moves them to their place. Each edge joins two triangles by the
//! numbers of its corners. Source: glTF 2.0 specification. Cost: that of [`surfaces`](crate::export::surfaces).

use serde_json::json;

use crate::colours::colour;
use crate::export::{
    format::Format,
    names,
    output::{Export, Files, Out},
    surfaces::{HELD, surfaces},
};
use hexcast_core::base::error::{Error, Result};
use hexcast_core::base::length::Length;

pub(in crate::export) static FORMAT: Format = Format {
    program: "glTF",
    about: "closed surfaces of cells, with names and colours",
    held: HELD,
    ..Format::new(&[".glb"], |job, name, files| Box::pin(write(job, name, files)))
};

/// Bytes of a corner or a triangle: three numbers of 32 bits.
const ITEM_BYTES: u64 = 12;
/// Lengths of the parts of a file, and types of what is in them.
const HEAD_BYTES: u64 = 12 + 8 + 8;
const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

async fn write(job: &Export<'_>, name: &str, files: &mut dyn Files) -> Result<()> {
    let keeps = job.options.selection(job.mesh, false)?;
    let origin = [0, 1, 2].map(|axis| job.mesh.lines().list(axis)[0]);
    let surfaces = surfaces(job, &keeps, origin).await?;
    let (mut views, mut accessors, mut meshes, mut materials) = (vec![], vec![], vec![], vec![]);
    let mut n_bytes = 0;
    for (at, surface) in surfaces.iter().enumerate() {
        let (n_corners, n_triangles) = (surface.corners.len(), surface.triangles.len());
        for (n, target) in [(n_corners, ARRAY_BUFFER), (n_triangles, ELEMENT_ARRAY_BUFFER)] {
            let length = ITEM_BYTES * n as u64;
            views.push(json!({ "buffer": 0, "byteOffset": n_bytes, "byteLength": length, "target": target }));
            n_bytes += length;
        }
        let end = |pick: fn(f32, f32) -> f32| {
            [0, 1, 2].map(|axis| surface.corners.iter().map(|corner| corner[axis]).reduce(pick).unwrap_or_default())
        };
        accessors.push(json!({
            "bufferView": 2 * at, "componentType": FLOAT, "count": n_corners, "type": "VEC3",
            "min": end(f32::min), "max": end(f32::max)
        }));
        accessors.push(json!({
            "bufferView": 2 * at + 1, "componentType": UNSIGNED_INT, "count": 3 * n_triangles, "type": "SCALAR"
        }));
        let name = names::name(job.mesh, surface.flag);
        let primitive = json!({ "attributes": { "POSITION": 2 * at }, "indices": 2 * at + 1, "material": at });
        meshes.push(json!({ "name": name, "primitives": [primitive], "extras": { "flag": surface.flag } }));
        let [red, green, blue] = colour(surface.flag).map(linear);
        let look = json!({ "baseColorFactor": [red, green, blue, 1], "metallicFactor": 0, "roughnessFactor": 0.9 });
        materials.push(json!({ "name": name, "pbrMetallicRoughness": look }));
    }
    let unit = job.mesh.unit().and_then(Length::of_name);
    if unit.is_none() {
        let sentence = "its lengths should be in metres, and the unit of the mesh is not known: they are as in the mesh";
        job.say([sentence.to_string()]);
    }
    let metres = unit.map_or(1.0, |unit| unit.metres(1.0));
    let place = json!({
        "children": (1..=meshes.len()).collect::<Vec<_>>(),
        // columns: x stays, y goes to -z, z to y
        "matrix": [
            metres, 0, 0, 0,
            0, 0, -metres, 0,
            0, metres, 0, 0,
            metres * origin[0], metres * origin[2], -metres * origin[1], 1
        ]
    });
    let parts = (0..meshes.len()).map(|at| json!({ "mesh": at, "name": meshes[at]["name"] }));
    let nodes: Vec<_> = [place].into_iter().chain(parts).collect();
    let mut text = json!({
        "asset": { "version": "2.0", "generator": concat!("hexcast ", env!("CARGO_PKG_VERSION")) },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": nodes,
        "meshes": meshes,
        "materials": materials,
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{ "byteLength": n_bytes }]
    })
    .to_string();
    text.extend(std::iter::repeat_n(' ', text.len().next_multiple_of(4) - text.len()));
    let length = HEAD_BYTES + text.len() as u64 + n_bytes;
    let (Ok(length), Ok(n_bytes)) = (u32::try_from(length), u32::try_from(n_bytes)) else {
        let message = format!("the surfaces take {length} bytes, and .glb holds up to {}", u32::MAX);
        return Err(Error::new("export-too-large", message, "export fewer flags, or mesh with larger cells"));
    };
    let mut out = Out::create(files, name)?;
    out.put(b"glTF")?;
    [2, length].iter().try_for_each(|number| out.put(&number.to_le_bytes()))?;
    // text is far below 4 GiB, as all of the file is
    out.put(&(text.len() as u32).to_le_bytes())?;
    out.put(b"JSON")?;
    out.put(text.as_bytes())?;
    out.put(&n_bytes.to_le_bytes())?;
    out.put(b"BIN\0")?;
    for surface in &surfaces {
        surface.corners.as_flattened().iter().try_for_each(|number| out.put(&number.to_le_bytes()))?;
        surface.triangles.as_flattened().iter().try_for_each(|number| out.put(&number.to_le_bytes()))?;
    }
    out.finish()
}

/// A share of light of the byte of a colour of screens: sRGB, IEC 61966-2-1.
fn linear(byte: u8) -> f64 {
    let share = f64::from(byte) / 255.0;
    let light = if share <= 0.04045 { share / 12.92 } else { libm::pow((share + 0.055) / 1.055, 2.4) };
    // as many digits as a byte has
    (light * 1e4).round() / 1e4
}
