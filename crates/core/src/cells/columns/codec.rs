//! Runs as bytes: the content of a piece of a column file, three lists of small numbers.
//!
//! The layout is in [`super::file`].

use std::ops::Range;

use super::run::{Band, run, run_cell, run_flag};

/// The most rays and runs of a piece, unless a single ray has more runs.
pub const PIECE_RAYS: u32 = 1 << 16;
pub(crate) const PIECE_RUNS: u32 = 1 << 18;

/// Encodes the content of a piece, ray by ray.
#[derive(Default)]
pub struct PieceEncoder {
    counts: Vec<u8>,
    cells: Vec<u8>,
    flags: Vec<u8>,
    /// Runs of the ray before.
    before: Vec<u32>,
}

impl PieceEncoder {
    /// Adds the runs of the next ray.
    pub fn push(&mut self, runs: &[u32]) {
        put_varint(&mut self.counts, runs.len() as u32);
        let mut last = 0;
        for (k, &run) in runs.iter().enumerate() {
            let guess = self.before.get(k).map_or(last, |&run| run_cell(run));
            let difference = run_cell(run) as i32 - guess as i32;
            put_varint(&mut self.cells, (difference << 1 ^ difference >> 31) as u32);
            self.flags.push(run_flag(run));
            last = run_cell(run);
        }
        self.before.clear();
        self.before.extend_from_slice(runs);
    }

    /// Number of runs and content of the piece.
    pub(crate) fn finish(mut self) -> (u32, Vec<u8>) {
        let n_runs = self.flags.len() as u32;
        self.counts.append(&mut self.cells);
        self.counts.append(&mut self.flags);
        (n_runs, self.counts)
    }
}

/// Splits consecutive rays into pieces of at most [`PIECE_RAYS`] rays and [`PIECE_RUNS`] runs.
pub struct PieceSplitter {
    pieces: Vec<Range<u64>>,
    start: u64,
    ray: u64,
    runs: u64,
}

impl PieceSplitter {
    pub fn new(first_ray: u64) -> PieceSplitter {
        PieceSplitter { pieces: Vec::new(), start: first_ray, ray: first_ray, runs: 0 }
    }

    /// Takes the next ray.
    pub fn push(&mut self, n_runs: u64) {
        let full = self.ray - self.start == u64::from(PIECE_RAYS) || self.runs + n_runs > u64::from(PIECE_RUNS);
        if full && self.ray > self.start {
            self.pieces.push(self.start..self.ray);
            (self.start, self.runs) = (self.ray, 0);
        }
        self.runs += n_runs;
        self.ray += 1;
    }

    /// The rays of every piece.
    pub fn finish(mut self) -> Vec<Range<u64>> {
        if self.ray > self.start {
            self.pieces.push(self.start..self.ray);
        }
        self.pieces
    }
}

/// Reads the content of a piece of `n_rays` rays of `depth` cells with `n_runs` runs; says what is wrong with it otherwise.
pub fn decode(content: &[u8], n_rays: u32, n_runs: u32, depth: u32) -> Result<Band, String> {
    let n_cells_bytes = content.len().checked_sub(n_runs as usize).ok_or("its content is too short")?;
    let (numbers, flags) = content.split_at(n_cells_bytes);
    // a number takes at least a byte, so that allocations are bounded by the length of the content
    if numbers.len() < n_rays as usize + n_runs as usize {
        return Err("its content is too short".into());
    }
    let mut band = Band { ends: Vec::with_capacity(n_rays as usize), ..Band::default() };
    let mut rest = numbers;
    let mut end = 0u32;
    for ray in 0..n_rays {
        let count = take_varint(&mut rest)?;
        end =
            end.checked_add(count).filter(|&end| end <= n_runs).ok_or_else(|| format!("ray {ray} has {count} runs"))?;
        band.ends.push(end);
    }
    if end != n_runs {
        return Err(format!("its rays have {end} runs, its head says {n_runs}"));
    }
    band.runs = Vec::with_capacity(n_runs as usize);
    let mut before = 0..0;
    for ray in 0..n_rays as usize {
        let start = band.runs.len();
        let runs = &flags[start..band.ends[ray] as usize];
        decode_ray(&mut band.runs, before, runs, &mut rest, depth).map_err(|what| format!("ray {ray}: {what}"))?;
        before = start..band.runs.len();
    }
    if rest.is_empty() { Ok(band) } else { Err(format!("{} bytes too many before the flags", rest.len())) }
}

