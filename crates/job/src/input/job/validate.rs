//! Checks of a job before anything is read: every value in its range, nothing asked for twice. Messages name the key.

use super::quoted::short_number;
use super::{Fill, FractionsMethod, Job, Padding, PerAxis, TensorsJob};
use crate::base::error::{Error, Result};
use crate::input::choices::check_n_geometries;

/// Most cells of a halo.
const MAX_HALO: u32 = 65_535;

impl Job {
    /// Checks all values.
    ///
    /// # Errors
    /// - `job-empty`: no geometry.
    /// - `too-many-geometries`: more than [`crate::input::choices::MAX_GEOMETRIES`].
    /// - `job-value`: a value out of range.
    /// - `job-conflict`: more than one way to choose the cells.
    pub fn validate(&self) -> Result<()> {
        if self.geometries.is_empty() {
            return Err(Error::new("job-empty", "the job names no geometry", "give at least one geometry"));
        }
        check_n_geometries(self.geometries.len(), "the job names")?;
        self.validate_geometries()?;
        self.validate_materials()?;
        self.validate_cells()?;
        self.validate_lines()?;
        self.validate_gaps()?;
        self.validate_window()?;
        self.validate_measured()?;
        if self.unit.as_ref().is_some_and(|unit| unit.trim().is_empty()) {
            return Err(out_of_range("unit", "empty", "a unit of lengths such as \"mm\", or none"));
        }
        self.validate_domain()
    }

    fn validate_gaps(&self) -> Result<()> {
        if let Some(width @ 0..2) = self.close_gaps {
            return Err(out_of_range("close_gaps", width, "at least 2; openings of fewer cells are closed"));
        }
        if self.gap_flag == Some(0) {
            return Err(out_of_range("gap_flag", 0, "1 to 255; 0 is the background"));
        }
        if self.gap_flag.is_some() && self.close_gaps.is_none() {
            let message = "gap_flag is given without close_gaps, the only key that uses it";
            return Err(Error::new("job-conflict", message, "remove gap_flag or give close_gaps"));
        }
        Ok(())
    }

    fn validate_window(&self) -> Result<()> {
        if let Some([i0, j0, k0, i1, j1, k1]) = self.window {
            for (name, first, end) in [("x", i0, i1), ("y", j0, j1), ("z", k0, k1)] {
                if first >= end {
                    let found = format!("cells {first} to {end} along {name}");
                    return Err(out_of_range("window", found, "the first cell before the end, which is exclusive"));
                }
            }
        }
        if let Some(part) = self.part.filter(|part| !(1..=part.n_parts()).contains(&part.index.into())) {
            let found = format!("{} of {} parts", part.index, part.n_parts());
            return Err(out_of_range("part", found, "an index from 1 to the number of parts"));
        }
        let given: Vec<&str> = [("window", self.window.is_some()), ("part", self.part.is_some())]
            .into_iter()
            .filter_map(|(key, is_given)| is_given.then_some(key))
            .collect();
        if let Some(halo) = self.halo.filter(|halo| *halo > MAX_HALO) {
            return Err(out_of_range("halo", halo, &format!("0 to {MAX_HALO} cells")));
        }
        if self.halo_edge.is_some() && self.halo.is_none() {
            let message = "halo_edge is given without halo, whose cells beyond the box it decides";
            return Err(Error::new("job-conflict", message, "give halo (--halo), or remove halo_edge"));
        }
        let Some(&key_of_window) = given.first() else {
            if self.halo.is_some() {
                let message = "halo is given without window or part, whose cells it goes around";
                return Err(Error::new(
                    "job-conflict",
                    message,
                    "remove halo, or use padding for space around geometries",
                ));
            }
            return Ok(());
        };
        if given.len() > 1 {
            let message = "window and part are given together: each says which cells are meshed";
            return Err(Error::new("job-conflict", message, "keep one of them"));
        }
        if self.close_gaps.is_some() {
            let message =
                format!("close_gaps and {key_of_window} are given together: close_gaps needs cells beyond these");
            return Err(Error::new("job-conflict", message, "mesh the whole box for close_gaps"));
        }
        Ok(())
    }

