//! Files for JavaScript, encoded piece by piece as they are read.

use std::rc::Rc;

use sha2::{Digest, Sha256};
use wasm_bindgen::prelude::*;

use super::export::{export_work, exporter_of, links_work};
use super::mesh::WebMesh;
use super::resting::Resting;
use super::store::store_work;
use super::values::{JsResult, js_error};
use super::write_options::WriteOptions;
use crate::base::checksum::hex;
use crate::base::error::Result;
use crate::cells::flags::CellBox;
use crate::derived::mesh::Mesh;
use crate::output::export::{self, ExportOptions};
use crate::output::measured::Measured;
use crate::output::write::archive::{Array, Encoder};
use crate::output::write::{self, Compress, Format, Options, Written, column_file, links, npz, ordered, solid, vti};

/// Bytes of a piece of a file.
const PIECE_BYTES: usize = 4 << 20;
/// Least bytes of a piece of an archive, but for the last.
const LEAST_PIECE: usize = 1 << 16;

/// What a file is of, and its format there: `links.npz` of links, `npz` of the mesh, whose name is empty.
fn parts_of(name: &str) -> (&str, &str) {
    match name {
        "links" => ("links", "links"),
        _ => name.split_once('.').unwrap_or(("", name)),
    }
}

fn format_of(ending: &str) -> Result<Format> {
    Format::of_name(&format!("mesh.{}", if ending == "zarr" { "zarr.zip" } else { ending }))
}

#[wasm_bindgen]
impl WebMesh {
    /// Bytes of an uncompressed file before it is made; none where they depend on the flags, or what it is of was not measured.
    pub fn size(&self, format: &str, bits: bool) -> JsResult<Option<f64>> {
        let options = Options { bits, ..Options::default() };
        let size = match (exporter_of(format), parts_of(format)) {
            (Some(exporter), _) => export::exact_size(&self.mesh, exporter, &ExportOptions::default()),
            (None, ("links", _)) => self.measured.links().ok().map(links::n_bytes),
            (None, ("fractions", ending)) => self.measured.fractions().ok().and_then(|fractions| {
                let format = format_of(ending).ok()?;
                let (head, tail) = solid::around(&self.mesh, fractions, (format, &options)).ok()??;
                Some(solid::numbers(&self.mesh).n_bytes + (head.len() + tail.len()) as u64)
            }),
            (None, (_, ending)) => write::exact_size(&self.mesh, format_of(ending).map_err(js_error)?, &options),
        };
        Ok(size.map(|size| size as f64))
    }

    /// Starts hashing the raw file, whose bytes are the flags of all cells unless the options say otherwise.
    pub fn hash(&self, options: &str) -> JsResult<WebHash> {
        Ok(WebHash { pieces: self.encode("raw", options)?, hash: Sha256::new(), n_bytes: 0 })
    }

    /// The description of a raw file, with its hash if that was made.
    pub fn sidecar(&self, options: &str, sha256: Option<String>) -> JsResult<String> {
        let options = WriteOptions::read(options).map_err(js_error)?.of_mesh(PIECE_BYTES);
        write::around(&self.mesh, Format::Raw, &options).map_err(js_error)?;
        let n_bytes = write::exact_size(&self.mesh, Format::Raw, &options).unwrap_or(0);
        let written = Written { n_bytes, sha256 };
        Ok(write::sidecar_json(&self.mesh, &options, &written))
    }

    /// Starts a file: in the format of a mesh, of an exporter, or of what was measured, such as `links.npz`. `options` is JSON.
    pub fn encode(&self, format: &str, options: &str) -> JsResult<WebEncoder> {
        let (work, made) = self.work(format, options).map_err(js_error)?;
        Ok(WebEncoder { mesh: self.mesh.clone(), measured: self.measured.clone(), work, made, n_taken: 0 })
    }
}

