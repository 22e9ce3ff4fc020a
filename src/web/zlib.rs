//! zlib in the browser: functions of JavaScript, which has them from a wasm of their own.

use std::io;

use wasm_bindgen::prelude::*;

use crate::write::zlib::{Zlib, lend};

#[wasm_bindgen]
extern "C" {
    /// zlib as `www/zlib.js` loads it: its functions throw a sentence.
    pub type WebZlib;

    #[wasm_bindgen(method, catch, js_name = deflate)]
    fn try_deflate(this: &WebZlib, bytes: &[u8], level: u8) -> Result<Vec<u8>, JsValue>;

    #[wasm_bindgen(method, catch, js_name = inflate)]
    fn try_inflate(this: &WebZlib, stream: &[u8], most: f64) -> Result<Vec<u8>, JsValue>;
}

/// Lends zlib to all that writes and reads compressed files from now on.
#[wasm_bindgen(js_name = lendZlib)]
pub fn lend_zlib(zlib: WebZlib) {
    lend(zlib);
}

impl Zlib for WebZlib {
    fn deflate(&self, bytes: &[u8], level: u8) -> io::Result<Vec<u8>> {
        self.try_deflate(bytes, level).map_err(failed)
    }

    fn inflate(&self, stream: &[u8], most: u64) -> io::Result<Vec<u8>> {
        self.try_inflate(stream, most as f64).map_err(failed)
    }
}

fn failed(error: JsValue) -> io::Error {
    io::Error::other(error.as_string().unwrap_or_else(|| "zlib failed inside".into()))
}
