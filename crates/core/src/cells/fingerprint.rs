//! The flags hash: one number for all flags of a mesh, from its runs, whatever axis they run along.
//!
//! # Theory
//! With b_i the flag of cell i = x + nx (y + ny z), the bytes of a `.raw` file, F is the sum of b_i r^i modulo the prime
//! p = 2^127 - 1. Two different meshes have the same F with a probability of less than cells / 2^127, as the difference is a polynomial
//! of that degree and r is as good as random. A run of cells from s to e along an axis of stride d is a geometric series: its
//! sum of r^(d k) is T(e) - T(s) with T(n) the sum of the first n powers, from a table. So a run costs two lookups.
//!
//! r is the first 16 bytes of the SHA-256 of "hexcast flags 1", little endian, modulo p. The hash is "hx1-" and the first 16 bytes, in
//! hexadecimal, of the SHA-256 of: "hexcast flags 1"; nx, ny and nz as 4 bytes each and F as 16, little endian. `docs/flags_hash.md` has
//! it as a program. It tells meshes apart; it does not prove who made them, as r is known.
//!
//! F is a sum over cells, so that windows of a box add up to it: each has the sum over its cells, with i counted in the whole box.
//!
//! Cost: some 10 ns a run; 16 bytes for every cell along an axis.

use sha2::{Digest, Sha256};

use crate::base::checksum::hex;
use crate::base::error::{Error, Result};
use crate::base::parallel::*;
use crate::cells::columns::{Columns, run_cell, run_flag};

/// 2^127 - 1.
const P: u128 = (1 << 127) - 1;
/// Rays that one core takes at a time.
const CHUNK: u64 = 1 << 16;
const NAME: &str = "hexcast flags 1";

/// Hashes the flags of all cells.
///
/// # Errors
/// `io` where the columns are in a store that fails.
pub fn flags_hash(columns: &Columns) -> Result<String> {
    let dims = columns.dims();
    Ok(hash_of_sum(sum(columns, base(), [0; 3], dims)?, dims))
}

/// What cells of a larger box, the first of which is `first`, add to its F; as text.
///
/// # Errors
/// Those of [`flags_hash`].
pub fn flags_sum(columns: &Columns, first: [u32; 3], whole: [u32; 3]) -> Result<String> {
    Ok(format!("{:032x}", sum(columns, base(), first, whole)?))
}

/// The hash of a box from the sums of its windows; None where one is no such sum.
pub fn hash_of_sums<'a>(sums: impl Iterator<Item = &'a str>, dims: [u32; 3]) -> Option<String> {
    let of_text = |text: &str| u128::from_str_radix(text, 16).ok().filter(|sum| *sum < P);
    let sum = sums.map(of_text).try_fold(0, |sum, next| Some(reduced(sum + next?)))?;
    Some(hash_of_sum(sum, dims))
}

/// r.
fn base() -> u128 {
    let digest = Sha256::digest(NAME);
    reduced(u128::from_le_bytes(std::array::from_fn(|index| digest[index])))
}

fn hash_of_sum(sum: u128, dims: [u32; 3]) -> String {
    let mut hash = Sha256::new();
    hash.update(NAME);
    dims.iter().for_each(|n| hash.update(n.to_le_bytes()));
    hash.update(sum.to_le_bytes());
    format!("hx1-{}", hex(&hash.finalize()[..16]))
}

/// F, for this r, of cells of a larger box, which are counted in that.
fn sum(columns: &Columns, r: u128, first: [u32; 3], whole: [u32; 3]) -> Result<u128> {
    let rays = &columns.rays;
    let strides = [1, u64::from(whole[0]), u64::from(whole[0]) * u64::from(whole[1])];
    let offset = (0..3).map(|axis| u64::from(first[axis]) * strides[axis]).sum();
    let along = sums_of_powers(power(r, strides[rays.axis]), rays.depth);
    let [across, down] = [0, 1].map(|k| powers(power(r, strides[rays.across[k]]), rays.counts[k]));
    let (n_across, n_rays) = (u64::from(rays.counts[0]), rays.n_rays());
    let of_chunk = |chunk: u64| -> Result<u128> {
        let (mut ray, mut sum) = (chunk * CHUNK, 0);
        // of the rays of a row
        let (mut row, mut of_row) = (ray / n_across, 0);
        columns.for_rays(ray..n_rays.min(ray + CHUNK), |runs| {
            if ray / n_across != row {
                sum = reduced(sum + product(of_row, down[row as usize]));
                (row, of_row) = (ray / n_across, 0);
            }
            if !runs.is_empty() {
                let at = across[(ray % n_across) as usize];
                of_row = reduced(of_row + product(of_runs(runs, &along), at));
            }
            ray += 1;
        })?;
        Ok(reduced(sum + product(of_row, down[row as usize])))
    };
    let chunks: Vec<Result<u128>> = (0..n_rays.div_ceil(CHUNK)).into_par_iter().map(of_chunk).collect();
    let sum = chunks.into_iter().try_fold(0, |sum, chunk: Result<u128>| Ok::<u128, Error>(reduced(sum + chunk?)))?;
    Ok(product(sum, power(r, offset)))
}

/// The sum of flag times power over the cells of a ray; `along` has the sums of powers.
fn of_runs(runs: &[u32], along: &[u128]) -> u128 {
    // halves of 64 bits times flags: neither can overflow, and nothing is divided before the end
    let (mut low, mut high) = (0, 0);
    for (index, &run) in runs.iter().enumerate() {
        let flag = u128::from(run_flag(run));
        if flag != 0 {
            let end = runs.get(index + 1).map_or(along.len() - 1, |&next| run_cell(next) as usize);
            let powers = along[end] + (P - along[run_cell(run) as usize]);
            low += u128::from(powers as u64) * flag;
            high += (powers >> 64) * flag;
        }
    }
    reduced(reduced(low) + product(reduced(high), 1 << 64))
}

/// The powers 0 to n - 1.
fn powers(base: u128, n: u32) -> Vec<u128> {
    std::iter::successors(Some(1), |&last| Some(product(last, base))).take(n as usize).collect()
}

/// The sums of the first 0 to n powers.
fn sums_of_powers(base: u128, n: u32) -> Vec<u128> {
    let mut sums = vec![0];
    let mut sum = 0;
    for power in powers(base, n) {
        sum = reduced(sum + power);
        sums.push(sum);
    }
    sums
}

fn power(base: u128, mut exponent: u64) -> u128 {
    let (mut square, mut result) = (base, 1);
    while exponent > 0 {
        if exponent & 1 == 1 {
            result = product(result, square);
        }
        square = product(square, square);
        exponent >>= 1;
    }
    result
}

/// A number below 2^128 modulo p.
fn reduced(value: u128) -> u128 {
    let folded = (value & P) + (value >> 127);
    if folded >= P { folded - P } else { folded }
}

/// Product of two numbers below p, modulo p: 2^128 is 2.
fn product(one: u128, other: u128) -> u128 {
    let low = |value: u128| value & u128::from(u64::MAX);
    let (mid, carry) = (low(one) * (other >> 64)).overflowing_add((one >> 64) * low(other));
    let (bottom, over) = (low(one) * low(other)).overflowing_add(mid << 64);
    let top = (one >> 64) * (other >> 64) + (mid >> 64) + (u128::from(carry) << 64) + u128::from(over);
    // the top is below 2^126
    reduced((bottom & P) + (bottom >> 127) + (top << 1))
}

#[cfg(test)]
mod tests;
