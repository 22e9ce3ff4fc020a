//! Triangles of caps in clusters, each with its moments: halves along the Morton curve, which lie in boxes.
//!
//! Cost: of low degree 0.3 microseconds a triangle and some 150 bytes; of high degree 6, and some 200 bytes where triangles are many.

use glam::DVec3;

use super::harmonics::{LOW, Terms, add_moved, add_triangle};
use super::triangle::Triangle;
use crate::base::control::Control;
use crate::base::error::Result;
use crate::base::parallel::*;
use crate::base::sort::par_sort;

/// Most triangles of a cluster that has no parts.
const OF_LEAF: usize = 8;
/// Triangles that a core looks at between two rests.
const OF_STEP: usize = if cfg!(target_arch = "wasm32") { 1 << 10 } else { 1 << 13 };
/// Bits of a place on the Morton curve along an axis.
const BITS: u32 = 20;

/// Triangles that lie together.
pub(super) struct Cluster {
    pub(super) centre: DVec3,
    /// Most distance of a corner from the centre.
    pub(super) reach: f64,
    /// Of all triangles.
    pub(super) area: f64,
    /// A stretch of the triangles in the tree's order.
    triangles: [u32; 2],
    parts: Option<[u32; 2]>,
}

/// What is near, and has to be looked at more closely.
#[derive(Debug, Clone, Copy)]
pub(super) enum Near {
    Cluster(u32),
    Triangle(u32),
}

/// Clusters, the parts before the whole.
pub(super) struct Tree {
    pub(super) clusters: Vec<Cluster>,
    order: Vec<u32>,
}

impl Tree {
    /// Puts triangles, of which there is one at least, into clusters.
    ///
    /// # Errors
    /// `cancelled`.
    pub(super) async fn new(triangles: &[Triangle], control: &Control) -> Result<Tree> {
        let mut places = morton(triangles);
        control.rest().await?;
        par_sort(&mut places);
        let mut tree = Tree { clusters: Vec::new(), order: places.iter().map(|&(_, index)| index).collect() };
        // stretches, those that were halved, and how many triangles were looked at since the last rest
        let (mut left, mut done, mut n_looked) = (vec![(0, places.len(), false)], Vec::new(), 0);
        while let Some((start, end, is_halved)) = left.pop() {
            if !is_halved && end - start > OF_LEAF {
                let middle = start + half(&places[start..end]);
                left.extend([(start, end, true), (middle, end, false), (start, middle, false)]);
                continue;
            }
            let parts = if is_halved { done.pop().zip(done.pop()).map(|(upper, lower)| [lower, upper]) } else { None };
            let cluster = tree.cluster(triangles, [start, end], parts);
            done.push(tree.clusters.len() as u32);
            tree.clusters.push(cluster);
            n_looked += end - start;
            if n_looked > 8 * OF_STEP {
                n_looked = 0;
                control.rest().await?;
            }
        }
        Ok(tree)
    }

