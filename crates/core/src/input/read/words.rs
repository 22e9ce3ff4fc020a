//! Lines of words: the text of OBJ, OFF and PLY.

use super::text::excerpt;
use crate::base::error::{Error, Result};

/// Lines with their numbers, from 1; of what follows a `#` nothing, and no empty ones.
pub(super) struct Lines<'a> {
    rest: &'a [u8],
    pub(super) number: u64,
    /// The last line, to be shown.
    line: &'a [u8],
}

impl<'a> Lines<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Lines<'a> {
        Lines { rest: bytes, number: 0, line: b"" }
    }

    /// The words of the next line that has some.
    pub(super) fn next_line(&mut self) -> Option<impl Iterator<Item = &'a [u8]> + Clone + use<'a>> {
        loop {
            if self.rest.is_empty() {
                return None;
            }
            let end = self.rest.iter().position(|byte| matches!(byte, b'\n' | b'\r')).unwrap_or(self.rest.len());
            let (line, rest) = self.rest.split_at(end);
            // CR LF is one end of a line
            let n_end = if rest.starts_with(b"\r\n") { 2 } else { 1 };
            self.rest = &rest[n_end.min(rest.len())..];
            self.number += 1;
            self.line = line;
            let before_remark = line.split(|byte| *byte == b'#').next().unwrap_or_default();
            let mut words = before_remark.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()).peekable();
            if words.peek().is_some() {
                return Some(words);
            }
        }
    }

    /// The bytes after the last line.
    pub(super) fn rest(&self) -> &'a [u8] {
        self.rest
    }

    /// Where the last line is.
    pub(super) fn place(&self) -> String {
        format!("line {}", self.number)
    }

    /// The error of the last line.
    pub(super) fn wrong(&self, what: &str) -> Error {
        let message = format!("line {}: {what}, in \"{}\"", self.number, excerpt(self.line));
        Error::new("file-syntax", message, "export the model again, or as STL")
    }

    /// Reads a number of any type from a word.
    pub(super) fn number<T: std::str::FromStr>(&self, word: Option<&[u8]>, what: &str) -> Result<T> {
        let text = word.and_then(|word| std::str::from_utf8(word).ok());
        text.and_then(|text| text.parse().ok()).ok_or_else(|| self.wrong(what))
    }

    /// Reads the three coordinates of a corner.
    pub(super) fn corner(&self, mut words: impl Iterator<Item = &'a [u8]>) -> Result<[f32; 3]> {
        let mut corner = [0.0; 3];
        for number in &mut corner {
            *number = self.number(words.next(), "three coordinates are needed")?;
        }
        Ok(corner)
    }
}
