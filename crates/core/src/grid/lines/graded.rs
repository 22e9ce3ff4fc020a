//! Generated lines: on every end of every geometry's box, close where geometries are small, far elsewhere.
//!
//! Domain, boxes of geometries, sizes -> [`Lines`] and what the reader should know. Axis by axis:
//!
//! 1. The ends of the domain and of the boxes in it are fixed lines. Of two that are closer than the smallest cell the first stays, or that
//!    of the domain; a sentence names both.
//! 2. At an edge of metal, where the field is singular, a solver of Maxwell's equations is most accurate with the edge a third of a cell
//!    from the line inside and two thirds from the line outside (openEMS and others): both are fixed lines instead. Not along the axis
//!    along which a sheet is thin, nor where the edge is an end of something else as well.
//! 3. Between fixed lines `sizes` puts as few cells as the largest sizes and the growth allow. Geometries limit sizes by the ends of their
//!    boxes, whichever lines these got (`wanted`).
//! 4. Layers for absorbing boundaries are cells of the size at the end, beyond the domain.
//!
//! Cost: a few microseconds a line.

use super::{AXES, Lines, MAX_LISTED};
use crate::base::error::{Error, Result};
use crate::base::finding::Finding;
use crate::base::sort::sort_by;
use crate::grid::domain::{BoundingBox, Domain};
use crate::input::geometry::Sizing;
use crate::input::job::{DEFAULT_GROWTH, GradedJob, PerAxis, short_number};

mod sizes;
mod wanted_sizes;

use sizes::{Interval, settle};
use wanted_sizes::{Wanted, interval};

/// A geometry around which lines are generated.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Body<'a> {
    /// Its name, for findings.
    pub name: &'a str,
    /// Its box.
    pub bounds: BoundingBox,
    /// Sizes of cells across it.
    pub sizing: Sizing,
}

impl Body<'_> {
    /// A body of a name, its box, and what is asked of the cells across it.
    pub fn new(name: &str, bounds: BoundingBox, sizing: Sizing) -> Body<'_> {
        Body { name, bounds, sizing }
    }
}

/// Generates the lines of a job, and finds the ends that got none; geometries have the indices of `bodies`.
///
/// # Errors
/// `lines-no-sizes` where cells would have to be smaller than the smallest; `too-many-cells`.
pub fn graded(job: &GradedJob, domain: &Domain, bodies: &[Body]) -> Result<(Lines, Vec<Finding>)> {
    let mut findings = Vec::new();
    let mut lists = [const { Vec::new() }; 3];
    for (axis, list) in lists.iter_mut().enumerate() {
        *list = Axis { job, domain, bodies, axis }.lines(&mut findings)?;
        let layers = job.absorbing.map_or(0, |cells| PerAxis::each(cells)[axis]);
        add_layers(list, layers);
    }
    Ok((Lines::from_lists(lists)?, findings))
}

/// One axis of a job.
struct Axis<'a> {
    job: &'a GradedJob,
    domain: &'a Domain,
    bodies: &'a [Body<'a>],
    axis: usize,
}

/// A place where a line shall be, and whose ends are there: the geometry, and the side on which it does not lie.
#[derive(Debug, Clone)]
struct Fixed {
    at: f64,
    owners: Vec<(usize, f64)>,
}

/// An edge of metal, and the size of the cell that it lies in.
struct Edge {
    index: usize,
    outwards: f64,
    size: f64,
}

