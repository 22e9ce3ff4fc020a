//! Lines as people write them: 1.524, and not 1.5240000486373901.
//!
//! Files of surfaces hold numbers of 24 bits, and lines are computed from these. Who adds a box or a port to a solver's file types 1.524, which then
//! lies beside the line, and the solver leaves the box out. So a line is the decimal of at most seven digits that differs from it by no more than those
//! numbers are rounded, where there is one: 2^-24 of the largest of the axis. Numbers that are decimals already, of at most twelve digits, stay as they
//! are, and so do all lines of an axis whose cells are not much larger than that rounding.

use hexcast_core::grid::lines::Lines;

/// Digits that numbers of 24 bits hold.
const DIGITS: usize = 7;
/// Digits of a number that somebody gave as it is.
const GIVEN: usize = 12;
/// The rounding of numbers of 24 bits.
const ROUNDING: f64 = 1.0 / (1u64 << 24) as f64;
/// Cells are larger than the rounding by this at least.
const LEAST_CELL: f64 = 1000.0;

/// The lines of an axis.
pub(super) fn lines(lines: &Lines, axis: usize) -> Vec<f64> {
    let list = lines.list(axis);
    let most = rounding(&list);
    let smallest = list.windows(2).map(|two| two[1] - two[0]).fold(f64::INFINITY, f64::min);
    if smallest < LEAST_CELL * most {
        return list;
    }
    list.into_iter().map(|line| decimal(line, most)).collect()
}

/// The size of equal cells along an axis.
pub(super) fn size(lines: &Lines, axis: usize, size: f64) -> f64 {
    // both ends are rounded
    let most = 2.0 * rounding(&lines.list(axis)) / f64::from(lines.dims()[axis]);
    if size < LEAST_CELL * most { size } else { decimal(size, most) }
}

fn rounding(list: &[f64]) -> f64 {
    ROUNDING * list.iter().fold(0.0, |most: f64, line| most.max(line.abs()))
}

/// The shortest decimal that differs by no more than `most`, if a short one does.
fn decimal(number: f64, most: f64) -> f64 {
    let n_digits = format!("{number:e}").bytes().take_while(|byte| *byte != b'e').filter(u8::is_ascii_digit).count();
    if n_digits <= GIVEN {
        return number;
    }
    let of_digits = (0..DIGITS).filter_map(|n| format!("{number:.n$e}").parse::<f64>().ok());
    let mut candidates = [0.0].into_iter().chain(of_digits);
    candidates.find(|decimal| (decimal - number).abs() <= most).unwrap_or(number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_from_numbers_of_24_bits_are_the_decimals_that_were_written() {
        let [low, high] = [-60.0f32, 1.524].map(f64::from);
        let from_ends = Lines::new([low, 0.0, 0.0], [(high - low) / 42.0, f64::from(1.524f32) / 3.0, 0.1], [42, 3, 30]);
        let from_ends = from_ends.unwrap();
        assert_eq!(lines(&from_ends, 0)[42], 1.524);
        assert_eq!(lines(&from_ends, 1), [0.0, 0.508, 1.016, 1.524]);
        assert_eq!(lines(&from_ends, 2), (0..=30).map(|n| f64::from(n) / 10.0).collect::<Vec<_>>());
        assert_eq!(size(&from_ends, 1, f64::from(1.524f32) / 3.0), 0.508);
        assert_eq!(size(&from_ends, 2, 0.1), 0.1);
        // as it was given, though 24 bits do not hold it
        let given = vec![0.0, 99.999999, 100.123456789];
        let lists = Lines::from_lists([given.clone(), vec![0.0, 1.0 / 3.0], vec![1000.0, 1000.0001, 1000.00017]]);
        let lists = lists.unwrap();
        assert_eq!(lines(&lists, 0), given);
        // no short decimal is near enough
        assert_eq!(lines(&lists, 1), [0.0, 1.0 / 3.0]);
        // cells as fine as the rounding
        assert_eq!(lines(&lists, 2), lists.list(2));
    }
}
