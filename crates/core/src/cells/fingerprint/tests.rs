#![cfg(not(target_arch = "wasm32"))]

use num_bigint::BigUint;

use super::*;
use crate::cells::columns::{Band, run};
use crate::grid::rays::Rays;

/// Columns along an axis of flags, x fastest.
fn columns(axis: usize, dims: [u32; 3], flags: &[u8]) -> Columns {
    let rays = Rays::new(axis, dims);
    let mut band = Band::default();
    for j in 0..rays.counts[1] {
        for i in 0..rays.counts[0] {
            let mut last = 0;
            for k in 0..rays.depth {
                let mut cell = [k; 3];
                (cell[rays.across[0]], cell[rays.across[1]]) = (i, j);
                let flag = flags[(cell[0] + dims[0] * (cell[1] + dims[1] * cell[2])) as usize];
                if flag != last {
                    band.runs.push(run(k, flag));
                    last = flag;
                }
            }
            band.ends.push(band.runs.len() as u32);
        }
    }
    Columns::new(rays, vec![band]).unwrap()
}

#[test]
fn the_hash_is_that_of_the_bytes_along_every_axis() {
    let p = (BigUint::from(1u8) << 127) - 1u8;
    let r = BigUint::from_bytes_le(&Sha256::digest(NAME)[..16]) % &p;
    let mut state = 7u64;
    let mut backgrounds = std::collections::BTreeSet::new();
    for dims in [[1, 1, 1], [5, 4, 3], [7, 1, 9], [70, 65, 64]] {
        for kind in 0..3usize {
            let mut flag = 0;
            let mut next = || {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                if (state >> 40).is_multiple_of(4) {
                    flag = [0, (state >> 50) as u8 & 1, (state >> 50) as u8][kind];
                }
                flag
            };
            let flags: Vec<u8> = (0..dims.iter().product()).map(|_: u32| next()).collect();
            // from the last byte to the first, after Horner
            let expected = flags.iter().rev().fold(BigUint::from(0u8), |sum, &flag| (sum * &r + flag) % &p);
            let hashes = [0, 1, 2].map(|axis| {
                let columns = columns(axis, dims, &flags);
                let r = u128::try_from(&r).unwrap();
                assert_eq!(BigUint::from(sum(&columns, r, [0; 3], dims).unwrap()), expected, "{dims:?}, axis {axis}");
                flags_hash(&columns).unwrap()
            });
            assert!(hashes.iter().all(|hash| *hash == hashes[0] && hash.len() == 36), "{hashes:?}");
            if kind == 0 {
                backgrounds.insert(hashes[0].clone());
            }
        }
    }
    assert_eq!(backgrounds.len(), 4, "background alone differs by its size");
}

/// Computed by the program in `docs/flags_hash.md`.
#[test]
fn the_hash_of_a_small_mesh_is_fixed() {
    let hash = flags_hash(&columns(1, [3, 2, 2], &[0, 1, 1, 2, 0, 0, 0, 0, 255, 255, 1, 7])).unwrap();
    assert_eq!(hash, "hx1-bca93b4ca5349fb5d1e8ab8080975604");
}

#[test]
fn windows_add_up_to_the_hash_of_the_whole() {
    let dims = [11u32, 9, 7];
    let flags: Vec<u8> = (0..11 * 9 * 7u32).map(|index| [0, 0, 3, 255][(index / 5 * index % 4) as usize]).collect();
    let expected = flags_hash(&columns(2, dims, &flags)).unwrap();
    let ends = [[0, 4, 11], [0, 8, 9], [0, 1, 7]];
    let mut sums = Vec::new();
    for of in 0..8usize {
        let first = [0, 1, 2].map(|axis| ends[axis][of >> axis & 1]);
        let end = [0, 1, 2].map(|axis| ends[axis][(of >> axis & 1) + 1]);
        let cells = (first[2]..end[2])
            .flat_map(|z| (first[1]..end[1]).flat_map(move |y| (first[0]..end[0]).map(move |x| x + 11 * (y + 9 * z))));
        let flags: Vec<u8> = cells.map(|cell| flags[cell as usize]).collect();
        let window = columns(of % 3, [0, 1, 2].map(|axis| end[axis] - first[axis]), &flags);
        sums.push(flags_sum(&window, first, dims).unwrap());
    }
    assert_eq!(hash_of_sums(sums.iter().map(String::as_str), dims), Some(expected.clone()));
    assert_ne!(hash_of_sums(sums[1..].iter().map(String::as_str), dims), Some(expected));
    assert_eq!(hash_of_sums(["no sum"].into_iter(), dims), None);
}
