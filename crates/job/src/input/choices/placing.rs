//! Where a geometry is: the affine map from the coordinates of its file to those of the world.

use glam::{DAffine3, DMat3, DVec3};

use crate::base::error::{Error, Result};

/// Places the coordinates of a file in the world. The default leaves them where they are.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Placing(DAffine3);

impl Placing {
    /// First scales, then rotates by degrees about x, y and z in this order, then translates.
    ///
    /// Sines and cosines do not come from the platform, so that every machine snaps to the same bits; multiples of 90 degrees are
    /// exact.
    ///
    /// # Errors
    /// `job-value` where a number is not finite, or a scale is 0.
    pub fn new(scale: [f64; 3], rotate_degrees: [f64; 3], translate: [f64; 3]) -> Result<Placing> {
        let numbers = [scale, rotate_degrees, translate];
        if scale.contains(&0.0) || numbers.as_flattened().iter().any(|number| !number.is_finite()) {
            let message = format!("scale {scale:?}, rotate {rotate_degrees:?}, translate {translate:?}");
            return Err(Error::new("job-value", message, "give finite numbers, and scales other than 0"));
        }
        Ok(Placing::of_numbers(scale, rotate_degrees, translate))
    }

    /// As [`Placing::new`], with numbers that were checked.
    #[doc(hidden)]
    pub fn of_numbers(scale: [f64; 3], rotate_degrees: [f64; 3], translate: [f64; 3]) -> Placing {
        let [x, y, z] = rotate_degrees.map(sine_cosine_of_degrees);
        let about_x = DMat3::from_cols_array_2d(&[[1.0, 0.0, 0.0], [0.0, x.1, x.0], [0.0, -x.0, x.1]]);
        let about_y = DMat3::from_cols_array_2d(&[[y.1, 0.0, -y.0], [0.0, 1.0, 0.0], [y.0, 0.0, y.1]]);
        let about_z = DMat3::from_cols_array_2d(&[[z.1, z.0, 0.0], [-z.0, z.1, 0.0], [0.0, 0.0, 1.0]]);
        let matrix = about_z * about_y * about_x * DMat3::from_diagonal(DVec3::from(scale));
        Placing(DAffine3::from_mat3_translation(matrix, DVec3::from(translate)))
    }

    /// Places a point; where nothing is moved, the same numbers.
    #[inline]
    pub fn place(&self, point: [f64; 3]) -> [f64; 3] {
        if *self == Placing::default() { point } else { self.0.transform_point3(point.into()).to_array() }
    }

    /// Returns the function from a corner to its world coordinates. The identity returns the file's number exactly.
    #[doc(hidden)]
    #[inline]
    pub fn of_corners(self) -> impl Fn([f32; 3]) -> [f64; 3] + Sync {
        let stays = self == Placing::default();
        move |corner: [f32; 3]| {
            let file = [f64::from(corner[0]), f64::from(corner[1]), f64::from(corner[2])];
            if stays { file } else { self.place(file) }
        }
    }

    /// What scale and rotation make of the unit vectors along x, y and z.
    pub fn matrix(&self) -> [[f64; 3]; 3] {
        self.0.matrix3.to_cols_array_2d()
    }

    /// By what volumes grow; negative where the placing mirrors.
    pub fn determinant(&self) -> f64 {
        self.0.matrix3.determinant()
    }
}

/// Sine and cosine. What is left of whole quarter turns, at most 45 degrees, is exact, and `libm` does the rest: FDLIBM in Rust,
/// which has the same bits on every target. Off by less than an ulp or so.
fn sine_cosine_of_degrees(degrees: f64) -> (f64, f64) {
    // exact for any angle
    let degrees = degrees % 360.0;
    let quarter_turns = libm::rint(degrees / 90.0);
    let (sine, cosine) = libm::sincos((degrees - 90.0 * quarter_turns).to_radians());
    match quarter_turns.rem_euclid(4.0) as u8 {
        0 => (sine, cosine),
        1 => (cosine, -sine),
        2 => (-sine, -cosine),
        _ => (-cosine, sine),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sines_and_cosines_are_those_of_libm() {
        for step in -9000..9000 {
            let degrees = f64::from(step) * 0.123;
            let (sine, cosine) = sine_cosine_of_degrees(degrees);
            let expected = libm::sincos((degrees % 360.0).to_radians());
            // radians of several turns are off by more than ours
            assert!((sine - expected.0).abs() < 1e-15 && (cosine - expected.1).abs() < 1e-15, "{degrees}");
            assert!((sine * sine + cosine * cosine - 1.0).abs() < 4e-16, "{degrees}");
        }
        assert_eq!(sine_cosine_of_degrees(720.0), (0.0, 1.0));
        // of -280 degrees, from a table
        let (sine, cosine) = sine_cosine_of_degrees(-1e9);
        assert!((sine - 0.984_807_753_012_208_1).abs() < 2e-16 && (cosine - 0.173_648_177_666_930_35).abs() < 5e-17);
        assert!(sine_cosine_of_degrees(f64::INFINITY).0.is_nan());
    }

    #[test]
    fn quarter_turns_are_exact_and_follow_the_right_hand_rule() {
        let turn = Placing::of_numbers([1.0; 3], [0.0, 0.0, 90.0], [0.0; 3]);
        assert_eq!(turn.place([1.0, 0.0, 0.0]), [0.0, 1.0, 0.0]);
        let turn = Placing::of_numbers([1.0; 3], [-270.0, 0.0, 0.0], [0.0; 3]);
        assert_eq!(turn.place([0.0, 1.0, 0.0]), [0.0, 0.0, 1.0]);
        let turn = Placing::of_numbers([1.0; 3], [0.0, 450.0, 0.0], [0.0; 3]);
        assert_eq!(turn.place([0.0, 0.0, 1.0]), [1.0, 0.0, 0.0]);
    }

    #[test]
    fn scale_then_rotate_then_translate() {
        let place = Placing::of_numbers([2.0, 1.0, 1.0], [0.0, 0.0, 90.0], [10.0, 0.0, 0.0]);
        assert_eq!(place.place([1.0, 0.0, 0.0]), [10.0, 2.0, 0.0]);
    }

    #[test]
    fn numbers_that_are_not_finite_and_scales_of_0_are_errors() {
        let placing = |scale: f64, degrees: f64, z: f64| Placing::new([1.0, scale, 1.0], [degrees; 3], [0.0, 0.0, z]);
        assert_eq!(placing(1.0, 0.0, 0.0), Ok(Placing::default()));
        for (scale, degrees, z) in
            [(0.0, 0.0, 0.0), (f64::NAN, 0.0, 0.0), (1.0, f64::INFINITY, 0.0), (1.0, 0.0, f64::NAN)]
        {
            assert_eq!(placing(scale, degrees, z).unwrap_err().code(), "job-value");
        }
    }
}