    fn validate_measured(&self) -> Result<()> {
        if self.links.as_ref().is_some_and(|links| links.fluid.is_empty()) {
            return Err(out_of_range("links.fluid", "[]", "the flags of the fluid, 0 for the background"));
        }
        if !self.periodic.is_empty() && self.links.is_none() {
            let message = "periodic is given without links, the only key that uses it";
            return Err(Error::new("job-conflict", message, "remove periodic or give links (--links FILE)"));
        }
        if !self.periodic.is_empty() && (self.window.is_some() || self.part.is_some()) {
            let message =
                "periodic is given with a window or part, which does not have the cells at the other side of the box";
            return Err(Error::new("job-conflict", message, "mesh the whole box, or leave out periodic"));
        }
        if !self.conductors.is_empty() && !self.staggered {
            let message = "conductors is given without staggered, the only key that uses it";
            return Err(Error::new("job-conflict", message, "remove conductors or give staggered (--staggered FILE)"));
        }
        if self.conductors.contains(&0) {
            let hint = "1 to 255: an inverted geometry with a flag of its own can be metal around all others";
            return Err(out_of_range("conductors", 0, hint));
        }
        let (conformal, tensors) = (self.conformal.is_some(), self.tensors.is_some());
        let on_lines = [("staggered", self.staggered), ("conformal", conformal), ("tensors", tensors)];
        for (name, is_asked) in on_lines.into_iter().chain([("distance", self.distance.is_some())]) {
            if is_asked && self.close_gaps.is_some() {
                let message = format!("{name} is given with close_gaps: it follows the surfaces, whose gaps stay open");
                return Err(Error::new("job-conflict", message, "keep one of them"));
            }
            if is_asked && self.halo.is_some_and(|halo| halo > 0) {
                let message = format!("{name} is given with a halo: only what is in the window or part can be written");
                let hint = "leave out halo: neighbouring windows share the points between them";
                return Err(Error::new("job-conflict", message, hint));
            }
        }
        if self.cut_cells.is_some() && (self.window.is_some() || self.part.is_some() || self.close_gaps.is_some()) {
            let message = "cut_cells is given with a window, a part or close_gaps: cells are cut of a whole box, whose gaps stay open";
            return Err(Error::new(
                "job-conflict",
                message,
                "leave out window, part and close_gaps, or cut_cells (--cut, .eb)",
            ));
        }
        let stable = self.conformal.as_ref().map_or(0.0, |conformal| conformal.stable);
        if !(0.0..=1.0).contains(&stable) {
            let hint = "0 to 1: the least area of a face, as a part of the fraction of its longest edge";
            return Err(out_of_range("conformal.stable", stable, hint));
        }
        let band = self.distance.as_ref().and_then(|distance| distance.band.cells());
        if let Some(band) = band.filter(|band| !(band.is_finite() && *band > 0.0)) {
            return Err(out_of_range("distance.band", short_number(band), "a number of cells above 0, or \"all\""));
        }
        self.tensors.as_ref().map_or(Ok(()), TensorsJob::validate)?;
        let Some(fractions) = self.fractions else { return Ok(()) };
        if let Some(rays) = fractions.rays.filter(|rays| !matches!(rays, 1 | 2 | 4 | 8 | 16)) {
            return Err(out_of_range("fractions.rays", rays, "1, 2, 4, 8 or 16 rays along each axis of a cell"));
        }
        if fractions.method == Some(FractionsMethod::Exact) && fractions.rays.is_some() {
            let message = "fractions.rays is given, but exact fractions are measured without rays";
            let hint = "leave out rays (--fraction-rays), or give the method \"rays\" (--fraction-method rays)";
            return Err(Error::new("job-conflict", message, hint));
        }
        if fractions.by_rays().is_some() && (fractions.edges || fractions.centroids) {
            let asked = if fractions.edges { "edges" } else { "centroids" };
            let message = format!("fractions.{asked} is given, which rays do not measure");
            let hint =
                "leave out rays and the method (--fraction-rays, --fraction-method): then they are measured exactly";
            return Err(Error::new("job-conflict", message, hint));
        }
        if self.close_gaps.is_some() {
            let message =
                "fractions are given with close_gaps: they are measured from the surfaces, whose gaps stay open";
            return Err(Error::new("job-conflict", message, "keep one of them"));
        }
        Ok(())
    }

    fn validate_geometries(&self) -> Result<()> {
        for (index, geometry) in self.geometries.iter().enumerate() {
            let key = |name: &str| format!("geometries[{index}].{name}");
            if geometry.file.is_empty() {
                return Err(out_of_range(&key("file"), "\"\"", "the name of a file"));
            }
            if geometry.flag == Some(0) {
                return Err(out_of_range(&key("flag"), "0", "1 to 255; 0 is the background"));
            }
            if self.splits(geometry) && (geometry.solid.is_some() || geometry.name.is_some()) {
                let message = format!("{} is true, and a solid or a name is given", key("split"));
                return Err(Error::new(
                    "job-conflict",
                    message,
                    "split takes all solids and names them as the file does",
                ));
            }
            if geometry.same_flag && !(self.splits(geometry) && geometry.flag.is_some()) {
                let message = format!("{} is true, but split or a flag is missing", key("same_flag"));
                return Err(Error::new(
                    "job-conflict",
                    message,
                    "give the flag that all solids of the file get, and split",
                ));
            }
            if geometry.shell && geometry.fill == Some(Fill::Centre) {
                let message = format!("{} is true, and fill is \"centre\": no cell would be left", key("shell"));
                return Err(Error::new("job-conflict", message, "fill a shell \"separating\" or \"conservative\""));
            }
            if geometry.shell && (self.invert || geometry.invert) {
                let message = format!("{} is true, and so is shell: a shell has no inside to invert", key("invert"));
                return Err(Error::new("job-conflict", message, "keep one of them"));
            }
            let scale = geometry.scale.map_or([1.0; 3], PerAxis::each);
            for value in scale {
                if !value.is_finite() || value == 0.0 {
                    return Err(out_of_range(&key("scale"), short_number(value), "a finite number other than 0"));
                }
            }
            if geometry.about.is_some() && geometry.rotate.is_none() {
                let message = format!("{} is given without rotate: nothing rotates about it", key("about"));
                return Err(Error::new(
                    "job-conflict",
                    message,
                    "give rotate, in degrees about x, y and z, or leave it out",
                ));
            }
            let placings = [("rotate", geometry.rotate), ("about", geometry.about), ("translate", geometry.translate)];
            for (name, values) in placings {
                for value in values.unwrap_or_default() {
                    if !value.is_finite() {
                        return Err(out_of_range(&key(name), short_number(value), "finite numbers"));
                    }
                }
            }
        }
        Ok(())
    }

