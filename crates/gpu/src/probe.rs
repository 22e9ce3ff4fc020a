//! The probe: tests, once when a device is opened, the operations that all kernels rely on. A device with a wrong answer is
//! refused.
//! Twin: `shaders/probe.wgsl`.

use crate::buffers::Array;
use crate::device::{Opened, USE_CPU};
use crate::kernels::{Kernel, Kernels};
use crate::passes::Passes;
use crate::readback::Staging;
use hexcast_core::base::error::{Error, Result};

/// Most loops of an invocation of any kernel; `LOOPS` in `shaders/probe.wgsl`.
pub const MOST_LOOPS: u32 = 1 << 14;
/// Words of `Answers`, in which vectors are aligned to 16 bytes.
const N_ANSWERS: usize = 2 + 64 + 2 + 256 + 64 + 60;

/// Checks the answers of a device.
///
/// # Errors
/// `device-wrong`: names the adapter, its driver and the check that failed; `device-failed`, `device-lost`.
pub(crate) async fn probe(opened: &Opened, kernels: &Kernels, adapter: &str) -> Result<()> {
    let answers: Array<u32> = Array::storage(opened, "answers", N_ANSWERS as u64);
    let others: [Array<u32>; 7] = std::array::from_fn(|_| Array::storage(opened, "one of eight", 1));
    let mut passes = Passes { opened, kernels, is_software: true, encoder: opened.encoder(), profile: None };
    let mut bindings = vec![answers.all()];
    bindings.extend(others.iter().map(Array::all));
    passes.dispatch(Kernel::Probe, &bindings, [1, 1]);
    let [a, b, c, d, e, f, g] = others.each_ref().map(|buffer| buffer.first(1));
    let parts = [answers.all(), a, b, c, d, e, f, g];
    let [answers, others @ ..] = Staging::default().read(opened, passes.encoder, parts).await?;
    match failed(&answers, &others.concat()) {
        None => Ok(()),
        Some((check, found, expected)) => {
            let message = format!(
                "{adapter} fails a check of what every mesh relies on, {check}: {found:#x} in place of {expected:#x}"
            );
            Err(Error::new("device-wrong", message, USE_CPU))
        }
    }
}

/// The first check that failed, with what was found and what was expected.
fn failed(answers: &[u32], others: &[u32]) -> Option<(&'static str, u32, u32)> {
    let (sum, garbage, loops) = (answers[0], answers[1], &answers[2..66]);
    let (shifts, quotients) = (&answers[68..324], &answers[324..388]);
    let mut checks = vec![("atomic addition", sum, 2080), ("zeroed workgroup memory", garbage, 0)];
    for local in 0..64u32 {
        let state = (0..MOST_LOOPS).fold(local, |state, _| state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
        checks.push(("16384 loops of an invocation, with numbers that wrap around", loops[local as usize], state));
        let bits = 0x80f0_0001 ^ local.wrapping_mul(0x9e37_79b9);
        let by = local % 32;
        let expected = [bits << by, bits >> by, ((bits as i32) >> by) as u32, bits.count_ones()];
        checks.extend((0..4).map(|i| ("shifts and bit counts", shifts[4 * local as usize + i], expected[i])));
        let (found, exact) =
            (quotients[local as usize], f64::from(16_777_213 - 7919 * local) / f64::from(2 * local + 3));
        let error = (f64::from(f32::from_bits(found)) / exact - 1.0).abs();
        // wrong by less than the kernels allow for, with room to spare; also false for NaN
        let is_near = error < 1.0 / f64::from(1 << 19);
        checks.push(("division in f32", found, if is_near { found } else { (exact as f32).to_bits() }));
    }
    checks.extend((1..8).map(|k| ("eight storage buffers", others[k as usize - 1], k)));
    checks.into_iter().find(|(_, found, expected)| found != expected)
}
