//! Work that writes a file from its first byte to its last, and pauses from time to time. It resumes when its bytes are taken:
//! so the reader sets the pace, and memory holds only the bytes of a slab.

use std::future::Future;

use wasm_bindgen::prelude::*;

use super::values::JsResult;
use super::work::WebWork;
use hexcast_core::base::control::Control;
use hexcast_core::base::error::Result;
use hexcast_files::write::archive::Buffer;

/// A file while it is made.
pub(super) struct Resting {
    /// None at the end.
    work: Option<WebWork>,
    made: Buffer,
    /// Rests that it had, and those of its pass over all cells before the first byte, if there is one.
    n_rests: [usize; 2],
}

impl Resting {
    /// Work that writes to the buffer and rests by the control that it is given.
    pub(super) fn new<F: Future<Output = Result<()>> + 'static>(
        n_rests: usize,
        work: impl FnOnce(Buffer, Control) -> F + 'static,
    ) -> Resting {
        let made = Buffer::default();
        let out = made.clone();
        let work = WebWork::new(|control| async move { work(out, control).await.map(|()| JsValue::UNDEFINED) });
        Resting { work: Some(work), made, n_rests: [0, n_rests] }
    }

    /// The bytes up to the next rest, possibly none; None at the end.
    pub(super) fn step(&mut self) -> JsResult<Option<Vec<u8>>> {
        let Some(work) = &mut self.work else { return Ok(None) };
        self.n_rests[0] += 1;
        let step = work.step();
        if step != Ok(true) {
            self.work = None;
        }
        step?;
        Ok(Some(self.made.take()))
    }

    /// Share of the pass over all cells before the first byte, 0 to 1.
    pub(super) fn share(&self) -> f64 {
        match self.n_rests {
            [_, 0] => 1.0,
            [done, all] => (done as f64 / all as f64).min(1.0),
        }
    }
}
