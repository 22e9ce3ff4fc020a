//! Wavefront OBJ: `v` corners, `f` polygons of their numbers, `g` and `o` names of what follows; all else is passed over.
//!
//! Numbers of corners count from 1, or backwards from the last one where they are negative; what follows a `/` belongs to textures and
//! normals. A `\` at the end of a line joins the next one to it. Source: the specification of Wavefront, version 3.0, as in Bourke's copy.
//!
//! Our own reader: the crates for it keep textures and normals, trust indices, or join groups of one name from all over the file.

use std::borrow::Cow;

use super::contents::{Contents, Format};
use super::polygons::{CORNERS, Polygons};
use super::text::excerpt;
use super::words::Lines;
use crate::base::error::Result;
use crate::base::memory::{List, Memory};

/// Words that lines of an OBJ file begin with; others end what is taken for one.
const WORDS: &[&[u8]] = &[
    b"v", b"vt", b"vn", b"vp", b"f", b"fo", b"l", b"p", b"g", b"o", b"s", b"mg", b"usemtl", b"mtllib", b"usemap",
    b"maplib",
];

/// Whether a text may be an OBJ file, by its first line that is no remark.
pub(super) fn is_obj(head: &[u8]) -> bool {
    match Lines::new(head).next_line().and_then(|mut words| words.next()) {
        Some(word) => WORDS.contains(&word),
        // remarks only, as some programs write pages of
        None => head.starts_with(b"#"),
    }
}

pub(super) fn read(bytes: &[u8], n_bytes: u64, memory: &Memory) -> Result<Contents> {
    let copied = if bytes.contains(&b'\\') { bytes.len() as u64 } else { 0 };
    let _room = memory.take(copied, "its lines, joined,")?;
    let joined = joined(bytes);
    let mut lines = Lines::new(&joined);
    let mut polygons = Polygons::within(memory);
    let mut corners = List::new(memory, CORNERS);
    let (mut n_unknown, mut first_unknown) = (0u64, None);
    while let Some(mut words) = lines.next_line() {
        match words.next() {
            Some(b"v") => {
                let corner = lines.corner(words)?;
                polygons.corner(corner, || lines.place())?;
            }
            Some(b"f" | b"fo") => {
                corners.clear();
                for word in words {
                    corners.push(index(&lines, word, polygons.corners.len())?)?;
                }
                polygons.polygon(&corners, || lines.place())?;
            }
            Some(b"g" | b"o") => {
                let name: Vec<Cow<'_, str>> = words.map(String::from_utf8_lossy).collect();
                polygons.solid(&name.join(" "))?;
            }
            Some(word) if WORDS.contains(&word) => {}
            Some(word) if word.iter().all(u8::is_ascii_alphanumeric) => {
                n_unknown += 1;
                first_unknown.get_or_insert_with(|| format!("{} at {}", excerpt(word), lines.place()));
            }
            _ => return Err(lines.wrong("no statement of OBJ begins like this")),
        }
    }
    if let Some(first) = first_unknown {
        let text = format!(
            "{n_unknown} statements that are not polygons are ignored, such as {first}: curved surfaces are not read"
        );
        polygons.warnings.push(text);
    }
    polygons.finish(Format::Obj, n_bytes)
}

/// The bytes with lines that end in a backslash joined to the next.
fn joined(bytes: &[u8]) -> Cow<'_, [u8]> {
    if !bytes.contains(&b'\\') {
        return bytes.into();
    }
    let mut joined = Vec::with_capacity(bytes.len());
    let mut at = 0;
    while let Some(&byte) = bytes.get(at) {
        let ends = [&b"\\\r\n"[..], b"\\\n", b"\\\r"].into_iter().find(|ends| bytes[at..].starts_with(ends));
        joined.push(if ends.is_some() { b' ' } else { byte });
        at += ends.map_or(1, <[u8]>::len);
    }
    joined.into()
}

/// The index, from 0, that `7`, `7/1`, `7//2` or `-1` means where `n` corners are there.
fn index(lines: &Lines<'_>, word: &[u8], n: usize) -> Result<usize> {
    let number = word.split(|byte| *byte == b'/').next();
    let number: i64 = lines.number(number, "a polygon needs numbers of corners")?;
    let index = if number < 0 { n as i64 + number } else { number - 1 };
    let found = usize::try_from(index).ok().filter(|index| *index < n);
    found.ok_or_else(|| lines.wrong(&format!("there is no corner {number} of {n} so far")))
}
