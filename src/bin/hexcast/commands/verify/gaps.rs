//! Closed gaps: background cells that lie, along x, y or z, in a row of fewer than K between two flagged ones.
//!
//! All axes are looked at before a cell changes. Beyond the mesh there is background without end.

/// In place of a flag: nobody knows.
pub(super) const UNKNOWN: i16 = -1;

/// Gives the cells of gaps a flag. `counts` and `steps` are the number of cells along each axis and how far the next one is; beside cells that
/// nobody knows nobody knows the gaps.
pub(super) fn close(cells: &mut [i16], counts: [usize; 3], steps: [usize; 3], (width, flag): (u32, i16)) {
    let (mut closed, mut unsure) = (vec![false; cells.len()], vec![false; cells.len()]);
    for along in 0..3 {
        let [over, across] = [(along + 1) % 3, (along + 2) % 3];
        let starts =
            (0..counts[over]).flat_map(|i| (0..counts[across]).map(move |j| i * steps[over] + j * steps[across]));
        for start in starts {
            // the flagged cell before the background, if there is one
            let mut before = None;
            for at in 0..counts[along] {
                let cell = cells[start + at * steps[along]];
                if cell == 0 {
                    continue;
                }
                if let Some((last, known)) = before.filter(|&(last, _)| at - last <= width as usize) {
                    let is_known = known && cell != UNKNOWN;
                    let list = if is_known { &mut closed } else { &mut unsure };
                    (last + 1..at).for_each(|at| list[start + at * steps[along]] = true);
                }
                before = Some((at, cell != UNKNOWN));
            }
        }
    }
    for (cell, (is_closed, is_unsure)) in
        cells.iter_mut().zip(closed.into_iter().zip(unsure)).filter(|(cell, _)| **cell == 0)
    {
        *cell = if is_closed {
            flag
        } else if is_unsure {
            UNKNOWN
        } else {
            0
        };
    }
}
