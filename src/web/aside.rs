//! Columns aside in the browser: a file of JavaScript's as a store.

use std::io;

use wasm_bindgen::prelude::*;

use super::values::{forget, keep, kept};
use crate::columns::Store;

#[wasm_bindgen]
extern "C" {
    /// A file as `www/spill.js` opens it: its methods throw a sentence.
    pub type AsideFile;

    #[wasm_bindgen(method, catch)]
    fn append(this: &AsideFile, bytes: &[u8]) -> Result<f64, JsValue>;

    #[wasm_bindgen(method, catch)]
    fn read(this: &AsideFile, at: f64, bytes: &mut [u8]) -> Result<(), JsValue>;

    #[wasm_bindgen(method, catch)]
    fn truncate(this: &AsideFile, n_bytes: f64) -> Result<(), JsValue>;

    #[wasm_bindgen(method)]
    fn close(this: &AsideFile);
}

/// Such a file, by the number it is kept under; closed, and so removed, with the columns that are in it.
pub(super) struct WebStore(usize);

impl WebStore {
    pub(super) fn new(file: AsideFile) -> WebStore {
        WebStore(keep(file.into()))
    }

    fn call<T>(&self, act: impl FnOnce(&AsideFile) -> Result<T, JsValue>) -> io::Result<T> {
        let file: AsideFile = kept(self.0).unchecked_into();
        act(&file).map_err(|error| io::Error::other(error.as_string().unwrap_or_default()))
    }
}

impl Store for WebStore {
    fn append(&self, bytes: &[u8]) -> io::Result<u64> {
        self.call(|file| file.append(bytes)).map(|at| at as u64)
    }

    fn read(&self, at: u64, bytes: &mut [u8]) -> io::Result<()> {
        self.call(|file| file.read(at as f64, bytes))
    }

    fn truncate(&self, n_bytes: u64) -> io::Result<()> {
        self.call(|file| file.truncate(n_bytes as f64))
    }
}

impl Drop for WebStore {
    fn drop(&mut self) {
        kept(self.0).unchecked_into::<AsideFile>().close();
        forget(self.0);
    }
}
