//! Rays: one through the centres of every column of cells.
//!
//! A ray axis and the cells of the box -> [`Rays`]. Ray (i, j) runs along the ray axis through the centres of the cells
//! with index i on the first and j on the second axis across it; its index is `i + n_i * j`. In the fixed-point frame it
//! is at (i * 2^F, j * 2^F). Source: the paper, Eq. 10-12. Twin: `shaders/map.wgsl`.

/// The bundle of parallel rays that covers the box.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rays {
    /// Axis of the rays: 0, 1 or 2.
    pub axis: usize,
    /// The two axes across the rays, ascending.
    pub across: [usize; 2],
    /// Number of rays along each of the axes across.
    pub counts: [u32; 2],
    /// Number of cells on a ray.
    pub depth: u32,
}

impl Rays {
    /// Casts rays along `axis` through a box of `dims` cells.
    pub fn new(axis: usize, dims: [u32; 3]) -> Rays {
        let across = [[1, 2], [0, 2], [0, 1]][axis];
        Rays { axis, across, counts: across.map(|a| dims[a]), depth: dims[axis] }
    }

    /// The axis that carries the rays by default: the one with most cells, which needs the fewest rays. Axes less than an
    /// eighth shorter count as equal, and of equals the first is taken: runs along x are contiguous in every output and
    /// expand to flags several times faster than runs along z.
    pub fn longest_axis(dims: [u32; 3]) -> usize {
        let longest = dims[0].max(dims[1]).max(dims[2]);
        (0..3).find(|&axis| dims[axis] > longest - longest.div_ceil(8)).unwrap_or(0)
    }

    /// Number of rays of the box.
    pub fn n_rays(&self) -> u64 {
        u64::from(self.counts[0]) * u64::from(self.counts[1])
    }

    /// The cell x, y, z of its indices on the first axis across, the second and along the rays.
    pub fn cell(&self, [first, second, along]: [u32; 3]) -> [u32; 3] {
        let mut cell = [along; 3];
        (cell[self.across[0]], cell[self.across[1]]) = (first, second);
        cell
    }

    /// Coordinates of a point reordered to (first axis across, second axis across, along the ray).
    #[inline(always)]
    pub fn project(&self, point: [i32; 3]) -> [i32; 3] {
        [point[self.across[0]], point[self.across[1]], point[self.axis]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_axis_carries_the_rays_and_ties_go_to_the_first() {
        assert_eq!(Rays::longest_axis([5, 5, 5]), 0);
        assert_eq!(Rays::longest_axis([1, 1, 1]), 0);
        assert_eq!(Rays::longest_axis([5, 6, 6]), 1);
        assert_eq!(Rays::longest_axis([5, 6, 7]), 2);
        assert_eq!(Rays::longest_axis([1, 1, 2]), 2);
        assert_eq!(Rays::longest_axis([1023, 1023, 1024]), 0);
        assert_eq!(Rays::longest_axis([800, 899, 1024]), 1);
    }

    #[test]
    fn projection_keeps_the_axes_across_in_order() {
        assert_eq!(Rays::new(1, [2, 3, 4]).project([10, 20, 30]), [10, 30, 20]);
        assert_eq!(Rays::new(1, [2, 3, 4]).counts, [2, 4]);
        assert_eq!(Rays::new(1, [2, 3, 4]).n_rays(), 8);
    }
}
