//! Threads of the page: workers that share the memory of this module.
//!
//! JavaScript starts a worker for each thread, which waits in [`run_thread`]; once all are there, [`start_threads`] hands each its part of rayon's pool.

use std::collections::VecDeque;
use std::sync::{Condvar, Mutex, PoisonError};

use rayon::ThreadBuilder;
use wasm_bindgen::prelude::*;

use hexcast_core::base::parallel::start_pool;

/// Threads of the pool that no worker runs yet.
static WAITING: Mutex<VecDeque<ThreadBuilder>> = Mutex::new(VecDeque::new());
static MORE: Condvar = Condvar::new();

/// Runs a thread of the pool on this worker, for as long as the worker lives; waits for [`start_threads`].
#[wasm_bindgen(js_name = runThread)]
pub fn run_thread() {
    let waiting = WAITING.lock().unwrap_or_else(PoisonError::into_inner);
    let mut waiting = MORE.wait_while(waiting, |threads| threads.is_empty()).unwrap_or_else(PoisonError::into_inner);
    let thread = waiting.pop_front();
    drop(waiting);
    if let Some(thread) = thread {
        thread.run();
    }
}

/// Starts the pool on so many workers, all of which wait; whether it could.
#[wasm_bindgen(js_name = startThreads)]
pub fn start_threads(n_threads: usize) -> bool {
    start_pool(n_threads, |thread| {
        WAITING.lock().unwrap_or_else(PoisonError::into_inner).push_back(thread);
        MORE.notify_one();
    })
}
