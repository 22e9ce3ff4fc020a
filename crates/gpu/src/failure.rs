//! What a driver has said of a device that failed, and how hexcast hears it where the device is the caller's.
//!
//! A device has one handler of errors and one callback for its loss, and both stay the caller's. hexcast hears of its own errors by error
//! scopes. wgpu has these by thread, so they are open exactly while a future of hexcast's is polled ([`Scoped`]): what the caller does with
//! the device between polls, or in other threads, is told to the caller. Of a loss hexcast hears when a buffer cannot be read.

#[cfg(not(target_arch = "wasm32"))]
use std::cell::RefCell;
#[cfg(not(target_arch = "wasm32"))]
use std::pin::Pin;
use std::sync::{Mutex, MutexGuard, PoisonError};
#[cfg(not(target_arch = "wasm32"))]
use std::task::{Context, Poll};

#[cfg(not(target_arch = "wasm32"))]
use wgpu::{
    BufferDescriptor, BufferUsages, Device, Error as WgpuError, ErrorFilter, ErrorScopeGuard, MapMode, PollType,
};

use hexcast_core::base::error::{Error, Result};

/// The failure that explains all others.
#[derive(Debug, Default)]
pub(crate) struct Failure(Mutex<Option<Error>>);

impl Failure {
    fn lock(&self) -> MutexGuard<'_, Option<Error>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Keeps the first failure, except that a lost device explains all others.
    pub(super) fn note(&self, error: Error) {
        let mut failure = self.lock();
        if failure.is_none() || error.code() == "device-lost" {
            *failure = Some(error);
        }
    }

    /// Forgets a failure of a device that is still there.
    pub(super) fn forget(&self) {
        self.lock().take_if(|failure| failure.code() != "device-lost");
    }

    /// The failure, if there was one.
    pub(super) fn check(&self) -> Result<()> {
        self.lock().clone().map_or(Ok(()), Err)
    }
}

#[cfg(not(target_arch = "wasm32"))]
thread_local! {
    /// Open scopes, those of one device after those of the other.
    static SCOPES: RefCell<Vec<[ErrorScopeGuard; 3]>> = const { RefCell::new(Vec::new()) };
}

/// A future whose errors are told to hexcast, and to nobody else.
#[cfg(not(target_arch = "wasm32"))]
pub(super) struct Scoped<'a, F> {
    device: &'a Device,
    failure: &'a Failure,
    inner: Pin<Box<F>>,
}

#[cfg(not(target_arch = "wasm32"))]
impl<'a, F> Scoped<'a, F> {
    /// Takes what is done with a device.
    pub(super) fn new((device, failure): (&'a Device, &'a Failure), inner: F) -> Scoped<'a, F> {
        Scoped { device, failure, inner: Box::pin(inner) }
    }
}

#[cfg(not(target_arch = "wasm32"))]
impl<F: Future> Future for Scoped<'_, F> {
    type Output = F::Output;

    fn poll(self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<F::Output> {
        let this = self.get_mut();
        open(this.device);
        let _open = Open(this.failure);
        this.inner.as_mut().poll(context)
    }
}

/// Closes scopes, whatever happens within them.
#[cfg(not(target_arch = "wasm32"))]
struct Open<'a>(&'a Failure);

#[cfg(not(target_arch = "wasm32"))]
impl Drop for Open<'_> {
    fn drop(&mut self) {
        close(self.0);
    }
}

#[cfg(not(target_arch = "wasm32"))]
fn open(device: &Device) {
    let filters = [ErrorFilter::Validation, ErrorFilter::OutOfMemory, ErrorFilter::Internal];
    let scopes = filters.map(|filter| device.push_error_scope(filter));
    SCOPES.with_borrow_mut(|all| all.push(scopes));
}

/// Closes the scopes that were opened last, and notes what they heard; false if there are none.
#[cfg(not(target_arch = "wasm32"))]
fn close(failure: &Failure) -> bool {
    let Some([first, second, third]) = SCOPES.with_borrow_mut(Vec::pop) else { return false };
    // natively they are told at once
    let told = [pollster::block_on(third.pop()), pollster::block_on(second.pop()), pollster::block_on(first.pop())];
    for error in told.into_iter().flatten() {
        let (code, hint) = match error {
            WgpuError::OutOfMemory { .. } => ("memory", "take fewer or larger cells, or mesh it in windows"),
            _ => ("device-failed", "use another device, or the CPU backend"),
        };
        failure.note(Error::new(code, format!("the device refused what hexcast asked for: {error}"), hint));
    }
    true
}

/// Notes what the open scopes have heard until now.
#[cfg(not(target_arch = "wasm32"))]
pub(super) fn listen(device: &Device, failure: &Failure) {
    if close(failure) {
        open(device);
    }
}

/// Whether a device is there: from one that is lost not even an empty buffer can be read, and else nobody tells of the loss.
#[cfg(not(target_arch = "wasm32"))]
pub(super) async fn answers(device: &Device) -> bool {
    let asked = async {
        let usage = BufferUsages::MAP_READ | BufferUsages::COPY_DST;
        let descriptor = BufferDescriptor { label: Some("answer"), size: 4, usage, mapped_at_creation: false };
        let buffer = device.create_buffer(&descriptor);
        let (sender, receiver) = std::sync::mpsc::channel();
        buffer.map_async(MapMode::Read, .., move |mapped| {
            // nobody waits any more where this fails
            let _ = sender.send(mapped.is_ok());
        });
        device.poll(PollType::wait_indefinitely()).is_ok() && receiver.try_recv() == Ok(true)
    };
    Scoped::new((device, &Failure::default()), asked).await
}
