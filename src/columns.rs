//! Columns: the sorted, labelled runs of every ray. The result of a mesh: small, lossless, random access.
//!
//! A run is one u32, `first cell << 8 | flag`. The runs of a ray are sorted by cell; a run ends where the next begins, the
//! last at the end of the ray; cells before the first run are background; neighbouring runs differ in flag.
//! Cost in memory: 4 bytes a run and 4 bytes a ray.

use crate::rays::Rays;

/// Packs a run.
pub fn run(cell: u32, flag: u8) -> u32 {
    cell << 8 | u32::from(flag)
}

/// First cell of a packed run.
pub fn run_cell(run: u32) -> u32 {
    run >> 8
}

/// Flag of a packed run.
pub fn run_flag(run: u32) -> u8 {
    (run & 0xff) as u8
}

/// Runs of consecutive rays.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Band {
    /// Index of the first ray.
    pub first_ray: u64,
    /// End in `runs` of the runs of each ray; one entry a ray.
    pub ends: Vec<u32>,
    /// Runs, ray after ray.
    pub runs: Vec<u32>,
    /// Rays that do not leave every geometry they enter: the mesh is not closed there.
    pub odd_rays: u64,
    /// Number of crossings of the rays.
    pub n_crossings: u64,
}

impl Band {
    /// Runs of a ray of this band, counted from its first.
    pub fn ray(&self, index: usize) -> &[u32] {
        let start = if index == 0 { 0 } else { self.ends[index - 1] };
        &self.runs[start as usize..self.ends[index] as usize]
    }
}

/// Runs of all rays of the box.
#[derive(Debug, Clone)]
pub struct Columns {
    /// The rays.
    pub rays: Rays,
    bands: Vec<Band>,
}

impl PartialEq for Columns {
    /// Two results are equal if every ray has the same runs, however they are split in bands.
    fn eq(&self, other: &Columns) -> bool {
        self.rays == other.rays && (0..self.rays.n_rays()).all(|ray| self.ray(ray) == other.ray(ray))
    }
}

impl Columns {
    /// Joins bands, in order of their rays, to the columns of a box.
    ///
    /// # Panics
    /// If the bands do not cover every ray once, in order: a bug of the caller.
    pub fn new(rays: Rays, bands: Vec<Band>) -> Columns {
        let mut next = 0;
        for band in &bands {
            assert_eq!(band.first_ray, next, "bands must follow each other");
            next += band.ends.len() as u64;
        }
        assert_eq!(next, rays.n_rays(), "bands must cover all rays");
        Columns { rays, bands }
    }

    /// Number of cells on x, y and z.
    pub fn dims(&self) -> [u32; 3] {
        let mut dims = [self.rays.depth; 3];
        dims[self.rays.across[0]] = self.rays.counts[0];
        dims[self.rays.across[1]] = self.rays.counts[1];
        dims
    }

    /// The bands, in order of their rays.
    pub fn bands(&self) -> &[Band] {
        &self.bands
    }

    /// Runs of a ray by its index `i + n_i * j` over the axes across.
    pub fn ray(&self, ray: u64) -> &[u32] {
        let band = &self.bands[self.bands.partition_point(|band| band.first_ray <= ray) - 1];
        band.ray((ray - band.first_ray) as usize)
    }

    /// Runs of consecutive rays from one on; cheaper than asking for each.
    pub fn rays_from(&self, ray: u64) -> impl Iterator<Item = &[u32]> {
        let first = self.bands.partition_point(|band| band.first_ray + band.ends.len() as u64 <= ray);
        self.bands[first..].iter().flat_map(move |band| {
            let skipped = ray.saturating_sub(band.first_ray) as usize;
            (skipped..band.ends.len()).map(|index| band.ray(index))
        })
    }

    /// Flag of the cell (x, y, z), each below [`Columns::dims`].
    pub fn flag(&self, cell: [u32; 3]) -> u8 {
        let [i, j] = self.rays.across.map(|axis| u64::from(cell[axis]));
        flag_at(self.ray(i + u64::from(self.rays.counts[0]) * j), cell[self.rays.axis])
    }

