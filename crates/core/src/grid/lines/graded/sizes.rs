//! The cells between fixed lines: as few as the largest size and the growth allow.
//!
//! Between two fixed lines the wanted size of a cell at t is `s(t) = min(h, l + a t, r + a (L - t))`, with L their distance, h the largest
//! size there, l and r the sizes wanted at both ends, and `a = ln(growth)`. Lines are where the integral of 1 / s reaches equal parts of
//! its whole, of which there are as few as leave each at most 1. Then a cell is at most h, and neighbours differ by at most
//! `exp(a) = growth`, since s changes by at most a along a unit of length. At a fixed line the cells of two intervals meet, each with a
//! part of its own; where one is larger than the growth allows, or than the cell at that line may be, the size wanted at its end is reduced,
//! until no such place is left. Where that makes a cell too small, all cells of the interval get the size of the one at its line.

/// An interval between two fixed lines.
#[derive(Debug, Clone, Copy)]
pub(super) struct Interval {
    /// Its length.
    pub(super) length: f64,
    /// Largest size of a cell in it.
    pub(super) largest: f64,
    /// Largest sizes of the first and the last cell.
    pub(super) outer: [f64; 2],
    /// Sizes wanted at both ends.
    ends: [f64; 2],
}

impl Interval {
    pub(super) fn new(length: f64, largest: f64) -> Interval {
        let largest = largest.min(length);
        Interval { length, largest, outer: [largest; 2], ends: [largest; 2] }
    }

    /// Lets no cell be larger.
    pub(super) fn limit(&mut self, size: f64) {
        self.largest = self.largest.min(size);
        self.outer = self.outer.map(|outer| outer.min(size));
    }

    /// Lets no cell be larger at an end, 0 or 1.
    pub(super) fn limit_outer(&mut self, end: usize, size: f64) {
        self.outer[end] = self.outer[end].min(size);
    }

    /// Lets all cells be as large as the outer ones only; whether that changes anything.
    fn flatten(&mut self) -> bool {
        let [first, last] = self.outer;
        let is_changed = first.min(last) < self.largest;
        self.limit(first.min(last));
        is_changed
    }

    /// Where s begins to be flat, and where it ceases to be.
    fn bends(&self, slope: f64) -> [f64; 2] {
        let [left, right] = self.ends;
        let meeting = (0.5 * (self.length + (right - left) / slope)).clamp(0.0, self.length);
        let rise = ((self.largest - left) / slope).clamp(0.0, meeting);
        let fall = ((self.largest - right) / slope).clamp(0.0, self.length - meeting);
        [rise, self.length - fall]
    }

    /// Integral of 1 / s over the rise, the flat part and the fall.
    fn integrals(&self, slope: f64) -> [f64; 3] {
        let [rise, fall] = self.bends(slope);
        let of_ramp = |end: f64, length: f64| libm::log1p(slope * length / end) / slope;
        let flat = (fall - rise) / self.largest;
        [of_ramp(self.ends[0], rise), flat, of_ramp(self.ends[1], self.length - fall)]
    }

    /// Number of cells.
    pub(super) fn n_cells(&self, slope: f64) -> f64 {
        // a billionth of a cell is rounding
        (self.integrals(slope).iter().sum::<f64>() - 1e-9).ceil().max(1.0)
    }

    /// Distance of line k of n from the first.
    pub(super) fn line(&self, slope: f64, k: f64, n: f64) -> f64 {
        let [of_rise, of_flat, of_fall] = self.integrals(slope);
        if of_rise == 0.0 && of_fall == 0.0 {
            return k * (self.length / n);
        }
        let whole = of_rise + of_flat + of_fall;
        let at = whole * (k / n);
        let ramp = |end: f64, integral: f64| end * libm::expm1(slope * integral) / slope;
        if at <= of_rise {
            ramp(self.ends[0], at)
        } else if at <= of_rise + of_flat {
            self.bends(slope)[0] + (at - of_rise) * self.largest
        } else {
            self.length - ramp(self.ends[1], whole - at)
        }
    }

    /// Sizes of the first and the last cell.
    fn outer_cells(&self, slope: f64) -> [f64; 2] {
        let n = self.n_cells(slope);
        if n == 1.0 {
            return [self.length; 2];
        }
        [self.line(slope, 1.0, n), self.length - self.line(slope, n - 1.0, n)]
    }

    /// Wants smaller sizes at ends whose cells are larger than they may be; whether there are any.
    fn reduce_outer(&mut self, slope: f64) -> bool {
        let mut is_reduced = false;
        for end in [0, 1] {
            let cell = self.outer_cells(slope)[end];
            if cell > self.outer[end] * (1.0 + 1e-9) {
                self.reduce(end, self.ends[end] * (0.98 * self.outer[end] / cell), slope);
                is_reduced = true;
            }
        }
        is_reduced
    }

    /// Wants a smaller size at an end, 0 or 1.
    fn reduce(&mut self, end: usize, size: f64, slope: f64) {
        self.ends[end] = size;
        self.ends[1 - end] = self.ends[1 - end].min(size + slope * self.length);
    }
}

