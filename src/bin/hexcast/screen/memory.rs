//! What the system says about memory, and memory that is cheap to touch for the first time.

use hexcast::memory::Memory;
use hexcast::{Error, Result};
use memmap2::{MmapMut, MmapOptions};

/// Most bytes that this process has held; None where the system does not say.
pub(crate) fn peak_bytes() -> Option<u64> {
    kilobytes("/proc/self/status", "VmHWM:")
}

/// Bytes of the program itself, and of a GPU's driver: lavapipe takes 111 MB, most of it the compiler of its kernels, SwiftShader 123.
const PROGRAM_BYTES: u64 = 12_000_000;
const DRIVER_BYTES: u64 = 124_000_000;

/// Bytes that the program and, if it meshes, the driver of a GPU take, whatever they mesh.
pub(crate) fn program_bytes(on_gpu: bool) -> u64 {
    PROGRAM_BYTES + if on_gpu { DRIVER_BYTES } else { 0 }
}

/// The same, or what this process holds now without facets of so many bytes, if that is more.
pub(crate) fn program_bytes_now(on_gpu: bool, facets: u64) -> u64 {
    program_bytes(on_gpu).max(resident_bytes().unwrap_or(0).saturating_sub(facets))
}

/// Bytes that this process holds now; None where the system does not say.
pub(crate) fn resident_bytes() -> Option<u64> {
    kilobytes("/proc/self/status", "VmRSS:")
}

/// Bytes that a process comes to hold without asking after it was looked at: pages of the program that run later, and lists
/// that are too small to be asked for.
const UNASKED_BYTES: u64 = 2_000_000;

/// A limit of memory of which the program has its part, and which counts what this process holds.
pub(crate) fn limit(max_bytes: u64) -> Memory {
    let program_bytes = program_bytes(false);
    let resident = || resident_bytes().map(|bytes| bytes + UNASKED_BYTES);
    Memory::measured(max_bytes, if program_bytes < max_bytes { program_bytes } else { 0 }, resident)
}

/// Value in bytes of a line such as `VmHWM:  1234 kB`.
fn kilobytes(file: &str, key: &str) -> Option<u64> {
    let text = std::fs::read_to_string(file).ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix(key))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|kilobytes| kilobytes << 10)
}

/// Allocates zeroed bytes, in huge pages where the system has them: with small ones the first touch of a page costs more
/// than filling it.
///
/// # Errors
/// `memory` where they do not fit.
pub(crate) fn zeroed(n_bytes: u64) -> Result<MmapMut> {
    if let Some(available) = hexcast::machine::available_bytes()
        && n_bytes > available
    {
        return Err(too_much(n_bytes, &format!("{available} bytes are available")));
    }
    let Ok(length) = usize::try_from(n_bytes) else { return Err(too_much(n_bytes, "they cannot be addressed")) };
    let map = MmapOptions::new().len(length).map_anon().map_err(|error| too_much(n_bytes, &error.to_string()))?;
    // only speed depends on the advice
    #[cfg(target_os = "linux")]
    let _ = map.advise(memmap2::Advice::HugePage);
    Ok(map)
}

fn too_much(n_bytes: u64, why: &str) -> Error {
    let message = format!("all flags in memory take {n_bytes} bytes: {why}");
    Error::new("memory", message, "leave out --flags-in-memory: files are written without it")
}
