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
//! 50, and some megabytes for each core, where they are in no order. [`surface_with_rests`] is for callers that must be able to stop.

use std::ops::Range;
use std::sync::{Mutex, PoisonError};

use crate::base::control::{Control, at_once};
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
/// Chunks that each core takes between two rests: some tens of milliseconds.
const CHUNKS_AT_ONCE: usize = 8;
/// Vertices that each core compares between two rests, about.
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
    let Ok(found) = surface_within(facets, &Memory::default()) else { unreachable!("there is no limit") };
    found
}

/// The same within a limit of memory.
///
/// # Errors
/// `memory` where the numbers of the vertices and the edges do not fit.
pub fn surface_within(facets: &[Facet], memory: &Memory) -> Result<Surface> {
    let mut control = Control::default();
    control.memory = memory.clone();
    at_once(surface_with_rests(facets, &control))
}

/// The same with rests, within the memory of the control, which is told the share that is done.
///
/// # Errors
/// Those of [`surface_within`]; `cancelled`.
pub async fn surface_with_rests(facets: &[Facet], control: &Control) -> Result<Surface> {
    let mut check = Check::new(facets, control);
    check.make_chunks().await?;
    let first_numbers = check.number_shared().await?;
    check.look_at_own(first_numbers).await?;
    check.look_between().await?;
    Ok(check.found())
}

/// What errors of memory call what is held meanwhile.
const EXAMINED: &str = "the edges of the surface, which are examined,";

/// An examination of facets.
struct Check<'a> {
    facets: &'a [Facet],
    control: &'a Control,
    room: Held,
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

