//! PNG: four kinds of chunks around rows of pixels, deflated by flate2.
//!
//! Rows have no filter: areas of one colour repeat, which deflate sees by itself.
//!
//! Source: W3C, Portable Network Graphics (PNG) Specification (Third Edition), sections 5 and 11.2. The crate `png` brings what
//! it reads and writes besides: some 45 kB of wasm, 20 after gzip.

use std::io::Write;
use std::mem::take;

use flate2::Compression;
use flate2::write::ZlibEncoder;

use hexcast_core::base::checksum::crc32;
use hexcast_core::base::control::Control;
use hexcast_core::base::error::{Error, Result};

const SIGNATURE: [u8; 8] = *b"\x89PNG\r\n\x1a\n";
/// Bits of a channel; red, green and blue; deflate, the only set of filters, rows in order.
const RGB: [u8; 5] = [8, 2, 0, 0, 0];
/// Level of deflate.
const LEVEL: u32 = 6;
/// Bytes of pixels that are compressed between two rests.
const AT_ONCE: usize = 1 << 18;

/// The file of a picture: `3 * width * height` bytes, red, green and blue, row after row from the top.
///
/// # Errors
/// `io` where deflate fails; `cancelled`.
pub(super) async fn png(width: u32, height: u32, rgb: &[u8], control: &Control) -> Result<Vec<u8>> {
    let failed = |error| Error::io("writing a picture", error);
    let mut file = SIGNATURE.to_vec();
    push_chunk(&mut file, b"IHDR", &[&width.to_be_bytes()[..], &height.to_be_bytes(), &RGB].concat());
    let row = 3 * width as usize;
    let mut pixels = ZlibEncoder::new(Vec::new(), Compression::new(LEVEL));
    for rows in rgb.chunks(row * (AT_ONCE / row).max(1)) {
        for row in rows.chunks(row) {
            pixels.write_all(&[0]).map_err(failed)?;
            pixels.write_all(row).map_err(failed)?;
        }
        push_pixels(&mut file, &take(pixels.get_mut()));
        control.rest().await?;
    }
    push_pixels(&mut file, &pixels.finish().map_err(failed)?);
    push_chunk(&mut file, b"IEND", &[]);
    Ok(file)
}

fn push_pixels(file: &mut Vec<u8>, deflated: &[u8]) {
    if !deflated.is_empty() {
        push_chunk(file, b"IDAT", deflated);
    }
}

/// Length, name and content, and the checksum of both.
fn push_chunk(file: &mut Vec<u8>, name: &[u8; 4], content: &[u8]) {
    file.extend((content.len() as u32).to_be_bytes());
    let start = file.len();
    file.extend(name);
    file.extend(content);
    let mut checksum = crc32(&file[start..]);
    checksum.reverse();
    file.extend(checksum);
}
