//! JavaScript values that Rust holds, and errors as JavaScript gets them.

use std::cell::RefCell;

use wasm_bindgen::prelude::*;

use super::info;
use hexcast_core::base::error::Error;

pub(super) type JsResult<T> = std::result::Result<T, JsValue>;

/// An error as `www/core/core.js` parses it.
pub(super) fn js_error(error: Error) -> JsValue {
    let message = error.to_string();
    JsValue::from_str(&info::json(&info::ErrorFacts { code: error.code(), message: &message, hint: error.hint() }))
}

thread_local! {
    /// JavaScript values in use, by number: a closure that holds a number can be sent between threads, one that holds such a
    /// value cannot.
    static KEPT: RefCell<Vec<JsValue>> = RefCell::default();
}

pub(super) fn keep(value: JsValue) -> usize {
    KEPT.with_borrow_mut(|all| {
        let id = all.iter().position(JsValue::is_undefined).unwrap_or(all.len());
        all.resize(all.len().max(id + 1), JsValue::UNDEFINED);
        all[id] = value;
        id
    })
}

pub(super) fn forget(id: usize) {
    KEPT.with_borrow_mut(|all| all[id] = JsValue::UNDEFINED);
}

pub(super) fn kept(id: usize) -> JsValue {
    KEPT.with_borrow(|all| all[id].clone())
}
