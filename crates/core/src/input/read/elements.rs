//! The numbers of a GLB: elements of accessors, from the views of its one buffer.

use glam::DVec3;

use super::gltf_json::{Accessor, Root, missing, wrong};
use super::text::shown;
use crate::base::error::Result;
use crate::base::memory::{List, Memory};

/// What a description says about the bytes, and these.
pub(super) struct Bytes<'a> {
    pub(super) root: &'a Root,
    pub(super) binary: &'a [u8],
    pub(super) memory: &'a Memory,
}

/// A type of numbers by its code, and its size in bytes.
fn size_of(component_type: u32) -> Result<usize> {
    match component_type {
        5120 | 5121 => Ok(1),
        5122 | 5123 => Ok(2),
        5125 | 5126 => Ok(4),
        _ => Err(wrong(&format!("numbers have the type {component_type}, which glTF does not have"))),
    }
}

/// The size of numbers that count from 0.
fn size_of_index(component_type: u32) -> Result<usize> {
    if ![5121, 5123, 5125].contains(&component_type) {
        return Err(wrong(&format!(
            "indices have the type {component_type}, which is none of whole numbers from 0 on"
        )));
    }
    size_of(component_type)
}

/// Reads a number; where it is normalised, integers stand for 0 to 1 or -1 to 1.
fn number(bytes: &[u8], component_type: u32, is_normalized: bool) -> f64 {
    let low = |n: usize| bytes.get(n).copied().unwrap_or_default();
    let word = u32::from_le_bytes([low(0), low(1), low(2), low(3)]);
    let (value, most) = match component_type {
        5120 => (f64::from(low(0) as i8), 127.0),
        5121 => (f64::from(low(0)), 255.0),
        5122 => (f64::from(word as u16 as i16), 32767.0),
        5123 => (f64::from(word as u16), 65535.0),
        5125 => (f64::from(word), f64::from(u32::MAX)),
        _ => return f64::from(f32::from_bits(word)),
    };
    if is_normalized { (value / most).max(-1.0) } else { value }
}

impl<'a> Bytes<'a> {
    /// The corners of an accessor.
    pub(super) fn corners(&self, index: usize) -> Result<List<DVec3>> {
        let accessor = self.accessor(index, "VEC3")?;
        let (kind, size) = (accessor.component_type, size_of(accessor.component_type)?);
        let normalized = accessor.normalized;
        let corner = move |bytes: &[u8]| [0, 1, 2].map(|axis| number(&bytes[axis * size..], kind, normalized)).into();
        self.values(accessor, 3 * size, DVec3::ZERO, corner)
    }

    /// Indices of corners.
    pub(super) fn indices(&self, index: usize) -> Result<List<u32>> {
        let accessor = self.accessor(index, "SCALAR")?;
        let kind = accessor.component_type;
        self.values(accessor, size_of_index(kind)?, 0, |bytes| number(bytes, kind, false) as u32)
    }

    fn accessor(&self, index: usize, kind: &str) -> Result<&'a Accessor> {
        let accessors = &self.root.accessors;
        let accessor = accessors.get(index).ok_or_else(|| missing("accessor", index, accessors.len()))?;
        if accessor.r#type != kind {
            return Err(wrong(&format!("accessor {index} is of {}, not {kind}", shown(&accessor.r#type, 20))));
        }
        Ok(accessor)
    }

    /// Elements of `size` bytes each; those without bytes of their own are `zero` where none replaces them.
    fn values<T: Copy>(
        &self,
        accessor: &Accessor,
        size: usize,
        zero: T,
        value: impl Fn(&[u8]) -> T,
    ) -> Result<List<T>> {
        let n = accessor.count;
        let mut values = List::new(self.memory, "the elements of an accessor");
        let room = |values: &mut List<T>| values.reserve(n as usize);
        match accessor.buffer_view {
            Some(view) => {
                let elements = self.elements(view, accessor.byte_offset, (n, size))?;
                room(&mut values)?;
                for element in elements {
                    values.push(value(element))?;
                }
            }
            // so many that nothing in the file stands for are a mistake
            None if n > self.binary.len() as u64 => {
                return Err(wrong(&format!("an accessor has {n} elements and no bytes")));
            }
            None => {
                room(&mut values)?;
                for _ in 0..n {
                    values.push(zero)?;
                }
            }
        }
        if let Some(sparse) = &accessor.sparse {
            let kind = sparse.indices.component_type.unwrap_or(0);
            let places = (sparse.count, size_of_index(kind)?);
            let places = self.elements(sparse.indices.buffer_view, sparse.indices.byte_offset, places)?;
            let replaced = (sparse.count, size);
            let replaced = self.elements(sparse.values.buffer_view, sparse.values.byte_offset, replaced)?;
            for (place, bytes) in places.zip(replaced) {
                let place = number(place, kind, false) as u64;
                let of = values.get_mut(place as usize);
                *of.ok_or_else(|| wrong(&format!("a sparse accessor replaces element {place} of {n}")))? = value(bytes);
            }
        }
        Ok(values)
    }

    /// The bytes of so many elements of a view, from an offset on.
    fn elements(
        &self,
        view: usize,
        offset: u64,
        (n, size): (u64, usize),
    ) -> Result<impl Iterator<Item = &'a [u8]> + use<'a>> {
        let views = &self.root.buffer_views;
        let of = views.get(view).ok_or_else(|| missing("buffer view", view, views.len()))?;
        if of.buffer != 0 || self.root.buffers.first().is_none_or(|buffer| buffer.uri.is_some()) {
            return Err(wrong(
                "its numbers lie in another file, or as text in the description; export one binary .glb",
            ));
        }
        let stride = of.byte_stride.unwrap_or(size as u64);
        let begin = of.byte_offset.checked_add(offset);
        let end =
            stride.checked_mul(n.saturating_sub(1)).and_then(|last| begin?.checked_add(last)?.checked_add(size as u64));
        let view_end = of.byte_offset.checked_add(of.byte_length);
        let fits = end.is_some_and(|end| {
            view_end.is_some_and(|view_end| end <= view_end && view_end <= self.binary.len() as u64)
        });
        // 252 is the most that glTF allows
        if stride < size as u64 || stride > 252 || n > 0 && !fits {
            let what = format!("buffer view {view} holds fewer than {n} elements of {size} bytes, {stride} apart");
            return Err(wrong(&format!("{what}; its buffer has {} bytes", self.binary.len())));
        }
        let bytes = if n == 0 { &[][..] } else { &self.binary[begin.unwrap_or(0) as usize..end.unwrap_or(0) as usize] };
        Ok(bytes.chunks(stride as usize).map(move |element| &element[..size]))
    }
}