    /// The cluster of a stretch of the order.
    fn cluster(&self, triangles: &[Triangle], [start, end]: [usize; 2], parts: Option<[u32; 2]>) -> Cluster {
        let own = || self.order[start..end].iter().map(|&index| &triangles[index as usize]);
        let corners = || own().flat_map(|triangle| triangle.corners);
        let (low, high) = corners()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), corner| (low.min(corner), high.max(corner)));
        let centre = (low + high) * 0.5;
        // a little more than rounding takes away
        let reach = corners().map(|corner| corner.distance_squared(centre)).fold(0.0, f64::max).sqrt() * (1.0 + 1e-12);
        let area = own().map(|triangle| triangle.area).sum::<f64>() * (1.0 + 1e-9);
        Cluster { centre, reach, area, triangles: [start, end].map(|at| at as u32), parts }
    }

    /// The moments, N terms each, of all clusters but those of a few triangles.
    ///
    /// # Errors
    /// `cancelled`.
    pub(super) async fn expand<const N: usize>(
        &self,
        triangles: &[Triangle],
        control: &Control,
    ) -> Result<Vec<Option<Box<Terms<N>>>>> {
        // so that those of many triangles take some hundred bytes each
        let of_leaf = if N > LOW { (triangles.len() / 4096).clamp(OF_LEAF, 4 * OF_LEAF) } else { OF_LEAF };
        let clusters = &self.clusters;
        let large_parts = |cluster: &Cluster| cluster.parts.filter(|_| self.of(cluster).len() > of_leaf);
        let mut all: Vec<Option<Box<Terms<N>>>> = (0..clusters.len()).map(|_| None).collect();
        let is_leaf = |&at: &u32| large_parts(&clusters[at as usize]).is_none();
        let root = clusters.len() as u32 - 1;
        let leaves: Vec<u32> =
            clusters.iter().filter_map(large_parts).flatten().chain([root]).filter(is_leaf).collect();
        for some in leaves.chunks((OF_STEP / of_leaf).max(1) * current_num_threads()) {
            let moments: Vec<_> = some.par_iter().map(|&at| self.of_triangles(at, triangles)).collect();
            some.iter().zip(moments).for_each(|(&at, moments)| all[at as usize] = Some(moments));
            control.rest().await?;
        }
        for at in 0..clusters.len() {
            if let Some(parts) = large_parts(&clusters[at]) {
                let mut moments = Box::new(Terms::zero());
                for part in parts.map(|part| part as usize) {
                    let step = clusters[part].centre - clusters[at].centre;
                    all[part].iter().for_each(|own| add_moved(&mut moments, own, step));
                }
                all[at] = Some(moments);
            }
            if at % OF_STEP == 0 {
                control.rest().await?;
            }
        }
        Ok(all)
    }

    /// The cluster of all.
    pub(super) fn root(&self) -> Near {
        Near::Cluster(self.clusters.len() as u32 - 1)
    }

    /// Adds what a cluster is made of.
    pub(super) fn open(&self, cluster: &Cluster, to: &mut Vec<Near>) {
        match cluster.parts {
            Some(parts) => to.extend(parts.map(Near::Cluster)),
            None => to.extend(self.of(cluster).iter().map(|&index| Near::Triangle(index))),
        }
    }

    fn of(&self, cluster: &Cluster) -> &[u32] {
        let [start, end] = cluster.triangles.map(|at| at as usize);
        &self.order[start..end]
    }

    fn of_triangles<const N: usize>(&self, at: u32, triangles: &[Triangle]) -> Box<Terms<N>> {
        let (cluster, mut moments) = (&self.clusters[at as usize], Box::new(Terms::zero()));
        for &index in self.of(cluster) {
            add_triangle(&mut moments, triangles[index as usize].corners.map(|corner| corner - cluster.centre));
        }
        moments
    }
}

/// Where places are halved: where the highest bit in which they differ is set; none differ where all are at one place.
fn half(places: &[(u64, u32)]) -> usize {
    let differing = places[0].0 ^ places[places.len() - 1].0;
    match differing.checked_ilog2() {
        Some(bit) => places.partition_point(|(place, _)| place >> bit & 1 == 0),
        None => places.len() / 2,
    }
}

/// Places of triangles with their indices: by size, in powers of 2, then on the Morton curve through their box. So one large triangle
/// does not make the reach of many small ones large.
fn morton(triangles: &[Triangle]) -> Vec<(u64, u32)> {
    let first = |triangle: &Triangle| triangle.corners[0];
    let all = triangles.iter().map(first);
    let low = all.clone().fold(DVec3::INFINITY, DVec3::min);
    let size = (all.fold(DVec3::NEG_INFINITY, DVec3::max) - low).max_element().max(f64::MIN_POSITIVE);
    let place = |(index, triangle): (u32, &Triangle)| {
        let cells = ((first(triangle) - low) / size * f64::from((1u32 << BITS) - 1)).to_array().map(|c| c as u64);
        let bits = |bit: u32| (0..3).map(move |axis| (cells[axis] >> bit & 1) << (3 * bit + axis as u32)).sum::<u64>();
        let longest = (0..3).map(|k| triangle.corners[k].distance(triangle.corners[(k + 1) % 3])).fold(0.0, f64::max);
        // the exponent of its length in cells, from -4 to 11
        let size = (longest.to_bits() >> 52).clamp(1019, 1034) - 1019;
        (size << (3 * BITS) | (0..BITS).map(bits).sum::<u64>(), index)
    };
    (0..).zip(triangles).map(place).collect()
}
