//! What a job says of a geometry, and of the cells that no geometry has; also as an argument of the command line, such as
//! `coil.stl:flag=7,priority=2,name=copper`.

use std::str::FromStr;

use serde::{Deserialize, Serialize};

use super::quoted::on_one_line;
use super::settings::{for_each, joined, name_and_settings, number, yes_or_no};
use super::{Fill, Material, Open, PerAxis, numbers};
use crate::base::error::{Error, Result};
use crate::input::choices::Sizing;
use crate::input::choices::placing::Placing;

/// A file, the name and flag of its cells, and its transform.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(any(test, feature = "testing"), derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
#[non_exhaustive]
pub struct GeometryJob {
    /// The file as the caller names it.
    pub file: String,
    /// Takes only the solid of this name from an ASCII file of several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub solid: Option<String>,
    /// Makes every solid of the file a geometry of its own, named like the solid, flags counting up.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub split: bool,
    /// With `split` and `flag` every solid has this flag, in place of flags that count up.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub same_flag: bool,
    /// Name in reports and outputs; by default the file's without its extension.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Flag of its cells, 1 to 255; by default 1, 2, ... in the order of the job.
    #[serde(deserialize_with = "numbers::flag", skip_serializing_if = "Option::is_none")]
    pub flag: Option<u8>,
    /// Where geometries overlap, the higher priority wins; of equal ones a geometry that is closed or flat wins over one that is not, else the
    /// later.
    pub priority: i32,
    /// How cells are decided where its surface is not closed, if not as the job says.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub open: Option<Open>,
    /// Which cells along its surface it has as well, if not as the job says.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fill: Option<Fill>,
    /// Only the cells along its surface, and none for being inside; by default the `separating` ones.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub shell: bool,
    /// The cells outside of it instead of those inside: the fluid around a body, or within a wall that fills the rest of the domain.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub invert: bool,
    /// With `graded`: largest size of a cell across it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_size: Option<f64>,
    /// With `graded`: fewest cells across it along every axis, at least 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub min_cells: Option<u32>,
    /// With `graded`: whether it is metal, so that the lines nearest to its edges lie a third of a cell inside and two thirds outside.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub metal: bool,
    /// What it is made of: passed on to every output, and not used otherwise.
    #[serde(skip_serializing_if = "Material::is_empty")]
    pub material: Material,
    /// Scales first: one factor, or one an axis.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scale: Option<PerAxis<f64>>,
    /// Then rotates about x, y and z, in degrees.
    #[serde(deserialize_with = "numbers::list", skip_serializing_if = "Option::is_none")]
    pub rotate: Option<[f64; 3]>,
    /// The point about which it rotates, where it is once scaled; by default the origin.
    #[serde(deserialize_with = "numbers::list", skip_serializing_if = "Option::is_none")]
    pub about: Option<[f64; 3]>,
    /// Then moves, in the unit of the result.
    #[serde(deserialize_with = "numbers::list", skip_serializing_if = "Option::is_none")]
    pub translate: Option<[f64; 3]>,
}

impl GeometryJob {
    /// A file, without settings.
    pub fn new(file: impl Into<String>) -> GeometryJob {
        GeometryJob { file: file.into(), ..GeometryJob::default() }
    }

    /// Forgets how lines are generated around it.
    pub fn clear_sizing(&mut self) {
        (self.max_size, self.min_cells, self.metal) = (None, None, false);
    }

    /// How lines are generated around it.
    #[doc(hidden)]
    pub fn sizing(&self) -> Sizing {
        Sizing { max_size: self.max_size, min_cells: self.min_cells, metal: self.metal }
    }