/// Most times that a size at an end is reduced, for each interval.
const MAX_STEPS: usize = 2000;

/// Finds the sizes wanted at the ends of neighbouring intervals, none with a cell below `least`; the interval where there is none.
pub(super) fn settle(intervals: &mut [Interval], growth: f64, least: f64) -> Result<(), usize> {
    loop {
        match settle_once(intervals, growth, least) {
            Err(index) if intervals[index].flatten() => {}
            settled => return settled,
        }
    }
}

fn settle_once(intervals: &mut [Interval], growth: f64, least: f64) -> Result<(), usize> {
    let slope = libm::log(growth);
    let n = intervals.len();
    // sizes at fixed lines, as all intervals allow
    let mut wanted = vec![f64::INFINITY; n + 1];
    for (index, interval) in intervals.iter().enumerate() {
        wanted[index] = wanted[index].min(interval.largest);
        wanted[index + 1] = wanted[index + 1].min(interval.largest);
    }
    for index in 0..n {
        wanted[index + 1] = wanted[index + 1].min(wanted[index] + slope * intervals[index].length);
    }
    for index in (0..n).rev() {
        wanted[index] = wanted[index].min(wanted[index + 1] + slope * intervals[index].length);
    }
    for (index, interval) in intervals.iter_mut().enumerate() {
        interval.ends = [wanted[index], wanted[index + 1]];
    }
    for _ in 0..MAX_STEPS {
        let mut is_settled = true;
        for index in 1..n {
            let [before, after] = [intervals[index - 1].outer_cells(slope)[1], intervals[index].outer_cells(slope)[0]];
            let (larger, end, ratio) =
                if before > after { (index - 1, 1, before / after) } else { (index, 0, after / before) };
            if ratio > growth * (1.0 + 1e-12) {
                let size = intervals[larger].ends[end] * (0.98 * growth / ratio);
                intervals[larger].reduce(end, size, slope);
                is_settled = false;
            }
        }
        for interval in intervals.iter_mut() {
            is_settled &= !interval.reduce_outer(slope);
        }
        // the smallest cell of an interval is at one of its ends
        let too_small =
            |interval: &Interval| interval.outer_cells(slope).iter().any(|size| *size < least * (1.0 - 1e-9));
        if let Some(index) = intervals.iter().position(too_small) {
            return Err(index);
        }
        if is_settled {
            return Ok(());
        }
    }
    Err(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_size_at_a_line_is_what_every_interval_allows_from_where_it_is() {
        // lengths and largest sizes
        let table: [&[(f64, f64)]; 5] = [
            &[(4.0, 3.0), (1.0, 0.2), (6.0, 2.0), (0.5, 0.1), (9.0, 5.0)],
            &[(1.0, 0.1), (7.0, 7.0), (7.0, 7.0)],
            &[(7.0, 7.0), (7.0, 7.0), (1.0, 0.1)],
            &[(2.0, 0.5), (2.0, 0.5)],
            &[(3.0, 1.0)],
        ];
        for (of, growth) in table.into_iter().flat_map(|of| [(of, 1.1), (of, 1.3), (of, 2.0)]) {
            let mut intervals: Vec<Interval> = of.iter().map(|&(length, most)| Interval::new(length, most)).collect();
            settle(&mut intervals, growth, 1e-3).unwrap();
            let lines: Vec<f64> =
                of.iter().scan(0.0, |at, (length, _)| Some(std::mem::replace(at, *at + length))).collect();
            for (index, interval) in intervals.iter().enumerate() {
                for (end, at) in [(0, lines[index]), (1, lines[index] + of[index].0)] {
                    let allowed = |(&low, &(length, most)): (&f64, &(f64, f64))| {
                        most.min(length) + growth.ln() * (low - at).max(at - low - length).max(0.0)
                    };
                    let allowed = lines.iter().zip(of).map(allowed).fold(f64::INFINITY, f64::min);
                    let wanted = interval.ends[end];
                    assert!(wanted <= allowed * (1.0 + 1e-9), "{of:?}, {growth}: {wanted} at {at}, allowed {allowed}");
                }
            }
        }
    }

    #[test]
    fn a_smaller_size_at_an_end_limits_the_other_end() {
        let mut interval = Interval::new(2.0, 1.0);
        interval.reduce(0, 0.25, 0.125);
        assert_eq!(interval.ends, [0.25, 0.5]);
        interval.reduce(1, 0.375, 0.125);
        assert_eq!(interval.ends, [0.25, 0.375]);
    }

    #[test]
    fn cells_may_be_as_small_as_the_smallest() {
        let settled = |least: f64| settle(&mut [Interval::new(3.0, 1.0), Interval::new(2.0, 1.0)], 1.3, least);
        assert_eq!([settled(0.6), settled(1.0), settled(1.0 + 1e-6)], [Ok(()), Ok(()), Err(0)]);
    }
}
