//! What flags are made of, for programs that compute electromagnetic fields.

use crate::error::{Error, Result};
use crate::mesh::Mesh;

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
pub(super) fn electric(mesh: &Mesh, flag: usize) -> Option<Electric> {
    let named = mesh.names.iter().find(|named| usize::from(named.flag) == flag)?;
    let material = named.material;
    let is_known = material.pec || [material.eps_r, material.mu_r, material.sigma].iter().any(Option::is_some);
    is_known.then(|| Electric {
        eps_r: material.eps_r.unwrap_or(1.0),
        mu_r: material.mu_r.unwrap_or(1.0),
        sigma: material.sigma.unwrap_or(0.0),
        pec: material.pec,
        density: material.density,
    })
}

/// The kept flags that have cells, with what they are made of.
///
/// # Errors
/// `export-material` where the job does not say it of one; `job-conflict` where the background is a perfect conductor, and not kept.
pub(super) fn kept(mesh: &Mesh, keeps: &[bool; 256], what: &str) -> Result<Vec<(usize, Electric)>> {
    let cells = mesh.columns.cells_per_flag();
    if !keeps[0] && cells[0] > 0 && electric(mesh, 0).is_some_and(|background| background.pec) {
        let message =
            format!("the background is a perfect conductor, but {what} has conductors of exported flags only");
        return Err(Error::new("job-conflict", message, "export flag 0, too (--export-flags 0,1,...)"));
    }
    let flags = (0..256).filter(|&flag| keeps[flag] && cells[flag] > 0);
    flags
        .map(|flag| {
            let found = electric(mesh, flag);
            let missing = || {
                let named = mesh.names.iter().find(|named| usize::from(named.flag) == flag);
                let name = named.map_or(String::new(), |named| format!(" (\"{}\")", named.name));
                let message = format!("{what} needs to know what flag {flag}{name} is made of, and the job does not say it");
                let hint = "say it with eps_r, mu_r, sigma or pec: on the command line FILE:eps_r=2.2, in a job material = { eps_r = 2.2 }, \
                            of flag 0 under [background]; or leave the flag out (--export-flags)";
                Error::new("export-material", message, hint)
            };
            Ok((flag, found.ok_or_else(missing)?))
        })
        .collect()
}
