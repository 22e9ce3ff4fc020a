//! NRRD: the flags of equal cells as an image of three dimensions, for 3D Slicer, ITK and pynrrd.
//!
//! One file: a header in text, an empty line, and one byte a cell, x fastest, raw or as gzip. `space directions` has the size of a cell along
//! each axis, `space origin` the middle of the first cell: values are at the centres. What the flags are called and made of follows as
//! keys and values.
//! Source: the NRRD definition, version 5 (teem). Cost: two slabs of memory.

use std::io;

use crate::export::{
    format::Format,
    limits::equal_cells,
    options::ExportOptions,
    output::{Export, Files, Out, failed},
};
use crate::write::Compress;
use hexcast_core::base::error::Result;
use hexcast_core::base::sort::sort_by_key;
use hexcast_core::base::zlib::Deflate;
use hexcast_derived::mesh::Mesh;

pub(in crate::export) static FORMAT: Format = Format {
    program: "NRRD",
    about: "an image for 3D Slicer and ITK",
    on_disk: "gzip unless --compress=none",
    compresses: true,
    has_flags: false,
    check_lines: |lines| equal_cells(lines, ".nrrd").map(|_| ()),
    exact_size,
    held_planes: None,
    ..Format::new(&[".nrrd"], |job, name, files| Box::pin(write(job, name, files)))
};

/// Head of gzip: deflated, without a name or a time, by an unknown system.
const GZIP: [u8; 10] = [0x1f, 0x8b, 8, 0, 0, 0, 0, 0, 0, 255];

/// Level of gzip where the caller asks for zlib's.
fn level(compress: Compress) -> Option<u8> {
    match compress {
        Compress::None => None,
        Compress::Zlib(level) => Some(level),
    }
}

fn exact_size(mesh: &Mesh, options: &ExportOptions) -> Option<u64> {
    let is_raw = options.compress == Compress::None && !mesh.lines().is_graded();
    is_raw.then(|| mesh.n_cells() + header(mesh, options).len() as u64)
}

async fn write(job: &Export<'_>, name: &str, files: &mut dyn Files) -> Result<()> {
    let mut out = Out::create(files, name)?;
    out.put(header(job.mesh, job.options).as_bytes())?;
    match level(job.options.compress) {
        None => slabs(job, &mut out.file).await?,
        Some(level) => {
            out.put(&GZIP)?;
            let mut deflate = Deflate::new(&mut out.file, level);
            slabs(job, &mut deflate).await?;
            let (_, crc, n_bytes) = deflate.finish().map_err(failed)?;
            // of the number what fits
            out.put(&[crc.to_le_bytes(), (n_bytes as u32).to_le_bytes()].concat())?;
        }
    }
    out.finish()
}

async fn slabs(job: &Export<'_>, out: &mut dyn io::Write) -> Result<()> {
    job.for_each_slab(1, &mut |flags| out.write_all(flags).map_err(failed)).await
}

fn header(mesh: &Mesh, options: &ExportOptions) -> String {
    let [nx, ny, nz] = mesh.dims();
    let [dx, dy, dz] = mesh.lines().smallest();
    let [x, y, z] = [0, 1, 2].map(|axis| mesh.lines().centre(axis, 0));
    let encoding = if level(options.compress).is_some() { "gzip" } else { "raw" };
    let mut text = format!(
        "NRRD0005\n\
         # by hexcast {}\n\
         type: uint8\n\
         dimension: 3\n\
         space dimension: 3\n\
         sizes: {nx} {ny} {nz}\n\
         space directions: ({dx:?},0,0) (0,{dy:?},0) (0,0,{dz:?})\n\
         space origin: ({x:?},{y:?},{z:?})\n\
         kinds: domain domain domain\n\
         encoding: {encoding}\n",
        env!("CARGO_PKG_VERSION")
    );
    if let Some(unit) = mesh.unit() {
        let unit = quoted(unit);
        text += &format!("space units: \"{unit}\" \"{unit}\" \"{unit}\"\n");
    }
    let mut names: Vec<_> = mesh.names().iter().collect();
    sort_by_key(&mut names, |named| named.flag);
    for named in names {
        text += &format!("flag {}:={}\n", named.flag, one_line(&named.name));
        if let Some(material) = named.material.json() {
            text += &format!("flag {} material:={material}\n", named.flag);
        }
    }
    text + "\n"
}

/// A value of a key: in one line, as the format has it.
fn one_line(text: &str) -> String {
    text.replace('\\', "\\\\").replace('\n', "\\n").replace('\r', " ")
}

/// A text between quotes.
fn quoted(text: &str) -> String {
    one_line(&text.replace('"', "'"))
}
