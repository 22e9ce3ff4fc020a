//! What JavaScript calls: the only file with `#[wasm_bindgen]`.

use wasm_bindgen::prelude::wasm_bindgen;

/// Returns the version of hexcast, as in `package.json`.
#[wasm_bindgen]
pub fn version() -> String {
    env!("CARGO_PKG_VERSION").to_string()
}
