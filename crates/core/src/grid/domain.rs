//! The domain: the box that is meshed, and the end points that its mesh lines should meet.
//!
//! Bounding boxes of the geometries, a job -> [`Domain`]. The box is the job's two points, or the box around all geometries,
//! plus the job's padding by length. The end points X_i, Y_j, Z_k are the ends of the box and those ends of the geometries'
//! boxes that lie inside it, ascending, each once. Source: the paper, section 2.2, Eq. 4-6.

use crate::base::error::{Error, Result};
use crate::input::job::{Job, LinesJob, Padding};

/// Least and greatest coordinates.
pub type BoundingBox = [[f64; 3]; 2];

/// The box that is meshed.
#[derive(Debug, Clone, PartialEq)]
pub struct Domain {
    /// First corner, in the unit of the files.
    pub low: [f64; 3],
    /// Second corner.
    pub high: [f64; 3],
    /// End points of the intervals on each axis, ascending; the first is `low`, the last `high`.
    pub end_points: [Vec<f64>; 3],
    /// Bounding boxes of the geometries, as given: they may reach out of the domain.
    pub boxes: Vec<BoundingBox>,
}

impl Domain {
    /// Finds the box of a job around geometries with the given boxes.
    ///
    /// # Errors
    /// - `domain-empty`: there is no geometry, or the box has no extent along an axis.
    /// - `job-value`: a scale or translate puts a geometry where f64 ends.
    pub fn new(job: &Job, boxes: &[BoundingBox]) -> Result<Domain> {
        let [low, high] = match (&job.lines, job.domain) {
            (Some(lines), _) => ends_of(lines),
            (None, Some([x0, y0, z0, x1, y1, z1])) => padded([[x0, y0, z0], [x1, y1, z1]], job.padding),
            (None, None) => padded(around(boxes)?, job.padding),
        };
        for axis in 0..3 {
            let name = ["x", "y", "z"][axis];
            if !(high[axis] - low[axis]).is_finite() {
                let [from, to] = [low[axis], high[axis]];
                let message = format!("the domain reaches from {from:?} to {to:?} along {name}");
                return Err(Error::new("job-value", message, "use a smaller domain, padding, scale or translate"));
            }
            if low[axis] >= high[axis] {
                let message = format!("the geometries have no extent along {name}: all lie at {}", low[axis]);
                return Err(Error::new("domain-empty", message, "give a padding by length, or a domain of two points"));
            }
        }
        let end_points = [0, 1, 2].map(|axis| {
            let ends = boxes.iter().flatten().map(|corner| corner[axis]);
            let inside = ends.filter(|&end| low[axis] < end && end < high[axis]);
            let mut points = vec![low[axis], high[axis]];
            for end in inside {
                let at = points.partition_point(|&point| point < end);
                if points[at] != end {
                    points.insert(at, end);
                }
            }
            points
        });
        Ok(Domain { low, high, end_points, boxes: boxes.to_vec() })
    }

    /// Length of the box along an axis.
    pub fn extent(&self, axis: usize) -> f64 {
        self.high[axis] - self.low[axis]
    }

    /// Length by which coordinates of the geometries along an axis are uncertain: 2^-23 of the greatest.
    ///
    /// Files hold f32, which round by 2^-24 of a coordinate; two ends that should agree, or an extent, are off by at most two
    /// such errors. A translate that brings far geometries near is not accounted for.
    pub(crate) fn file_rounding(&self, axis: usize) -> f64 {
        let coordinates = self.boxes.iter().flatten().map(|corner| corner[axis].abs());
        coordinates.fold(0.0, f64::max) * f64::from(f32::EPSILON)
    }

    /// Length of the longest side.
    pub fn longest_extent(&self) -> f64 {
        (0..3).map(|axis| self.extent(axis)).fold(0.0, f64::max)
    }
}

/// The first and the last line of each axis; those of lists that hold too few are refused later.
fn ends_of(LinesJob { x, y, z }: &LinesJob) -> BoundingBox {
    let lists = [x, y, z];
    let end = |of: fn(&[f64]) -> Option<&f64>| lists.map(|list| of(list).copied().unwrap_or_default());
    [end(<[f64]>::first), end(<[f64]>::last)]
}

fn around(boxes: &[BoundingBox]) -> Result<BoundingBox> {
    let join = |a: BoundingBox, b: &BoundingBox| -> BoundingBox {
        let low = std::array::from_fn(|axis| a[0][axis].min(b[0][axis]));
        [low, std::array::from_fn(|axis| a[1][axis].max(b[1][axis]))]
    };
    let first = boxes.first().copied();
    let joined = first.map(|first| boxes.iter().fold(first, join));
    joined.ok_or_else(|| Error::new("domain-empty", "there is no geometry to put a box around", "add a geometry"))
}

