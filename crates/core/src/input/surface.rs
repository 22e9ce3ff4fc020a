//! Closedness of a surface: which edges of its facets have no partner.
//!
//! Facets -> [`Surface`], facts for reports; no later stage depends on it. Two corners are one vertex where
//! their f32 coordinates are equal (-0 = +0), which is what the exact arithmetic of the mesher sees: a gap of one ulp is
//! a gap. A facet with two equal corners is collapsed and only counted.
//!
//! [`crate::input::edges`] defines open, non-manifold and flipped edges. The rule `nonzero` is well defined if the facets use every
//! edge as often in one direction as in the other, the rule `parity` if they use every edge an even number of times.
//!
//! In four passes, each of which is done in parts that fit the cache, on all cores: facets become chunks with vertices of their own; the vertices of
//! all chunks are compared; chunks look at the edges that they alone use; the edges between chunks are sorted. Keys decide everywhere, hashes
//! only where they are looked for. Nothing that is found depends on the order of facets, but for the last bits of the area.
//!
//! Cost: O(n log n) time. Beside the input 18 bytes a facet where facets that are near in the list are near in space, and 4 for the shells; at most
//! 50, and some megabytes for each core, where they are in no order. [`SurfaceCheck`] does it in steps, for callers that must be able to stop.

use std::ops::Range;
use std::sync::{Mutex, PoisonError};

use crate::base::error::Result;
use crate::base::memory::{Held, Memory};
use crate::base::parallel::*;
use crate::input::edges::{Groups, directions, each};
use crate::input::geometry::Facet;

mod chunk;
mod shared;
mod tally;

use chunk::{Chunk, FACETS, PARTS, Scratch};
use tally::Tally;

pub use tally::MAX_WORST_OPEN_EDGES;

/// Facets whose areas are summed first.
const AREAS_AT_ONCE: usize = 4096;
/// Chunks that each core takes in a step: some tens of milliseconds.
const CHUNKS_AT_ONCE: usize = 8;
/// Vertices that each core compares in a step, about.
const COMPARED_AT_ONCE: usize = 1 << 18;

/// What the edges and areas of facets say about the surface they form.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Surface {
    /// Number of facets, collapsed ones included.
    pub n_facets: u64,
    /// Number of edges used once.
    pub open_edges: u64,
    /// Number of edges used more than twice.
    pub nonmanifold_edges: u64,
    /// Number of edges used twice in the same direction: one of the two facets is inside-out.
    pub flipped_edges: u64,
    /// Number of facets whose area is zero in f64, collapsed ones included.
    pub zero_area: u64,
    /// Number of facets with two or three equal corners.
    pub collapsed: u64,
    /// Every edge is used as often one way as the other: winding numbers are well defined.
    pub closed_oriented: bool,
    /// Every edge is used an even number of times: odd and even are well defined, whatever the orientation.
    pub closed_parity: bool,
    /// Every edge is used exactly once each way. Like the two above true where no facet has an edge.
    pub watertight: bool,
    /// Sum of the facets' areas, in squared file units.
    pub area: f64,
    /// Number of groups of facets connected over shared edges, collapsed facets left out.
    pub shells: u64,
    /// At most [`MAX_WORST_OPEN_EDGES`] open edges, longest first, as their two end points in file coordinates.
    pub worst_open_edges: Vec<[[f32; 3]; 2]>,
}

/// The corners' normal times twice the area of a facet, right-hand rule, in f64; zero for facets of zero area.
pub fn doubled_area_vector(facet: &Facet) -> [f64; 3] {
    // written out: nested maps of arrays are calls, which take several times as long
    let [a, b, c] = [in_f64(facet[0]), in_f64(facet[1]), in_f64(facet[2])];
    let u = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
    let v = [c[0] - a[0], c[1] - a[1], c[2] - a[2]];
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}

#[inline(always)]
fn in_f64([x, y, z]: [f32; 3]) -> [f64; 3] {
    [f64::from(x), f64::from(y), f64::from(z)]
}

/// Examines the edges and areas of facets. Several solids that are closed together are passed as one slice.
///
/// Facets carry a 32-bit index, so that there may be at most 2^32 of them.
pub fn surface(facets: &[Facet]) -> Surface {
    let mut check = SurfaceCheck::new(facets);
    while check.step(facets) {}
    check.finish()
}

/// The same within a limit of memory.
///
/// # Errors
/// `memory` where the numbers of the vertices and the edges do not fit.
pub fn surface_within(facets: &[Facet], memory: &Memory) -> Result<Surface> {
    let mut room = Held::of(memory);
    let mut check = SurfaceCheck::new(facets);
    loop {
        room.set(check.bytes_of_step(), EXAMINED)?;
        if !check.step(facets) {
            return Ok(check.finish());
        }
    }
}

/// What errors of memory call what is held meanwhile.
const EXAMINED: &str = "the edges of the surface, which are examined,";

/// An examination of facets in steps, each of which gets all facets.
pub struct SurfaceCheck {
    n_facets: usize,
    pass: Pass,
    chunks: Vec<Chunk>,
    /// Bytes that the chunks take.
    bytes_of_chunks: u64,
    area: f64,
    zero_area: u64,
    collapsed: u64,
    shells: Groups,
    tally: Tally,
    pool: Pool,
}

