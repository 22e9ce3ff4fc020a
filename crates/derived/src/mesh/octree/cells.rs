//! Sets of cells as runs along x, row by row.

/// Cells of a level; the runs of a row are sorted and do not touch.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Cells {
    dims: [u32; 3],
    planes: Vec<Plane>,
}

/// Those of a plane across z.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Plane {
    /// Where the runs of each row end; none where there are no runs at all.
    ends: Vec<u32>,
    /// The first cell, and the end.
    runs: Vec<[u32; 2]>,
    n_rows: u32,
}

impl Plane {
    /// Adds a row: runs that are sorted and do not touch, cut to so many cells.
    pub(super) fn add(&mut self, found: &[[u32; 2]], nx: u32) {
        self.runs.extend(found.iter().map(|[start, end]| [*start, nx.min(*end)]));
        self.n_rows += 1;
        if !self.runs.is_empty() {
            // of rows before the first run, too
            self.ends.resize(self.n_rows as usize - 1, 0);
            self.ends.push(self.runs.len() as u32);
        }
    }

    fn row(&self, y: u32) -> &[[u32; 2]] {
        let Some(&end) = self.ends.get(y as usize) else { return &[] };
        let start = y.checked_sub(1).map_or(0, |before| self.ends[before as usize]);
        &self.runs[start as usize..end as usize]
    }

    pub(super) fn n_bytes(&self) -> u64 {
        (size_of_val(&self.ends[..]) + size_of_val(&self.runs[..]) + size_of::<Plane>()) as u64
    }
}

impl Cells {
    pub(super) fn new(dims: [u32; 3], planes: Vec<Plane>) -> Cells {
        Cells { dims, planes }
    }

    pub(super) fn row(&self, [y, z]: [u32; 2]) -> &[[u32; 2]] {
        self.planes[z as usize].row(y)
    }

    /// Adds the runs of a row of the level before: the parents of these cells, and of all that touch them.
    pub(super) fn add_parents(&self, [y, z]: [u32; 2], found: &mut Vec<[u32; 2]>) {
        let around = |at: u32, n: u32| (2 * at).saturating_sub(1)..(2 * at + 3).min(n);
        for plane in around(z, self.dims[2]) {
            for row in around(y, self.dims[1]) {
                let mut at = 0;
                self.row([row, plane]).iter().for_each(|run| unite(found, &mut at, parents(*run)));
            }
        }
    }

    pub(super) fn n_cells(&self) -> u64 {
        let runs = self.planes.iter().flat_map(|plane| &plane.runs);
        runs.map(|[start, end]| u64::from(end - start)).sum()
    }

    pub(super) fn n_bytes(&self) -> u64 {
        self.planes.iter().map(Plane::n_bytes).sum()
    }
}

/// The parents of the cells of a run and of one more at both ends.
fn parents([start, end]: [u32; 2]) -> [u32; 2] {
    [start.saturating_sub(1) / 2, (end + 2) / 2]
}

/// Adds a run to others, which are sorted and do not touch, from one of these on; where that is becomes the place of the run.
pub(super) fn unite(all: &mut Vec<[u32; 2]>, from: &mut usize, [start, end]: [u32; 2]) {
    let at = *from + all[*from..].iter().take_while(|run| run[1] < start).count();
    let n_met = all[at..].iter().take_while(|run| run[0] <= end).count();
    *from = at;
    match n_met {
        0 => all.insert(at, [start, end]),
        _ => {
            all[at] = [start.min(all[at][0]), end.max(all[at + n_met - 1][1])];
            all.drain(at + 1..at + n_met);
        }
    }
}
