//! Runs what takes long: without the GIL, on a thread of its own, while the calling thread serves Python.
//!
//! Every 50 ms that thread takes the GIL, lets Python handle signals, and tells the caller's function how far the work has come. So Ctrl-C
//! ends the work within moments, and the function runs on the thread that the caller called from, as notebooks and tqdm need it. What
//! the function or a signal handler raises cancels the work and is raised once that has stopped.
//!
//! A process that was forked has none of rayon's threads; there the work gets threads of its own.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, OnceLock, PoisonError};
use std::thread;
use std::time::Duration;

use hexcast::control::{Control, Progress};
use hexcast::{Error, Result};
use pyo3::prelude::*;

use crate::py_error;

/// How often Python gets its turn.
const TURN: Duration = Duration::from_millis(50);

/// What the working thread says to the calling one.
#[derive(Default)]
struct Said {
    progress: Option<Progress>,
    is_done: bool,
}

#[derive(Default)]
struct Board(Mutex<Said>, Condvar);

impl Board {
    fn said(&self) -> MutexGuard<'_, Said> {
        // every change is one assignment
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits for a turn or for the end of the work; returns the progress, if there is news, and whether that is the end.
    fn wait(&self) -> (Option<Progress>, bool) {
        let waited = self.1.wait_timeout_while(self.said(), TURN, |said| !said.is_done);
        let (mut said, _) = waited.unwrap_or_else(PoisonError::into_inner);
        (said.progress.take(), said.is_done)
    }
}

/// Sets the board to done however the work ends.
struct Done<'a>(&'a Board);

impl Drop for Done<'_> {
    fn drop(&mut self) {
        self.0.said().is_done = true;
        self.0.1.notify_all();
    }
}

/// Does some work; `progress` is called with rays done and rays in all.
///
/// # Errors
/// Those of the work as `hexcast.Error`; KeyboardInterrupt, or whatever else a signal handler or `progress` raises.
pub(crate) fn run<T: Send>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Control) -> Result<T> + Send,
) -> PyResult<T> {
    let progress = progress.map(|function| function.clone().unbind());
    let board = Arc::new(Board::default());
    let teller = board.clone();
    let control = Control::with_progress(move |now| teller.said().progress = Some(now));
    py.detach(|| {
        thread::scope(|scope| {
            let working = scope.spawn(|| {
                let _done = Done(&board);
                in_threads(|| work(&control))
            });
            let mut raised = None;
            loop {
                let (news, is_done) = board.wait();
                if raised.is_none()
                    && let Err(error) = serve(progress.as_ref(), news)
                {
                    control.cancel.cancel();
                    raised = Some(error);
                }
                if is_done {
                    break;
                }
            }
            let result = working.join().unwrap_or_else(|_| {
                Err(Error::new("device-failed", "the driver or hexcast crashed", "use backend=\"cpu\", and report it"))
            });
            raised.map_or_else(|| result.map_err(py_error), Err)
        })
    })
}

/// Gives Python its turn.
fn serve(progress: Option<&Py<PyAny>>, news: Option<Progress>) -> PyResult<()> {
    Python::attach(|py| {
        py.check_signals()?;
        if let (Some(progress), Some(news)) = (progress, news) {
            progress.call1(py, (news.rays_done, news.n_rays))?;
        }
        Ok(())
    })
}

/// Runs work on so many threads, or on all there are.
///
/// # Errors
/// `io` where the system starts no threads; those of the work.
pub(crate) fn on_threads<T: Send>(n: Option<usize>, work: impl FnOnce() -> Result<T> + Send) -> Result<T> {
    let Some(n) = n else { return work() };
    let failed = |error| Error::new("io", format!("starting {n} threads: {error}"), "give fewer threads");
    rayon::ThreadPoolBuilder::new().num_threads(n).build().map_err(failed)?.install(work)
}

/// Runs work where there are rayon's threads.
fn in_threads<T: Send>(work: impl FnOnce() -> Result<T> + Send) -> Result<T> {
    static FIRST: OnceLock<u32> = OnceLock::new();
    let process = std::process::id();
    if *FIRST.get_or_init(|| process) == process {
        // loops on all cores begin at once there, and from outside each would wake a thread first
        return rayon::scope(|_| work());
    }
    let failed =
        |error| Error::new("io", format!("starting threads in a forked process: {error}"), "start fewer processes");
    rayon::ThreadPoolBuilder::new().build().map_err(failed)?.install(work)
}
