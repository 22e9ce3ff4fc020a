//! ASCII STL: one statement a line, in any case, separated by any spaces, ended by LF, CRLF or CR.
//!
//! ```text
//! solid NAME
//!   facet normal X Y Z
//!     outer loop
//!       vertex X Y Z        three times
//!     endloop
//!   endfacet                any number of facets
//! endsolid NAME             any number of solids
//! ```
//!
//! Accepted beyond it: blank lines, a byte order mark, no final line end, an `endsolid` that is missing (warned about),
//! any text for the numbers of a normal, bytes of value 0 or 26 after the last solid. Numbers are rounded to the
//! nearest f32. A line may be [`MAX_LINE`] bytes long, so that garbage cannot fill the memory.

use super::contents::{self, Contents, FACETS, Format, SOLID_BYTES, SOLIDS, Solid, Tally, Warnings};
use super::text;
use crate::base::error::{Error, Result};
use crate::base::memory::{Held, List, Memory};
use crate::input::geometry::{Facet, SharedFacets};

/// Longest line, in bytes.
const MAX_LINE: usize = 1 << 16;

/// The statement that must come next.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
enum Expect {
    #[default]
    Solid,
    Facet,
    Loop,
    /// The corner of this index.
    Vertex(usize),
    EndLoop,
    EndFacet,
}

/// Reads a text from its first byte.
#[derive(Debug)]
pub(super) struct Parser {
    /// The beginning of a line that the last chunk cut.
    partial: Vec<u8>,
    after_carriage_return: bool,
    /// Number of the line being read, from 1.
    line: u64,
    expect: Expect,
    facet_line: u64,
    normal: [f32; 3],
    corners: Facet,
    /// Facets of all solids.
    facets: List<Facet>,
    /// Name of each solid and number of facets before it.
    solids: List<(String, usize)>,
    /// The bytes of these names.
    names: Held,
    solid_line: u64,
    tally: Tally,
    warnings: Warnings,
}

impl Parser {
    /// Nothing read yet.
    pub(super) fn within(memory: &Memory) -> Parser {
        Parser {
            partial: Vec::new(),
            after_carriage_return: false,
            line: 0,
            expect: Expect::default(),
            facet_line: 0,
            normal: [0.0; 3],
            corners: Facet::default(),
            facets: List::new(memory, FACETS),
            solids: List::new(memory, SOLIDS),
            names: Held::of(memory),
            solid_line: 0,
            tally: Tally::default(),
            warnings: Warnings::default(),
        }
    }

    /// Takes the next bytes of the text.
    ///
    /// # Errors
    /// `stl-syntax`, `stl-not-finite`, `too-many-facets`, `memory` as in [`super::Reader::push`].
    pub(super) fn push(&mut self, mut bytes: &[u8]) -> Result<()> {
        while !bytes.is_empty() {
            if std::mem::take(&mut self.after_carriage_return) && bytes[0] == b'\n' {
                bytes = &bytes[1..];
                continue;
            }
            let Some(end) = bytes.iter().position(|byte| matches!(byte, b'\n' | b'\r')) else {
                return self.keep(bytes);
            };
            self.after_carriage_return = bytes[end] == b'\r';
            if self.partial.is_empty() {
                self.whole_line(&bytes[..end])?;
            } else {
                self.keep(&bytes[..end])?;
                self.kept_line()?;
            }
            bytes = &bytes[end + 1..];
        }
        Ok(())
    }

    /// Ends the text.
    ///
    /// # Errors
    /// `stl-empty`, `stl-truncated` as in [`super::Reader::finish`], and those of [`Parser::push`] for the last line.
    pub(super) fn finish(mut self, n_bytes: u64) -> Result<Contents> {
        if !self.partial.is_empty() {
            self.kept_line()?;
        }
        match self.expect {
            Expect::Solid => {}
            Expect::Facet => {
                let message = format!("line {}: the file ends without \"endsolid\"", self.line);
                self.warnings.push(message);
                self.end_solid();
            }
            _ => return Err(self.cut_short()),
        }
        let n_facets = self.facets.len() as u64;
        if n_facets == 0 {
            return Err(contents::empty(&format!("no facet in {} lines of ASCII STL", self.line)));
        }
        self.names.keep();
        let (names, starts): (Vec<String>, Vec<usize>) = self.solids.keep().into_iter().unzip();
        let parts = SharedFacets::cut(self.facets.keep(), &starts);
        Ok(Contents {
            format: Format::StlAscii,
            solids: names
                .into_iter()
                .zip(parts)
                .map(|(name, facets)| Solid { name, facets: facets.known_finite() })
                .collect(),
            n_facets,
            n_bytes,
            unit: None,
            wrong_normals: self.tally.wrong_normals,
            zero_normals: self.tally.zero_normals,
            zero_area: self.tally.zero_area,
            has_colours: false,
            conversion: None,
            warnings: self.warnings.finish(),
        })
    }

