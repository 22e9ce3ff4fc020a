//! A column file that a page opened, as a store that is only read.

use std::io;

use wasm_bindgen::prelude::*;

use super::values::{forget, keep, kept};
use crate::columns::Store;

#[wasm_bindgen]
extern "C" {
    /// A file as `www/column_file.js` has it: its method throws a sentence.
    pub type ColumnFile;

    #[wasm_bindgen(method, catch)]
    fn read(this: &ColumnFile, at: f64, bytes: &mut [u8]) -> Result<(), JsValue>;
}

/// Such a file, by the number it is kept under.
pub(super) struct FileInPage(usize);

impl FileInPage {
    pub(super) fn new(file: ColumnFile) -> FileInPage {
        FileInPage(keep(file.into()))
    }
}

impl Store for FileInPage {
    fn read(&self, at: u64, bytes: &mut [u8]) -> io::Result<()> {
        let file: ColumnFile = kept(self.0).unchecked_into();
        let failed = |error: JsValue| io::Error::other(error.as_string().unwrap_or_default());
        file.read(at as f64, bytes).map_err(failed)
    }

    fn append(&self, _: &[u8]) -> io::Result<u64> {
        Err(io::ErrorKind::Unsupported.into())
    }

    fn truncate(&self, _: u64) -> io::Result<()> {
        Err(io::ErrorKind::Unsupported.into())
    }
}

impl Drop for FileInPage {
    fn drop(&mut self) {
        forget(self.0);
    }
}
