//! The head of a column file.

use crate::checksum::crc32;
use crate::error::{Error, Result};
use crate::lines::Lines;
use crate::mesh::{Mesh, Named};
use crate::rays::Rays;

use super::layout::{MAGIC, MAX_BODY, MAX_DIM, VERSION, corrupt};

/// What the head says.
#[derive(Debug)]
pub(super) struct Head {
    pub(super) rays: Rays,
    pub(super) zlib: bool,
    pub(super) lines: Lines,
    pub(super) unit: Option<String>,
    pub(super) names: Vec<Named>,
}

/// Lays out the head of a mesh, checksum included.
///
/// # Errors
/// `job-value` where the names are longer than a head may be.
pub(super) fn encode(mesh: &Mesh, zlib: bool) -> Result<Vec<u8>> {
    let mut body = Vec::new();
    mesh.dims().iter().for_each(|n| body.extend(n.to_le_bytes()));
    body.extend([mesh.columns.rays.axis as u8, u8::from(zlib), 0, 0]);
    [mesh.lines.origin, mesh.lines.spacing].as_flattened().iter().for_each(|number| body.extend(number.to_le_bytes()));
    body.push(u8::from(mesh.unit.is_some()));
    mesh.unit.iter().for_each(|unit| text(&mut body, unit));
    body.extend((mesh.names.len() as u32).to_le_bytes());
    for named in &mesh.names {
        body.push(named.flag);
        text(&mut body, &named.name);
    }
    if body.len() > MAX_BODY {
        let message = format!("names of {} bytes; a column file holds {MAX_BODY}", body.len());
        return Err(Error::new("job-value", message, "give the geometries shorter names"));
    }
    let mut head = [&MAGIC[..], &VERSION.to_le_bytes(), &(body.len() as u32).to_le_bytes(), &body].concat();
    head.extend(crc32(&head));
    Ok(head)
}

fn text(body: &mut Vec<u8>, text: &str) {
    body.extend((text.len() as u32).to_le_bytes());
    body.extend(text.as_bytes());
}

/// Reads the body of a head whose checksum was right; `start` is its place in the file.
///
/// # Errors
/// `columns-corrupt` where a value is out of range or the body ends early or late.
pub(super) fn decode(body: &[u8], start: u64) -> Result<Head> {
    let mut at = Cursor { body, at: 0, start };
    let dims = [at.u32()?, at.u32()?, at.u32()?];
    let n_cells = dims.iter().try_fold(1i64, |product, &n| product.checked_mul(n.into()));
    if dims.iter().any(|n| !(1..=MAX_DIM).contains(n)) || n_cells.is_none() {
        return Err(at.wrong(format!("{dims:?} cells")));
    }
    let [axis, zlib, kind, zero] = at.array()?;
    if axis > 2 || zlib > 1 || kind != 0 || zero != 0 {
        return Err(at.wrong(format!("ray axis {axis}, compression {zlib}, lines of kind {kind}, {zero}")));
    }
    let origin = [at.f64()?, at.f64()?, at.f64()?];
    let spacing = [at.f64()?, at.f64()?, at.f64()?];
    let lines = Lines::new(origin, spacing, dims).map_err(|error| at.wrong(error.to_string()))?;
    let unit = match at.array()? {
        [0] => None,
        [1] => Some(at.text()?),
        [other] => return Err(at.wrong(format!("{other} where 0 or 1 says whether there is a unit"))),
    };
    let mut names = Vec::new();
    for _ in 0..at.u32()? {
        let [flag] = at.array()?;
        if flag == 0 {
            return Err(at.wrong("a name for flag 0".into()));
        }
        names.push(Named { flag, name: at.text()? });
    }
    if at.at != body.len() {
        return Err(at.wrong(format!("{} bytes after the names", body.len() - at.at)));
    }
    Ok(Head { rays: Rays::new(usize::from(axis), dims), zlib: zlib == 1, lines, unit, names })
}

struct Cursor<'a> {
    body: &'a [u8],
    at: usize,
    start: u64,
}

impl<'a> Cursor<'a> {
    fn wrong(&self, what: String) -> Error {
        corrupt(format!("the head says, before byte {}: {what}", self.start + self.at as u64))
    }

    fn bytes(&mut self, n: usize) -> Result<&'a [u8]> {
        let rest = &self.body[self.at..];
        let bytes = rest.get(..n).ok_or_else(|| self.wrong(format!("{n} bytes, and {} follow", rest.len())))?;
        self.at += n;
        Ok(bytes)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N]> {
        let mut array = [0; N];
        array.copy_from_slice(self.bytes(N)?);
        Ok(array)
    }

    fn u32(&mut self) -> Result<u32> {
        self.array().map(u32::from_le_bytes)
    }

    fn f64(&mut self) -> Result<f64> {
        self.array().map(f64::from_le_bytes)
    }

    fn text(&mut self) -> Result<String> {
        let n = self.u32()? as usize;
        let bytes = self.bytes(n)?;
        String::from_utf8(bytes.to_vec()).map_err(|error| self.wrong(error.to_string()))
    }
}
