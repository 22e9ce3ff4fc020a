//! Checks of what decides lines that are not equally spaced.

use super::lines_job::GradedJob;
use super::quoted::short_number;
use super::validate::out_of_range;
use super::{Job, Padding, PerAxis};
use crate::base::error::{Error, Result};
use crate::input::choices::Sizing;

/// Most cells of an absorbing layer.
const MAX_ABSORBING: u32 = 1024;

impl GradedJob {
    fn validate(&self) -> Result<()> {
        for value in self.max_size.each() {
            if !(value.is_finite() && value > 0.0) {
                return Err(out_of_range("graded.max_size", short_number(value), "a positive number"));
            }
            if let Some(least) = self.min_size.filter(|least| !(*least > 0.0 && *least <= value)) {
                let allowed = format!("above 0, at most max_size, {}", short_number(value));
                return Err(out_of_range("graded.min_size", short_number(least), &allowed));
            }
        }
        if let Some(growth) = self.growth.filter(|growth| !(*growth >= 1.01 && *growth <= 10.0)) {
            return Err(out_of_range("graded.growth", short_number(growth), "1.01 to 10"));
        }
        let layers = self.absorbing.map_or([0; 3], PerAxis::each);
        if let Some(most) = layers.into_iter().find(|cells| *cells > MAX_ABSORBING) {
            return Err(out_of_range("graded.absorbing", most, &format!("0 to {MAX_ABSORBING} cells")));
        }
        Ok(())
    }
}

impl Job {
    /// Checks what decides lines that are not equally spaced.
    pub(super) fn validate_lines(&self) -> Result<()> {
        let conflict = |message: &str, hint: &str| Err(Error::new("job-conflict", message, hint));
        if let Some(graded) = &self.graded {
            graded.validate()?;
        }
        for (index, geometry) in self.geometries.iter().enumerate() {
            let key = |name: &str| format!("geometries[{index}].{name}");
            if let Some(size) = geometry.max_size.filter(|size| !(size.is_finite() && *size > 0.0)) {
                return Err(out_of_range(&key("max_size"), short_number(size), "a positive number"));
            }
            if geometry.min_cells == Some(0) {
                return Err(out_of_range(&key("min_cells"), 0, "at least 1"));
            }
            if geometry.sizing() != Sizing::default() && self.graded.is_none() {
                let message =
                    format!("geometries[{index}] has max_size, min_cells or metal, and the job has no graded");
                return conflict(&message, "give graded (--graded), the only key that uses them");
            }
        }
        if self.lines.is_some() && (self.domain.is_some() || self.padding.is_some()) {
            let message = "lines are given together with domain or padding: the first and the last line are the domain";
            return conflict(message, "leave out domain and padding");
        }
        if self.graded.is_some() && matches!(self.padding, Some(Padding::Cells(_))) {
            let message = "graded and padding by cells are given together: cells differ in size";
            return conflict(message, "use graded.absorbing for cells of the size at the ends, or padding by length");
        }
        Ok(())
    }
}
