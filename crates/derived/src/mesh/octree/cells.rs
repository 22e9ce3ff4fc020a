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
    /// Adds a row: runs in any order, which may meet, cut to so many cells.
    pub(super) fn add(&mut self, found: &mut [[u32; 2]], nx: u32) {
        let first = self.runs.len();
        found.sort_unstable();
        for &mut [start, end] in found {
            let end = end.min(nx);
            match self.runs[first..].last_mut() {
                Some(last) if start <= last[1] => last[1] = last[1].max(end),
                _ => self.runs.push([start, end]),
            }
        }
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
        let mut rows = [&[][..]; 16];
        let mut n = 0;
        for plane in around(z, self.dims[2]) {
            for row in around(y, self.dims[1]) {
                rows[n] = self.row([row, plane]);
                n += 1;
            }
        }
        if !add_hulls(&rows[..n], found) {
            found.extend(rows[..n].iter().copied().flatten().map(|run| parents(*run)));
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

/// Adds the parents of runs where all rows have as many of them, and the first of all, longer by a cell at both ends, meet, and so the second, and so on; false, and nothing, where not.
fn add_hulls(rows: &[&[[u32; 2]]], found: &mut Vec<[u32; 2]>) -> bool {
    let n_runs = rows[0].len();
    if rows.iter().any(|runs| runs.len() != n_runs) {
        return false;
    }
    let n_found = found.len();
    for at in 0..n_runs {
        let [mut low, mut high] = [rows[0][at]; 2];
        for runs in &rows[1..] {
            let [start, end] = runs[at];
            low = [low[0].min(start), low[1].min(end)];
            high = [high[0].max(start), high[1].max(end)];
        }
        if high[0] > low[1] + 2 {
            found.truncate(n_found);
            return false;
        }
        found.push(parents([low[0], high[1]]));
    }
    true
}