impl<'a> Check<'a> {
    fn new(facets: &'a [Facet], control: &'a Control) -> Check<'a> {
        Check {
            facets,
            control,
            room: Held::of(&control.memory),
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

    /// Rests where this share of the work is done, and takes room for the most bytes that the next part of it holds beside the chunks.
    async fn begin(&mut self, share: f64, n_bytes: u64) -> Result<()> {
        debug_assert!(self.bytes_of_chunks <= self.room.n_bytes(), "{} bytes", self.bytes_of_chunks);
        self.room.set(self.bytes_of_chunks + n_bytes, EXAMINED)?;
        self.control.rest_at(share).await
    }

    /// Number of all chunks.
    fn n_chunks(&self) -> usize {
        self.facets.len().div_ceil(FACETS)
    }

    /// Chunks between two rests: no large share of them all, whatever the number of cores, so that memory is counted as it is taken.
    fn chunks_at_once(&self) -> usize {
        let n_cores = current_num_threads();
        (CHUNKS_AT_ONCE * n_cores).min(n_cores.max(self.n_chunks() / 16)).max(1)
    }

    /// Number of vertices of a part.
    fn n_of_part(&self, part: usize) -> usize {
        self.chunks.iter().map(|chunk| chunk.n_of_part(part)).sum()
    }

    /// Parts between two rests, from the given one.
    fn parts_at_once(&self, first: usize) -> Range<usize> {
        let n_vertices: usize = self.chunks.iter().map(Chunk::n_vertices).sum();
        let n = COMPARED_AT_ONCE * current_num_threads() * PARTS / n_vertices.max(1);
        first..PARTS.min(first + n.max(current_num_threads()))
    }

    /// Most bytes of the lists for the chunks that cores look at.
    fn bytes_of_pool(&self) -> u64 {
        current_num_threads().min(self.n_chunks()) as u64 * Scratch::most_bytes(FACETS.min(self.facets.len()))
    }

    /// Bytes of the groups of connected facets.
    fn bytes_of_groups(&self) -> u64 {
        (size_of::<u32>() * self.facets.len()) as u64
    }

    /// Facets become chunks, with vertices of their own, and their areas are summed.
    async fn make_chunks(&mut self) -> Result<()> {
        for facets in self.facets.chunks(self.chunks_at_once() * FACETS) {
            let of_next = facets.len().div_ceil(FACETS) as u64 * Chunk::most_bytes(FACETS.min(facets.len()));
            let share = 0.4 * self.chunks.len() as f64 / self.n_chunks() as f64;
            self.begin(share, self.bytes_of_pool() + of_next).await?;
            let make = |facets: &[Facet]| (self.pool.with(|scratch| Chunk::new(facets, scratch)), areas(facets));
            let made: Vec<(Chunk, Vec<(f64, u64)>)> = on_all_cores(|| facets.par_chunks(FACETS).map(make).collect());
            for (chunk, areas) in made {
                self.bytes_of_chunks += chunk.bytes();
                self.chunks.push(chunk);
                for (area, zeros) in areas {
                    self.area += area;
                    self.zero_area += zeros;
                }
            }
        }
        Ok(())
    }

    /// Compares the vertices of all chunks, part by part, and numbers those that several have; the first number of each part, unless there is
    /// one chunk.
    async fn number_shared(&mut self) -> Result<Option<Vec<usize>>> {
        if self.chunks.len() < 2 {
            return Ok(None);
        }
        let mut n_shared = Vec::with_capacity(PARTS);
        while n_shared.len() < PARTS {
            let parts = self.parts_at_once(n_shared.len());
            let n_at_once = parts.len().min(current_num_threads()) as u64;
            let largest = parts.clone().map(|part| self.n_of_part(part)).max().unwrap_or(0);
            let share = 0.4 + 0.1 * n_shared.len() as f64 / PARTS as f64;
            self.begin(share, self.bytes_of_pool() + n_at_once * shared::most_bytes_of_part(largest)).await?;
            n_shared.extend(shared::number_parts(&mut self.chunks, parts));
        }
        let mut first = 0;
        for n in &mut n_shared {
            first += std::mem::replace(n, first);
        }
        Ok(Some(n_shared))
    }

    /// Looks at the edges that chunks have for themselves.
    async fn look_at_own(&mut self, first_numbers: Option<Vec<usize>>) -> Result<()> {
        let (n_chunks, n_at_once) = (self.chunks.len(), self.chunks_at_once());
        let of_chunk = Chunk::most_bytes_of_own_edges(FACETS.min(self.facets.len()));
        for first in (0..n_chunks).step_by(n_at_once) {
            let end = n_chunks.min(first + n_at_once);
            let of_next = (end - first) as u64 * of_chunk;
            let share = 0.5 + 0.4 * first as f64 / n_chunks as f64;
            self.begin(share, self.bytes_of_pool() + self.bytes_of_groups() + of_next).await?;
            if first == 0 {
                self.shells.reserve(self.facets.len());
            }
            let next = &mut self.chunks[first..end];
            let bytes_before: u64 = next.iter().map(Chunk::bytes).sum();
            let facets = &self.facets[first * FACETS..self.facets.len().min(end * FACETS)];
            let look = |(chunk, facets): (&mut Chunk, &[Facet])| {
                chunk.number(facets, first_numbers.as_deref());
                self.pool.with(|scratch| chunk.own_edges(facets, scratch))
            };
            let pairs = next.par_iter_mut().zip(facets.par_chunks(FACETS));
            let found: Vec<chunk::OwnEdges> = on_all_cores(|| pairs.map(look).collect());
            self.bytes_of_chunks += next.iter().map(Chunk::bytes).sum::<u64>();
            self.bytes_of_chunks -= bytes_before;
            for own in found {
                self.tally.add(own.tally);
                self.shells.append(own.groups);
                self.collapsed += own.n_collapsed;
            }
        }
        self.pool = Pool::default();
        Ok(())
    }

    /// Looks at the edges that several chunks may use, class by class.
    async fn look_between(&mut self) -> Result<()> {
        let (facets, n_facets) = (self.facets, self.facets.len());
        let n_uses: usize = self.chunks.iter().map(Chunk::n_shared_uses).sum();
        let n_classes = if n_uses == 0 { 0 } else { shared::n_classes(n_uses, n_facets) };
        for class in 0..n_classes {
            let share = 0.9 + 0.1 * class as f64 / n_classes as f64;
            self.begin(share, self.bytes_of_groups() + shared::bytes_of_class(n_uses, n_facets)).await?;
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
        Ok(())
    }

    /// What was found, once all is done.
    fn found(self) -> Surface {
        let n_facets = self.facets.len() as u64;
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
