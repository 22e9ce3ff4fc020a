//! That every number fits its width: what `facet.rs`, `wide.wgsl` and the tiles claim, decided for all inputs, from the text that ships.
//! `docs/widths.md` says which claim is decided by which test.
//!
//! The shaders are read by naga and run by [`interpret`] over numbers that stand for many: ranges, formulas of bits, roundings, and words
//! so small that every input can be tried. Each test has a counterpart in which the claim is made false and has to fail.

use hexcast::gpu::kernel_texts;
use naga::Module;

mod bits;
mod formulas;
mod frames;
mod graded;
mod heights;
mod host;
mod interpret;
mod kernels;
mod quotients;
mod ranges;
mod roundings;
mod small;
mod tiles;
mod wide;

/// A kernel as it ships.
fn kernel(name: &str) -> Module {
    changed(name, &[])
}

/// A kernel with some texts replaced by others.
fn changed(name: &str, changes: &[[&str; 2]]) -> Module {
    let mut text = kernel_texts().into_iter().find(|kernel| kernel.name == name).expect("a kernel").text;
    for [from, to] in changes {
        assert_eq!(text.matches(from).count(), 1, "{name}: {from}");
        text = text.replace(from, to);
    }
    naga::front::wgsl::parse_str(&text).unwrap_or_else(|error| panic!("{name}: {}", error.emit_to_string(&text)))
}
