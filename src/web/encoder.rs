//! Files for JavaScript, encoded piece by piece as they are read.

use hexcast_core::set;
use sha2::{Digest, Sha256};
use wasm_bindgen::prelude::*;

use super::border::{JsResult, js_error};
use super::export::{export_work, exporter_of, hdf5_work};
use super::mesh::WebMesh;
use super::work::Resting;
use super::write_options::WriteOptions;
use crate::meshing::measured::Measured;
use hexcast_core::base::checksum::hex;
use hexcast_core::base::error::{Error, Result};
use hexcast_derived::mesh::Mesh;
use hexcast_files::export::{self, ExportOptions};
use hexcast_files::write::cells::Cells;
use hexcast_files::write::{self, Compress, Format, Options, Written, archive, links};

/// Bytes of a piece of a file.
const PIECE_BYTES: usize = 4 << 20;
/// Most bytes of the numbers of a row of chunks of a store, which is held whole, twice: wasm has 4 GiB.
const MAX_ROW: u64 = 1 << 29;

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
        let options = set!(Options { bits, ..Options::default() });
        let size = match (exporter_of(format), parts_of(format)) {
            (Some(exporter), _) => export::exact_size(&self.mesh, exporter, &ExportOptions::default()),
            (None, ("links", _)) => self.measured.links().ok().map(links::n_bytes),
            (None, (of @ ("fractions" | "distance"), ending)) => {
                cells_of(&self.mesh, &self.measured, of, &options).ok().and_then(|cells| {
                    let format = format_of(ending).ok()?;
                    cells.around(format).ok().and_then(|_| cells.exact_size(format))
                })
            }
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
        let written = Written::new(n_bytes, sha256);
        Ok(write::sidecar_json(&self.mesh, &options, &written))
    }

    /// Starts a file: in the format of a mesh, of an exporter, or of what was measured, such as `links.npz`. `options` is JSON.
    pub fn encode(&self, format: &str, options: &str) -> JsResult<WebEncoder> {
        let work = self.work(format, options).map_err(js_error)?;
        Ok(WebEncoder { work, made: Vec::new(), n_taken: 0 })
    }
}

impl WebMesh {
    /// The work of a file. What is wrong with it shows before it begins.
    fn work(&self, name: &str, options: &str) -> Result<Resting> {
        let given = WriteOptions::read(options)?;
        let exporter = exporter_of(name);
        given.check(name, exporter)?;
        let (mesh, measured, compress) = (self.mesh.clone(), self.measured.clone(), given.compress());
        if let Some(exporter) = exporter {
            let WriteOptions { ascii, export_flags: flags, .. } = given;
            let options = set!(ExportOptions { flags, ascii, compress, ..ExportOptions::default() });
            return export_work(mesh, exporter, options);
        }
        match parts_of(name) {
            (of, "h5") => hdf5_work((mesh, measured), of, compress),
            ("links", "links") => {
                measured.links()?;
                Ok(Resting::new(0, |mut out, control| async move {
                    links::write_records(measured.links()?, &mut out, &control).await.map(|_| ())
                }))
            }
            (of @ ("" | "fractions" | "distance"), ending) if of.is_empty() || ending != "npz" => {
                self.work_of_cells(of, format_of(ending)?, given.of_mesh(PIECE_BYTES))
            }
            (of, _) => {
                measured.arrays(&mesh, of)?;
                let of = of.to_string();
                Ok(Resting::new(0, move |mut out, control| async move {
                    let arrays = measured.arrays(&mesh, &of)?;
                    archive::write_with_rests(&arrays, "the arrays", compress, &mut out, &control).await.map(|_| ())
                }))
            }
        }
    }

    /// The work of a file that holds a number for each cell: its flag, or of `fractions` what is not background, or its distance.
    fn work_of_cells(&self, of: &str, format: Format, options: Options) -> Result<Resting> {
        let (mesh, measured, options) = (self.mesh.clone(), self.measured.clone(), options.with_zarr(self.zarr));
        let cells = cells_of(&mesh, &measured, of, &options)?;
        cells.around(format)?;
        if format == Format::ZarrZip {
            let n_bytes = cells.store()?.row_bytes();
            if n_bytes > MAX_ROW {
                let message = format!("zarr: a row of chunks has {n_bytes} bytes, and at most {MAX_ROW} are held here");
                return Err(Error::new(
                    "memory",
                    message,
                    "ask for smaller chunks with the key zarr.chunks of the job",
                ));
            }
        }
        // of these the sizes of all blocks precede the first
        let is_image = matches!((format, options.compress), (Format::Vti | Format::Vtr, Compress::Zlib(_)));
        let n_rests = if is_image { mesh.slabs(cells.n_of_slab()).count() } else { 0 };
        let of = of.to_string();
        Ok(Resting::new(n_rests, move |mut out, control| async move {
            let cells = cells_of(&mesh, &measured, &of, &options)?;
            cells.write(format, &mut out, &control).await.map(|_| ())
        }))
    }
}

/// What a file has for its cells.
fn cells_of<'a>(mesh: &'a Mesh, measured: &'a Measured, of: &str, options: &'a Options) -> Result<Cells<'a>> {
    match of {
        "fractions" => Cells::solid(mesh, measured.fractions()?, options),
        "distance" => Cells::distance(mesh, measured.distance()?, options),
        _ => Ok(Cells::flags(mesh, options)),
    }
}

/// Encodes a file, piece by piece.
#[wasm_bindgen]
pub struct WebEncoder {
    work: Resting,
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
            let Some(made) = self.work.step()? else { return Ok(None) };
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

    /// What the file lacks of the mesh, a sentence each, at its end.
    pub fn lacks(&self) -> Vec<String> {
        self.work.lacks()
    }

    /// Share of the work before the first byte, 0 to 1.
    pub fn share(&self) -> f64 {
        self.work.share()
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
