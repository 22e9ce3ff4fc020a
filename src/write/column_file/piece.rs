//! Pieces of a column file: some rays as three lists of small numbers.

use std::ops::Range;

use crate::columns::{Band, Columns, run, run_cell, run_flag};

use super::{PIECE_RAYS, PIECE_RUNS};

/// Splits the rays in pieces; the same for any split in bands.
pub(super) fn plan(columns: &Columns) -> Vec<Range<u64>> {
    let mut pieces = Vec::new();
    let (mut start, mut ray, mut runs) = (0, 0, 0);
    for band in columns.bands() {
        let mut last = 0;
        for &end in &band.ends {
            let count = end - last;
            last = end;
            let full = ray - start == u64::from(PIECE_RAYS) || runs + u64::from(count) > u64::from(PIECE_RUNS);
            if full && ray > start {
                pieces.push(start..ray);
                (start, runs) = (ray, 0);
            }
            runs += u64::from(count);
            ray += 1;
        }
    }
    pieces.push(start..ray);
    pieces
}

/// Number of runs and content of a piece.
pub(super) fn encode(columns: &Columns, rays: Range<u64>) -> (u32, Vec<u8>) {
    let (mut counts, mut cells, mut flags) = (Vec::new(), Vec::new(), Vec::new());
    let mut before: &[u32] = &[];
    for ray in rays {
        let runs = columns.ray(ray);
        put_varint(&mut counts, runs.len() as u32);
        let mut last = 0;
        for (k, &run) in runs.iter().enumerate() {
            let guess = before.get(k).map_or(last, |&run| run_cell(run));
            let difference = run_cell(run) as i32 - guess as i32;
            put_varint(&mut cells, (difference << 1 ^ difference >> 31) as u32);
            flags.push(run_flag(run));
            last = run_cell(run);
        }
        before = runs;
    }
    let n_runs = flags.len() as u32;
    counts.append(&mut cells);
    counts.append(&mut flags);
    (n_runs, counts)
}

/// Reads the content of a piece of `n_rays` rays of `depth` cells with `n_runs` runs; says what is wrong with it otherwise.
pub(super) fn decode(content: &[u8], n_rays: u32, n_runs: u32, depth: u32) -> Result<Band, String> {
    let n_cells_bytes = content.len().checked_sub(n_runs as usize).ok_or("its content is too short")?;
    let (numbers, flags) = content.split_at(n_cells_bytes);
    // a byte a number at least, so that nothing is allocated that the content does not pay for
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

/// Appends the runs of one ray; `before` is where those of the ray before stand.
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
            return Err(format!("run {k} starts at cell {cell} of {depth}, not behind the one before"));
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
