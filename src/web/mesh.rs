//! A mesh for JavaScript: queries, pictures, and files encoded piece by piece as they are read.

use std::rc::Rc;
use std::sync::Arc;

use sha2::{Digest, Sha256};
use wasm_bindgen::prelude::*;

use super::file::{JsFile, JsFileStore};
use super::measured::Measured;
use super::values::{JsResult, js_error};
use crate::checksum::hex;
use crate::columns::BoxRuns;
use crate::control::Control;
use crate::error::{Error, Result};
use crate::flags::CellBox;
use crate::lines::Lines;
use crate::mesh::Mesh;
use crate::report::ColumnsReport;
use crate::skin::{skin, slice};
use crate::write::archive::Encoder;
use crate::write::{self, Compress, Format, Options, Written, column_file, vti};

/// Bytes of a piece of a file.
const PIECE_BYTES: usize = 4 << 20;
/// Least bytes of a piece of an archive, but for the last.
const LEAST_PIECE: usize = 1 << 16;

/// Most bytes for the index of an opened file and for what was read of it last.
const OPENED_BYTES: u64 = 1 << 30;

/// A finished mesh.
#[wasm_bindgen]
pub struct WebMesh {
    pub(super) mesh: Rc<Mesh>,
    pub(super) measured: Rc<Measured>,
    report: String,
}

impl WebMesh {
    pub(super) fn new(mesh: Mesh, measured: Measured, report: String) -> WebMesh {
        WebMesh { mesh: Rc::new(mesh), measured: Rc::new(measured), report }
    }
}

fn cell_box(numbers: &[u32]) -> JsResult<CellBox> {
    match *numbers {
        [x0, y0, z0, x1, y1, z1] => Ok([x0..x1, y0..y1, z0..z1]),
        _ => Err(js_error(Error::new("job-value", "a box is two corners of three cells", ""))),
    }
}

fn options(format: &str, compress: u8, bits: bool) -> JsResult<(Format, Options)> {
    let format = Format::of_name(&format!("mesh.{format}")).map_err(js_error)?;
    let compress = if compress == 0 { Compress::None } else { Compress::Zlib(compress) };
    Ok((format, Options { compress, bits, slab_bytes: PIECE_BYTES, ..Options::default() }))
}

#[wasm_bindgen]
impl WebMesh {
    /// Opens a column file of so many bytes, which stays where it is.
    pub fn open(file: JsFile, n_bytes: f64) -> JsResult<WebMesh> {
        let store = Arc::new(JsFileStore::new(file));
        let mesh = column_file::open(store, n_bytes as u64, OPENED_BYTES, &Control::default()).map_err(js_error)?;
        let report = super::info::json(&ColumnsReport::new(&mesh));
        Ok(WebMesh::new(mesh, Measured::default(), report))
    }

    /// The report as JSON.
    pub fn report(&self) -> String {
        self.report.clone()
    }

    /// Axis of the rays.
    #[wasm_bindgen(js_name = rayAxis)]
    pub fn ray_axis(&self) -> u32 {
        self.mesh.columns.rays.axis as u32
    }

    /// Number of runs and bytes of the columns.
    #[wasm_bindgen(js_name = columnFacts)]
    pub fn column_facts(&self) -> Vec<f64> {
        vec![self.mesh.columns.n_runs() as f64, self.mesh.columns.n_bytes() as f64]
    }

    /// Packed runs of a ray: first cell << 8 | flag.
    pub fn ray(&self, i: u32, j: u32) -> JsResult<Vec<u32>> {
        let rays = &self.mesh.columns.rays;
        if i >= rays.counts[0] || j >= rays.counts[1] {
            let message = format!("ray ({i}, {j}) is not one of {} x {}", rays.counts[0], rays.counts[1]);
            return Err(js_error(Error::new("job-value", message, "")));
        }
        let ray = self.mesh.columns.ray(u64::from(i) + u64::from(rays.counts[0]) * u64::from(j));
        Ok(ray.map_err(js_error)?.into_owned())
    }

    /// Packed runs of consecutive rays, as of [`WebMesh::ray`], each ray's behind their number.
    pub fn rays(&self, first: f64, n_rays: u32) -> JsResult<Vec<u32>> {
        let mut packed = Vec::new();
        for ray in first as u64..first as u64 + u64::from(n_rays) {
            let runs = self.mesh.columns.ray(ray).map_err(js_error)?;
            packed.push(runs.len() as u32);
            packed.extend_from_slice(&runs);
        }
        Ok(packed)
    }

    /// Flag of one cell.
    pub fn flag(&self, x: u32, y: u32, z: u32) -> JsResult<u8> {
        self.mesh.flag([x, y, z]).map_err(js_error)
    }