/// Appends the runs of one ray; `before` is the range of those of the ray before.
fn decode_ray(
    runs: &mut Vec<u32>,
    before: Range<usize>,
    flags: &[u8],
    cells: &mut &[u8],
    depth: u32,
) -> Result<(), String> {
    let mut last: Option<(u32, u8)> = None;
    for (k, &flag) in flags.iter().enumerate() {
        let guess = if k < before.len() { run_cell(runs[before.start + k]) } else { last.map_or(0, |(cell, _)| cell) };
        let coded = take_varint(cells)?;
        let difference = i64::from(coded >> 1) ^ -i64::from(coded & 1);
        let cell = i64::from(guess) + difference;
        if cell < last.map_or(0, |(cell, _)| i64::from(cell) + 1) || cell >= i64::from(depth) {
            return Err(format!("run {k} starts at cell {cell} of {depth}, not after the one before"));
        }
        if flag == last.map_or(0, |(_, flag)| flag) {
            return Err(format!("run {k} repeats flag {flag}"));
        }
        runs.push(run(cell as u32, flag));
        last = Some((cell as u32, flag));
    }
    Ok(())
}

fn put_varint(out: &mut Vec<u8>, mut value: u32) {
    while value >= 0x80 {
        out.push(value as u8 | 0x80);
        value >>= 7;
    }
    out.push(value as u8);
}

fn take_varint(bytes: &mut &[u8]) -> Result<u32, String> {
    let mut value = 0u64;
    for shift in (0..35).step_by(7) {
        let (&byte, rest) = bytes.split_first().ok_or("its numbers end early")?;
        *bytes = rest;
        value |= u64::from(byte & 0x7f) << shift;
        if byte < 0x80 {
            return u32::try_from(value).map_err(|_| format!("the number {value} is too large"));
        }
    }
    Err("a number has more than five bytes".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_are_split_where_a_piece_is_full() {
        let most = u64::from(PIECE_RUNS);
        let no_runs = vec![0; 2 * PIECE_RAYS as usize + 1];
        let tables: [(&[u64], &[u64]); 7] = [
            (&[], &[]),
            (&no_runs, &[0, 65_536, 131_072, 131_073]),
            (&[most], &[0, 1]),
            (&[most / 2, most / 2], &[0, 2]),
            (&[most / 2, most / 2, most / 2, most / 2, 0], &[0, 2, 5]),
            (&[most / 2, most / 2, 1, most - 1, 1], &[0, 2, 4, 5]),
            (&[most / 2 + 1, most / 2, most + 1, 3 * most], &[0, 1, 2, 3, 4]),
        ];
        for (counts, ends) in tables {
            for first in [0, 70_000] {
                let mut splitter = PieceSplitter::new(first);
                counts.iter().for_each(|&n_runs| splitter.push(n_runs));
                let expected: Vec<_> = ends.windows(2).map(|two| first + two[0]..first + two[1]).collect();
                assert_eq!(splitter.finish(), expected);
            }
        }
    }

    #[test]
    fn contents_read_back_and_wrong_ones_are_refused() {
        const DEPTH: u32 = 1 << 24;
        // rays of as many runs, and first cells as far from those of the ray before, as one and two bytes hold
        let starts = [0u32, 63, 127, 64, 0, 8192, 16_384, 8191, DEPTH - 1000, 0];
        let counts = [1u32, 127, 128, 129, 0, 3, 300, 1, 1000, 0];
        let rays: Vec<Vec<u32>> = starts
            .iter()
            .zip(counts)
            .map(|(start, n)| (0..n).map(|k| run(start + k, (k % 2 + 1) as u8)).collect())
            .collect();
        let mut encoder = PieceEncoder::default();
        rays.iter().for_each(|runs| encoder.push(runs));
        let (n_runs, content) = encoder.finish();
        let band = decode(&content, 10, n_runs, DEPTH).unwrap();
        assert_eq!((0..10).map(|ray| band.ray(ray).to_vec()).collect::<Vec<_>>(), rays);
        let last = u64::from(DEPTH) - 1;
        assert_eq!(
            decode(&content, 10, n_runs, DEPTH - 1),
            Err(format!("ray 8: run 999 starts at cell {last} of {last}, not after the one before"))
        );
        for (bytes, n_rays, n_runs, expected) in [
            (&[][..], 0, 1, "its content is too short"),
            (&[0], 2, 0, "its content is too short"),
            (&[1, 0, 7], 1, 2, "its content is too short"),
            (&[0x80, 0x80, 0x80, 0x80, 0x80, 0], 1, 0, "a number has more than five bytes"),
            (&[0xff, 0xff, 0xff, 0xff, 0x10], 1, 0, "the number 4563402751 is too large"),
            (&[0x80], 1, 0, "its numbers end early"),
        ] {
            assert_eq!(decode(bytes, n_rays, n_runs, 9), Err(expected.to_string()), "{bytes:?}");
        }
    }
}
