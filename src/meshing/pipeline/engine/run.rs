//! What an engine runs: it meshes, or hands out crossings, on the GPU as long as that is there and right, then on the CPU.

use super::Engine;
use crate::meshing::estimate::{BandLimit, MemoryBudget};
use hexcast_core::base::control::Control;
#[cfg(feature = "gpu")]
use hexcast_core::base::error::Error;
use hexcast_core::base::error::Result;
use hexcast_core::cells::columns::{Band, Columns, ColumnsBuilder};
use hexcast_core::grid::rays::Rays;
use hexcast_core::input::job::Rule;
use hexcast_core::open_surfaces::overlay::Overlay;
use hexcast_core::stages::axis_crossings::{AxisCasts, AxisCrossings, Collected};
use hexcast_core::stages::cast::Cast;
use hexcast_core::stages::cpu;
use hexcast_core::stages::crossings::Crossings;
#[cfg(feature = "gpu")]
use hexcast_gpu::{Gpu, Options, Usage, instance};

/// Times that a lost device is opened again.
#[cfg(feature = "gpu")]
const MAX_REOPENINGS: u32 = 3;

/// Memory that meshing used, besides facets and columns, and what the check of the device found.
#[derive(Debug, Default, Clone, Copy)]
pub struct Used {
    /// Most bytes on the device.
    pub device_bytes: u64,
    /// Most bytes on the host.
    pub host_bytes: u64,
    /// Rays of the GPU's that the CPU cast again, and those of them whose cells differed; None if no GPU meshed.
    pub checked: Option<[u64; 2]>,
}

impl Used {
    /// That of two things, one after the other.
    pub(crate) fn and(self, other: Used) -> Used {
        let sum = |[a, b]: [u64; 2], [c, d]: [u64; 2]| [a + c, b + d];
        Used {
            device_bytes: self.device_bytes.max(other.device_bytes),
            host_bytes: self.host_bytes.max(other.host_bytes),
            checked: self
                .checked
                .map_or(other.checked, |checked| Some(sum(checked, other.checked.unwrap_or_default()))),
        }
    }
}

impl Engine {
    /// Meshes a frame; also returns the memory used.
    ///
    /// # Errors
    /// `cancelled`; `device-lost` when the device was lost too often, or for good, and there is no CPU fallback.
    #[doc(hidden)]
    pub async fn columns(&mut self, cast: &Cast<'_>, control: &Control) -> Result<(Columns, Used)> {
        let mut builder = ColumnsBuilder::new(*cast.rays, u64::MAX, None);
        let used =
            self.build(cast, &MemoryBudget::unlimited(cast.rays, u64::MAX), &mut builder, &mut None, control).await?;
        Ok((builder.finish()?, used))
    }

    /// Casts all rays at a frame and hands out their crossings, some rows of rays after the other; with their facets, if asked. A GPU
    /// keeps to the limits.
    ///
    /// # Errors
    /// Those of [`Engine::columns`].
    #[doc(hidden)]
    pub async fn crossings(
        &mut self,
        cast: &Cast<'_>,
        with_facets: bool,
        #[cfg_attr(not(feature = "gpu"), expect(unused_variables, reason = "they are those of a GPU"))]
        limits: BandLimit,
        control: &Control,
        take: &mut impl FnMut(Vec<Crossings>),
    ) -> Result<Used> {
        let n_i = cast.rays.counts[0];
        #[cfg_attr(not(feature = "gpu"), expect(unused_mut))]
        let (mut n_rows, mut used) = (0u32, Used::default());
        #[cfg(feature = "gpu")]
        {
            let mut attempts = Attempts::new(cast, limits);
            while let Some(gpu) = &self.gpu {
                let rows = n_rows..cast.rays.counts[1];
                let take = &mut |more: Vec<Crossings>| {
                    n_rows += more.iter().map(|crossings| (crossings.offsets.len() - 1) as u32 / n_i).sum::<u32>();
                    take(more);
                };
                let (options, usage) = (&attempts.options, &mut attempts.usage);
                let result = gpu.crossings(cast, (options, with_facets), control, rows, usage, take).await;
                if attempts.is_done(self, result, &mut used).await? {
                    return Ok(used);
                }
            }
        }
        let mut strips = cpu::Strips::new(cast, None).at_ray(u64::from(n_rows) * u64::from(n_i));
        while let Some(crossings) = strips.crossings(with_facets, control)? {
            take(crossings);
            control.pause().await;
        }
        Ok(Used { host_bytes: used.host_bytes.max(strips.n_bytes()), ..used })
    }

