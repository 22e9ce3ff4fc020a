//! 3MF: a ZIP archive with XML: the items of the build, each an object of triangles or of other objects, placed; with a unit.
//!
//! An item becomes a solid of its object's name. Corners are read as f32, placed in f64 and rounded again. Objects may lie in several model
//! files of the archive (the production extension). Supports, modifiers (objects of type "other", as slicers write them), and items that are not
//! to be printed, are left out, with a warning. What changes a solid (beam lattices, slices in place of a mesh, encryption) is refused. Source: 3MF Core Specification 1.3, Production Extension 1.1.
//!
//! Archives are read by `rawzip`, XML by `quick-xml`: both are small, and read text as it is unpacked. The crates for 3MF make an object
//! of every corner, bring cryptography or geometry libraries, or do not know the production extension.

use std::collections::{HashMap, HashSet};

use glam::{DAffine3, DVec3};

use super::contents::{Contents, Format};
use super::model_xml::{Kind, Model, Object, parse, wrong};
use super::package::Package;
use super::polygons::Polygons;
use super::text::shown;
use crate::base::error::Result;
use crate::base::memory::Memory;

/// Objects within objects, at most.
const MAX_DEPTH: u32 = 100;

pub(super) fn read(file: &[u8], n_bytes: u64, memory: &Memory) -> Result<Contents> {
    let package = Package::open(file, memory)?;
    let first = package.first_model()?;
    let mut models = HashMap::new();
    let mut wanted = vec![first.clone()];
    while let Some(name) = wanted.pop() {
        if models.contains_key(&name) {
            continue;
        }
        let model = package.with_text(&name, |text| parse(text, memory))?;
        let others = model.parts().filter(|part| !models.contains_key(*part));
        wanted.extend(others.map(str::to_string).collect::<HashSet<_>>());
        models.insert(name, model);
    }
    let mut reading = Reading { models: &models, polygons: Polygons::within(memory), n_left_out: 0 };
    let model = &models[&first];
    if let Some((name, other)) = models.iter().find(|(_, other)| other.unit != model.unit) {
        return Err(wrong(&format!(
            "{} is in {} and {} in {}",
            shown(&first, 60),
            model.unit,
            shown(name, 60),
            other.unit
        )));
    }
    let mut left_out = Vec::new();
    for item in model.items.iter() {
        let part = item.placed.part.as_deref().unwrap_or(&first);
        let object = reading.object(part, item.placed.object)?;
        if !item.is_printed {
            left_out.push(&object.name);
            continue;
        }
        reading.polygons.new_solid(&object.name)?;
        reading.place(part, item.placed.object, item.placed.by, 0)?;
    }
    let n_objects = reading.n_left_out;
    let mut polygons = reading.polygons;
    if let [name, ..] = left_out[..] {
        let (n, name) = (left_out.len(), shown(name, 60));
        if n == model.items.len() {
            return Err(wrong(&format!("none of its {n} items is to be printed (printable=\"0\")")));
        }
        polygons.warnings.push(format!(
            "{n} of {} items are left out, for they are not to be printed (printable=\"0\"), the first of the object \"{name}\"",
            model.items.len()
        ));
    }
    if n_objects > 0 {
        polygons.warnings.push(format!(
            "{n_objects} supports and modifiers (objects of type support, solidsupport or other) are left out"
        ));
    }
    if model.items.is_empty() {
        return Err(wrong("its build has no item: no object is placed"));
    }
    Ok(Contents { unit: Some(model.unit), ..polygons.finish(Format::ThreeMf, n_bytes)? })
}

struct Reading<'a> {
    /// By the names of their files.
    models: &'a HashMap<String, Model>,
    polygons: Polygons,
    n_left_out: u64,
}

impl<'a> Reading<'a> {
    fn object(&self, part: &str, id: u32) -> Result<&'a Object> {
        let object = self.models.get(part).and_then(|model| model.objects.get(&id));
        object.ok_or_else(|| wrong(&format!("{} has no object {id}", shown(part, 60))))
    }

    /// Adds the triangles of an object and of its components.
    fn place(&mut self, part: &str, id: u32, world: DAffine3, depth: u32) -> Result<()> {
        let object = self.object(part, id)?;
        if depth > MAX_DEPTH {
            return Err(wrong(&format!("objects are nested more than {MAX_DEPTH} deep at object {id}")));
        }
        let (n_corners, n_parts) = match &object.kind {
            Kind::Mesh { corners, triangles } => (corners.len(), triangles.len()),
            Kind::Components(components) => (0, components.len()),
        };
        self.polygons.count_copied(1 + n_corners + n_parts)?;
        if object.is_left_out {
            self.n_left_out += 1;
            return Ok(());
        }
        match &object.kind {
            Kind::Components(components) => components.iter().try_for_each(|component| {
                let part = component.part.as_deref().unwrap_or(part);
                self.place(part, component.object, world * component.by, depth + 1)
            }),
            Kind::Mesh { corners, triangles } => {
                let place = || format!("object {id} of {}", shown(part, 60));
                self.polygons.corners.clear();
                for corner in corners.iter() {
                    let corner = world.transform_point3(DVec3::from(corner.map(f64::from)));
                    self.polygons.corner(corner.to_array().map(|number| number as f32), place)?;
                }
                let is_mirrored = world.matrix3.determinant() < 0.0;
                triangles.iter().try_for_each(|&[a, b, c]| {
                    let corners = if is_mirrored { [a, c, b] } else { [a, b, c] };
                    if let Some(index) = corners.iter().find(|&&index| index as usize >= self.polygons.corners.len()) {
                        let n = self.polygons.corners.len();
                        return Err(wrong(&format!("{}: there is no corner {index} of {n}, counted from 0", place())));
                    }
                    self.polygons.polygon(&corners.map(|index| index as usize), place)
                })
            }
        }
    }
}
