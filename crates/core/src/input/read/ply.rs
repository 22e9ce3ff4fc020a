//! PLY: a header that says which elements follow with which properties, then their values, as text or in either order of bytes.
//!
//! Of the element `vertex` the properties x, y and z are taken, of `face` the list `vertex_indices` or `vertex_index`; all else is passed
//! over by its size. Corners given as doubles are rounded to f32. Numbers of elements that a header announces are not trusted: memory is
//! taken as values come. Source: Turk, The PLY polygon file format, 1994.
//!
//! Our own reader: the crates for it make an object of every element, several times the memory of the facets.

use super::contents::{Contents, Format};
use super::polygons::{CORNERS, Polygons};
use super::words::Lines;
use crate::base::error::{Error, Result};
use crate::base::memory::{Held, List, Memory};

/// A type of numbers and its size in bytes.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

const KINDS: &[(&[u8], Kind)] = &[
    (b"char", Kind::I8),
    (b"int8", Kind::I8),
    (b"uchar", Kind::U8),
    (b"uint8", Kind::U8),
    (b"short", Kind::I16),
    (b"int16", Kind::I16),
    (b"ushort", Kind::U16),
    (b"uint16", Kind::U16),
    (b"int", Kind::I32),
    (b"int32", Kind::I32),
    (b"uint", Kind::U32),
    (b"uint32", Kind::U32),
    (b"float", Kind::F32),
    (b"float32", Kind::F32),
    (b"double", Kind::F64),
    (b"float64", Kind::F64),
];

struct Property {
    /// Of the number of values, where it is a list.
    count: Option<Kind>,
    kind: Kind,
    name: Vec<u8>,
}

struct Element {
    name: Vec<u8>,
    n: u64,
    properties: Vec<Property>,
}

#[derive(Clone, Copy, PartialEq)]
enum Encoding {
    Text,
    Little,
    Big,
}

/// Whether the first line is that of PLY.
pub(super) fn is_ply(head: &[u8]) -> bool {
    head.strip_prefix(b"ply").is_some_and(|rest| rest.first().is_some_and(u8::is_ascii_whitespace))
}

pub(super) fn read(bytes: &[u8], n_bytes: u64, memory: &Memory) -> Result<Contents> {
    let mut lines = Lines::new(bytes);
    let (encoding, elements) = header(&mut lines, memory)?;
    let rest = lines.rest();
    let mut values: Box<dyn Values> = match encoding {
        Encoding::Text => Box::new(Text { lines, words: List::new(memory, "the words of a line") }),
        _ => Box::new(Binary {
            rest,
            n_header: bytes.len() - rest.len(),
            n_all: rest.len(),
            is_big: encoding == Encoding::Big,
        }),
    };
    let mut polygons = Polygons::within(memory);
    for element in &elements {
        read_element(element, &mut *values, &mut polygons, memory)?;
    }
    polygons.finish(if encoding == Encoding::Text { Format::PlyAscii } else { Format::PlyBinary }, n_bytes)
}

fn header(lines: &mut Lines<'_>, memory: &Memory) -> Result<(Encoding, Vec<Element>)> {
    let (mut encoding, mut elements) = (None, Vec::<Element>::new());
    // of a line an element or a property and its name, in lists that grow
    let mut room = Held::of(memory);
    let mut is_first = true;
    while let Some(mut words) = lines.next_line() {
        let word = words.next().unwrap_or_default();
        room.grow(4 * size_of::<Element>() as u64, "the lines of its header")?;
        match word {
            b"ply" if is_first => {}
            b"format" => {
                encoding = Some(match words.next() {
                    Some(b"ascii") => Encoding::Text,
                    Some(b"binary_little_endian") => Encoding::Little,
                    Some(b"binary_big_endian") => Encoding::Big,
                    _ => {
                        return Err(
                            lines.wrong("the format is neither ascii nor binary_little_endian nor binary_big_endian")
                        );
                    }
                });
            }
            b"comment" | b"obj_info" => {}
            b"element" => {
                let name = words.next().unwrap_or_default().to_vec();
                let n = lines.number(words.next(), "an element needs a name and a number")?;
                elements.push(Element { name, n, properties: Vec::new() });
            }
            b"property" => {
                let kind = |word: Option<&[u8]>| {
                    let found = KINDS.iter().find(|(name, _)| Some(*name) == word).map(|(_, kind)| *kind);
                    found.ok_or_else(|| lines.wrong("a property has a type that PLY does not have"))
                };
                let first = words.next();
                let (count, first) =
                    if first == Some(b"list") { (Some(kind(words.next())?), words.next()) } else { (None, first) };
                let property = Property { count, kind: kind(first)?, name: words.next().unwrap_or_default().to_vec() };
                let element = elements.last_mut().ok_or_else(|| lines.wrong("a property stands before any element"))?;
                element.properties.push(property);
            }
            b"end_header" => {
                let encoding = encoding.ok_or_else(|| lines.wrong("the header names no format"))?;
                return Ok((encoding, elements));
            }
            _ => return Err(lines.wrong("no line of a header of PLY begins like this")),
        }
        is_first = false;
    }
    Err(lines.wrong("the file ends within its header"))
}

