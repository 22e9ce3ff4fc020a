//! The ZIP archive of a 3MF: its files by name, and which of them is the model.

use std::collections::HashMap;
use std::io::{BufRead, BufReader, Read};

use flate2::bufread::DeflateDecoder;
use quick_xml::events::Event;
use rawzip::{CompressionMethod, ZipArchive, ZipArchiveEntryWayfinder, ZipSliceArchive};

use super::model_xml::{attribute, key, wrong};
use super::text::shown;
use super::xml_events::Events;
use crate::base::error::{Error, Result};
use crate::base::memory::{Held, Memory};

/// Most bytes that a file of the archive may have unpacked.
const MAX_UNPACKED: u64 = 16 << 30;
/// Bytes of a file in the table of an archive, which doubles as it grows.
const ENTRY_BYTES: u64 = 3 * (size_of::<(String, ZipArchiveEntryWayfinder, CompressionMethod)>() as u64 + 8);
/// What names the model among the relations of the archive.
const MODEL: &str = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel";

pub(super) struct Package<'a> {
    archive: ZipSliceArchive<&'a [u8]>,
    /// By [`key`].
    entries: HashMap<String, (ZipArchiveEntryWayfinder, CompressionMethod)>,
    _room: Held,
    memory: Memory,
}

impl<'a> Package<'a> {
    pub(super) fn open(file: &'a [u8], memory: &Memory) -> Result<Package<'a>> {
        let damaged =
            |error: rawzip::Error| wrong(&format!("the ZIP archive is damaged: {}", shown(&error.to_string(), 150)));
        let archive = ZipArchive::from_slice(file).map_err(damaged)?;
        let mut entries = HashMap::new();
        let mut room = Held::of(memory);
        let mut listed = archive.entries();
        while let Some(entry) = listed.next_entry().map_err(damaged)? {
            let name = String::from_utf8_lossy(entry.file_path().as_ref()).to_ascii_lowercase();
            room.grow(2 * name.len() as u64 + ENTRY_BYTES, "the files of its archive")?;
            entries.insert(name, (entry.wayfinder(), entry.compression_method()));
        }
        Ok(Package { archive, entries, _room: room, memory: memory.clone() })
    }

    /// The [`key`] of the model where the relations of the archive say so, and else the usual one.
    pub(super) fn first_model(&self) -> Result<String> {
        let related = if self.entries.contains_key("_rels/.rels") {
            self.with_text("_rels/.rels", |text| model_of(text, &self.memory))?
        } else {
            None
        };
        let name = key(&related.unwrap_or_else(|| "3D/3dmodel.model".into()));
        if self.entries.contains_key(&name) {
            return Ok(name);
        }
        let message = format!("this is a ZIP archive of {} files without a 3MF model", self.entries.len());
        Err(Error::new("stl-not-stl", message, "unpack it and give the files in it"))
    }

    /// Unpacks a file, named by its [`key`], while `read` reads it.
    pub(super) fn with_text<T>(&self, name: &str, read: impl FnOnce(&mut dyn BufRead) -> Result<T>) -> Result<T> {
        let shown_name = shown(name, 60);
        let damaged = |error: &dyn std::fmt::Display| {
            wrong(&format!("{shown_name} is damaged: {}", shown(&error.to_string(), 150)))
        };
        let (wayfinder, method) =
            self.entries.get(name).ok_or_else(|| wrong(&format!("it has no file {shown_name}")))?;
        let entry = self.archive.get_entry(*wayfinder).map_err(|error| damaged(&error))?;
        let data = entry.data();
        let unpacked: Box<dyn Read> = match *method {
            CompressionMethod::STORE => Box::new(data),
            CompressionMethod::DEFLATE => Box::new(DeflateDecoder::new(data)),
            method => {
                return Err(wrong(&format!(
                    "{shown_name} is packed by method {}, and only deflate can be read",
                    method.as_u16()
                )));
            }
        };
        let mut text = BufReader::with_capacity(1 << 16, entry.verifying_reader(unpacked).take(MAX_UNPACKED));
        let found = read(&mut text).map_err(|error| error.at(&shown_name))?;
        // the sum at the end of the file is compared once all of it was read
        std::io::copy(&mut text, &mut std::io::sink()).map_err(|error| damaged(&error))?;
        Ok(found)
    }
}

/// The target of the relation that names the model.
fn model_of(text: &mut dyn BufRead, memory: &Memory) -> Result<Option<String>> {
    let mut reader = Events::new(text, memory);
    let mut found = None;
    loop {
        match reader.next()?.0 {
            Event::Eof => return Ok(found),
            Event::Start(tag) | Event::Empty(tag)
                if tag.local_name().as_ref() == b"Relationship"
                    && attribute(&tag, "Type")?.as_deref() == Some(MODEL) =>
            {
                found = found.or(attribute(&tag, "Target")?);
            }
            _ => {}
        }
    }
}
