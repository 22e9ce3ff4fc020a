//! What the job says of the cells that no geometry has.

use std::str::FromStr;

use serde::{Deserialize, Serialize};

use super::Material;
use super::settings::{for_each, number, yes_or_no};
use crate::base::error::{Error, Result};

/// Name and substance of the background, flag 0, for outputs that name it.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(any(test, feature = "testing"), derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
#[non_exhaustive]
pub struct BackgroundJob {
    /// Its name; by default `background`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// What it is made of.
    #[serde(skip_serializing_if = "Material::is_empty")]
    pub material: Material,
}

impl FromStr for BackgroundJob {
    type Err = Error;

    /// Reads an argument such as `name=air,eps_r=1.0006`.
    ///
    /// # Errors
    /// `job-value`: an unknown key, or a value that is not a number; `job-conflict`: a key given twice.
    fn from_str(argument: &str) -> Result<BackgroundJob> {
        let mut background = BackgroundJob::default();
        let example = "write it as name=air,eps_r=1.0006";
        for_each(argument, ("background", example), |key, value| background.set(key, value))?;
        Ok(background)
    }
}

impl BackgroundJob {
    fn set(&mut self, key: &str, value: &str) -> std::result::Result<(), String> {
        match (key, self.material.number_mut(key)) {
            (_, Some(place)) => *place = Some(number(key, value)?),
            ("name", _) => self.name = Some(value.to_string()),
            ("pec", _) => self.material.pec = yes_or_no(key, value)?,
            _ => return Err(format!("there is no key \"{key}\"; keys are name, {}", Material::KEYS.join(", "))),
        }
        Ok(())
    }
}
