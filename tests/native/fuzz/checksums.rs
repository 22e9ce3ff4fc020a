//! Right checksums for a changed column file, so that what is behind them is read.

use std::ops::Range;

use flate2::Crc;

use super::mutate::Random;

/// Bytes of the head of a piece.
const PIECE: usize = 44;

fn u32_at(bytes: &[u8], at: usize) -> Option<usize> {
    let number = bytes.get(at..at + 4)?;
    Some(u32::from_le_bytes(number.try_into().expect("4 bytes")) as usize)
}

fn put_crc(bytes: &mut [u8], of: Range<usize>, at: usize) -> Option<()> {
    let mut crc = Crc::new();
    crc.update(bytes.get(of)?);
    bytes.get_mut(at..at + 4)?.copy_from_slice(&crc.sum().to_le_bytes());
    Some(())
}

fn find(bytes: &[u8], from: usize, tags: &[&[u8; 4]]) -> Option<usize> {
    let windows = bytes.get(from..)?.windows(4);
    windows.zip(from..).find(|(window, _)| tags.iter().any(|tag| *window == *tag)).map(|(_, at)| at)
}

fn put_u32(bytes: &mut [u8], at: usize, number: usize) -> Option<()> {
    bytes.get_mut(at..at + 4)?.copy_from_slice(&(number as u32).to_le_bytes());
    Some(())
}

/// Repairs magic, checksums, the index and the place of the end, as far as they are found; mostly lengths and version, too.
pub(super) fn repair(bytes: &mut [u8], random: &mut Random) -> Option<()> {
    bytes.get_mut(..8)?.copy_from_slice(b"\x89HXC\r\n\x1a\n");
    if u32_at(bytes, 8)? > 2 && random.below(8) > 0 {
        put_u32(bytes, 8, 2)?;
    }
    if let Some(first) = find(bytes, 20, &[b"PIEC", b"BAND", b"ENDS"]).filter(|_| random.below(4) > 0) {
        put_u32(bytes, 12, first - 20)?;
    }
    let start = 16 + u32_at(bytes, 12)?;
    put_crc(bytes, 0..start, start)?;
    let mut starts = Vec::new();
    let mut next = start + 4;
    while let Some(at) = find(bytes, next, &[b"PIEC", b"BAND"]).filter(|at| at + PIECE <= bytes.len()) {
        starts.push(at as u64);
        next = at + PIECE;
        if let Some(end) = find(bytes, next, &[b"PIEC", b"BAND", b"ENDS"]).filter(|_| random.below(4) > 0) {
            put_u32(bytes, at + 16, end - next)?;
            if random.below(4) > 0 && bytes.get(30) == Some(&0) {
                put_u32(bytes, at + 12, end - next)?;
            }
        }
        let stored = next..next.saturating_add(u32_at(bytes, at + 16)?);
        if put_crc(bytes, stored.clone(), at + 20).is_some() {
            next = stored.end;
        }
        put_crc(bytes, at..at + PIECE - 4, at + PIECE - 4)?;
    }
    let end = find(bytes, next, &[b"ENDS"])?;
    let tail = bytes.len().checked_sub(16).filter(|tail| *tail >= end + 4)?;
    if random.below(4) > 0 && end + 12 <= tail {
        put_u32(bytes, end + 4, starts.len())?;
    }
    for (piece, at) in starts.into_iter().enumerate() {
        // where the index has so many
        let entry = end + 12 + 16 * piece;
        if entry + 12 <= tail {
            bytes[entry..entry + 8].copy_from_slice(&at.to_le_bytes());
        }
    }
    put_crc(bytes, end..tail - 4, tail - 4)?;
    bytes[tail..tail + 8].copy_from_slice(&(end as u64).to_le_bytes());
    bytes[tail + 8..].copy_from_slice(b"HXC END\n");
    Some(())
}
