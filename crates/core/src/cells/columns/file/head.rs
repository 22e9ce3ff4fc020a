//! The head of a column file.

use super::{corrupt, u32_at};
use crate::base::checksum::crc32;
use crate::base::error::{Error, Result};
use crate::grid::lines::Lines;
use crate::grid::rays::Rays;
use crate::input::geometry::Material;

/// What a file starts with.
pub const MAGIC: [u8; 8] = *b"\x89HXC\r\n\x1a\n";
/// The version that is written of equal cells, that of cells that differ in size, and that of either where flags have materials or flag 0
/// has a name.
pub(crate) const VERSION: u32 = 2;
pub(crate) const LISTED: u32 = 3;
pub(crate) const WITH_MATERIALS: u32 = 4;
/// Bytes before the body.
pub const START: usize = 16;
/// Most bytes of a body without lines, and with them.
const MAX_BODY: usize = 1 << 20;
const MAX_LISTED_BODY: usize = 1 << 23;
const MAX_DIM: u32 = 1 << 24;

/// A flag in use and its name.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Named {
    /// The flag, 0 to 255; 0 where the job names the background.
    pub flag: u8,
    /// Name of the geometry that carries it.
    pub name: String,
    /// What its cells are made of.
    pub material: Material,
}

impl Named {
    /// A flag and its name.
    pub fn new(flag: u8, name: impl Into<String>) -> Named {
        Named { flag, name: name.into(), material: Material::default() }
    }
}

/// What the head of a column file says.
#[derive(Debug, Clone, PartialEq)]
#[doc(hidden)]
pub struct Head {
    /// What is meshed, where the file is not finished yet.
    #[doc(hidden)]
    pub identity: Option<[u8; 32]>,
    /// The rays.
    #[doc(hidden)]
    pub rays: Rays,
    /// Whether pieces are compressed.
    #[doc(hidden)]
    pub zlib: bool,
    /// The mesh lines.
    #[doc(hidden)]
    pub lines: Lines,
    /// Unit of lengths, if one was named.
    #[doc(hidden)]
    pub unit: Option<String>,
    /// Names of flags.
    #[doc(hidden)]
    pub names: Vec<Named>,
}

impl Head {
    /// Lays out the head, checksum included.
    ///
    /// # Errors
    /// `job-value` where the names are longer than a head may be.
    #[doc(hidden)]
    pub fn encode(&self) -> Result<Vec<u8>> {
        let mut body = vec![u8::from(self.identity.is_some())];
        body.extend(self.identity.iter().flatten());
        self.lines.dims().iter().for_each(|n| body.extend(n.to_le_bytes()));
        body.extend([self.rays.axis as u8, u8::from(self.zlib), u8::from(self.lines.is_graded()), 0]);
        let numbers = match self.lines.spacing() {
            Some(spacing) => [self.lines.origin(), spacing].concat(),
            None => [0, 1, 2].map(|axis| self.lines.list(axis)).concat(),
        };
        let without_lines = body.len();
        numbers.iter().for_each(|number| body.extend(number.to_le_bytes()));
        let n_of_lines = if self.lines.is_graded() { body.len() - without_lines } else { 0 };
        body.push(u8::from(self.unit.is_some()));
        self.unit.iter().for_each(|unit| text(&mut body, unit));
        body.extend((self.names.len() as u32).to_le_bytes());
        for named in &self.names {
            body.push(named.flag);
            text(&mut body, &named.name);
        }
        let version = version(&self.lines, &self.names);
        if version == WITH_MATERIALS {
            self.names
                .iter()
                .for_each(|named| text(&mut body, &serde_json::to_string(&named.material).unwrap_or_default()));
        }
        if body.len() - n_of_lines > MAX_BODY {
            let n_bytes = body.len() - n_of_lines;
            let message = format!("names of {n_bytes} bytes; a column file holds {MAX_BODY}");
            return Err(Error::new("job-value", message, "give the geometries shorter names"));
        }
        let mut head = [&MAGIC[..], &version.to_le_bytes(), &(body.len() as u32).to_le_bytes(), &body].concat();
        head.extend(crc32(&head));
        Ok(head)
    }
}