    fn keep(&mut self, bytes: &[u8]) -> Result<()> {
        if self.partial.len() + bytes.len() > MAX_LINE {
            self.line += 1;
            return Err(self.too_long());
        }
        self.partial.extend_from_slice(bytes);
        Ok(())
    }

    fn kept_line(&mut self) -> Result<()> {
        let mut line = std::mem::take(&mut self.partial);
        let result = self.whole_line(&line);
        line.clear();
        self.partial = line;
        result
    }

    fn whole_line(&mut self, line: &[u8]) -> Result<()> {
        self.line += 1;
        if line.len() > MAX_LINE {
            return Err(self.too_long());
        }
        let line = if self.line == 1 { text::without_mark(line) } else { line };
        let (word, rest) = first_word(line);
        if word.is_empty() { Ok(()) } else { self.statement(Keyword::of(word), rest, line) }
    }

    fn statement(&mut self, keyword: Keyword, rest: &[u8], line: &[u8]) -> Result<()> {
        match (self.expect, keyword) {
            (Expect::Vertex(corner), Keyword::Vertex) => {
                self.corners[corner] = self.vertex(rest, corner)?;
                self.expect = if corner < 2 { Expect::Vertex(corner + 1) } else { Expect::EndLoop };
            }
            (Expect::Facet, Keyword::Facet) => {
                self.facet_line = self.line;
                self.normal = normal(rest);
                self.expect = Expect::Loop;
            }
            (Expect::Loop, Keyword::Outer) if first_word(rest).0.eq_ignore_ascii_case(b"loop") => {
                self.expect = Expect::Vertex(0);
            }
            (Expect::EndLoop, Keyword::EndLoop) => self.expect = Expect::EndFacet,
            (Expect::EndFacet, Keyword::EndFacet) => self.end_facet()?,
            (Expect::Solid, Keyword::Solid) => self.begin_solid(rest)?,
            (Expect::Facet, Keyword::Solid) => {
                let message = format!("line {}: a \"solid\" begins before the \"endsolid\" of the last", self.line);
                self.warnings.push(message);
                self.end_solid();
                self.begin_solid(rest)?;
            }
            (Expect::Facet, Keyword::EndSolid) => self.end_solid(),
            (Expect::Solid, Keyword::Other) if line.iter().all(|b| matches!(b, 0 | 26) || b.is_ascii_whitespace()) => {}
            _ => return Err(self.unexpected(keyword, line)),
        }
        Ok(())
    }

    fn begin_solid(&mut self, name: &[u8]) -> Result<()> {
        let name = String::from_utf8_lossy(name.trim_ascii()).into_owned();
        self.names.grow(SOLID_BYTES + name.len() as u64, SOLIDS)?;
        self.solids.push((name, self.facets.len()))?;
        self.solid_line = self.line;
        self.expect = Expect::Facet;
        Ok(())
    }

    fn end_solid(&mut self) {
        self.expect = Expect::Solid;
        if let Some((name, _)) = self.solids.pop_if(|(_, start)| *start == self.facets.len()) {
            self.names.shrink(SOLID_BYTES + name.len() as u64);
            let name = text::excerpt(name.as_bytes());
            self.warnings.push(format!("line {}: solid \"{name}\" without facets left out", self.solid_line));
        }
    }

    fn end_facet(&mut self) -> Result<()> {
        self.expect = Expect::Facet;
        if self.facets.len() as u64 == u64::from(u32::MAX) {
            let message = format!("line {}: more than {} facets", self.line, u32::MAX);
            return Err(Error::new("too-many-facets", message, "split the model into several files"));
        }
        self.tally.count(self.normal, &self.corners);
        self.facets.push(self.corners)
    }

    /// Reads the three numbers after "vertex".
    fn vertex(&self, mut rest: &[u8], corner: usize) -> Result<[f32; 3]> {
        let mut numbers = [0.0; 3];
        for axis in 0..3 {
            let (word, behind) = first_word(rest);
            numbers[axis] = match number(word) {
                Some(value) if value.is_finite() => value,
                found => return Err(self.bad_number(word, found.is_some(), corner, axis)),
            };
            rest = behind;
        }
        let (word, _) = first_word(rest);
        if word.is_empty() {
            return Ok(numbers);
        }
        let message = format!("line {}: \"{}\" after the three numbers of a vertex", self.line, text::excerpt(word));
        Err(Error::new("stl-syntax", message, "write three coordinates a vertex"))
    }

