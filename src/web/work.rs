//! Work that pauses: each step runs to the next pause, and between two steps messages arrive, also one that cancels.

use std::future::{Future, poll_fn};
use std::mem::take;
use std::pin::Pin;
use std::task::{Context, Poll, Waker};

use hexcast_core::base::control::Control;
use hexcast_core::base::error::{Error, Result};

/// Work and, once it is done, what it made.
pub(super) struct Work<T> {
    work: Option<Pin<Box<dyn Future<Output = Result<T>>>>>,
    pub(super) made: Option<T>,
}

impl<T> Work<T> {
    /// Starts work, which rests by the control that it gets.
    pub(super) fn new<F: Future<Output = Result<T>> + 'static>(start: impl FnOnce(Control) -> F) -> Work<T> {
        let control = Control::default().pausing(|| Box::pin(once()));
        Work { work: Some(Box::pin(start(control))), made: None }
    }

    /// Works up to the next rest; false once all is done.
    ///
    /// # Errors
    /// Those of the work, which is over then.
    pub(super) fn step(&mut self) -> Result<bool> {
        let Some(work) = &mut self.work else { return Ok(false) };
        let Poll::Ready(done) = work.as_mut().poll(&mut Context::from_waker(Waker::noop())) else { return Ok(true) };
        self.work = None;
        self.made = Some(done?);
        Ok(false)
    }

    /// What was made.
    ///
    /// # Errors
    /// `cancelled` where the work is not done.
    pub(super) fn finish(self) -> Result<T> {
        self.made.ok_or(Error::Cancelled)
    }
}

/// Waits until it is asked a second time.
async fn once() {
    let mut is_first = true;
    poll_fn(|_| if take(&mut is_first) { Poll::Pending } else { Poll::Ready(()) }).await;
}