/// The version of the file of a mesh.
fn version(lines: &Lines, names: &[Named]) -> u32 {
    let has_more = names.iter().any(|named| named.flag == 0 || !named.material.is_empty());
    match (has_more, lines.is_graded()) {
        (true, _) => WITH_MATERIALS,
        (false, true) => LISTED,
        (false, false) => VERSION,
    }
}

fn text(body: &mut Vec<u8>, text: &str) {
    body.extend((text.len() as u32).to_le_bytes());
    body.extend(text.as_bytes());
}

/// Version and number of bytes of the body of a head that starts with these [`START`] bytes.
///
/// # Errors
/// `columns-corrupt` where they do not start a column file; `columns-version` where a newer hexcast wrote it.
pub fn start(bytes: &[u8]) -> Result<(u32, usize)> {
    if bytes[..8] != MAGIC {
        return Err(corrupt("this is not a column file: it does not start with the signature of one".into()));
    }
    let (version, n_body) = (u32_at(bytes, 8), u32_at(bytes, 12) as usize);
    if version > WITH_MATERIALS {
        let message = format!("the column file has version {version}; this hexcast reads up to {WITH_MATERIALS}");
        return Err(Error::new("columns-version", message, "use a newer hexcast"));
    }
    let most = if version >= LISTED { MAX_LISTED_BODY } else { MAX_BODY };
    if version < VERSION || n_body > most {
        return Err(corrupt(format!("the head says, at byte 8: version {version}, {n_body} bytes")));
    }
    Ok((version, n_body))
}