    /// Flags of a box, first and end on x, y, z; x fastest.
    #[wasm_bindgen(js_name = box)]
    pub fn box_flags(&self, corners: &[u32]) -> JsResult<Vec<u8>> {
        self.mesh.box_flags(&cell_box(corners)?).map_err(js_error)
    }

    /// Runs of the rays through a box, cut to it and counted from its first cell: the first run of each ray, the number of runs, then
    /// the packed runs.
    #[wasm_bindgen(js_name = boxRuns)]
    pub fn box_runs(&self, corners: &[u32]) -> JsResult<Vec<u32>> {
        let BoxRuns { mut offsets, runs } = self.mesh.box_runs(&cell_box(corners)?).map_err(js_error)?;
        offsets.extend(runs);
        Ok(offsets)
    }

    /// Boxes of all slabs, six numbers each.
    pub fn slabs(&self, max_bytes: f64) -> Vec<u32> {
        let slabs = self.mesh.slabs(max_bytes as usize);
        slabs.flat_map(|[x, y, z]| [x.start, y.start, z.start, x.end, y.end, z.end]).collect()
    }

    /// A plane of flags, headed by width, height and cells a pixel, each four bytes, little-endian.
    pub fn slice(&self, axis: u32, index: u32, max_pixels: u32) -> JsResult<Vec<u8>> {
        let axis = axis as usize;
        if axis > 2 || index >= self.mesh.dims()[axis] {
            return Err(js_error(Error::new("job-value", format!("there is no plane {index} across axis {axis}"), "")));
        }
        let plane = slice(&self.mesh, axis, index, [max_pixels.max(1); 2]).map_err(js_error)?;
        let head = [plane.width, plane.height, plane.step].map(u32::to_le_bytes);
        Ok([head.as_flattened(), &plane.flags].concat())
    }

    /// The stair-step surface.
    pub fn skin(&self, max_quads: f64) -> JsResult<WebSkin> {
        let skin = skin(&self.mesh, max_quads as usize, None, &Control::default()).map_err(js_error)?;
        Ok(WebSkin { skin, lines: self.mesh.lines.clone() })
    }

    /// Bytes of an uncompressed file before it is made; none where they depend on the flags.
    pub fn size(&self, format: &str, bits: bool) -> JsResult<Option<f64>> {
        let (format, options) = options(format, 0, bits)?;
        Ok(write::exact_size(&self.mesh, format, &options).map(|size| size as f64))
    }

    /// Starts hashing all flags: the bytes of the raw file.
    pub fn hash(&self, bits: bool) -> JsResult<WebHash> {
        Ok(WebHash { pieces: self.encode("raw", 0, bits)?, hash: Sha256::new(), n_bytes: 0 })
    }

    /// The description of a raw file, with its hash if that was made.
    pub fn sidecar(&self, bits: bool, sha256: Option<String>) -> String {
        let options = Options { bits, ..Options::default() };
        let n_bytes = write::exact_size(&self.mesh, Format::Raw, &options).unwrap_or(0);
        let written = Written { n_bytes, sha256 };
        write::sidecar_json(&self.mesh, &options, &written)
    }

    /// Starts a file: in the format of a mesh, or `links.npz`, `fractions.npz` or `staggered.npz`.
    pub fn encode(&self, format: &str, compress: u8, bits: bool) -> JsResult<WebEncoder> {
        let of = format.strip_suffix(".npz").unwrap_or("");
        let (format, options) = options(format.rsplit('.').next().unwrap_or(""), compress, bits)?;
        let around = write::around(&self.mesh, format, &options).map_err(js_error)?;
        let (work, made) = match (around, options.compress) {
            (Some((head, tail)), _) => {
                let mut pieces: Vec<CellBox> = self.mesh.slabs(PIECE_BYTES).collect();
                pieces.reverse();
                (Work::Flags { bits, pieces, tail }, head)
            }
            (None, Compress::Zlib(level)) if matches!(format, Format::Vti | Format::Vtr) => {
                (Work::Image(vti::VtiEncoder::new(&self.mesh, format, level, PIECE_BYTES)), Vec::new())
            }
            (None, compress) if format == Format::Npz => {
                // whether there are any shows now
                self.measured.arrays(&self.mesh, of, PIECE_BYTES).map_err(js_error)?;
                (Work::Archive { of: of.into(), encoder: Box::new(Encoder::new(compress)) }, Vec::new())
            }
            (None, compress) => {
                let encoder = column_file::ColumnFileEncoder::new(&self.mesh, compress).map_err(js_error)?;
                (Work::Columns(encoder), Vec::new())
            }
        };
        Ok(WebEncoder { mesh: self.mesh.clone(), measured: self.measured.clone(), work, made, n_taken: 0 })
    }
}

