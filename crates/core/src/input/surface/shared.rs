//! Shared vertices and edges: those of several chunks.
//!
//! Chunks -> numbers of the vertices that several of them have, part by part; each part is compared in a table that fits the cache. Then the
//! uses of edges whose ends both have numbers, sorted edge by edge, some classes of edges at a time.
//!
//! Cost: little where chunks have most of their vertices alone. Where facets are in no order nearly all vertices are shared: then
//! a pass over all facets for each class, and 72 bytes for each use of a class, 12 a facet.

use std::ops::Range;

use super::chunk::{Chunk, FACETS, OWN, Vertex};
use crate::base::parallel::*;
use crate::input::edges::{Use, vertex_hash};

/// Uses that are sorted at a time, about, are a sixth of the number of facets, but not fewer than this.
const LEAST_USES: usize = 1 << 18;
/// A place of the table that is free.
const FREE: usize = usize::MAX;

/// A vertex of a part.
struct Distinct {
    key: [u32; 3],
    /// Its number among the shared ones of its part, or [`OWN`].
    number: usize,
}

/// Numbers the vertices of some parts that several chunks have, from 0 in each part; returns how many each part has.
pub(super) fn number_parts(chunks: &mut [Chunk], parts: Range<usize>) -> Vec<usize> {
    let mut of_parts: Vec<Vec<&mut [Vertex]>> = parts.clone().map(|_| Vec::with_capacity(chunks.len())).collect();
    for chunk in chunks {
        of_parts.iter_mut().zip(chunk.of_parts(parts.clone())).for_each(|(part, vertices)| part.push(vertices));
    }
    on_all_cores(|| of_parts.into_par_iter().map(number_part).collect())
}

fn number_part(mut of_chunks: Vec<&mut [Vertex]>) -> usize {
    let n: usize = of_chunks.iter().map(|vertices| vertices.len()).sum();
    let mut table = vec![FREE; n_places(n)];
    let mut all: Vec<Distinct> = Vec::with_capacity(n);
    let mut index_of = Vec::with_capacity(n);
    let mut n_shared = 0;
    for key in of_chunks.iter().flat_map(|vertices| vertices.iter()).map(|vertex| vertex.key()) {
        // the first bits are those of the part
        let mut place = vertex_hash(key) as usize & (table.len() - 1);
        let index = loop {
            let index = table[place];
            if index == FREE {
                table[place] = all.len();
                all.push(Distinct { key, number: OWN });
                break all.len() - 1;
            }
            let other = &mut all[index];
            if other.key == key {
                // those of one chunk differ
                if other.number == OWN {
                    other.number = n_shared;
                    n_shared += 1;
                }
                break index;
            }
            place = (place + 1) & (table.len() - 1);
        };
        index_of.push(index);
    }
    let vertices = of_chunks.iter_mut().flat_map(|vertices| vertices.iter_mut());
    vertices.zip(index_of).for_each(|(vertex, index)| vertex.set_number(all[index].number));
    n_shared
}

/// Most bytes that a part of so many vertices takes.
pub(super) fn most_bytes_of_part(n: usize) -> u64 {
    (n * (size_of::<Distinct>() + size_of::<usize>()) + n_places(n) * size_of::<usize>()) as u64
}

/// Places of the table of so many vertices.
fn n_places(n: usize) -> usize {
    (n / 3 * 4 + 4).next_power_of_two()
}

/// Number of classes that so many uses of edges of so many facets are put in: each is a pass over all facets, so that there are at most 18.
pub(super) fn n_classes(n_uses: usize, n_facets: usize) -> usize {
    n_uses.div_ceil(LEAST_USES.max(n_facets / 6)).max(1)
}

/// The class of an edge: any that depends on both its vertices alone.
#[inline(always)]
fn class_of(low: usize, high: usize, n_classes: usize) -> usize {
    let hash = (low as u64 ^ (high as u64).rotate_left(32)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    (((hash >> 32) * n_classes as u64) >> 32) as usize
}

/// The uses of the edges of a class that several chunks may use, edge by edge.
pub(super) fn uses_of_class(chunks: &[Chunk], class: usize, n_classes: usize) -> Vec<Use> {
    let is_wanted = |low: usize, high: usize| class_of(low, high, n_classes) == class;
    let of_chunk = |(index, chunk): (usize, &Chunk)| chunk.shared_uses(index * FACETS, is_wanted);
    let of_chunks: Vec<Vec<Use>> = on_all_cores(|| chunks.par_iter().enumerate().map(of_chunk).collect());
    let mut uses = of_chunks.concat();
    drop(of_chunks);
    on_all_cores(|| uses.par_sort_unstable());
    uses
}

/// Most bytes that the uses of a class take, about: lists that grow, and all in one list.
pub(super) fn bytes_of_class(n_uses: usize, n_facets: usize) -> u64 {
    (3 * size_of::<Use>() * n_uses.div_ceil(n_classes(n_uses, n_facets))) as u64
}