impl Axis<'_> {
    fn lines(&self, findings: &mut Vec<Finding>) -> Result<Vec<f64>> {
        let fixed = self.fixed(findings);
        let mut wanted = self.wanted(&fixed);
        loop {
            self.check_sizes(&wanted)?;
            let mut of_edges = findings.clone();
            let lines = self.lines_between(&fixed, &wanted, &mut of_edges);
            let lacks = |of: &mut Wanted| lines.as_ref().is_ok_and(|lines| of.count_more(lines));
            if wanted.iter_mut().filter_map(|of| lacks(of).then_some(())).count() == 0 {
                *findings = of_edges;
                return lines;
            }
        }
    }

    /// All lines, where geometries want cells of some sizes.
    fn lines_between(&self, fixed: &[Fixed], wanted: &[Wanted], findings: &mut Vec<Finding>) -> Result<Vec<f64>> {
        let mut edges = self.edges(fixed, wanted, findings);
        let growth = self.job.growth.unwrap_or(DEFAULT_GROWTH);
        let least = self.job.smallest(self.axis);
        loop {
            let (places, cells_of_edges) = places(fixed, &edges);
            let mut intervals: Vec<Interval> =
                places.windows(2).map(|two| self.interval(wanted, [two[0], two[1]])).collect();
            // of more no sizes are found: they are below the rounding of their places
            self.check_n_cells(intervals.iter().map(|of| of.length / of.largest).sum::<f64>().floor())?;
            let settled = settle(&mut intervals, growth, least);
            // the cell around an edge stays whole: where it cannot, it has to be smaller
            let divided = |edge: &usize| intervals[cells_of_edges[*edge]].n_cells(libm::log(growth)) > 1.0;
            if let Some(edge) = (0..edges.len()).find(divided) {
                edges[edge].size *= 0.8;
                if edges[edge].size < least {
                    let Edge { index, .. } = edges.remove(edge);
                    self.note_edge(findings, &fixed[index], "a cell around it would be smaller than the smallest");
                }
                continue;
            }
            settled.map_err(|index| self.no_sizes([places[index], places[index + 1]], growth))?;
            return self.filled(&places, &intervals, growth);
        }
    }

    fn check_n_cells(&self, n_cells: f64) -> Result<()> {
        if n_cells < MAX_LISTED as f64 {
            return Ok(());
        }
        let (n_cells, name) = (short_number(n_cells), AXES[self.axis]);
        let message = format!("{n_cells} cells along {name}: at most {} fit", MAX_LISTED - 1);
        Err(Error::new("too-many-cells", message, "use a larger max_size, or a smaller domain"))
    }

    /// The places of all lines.
    fn filled(&self, places: &[f64], intervals: &[Interval], growth: f64) -> Result<Vec<f64>> {
        let slope = libm::log(growth);
        let n_cells: f64 = intervals.iter().map(|interval| interval.n_cells(slope)).sum();
        self.check_n_cells(n_cells)?;
        let mut lines = vec![places[0]];
        for (interval, two) in intervals.iter().zip(places.windows(2)) {
            let n = interval.n_cells(slope);
            lines.extend((1..n as u32).map(|k| two[0] + interval.line(slope, k.into(), n)));
            lines.push(two[1]);
        }
        Ok(lines)
    }

    /// What each geometry wants.
    fn wanted(&self, fixed: &[Fixed]) -> Vec<Wanted> {
        let of = |(body, Body { sizing, .. }): (usize, &Body)| Wanted::new(self.ends_of(fixed, body), *sizing);
        self.bodies.iter().enumerate().map(of).collect()
    }

    /// The cells between two lines.
    fn interval(&self, wanted: &[Wanted], two: [f64; 2]) -> Interval {
        interval(wanted, two, self.job.max_size.each()[self.axis], self.job.smallest(self.axis))
    }

    /// Refuses geometries that want cells smaller than the smallest.
    fn check_sizes(&self, wanted: &[Wanted]) -> Result<()> {
        let least = self.job.smallest(self.axis);
        for (Body { name, .. }, wanted) in self.bodies.iter().zip(wanted) {
            let ([low, high], size) = (wanted.ends, wanted.size());
            if high > low && size < least * (1.0 - 1e-9) {
                let axis = AXES[self.axis];
                let [low, high, size, least] = [low, high, size, least].map(short_number);
                let message = format!(
                    "geometry \"{name}\" wants cells of at most {size} along {axis}, from {low} to {high}: the smallest is {least}"
                );
                let hint = "allow smaller cells (min_size), or let it have a larger max_size or fewer min_cells";
                return Err(Error::new("lines-no-sizes", message, hint));
            }
        }
        Ok(())
    }

    /// The ends of a geometry's box, within the domain; on their lines where only rounding of the files keeps them off.
    fn ends_of(&self, fixed: &[Fixed], body: usize) -> [f64; 2] {
        let [low, high] = self.bodies[body].bounds.map(|corner| corner[self.axis]);
        let [first, last] = [self.domain.low[self.axis], self.domain.high[self.axis]];
        let rounding = self.domain.file_rounding(self.axis);
        let place = |side: f64, end: f64| {
            let own = fixed.iter().find(|fixed| fixed.owners.contains(&(body, side)));
            let near = own.filter(|fixed| (fixed.at - end).abs() <= rounding);
            near.map_or(end.clamp(first, last), |fixed| fixed.at)
        };
        match [place(-1.0, low), place(1.0, high)] {
            // thinner than that
            [one, other] if one == other && low < high => [low.clamp(first, last), high.clamp(first, last)],
            ends => ends,
        }
    }

    /// The ends of the domain and of all geometries in it, ascending, none closer to each other than the smallest cell.
    fn fixed(&self, findings: &mut Vec<Finding>) -> Vec<Fixed> {
        let [first, last] = [self.domain.low[self.axis], self.domain.high[self.axis]];
        let mut ends: Vec<(f64, usize, f64)> = Vec::new();
        for (index, body) in self.bodies.iter().enumerate() {
            let [low, high] = body.bounds.map(|corner| corner[self.axis]);
            ends.extend(
                [(low, index, -1.0), (high, index, 1.0)].into_iter().filter(|(at, ..)| (first..=last).contains(at)),
            );
        }
        // of equal ones in the order of the geometries
        sort_by(&mut ends, |one, other| {
            one.0.total_cmp(&other.0).then(one.1.cmp(&other.1)).then(one.2.total_cmp(&other.2)).is_lt()
        });
        let least = self.job.smallest(self.axis);
        let mut fixed = vec![Fixed { at: first, owners: Vec::new() }];
        for (at, body, side) in ends {
            // the end of the domain stays, unless its beginning is as close
            let line = if last - at < least { last } else { at };
            match fixed.last_mut().filter(|fixed| line - fixed.at < least) {
                Some(fixed) => {
                    self.note(findings, (at, body), fixed);
                    fixed.owners.push((body, side));
                }
                None => {
                    let new = Fixed { at: line, owners: vec![(body, side)] };
                    self.note(findings, (at, body), &new);
                    fixed.push(new);
                }
            }
        }
        if fixed.last().is_none_or(|end| end.at < last) {
            fixed.push(Fixed { at: last, owners: Vec::new() });
        }
        fixed
    }

    /// Says that an end is not where its line is.
    fn note(&self, findings: &mut Vec<Finding>, (at, body): (f64, usize), line: &Fixed) {
        if line.at == at {
            return;
        }
        let other = match line.owners.iter().find(|(owner, _)| *owner != body) {
            Some((owner, _)) => format!("of \"{}\"", self.bodies[*owner].name),
            None if line.owners.is_empty() || line.at == self.domain.high[self.axis] => "of the domain".into(),
            None => "of its other side".into(),
        };
        let (name, distance, smallest) = (self.bodies[body].name, (line.at - at).abs(), self.job.smallest(self.axis));
        let sentence = format!(
            "the end of \"{name}\" at {} = {at} has no line of its own: it is {distance:e} from that {other} at {}, less than the \
             smallest cell, {smallest}",
            AXES[self.axis], line.at,
        );
        let found = Finding::new("end-without-line", sentence).of_geometry(body, name).along(self.axis);
        let found = found.with_value("end", at).with_value("line", line.at).with_value("distance", distance);
        findings.push(found.with_value("smallest_cell", smallest));
    }

    /// The edges of metal, each with the size of a cell that has room between its neighbours.
    fn edges(&self, fixed: &[Fixed], wanted: &[Wanted], findings: &mut Vec<Finding>) -> Vec<Edge> {
        let mut edges = Vec::new();
        for index in 1..fixed.len().max(1) - 1 {
            let Fixed { at, ref owners } = fixed[index];
            let Some(&(_, outwards)) = owners.iter().find(|(body, _)| self.has_thirds(*body)) else { continue };
            if owners.iter().any(|&(other, side)| side != outwards || !self.has_thirds(other)) {
                self.note_edge(findings, &fixed[index], "another geometry ends there");
                continue;
            }
            let (before, after) = (at - fixed[index - 1].at, fixed[index + 1].at - at);
            let (inside, outside) = if outwards > 0.0 { (before, after) } else { (after, before) };
            // a cell more fits between this edge and one like it: inside 2/3 + 1 sizes, outside 4/3 + 1
            let room = (inside * 3.0 / 5.0).min(outside * 3.0 / 7.0);
            let [low, high] =
                [[fixed[index - 1].at, at], [at, fixed[index + 1].at]].map(|two| self.interval(wanted, two));
            let size = low.outer[1].min(high.outer[0]).min(room);
            if size < self.job.smallest(self.axis) {
                self.note_edge(findings, &fixed[index], "a cell around it would be smaller than the smallest");
                continue;
            }
            edges.push(Edge { index, outwards, size });
        }
        edges
    }

    /// Says that an edge of metal has no line at a third.
    fn note_edge(&self, findings: &mut Vec<Finding>, Fixed { at, owners }: &Fixed, why: &str) {
        let Some(&(body, _)) = owners.iter().find(|(body, _)| self.has_thirds(*body)) else { return };
        let name = self.bodies[body].name;
        let sentence = format!("the edge of \"{name}\" at {} = {at} lies on a line: {why}", AXES[self.axis]);
        let found = Finding::new("edge-on-line", sentence).of_geometry(body, name).along(self.axis);
        findings.push(found.with_value("edge", *at));
    }

    /// Whether lines shall lie beside the edges of a geometry: it is metal, and not a sheet across this axis.
    fn has_thirds(&self, body: usize) -> bool {
        let Body { bounds: [low, high], sizing, .. } = self.bodies[body];
        let extent = |axis: usize| high[axis] - low[axis];
        let others = (0..3).filter(|&axis| axis != self.axis).map(extent).fold(f64::INFINITY, f64::min);
        sizing.metal && extent(self.axis) >= 0.5 * others
    }

    fn no_sizes(&self, [from, to]: [f64; 2], growth: f64) -> Error {
        let name = AXES[self.axis];
        let [from, to, least] = [from, to, self.job.smallest(self.axis)].map(short_number);
        let message = format!(
            "cells of at least {least} along {name} cannot meet all ends with a growth of {growth}: none fit between the ends at {from} and {to}",
        );
        let hint = "allow smaller cells (min_size) or a larger growth, or let geometries there have larger cells; or move the ends, so that \
                    none are nearly equal";
        Error::new("lines-no-sizes", message, hint)
    }
}

