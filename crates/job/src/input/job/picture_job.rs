//! Pictures that a job file asks for, also from a command-line argument such as `part.png:axis=x/z,at=25%`. Natively only.

use std::collections::BTreeMap;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use super::Several;
use super::settings::{for_each, joined, name_and_settings, yes_or_no};
use crate::base::error::{Error, Result};

/// Slices of the mesh as a picture: each place along each axis, side by side.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(any(test, feature = "testing"), derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields, expecting = "a table such as { axis = \"z\", output = \"slice.png\" }")]
#[non_exhaustive]
pub struct SliceJob {
    /// File, `.png`.
    pub output: String,
    /// Axes across the slices, "x", "y" or "z"; by default all three.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub axis: Option<Several<String>>,
    /// Places along each axis, in the unit of the mesh, or in percent of its length such as "25%"; by default the middle.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at: Option<Several<PlaceJob>>,
    /// Whether lines between cells are drawn, where cells have 6 pixels or more; by default they are.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lines: Option<bool>,
    /// Pixels of the longest side of the mesh, 1 to 32,768; by default 600.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub size: Option<u32>,
    /// Flags that are shown, all by default; cells of others are white.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flags: Option<Vec<u8>>,
    /// Colours of flags, such as { 1 = "d98324" }.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub colours: BTreeMap<String, String>,
}

/// The stair-step surface of the mesh as a picture.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(any(test, feature = "testing"), derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields, expecting = "a table such as { direction = [30, 20], output = \"view.png\" }")]
#[non_exhaustive]
pub struct ViewJob {
    /// File, `.png`.
    pub output: String,
    /// Direction to the eye in degrees: around z from the x axis, and up; by default -60 and 25.
    #[serde(deserialize_with = "super::numbers::list", skip_serializing_if = "Option::is_none")]
    pub direction: Option<[f64; 2]>,
    /// Cells that are shown, the first on each axis and the end, exclusive; by default all.
    #[serde(deserialize_with = "super::numbers::list", skip_serializing_if = "Option::is_none")]
    pub window: Option<[u32; 6]>,
    /// Pixels of the longer side, 1 to 32,768; by default 1000.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub size: Option<u32>,
    /// Flags that are shown, all by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flags: Option<Vec<u8>>,
    /// Colours of flags, as for slices.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub colours: BTreeMap<String, String>,
}

/// A place along an axis: a coordinate, or a text such as "25%".
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(any(test, feature = "testing"), derive(schemars::JsonSchema))]
#[serde(untagged, expecting = "a coordinate, or a text such as \"25%\", is needed")]
pub enum PlaceJob {
    /// In the unit of the mesh.
    #[serde(deserialize_with = "super::numbers::finite")]
    Coordinate(f64),
    /// A coordinate, or in percent of the length of the mesh.
    Text(String),
}

impl FromStr for SliceJob {
    type Err = Error;

    /// Reads `OUT.png` or `OUT.png:key=value,...`, where several values are joined by `/`; or the JSON of a job file.
    ///
    /// # Errors
    /// `job-value` for an unknown key or a value of a wrong kind; `job-conflict` where a key is given twice.
    fn from_str(argument: &str) -> Result<SliceJob> {
        let example = "write OUT.png:axis=x/z,at=25%,size=400";
        of_argument(argument, example, |slice: &mut SliceJob, key, value| {
            let texts = || value.split('/').map(|text| text.trim().to_string());
            match key {
                "output" => slice.output = value.into(),
                "axis" => slice.axis = Some(Several(texts().collect())),
                "at" => slice.at = Some(Several(texts().map(PlaceJob::Text).collect())),
                "lines" => slice.lines = Some(yes_or_no(key, value)?),
                "size" => slice.size = Some(whole(key, value)?),
                "flags" => slice.flags = Some(flags(value)?),
                "colours" => slice.colours = colours(value)?,
                _ => return Err(no_key(key, "axis, at, lines, size, flags, colours")),
            }
            Ok(())
        })
    }
}

impl FromStr for ViewJob {
    type Err = Error;

    /// Reads `OUT.png` or `OUT.png:key=value,...`, where several values are joined by `/`; or the JSON of a job file.
    ///
    /// # Errors
    /// `job-value` for an unknown key or a value of a wrong kind; `job-conflict` where a key is given twice.
    fn from_str(argument: &str) -> Result<ViewJob> {
        let example = "write OUT.png:direction=30/20,size=400";
        of_argument(argument, example, |view: &mut ViewJob, key, value| {
            match key {
                "output" => view.output = value.into(),
                "direction" => view.direction = Some(joined((key, value), "30/20")?),
                "window" => view.window = Some(joined((key, value), "0/0/0/64/64/32")?),
                "size" => view.size = Some(whole(key, value)?),
                "flags" => view.flags = Some(flags(value)?),
                "colours" => view.colours = colours(value)?,
                _ => return Err(no_key(key, "direction, window, size, flags, colours")),
            }
            Ok(())
        })
    }
}

/// Reads an argument: the name of the output is the key `output`, for what follows it `set` is called.
fn of_argument<T: Default + for<'a> Deserialize<'a>>(
    argument: &str,
    example: &str,
    mut set: impl FnMut(&mut T, &str, &str) -> std::result::Result<(), String>,
) -> Result<T> {
    let (output, settings) = name_and_settings(argument).map_or((argument, None), |(of, rest)| (of, Some(rest)));
    // a job file's, as the command hands it on
    if argument.starts_with('{') && argument.ends_with('}') {
        return serde_json::from_str(argument).map_err(|error| Error::new("job-value", error.to_string(), example));
    }
    let mut picture = T::default();
    // any text is a name
    let _ = set(&mut picture, "output", output);
    if let Some(settings) = settings {
        for_each(settings, (output, example), |key, value| match key {
            "output" => Err("output is the name before the colon".into()),
            _ => set(&mut picture, key, value),
        })?;
    }
    Ok(picture)
}

fn no_key(key: &str, keys: &str) -> String {
    format!("there is no key \"{key}\"; keys are {keys}")
}

fn whole(key: &str, value: &str) -> std::result::Result<u32, String> {
    value.parse().map_err(|_| format!("{key}={value} is not a whole number"))
}

fn flags(value: &str) -> std::result::Result<Vec<u8>, String> {
    let flags = value.split('/').map(|flag| flag.trim().parse().ok()).collect::<Option<Vec<u8>>>();
    flags.ok_or_else(|| format!("flags={value}: numbers from 0 to 255 joined by / are needed, as in 1/3"))
}

fn colours(value: &str) -> std::result::Result<BTreeMap<String, String>, String> {
    let pair = |text: &str| text.split_once('=').map(|(flag, rgb)| (flag.trim().to_string(), rgb.trim().to_string()));
    let pairs = value.split('/').map(pair).collect::<Option<BTreeMap<String, String>>>();
    pairs.ok_or_else(|| format!("colours={value}: FLAG=RRGGBB joined by / are needed, as in 1=d98324/2=4a7fb0"))
}
