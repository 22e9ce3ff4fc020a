//! Distinguishes formats by length and content: the first bytes of a file and its length -> [`Format`].
//!
//! 1. A file of exactly 84 + 50 n bytes, n the count at byte 80, is binary, whatever its header says: in text these
//!    four bytes make a count of more than 150 million.
//! 2. Otherwise a file is ASCII where the first word is "solid" and what follows is text.
//! 3. Otherwise it is gzip, ZIP (3MF), GLB, PLY, OFF or OBJ by its first bytes or its first word.
//! 4. Otherwise it is binary with missing or extra bytes, unless it is text or a known other format.
//!
//! Cost: at most [`HEAD`] bytes are looked at.

use super::contents::{Format, empty};
use super::stl_binary;
use super::text::{excerpt, without_mark};
use crate::base::error::{Error, Result};

/// How many bytes of a file decide; less where the file is shorter.
pub(super) const HEAD: usize = 1024;

const GIVE: &str = "export the model as STL, OBJ, OFF, PLY, 3MF or GLB";

const FROM_CAD: &str = "name the file itself: the command, Python and C convert it, and so does the page; in JavaScript call readCad of hexcast/cad";

/// First bytes of files that people give in place of surfaces, their name, and what to do.
const OTHERS: &[(&[u8], &str, &str)] = &[
    (b"{", "JSON, such as glTF that is not binary", "export a model as a binary .glb; give a job by --job"),
    (b"\xff\xfe", "UTF-16 text", "save it as ASCII or UTF-8"),
    (b"\xfe\xff", "UTF-16 text", "save it as ASCII or UTF-8"),
    (b"\x89PNG", "a PNG picture", GIVE),
    (b"%PDF", "a PDF document", GIVE),
];

/// Decides the format of a file of `n_bytes` bytes by its first [`HEAD`] ones (all of them where it is shorter).
///
/// # Errors
/// - `stl-empty`: there are no bytes.
/// - `stl-not-stl`: they are of no format that can be read.
pub(super) fn format(head: &[u8], n_bytes: u64) -> Result<Format> {
    if n_bytes == 0 {
        return Err(empty("the file has 0 bytes"));
    }
    if stl_binary::announced(head).is_some_and(|n| stl_binary::n_bytes_of(n) == n_bytes) {
        return Ok(Format::StlBinary);
    }
    let words = without_mark(head).trim_ascii_start();
    let is_text = !head.iter().any(|byte| is_control(*byte));
    if starts_with_word(words, b"solid") && (is_text || has_facet_line(words)) {
        return Ok(Format::StlAscii);
    }
    if let Some(format) = super::whole::format(head, is_text) {
        return Ok(format);
    }
    if let Some(format) = cad_format(head) {
        let message = format!("this is {}, a file of CAD, which has no triangles", format.name());
        return Err(Error::new("stl-not-stl", message, FROM_CAD));
    }
    if let Some((_, name, hint)) = OTHERS.iter().find(|(magic, ..)| head.starts_with(magic)) {
        return Err(Error::new("stl-not-stl", format!("this is {name}, not a surface"), *hint));
    }
    if is_text {
        let found = excerpt(words);
        let begins = "an ASCII STL begins with \"solid\", PLY with \"ply\", OFF with \"OFF\", OBJ with a statement such as \"v\"";
        return Err(Error::new("stl-not-stl", format!("this is text that begins with \"{found}\": {begins}"), GIVE));
    }
    if n_bytes < super::stl_record::HEADER as u64 {
        let message = format!("{n_bytes} bytes that are not text; a binary STL has at least 84");
        return Err(Error::new("stl-not-stl", message, "copy or export the file again"));
    }
    Ok(Format::StlBinary)
}

/// Which format of CAD a file has by its start: STEP begins with `ISO-10303-21;`; the first line of IGES has S or C and the number 1 from column
/// 73 on. Source: ISO 10303-21, 5.4; IGES 5.3, 2.2.4.1.
pub fn cad_format(head: &[u8]) -> Option<Format> {
    let words = without_mark(head).trim_ascii_start();
    if words.strip_prefix(b"ISO-10303-21").is_some_and(|rest| rest.trim_ascii_start().starts_with(b";")) {
        return Some(Format::Step);
    }
    let line = head.split(|byte| matches!(byte, b'\n' | b'\r')).next()?;
    let [b'S' | b'C', number @ ..] = line.get(72..80)? else { return None };
    let number = std::str::from_utf8(number).ok()?.trim();
    (number.parse() == Ok(1)).then_some(Format::Iges)
}

fn is_control(byte: u8) -> bool {
    (byte < b' ' && !matches!(byte, b'\t' | b'\n' | b'\r' | 0x0b | 0x0c)) || byte == 0x7f
}

fn starts_with_word(bytes: &[u8], word: &[u8]) -> bool {
    let rest = bytes.get(word.len()..).unwrap_or_default();
    bytes.len() >= word.len()
        && bytes[..word.len()].eq_ignore_ascii_case(word)
        && rest.first().is_none_or(|next| next.is_ascii_whitespace())
}

/// Whether a line begins with "facet": then control bytes in a name or at the end do not make the file binary.
fn has_facet_line(bytes: &[u8]) -> bool {
    bytes.split(|byte| matches!(byte, b'\n' | b'\r')).any(|line| starts_with_word(line.trim_ascii_start(), b"facet"))
}