    /// Casts the rays that decide something apart from the rays of the mesh, `main`. A GPU keeps to the limits.
    ///
    /// # Errors
    /// Those of [`Engine::columns`].
    pub(crate) async fn axis_crossings(
        &mut self,
        casts: &[AxisCasts],
        main: &Rays,
        limits: BandLimit,
        control: &Control,
    ) -> Result<(Vec<AxisCrossings>, Used)> {
        let (mut found, mut used) = (Vec::new(), Used::default());
        for AxisCasts { frame, axes } in casts {
            for &(axis, is_counted) in axes {
                let rays = Rays::new(axis, frame.dims);
                // the crossings are the same under either rule
                let cast = Cast { frame, rays: &rays, rule: Rule::Parity };
                let mut collected = Collected::default();
                let take = &mut |more| collected.add(more, &rays, main, is_counted);
                used = used.and(self.crossings(&cast, false, limits, control, take).await?);
                found.push(collected.in_order());
            }
        }
        Ok((found, used))
    }

    /// Meshes the rays after those that the builder has, and puts open geometries over them. Each band is packed, and spills if it
    /// must, while a GPU works on the next.
    ///
    /// # Errors
    /// Those of [`Engine::columns`] and [`ColumnsBuilder::push`]; the builder keeps what was finished before.
    pub(crate) async fn build(
        &mut self,
        cast: &Cast<'_>,
        budget: &MemoryBudget,
        builder: &mut ColumnsBuilder,
        overlay: &mut Option<Overlay>,
        control: &Control,
    ) -> Result<Used> {
        #[cfg_attr(not(feature = "gpu"), expect(unused_mut))]
        let mut used = Used::default();
        #[cfg(feature = "gpu")]
        {
            let mut attempts = Attempts::new(cast, budget.bands);
            // what the GPU has finished before it fails stays: it was checked
            while let Some(gpu) = &self.gpu {
                let first_row = (builder.n_rays() / u64::from(cast.rays.counts[0])) as u32;
                let rows = first_row..cast.rays.counts[1];
                let take = &mut |band: Band| builder.push(laid(overlay, vec![band])?);
                let (options, usage) = (&attempts.options, &mut attempts.usage);
                let result = gpu.hand_out_bands(cast, options, control, rows, usage, take).await;
                if attempts.is_done(self, result, &mut used).await? {
                    return Ok(used);
                }
            }
        }
        let strips = cpu::Strips::new(cast, None).in_rounds_of(budget.most_strips);
        let mut strips = strips.at_ray(builder.n_rays());
        while let Some(bands) = strips.round(control)? {
            builder.push(laid(overlay, bands)?)?;
            control.pause().await;
        }
        Ok(Used { host_bytes: used.host_bytes.max(strips.n_bytes()), ..used })
    }
}

/// What is run on the GPU, in bands that keep to the limits, and again on a new device where that is lost; each time it goes on where it
/// stopped.
#[cfg(feature = "gpu")]
struct Attempts {
    options: Options,
    usage: Usage,
    reopenings: u32,
}

#[cfg(feature = "gpu")]
impl Attempts {
    fn new(cast: &Cast, limits: BandLimit) -> Attempts {
        let most_rows = u32::try_from(limits.n_rays / u64::from(cast.rays.counts[0])).unwrap_or(u32::MAX).max(1);
        let (most_rows, max_bytes) = (Some(most_rows), Some(limits.device_bytes));
        let options = Options { most_rows, max_bytes, ..Options::default() };
        Attempts { options, usage: Usage { rows_of_band: 64, ..Usage::default() }, reopenings: 0 }
    }

    /// Whether an attempt with this result was the last that is needed. If not, the engine has a new device, or none where the CPU shall
    /// go on.
    async fn is_done(&mut self, engine: &mut Engine, result: Result<()>, used: &mut Used) -> Result<bool> {
        let usage = &self.usage;
        *used = Used { device_bytes: usage.peak_bytes, host_bytes: usage.host_bytes, checked: Some(usage.checked) };
        let Err(mut error) = result else { return Ok(true) };
        // no other device has what the caller has on its own
        let is_callers = engine.gpu.as_ref().is_some_and(Gpu::is_callers);
        if error.code() == "device-lost" && !is_callers && self.reopenings < MAX_REOPENINGS {
            self.reopenings += 1;
            self.options.rows_per_band = Some((usage.rows_of_band / 2).max(1));
            let instance = engine.instance.get_or_insert_with(instance);
            match Gpu::open_in(instance, engine.wanted_adapter.as_deref(), None).await {
                Ok(gpu) => {
                    engine.gpu = Some(gpu);
                    return Ok(false);
                }
                Err(again) => error = lost_for_good(&error, &again),
            }
        }
        if error.code() == "device-wrong" || engine.has_cpu_fallback && error.code() == "device-lost" {
            engine.gpu = None;
            (engine.fallback, engine.has_failed) = (Some(error.to_string()), true);
            return Ok(false);
        }
        Err(error)
    }
}

/// Bands with the open geometries put over them, if there are any.
fn laid(overlay: &mut Option<Overlay>, bands: Vec<Band>) -> Result<Vec<Band>> {
    match overlay {
        Some(overlay) => overlay.lay(bands),
        None => Ok(bands),
    }
}

/// The error of a device that was lost and cannot be opened again.
#[cfg(feature = "gpu")]
fn lost_for_good(lost: &Error, again: &Error) -> Error {
    Error::new("device-lost", format!("{lost}; opening it again: {again}"), lost.hint())
}
