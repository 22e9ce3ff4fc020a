//! The names of flags, and what their cells are made of.

use crate::error::{Error, Result};
use crate::geometry::Geometry;
use crate::job::Job;
use crate::mesh::Named;

/// One name a flag: those of its geometries; flag 0 has one where the job names it.
///
/// # Errors
/// `job-conflict` where geometries of one flag have different materials.
pub(super) fn names(job: &Job, geometries: &[Geometry]) -> Result<Vec<Named>> {
    let mut names: Vec<Named> = Vec::new();
    for geometry in geometries {
        match names.iter_mut().find(|named| named.flag == geometry.flag) {
            Some(named) if named.material != geometry.material => {
                let message = format!(
                    "\"{}\" and \"{}\" have flag {} and different materials",
                    named.name, geometry.name, geometry.flag
                );
                return Err(Error::new("job-conflict", message, "give them different flags, or the same material"));
            }
            Some(named) => named.name = format!("{} + {}", named.name, geometry.name),
            None => names.push(Named { flag: geometry.flag, name: geometry.name.clone(), material: geometry.material }),
        }
    }
    if let Some(background) = &job.background {
        let name = background.name.clone().unwrap_or_else(|| "background".into());
        names.push(Named { flag: 0, name, material: background.material });
    }
    Ok(names)
}
