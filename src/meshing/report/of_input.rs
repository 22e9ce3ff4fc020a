//! What the report says of a file.

use serde::Serialize;

use hexcast_core::input::sources::Source;

/// One input: a file, or facets that were in memory.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct InputReport {
    /// Its name as the job has it.
    pub file: String,
    /// SHA-256 of its bytes; null for facets that were in memory.
    pub sha256: Option<String>,
    /// Its length.
    pub bytes: u64,
    /// How it was written.
    pub format: &'static str,
    /// The unit of its coordinates; null where it does not say.
    pub unit: Option<&'static str>,
    /// Number of facets.
    pub facets: u64,
    /// Facets whose file normal points against their corners; the corners count.
    pub wrong_normals: u64,
    /// Facets without area.
    pub zero_area: u64,
    /// What was accepted although it is not as it should be.
    pub warnings: Vec<String>,
}

impl InputReport {
    /// Describes a file.
    pub fn new(source: &Source) -> InputReport {
        let contents = &source.contents;
        InputReport {
            file: source.file.clone(),
            sha256: source.sha256.clone(),
            bytes: contents.n_bytes,
            format: contents.format.name(),
            unit: contents.unit,
            facets: contents.n_facets,
            wrong_normals: contents.wrong_normals,
            zero_area: contents.zero_area,
            warnings: contents.warnings.clone(),
        }
    }
}
