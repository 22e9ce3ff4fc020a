//! The browser's second wasm: zlib alone, for the one that meshes. `www/zlib.js` is its only caller.
//!
//! Bytes cross as copies; a failure is thrown as a sentence.

use std::io;

use wasm_bindgen::prelude::*;

use crate::write::zlib;

type JsResult<T> = std::result::Result<T, JsValue>;

fn sentence(error: io::Error) -> JsValue {
    error.to_string().into()
}

/// Compresses bytes to one zlib stream; level 1 to 9.
#[wasm_bindgen]
pub fn deflate(bytes: &[u8], level: u8) -> JsResult<Vec<u8>> {
    zlib::deflate(bytes, level).map_err(sentence)
}

/// Expands a zlib stream to at most so many bytes.
#[wasm_bindgen]
pub fn inflate(stream: &[u8], most: f64) -> JsResult<Vec<u8>> {
    zlib::inflate(stream, most as u64).map_err(sentence)
}
