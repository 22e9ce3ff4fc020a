//! Cancel and progress, handed down to the stages that take long.

use std::future::Future;
use std::pin::{Pin, pin};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::task::{Context, Poll, Waker};

use crate::base::error::{Error, Result};
use crate::base::memory::Memory;

/// Asks a running mesh to stop; clones share the request.
#[derive(Debug, Clone, Default)]
pub struct CancelToken(Arc<AtomicBool>);

impl CancelToken {
    /// Asks to stop.
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether the mesh was asked to stop.
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// How far a mesh has come.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct Progress {
    /// Rays whose columns are done.
    pub rays_done: u64,
    /// Rays of the whole box.
    pub n_rays: u64,
}

/// What [`Control::pause`] waits for. Natively an executor may move it, and the mesh that waits, to another thread.
#[cfg(not(target_arch = "wasm32"))]
pub type Waiting = Pin<Box<dyn Future<Output = ()> + Send>>;
/// What [`Control::pause`] waits for; promises of JavaScript stay on their thread.
#[cfg(target_arch = "wasm32")]
pub type Waiting = Pin<Box<dyn Future<Output = ()>>>;

/// Holes of an open surface, of which cells are about to be decided.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct HoleWork {
    /// Triangles that close the holes.
    pub triangles: u64,
    /// Cells that are looked at one by one, at most: those of a ball of whose surface the triangles are half.
    pub cells: u64,
}

impl HoleWork {
    /// So many triangles and cells.
    pub fn new(triangles: u64, cells: u64) -> HoleWork {
        HoleWork { triangles, cells }
    }
}

/// Returns what [`Control::pause`] waits for.
type Pause = Arc<dyn Fn() -> Waiting + Send + Sync>;

/// What a caller hands down to follow and stop a mesh.
#[derive(Clone, Default)]
#[non_exhaustive]
pub struct Control {
    /// Stops the mesh at the next band with `cancelled`.
    pub cancel: CancelToken,
    /// What files that are read, and what is made of them, may take of the memory.
    pub memory: Memory,
    on_progress: Option<Arc<dyn Fn(Progress) + Send + Sync>>,
    on_holes: Option<Arc<dyn Fn(HoleWork) + Send + Sync>>,
    on_share: Option<Arc<dyn Fn(f64) + Send + Sync>>,
    pause: Option<Pause>,
}

impl Control {
    /// Follows a mesh with a function called after every band, from the thread that meshes.
    pub fn with_progress(on_progress: impl Fn(Progress) + Send + Sync + 'static) -> Control {
        Control { on_progress: Some(Arc::new(on_progress)), ..Control::default() }
    }

    /// Says what work begins with the holes of each open surface.
    pub fn on_holes(mut self, on_holes: impl Fn(HoleWork) + Send + Sync + 'static) -> Control {
        self.on_holes = Some(Arc::new(on_holes));
        self
    }

    /// Says what share of the work is done, 0 to 1, where that is a surface's: of a check of its edges, or a preview.
    pub fn on_share(mut self, on_share: impl Fn(f64) + Send + Sync + 'static) -> Control {
        self.on_share = Some(Arc::new(on_share));
        self
    }

    /// The same for one of several pieces of work, whose share is one of that of all.
    #[doc(hidden)]
    pub fn of_piece(&self, index: usize, n_pieces: usize) -> Control {
        let all = self.clone();
        self.clone().on_share(move |share| all.share((index as f64 + share) / n_pieces as f64))
    }

    /// Reports the share of the work that is done.
    fn share(&self, share: f64) {
        if let Some(on_share) = &self.on_share {
            on_share(share);
        }
    }

    /// Rests where this share of the work is done, which it reports.
    ///
    /// # Errors
    /// `cancelled`.
    pub(crate) async fn rest_at(&self, share: f64) -> Result<()> {
        self.share(share);
        self.rest().await
    }

    /// Reports work with holes that begins.
    pub(crate) fn begin_holes(&self, work: HoleWork) {
        if let Some(on_holes) = &self.on_holes {
            on_holes(work);
        }
    }

    /// Returns `cancelled` if the mesh was asked to stop.
    ///
    /// # Errors
    /// `cancelled`.
    pub fn check(&self) -> Result<()> {
        if self.cancel.is_cancelled() { Err(Error::Cancelled) } else { Ok(()) }
    }

    /// Yields between two rounds of work: in a browser's worker, messages such as the one that cancels arrive only while
    /// nothing runs.
    pub fn pausing(mut self, pause: impl Fn() -> Waiting + Send + Sync + 'static) -> Control {
        self.pause = Some(Arc::new(pause));
        self
    }

    /// Yields, if [`Control::pausing`] said how.
    pub async fn pause(&self) {
        if let Some(pause) = &self.pause {
            pause().await;
        }
    }

    /// Yields, and returns `cancelled` if the mesh was asked to stop.
    ///
    /// # Errors
    /// `cancelled`.
    pub async fn rest(&self) -> Result<()> {
        self.pause().await;
        self.check()
    }

    /// The same without pauses, for work that is done at once.
    #[doc(hidden)]
    pub fn without_pauses(&self) -> Control {
        Control { pause: None, ..self.clone() }
    }

    /// The same without reports of progress, for what is meshed besides.
    #[doc(hidden)]
    pub fn without_progress(&self) -> Control {
        Control { on_progress: None, on_holes: None, on_share: None, ..self.clone() }
    }

    /// Reports progress.
    pub fn advance(&self, rays_done: u64, n_rays: u64) {
        if let Some(on_progress) = &self.on_progress {
            on_progress(Progress { rays_done, n_rays });
        }
    }
}

/// Rests once in so many pieces of work.
#[doc(hidden)]
pub struct Paced<'a> {
    control: &'a Control,
    every: usize,
    n_done: usize,
}

impl Paced<'_> {
    pub fn new(control: &Control, every: usize) -> Paced<'_> {
        Paced { control, every, n_done: 0 }
    }

    /// Counts pieces that are done.
    ///
    /// # Errors
    /// `cancelled`.
    pub async fn done(&mut self, n: usize) -> Result<()> {
        self.n_done += n;
        if self.n_done >= self.every {
            self.n_done = 0;
            self.control.rest().await?;
        }
        Ok(())
    }
}

/// Does work at once that waits for nothing but pauses, with a control that has none.
#[doc(hidden)]
pub fn at_once<T>(work: impl Future<Output = T>) -> T {
    let mut work = pin!(work);
    loop {
        if let Poll::Ready(done) = work.as_mut().poll(&mut Context::from_waker(Waker::noop())) {
            return done;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clones_share_the_request() {
        let control = Control::default();
        let token = control.cancel.clone();
        assert_eq!(control.check(), Ok(()));
        token.cancel();
        assert_eq!(control.check(), Err(Error::Cancelled));
    }
}
