//! The sweep that finds gaps across the rays.
//!
//! A line of neighbouring rays -> the runs of the gaps along this line. After every ray, its background is cut in pieces by the
//! ray at which the background began there. What was background and is no longer is a gap if it began after the first ray,
//! fewer than K rays ago.
//! Cost: O(pieces) a ray, of which there are at most as many as ends of the last K rays.

use crate::leak::passage::{OpenRun, Passage};
use hexcast_core::cells::columns::CellRun;

/// Cells of a ray that are background since the same ray of the line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Piece {
    start: u32,
    end: u32,
    /// None where the background reaches beyond the mesh, or is too wide for a gap already.
    since: Option<u32>,
}

/// Where the background of the current ray began.
pub(super) struct Sweep {
    width: u32,
    pieces: Vec<Piece>,
    next: Vec<Piece>,
}

impl Sweep {
    pub(super) fn new(width: u32) -> Sweep {
        Sweep { width, pieces: Vec::new(), next: Vec::new() }
    }

    /// Finds the gaps along a line of rays.
    pub(super) fn gaps(mut self, background: &Passage, line: impl Iterator<Item = [u32; 2]>) -> Vec<CellRun> {
        let mut found = Vec::new();
        // the rays that may still be in a gap
        let mut rays: Vec<u32> = Vec::new();
        for (index, place) in (0..).zip(line) {
            let ray = background.ray(place);
            let runs = &background.runs[background.runs_of(ray)];
            self.end_pieces(runs, |piece, since| {
                for &ray in &rays[since as usize..] {
                    found.push(CellRun { ray: ray.into(), start: piece.start, end: piece.end });
                }
            });
            self.begin_pieces(runs, index);
            rays.push(ray);
        }
        found
    }

    /// Calls `ended` with what no longer is background, and since when it was.
    fn end_pieces(&self, runs: &[OpenRun], mut ended: impl FnMut(OpenRun, u32)) {
        let mut runs = runs.iter().peekable();
        for piece in &self.pieces {
            let mut start = piece.start;
            while let Some(run) = runs.peek().filter(|run| run.start < piece.end) {
                if let Some(since) = piece.since.filter(|_| start < run.start) {
                    ended(OpenRun { start, end: run.start }, since);
                }
                start = start.max(run.end);
                // a run may reach into the next piece
                if run.end > piece.end {
                    break;
                }
                runs.next();
            }
            if let Some(since) = piece.since.filter(|_| start < piece.end) {
                ended(OpenRun { start, end: piece.end }, since);
            }
        }
    }

    /// Cuts the background of the ray of this index in pieces.
    fn begin_pieces(&mut self, runs: &[OpenRun], index: u32) {
        self.next.clear();
        let new = (index > 0).then_some(index);
        let mut first = 0;
        for run in runs {
            let mut start = run.start;
            while self.pieces.get(first).is_some_and(|piece| piece.end <= start) {
                first += 1;
            }
            for piece in self.pieces[first..].iter().take_while(|piece| piece.start < run.end) {
                push(&mut self.next, Piece { start, end: piece.start.max(start), since: new });
                let from = piece.start.max(start);
                let since = piece.since.filter(|since| index + 1 - since < self.width);
                let end = piece.end.min(run.end);
                push(&mut self.next, Piece { start: from, end, since });
                start = end;
            }
            push(&mut self.next, Piece { start, end: run.end, since: new });
        }
        std::mem::swap(&mut self.pieces, &mut self.next);
    }
}

/// Adds a piece, unless it has no cells, to what it continues.
fn push(pieces: &mut Vec<Piece>, piece: Piece) {
    match pieces.last_mut() {
        _ if piece.start >= piece.end => {}
        Some(before) if before.end == piece.start && before.since == piece.since => before.end = piece.end,
        _ => pieces.push(piece),
    }
}
