//! OFF: a line `OFF`, a line of the numbers of corners, polygons and edges, the corners, the polygons as a number and as many indices.
//!
//! The numbers may stand behind the word. Of `COFF`, `NOFF`, `STOFF` and the like, normals, colours and textures are passed over. Source:
//! the manual of Geomview, section 4.2.5. The binary variant and those with four coordinates are refused.
//!
//! Our own reader: it is as long as a call of another would be, and says on which line the file is wrong.

use super::contents::{Contents, Format};
use super::polygons::{CORNERS, Polygons};
use super::words::Lines;
use crate::base::error::Result;
use crate::base::memory::{List, Memory};

/// Whether the first word is one of those of OFF.
pub(super) fn is_off(head: &[u8]) -> bool {
    first_word(head)
        .is_some_and(|word| word.ends_with(b"OFF") && word.len() <= 8 && word.iter().all(u8::is_ascii_alphanumeric))
}

fn first_word(head: &[u8]) -> Option<&[u8]> {
    Lines::new(head).next_line()?.next()
}

pub(super) fn read(bytes: &[u8], n_bytes: u64, memory: &Memory) -> Result<Contents> {
    let mut lines = Lines::new(bytes);
    let mut words = lines.next_line();
    let word = words.as_mut().and_then(|words| words.next()).unwrap_or_default();
    let kind = &word[..word.len().saturating_sub(3)];
    if kind.contains(&b'4') || kind.contains(&b'n') {
        return Err(lines.wrong("corners of more or fewer than three coordinates cannot be read"));
    }
    let mut rest = words.filter(|words| words.clone().next().is_some());
    if rest.as_mut().and_then(|words| words.clone().next()).is_some_and(|word| word == b"BINARY") {
        return Err(lines.wrong("binary OFF cannot be read"));
    }
    if rest.is_none() {
        rest = lines.next_line();
    }
    let mut counts = rest.ok_or_else(|| ended(&lines, "the numbers of corners and polygons"))?;
    let what = "the numbers of corners and polygons are needed";
    let n_corners: u64 = lines.number(counts.next(), what)?;
    let n_polygons: u64 = lines.number(counts.next(), what)?;
    let mut polygons = Polygons::within(memory);
    for _ in 0..n_corners {
        let words = lines.next_line().ok_or_else(|| ended(&lines, &format!("{n_corners} corners")))?;
        let corner = lines.corner(words)?;
        polygons.corner(corner, || lines.place())?;
    }
    let mut corners = List::new(memory, CORNERS);
    for _ in 0..n_polygons {
        let mut words = lines.next_line().ok_or_else(|| ended(&lines, &format!("{n_polygons} polygons")))?;
        let n: usize = lines.number(words.next(), "the number of corners of a polygon is needed")?;
        corners.clear();
        for word in words.by_ref().take(n) {
            let index: usize = lines.number(Some(word), "a polygon needs indices of corners")?;
            if index >= polygons.corners.len() {
                return Err(lines.wrong(&format!("there is no corner {index} of {n_corners}, counted from 0")));
            }
            corners.push(index)?;
        }
        if corners.len() < n {
            return Err(lines.wrong(&format!("{n} indices are announced, and {} are there", corners.len())));
        }
        polygons.polygon(&corners, || lines.place())?;
    }
    if lines.next_line().is_some() {
        let text = format!("what follows the {n_polygons} polygons, from line {} on, is ignored", lines.number);
        polygons.warnings.push(text);
    }
    polygons.finish(Format::Off, n_bytes)
}

fn ended(lines: &Lines<'_>, before: &str) -> crate::base::error::Error {
    lines.wrong(&format!("the file ends before {before}"))
}
