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
        for plane in around(z, self.dims[2]) {
            for row in around(y, self.dims[1]) {
                let runs = self.row([row, plane]).iter();
                found.extend(runs.map(|[start, end]| [start.saturating_sub(1) / 2, (end + 2) / 2]));
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
