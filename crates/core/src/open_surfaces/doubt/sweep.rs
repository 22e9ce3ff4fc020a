//! The sweep that turns runs into runs across them.

/// Goes from place to place, ascending, each with runs of cells, and hands out every cell once: cells of runs, and the places, as
/// many as can be, that follow each other and all have them.
#[derive(Default)]
pub(super) struct Sweep {
    pieces: Vec<Piece>,
    /// The place after the last.
    end: u32,
}

/// Cells that are in the set since the same place.
#[derive(Clone, Copy)]
struct Piece {
    run: [u32; 2],
    since: u32,
}

impl Sweep {
    /// Takes all places; the runs of a place ascend and have no cells in common.
    pub(super) fn all(runs: impl Iterator<Item = (u32, [u32; 2])>, mut found: impl FnMut([u32; 2], [u32; 2])) {
        let mut sweep = Sweep::default();
        let mut runs = runs.peekable();
        let mut own = Vec::new();
        while let Some(&(place, _)) = runs.peek() {
            own.clear();
            while let Some((_, run)) = runs.next_if(|(of, _)| *of == place) {
                own.push(run);
            }
            sweep.step(place, &own, &mut found);
        }
        sweep.finish(&mut found);
    }

    /// Takes the next place that has runs; hands out runs and places.
    pub(super) fn step(&mut self, place: u32, own: &[[u32; 2]], found: &mut impl FnMut([u32; 2], [u32; 2])) {
        if place > self.end {
            self.finish(found);
        }
        let mut cuts: Vec<u32> =
            self.pieces.iter().flat_map(|piece| piece.run).chain(own.as_flattened().iter().copied()).collect();
        cuts.sort_unstable();
        cuts.dedup();
        let mut pieces = Vec::with_capacity(cuts.len());
        let (mut before, mut now) = (0, 0);
        for cut in cuts.windows(2) {
            let run = [cut[0], cut[1]];
            while self.pieces.get(before).is_some_and(|piece| piece.run[1] <= run[0]) {
                before += 1;
            }
            while own.get(now).is_some_and(|own| own[1] <= run[0]) {
                now += 1;
            }
            let since = self.pieces.get(before).filter(|piece| piece.run[0] <= run[0]).map(|piece| piece.since);
            let is_own = own.get(now).is_some_and(|own| own[0] <= run[0]);
            match (since, is_own) {
                (Some(since), false) => found(run, [since, place]),
                (since, true) => push(&mut pieces, Piece { run, since: since.unwrap_or(place) }),
                (None, false) => {}
            }
        }
        self.pieces = pieces;
        self.end = place + 1;
    }

    /// Hands out what is left: the next places have none of it.
    pub(super) fn finish(&mut self, found: &mut impl FnMut([u32; 2], [u32; 2])) {
        self.pieces.drain(..).for_each(|piece| found(piece.run, [piece.since, self.end]));
    }
}

/// Adds a piece to what it continues.
fn push(pieces: &mut Vec<Piece>, piece: Piece) {
    match pieces.last_mut() {
        Some(last) if last.run[1] == piece.run[0] && last.since == piece.since => last.run[1] = piece.run[1],
        _ => pieces.push(piece),
    }
}
