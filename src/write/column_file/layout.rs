//! The constants of the layout, and the error of a file that does not keep to it.

use crate::error::Error;

pub(super) const MAGIC: [u8; 8] = *b"\x89HXC\r\n\x1a\n";
pub(super) const VERSION: u32 = 1;
pub(super) const MAX_BODY: usize = 1 << 20;
pub(super) const MAX_DIM: u32 = 1 << 24;
pub(super) const PIECE_TAG: [u8; 4] = *b"PIEC";
pub(super) const PIECE_HEAD: usize = 44;
pub(super) const END_TAG: [u8; 4] = *b"ENDS";
pub(super) const END_MAGIC: [u8; 8] = *b"HXC END\n";

pub(super) fn corrupt(message: String) -> Error {
    Error::new("columns-corrupt", message, "copy or write the file again")
}
