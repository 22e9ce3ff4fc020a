//! The end of a column file: where its pieces are, and what all of them hold.

use super::{corrupt, u32_at, u64_at};
use crate::base::checksum::crc32;
use crate::base::error::Result;
use crate::base::parallel::*;
use crate::cells::columns::packed_band::PackedBand;

const END_TAG: [u8; 4] = *b"ENDS";
const END_MAGIC: [u8; 8] = *b"HXC END\n";
/// Bytes after the checksum: the offset of the end, and the magic.
pub const TAIL: usize = 16;

/// What all pieces hold.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Totals {
    pub n_runs: u64,
    pub odd_rays: u64,
    pub(crate) n_crossings: u64,
    /// Cells of every flag that the runs name: those before the first run of a ray are not counted.
    pub cells: Box<[u64; 256]>,
}

impl Totals {
    /// Counts what bands of rays of `depth` cells hold.
    pub(crate) fn of(bands: &[PackedBand], depth: u32) -> Totals {
        let mut totals = Totals { n_runs: 0, odd_rays: 0, n_crossings: 0, cells: Box::new([0; 256]) };
        totals.add(bands, depth);
        totals
    }

    /// Adds what more bands hold. Sums that do not fit 64 bits, as a crafted file may have them, stay at `u64::MAX`.
    pub(crate) fn add(&mut self, bands: &[PackedBand], depth: u32) {
        bands.iter().for_each(|band| self.add_counts(band));
        // some bands at a time: what they return takes 2 kB each
        for bands in bands.chunks(256) {
            let cells: Vec<[u64; 256]> = bands.par_iter().map(|band| band.cells_per_flag(depth)).collect();
            for cells in cells {
                self.cells.iter_mut().zip(cells).for_each(|(sum, cells)| *sum += cells);
            }
        }
    }

    /// Adds what a band holds besides its cells.
    pub(crate) fn add_counts(&mut self, band: &PackedBand) {
        self.n_runs = self.n_runs.saturating_add(band.n_runs());
        self.odd_rays = self.odd_rays.saturating_add(band.odd_rays);
        self.n_crossings = self.n_crossings.saturating_add(band.n_crossings);
    }
}

/// Lays out the end, which starts at byte `at`; `index` has the start and the first ray of each piece.
pub fn encode(index: &[[u64; 2]], totals: &Totals, at: u64) -> Vec<u8> {
    let mut end = END_TAG.to_vec();
    let mut put = |number: u64| end.extend(number.to_le_bytes());
    put(index.len() as u64);
    index.as_flattened().iter().for_each(|&number| put(number));
    [totals.n_runs, totals.odd_rays, totals.n_crossings].into_iter().for_each(put);
    let flags = (1..=255u8).filter(|&flag| totals.cells[usize::from(flag)] > 0);
    end.extend((flags.clone().count() as u32).to_le_bytes());
    for flag in flags {
        end.push(flag);
        end.extend(totals.cells[usize::from(flag)].to_le_bytes());
    }
    end.extend(crc32(&end));
    end.extend(at.to_le_bytes());
    end.extend(END_MAGIC);
    end
}

/// The byte at which the end starts, by the last [`TAIL`] bytes of a file; None where they are not the last of an end.
pub fn start(tail: &[u8; TAIL]) -> Option<u64> {
    (tail[8..] == END_MAGIC).then(|| u64_at(tail, 0))
}

/// Reads an end without its tail, which starts at byte `at`: index and totals.
///
/// # Errors
/// `columns-corrupt` where the checksum is wrong or a number does not fit the length of the end.
pub fn decode(end: &[u8], at: u64) -> Result<(Vec<[u64; 2]>, Totals)> {
    let wrong = |what: &str| corrupt(format!("the end at byte {at}: {what}"));
    let (body, crc) = end.split_last_chunk::<4>().ok_or_else(|| wrong("it is too short"))?;
    if body.len() < 20 || body[..4] != END_TAG || *crc != crc32(body) {
        return Err(wrong("its checksum is wrong"));
    }
    let n_pieces = u64_at(body, 4);
    let (numbers, _) = body[12..].as_chunks::<8>();
    let n_numbers = n_pieces.checked_mul(2).and_then(|n| usize::try_from(n).ok()).filter(|n| *n < numbers.len());
    let n_numbers = n_numbers.ok_or_else(|| wrong("it is too short for the number of pieces"))?;
    let (index, _) = numbers[..n_numbers].as_chunks::<2>();
    let index = index.iter().map(|pair| pair.map(u64::from_le_bytes)).collect();
    let totals = totals(&body[12 + 8 * n_numbers..]).ok_or_else(|| wrong("its length does not fit its totals"))?;
    Ok((index, totals))
}

fn totals(bytes: &[u8]) -> Option<Totals> {
    let (counts, flags) = bytes.split_at_checked(28)?;
    let [n_runs, odd_rays, n_crossings] = [0, 8, 16].map(|at| u64_at(counts, at));
    let (flags, rest) = flags.as_chunks::<9>();
    let mut cells = Box::new([0; 256]);
    flags.iter().for_each(|flag| cells[usize::from(flag[0])] = u64_at(flag, 1));
    let ascend = flags.is_sorted_by(|a, b| a[0] < b[0]) && flags.first().is_none_or(|flag| flag[0] > 0);
    let fits = rest.is_empty() && flags.len() == u32_at(counts, 24) as usize && ascend;
    fits.then_some(Totals { n_runs, odd_rays, n_crossings, cells })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_end_reads_back_and_flags_that_do_not_ascend_are_refused() {
        let mut totals = Totals { n_runs: 7, odd_rays: 1 << 40, n_crossings: 3, cells: Box::new([0; 256]) };
        (totals.cells[2], totals.cells[255]) = (1, 1 << 50);
        let index = vec![[30, 0], [90, 4]];
        let end = encode(&index, &totals, 123);
        let (end, tail) = end.split_at(end.len() - TAIL);
        assert_eq!((u64_at(tail, 0), &tail[8..]), (123, &b"HXC END\n"[..]));
        assert_eq!(decode(end, 123).unwrap(), (index, totals));
        // tag, number of pieces, index, three totals; then how many flags, and nine bytes each
        let flags = 4 + 8 + 2 * 16 + 24;
        let changed = |change: fn(&mut Vec<u8>, usize)| {
            let mut body = end[..end.len() - 4].to_vec();
            change(&mut body, flags);
            body.extend(crc32(&body));
            decode(&body, 123).map(|_| ()).map_err(|error| error.to_string())
        };
        assert_eq!(changed(|_, _| ()), Ok(()));
        let wrong: [fn(&mut Vec<u8>, usize); 6] = [
            |body, flags| body[flags + 4] = 0,
            |body, flags| body[flags + 4] = 255,
            |body, flags| body[flags + 13] = 1,
            |body, flags| body[flags] = 1,
            |body, _| body.push(0),
            |body, flags| body.truncate(flags),
        ];
        for (number, wrong) in wrong.into_iter().enumerate() {
            let sentence = changed(wrong).unwrap_err();
            assert!(
                sentence.contains("the end at byte 123: its length does not fit its totals"),
                "{number}: {sentence}"
            );
        }
        let sentence = changed(|body, _| body[4] = 200).unwrap_err();
        assert!(sentence.contains("too short for the number of pieces"), "{sentence}");
        let sentence = changed(|body, _| body[0] = b'e').unwrap_err();
        assert!(sentence.contains("its checksum is wrong"), "{sentence}");
    }
}
