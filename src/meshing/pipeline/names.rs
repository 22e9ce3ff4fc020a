//! The names of flags, and what their cells are made of.

use hexcast_core::base::error::{Error, Result};
use hexcast_core::derived::mesh::Named;
use hexcast_core::input::geometry::{Geometry, joined_names};
use hexcast_core::input::job::Job;
use hexcast_core::set;

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
    let named = |flag, name: String, material| set!(Named { material, ..Named::new(flag, name) });
    let of_flag = |of_flag: Vec<&Geometry>| {
        let name = joined_names(of_flag.iter().map(|geometry| &geometry.name[..]));
        named(of_flag[0].flag, name, of_flag[0].material)
    };
    let mut names: Vec<Named> = of_flags.into_iter().map(of_flag).collect();
    if let Some(background) = &job.background {
        let name = background.name.clone().unwrap_or_else(|| "background".into());
        names.push(named(0, name, background.material));
    }
    Ok(names)
}
