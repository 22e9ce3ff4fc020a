//! Files for JavaScript, encoded piece by piece as they are read.

use std::rc::Rc;

use sha2::{Digest, Sha256};
use wasm_bindgen::prelude::*;

use super::export::{ExportWork, exporter_of};
use super::measured::Measured;
use super::mesh::WebMesh;
use super::values::{JsResult, js_error};
use super::write_options::WriteOptions;
use crate::checksum::hex;
use crate::error::Result;
use crate::export::{self, ExportOptions};
use crate::flags::CellBox;
use crate::mesh::Mesh;
use crate::write::archive::Encoder;
use crate::write::{self, Compress, Format, Options, Written, column_file, ordered, vti};

/// Bytes of a piece of a file.
const PIECE_BYTES: usize = 4 << 20;
/// Least bytes of a piece of an archive, but for the last.
const LEAST_PIECE: usize = 1 << 16;

fn format_of(name: &str) -> JsResult<Format> {
    Format::of_name(&format!("mesh.{name}")).map_err(js_error)
}

#[wasm_bindgen]
impl WebMesh {
    /// Bytes of an uncompressed file before it is made; none where they depend on the flags.
    pub fn size(&self, format: &str, bits: bool) -> JsResult<Option<f64>> {
        let size = match exporter_of(format) {
            Some(exporter) => export::exact_size(&self.mesh, exporter, &ExportOptions::default()),
            None => write::exact_size(&self.mesh, format_of(format)?, &Options { bits, ..Options::default() }),
        };
        Ok(size.map(|size| size as f64))
    }

    /// Starts hashing the raw file, whose bytes are the flags of all cells unless the options say otherwise.
    pub fn hash(&self, options: &str) -> JsResult<WebHash> {
        Ok(WebHash { pieces: self.encode("raw", options)?, hash: Sha256::new(), n_bytes: 0 })
    }

    /// The description of a raw file, with its hash if that was made.
    pub fn sidecar(&self, options: &str, sha256: Option<String>) -> JsResult<String> {
        let options = WriteOptions::read(options)?.of_mesh(PIECE_BYTES);
        write::around(&self.mesh, Format::Raw, &options).map_err(js_error)?;
        let n_bytes = write::exact_size(&self.mesh, Format::Raw, &options).unwrap_or(0);
        let written = Written { n_bytes, sha256 };
        Ok(write::sidecar_json(&self.mesh, &options, &written))
    }

    /// Starts a file: in the format of a mesh or of an exporter, or `links.npz`, `fractions.npz` or `staggered.npz`. `options` is JSON.
    pub fn encode(&self, format: &str, options: &str) -> JsResult<WebEncoder> {
        let given = WriteOptions::read(options)?;
        let exporter = exporter_of(format);
        given.check(format, exporter).map_err(js_error)?;
        if let Some(exporter) = exporter {
            let compress = given.compress();
            let WriteOptions { ascii, export_flags: flags, .. } = given;
            let options = ExportOptions { flags, ascii, compress, ..ExportOptions::default() };
            let work = ExportWork::new(self.mesh.clone(), exporter, options).map_err(js_error)?;
            return Ok(self.encoder(Work::Export(work), Vec::new()));
        }
        let of = format.strip_suffix(".npz").unwrap_or("");
        let (format, options) = (format_of(format.rsplit('.').next().unwrap_or(""))?, given.of_mesh(PIECE_BYTES));
        let around = write::around(&self.mesh, format, &options).map_err(js_error)?;
        let (work, made) = match (around, options.compress) {
            (Some((head, tail)), _) => {
                let mut pieces = ordered::boxes(self.mesh.dims(), options.axis_order, PIECE_BYTES);
                pieces.reverse();
                (Work::Flags { options, pieces, tail }, head)
            }
            (None, Compress::Zlib(level)) if matches!(format, Format::Vti | Format::Vtr) => {
                (Work::Image(vti::VtiEncoder::new(&self.mesh, format, level, PIECE_BYTES)), Vec::new())
            }
            (None, compress) if format == Format::Npz => {
                // whether there are any shows now
                self.measured.arrays(&self.mesh, of, options).map_err(js_error)?;
                (Work::Archive { of: of.into(), options, encoder: Box::new(Encoder::new(compress)) }, Vec::new())
            }
            (None, compress) => {
                let encoder = column_file::ColumnFileEncoder::new(&self.mesh, compress).map_err(js_error)?;
                (Work::Columns(encoder), Vec::new())
            }
        };
        Ok(self.encoder(work, made))
    }
}

impl WebMesh {
    fn encoder(&self, work: Work, made: Vec<u8>) -> WebEncoder {
        WebEncoder { mesh: self.mesh.clone(), measured: self.measured.clone(), work, made, n_taken: 0 }
    }
}

/// How a file is encoded.
enum Work {
    /// Flags as they are, as other numbers, or a bit each: boxes still to encode, the next one last, and what follows them.
    Flags { options: Options, pieces: Vec<CellBox>, tail: Vec<u8> },
    /// A compressed `.vti`.
    Image(vti::VtiEncoder),
    /// A column file.
    Columns(column_file::ColumnFileEncoder),
    /// Arrays of what was measured, or of the mesh.
    Archive { of: String, options: Options, encoder: Box<Encoder> },
    /// The files of an exporter.
    Export(ExportWork),
}

impl Work {
    /// The next bytes, possibly none yet; None at the end.
    fn step(&mut self, mesh: &Mesh, measured: &Measured) -> Result<Option<Vec<u8>>> {
        match self {
            Work::Archive { of, options, encoder } => {
                let arrays = measured.arrays(mesh, of, *options)?;
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
            Work::Export(export) => export.step(),
            Work::Flags { options, pieces, tail } => {
                let Some(cells) = pieces.pop() else {
                    let tail = std::mem::take(tail);
                    return Ok((!tail.is_empty()).then_some(tail));
                };
                ordered::bytes_of_box(mesh, options, &cells).map(Some)
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
            Work::Export(export) => export.share(),
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
