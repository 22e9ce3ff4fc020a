//! Open backends that wait for the next mesh: opening a GPU takes longer than many a mesh.

use std::sync::{Mutex, PoisonError};

use hexcast::Result;
use hexcast::job::BackendChoice;
use hexcast::pipeline::Engine;

/// Most backends that wait.
const MAX_WAITING: usize = 4;
/// Bytes of buffers that one may keep while it waits.
const MAX_POOL_BYTES: u64 = 1 << 30;

/// What a backend was opened for. A device does not survive a fork.
#[derive(Clone, PartialEq)]
struct Key {
    choice: BackendChoice,
    adapter: Option<String>,
    process: u32,
}

static WAITING: Mutex<Vec<(Key, Engine)>> = Mutex::new(Vec::new());

/// Uses a backend, one that waits if there is one.
///
/// # Errors
/// Those of [`Engine::open`] and of `act`.
pub(crate) fn with_engine<T>(
    choice: BackendChoice,
    adapter: Option<&str>,
    act: impl FnOnce(&mut Engine) -> Result<T>,
) -> Result<T> {
    let key = Key { choice, adapter: adapter.map(String::from), process: std::process::id() };
    let waiting = || WAITING.lock().unwrap_or_else(PoisonError::into_inner);
    let found = {
        let mut waiting = waiting();
        waiting.iter().position(|(other, _)| *other == key).map(|index| waiting.swap_remove(index).1)
    };
    let mut engine = match found {
        Some(engine) => engine,
        None => pollster::block_on(Engine::open(choice, adapter))?,
    };
    let before = engine.fallback.clone();
    let result = act(&mut engine);
    // a GPU that was given up is looked for again next time
    if engine.fallback == before && waiting().len() < MAX_WAITING {
        engine.clear_pool_over(MAX_POOL_BYTES);
        // the next mesh does not open it
        engine.seconds = 0.0;
        waiting().push((key, engine));
    }
    result
}
