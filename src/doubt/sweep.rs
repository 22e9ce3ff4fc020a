//! The sweep that turns runs into runs across them.

/// Cells that are in the set since the same place.
#[derive(Clone, Copy)]
struct Piece {
    run: [u32; 2],
    since: u32,
}

/// Takes places, ascending, each with a run of cells, of which those of a place ascend and have none in common. Hands out every cell
/// once: cells of runs, and the places, as many as can be, that follow each other and all have them.
pub(super) fn sweep(runs: impl Iterator<Item = (u32, [u32; 2])>, mut found: impl FnMut([u32; 2], [u32; 2])) {
    let mut runs = runs.peekable();
    let (mut pieces, mut next) = (Vec::<Piece>::new(), Vec::new());
    let (mut cuts, mut own) = (Vec::new(), Vec::new());
    let mut end = 0;
    while let Some(&(place, _)) = runs.peek() {
        if place > end {
            pieces.drain(..).for_each(|piece| found(piece.run, [piece.since, end]));
        }
        own.clear();
        while let Some((_, run)) = runs.next_if(|(of, _)| *of == place) {
            own.push(run);
        }
        cuts.clear();
        cuts.extend(pieces.iter().flat_map(|piece| piece.run).chain(own.iter().flatten().copied()));
        cuts.sort_unstable();
        cuts.dedup();
        next.clear();
        let (mut before, mut now) = (0, 0);
        for cut in cuts.windows(2) {
            let run = [cut[0], cut[1]];
            while pieces.get(before).is_some_and(|piece| piece.run[1] <= run[0]) {
                before += 1;
            }
            while own.get(now).is_some_and(|own| own[1] <= run[0]) {
                now += 1;
            }
            let since = pieces.get(before).filter(|piece| piece.run[0] <= run[0]).map(|piece| piece.since);
            let is_own = own.get(now).is_some_and(|own| own[0] <= run[0]);
            match (since, is_own) {
                (Some(since), false) => found(run, [since, place]),
                (since, true) => push(&mut next, Piece { run, since: since.unwrap_or(place) }),
                (None, false) => {}
            }
        }
        std::mem::swap(&mut pieces, &mut next);
        end = place + 1;
    }
    pieces.into_iter().for_each(|piece| found(piece.run, [piece.since, end]));
}

/// Adds a piece to what it continues.
fn push(pieces: &mut Vec<Piece>, piece: Piece) {
    match pieces.last_mut() {
        Some(last) if last.run[1] == piece.run[0] && last.since == piece.since => last.run[1] = piece.run[1],
        _ => pieces.push(piece),
    }
}
