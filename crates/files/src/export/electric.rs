//! What flags are made of, for programs that compute electromagnetic fields.

use hexcast_core::base::error::{Error, Result};
use hexcast_derived::mesh::{Mesh, Named};

use super::names::said;

/// A substance in a field.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Electric {
    pub(super) eps_r: f64,
    pub(super) mu_r: f64,
    /// S/m.
    pub(super) sigma: f64,
    /// A perfect electric conductor: the other numbers do not matter.
    pub(super) pec: bool,
    /// kg/m3.
    pub(super) density: Option<f64>,
}

/// The substance of a flag; what the job leaves out is that of vacuum. None where it says nothing that matters to a field.
pub(super) fn electric(names: &[Named], flag: u8) -> Option<Electric> {
    let material = names.iter().find(|named| named.flag == flag)?.material;
    let is_known = material.pec || [material.eps_r, material.mu_r, material.sigma].iter().any(Option::is_some);
    is_known.then(|| Electric {
        eps_r: material.eps_r.unwrap_or(1.0),
        mu_r: material.mu_r.unwrap_or(1.0),
        sigma: material.sigma.unwrap_or(0.0),
        pec: material.pec,
        density: material.density,
    })
}

/// Flags, with what they are made of.
///
/// # Errors
/// `export-material` where the job does not say it of one.
pub(super) fn substances(names: &[Named], flags: &[u8], what: &str) -> Result<Vec<(u8, Electric)>> {
    let missing = |flag| {
        let message =
            format!("{what} needs to know what {} is made of, and the job does not say it", said(names, flag));
        let hint = "say it with eps_r, mu_r, sigma or pec: on the command line FILE:eps_r=2.2, in a job material = { eps_r = 2.2 }, \
                    of flag 0 under [background]; or leave the flag out (--export-flags)";
        Error::new("export-material", message, hint)
    };
    flags.iter().map(|&flag| Ok((flag, electric(names, flag).ok_or_else(|| missing(flag))?))).collect()
}

/// Refuses a background that is a perfect conductor and is not exported.
///
/// # Errors
/// `job-conflict`.
pub(super) fn check_background(mesh: &Mesh, keeps: &[bool; 256], what: &str) -> Result<()> {
    let has_background = !keeps[0] && mesh.columns().cells_per_flag()[0] > 0;
    if has_background && electric(mesh.names(), 0).is_some_and(|background| background.pec) {
        let message =
            format!("the background is a perfect conductor, but {what} has conductors of exported flags only");
        return Err(Error::new("job-conflict", message, "export flag 0, too (--export-flags 0,1,...)"));
    }
    Ok(())
}
