//! The choices of exporters.

use serde::Deserialize;

use crate::write::Compress;
use hexcast_core::base::error::{Error, Result};
use hexcast_derived::mesh::{Mesh, SLAB_BYTES};

/// By what faces at the boundary of exported cells are named.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum PatchNames {
    /// By the side of the box, else by the flag of the neighbour.
    #[default]
    Side,
    /// By the flag of the neighbour; all sides of the box have one name.
    Neighbour,
    /// By the solid, or else the geometry, whose facet made the face.
    Solid,
}

/// Choices of an exporter; those that do not apply to it are not looked at.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct ExportOptions {
    /// Flags whose cells are exported, where an exporter writes only some: also 0. None means all but 0.
    pub flags: Option<Vec<u8>>,
    /// Text in place of numbers in binary.
    pub ascii: bool,
    /// By what patches and surfaces are named, where [`super::Exporter::has_patches`].
    pub patches: PatchNames,
    /// Solids whose patches a fluid flows through: of type `patch` in OpenFOAM, as the sides of the box; those of others are walls.
    pub open_patches: Vec<String>,
    /// Compression, where [`super::Exporter::compresses`].
    pub compress: Compress,
    /// Flags held at once, twice; at least a row of cells, or a plane where points are numbered.
    pub slab_bytes: usize,
}

impl Default for ExportOptions {
    fn default() -> ExportOptions {
        let (patches, open_patches) = (PatchNames::Side, Vec::new());
        ExportOptions {
            flags: None,
            ascii: false,
            patches,
            open_patches,
            compress: Compress::None,
            slab_bytes: SLAB_BYTES,
        }
    }
}

impl ExportOptions {
    /// Exports the cells of these flags only, also of 0.
    pub fn with_flags(self, flags: Vec<u8>) -> ExportOptions {
        ExportOptions { flags: Some(flags), ..self }
    }

    /// Writes text in place of numbers in binary.
    pub fn with_ascii(self, ascii: bool) -> ExportOptions {
        ExportOptions { ascii, ..self }
    }

    /// Says by what patches and surfaces are named.
    pub fn with_patches(self, patches: PatchNames) -> ExportOptions {
        ExportOptions { patches, ..self }
    }

    /// Names the solids whose patches a fluid flows through.
    pub fn with_open_patches(self, open_patches: Vec<String>) -> ExportOptions {
        ExportOptions { open_patches, ..self }
    }

    /// Compresses, or does not.
    pub fn with_compress(self, compress: Compress) -> ExportOptions {
        ExportOptions { compress, ..self }
    }

    /// Limits the flags that are held at once, twice.
    pub fn with_slab_bytes(self, slab_bytes: usize) -> ExportOptions {
        ExportOptions { slab_bytes, ..self }
    }

    /// Those of some flags whose cells are exported.
    pub(super) fn chosen(&self, flags: impl IntoIterator<Item = u8>) -> Vec<u8> {
        let is_chosen = |flag: &u8| self.flags.as_ref().map_or(*flag > 0, |chosen| chosen.contains(flag));
        flags.into_iter().filter(is_chosen).collect()
    }

    /// Those whose cells are exported.
    pub(super) fn exported(&self, mesh: &Mesh) -> Vec<u8> {
        let cells = mesh.columns().cells_per_flag();
        self.chosen((0..=255).filter(|flag| cells[usize::from(*flag)] > 0))
    }

    /// Whether the cells of each flag are exported, and its faces where plates are.
    ///
    /// # Errors
    /// `job-conflict` where a flag asked for has no cell, or no cell is left.
    pub(super) fn selection(&self, mesh: &Mesh, has_plates: bool) -> Result<[bool; 256]> {
        let mut cells = mesh.columns().cells_per_flag();
        mesh.plates().iter().filter(|_| has_plates).for_each(|plate| cells[usize::from(plate.flag)] += 1);
        let used = || {
            (0..=255u8).filter(|flag| cells[usize::from(*flag)] > 0).map(|flag| flag.to_string()).collect::<Vec<_>>()
        };
        let Some(flags) = &self.flags else {
            if (1..256).all(|flag| cells[flag] == 0) {
                let message =
                    "there is no cell to export: every cell has flag 0, and by default only other flags are exported";
                return Err(Error::new("job-conflict", message, "name the flags to export (--export-flags 0)"));
            }
            return Ok(std::array::from_fn(|flag| flag > 0));
        };
        if let Some(flag) = flags.iter().find(|flag| cells[usize::from(**flag)] == 0) {
            let message =
                format!("flag {flag} is to be exported, and no cell has it; flags in use: {}", used().join(", "));
            return Err(Error::new("job-conflict", message, "name flags that are in use"));
        }
        let mut keeps = [false; 256];
        flags.iter().for_each(|flag| keeps[usize::from(*flag)] = true);
        Ok(keeps)
    }
}
