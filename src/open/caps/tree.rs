//! Triangles of caps in clusters, each with its moments: halves along the Morton curve, which lie in boxes.
//!
//! Cost: 6 microseconds a triangle; some 100 bytes.

use glam::DVec3;

use super::harmonics::{Terms, add_moved, add_triangle};
use super::triangle::Triangle;
use crate::control::Control;
use crate::error::Result;
use crate::parallel::*;
use crate::sort::sort;

/// Most triangles of a cluster that has no parts.
const OF_LEAF: usize = 48;
/// Leaves that a core looks at between two rests.
const OF_STEP: usize = 64;
/// Bits of a place on the Morton curve along an axis.
const BITS: u32 = 20;

/// Triangles that lie together.
pub(super) struct Cluster {
    pub(super) centre: DVec3,
    /// Most distance of a corner from the centre.
    pub(super) reach: f64,
    /// Of all triangles.
    pub(super) area: f64,
    pub(super) moments: Terms,
    parts: Parts,
}

enum Parts {
    Clusters([u32; 2]),
    /// A stretch of the triangles in the tree's order.
    Triangles([u32; 2]),
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
        sort(&mut places);
        let mut tree = Tree { clusters: Vec::new(), order: places.iter().map(|&(_, index)| index).collect() };
        tree.divide(triangles, &places, 0);
        let leaves: Vec<usize> =
            (0..tree.clusters.len()).filter(|&at| matches!(tree.clusters[at].parts, Parts::Triangles(_))).collect();
        for some in leaves.chunks(OF_STEP * current_num_threads()) {
            let moments: Vec<Terms> =
                some.par_iter().map(|&at| tree.of_triangles(&tree.clusters[at], triangles)).collect();
            some.iter().zip(moments).for_each(|(&at, moments)| tree.clusters[at].moments = moments);
            control.rest().await?;
        }
        for at in 0..tree.clusters.len() {
            if let Parts::Clusters(parts) = tree.clusters[at].parts {
                let mut moments = Terms::zero();
                for part in parts.map(|part| &tree.clusters[part as usize]) {
                    add_moved(&mut moments, &part.moments, part.centre - tree.clusters[at].centre);
                }
                tree.clusters[at].moments = moments;
            }
            if at % 4096 == 0 {
                control.rest().await?;
            }
        }
        Ok(tree)
    }

    /// The cluster of all.
    pub(super) fn root(&self) -> Near {
        Near::Cluster(self.clusters.len() as u32 - 1)
    }

    /// Adds what a cluster is made of.
    pub(super) fn open(&self, cluster: &Cluster, to: &mut Vec<Near>) {
        match cluster.parts {
            Parts::Clusters(parts) => to.extend(parts.map(Near::Cluster)),
            Parts::Triangles([start, end]) => {
                to.extend(self.order[start as usize..end as usize].iter().map(|&index| Near::Triangle(index)));
            }
        }
    }

    /// Adds the cluster of a stretch of the order, which begins at `start`, behind its parts; returns its index.
    fn divide(&mut self, triangles: &[Triangle], places: &[(u64, u32)], start: usize) -> u32 {
        let n = places.len();
        let parts = if n <= OF_LEAF {
            Parts::Triangles([start, start + n].map(|at| at as u32))
        } else {
            // where the highest bit in which they differ is set; none differ where all are at one place
            let differing = places[0].0 ^ places[n - 1].0;
            let middle = match differing.checked_ilog2() {
                Some(bit) => places.partition_point(|(place, _)| place >> bit & 1 == 0),
                None => n / 2,
            };
            let (lower, upper) = places.split_at(middle);
            let lower = self.divide(triangles, lower, start);
            Parts::Clusters([lower, self.divide(triangles, upper, start + middle)])
        };
        let corners = || places.iter().flat_map(|&(_, index)| triangles[index as usize].corners);
        let (low, high) = corners()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), corner| (low.min(corner), high.max(corner)));
        let centre = (low + high) * 0.5;
        // a little more than rounding takes away
        let reach = corners().map(|corner| corner.distance_squared(centre)).fold(0.0, f64::max).sqrt() * (1.0 + 1e-12);
        let area = places.iter().map(|&(_, index)| triangles[index as usize].area).sum::<f64>() * (1.0 + 1e-9);
        self.clusters.push(Cluster { centre, reach, area, moments: Terms::zero(), parts });
        self.clusters.len() as u32 - 1
    }

    fn of_triangles(&self, cluster: &Cluster, triangles: &[Triangle]) -> Terms {
        let mut moments = Terms::zero();
        if let Parts::Triangles([start, end]) = cluster.parts {
            for &index in &self.order[start as usize..end as usize] {
                add_triangle(&mut moments, triangles[index as usize].corners.map(|corner| corner - cluster.centre));
            }
        }
        moments
    }
}

/// Places of triangles on the Morton curve through their box, with their indices.
fn morton(triangles: &[Triangle]) -> Vec<(u64, u32)> {
    let first = |triangle: &Triangle| triangle.corners[0];
    let all = triangles.iter().map(first);
    let low = all.clone().fold(DVec3::INFINITY, DVec3::min);
    let size = (all.fold(DVec3::NEG_INFINITY, DVec3::max) - low).max_element().max(f64::MIN_POSITIVE);
    let place = |(index, triangle): (u32, &Triangle)| {
        let cells = ((first(triangle) - low) / size * f64::from((1u32 << BITS) - 1)).to_array().map(|c| c as u64);
        let bits = |bit: u32| (0..3).map(move |axis| (cells[axis] >> bit & 1) << (3 * bit + axis as u32)).sum::<u64>();
        ((0..BITS).map(bits).sum(), index)
    };
    (0..).zip(triangles).map(place).collect()
}