/// Where values come from, one after the other.
trait Values {
    /// Begins an element; of text it is a line.
    fn begin(&mut self) -> Result<()>;
    /// The next number, as f64, which holds all kinds exactly.
    fn next(&mut self, kind: Kind) -> Result<f64>;
    /// The next number as f32, rounded once.
    fn next_f32(&mut self, kind: Kind) -> Result<f32>;
    /// Where it is.
    fn place(&self) -> String;
    /// An error there.
    fn wrong(&self, what: &str) -> Error;
}

struct Text<'a> {
    lines: Lines<'a>,
    /// Of the line, the last first.
    words: List<&'a [u8]>,
}

impl Values for Text<'_> {
    fn begin(&mut self) -> Result<()> {
        let words = self.lines.next_line().ok_or_else(|| self.lines.wrong("the file ends before all elements"))?;
        self.words.clear();
        for word in words {
            self.words.push(word)?;
        }
        self.words.reverse();
        Ok(())
    }

    fn next(&mut self, _: Kind) -> Result<f64> {
        let word = self.words.pop_if(|_| true);
        self.lines.number(word, "a number is needed")
    }

    fn next_f32(&mut self, _: Kind) -> Result<f32> {
        let word = self.words.pop_if(|_| true);
        self.lines.number(word, "a number is needed")
    }

    fn place(&self) -> String {
        self.lines.place()
    }

    fn wrong(&self, what: &str) -> Error {
        self.lines.wrong(what)
    }
}

struct Binary<'a> {
    rest: &'a [u8],
    n_header: usize,
    n_all: usize,
    is_big: bool,
}

impl Binary<'_> {
    fn bytes<const N: usize>(&mut self) -> Result<[u8; N]> {
        let Some((bytes, rest)) = self.rest.split_first_chunk::<N>() else {
            return Err(self.wrong("the file ends before all elements that its header announces"));
        };
        self.rest = rest;
        let mut bytes = *bytes;
        if self.is_big {
            bytes.reverse();
        }
        Ok(bytes)
    }
}

impl Values for Binary<'_> {
    fn begin(&mut self) -> Result<()> {
        Ok(())
    }

    fn next(&mut self, kind: Kind) -> Result<f64> {
        Ok(match kind {
            Kind::I8 => i8::from_le_bytes(self.bytes()?).into(),
            Kind::U8 => u8::from_le_bytes(self.bytes()?).into(),
            Kind::I16 => i16::from_le_bytes(self.bytes()?).into(),
            Kind::U16 => u16::from_le_bytes(self.bytes()?).into(),
            Kind::I32 => i32::from_le_bytes(self.bytes()?).into(),
            Kind::U32 => u32::from_le_bytes(self.bytes()?).into(),
            Kind::F32 => f32::from_le_bytes(self.bytes()?).into(),
            Kind::F64 => f64::from_le_bytes(self.bytes()?),
        })
    }

    fn next_f32(&mut self, kind: Kind) -> Result<f32> {
        self.next(kind).map(|number| number as f32)
    }

    fn place(&self) -> String {
        format!("byte {}", self.n_header + self.n_all - self.rest.len())
    }

    fn wrong(&self, what: &str) -> Error {
        Error::new("file-syntax", format!("{}: {what}", self.place()), "export the model again, or as STL")
    }
}

fn read_element(element: &Element, values: &mut dyn Values, polygons: &mut Polygons, memory: &Memory) -> Result<()> {
    let is_vertex = element.name == b"vertex";
    let is_face = element.name == b"face";
    let axis_of = |name: &[u8]| [b"x", b"y", b"z"].iter().position(|axis| name == *axis);
    let has = |name: &[u8]| element.properties.iter().any(|property| property.name == name && property.count.is_none());
    if is_vertex && !(has(b"x") && has(b"y") && has(b"z")) {
        return Err(values.wrong("the element vertex has no x, y and z"));
    }
    if element.properties.is_empty() {
        return Ok(());
    }
    let mut corners = List::new(memory, CORNERS);
    for _ in 0..element.n {
        values.begin()?;
        let mut corner = [0.0; 3];
        for property in &element.properties {
            let is_polygon = is_face && matches!(&property.name[..], b"vertex_indices" | b"vertex_index");
            match property.count {
                None => match axis_of(&property.name).filter(|_| is_vertex) {
                    Some(axis) => corner[axis] = values.next_f32(property.kind)?,
                    None => _ = values.next(property.kind)?,
                },
                Some(count) => {
                    let n = values.next(count)?;
                    if !(n >= 0.0 && n.fract() == 0.0) {
                        return Err(values.wrong(&format!("a list of {n} values")));
                    }
                    corners.clear();
                    for _ in 0..n as u64 {
                        let index = values.next(property.kind)?;
                        if is_polygon {
                            corners.push(index_of(index, polygons.corners.len(), values)?)?;
                        }
                    }
                    if is_polygon {
                        polygons.polygon(&corners, || values.place())?;
                    }
                }
            }
        }
        if is_vertex {
            polygons.corner(corner, || values.place())?;
        }
    }
    Ok(())
}

fn index_of(index: f64, n: usize, values: &dyn Values) -> Result<usize> {
    let is_there = index >= 0.0 && index < n as f64 && index.fract() == 0.0;
    if is_there {
        Ok(index as usize)
    } else {
        Err(values.wrong(&format!("there is no corner {index} of {n}, counted from 0")))
    }
}