    /// Places file coordinates in the world.
    #[doc(hidden)]
    pub fn world_from_file(&self) -> Placing {
        let scale = self.scale.map_or([1.0; 3], PerAxis::each);
        let (rotate, mut translate) = (self.rotate.unwrap_or_default(), self.translate.unwrap_or_default());
        if let Some(about) = self.about {
            let turned = Placing::of_numbers([1.0; 3], rotate, [0.0; 3]).place(about);
            (0..3).for_each(|axis| translate[axis] += about[axis] - turned[axis]);
        }
        Placing::of_numbers(scale, rotate, translate)
    }

    /// Reads `FILE` or `FILE:key=value,...` with the keys flag, priority, open, fill, shell, invert, name, solid, split, same_flag, max_size, min_cells,
    /// metal, scale, rotate, about, translate and those of a [`Material`];
    /// three numbers are joined by `/`. The settings begin after the first colon that a word and `=` follow, so other colons
    /// belong to the file, as in `C:\run=3\part.stl`.
    ///
    /// # Errors
    /// - `job-value`: no file, an unknown key or a value that is not a number, with what was expected.
    /// - `job-conflict`: a key given twice.
    pub fn from_argument(argument: &str) -> Result<GeometryJob> {
        let Some((file, settings)) = name_and_settings(argument) else {
            return Ok(GeometryJob::new(argument));
        };
        let what = format!("geometry \"{}\"", on_one_line(argument));
        let hint = "write FILE:flag=7,priority=2,name=copper";
        if file.is_empty() {
            return Err(Error::new("job-value", format!("{what}: there is no file before the colon"), hint));
        }
        let mut geometry = GeometryJob::new(file);
        for_each(settings, (&what, hint), |key, value| geometry.set(key, value))?;
        Ok(geometry)
    }

    fn set(&mut self, key: &str, value: &str) -> std::result::Result<(), String> {
        match key {
            "flag" => self.flag = Some(value.parse().map_err(|_| format!("flag={value}: flags are 1 to 255"))?),
            "priority" => {
                self.priority = value.parse().map_err(|_| format!("priority={value} is not a whole number"))?
            }
            "open" => self.open = Some(named(key, value, "winding, vote, error or parity")?),
            "fill" => self.fill = Some(named(key, value, "centre, conservative or separating")?),
            "shell" => self.shell = yes_or_no(key, value)?,
            "invert" => self.invert = yes_or_no(key, value)?,
            "max_size" => self.max_size = Some(number(key, value)?),
            "min_cells" => {
                self.min_cells = Some(value.parse().map_err(|_| format!("min_cells={value} is not a whole number"))?)
            }
            "metal" => self.metal = yes_or_no(key, value)?,
            "name" => self.name = Some(value.to_string()),
            "solid" => self.solid = Some(value.to_string()),
            "split" => self.split = yes_or_no(key, value)?,
            "same_flag" => self.same_flag = yes_or_no(key, value)?,
            "scale" if !value.contains('/') => self.scale = Some(PerAxis::All(number(key, value)?)),
            "scale" => self.scale = Some(PerAxis::Each(joined((key, value), "0/0/90")?)),
            "rotate" => self.rotate = Some(joined((key, value), "0/0/90")?),
            "about" => self.about = Some(joined((key, value), "0/0/90")?),
            "translate" => self.translate = Some(joined((key, value), "0/0/90")?),
            "pec" => self.material.pec = yes_or_no(key, value)?,
            _ => {
                if let Some(place) = self.material.number_mut(key) {
                    *place = Some(number(key, value)?);
                    return Ok(());
                }
                let keys = "flag, priority, open, fill, shell, invert, name, solid, split, same_flag, max_size, min_cells, metal, scale, rotate, about, translate, eps_r, mu_r, sigma, pec, density, E, nu";
                return Err(format!("there is no key \"{key}\"; keys are {keys}"));
            }
        }
        Ok(())
    }
}

fn named<'a, T: Deserialize<'a>>(key: &str, text: &'a str, names: &str) -> std::result::Result<T, String> {
    let value = serde::de::value::StrDeserializer::<serde::de::value::Error>::new(text);
    T::deserialize(value).map_err(|_| format!("{key}={text}: write {names}"))
}

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
