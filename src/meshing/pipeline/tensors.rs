//! The smoothed permittivity at the points of E: what flags are made of, and the cells around points, cut exactly.

use super::backend::Backend;
use super::prepare::{Prepared, Task};
use super::staggered::{Bodies, metal};
use super::surfaces::{Uncut, is_flat};
use hexcast_core::base::error::{Error, Result};
use hexcast_core::grid::frame::Frame;
use hexcast_core::input::job::{Job, TensorsJob};
use hexcast_derived::cut_cells::CutBy;
use hexcast_derived::cut_cells::tensors::{OfFlags, TensorCounts, Tensors, isotropic, permittivity};
use hexcast_derived::staggered::{COMPONENTS, check_dims};

/// The components of E among all.
const ELECTRIC: usize = 3;

impl Uncut {
    /// The smoothed permittivity at the points of E that a job asks for.
    ///
    /// # Errors
    /// Those of [`of_flags`] and [`permittivity`]; `job-conflict` where a geometry without a volume is no metal; `memory` where columns would take more than there is.
    pub(super) async fn tensors(
        &self,
        task: &Task<'_>,
        max_bytes: u64,
        backend: &mut Backend<'_>,
    ) -> Result<Option<Tensors>> {
        let &Task { job, prepared, .. } = task;
        let Some(asked) = &job.tensors else { return Ok(None) };
        check_dims(self.frame.dims, "tensors")?;
        let eps = of_flags(asked, job, prepared)?;
        self.check_volumes(&eps, prepared)?;
        let window = prepared.cell_window();
        let cells = [window.first, window.end];
        let control = &backend.control.without_progress();
        let mut backend = backend.with_control(control);
        let bodies = self.bodies(prepared, |_| true);
        // this frame, the two made of it, that around points, one that is cast or in a mirror, and the facets by planes
        let mut left = max_bytes.saturating_sub(6 * 38 * self.frame.facets.len() as u64);
        let (kinds, is_oriented) = (bodies.kinds(prepared), self.are_oriented());
        let (mut parts, mut counts) = (Vec::with_capacity(ELECTRIC), TensorCounts::default());
        for (component, (_, is_moved)) in COMPONENTS.into_iter().enumerate().take(ELECTRIC) {
            let codes = self.points(task, (&bodies, cells, is_moved), left, &mut backend).await?;
            left = left.saturating_sub(codes.n_bytes());
            let frame = &bodies.of_flags().around_faces(is_moved);
            let (lines, kinds, is_oriented) = (&prepared.whole, &kinds[..], &is_oriented[..]);
            let by = CutBy { frame, lines, rule: job.rule, kinds, is_oriented };
            let (part, more) = permittivity(by, (component, cells), (&eps, codes), (left, control)).await?;
            left = left.saturating_sub(part.n_bytes());
            counts.add(more);
            parts.push(part);
        }
        Ok(Some(Tensors::new(parts, window.first, counts)))
    }

    /// Refuses geometries whose permittivity has no volume to be averaged over.
    ///
    /// # Errors
    /// `job-conflict`.
    fn check_volumes(&self, eps: &OfFlags, prepared: &Prepared) -> Result<()> {
        for (position, &index) in self.frame.ranks.geometry_at.iter().enumerate() {
            let geometry = &prepared.geometries[index];
            let has_none = geometry.shell || is_flat(&self.frame, position) && !geometry.invert;
            if has_none && eps[usize::from(geometry.flag)].is_some() {
                let message =
                    format!("geometry \"{}\" has no volume over which tensors could average its eps_r", geometry.name);
                let hint = "give it a thickness and leave out shell, or leave it out of this job";
                return Err(Error::new("job-conflict", message, hint));
            }
        }
        Ok(())
    }
}

/// The permittivity of each flag. Metal is what it is for `conformal`.
///
/// # Errors
/// `no-permittivity` where a geometry has none; `job-value` where a flag is none of the job's; those of [`metal`].
fn of_flags(asked: &TensorsJob, job: &Job, prepared: &Prepared) -> Result<OfFlags> {
    let is_metal = job.conformal.as_ref().map(|conformal| metal(conformal, prepared)).transpose()?;
    let is_metal = is_metal.unwrap_or([false; 256]);
    let mut eps = [Some(isotropic(1.0)); 256];
    for named in &prepared.names {
        let flag = usize::from(named.flag);
        let has_own = asked.anisotropic.iter().any(|of| of.flag == named.flag);
        match named.material.eps_r {
            _ if is_metal[flag] || has_own => {}
            _ if named.material.pec => {
                let message = format!("flag {flag} ({}) is a perfect conductor, which has no permittivity", named.name);
                let hint = "ask for conformal (--conformal FILE), too, which has the metal: tensors then are those of what lies outside it";
                return Err(Error::new("no-permittivity", message, hint));
            }
            Some(number) => eps[flag] = Some(isotropic(number)),
            // the background is vacuum by default
            None if flag == 0 => {}
            None => {
                let message = format!("flag {flag} ({}) has no permittivity, of which tensors are made", named.name);
                let hint = "give its material eps_r (FILE:eps_r=2.2), or name metal for conformal (--conformal FILE --metal FLAGS)";
                return Err(Error::new("no-permittivity", message, hint));
            }
        }
    }
    for of in &asked.anisotropic {
        if of.flag > 0 && !prepared.geometries.iter().any(|geometry| geometry.flag == of.flag) {
            let message = format!("no geometry has flag {}, which tensors.anisotropic names", of.flag);
            return Err(Error::new("job-value", message, "name flags of geometries, or 0 for the background"));
        }
        eps[usize::from(of.flag)] = Some(of.eps_r);
    }
    (0..).zip(is_metal).filter(|(_, is_metal)| *is_metal).for_each(|(flag, _): (usize, _)| eps[flag] = None);
    Ok(eps)
}

impl Bodies {
    /// The facets of bodies, with flags in place of codes.
    fn of_flags(&self) -> Frame {
        let mut frame = self.frame.clone();
        frame.ranks.flag_of_rank.clone_from(&self.flags);
        frame
    }
}
