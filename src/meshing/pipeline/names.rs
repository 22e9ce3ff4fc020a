//! The names of flags, and what their cells are made of.

use crate::base::error::{Error, Result};
use crate::derived::mesh::Named;
use crate::input::geometry::{Geometry, joined_names};
use crate::input::job::Job;

/// One name a flag: those of its geometries; flag 0 has one where the job names it.
///
/// # Errors
/// `job-conflict` where geometries of one flag have different materials.
pub(super) fn names(job: &Job, geometries: &[Geometry]) -> Result<Vec<Named>> {
    let mut of_flags: Vec<Vec<&Geometry>> = Vec::new();
    for geometry in geometries {
        match of_flags.iter_mut().find(|others| others[0].flag == geometry.flag) {
            Some(others) if others[0].material != geometry.material => {
                let message = format!(
                    "\"{}\" and \"{}\" have flag {} and different materials",
                    others[0].name, geometry.name, geometry.flag
                );
                return Err(Error::new("job-conflict", message, "give them different flags, or the same material"));
            }
            Some(others) => others.push(geometry),
            None => of_flags.push(vec![geometry]),
        }
    }
    let named = |of_flag: Vec<&Geometry>| Named {
        flag: of_flag[0].flag,
        name: joined_names(of_flag.iter().map(|geometry| &geometry.name[..])),
        material: of_flag[0].material,
    };
    let mut names: Vec<Named> = of_flags.into_iter().map(named).collect();
    if let Some(background) = &job.background {
        let name = background.name.clone().unwrap_or_else(|| "background".into());
        names.push(Named { flag: 0, name, material: background.material });
    }
    Ok(names)
}