    fn bad_number(&self, word: &[u8], is_number: bool, corner: usize, axis: usize) -> Error {
        let (line, facet, corner, axis) = (self.line, self.facets.len() + 1, corner + 1, ["x", "y", "z"][axis]);
        let place = format!("line {line}: {axis} of corner {corner} of facet {facet}");
        if word.is_empty() {
            let message = format!("{place} is missing; a vertex has three numbers");
            return Error::new("stl-syntax", message, "copy or export the file again");
        }
        let found = text::excerpt(word);
        if is_number && word.iter().any(u8::is_ascii_digit) {
            let message = format!("{place} is {found}, beyond the largest single-precision number, 3.4e38");
            return Error::new("stl-not-finite", message, "choose a larger unit of length for the model");
        }
        if is_number || names_no_number(word) {
            let hint = "repair the model where it was made; a corner needs three finite numbers";
            return Error::new("stl-not-finite", format!("{place} is {found}"), hint);
        }
        let hint = "write numbers like -1.5e-3, with a decimal point";
        Error::new("stl-syntax", format!("{place}: \"{found}\" is not a number"), hint)
    }

    fn unexpected(&self, keyword: Keyword, line: &[u8]) -> Error {
        if (self.expect, keyword) == (Expect::EndLoop, Keyword::Vertex) {
            let message = format!(
                "line {}: a fourth vertex in the facet of line {}; facets are triangles",
                self.line, self.facet_line
            );
            return Error::new("stl-syntax", message, "triangulate the model on export");
        }
        let (found, expected) = (text::excerpt(line), self.expected());
        let message = format!("line {}: \"{found}\" where {expected} is expected", self.line);
        Error::new("stl-syntax", message, "copy or export the file again")
    }

    fn cut_short(&self) -> Error {
        let message = format!(
            "the file ends after line {}, inside the facet of line {}, where {} is expected; {} facets are whole",
            self.line,
            self.facet_line,
            self.expected(),
            self.facets.len()
        );
        Error::new("stl-truncated", message, "copy or export the file again; it is cut short")
    }

    fn too_long(&self) -> Error {
        let message = format!("line {} is longer than {MAX_LINE} bytes", self.line);
        Error::new("stl-syntax", message, "copy or export the file again; this is not an ASCII STL")
    }

    fn expected(&self) -> String {
        match self.expect {
            Expect::Solid => "\"solid\"".into(),
            Expect::Facet => "\"facet normal\" or \"endsolid\"".into(),
            Expect::Loop => "\"outer loop\"".into(),
            Expect::Vertex(corner) => format!("\"vertex\" {} of 3", corner + 1),
            Expect::EndLoop => "\"endloop\"".into(),
            Expect::EndFacet => "\"endfacet\"".into(),
        }
    }
}

/// The words that begin a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Keyword {
    Solid,
    Facet,
    Outer,
    Vertex,
    EndLoop,
    EndFacet,
    EndSolid,
    Other,
}

impl Keyword {
    fn of(word: &[u8]) -> Keyword {
        let is = |keyword: &str| word.eq_ignore_ascii_case(keyword.as_bytes());
        match word.len() {
            6 if is("vertex") => Keyword::Vertex,
            5 if is("facet") => Keyword::Facet,
            5 if is("outer") => Keyword::Outer,
            5 if is("solid") => Keyword::Solid,
            7 if is("endloop") => Keyword::EndLoop,
            8 if is("endfacet") => Keyword::EndFacet,
            8 if is("endsolid") => Keyword::EndSolid,
            _ => Keyword::Other,
        }
    }
}

/// Splits off the first word; empty where only spaces are left.
fn first_word(line: &[u8]) -> (&[u8], &[u8]) {
    let line = line.trim_ascii_start();
    let end = line.iter().position(u8::is_ascii_whitespace).unwrap_or(line.len());
    line.split_at(end)
}

/// Reads what follows "facet": normals are only reported, so that any text is accepted, and counts as not a number.
fn normal(rest: &[u8]) -> [f32; 3] {
    let (_, mut rest) = first_word(rest);
    std::array::from_fn(|_| {
        let (word, behind) = first_word(rest);
        rest = behind;
        number(word).unwrap_or(f32::NAN)
    })
}

/// Reads the f32 nearest to a decimal number; None where the word is not a number. Numbers beyond f32 come out infinite.
fn number(word: &[u8]) -> Option<f32> {
    str::from_utf8(word).ok()?.parse().ok()
}

/// Whether a word is how some C library prints NaN or infinity, such as `-nan(ind)` or `1.#INF`.
fn names_no_number(word: &[u8]) -> bool {
    let bare = word.strip_prefix(b"-").or(word.strip_prefix(b"+")).unwrap_or(word);
    let begins = |name: &[u8]| bare.len() >= 3 && bare[..3].eq_ignore_ascii_case(name);
    begins(b"nan") || begins(b"inf") || word.contains(&b'#')
}
