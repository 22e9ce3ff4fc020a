//! A file of JavaScript's as a store of columns.

use std::io;

use wasm_bindgen::prelude::*;

use super::border::{forget, keep, kept};
use hexcast_core::cells::columns::{Store, sealed};

#[wasm_bindgen]
extern "C" {
    /// A file as `www/platform/spill.js` opens it, or one of `www/core/column_file.js`, which can only be read. A method throws a sentence.
    pub type JsFile;

    #[wasm_bindgen(method, catch)]
    fn append(this: &JsFile, bytes: &[u8]) -> Result<f64, JsValue>;

    #[wasm_bindgen(method, catch)]
    fn read(this: &JsFile, at: f64, bytes: &mut [u8]) -> Result<(), JsValue>;

    #[wasm_bindgen(method, catch)]
    fn truncate(this: &JsFile, n_bytes: f64) -> Result<(), JsValue>;

    #[wasm_bindgen(method, catch)]
    fn close(this: &JsFile) -> Result<(), JsValue>;
}

/// Such a file, by the number it is kept under; closed, and so removed if it is temporary, with the columns that are in it.
pub(super) struct JsFileStore(usize);

impl JsFileStore {
    pub(super) fn new(file: JsFile) -> JsFileStore {
        JsFileStore(keep(file.into()))
    }

    fn call<T>(&self, act: impl FnOnce(&JsFile) -> Result<T, JsValue>) -> io::Result<T> {
        let file: JsFile = kept(self.0).unchecked_into();
        act(&file).map_err(|error| io::Error::other(error.as_string().unwrap_or_default()))
    }
}

impl sealed::Sealed for JsFileStore {}

impl Store for JsFileStore {
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

impl Drop for JsFileStore {
    fn drop(&mut self) {
        // a file that can only be read has nothing to close
        let _ = self.call(JsFile::close);
        forget(self.0);
    }
}