/// Reads the body of a head whose checksum was right.
///
/// # Errors
/// `columns-corrupt` where a value is out of range or the body ends early or late.
pub fn decode(version: u32, body: &[u8]) -> Result<Head> {
    let mut at = Cursor { body, at: 0, start: START as u64 };
    let identity = match at.array()? {
        [0] => None,
        [1] => Some(at.array()?),
        [other] => return Err(at.wrong(format!("{other} where 0 or 1 must say whether there is an identity"))),
    };
    let dims = [at.u32()?, at.u32()?, at.u32()?];
    let n_cells = dims.iter().try_fold(1i64, |product, &n| product.checked_mul(n.into()));
    if dims.iter().any(|n| !(1..=MAX_DIM).contains(n)) || n_cells.is_none() {
        return Err(at.wrong(format!("{dims:?} cells")));
    }
    let [axis, zlib, kind, zero] = at.array()?;
    let is_listed = version == LISTED || (version == WITH_MATERIALS && kind == 1);
    if axis > 2 || zlib > 1 || kind != u8::from(is_listed) || zero != 0 {
        return Err(at.wrong(format!("ray axis {axis}, compression {zlib}, lines of kind {kind}, {zero}")));
    }
    let lines = if is_listed { at.lists(dims)? } else { at.spacing(dims)? };
    let unit = match at.array()? {
        [0] => None,
        [1] => Some(at.text()?),
        [other] => return Err(at.wrong(format!("{other} where 0 or 1 must say whether there is a unit"))),
    };
    let mut names = Vec::new();
    for _ in 0..at.u32()? {
        let [flag] = at.array()?;
        if flag == 0 && version < WITH_MATERIALS {
            return Err(at.wrong("a name for flag 0".into()));
        }
        names.push(Named::new(flag, at.text()?));
    }
    if version == WITH_MATERIALS {
        for named in &mut names {
            let material = serde_json::from_str(&at.text()?);
            named.material =
                material.map_err(|error| at.wrong(format!("the material of flag {}: {error}", named.flag)))?;
            if let Some((key, value, allowed)) = named.material.out_of_range() {
                return Err(at.wrong(format!("{key} = {value} of flag {}; allowed: {allowed}", named.flag)));
            }
        }
    }
    if at.at != body.len() {
        return Err(at.wrong(format!("{} bytes after the names", body.len() - at.at)));
    }
    Ok(Head { identity, rays: Rays::new(usize::from(axis), dims), zlib: zlib == 1, lines, unit, names })
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

    fn spacing(&mut self, dims: [u32; 3]) -> Result<Lines> {
        let origin = [self.f64()?, self.f64()?, self.f64()?];
        let spacing = [self.f64()?, self.f64()?, self.f64()?];
        Lines::new(origin, spacing, dims).map_err(|error| self.wrong(error.to_string()))
    }

    fn lists(&mut self, dims: [u32; 3]) -> Result<Lines> {
        let mut lists = [const { Vec::new() }; 3];
        for (list, n) in lists.iter_mut().zip(dims) {
            let bytes = self.bytes(8 * (n as usize + 1))?;
            *list = bytes.as_chunks::<8>().0.iter().map(|number| f64::from_le_bytes(*number)).collect();
        }
        Lines::from_lists(lists).map_err(|error| self.wrong(error.to_string()))
    }

    fn text(&mut self) -> Result<String> {
        let n = self.u32()? as usize;
        let bytes = self.bytes(n)?;
        String::from_utf8(bytes.to_vec()).map_err(|error| self.wrong(error.to_string()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn head(names: &[&str]) -> Head {
        let lines = Lines::new([0.0; 3], [1.0; 3], [3, 4, 5]).unwrap();
        let names = (1..).zip(names).map(|(flag, name)| Named::new(flag, name.to_string())).collect();
        Head { identity: None, rays: Rays::new(1, [3, 4, 5]), zlib: true, lines, unit: Some("mm".into()), names }
    }

    #[test]
    fn names_longer_than_a_head_are_refused_with_their_bytes() {
        let long = "x".repeat(1 << 19);
        let bytes = head(&["a"]).encode().unwrap();
        let (version, n_body) = start(&bytes).unwrap();
        assert_eq!((version, n_body), (VERSION, bytes.len() - START - 4));
        // another name takes five bytes more than its text
        let n = n_body + 2 * (5 + (1 << 19));
        let error = head(&["a", &long, &long]).encode().unwrap_err();
        assert_eq!(
            (error.code(), error.to_string()),
            ("job-value", format!("names of {n} bytes; a column file holds 1048576"))
        );
        let fits = "x".repeat((1 << 20) - n_body - 5);
        assert_eq!(start(&head(&["a", &fits]).encode().unwrap()).unwrap(), (VERSION, 1 << 20));
        // listed lines, 8 bytes each, are not counted; equally spaced ones, 48 bytes, are
        let listed = |name: &str| {
            let lines = Lines::from_lists([4, 5, 6].map(|n| (0..n).map(|k| f64::from(k * k)).collect())).unwrap();
            Head { lines, ..head(&["a", name]) }.encode()
        };
        let fits = format!("{fits}{}", "x".repeat(48));
        assert_eq!(start(&listed(&fits).unwrap()).unwrap(), (LISTED, (1 << 20) + 8 * 15));
        let error = listed(&(fits + "x")).unwrap_err();
        assert_eq!(error.to_string(), "names of 1048577 bytes; a column file holds 1048576");
    }

    #[test]
    fn heads_that_no_hexcast_wrote_are_refused() {
        let bytes = head(&["a"]).encode().unwrap();
        let begins = |version: u32, n_body: u32| {
            start(&[&bytes[..8], &version.to_le_bytes(), &n_body.to_le_bytes()].concat()).map_err(|error| error.code())
        };
        assert_eq!([begins(2, 1 << 20), begins(3, 1 << 23)], [Ok((2, 1 << 20)), Ok((3, 1 << 23))]);
        let wrong = [begins(0, 9), begins(1, 9), begins(2, (1 << 20) + 1), begins(3, (1 << 23) + 1)];
        assert_eq!((wrong, begins(5, 9)), ([Err("columns-corrupt"); 4], Err("columns-version")));
        let body = &bytes[START..bytes.len() - 4];
        let found = decode(VERSION, body).unwrap();
        assert_eq!(
            (found.rays, found.zlib, found.unit, &found.names),
            (Rays::new(1, [3, 4, 5]), true, Some("mm".into()), &head(&["a"]).names)
        );
        // the one name is a flag, four bytes of length, a letter
        let mut no_flag = body.to_vec();
        no_flag[body.len() - 6] = 0;
        for (body, sentence) in [(no_flag, "a name for flag 0"), ([body, &[1, 2]].concat(), "2 bytes after the names")]
        {
            let error = decode(VERSION, &body).err().unwrap();
            assert!(error.code() == "columns-corrupt" && error.to_string().contains(sentence), "{error}");
        }
    }
}
