//! The options of a file, as JavaScript gives them.

use hexcast_core::set;
use serde::Deserialize;

use super::export::names_of;
use hexcast_core::base::error::{Error, Result};
use hexcast_files::export::Exporter;
use hexcast_files::write::{AxisOrder, Compress, Options};

/// Options as `www/client/formats.js` writes them.
#[derive(Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct WriteOptions {
    /// A zlib level, 0 for none.
    compress: u8,
    pub(super) bits: bool,
    pub(super) ascii: bool,
    pub(super) export_flags: Option<Vec<u8>>,
    axis_order: AxisOrder,
    /// A byte for each flag.
    map: Option<Vec<u8>>,
}

impl WriteOptions {
    /// Reads them from JSON.
    ///
    /// # Errors
    /// `job-value`, which nobody meets: JavaScript checks them first.
    pub(super) fn read(text: &str) -> Result<WriteOptions> {
        serde_json::from_str(text).map_err(|error| Error::new("job-value", format!("options: {error}"), ""))
    }

    pub(super) fn compress(&self) -> Compress {
        if self.compress == 0 { Compress::None } else { Compress::Zlib(self.compress) }
    }

    /// What the writer of a mesh is given, with slabs of so many bytes.
    pub(super) fn of_mesh(&self, slab_bytes: usize) -> Options {
        let options = set!(Options { compress: self.compress(), bits: self.bits, slab_bytes, ..Options::default() });
        let map = self.map.as_deref().and_then(|map| map.try_into().ok());
        set!(Options { axis_order: self.axis_order, map, ..options })
    }

    /// Refuses options that a format would silently ignore. Formats of the mesh look at compression and bits themselves.
    pub(super) fn check(&self, format: &str, exporter: Option<Exporter>) -> Result<()> {
        let is = |fits: fn(Exporter) -> bool| exporter.is_some_and(fits);
        // several files come as an archive, which is compressed
        let compresses: fn(Exporter) -> bool =
            |exporter| exporter.compresses() || exporter.file_names("mesh").len() > 1;
        let is_array = matches!(format, "raw" | "npy" | "npz");
        // what is measured has one form
        let is_of_mesh = exporter.is_none() && !format.contains('.') && format != "links";
        let one_order = "always has the flags, in one order of cells";
        let is_plain = exporter.is_none() && format != "links";
        let known = [
            (is_plain || is(compresses), self.compress > 0, "compress", "cannot be compressed"),
            (is_of_mesh, self.bits, "bits", "has no bit-packed variant"),
            (is(Exporter::has_ascii), self.ascii, "ascii", "is written in one form only"),
            (is(Exporter::has_flags), self.export_flags.is_some(), "exportFlags", "always holds all flags"),
            (is_array, self.axis_order != AxisOrder::Zyx, "axisOrder", one_order),
            (is_array, self.map.is_some(), "map", one_order),
        ];
        let wrong = known.iter().find(|(fits, is_given, ..)| *is_given && !fits);
        wrong.map_or(Ok(()), |(_, _, option, why)| {
            let others = match *option {
                "compress" if format == "links" => "links.npz or links.h5".into(),
                "compress" => names_of(compresses),
                "bits" => "raw or npy".into(),
                "ascii" => names_of(Exporter::has_ascii),
                "exportFlags" => names_of(Exporter::has_flags),
                _ => "raw, npy or npz".into(),
            };
            let message = format!("{option} is given, and .{format} {why}");
            Err(Error::new("job-conflict", message, format!("leave it out, or write {others}")))
        })
    }
}
