//! What the job says of the cells that no geometry has.

use serde::{Deserialize, Serialize};

use super::Material;

/// Name and substance of the background, flag 0, for outputs that name it.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct BackgroundJob {
    /// Its name; by default `background`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// What it is made of.
    #[serde(skip_serializing_if = "Material::is_empty")]
    pub material: Material,
}