    /// Number of runs of all rays.
    pub fn n_runs(&self) -> u64 {
        self.bands.iter().map(|band| band.runs.len() as u64).sum()
    }

    /// Number of crossings that the rays had.
    pub fn n_crossings(&self) -> u64 {
        self.bands.iter().map(|band| band.n_crossings).sum()
    }

    /// Rays that do not leave every geometry they enter.
    pub fn odd_rays(&self) -> u64 {
        self.bands.iter().map(|band| band.odd_rays).sum()
    }

    /// Bytes held in memory.
    pub fn n_bytes(&self) -> u64 {
        self.bands.iter().map(|band| 4 * (band.runs.capacity() + band.ends.capacity()) as u64).sum()
    }

    /// Number of cells of every flag, 0 to 255.
    pub fn cells_per_flag(&self) -> [u64; 256] {
        use crate::parallel::*;
        let add = |mut a: [u64; 256], b: [u64; 256]| {
            a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
            a
        };
        let of_bands = self.bands.par_iter().map(|band| self.cells_of_band(band)).collect::<Vec<_>>();
        let mut cells = of_bands.into_iter().fold([0u64; 256], add);
        let flagged: u64 = cells.iter().sum();
        cells[0] += self.rays.n_rays() * u64::from(self.rays.depth) - flagged;
        cells
    }

    /// Cells of every flag that runs of the band name; cells before the first run of a ray are not counted.
    fn cells_of_band(&self, band: &Band) -> [u64; 256] {
        let mut cells = [0u64; 256];
        for ray in 0..band.ends.len() {
            let mut end = self.rays.depth;
            for &run in band.ray(ray).iter().rev() {
                cells[usize::from(run_flag(run))] += u64::from(end - run_cell(run));
                end = run_cell(run);
            }
        }
        cells
    }
}

/// Flag of a cell of a ray with the given runs.
pub fn flag_at(runs: &[u32], cell: u32) -> u8 {
    match runs.partition_point(|&run| run_cell(run) <= cell) {
        0 => 0,
        after => run_flag(runs[after - 1]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn columns() -> Columns {
        let rays = Rays::new(2, [2, 2, 10]);
        let first =
            Band { first_ray: 0, ends: vec![2, 2, 3], runs: vec![run(1, 7), run(4, 0), run(9, 1)], ..Band::default() };
        let second = Band { first_ray: 3, ends: vec![1], runs: vec![run(0, 2)], ..Band::default() };
        Columns::new(rays, vec![first, second])
    }

    #[test]
    fn runs_are_found_across_bands() {
        let columns = columns();
        assert_eq!(columns.dims(), [2, 2, 10]);
        let flags = |x, y| (0..10).map(|z| columns.flag([x, y, z])).collect::<Vec<_>>();
        assert_eq!(flags(0, 0), [0, 7, 7, 7, 0, 0, 0, 0, 0, 0]);
        assert_eq!(flags(1, 0), [0; 10]);
        assert_eq!(flags(0, 1), [0, 0, 0, 0, 0, 0, 0, 0, 0, 1]);
        assert_eq!(flags(1, 1), [2; 10]);
        for ray in 0..=4 {
            let found: Vec<&[u32]> = columns.rays_from(ray).collect();
            let expected: Vec<&[u32]> = (ray..4).map(|ray| columns.ray(ray)).collect();
            assert_eq!(found, expected, "from ray {ray}");
        }
    }

    #[test]
    fn every_cell_is_counted_once() {
        let cells = columns().cells_per_flag();
        assert_eq!([cells[0], cells[1], cells[2], cells[7]], [26, 1, 10, 3]);
        assert_eq!(cells.iter().sum::<u64>(), 40);
    }

    #[test]
    fn equality_looks_at_rays_not_at_bands() {
        let joined = Band {
            first_ray: 0,
            ends: vec![2, 2, 3, 4],
            runs: vec![run(1, 7), run(4, 0), run(9, 1), run(0, 2)],
            ..Band::default()
        };
        let mut joined = Columns::new(columns().rays, vec![joined]);
        assert_eq!(joined, columns());
        joined.bands[0].runs[3] = run(1, 2);
        assert_ne!(joined, columns());
    }
}
