//! The order in which geometries win.

use crate::geometry::Geometry;

/// Geometries in the order in which they win: rank 0 loses against all others.
///
/// Sorted by priority, at equal priority by position in the job ("meshed in order": the later wins).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Ranks {
    /// Index in the job of the geometry of each rank.
    pub geometry_of_rank: Vec<usize>,
    /// Property flag of each rank.
    pub flag_of_rank: Vec<u8>,
}

impl Ranks {
    /// Ranks geometries by priority and order.
    pub fn new(geometries: &[Geometry]) -> Ranks {
        let mut geometry_of_rank: Vec<usize> = Vec::new();
        for (index, geometry) in geometries.iter().enumerate() {
            let rank = geometry_of_rank.partition_point(|&other| geometries[other].priority <= geometry.priority);
            geometry_of_rank.insert(rank, index);
        }
        let flag_of_rank = geometry_of_rank.iter().map(|&index| geometries[index].flag).collect();
        Ranks { geometry_of_rank, flag_of_rank }
    }
}
