//! A model file of a 3MF: its unit, its objects and the items of its build.

use std::collections::HashMap;
use std::io::BufRead;

use glam::DAffine3;
use quick_xml::XmlVersion;
use quick_xml::events::{BytesStart, Event};

use super::text::shown;
use super::xml_events::Events;
pub(super) use super::xml_events::wrong;
use crate::base::error::Result;
use crate::base::memory::{Held, List, Memory};

/// Parts of the names of extensions that a reader of solids need not know, or that are read.
const HARMLESS: [&str; 4] = ["/production/", "/material/", "/slice/", "/trianglesets/"];

/// What units are called in a model, and here.
pub const UNITS: [(&str, &str); 6] =
    [("millimeter", "mm"), ("micron", "um"), ("centimeter", "cm"), ("inch", "in"), ("foot", "ft"), ("meter", "m")];
/// That of a model that does not say.
pub const MILLIMETRE: (&str, &str) = UNITS[0];

pub(super) struct Model {
    pub(super) unit: &'static str,
    pub(super) objects: HashMap<u32, Object>,
    pub(super) items: List<Item>,
    /// What objects take, and the names in them.
    room: Held,
}

pub(super) struct Object {
    pub(super) name: String,
    /// Whether it is no part of what is made: a support, or a modifier of a slicer.
    pub(super) is_left_out: bool,
    pub(super) kind: Kind,
}

pub(super) enum Kind {
    Mesh { corners: List<[f32; 3]>, triangles: List<[u32; 3]> },
    Components(List<Placed>),
}

impl Kind {
    fn mesh(memory: &Memory) -> Kind {
        Kind::Mesh {
            corners: List::new(memory, "the corners of an object"),
            triangles: List::new(memory, "the triangles of an object"),
        }
    }
}

/// Bytes of an object in its table, which doubles as it grows.
const OBJECT_BYTES: u64 = 3 * (size_of::<(u32, Object)>() as u64 + 8);

/// An object, in this model file or another, and where it goes.
pub(super) struct Placed {
    pub(super) part: Option<String>,
    pub(super) object: u32,
    pub(super) by: DAffine3,
}

pub(super) struct Item {
    pub(super) placed: Placed,
    pub(super) is_printed: bool,
}

impl Model {
    /// Names of the other model files that this one needs.
    pub(super) fn parts(&self) -> impl Iterator<Item = &str> {
        let components = self.objects.values().flat_map(|object| match &object.kind {
            Kind::Components(components) => &components[..],
            Kind::Mesh { .. } => &[],
        });
        components.chain(self.items.iter().map(|item| &item.placed)).filter_map(|placed| placed.part.as_deref())
    }
}

/// Reads a model file.
pub(super) fn parse(text: &mut dyn BufRead, memory: &Memory) -> Result<Model> {
    let mut events = Events::new(text, memory);
    let mut model = None;
    let mut object: Option<(u32, Object)> = None;
    loop {
        let (event, end) = events.next()?;
        let at = |what: &str| wrong(&format!("byte {end}: {what}"));
        match event {
            Event::Eof => {
                let mut model: Model = model.ok_or_else(|| wrong("there is no element \"model\""))?;
                model.objects.extend(object);
                return Ok(model);
            }
            Event::Start(tag) | Event::Empty(tag) => {
                let name = tag.local_name();
                let Some(model) = &mut model else {
                    if name.as_ref() != b"model" {
                        return Err(at("the first element is not \"model\""));
                    }
                    model = Some(head(&tag, memory)?);
                    continue;
                };
                match name.as_ref() {
                    b"object" => {
                        model.objects.extend(object.take());
                        let kind = attribute(&tag, "type")?;
                        let is_left_out = matches!(kind.as_deref(), Some("support" | "solidsupport" | "other"));
                        if local(&tag, b"meshresolution")?.as_deref() == Some("lowres") {
                            return Err(at("an object is made of slices, and its mesh is a coarse stand-in"));
                        }
                        let name = attribute(&tag, "name")?.unwrap_or_default();
                        model.room.grow(OBJECT_BYTES + 2 * name.len() as u64, "the objects of a model")?;
                        object = Some((number(&tag, "id")?, Object { name, is_left_out, kind: Kind::mesh(memory) }));
                    }
                    b"item" => {
                        let is_printed = !matches!(attribute(&tag, "printable")?.as_deref(), Some("0" | "false"));
                        let placed = placed(&tag, &mut model.room)?;
                        model.items.push(Item { placed, is_printed })?;
                    }
                    name => {
                        if let Some((_, object)) = &mut object {
                            object.add(name, &tag, &mut model.room)?;
                        }
                    }
                }
            }
            _ => {}
        }
    }
}