impl WebMesh {
    /// The work of a file, and its first bytes.
    fn work(&self, name: &str, options: &str) -> Result<(Work, Vec<u8>)> {
        let given = WriteOptions::read(options)?;
        let (mesh, exporter) = (&self.mesh, exporter_of(name));
        given.check(name, exporter)?;
        if let Some(exporter) = exporter {
            let compress = given.compress();
            let WriteOptions { ascii, export_flags: flags, .. } = given;
            let options = ExportOptions { flags, ascii, compress, ..ExportOptions::default() };
            return Ok((Work::Resting(export_work(mesh.clone(), exporter, options)?), Vec::new()));
        }
        let (of, ending) = parts_of(name);
        if ending == "links" {
            self.measured.links()?;
            return Ok((Work::Links { next: 0 }, Vec::new()));
        }
        if name == "links.h5" {
            return Ok((Work::Resting(links_work(self.measured.clone(), given.compress())?), Vec::new()));
        }
        let (format, options) = (format_of(ending)?, given.of_mesh(PIECE_BYTES).with_zarr(self.zarr));
        let is_solid = of == "fractions" && format != Format::Npz;
        let around = match is_solid {
            true => solid::around(mesh, self.measured.fractions()?, (format, &options))?,
            false => write::around(mesh, format, &options)?,
        };
        let numbers = || if is_solid { solid::numbers(mesh) } else { vti::Numbers::flags(mesh) };
        let cells = Cells((!is_solid).then_some(options));
        let slabs = || match is_solid {
            true => mesh.slabs(PIECE_BYTES / 4).collect(),
            false => ordered::boxes(mesh.dims(), options.axis_order, PIECE_BYTES),
        };
        Ok(match (around, options.compress) {
            (Some((head, tail)), _) => {
                let mut pieces: Vec<CellBox> = slabs();
                pieces.reverse();
                (Work::Cells { cells, pieces, tail }, head)
            }
            (None, Compress::Zlib(level)) if matches!(format, Format::Vti | Format::Vtr) => {
                (Work::Image { cells, encoder: vti::VtiEncoder::of(numbers(), (format, level), slabs()) }, Vec::new())
            }
            (None, _) if format == Format::ZarrZip => {
                let measured = is_solid.then(|| self.measured.clone());
                (Work::Resting(store_work(mesh.clone(), measured, options)?), Vec::new())
            }
            (None, compress) if format == Format::Npz => {
                // whether there are any shows now
                arrays_of(mesh, &self.measured, of, options)?;
                (Work::Archive { of: of.into(), options, encoder: Box::new(Encoder::new(compress)) }, Vec::new())
            }
            (None, compress) => (Work::Columns(column_file::ColumnFileEncoder::new(mesh, compress)?), Vec::new()),
        })
    }
}

/// The arrays of an archive: of what was measured, or else of the mesh, as the options ask for it.
fn arrays_of<'a>(mesh: &'a Mesh, measured: &'a Measured, of: &str, options: Options) -> Result<Vec<Array<'a>>> {
    match of {
        "links" | "fractions" | "staggered" => measured.arrays(mesh, of),
        _ => Ok(npz::arrays(mesh, options)),
    }
}

/// What stands for a cell: its flag, another number for it, or a bit, as the options say. None: the fraction that is not background.
#[derive(Clone, Copy)]
struct Cells(Option<Options>);

impl Cells {
    fn bytes(self, mesh: &Mesh, measured: &Measured, cells: &CellBox) -> Result<Vec<u8>> {
        match self.0 {
            Some(options) => ordered::bytes_of_box(mesh, &options, cells),
            None => solid::bytes_of_slab(mesh, measured.fractions()?, cells),
        }
    }
}

/// How a file is encoded.
enum Work {
    /// Cells as they are: boxes still to encode, the next one last, and what follows them.
    Cells { cells: Cells, pieces: Vec<CellBox>, tail: Vec<u8> },
    /// A compressed `.vti` or `.vtr`.
    Image { cells: Cells, encoder: vti::VtiEncoder },
    /// Records of links, from this piece on.
    Links { next: usize },
    /// A column file.
    Columns(column_file::ColumnFileEncoder),
    /// Arrays of what was measured, or of the mesh.
    Archive { of: String, options: Options, encoder: Box<Encoder> },
    /// The files of an exporter, links as HDF5, or a store.
    Resting(Resting),
}

impl Work {
    /// The next bytes, possibly none yet; None at the end.
    fn step(&mut self, mesh: &Mesh, measured: &Measured) -> Result<Option<Vec<u8>>> {
        match self {
            Work::Archive { of, options, encoder } => {
                let arrays = arrays_of(mesh, measured, of, *options)?;
                // arrays may be short, and what is deflated waits for more
                let mut made = Vec::new();
                while made.len() < LEAST_PIECE {
                    let Some(more) = encoder.step(&arrays)? else { break };
                    made.extend(more);
                }
                Ok((!made.is_empty()).then_some(made))
            }
            Work::Image { cells, encoder } => encoder.step_of(mesh, &|slab| cells.bytes(mesh, measured, slab)),
            Work::Columns(encoder) => encoder.step(mesh),
            Work::Resting(work) => work.step(),
            Work::Links { next } => {
                *next += 1;
                Ok(links::piece(measured.links()?, *next - 1))
            }
            Work::Cells { cells, pieces, tail } => {
                let Some(piece) = pieces.pop() else {
                    let tail = std::mem::take(tail);
                    return Ok((!tail.is_empty()).then_some(tail));
                };
                cells.bytes(mesh, measured, &piece).map(Some)
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
            Work::Image { encoder, .. } => encoder.share(),
            Work::Resting(work) => work.share(),
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
