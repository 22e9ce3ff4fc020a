//! What an exporter is, as one value, which its file in `formats/` makes.

use std::future::Future;
use std::pin::Pin;

use super::options::ExportOptions;
use super::output::{Export, Files};
use hexcast_core::base::error::Result;
use hexcast_core::grid::lines::Lines;
use hexcast_derived::mesh::{Mesh, Named};

/// Files being written.
pub(super) type Writing<'a> = Pin<Box<dyn Future<Output = Result<()>> + 'a>>;

/// How outputs of a format are named, what it can hold, and how it is written. [`Format::new`] has what most formats share.
pub(super) struct Format {
    /// How the path of an output ends that asks for this format: from a dot on, or its last parts.
    pub(super) endings: &'static [&'static str],
    /// The program that reads it, or its own name.
    pub(super) program: &'static str,
    /// What is in it, for a list of formats: a few words.
    pub(super) about: &'static str,
    /// What is made on disk besides one file of the name that was given; empty where that is all.
    pub(super) on_disk: &'static str,
    /// Whether files are compressed where the caller asks for it.
    pub(super) compresses: bool,
    /// Whether there is a form of text besides the binary one.
    pub(super) has_ascii: bool,
    /// Whether cells are cut at the surface of a fluid, where the mesh has its outline.
    pub(super) cuts: bool,
    /// Whether the mesh must have one, with its parts.
    pub(super) is_boundary: bool,
    /// Whether only some flags can be exported.
    pub(super) has_flags: bool,
    /// Whether files have the faces of geometries without thickness.
    pub(super) has_plates: bool,
    /// Most characters of the name of a face at the boundary, where such faces have names.
    pub(super) longest_name: Option<usize>,
    /// The program whose lengths have a unit of its own, and that unit.
    pub(super) unit: Option<(&'static str, &'static str)>,
    /// The axis across which whole planes of flags are held; None where it holds the file, or little.
    pub(super) held_planes: Option<usize>,
    /// What it holds of a mesh besides planes or slabs, and about the most bytes of that.
    pub(super) held: (&'static str, fn(&Mesh) -> u64),
    /// The files of an output, by the last part of its path.
    pub(super) file_names: fn(&str) -> Vec<String>,
    /// Refuses cells that the format cannot hold.
    pub(super) check_lines: fn(&Lines) -> Result<()>,
    /// Refuses flags to export that the format cannot hold.
    pub(super) check_flags: fn(&[u8]) -> Result<()>,
    /// Refuses what the flags to export are made of.
    pub(super) check_materials: fn(&[Named], &[u8]) -> Result<()>,
    /// Refuses a mesh of which these flags are kept.
    pub(super) check_mesh: fn(&Mesh, &ExportOptions, &[bool; 256]) -> Result<()>,
    /// The bytes of all files, where they do not depend on the flags.
    pub(super) exact_size: fn(&Mesh, &ExportOptions) -> Option<u64>,
    /// Writes the files of an output, by the last part of its path.
    pub(super) write: Write,
}

/// [`Format::write`].
type Write = for<'a> fn(&'a Export<'a>, &'a str, &'a mut dyn Files) -> Writing<'a>;

impl Format {
    /// One file of some flags, of any cells, flags and materials: what a format does not say otherwise.
    pub(super) const fn new(endings: &'static [&'static str], write: Write) -> Format {
        Format {
            endings,
            program: "",
            about: "",
            on_disk: "",
            compresses: false,
            has_ascii: false,
            cuts: false,
            is_boundary: false,
            has_flags: true,
            has_plates: false,
            longest_name: None,
            unit: None,
            held_planes: Some(2),
            held: ("", |_| 0),
            file_names: |name| vec![name.to_string()],
            check_lines: |_| Ok(()),
            check_flags: |_| Ok(()),
            check_materials: |_, _| Ok(()),
            check_mesh: |_, _, _| Ok(()),
            exact_size: |_, _| None,
            write,
        }
    }
}