/// Lists for the chunks that cores look at, at most one for each.
#[derive(Default)]
struct Pool(Mutex<Vec<Scratch>>);

impl Pool {
    fn with<T>(&self, work: impl FnOnce(&mut Scratch) -> T) -> T {
        let lock = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let mut scratch = lock().pop().unwrap_or_default();
        let result = work(&mut scratch);
        lock().push(scratch);
        result
    }
}

/// What the next step does.
enum Pass {
    /// The next facets become chunks.
    Chunks,
    /// The next parts of the vertices of all chunks are compared; how many the parts before have that are shared.
    Shared(Vec<usize>),
    /// The next chunks, from this one, look at the edges that are their own; the first number of the shared vertices of each part, if there
    /// are several chunks.
    Own(usize, Option<Vec<usize>>),
    /// The next class of edges between chunks is looked at.
    Between { class: usize, n_uses: usize },
}

impl SurfaceCheck {
    /// Starts to examine facets.
    pub fn new(facets: &[Facet]) -> SurfaceCheck {
        SurfaceCheck {
            n_facets: facets.len(),
            pass: Pass::Chunks,
            chunks: Vec::new(),
            bytes_of_chunks: 0,
            area: 0.0,
            zero_area: 0,
            collapsed: 0,
            shells: Groups::new(0),
            tally: Tally::new(),
            pool: Pool::default(),
        }
    }

    /// Does a part of the work; false once all is done.
    pub fn step(&mut self, facets: &[Facet]) -> bool {
        match std::mem::replace(&mut self.pass, Pass::Chunks) {
            Pass::Chunks => self.make_chunks(facets),
            Pass::Shared(n_shared) => self.compare(n_shared),
            Pass::Own(first, first_numbers) => self.look_at_own(facets, first, first_numbers),
            Pass::Between { class, n_uses } => return self.look_between(facets, class, n_uses),
        }
        true
    }

    /// Most bytes that the next step holds.
    fn bytes_of_step(&self) -> u64 {
        let groups = size_of::<u32>() as u64 * self.n_facets as u64;
        let n_cores = current_num_threads();
        let n_next = |first: usize| self.chunks_at_once().min(self.n_chunks() - first) as u64;
        let of_pool = n_cores.min(self.n_chunks()) as u64 * Scratch::most_bytes(FACETS.min(self.n_facets));
        let more = match &self.pass {
            Pass::Chunks => {
                let n_left = self.n_facets - self.chunks.len() * FACETS;
                of_pool + n_next(self.chunks.len()) * Chunk::most_bytes(FACETS.min(n_left))
            }
            Pass::Shared(n_shared) => {
                let parts = self.parts_at_once(n_shared.len());
                let n_at_once = parts.len().min(n_cores) as u64;
                let largest = parts.map(|part| self.n_of_part(part)).max().unwrap_or(0);
                of_pool + n_at_once * shared::most_bytes_of_part(largest)
            }
            Pass::Own(first, _) => {
                of_pool + groups + n_next(*first) * Chunk::most_bytes_of_own_edges(FACETS.min(self.n_facets))
            }
            Pass::Between { n_uses, .. } => groups + shared::bytes_of_class(*n_uses, self.n_facets),
        };
        self.bytes_of_chunks + more
    }

    /// Share of the work that is done, 0 to 1.
    pub fn share(&self) -> f64 {
        let of_chunks = |n: usize| n as f64 / self.n_chunks().max(1) as f64;
        match &self.pass {
            Pass::Chunks => 0.4 * of_chunks(self.chunks.len()),
            Pass::Shared(n_shared) => 0.4 + 0.1 * n_shared.len() as f64 / PARTS as f64,
            Pass::Own(first, _) => 0.5 + 0.4 * of_chunks(*first),
            Pass::Between { class, n_uses } => {
                0.9 + 0.1 * *class as f64 / shared::n_classes(*n_uses, self.n_facets) as f64
            }
        }
    }

    /// What was found, once all is done.
    pub fn finish(self) -> Surface {
        let n_facets = self.n_facets as u64;
        Surface {
            n_facets,
            open_edges: self.tally.open,
            nonmanifold_edges: self.tally.nonmanifold,
            flipped_edges: self.tally.flipped,
            zero_area: self.zero_area,
            collapsed: self.collapsed,
            closed_oriented: self.tally.closed_oriented,
            closed_parity: self.tally.closed_parity,
            watertight: self.tally.watertight,
            area: self.area,
            shells: n_facets - self.collapsed - self.shells.n_joined,
            worst_open_edges: self.tally.longest(),
        }
    }

    /// Number of all chunks.
    fn n_chunks(&self) -> usize {
        self.n_facets.div_ceil(FACETS)
    }

    /// Chunks of a step: no large share of them all, whatever the number of cores, so that memory is counted as it is taken.
    fn chunks_at_once(&self) -> usize {
        let n_cores = current_num_threads();
        (CHUNKS_AT_ONCE * n_cores).min(n_cores.max(self.n_chunks() / 16)).max(1)
    }