impl Object {
    /// Takes a corner, a triangle or a component.
    fn add(&mut self, name: &[u8], tag: &BytesStart<'_>, room: &mut Held) -> Result<()> {
        match (name, &mut self.kind) {
            (b"vertex", Kind::Mesh { corners, .. }) => {
                corners.push([number(tag, "x")?, number(tag, "y")?, number(tag, "z")?])?;
            }
            (b"triangle", Kind::Mesh { triangles, .. }) => {
                triangles.push([number(tag, "v1")?, number(tag, "v2")?, number(tag, "v3")?])?;
            }
            (b"components", kind) => {
                *kind = Kind::Components(List::new(room.memory(), "the components of an object"));
            }
            (b"component", Kind::Components(components)) => components.push(placed(tag, room)?)?,
            (b"beamlattice", _) => return Err(wrong("it has a beam lattice, which cannot be read")),
            _ => {}
        }
        Ok(())
    }
}

/// What the element of a model itself says.
fn head(tag: &BytesStart<'_>, memory: &Memory) -> Result<Model> {
    let unit = match attribute(tag, "unit")?.as_deref() {
        None => MILLIMETRE.1,
        Some(name) => match UNITS.iter().find(|(known, _)| *known == name) {
            Some((_, unit)) => unit,
            None => return Err(wrong(&format!("\"{}\" is not one of its units", shown(name, 20)))),
        },
    };
    for prefix in attribute(tag, "requiredextensions")?.unwrap_or_default().split_ascii_whitespace() {
        let space = attribute(tag, &format!("xmlns:{prefix}"))?.unwrap_or_default();
        if !HARMLESS.iter().any(|known| space.contains(known)) {
            return Err(wrong(&format!(
                "the file needs the extension {}, which cannot be read",
                shown(&format!("{prefix} ({space})"), 100)
            )));
        }
    }
    Ok(Model {
        unit,
        objects: HashMap::new(),
        items: List::new(memory, "the items of its build"),
        room: Held::of(memory),
    })
}

fn placed(tag: &BytesStart<'_>, room: &mut Held) -> Result<Placed> {
    let by = match attribute(tag, "transform")? {
        None => DAffine3::IDENTITY,
        Some(text) => {
            let numbers: Option<Vec<f64>> = text.split_ascii_whitespace().map(|word| word.parse().ok()).collect();
            // rows of the specification multiply a row from the left: they are columns of ours
            let numbers = numbers.and_then(|numbers| <[f64; 12]>::try_from(numbers).ok());
            DAffine3::from_cols_array(
                &numbers.ok_or_else(|| wrong(&format!("transform=\"{}\" is not 12 numbers", shown(&text, 60))))?,
            )
        }
    };
    // it has the prefix of the production extension
    let part = local(tag, b"path")?.map(|path| key(&path));
    // also in the list of parts that are needed
    room.grow(3 * part.as_ref().map_or(0, String::len) as u64, "the names of parts")?;
    Ok(Placed { part, object: number(tag, "objectid")?, by })
}

/// Names of files in such an archive do not distinguish ASCII letters by their case (ECMA-376-2), and may begin with slashes.
pub(super) fn key(name: &str) -> String {
    name.trim_start_matches('/').to_ascii_lowercase()
}

/// The value of an attribute, whatever the prefix of its name.
fn local(tag: &BytesStart<'_>, name: &[u8]) -> Result<Option<String>> {
    let mut attributes = tag.attributes();
    let found = attributes.with_checks(false).flatten().find(|of| of.key.local_name().as_ref() == name);
    let value = found.map(|of| of.normalized_value(XmlVersion::Implicit1_0).map(|value| value.into_owned()));
    value.transpose().map_err(|error| wrong(&shown(&error.to_string(), 150)))
}

/// The value of an attribute.
pub(super) fn attribute(tag: &BytesStart<'_>, name: &str) -> Result<Option<String>> {
    let wrong =
        |error: &dyn std::fmt::Display| wrong(&format!("attribute {name:?}: {}", shown(&error.to_string(), 150)));
    let found = tag.try_get_attribute(name).map_err(|error| wrong(&error))?;
    found
        .map(|found| {
            found
                .normalized_value(XmlVersion::Implicit1_0)
                .map(|value| value.into_owned())
                .map_err(|error| wrong(&error))
        })
        .transpose()
}

/// The number that an attribute must have.
fn number<T: std::str::FromStr>(tag: &BytesStart<'_>, name: &str) -> Result<T> {
    let found = tag.try_get_attribute(name).ok().flatten();
    let number = found.and_then(|found| std::str::from_utf8(&found.value).ok()?.trim().parse().ok());
    number.ok_or_else(|| {
        let element = shown(&String::from_utf8_lossy(tag.name().as_ref()), 20);
        wrong(&format!("an element \"{element}\" has no number \"{name}\""))
    })
}