/// How a file is encoded.
enum Work {
    /// Flags as they are, or a bit each: boxes still to encode, the next one last, and what follows them.
    Flags { bits: bool, pieces: Vec<CellBox>, tail: Vec<u8> },
    /// A compressed `.vti`.
    Image(vti::VtiEncoder),
    /// A column file.
    Columns(column_file::ColumnFileEncoder),
    /// Arrays of what was measured, or of the mesh.
    Archive { of: String, encoder: Box<Encoder> },
}

impl Work {
    /// The next bytes, possibly none yet; None at the end.
    fn step(&mut self, mesh: &Mesh, measured: &Measured) -> Result<Option<Vec<u8>>> {
        match self {
            Work::Archive { of, encoder } => {
                let arrays = measured.arrays(mesh, of, PIECE_BYTES)?;
                // arrays may be short, and what is deflated waits for more
                let mut made = Vec::new();
                while made.len() < LEAST_PIECE {
                    let Some(more) = encoder.step(&arrays)? else { break };
                    made.extend(more);
                }
                Ok((!made.is_empty()).then_some(made))
            }
            Work::Image(encoder) => encoder.step(mesh),
            Work::Columns(encoder) => encoder.step(mesh),
            Work::Flags { bits, pieces, tail } => {
                let Some(cells) = pieces.pop() else {
                    let tail = std::mem::take(tail);
                    return Ok((!tail.is_empty()).then_some(tail));
                };
                if *bits { mesh.box_bits(&cells) } else { mesh.box_flags(&cells) }.map(Some)
            }
        }
    }
}

/// Encodes a file, piece by piece.
#[wasm_bindgen]
pub struct WebEncoder {
    mesh: Rc<Mesh>,
    measured: Rc<Measured>,
    work: Work,
    /// Bytes that are encoded, and how many of them were taken.
    made: Vec<u8>,
    n_taken: usize,
}

#[wasm_bindgen]
impl WebEncoder {
    /// The next bytes of the file, empty where it needs more work first; none at its end.
    #[wasm_bindgen(js_name = nextPiece)]
    pub fn next_piece(&mut self) -> JsResult<Option<Vec<u8>>> {
        if self.n_taken == self.made.len() {
            let Some(made) = self.work.step(&self.mesh, &self.measured).map_err(js_error)? else { return Ok(None) };
            (self.made, self.n_taken) = (made, 0);
        }
        if self.n_taken == 0 && self.made.len() <= PIECE_BYTES {
            return Ok(Some(std::mem::take(&mut self.made)));
        }
        let end = self.made.len().min(self.n_taken + PIECE_BYTES);
        let piece = self.made[self.n_taken..end].to_vec();
        self.n_taken = end;
        Ok(Some(piece))
    }

    /// Share of the work before the first byte, 0 to 1.
    pub fn share(&self) -> f64 {
        match &self.work {
            Work::Image(encoder) => encoder.share(),
            _ => 1.0,
        }
    }
}

/// Hashes all flags, piece by piece, so that other work can run in between.
#[wasm_bindgen]
pub struct WebHash {
    pieces: WebEncoder,
    hash: Sha256,
    n_bytes: u64,
}

#[wasm_bindgen]
impl WebHash {
    /// Takes the next piece; false at the end.
    pub fn step(&mut self) -> JsResult<bool> {
        let Some(piece) = self.pieces.next_piece()? else { return Ok(false) };
        self.hash.update(&piece);
        self.n_bytes += piece.len() as u64;
        Ok(true)
    }

    /// Bytes taken so far.
    #[wasm_bindgen(js_name = nBytes)]
    pub fn n_bytes(&self) -> f64 {
        self.n_bytes as f64
    }

    /// The hash in hexadecimal.
    pub fn finish(self) -> String {
        hex(&self.hash.finalize())
    }
}

/// A stair-step surface.
#[wasm_bindgen]
pub struct WebSkin {
    skin: crate::skin::Skin,
    lines: Lines,
}

#[wasm_bindgen]
impl WebSkin {
    /// Cells a drawn cell.
    pub fn step(&self) -> u32 {
        self.skin.step
    }

    /// Flags of the parts.
    pub fn flags(&self) -> Vec<u8> {
        self.skin.parts.iter().map(|part| part.flag).collect()
    }

    /// Corners of a part's quads in world lengths from the mesh's origin, three numbers a vertex.
    pub fn positions(&self, part: usize) -> Vec<f32> {
        let positions = self.skin.parts[part].positions.iter().enumerate();
        let place = |axis: usize, cells: f64| match self.lines.spacing() {
            Some(spacing) => cells * spacing[axis],
            None => self.lines.at(axis, cells) - self.lines.origin()[axis],
        };
        positions.map(|(index, &cells)| place(index % 3, cells.into()) as f32).collect()
    }

    /// Indices of a part, three a triangle.
    pub fn indices(&self, part: usize) -> Vec<u32> {
        self.skin.parts[part].indices.clone()
    }
}