    /// Checks all materials; geometries of one flag are one substance.
    fn validate_materials(&self) -> Result<()> {
        let background = self.background.iter().map(|background| ("background".to_string(), background.material));
        let geometries = self.geometries.iter().enumerate();
        let geometries = geometries.map(|(index, geometry)| (format!("geometries[{index}]"), geometry.material));
        for (key, material) in background.chain(geometries) {
            if let Some((name, value, allowed)) = material.out_of_range() {
                return Err(out_of_range(&format!("{key}.material.{name}"), short_number(value), allowed));
            }
        }
        Ok(())
    }

    fn validate_cells(&self) -> Result<()> {
        let ways = [
            ("cells", self.cells.is_some()),
            ("dims", self.dims.is_some()),
            ("cell_size", self.cell_size.is_some()),
            ("max_cell_size", self.max_cell_size.is_some()),
            ("lines", self.lines.is_some()),
            ("graded", self.graded.is_some()),
        ];
        let given: Vec<&str> = ways.iter().filter(|way| way.1).map(|way| way.0).collect();
        if given.len() > 1 {
            let message = format!("{} are given together: each by itself decides the cells", given.join(" and "));
            return Err(Error::new("job-conflict", message, "keep one of them"));
        }
        if self.cells == Some(0) {
            return Err(out_of_range("cells", 0, "at least 1"));
        }
        if self.thin_cells == Some(0) {
            return Err(out_of_range("thin_cells", 0, "at least 1"));
        }
        if self.max_cells == Some(0) {
            return Err(out_of_range("max_cells", 0, "at least 1"));
        }
        if let Some(dims) = self.dims.filter(|dims| dims.contains(&0)) {
            return Err(out_of_range("dims", format!("{dims:?}"), "at least 1 on every axis"));
        }
        let sizes = self.cell_size.map_or(vec![], |size| size.each().to_vec());
        for (key, value) in sizes
            .iter()
            .map(|&size| ("cell_size", size))
            .chain(self.max_cell_size.map(|s| ("max_cell_size", s)))
            .chain(self.deviation.map(|d| ("deviation", d)))
        {
            if !(value.is_finite() && value > 0.0) {
                return Err(out_of_range(key, short_number(value), "a positive number"));
            }
        }
        if let Some(tolerance) = self.tolerance {
            if !(0.0..=0.5).contains(&tolerance) {
                return Err(out_of_range("tolerance", short_number(tolerance), "0 to 0.5 cells"));
            }
            if self.max_cell_size.is_none() {
                let message = "tolerance is given without max_cell_size, the only key that uses it";
                return Err(Error::new("job-conflict", message, "remove tolerance or give max_cell_size"));
            }
        }
        Ok(())
    }

    fn validate_domain(&self) -> Result<()> {
        if let Some(domain) = self.domain {
            for axis in 0..3 {
                let (low, high) = (domain[axis], domain[axis + 3]);
                if !(low.is_finite() && high.is_finite() && low < high) {
                    let name = ["x", "y", "z"][axis];
                    let found = format!("{} to {} along {name}", short_number(low), short_number(high));
                    return Err(out_of_range("domain", found, "finite numbers, the first corner below the second"));
                }
            }
        }
        if let Some(Padding::Length(lengths)) = self.padding {
            for value in lengths.each() {
                if !(value.is_finite() && value >= 0.0) {
                    return Err(out_of_range("padding.length", short_number(value), "0 or a positive number"));
                }
            }
        }
        Ok(())
    }
}

pub(super) fn out_of_range(key: &str, found: impl std::fmt::Display, allowed: &str) -> Error {
    Error::new("job-value", format!("{key} is {found}; allowed: {allowed}"), "")
}
