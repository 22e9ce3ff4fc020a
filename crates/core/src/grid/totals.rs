//! Totals: exact sums of volumes and areas, the same in any order, along any axis, and whatever windows a box is cut in.
//!
//! Lengths, areas -> whole numbers of a fixed unit -> [`Total`] -> f64, rounded once.
//! Among equal cells lengths are counted in cells. Otherwise a line lies at a whole number of units of 2^k, with k so that the box is
//! shorter than 2^62 of them: lines are rounded only where they are close to 0 beside the size of the box, to less than its 2^-61st
//! part. An area is rounded to a unit of 2^-100 of the square of the box, or less. Volumes and areas of windows add up to those of the box, as text.
//! Cost: some ns a term; 8 bytes a line.

use crate::grid::lines::Lines;

/// Bits that hold the length of a box.
const LENGTH_BITS: i32 = 62;
/// Bits that hold the square of its longest side.
const AREA_BITS: i32 = 100;

/// A sum of whole numbers, of at most 256 bits; the least come first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Total([u64; 4]);

impl Total {
    /// Adds another.
    pub fn add(&mut self, other: Total) {
        let mut carry = 0;
        for (limb, more) in self.0.iter_mut().zip(other.0) {
            let sum = u128::from(*limb) + u128::from(more) + carry;
            (*limb, carry) = (sum as u64, sum >> 64);
        }
    }

    /// Multiplies by a whole number.
    pub fn times(self, by: u64) -> Total {
        let (mut product, mut carry) = (self, 0);
        for limb in &mut product.0 {
            let part = u128::from(*limb) * u128::from(by) + carry;
            (*limb, carry) = (part as u64, part >> 64);
        }
        product
    }

    /// The nearest f64, ties to even.
    fn rounded(self) -> f64 {
        let Some(top) = (0..4).rev().find(|&limb| self.0[limb] > 0) else { return 0.0 };
        let below = if top > 0 { self.0[top - 1] } else { 0 };
        let both = u128::from(self.0[top]) << 64 | u128::from(below);
        // what is further below decides ties alone
        let is_more = self.0[..top.saturating_sub(1)].iter().any(|&limb| limb > 0);
        libm::ldexp((both | u128::from(is_more)) as f64, 64 * (top as i32 - 1))
    }

    /// As text: hexadecimal digits.
    pub fn text(self) -> String {
        let digits = self.0.iter().rev().map(|limb| format!("{limb:016x}")).collect::<String>();
        let short = digits.trim_start_matches('0');
        if short.is_empty() { "0".into() } else { short.into() }
    }

    /// Reads this text; None where it is none.
    pub fn of_text(text: &str) -> Option<Total> {
        let is_text = (1..=64).contains(&text.len()) && text.bytes().all(|byte| byte.is_ascii_hexdigit());
        let digits = if is_text { format!("{text:0>64}") } else { return None };
        let limb = |nth: usize| u64::from_str_radix(&digits[16 * nth..16 * (nth + 1)], 16).ok();
        Some(Total([limb(3)?, limb(2)?, limb(1)?, limb(0)?]))
    }
}

impl From<u128> for Total {
    fn from(number: u128) -> Total {
        Total([number as u64, (number >> 64) as u64, 0, 0])
    }
}

/// What lengths and areas of a box are counted in.
pub struct Ruler {
    /// Where the lines are, in units, counted from the first; None of equal cells, in which they are counted.
    lines: Option<[Vec<u64>; 3]>,
    /// A unit of volume: a number, and the exponent of 2 that it is multiplied by; and the exponent of a unit of area.
    volume: (f64, i32),
    area: i32,
}

impl Ruler {
    /// Measures between these lines, of which some may be those of a window of a box, or lie around it: only those within the box add up to it.
    pub fn new(lines: &Lines, whole: &Lines) -> Ruler {
        let sides = |of: &Lines| [0, 1, 2].map(|axis| of.line(axis, of.dims()[axis]) - of.line(axis, 0));
        let longer = |axis: usize| sides(whole)[axis].max(sides(lines)[axis]);
        // the least power of two above a length
        let exponents = [0, 1, 2].map(|axis| libm::frexp(longer(axis)).1);
        let longest = sides(whole).into_iter().fold(0.0, f64::max);
        let area = 2 * libm::frexp(longest).1 - AREA_BITS;
        let Some(volume) = lines.cell_volume() else {
            let units = exponents.map(|exponent| exponent - LENGTH_BITS);
            let places = |axis: usize| {
                let place = |line: f64| libm::rint(libm::ldexp(line, -units[axis])) as i128;
                let first = place(lines.line(axis, 0));
                lines.list(axis).into_iter().map(|line| (place(line) - first) as u64).collect()
            };
            let volume = (1.0, units.iter().sum());
            return Ruler { lines: Some([0, 1, 2].map(places)), volume, area };
        };
        Ruler { lines: None, volume: (volume, 0), area }
    }