/// The places of fixed lines, with two beside each edge of metal, and the interval that holds each edge.
fn places(fixed: &[Fixed], edges: &[Edge]) -> (Vec<f64>, Vec<usize>) {
    let (mut places, mut cells) = (Vec::with_capacity(fixed.len() + edges.len()), Vec::with_capacity(edges.len()));
    for (index, fixed) in fixed.iter().enumerate() {
        match edges.iter().find(|edge| edge.index == index) {
            None => places.push(fixed.at),
            Some(Edge { outwards, size, .. }) => {
                let [inside, outside] = [fixed.at - outwards * size / 3.0, fixed.at + outwards * size * 2.0 / 3.0];
                cells.push(places.len());
                places.extend([inside.min(outside), inside.max(outside)]);
            }
        }
    }
    (places, cells)
}

/// Adds cells at both ends, as large as those there.
fn add_layers(lines: &mut Vec<f64>, n: u32) {
    let last = lines.len() - 1;
    let (first, before) = (lines[0], lines[1] - lines[0]);
    let (end, after) = (lines[last], lines[last] - lines[last - 1]);
    lines.extend((1..=n).map(|k| end + f64::from(k) * after));
    lines.splice(0..0, (1..=n).rev().map(|k| first - f64::from(k) * before));
}

#[cfg(test)]
mod tests;