    /// Number of vertices of a part.
    fn n_of_part(&self, part: usize) -> usize {
        self.chunks.iter().map(|chunk| chunk.n_of_part(part)).sum()
    }

    /// Parts of a step from the given one.
    fn parts_at_once(&self, first: usize) -> Range<usize> {
        let n_vertices: usize = self.chunks.iter().map(Chunk::n_vertices).sum();
        let n = COMPARED_AT_ONCE * current_num_threads() * PARTS / n_vertices.max(1);
        first..PARTS.min(first + n.max(current_num_threads()))
    }

    /// Finds the vertices of the next facets, and sums their areas.
    fn make_chunks(&mut self, facets: &[Facet]) {
        let first = self.chunks.len() * FACETS;
        let next = &facets[first..facets.len().min(first + self.chunks_at_once() * FACETS)];
        let make = |facets: &[Facet]| (self.pool.with(|scratch| Chunk::new(facets, scratch)), areas(facets));
        let made: Vec<(Chunk, Vec<(f64, u64)>)> = next.par_chunks(FACETS).map(make).collect();
        for (chunk, areas) in made {
            self.bytes_of_chunks += chunk.bytes();
            self.chunks.push(chunk);
            for (area, zeros) in areas {
                self.area += area;
                self.zero_area += zeros;
            }
        }
        self.pass = match self.chunks.len() {
            n if n < self.n_chunks() => Pass::Chunks,
            0 | 1 => Pass::Own(0, None),
            _ => Pass::Shared(Vec::new()),
        };
    }

    /// Numbers the shared vertices of the next parts.
    fn compare(&mut self, mut n_shared: Vec<usize>) {
        let parts = self.parts_at_once(n_shared.len());
        n_shared.extend(shared::number_parts(&mut self.chunks, parts));
        if n_shared.len() < PARTS {
            self.pass = Pass::Shared(n_shared);
            return;
        }
        let mut first = 0;
        for n in &mut n_shared {
            first += std::mem::replace(n, first);
        }
        self.pass = Pass::Own(0, Some(n_shared));
    }

    /// Looks at the own edges of the next chunks.
    fn look_at_own(&mut self, facets: &[Facet], first: usize, first_numbers: Option<Vec<usize>>) {
        if first == 0 {
            self.shells.reserve(facets.len());
        }
        let end = self.n_chunks().min(first + self.chunks_at_once());
        let next = &mut self.chunks[first..end];
        let bytes_before: u64 = next.iter().map(Chunk::bytes).sum();
        let facets = &facets[first * FACETS..facets.len().min(end * FACETS)];
        let look = |(chunk, facets): (&mut Chunk, &[Facet])| {
            chunk.number(facets, first_numbers.as_deref());
            self.pool.with(|scratch| chunk.own_edges(facets, scratch))
        };
        let found: Vec<chunk::OwnEdges> = next.par_iter_mut().zip(facets.par_chunks(FACETS)).map(look).collect();
        self.bytes_of_chunks += next.iter().map(Chunk::bytes).sum::<u64>();
        self.bytes_of_chunks -= bytes_before;
        for own in found {
            self.tally.add(own.tally);
            self.shells.append(own.groups);
            self.collapsed += own.n_collapsed;
        }
        self.pass = if end < self.n_chunks() {
            Pass::Own(end, first_numbers)
        } else {
            self.pool = Pool::default();
            Pass::Between { class: 0, n_uses: self.chunks.iter().map(Chunk::n_shared_uses).sum() }
        };
    }

    /// Looks at a class of the edges that several chunks may use; false once all are done.
    fn look_between(&mut self, facets: &[Facet], class: usize, n_uses: usize) -> bool {
        let n_classes = shared::n_classes(n_uses, self.n_facets);
        if n_uses > 0 && class < n_classes {
            for uses in each(&shared::uses_of_class(&self.chunks, class, n_classes)) {
                self.tally.count(directions(uses));
                for two in uses.windows(2) {
                    self.shells.join(two[0].facet() as u32, two[1].facet() as u32);
                }
                if let [open] = uses {
                    let (facet, chunk) = (open.facet(), &self.chunks[open.facet() / FACETS]);
                    self.tally.list(open.pair().map(|vertex| facets[facet][chunk.corner(facet % FACETS, vertex)]));
                }
            }
        }
        self.pass = Pass::Between { class: class + 1, n_uses };
        n_uses > 0 && class + 1 < n_classes
    }
}

/// Sums of areas and numbers of facets without area, of blocks of fixed size, so that neither steps nor threads change the last bits.
fn areas(facets: &[Facet]) -> Vec<(f64, u64)> {
    let of_block = |block: &[Facet]| {
        block.iter().fold((0.0, 0), |(area, zeros), facet| {
            let [x, y, z] = doubled_area_vector(facet);
            (area + 0.5 * (x * x + y * y + z * z).sqrt(), zeros + u64::from([x, y, z] == [0.0; 3]))
        })
    };
    facets.chunks(AREAS_AT_ONCE).map(of_block).collect()
}

#[cfg(test)]
mod tests;