fn padded([low, high]: BoundingBox, padding: Option<Padding>) -> BoundingBox {
    let Some(Padding::Length(lengths)) = padding else { return [low, high] };
    let lengths = lengths.each();
    [std::array::from_fn(|axis| low[axis] - lengths[axis]), std::array::from_fn(|axis| high[axis] + lengths[axis])]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::job::PerAxis;
    use crate::set;

    const BOXES: [BoundingBox; 2] = [[[0.0, 0.0, 0.0], [4.0, 1.0, 1.0]], [[1.0, 0.0, -2.0], [9.0, 1.0, 0.5]]];

    #[test]
    fn the_box_is_around_all_geometries_and_knows_their_ends() {
        let domain = Domain::new(&Job::default(), &BOXES).unwrap();
        assert_eq!((domain.low, domain.high), ([0.0, 0.0, -2.0], [9.0, 1.0, 1.0]));
        assert_eq!(domain.end_points, [vec![0.0, 1.0, 4.0, 9.0], vec![0.0, 1.0], vec![-2.0, 0.0, 0.5, 1.0]]);
        assert_eq!(domain.longest_extent(), 9.0);
        assert_eq!([0, 1, 2].map(|axis| domain.file_rounding(axis)), [9.0, 1.0, 2.0].map(|far: f64| far / 8_388_608.0));
        let small = Domain::new(&Job::default(), &[[[-0.25; 3], [0.125; 3]]]).unwrap();
        assert_eq!(small.file_rounding(1), 0.25 / 8_388_608.0);
    }

    #[test]
    fn padding_by_length_moves_the_ends() {
        let job = set!(Job { padding: Some(Padding::Length(PerAxis::Each([1.0, 0.5, 2.0]))), ..Job::default() });
        let domain = Domain::new(&job, &BOXES).unwrap();
        assert_eq!((domain.low, domain.high), ([-1.0, -0.5, -4.0], [10.0, 1.5, 3.0]));
        // along y both geometries have the same ends, each once
        assert_eq!(domain.end_points[..2], [vec![-1.0, 0.0, 1.0, 4.0, 9.0, 10.0], vec![-0.5, 0.0, 1.0, 1.5]]);
    }

    #[test]
    fn padding_goes_around_a_given_box_too() {
        let job = set!(Job {
            domain: Some([2.0, 0.0, -1.0, 3.0, 1.0, 0.0]),
            padding: Some(Padding::Length(PerAxis::Each([1.5, 0.0, 0.25]))),
            ..Job::default()
        });
        let domain = Domain::new(&job, &BOXES).unwrap();
        assert_eq!((domain.low, domain.high), ([0.5, 0.0, -1.25], [4.5, 1.0, 0.25]));
        assert_eq!(domain.end_points[0], [0.5, 1.0, 4.0, 4.5]);
        // cells are added by the lines
        let job = set!(Job { padding: Some(Padding::Cells(PerAxis::All(2))), ..job });
        assert_eq!(Domain::new(&job, &BOXES).unwrap().low, [2.0, 0.0, -1.0]);
    }

    #[test]
    fn a_given_box_hides_the_ends_outside_it() {
        let job = set!(Job { domain: Some([0.5, 0.0, -3.0, 5.0, 1.0, 0.25]), ..Job::default() });
        let domain = Domain::new(&job, &BOXES).unwrap();
        assert_eq!(domain.end_points, [vec![0.5, 1.0, 4.0, 5.0], vec![0.0, 1.0], vec![-3.0, -2.0, 0.0, 0.25]]);
    }

    #[test]
    fn geometries_at_the_end_of_the_numbers_are_refused() {
        for far in [[[0.0; 3], [f64::INFINITY; 3]], [[f64::MIN; 3], [f64::MAX; 3]]] {
            assert_eq!(Domain::new(&Job::default(), &[far]).unwrap_err().code(), "job-value");
        }
    }

    #[test]
    fn a_flat_box_is_refused_and_named() {
        for (axis, name) in ["x", "y", "z"].iter().enumerate() {
            let mut flat = [[[0.0, 0.0, 0.0], [4.0, 1.0, 3.0]]];
            flat[0][1][axis] = 0.0;
            let error = Domain::new(&Job::default(), &flat).unwrap_err();
            assert_eq!(error.code(), "domain-empty");
            assert!(error.to_string().contains(&format!("along {name}")), "{error}");
        }
        assert_eq!(Domain::new(&Job::default(), &[]).unwrap_err().code(), "domain-empty");
    }
}
