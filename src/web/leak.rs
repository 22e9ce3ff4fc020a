//! Leaks for JavaScript.

use serde::Deserialize;
use wasm_bindgen::prelude::*;

use super::WebJob;
use super::border::{JsResult, js_error, json};
use super::mesh::WebMesh;
use hexcast_core::base::control::Control;
use hexcast_core::base::error::{Error, Result};
use hexcast_core::input::sources::geometries;
use hexcast_derived::leak::{Answer, Question, leak};

/// Most bytes for the search where the caller does not say.
const DEFAULT_BYTES: u64 = 1 << 30;

/// A question as `www/client/mesh.js` writes it.
#[derive(Deserialize)]
struct Asked {
    from: [f64; 3],
    to: [f64; 3],
    #[serde(default)]
    flags: Vec<u8>,
    max_memory: Option<u64>,
}

impl Asked {
    fn read(text: &str) -> Result<Question> {
        let hint = "give from and to as three numbers each, flags as numbers from 0 to 255, and max_memory in bytes";
        let mut json = serde_json::Deserializer::from_str(text);
        let Asked { from, to, flags, max_memory } = serde_path_to_error::deserialize(&mut json).map_err(|error| {
            Error::new("job-value", format!("{} of the leak: {}", error.path(), error.inner()), hint)
        })?;
        Ok(Question::new(from, to).with_flags(flags).with_max_bytes(max_memory.unwrap_or(DEFAULT_BYTES)))
    }
}

#[wasm_bindgen]
impl WebMesh {
    /// Looks for a path from one point to another. `question` is JSON of `{from, to, flags, max_memory}`; facets are named in
    /// the surfaces of `job`, if it is given. Returns what `hexcast leak --json` prints.
    pub fn leak(&self, question: &str, job: Option<WebJob>) -> JsResult<String> {
        let answer = || {
            let question = Asked::read(question)?;
            let surfaces = job.map(|job| geometries(&job.job, job.sources())).transpose()?;
            let found = leak(&self.mesh, &question, &Control::default())?;
            Answer::new(found, &self.mesh, surfaces.as_deref())
        };
        answer().map(|answer| json(&answer)).map_err(js_error)
    }
}
