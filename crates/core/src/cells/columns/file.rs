//! The column file, `.hxc`: a mesh as its runs, some bytes a ray instead of one a cell; lossless, and it reads back.
//!
//! It is the one form of columns on disk: columns that exceed the memory spill to an unfinished file, an interrupted mesh
//! continues from one, and once it has its end it is a file like any other.
//!
//! All numbers are little-endian. `u8`, `u32`, `u64` are unsigned integers, `f64` is IEEE 754, a *text* is a u32 number
//! of bytes and that many bytes of UTF-8, a *varint* is LEB128: seven bits a byte, lowest first, the top bit set on all
//! bytes but the last, at most five bytes and below 2^32. `crc32` is that of zlib and PNG.
//!
//! A file is a head, pieces, an end; nothing follows. A file without an end is unfinished; its bands are valid up to the last whole one.
//!
//! **Head.**
//!
//! | bytes | what |
//! |---|---|
//! | 8 | `89 48 58 43 0d 0a 1a 0a` (`.HXC`, CR LF, ctrl-Z, LF) |
//! | u32 | version of the layout: 2; 3 where cells differ in size; 4 where flags have materials or flag 0 has a name. A reader refuses a higher one here |
//! | u32 | number of bytes of the body, at most 2^20, from version 3 on 2^23 |
//! | body | u8 1 and 32 bytes that identify what is meshed, in a file to resume from; or u8 0 |
//! | | 3 u32 `dims`: cells on x, y, z, 1 to 2^24 each, their product below 2^63 |
//! | | u8 `axis` of the rays: 0, 1, 2; u8 compression of pieces: 0 none, 1 zlib; u8 kind of lines: 0 equally spaced, 1 (version 3, 4) listed; u8 zero |
//! | | kind 0: 3 f64 `origin`, 3 f64 `spacing`: line i of an axis is origin + i * spacing |
//! | | kind 1: all lines of x, then y, then z, ascending: cells + 1 f64 each, at most 2^18 - 1 |
//! | | u8 1 and a text: the unit of lengths; or u8 0: none was named |
//! | | u32 number of names; for each a u8 flag (0 in version 4 only) and a text: the name of the flag |
//! | | version 4: for each name a text: the material of the flag as a JSON object, with the keys of a job |
//! | u32 | crc32 of all bytes before |
//!
//! **Pieces.** The rays follow each other by their index `i + n_i * j`, where i and j count cells along the first and the
//! second of the two axes across `axis`, in the order x, y, z. A piece holds 1 to 2^16 whole rays and at most 2^18 runs,
//! or one ray with any number of runs.
//!
//! | bytes | what |
//! |---|---|
//! | 4 | `BAND` if the piece ends a band, else `PIEC` |
//! | u32 | number of rays |
//! | u32 | number of runs |
//! | u32 | number of bytes of the content |
//! | u32 | number of bytes stored: the content, or a zlib stream of it |
//! | u32 | crc32 of the stored bytes |
//! | u64 | odd rays; u64 crossings: of the band that it ends, else 0; the sums over all pieces are those of the mesh |
//! | u32 | crc32 of the 40 bytes before |
//! | ... | the stored bytes |
//!
//! The content is three lists one after the other: a varint a ray, its number of runs; a varint a run, its first cell; a
//! u8 a run, its flag. A run reaches to the cell before the next run of its ray, the last to the end of the ray; cells
//! before the first run have flag 0; cells ascend, and a flag differs from the one before it (0 before the first).
//! The first cell is stored as its difference d from a guess, as 2 d for d >= 0 and -2 d - 1 for d < 0. The guess for
//! run k of a ray is the cell of run k of the ray before, if that ray is in this piece and has such a run; otherwise the
//! cell of run k - 1 of the same ray, or 0 for k = 0.
//!
//! **End.**
//!
//! | bytes | what |
//! |---|---|
//! | 4 | `ENDS` |
//! | u64 | number of pieces; for each a u64, the byte at which it starts, and a u64, the index of its first ray |
//! | u64 | number of runs of all pieces |
//! | u64 | odd rays; u64 crossings of all pieces |
//! | u32 | number of flags in use besides 0; for each, ascending, a u8, the flag, and a u64, its number of cells |
//! | u32 | crc32 of the bytes from `ENDS` on |
//! | u64 | the byte at which `ENDS` starts, so that the index is found from the end of the file |
//! | 8 | `HXC END` and LF |
//!
//! **Version 1** has no u8 of the identity in its head, only `PIEC` in its pieces, and in its end nothing between the number of
//! runs and the crc32. It can still be read; opening it reads all of it once, to count.

use crate::base::error::Error;

pub mod end;
pub mod head;
pub mod piece;

/// The error of a file that does not follow the layout.
pub fn corrupt(message: String) -> Error {
    Error::new("columns-corrupt", message, "copy or write the file again")
}

/// The little-endian u32 at an offset.
fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
}

/// The little-endian u64 at an offset.
fn u64_at(bytes: &[u8], at: usize) -> u64 {
    u64::from(u32_at(bytes, at)) | u64::from(u32_at(bytes, at + 4)) << 32
}
