//! Work that pauses: each step runs to the next pause, and between two steps messages arrive, also one that cancels.

use std::cell::RefCell;
use std::future::{Future, poll_fn};
use std::mem::take;
use std::pin::Pin;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::task::{Context, Poll, Waker};

use wasm_bindgen::prelude::*;

use super::border::{JsResult, js_error};
use hexcast_core::base::control::Control;
use hexcast_core::base::error::Result;
use hexcast_files::write::archive::Buffer;

/// Work and, once it is done, what it made.
#[wasm_bindgen]
pub struct WebWork {
    work: Option<Pin<Box<dyn Future<Output = Result<JsValue>>>>>,
    made: JsValue,
    /// The bits of the share that is done.
    share: Arc<AtomicU64>,
}

impl WebWork {
    /// Starts work, which rests by the control that it gets.
    pub(super) fn new<F: Future<Output = Result<JsValue>> + 'static>(start: impl FnOnce(Control) -> F) -> WebWork {
        let share = Arc::new(AtomicU64::default());
        let told = share.clone();
        let control = Control::default().pausing(|| Box::pin(once()));
        let control = control.on_share(move |share| told.store(share.to_bits(), Relaxed));
        WebWork { work: Some(Box::pin(start(control))), made: JsValue::UNDEFINED, share }
    }
}

#[wasm_bindgen]
impl WebWork {
    /// Works up to the next rest; false once all is done. After an error it is over.
    pub fn step(&mut self) -> JsResult<bool> {
        let Some(work) = &mut self.work else { return Ok(false) };
        let Poll::Ready(done) = work.as_mut().poll(&mut Context::from_waker(Waker::noop())) else { return Ok(true) };
        self.work = None;
        self.made = done.map_err(js_error)?;
        Ok(false)
    }

    /// Share of the work that is done, 0 to 1, of a check or a preview of a surface; it may begin again.
    pub fn share(&self) -> f64 {
        f64::from_bits(self.share.load(Relaxed))
    }

    /// What was made, once all is done.
    pub fn finish(self) -> JsValue {
        self.made
    }
}

/// Work that writes a file from its first byte to its last, and pauses from time to time. It resumes when its bytes are taken: so the reader
/// sets the pace, and memory holds only the bytes of a slab.
pub(super) struct Resting {
    /// None at the end.
    work: Option<WebWork>,
    made: Buffer,
    /// What the file lacks of the mesh, a sentence each, once it is written.
    lacks: Rc<RefCell<Vec<String>>>,
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
        Resting { work: Some(work), made, lacks: Rc::default(), n_rests: [0, n_rests] }
    }

    /// With what the work says that the file lacks.
    pub(super) fn with_lacks(self, lacks: Rc<RefCell<Vec<String>>>) -> Resting {
        Resting { lacks, ..self }
    }

    /// What the file lacks, once it is written.
    pub(super) fn lacks(&self) -> Vec<String> {
        self.lacks.borrow().clone()
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

/// Waits until it is asked a second time.
async fn once() {
    let mut is_first = true;
    poll_fn(|_| if take(&mut is_first) { Poll::Pending } else { Poll::Ready(()) }).await;
}