    /// Whether a cell is a unit of volume.
    pub fn counts_cells(&self) -> bool {
        self.lines.is_none()
    }

    /// From a line of an axis to another, in units.
    pub(crate) fn length(&self, axis: usize, [from, to]: [u32; 2]) -> u64 {
        match &self.lines {
            None => (to - from).into(),
            Some(lines) => lines[axis][to as usize] - lines[axis][from as usize],
        }
    }

    /// The volume of cells from lines to others, in units.
    pub fn cells(&self, [low, high]: [[u32; 3]; 2]) -> Total {
        let [x, y, z] = [0, 1, 2].map(|axis| self.length(axis, [low[axis], high[axis]]));
        Total::from(u128::from(x) * u128::from(y)).times(z)
    }

    /// A volume of so many units; `parts` is in how many, a power of two, one is divided.
    pub fn volume(&self, total: Total, parts: u64) -> f64 {
        libm::ldexp(total.rounded() * self.volume.0 / parts as f64, self.volume.1)
    }

    /// An area as a number of units.
    pub fn of_area(&self, area: f64) -> Total {
        Total::from(libm::rint(libm::ldexp(area, -self.area)) as u128)
    }

    /// An area of so many units.
    pub fn area(&self, total: Total) -> f64 {
        libm::ldexp(total.rounded(), self.area)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn totals_are_rounded_once_and_to_even() {
        let of = |number: u128| Total::from(number);
        for number in
            [0, 1, (1 << 53) + 1, (1 << 54) + 3, u128::MAX, (1 << 100) + (1 << 47) + 1, (1 << 100) + (1 << 47)]
        {
            assert_eq!(of(number).rounded(), number as f64, "{number}");
            assert_eq!(Total::of_text(&of(number).text()), Some(of(number)));
        }
        // a tie that only the least bit decides, 200 bits below
        let mut tie = of((1 << 63) + (1 << 10)).times(1 << 63).times(1 << 63).times(2);
        let even = tie.rounded();
        tie.add(of(1));
        assert_eq!((even, tie.rounded()), (2f64.powi(190), 2f64.powi(190) + 2f64.powi(138)));
        let mut sum = of(u128::MAX);
        sum.add(of(1));
        assert_eq!((sum.text(), sum.rounded()), ("1".to_string() + &"0".repeat(32), 2f64.powi(128)));
        assert_eq!(["", "g", "-1", &"1".repeat(65)].map(Total::of_text), [None; 4]);
    }

    #[test]
    fn lengths_between_lines_add_up_and_are_those_of_the_lines() {
        let list = |scale: f64| vec![-3.3 * scale, -1e-9 * scale, 0.1 * scale, 0.3 * scale, 7.7 * scale];
        for scale in [1.0, 1e-30, 1e30] {
            let whole = Lines::from_lists([list(1.0), list(scale), vec![0.0, 1.0, 3.0]]).unwrap();
            let some = whole.window([[1, 1, 0], [4, 3, 1]]);
            let [ruler, of_some] = [&whole, &some].map(|lines| Ruler::new(lines, &whole));
            for (from, to) in [(0, 1), (1, 2), (1, 3), (0, 4)] {
                let length = ruler.length(1, [from, to]);
                let expected =
                    libm::ldexp(whole.line(1, to) - whole.line(1, from), LENGTH_BITS - libm::frexp(11.0 * scale).1);
                assert!((length as f64 - expected).abs() <= 4.0 + 1e-15 * expected, "{length} {expected}");
            }
            let both: Vec<u64> = (1..3).map(|line| ruler.length(1, [line, line + 1])).collect();
            assert_eq!(both, [0, 1].map(|line| of_some.length(1, [line, line + 1])));
            assert_eq!(both.iter().sum::<u64>(), ruler.length(1, [1, 3]));
            let mut halves = of_some.cells([[0; 3], [1, 2, 1]]);
            halves.add(of_some.cells([[1, 0, 0], [3, 2, 1]]));
            assert_eq!(halves, ruler.cells([[1, 1, 0], [4, 3, 1]]));
            let volume = ruler.volume(halves.times(8), 8);
            let expected = (7.7 + 1e-9) * 0.3 * scale + (7.7 + 1e-9) * 1e-9 * scale;
            assert!((volume / expected - 1.0).abs() < 1e-14, "{volume} {expected}");
        }
        let equal = Lines::new([0.1; 3], [0.1, 0.2, 0.3], [7, 8, 9]).unwrap();
        let ruler = Ruler::new(&equal, &equal);
        let total = ruler.cells([[0; 3], [3, 5, 7]]);
        assert_eq!(ruler.volume(total, 1), 105.0 * equal.cell_volume().unwrap());
        let area = ruler.area(ruler.of_area(1.0 / 3.0));
        assert!((area - 1.0 / 3.0).abs() < 1e-16, "{area}");
    }
}
