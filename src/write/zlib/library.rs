//! zlib by flate2.

use std::io::{self, Read};

use flate2::Compression;
use flate2::bufread::{ZlibDecoder, ZlibEncoder};

/// Compresses bytes to one zlib stream; level 1 to 9.
///
/// # Errors
/// Those of flate2, which has none for bytes in memory.
pub(crate) fn deflate(bytes: &[u8], level: u8) -> io::Result<Vec<u8>> {
    let mut stream = Vec::new();
    ZlibEncoder::new(bytes, Compression::new(level.into())).read_to_end(&mut stream)?;
    Ok(stream)
}

/// Expands a zlib stream to at most `most` bytes; a stream that goes on is cut there.
///
/// # Errors
/// What is no zlib stream, ends early, or does not have the checksum that it says; bytes that follow the stream.
pub(crate) fn inflate(stream: &[u8], most: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let mut decoder = ZlibDecoder::new(stream);
    decoder.by_ref().take(most).read_to_end(&mut bytes)?;
    if (bytes.len() as u64) < most && decoder.total_in() < stream.len() as u64 {
        return Err(io::Error::other("bytes follow its zlib stream"));
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stream_is_expanded_as_far_as_allowed() {
        let bytes: Vec<u8> = (0..200_000u32).map(|i| (i / 700) as u8).collect();
        for level in 1..=9 {
            let stream = deflate(&bytes, level).unwrap();
            assert!(stream.len() < 10_000, "level {level}: {} bytes", stream.len());
            for most in [0, 1, 199_999, 200_000, 200_001, u64::MAX] {
                let n_expected = bytes.len().min(most as usize);
                assert_eq!(inflate(&stream, most).unwrap(), bytes[..n_expected], "level {level}, at most {most}");
            }
        }
    }

    #[test]
    fn what_is_not_one_whole_stream_is_refused() {
        let stream = deflate(b"flags, flags, flags", 6).unwrap();
        let mut damaged = stream.clone();
        damaged[stream.len() - 1] ^= 1;
        let cases = [&stream[..stream.len() - 1], &stream[..7], &[], &damaged, &[&stream[..], b"x"].concat()];
        for (index, case) in cases.into_iter().enumerate() {
            assert!(inflate(case, 100).is_err(), "case {index}");
        }
    }
}
