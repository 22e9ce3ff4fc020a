//! The backend: the GPU or the CPU, chosen once, used for many meshes.

use web_time::Instant;

use crate::axis_crossings::{AxisCasts, AxisCrossings, Collected};
use crate::cast::Cast;
use crate::columns::{Band, Columns, ColumnsBuilder};
use crate::control::Control;
use crate::cpu;
use crate::crossings::Crossings;
#[cfg(feature = "gpu")]
use crate::error::Error;
use crate::error::Result;
#[cfg(feature = "gpu")]
use crate::estimate::UPLOAD_FACET_BYTES;
use crate::estimate::{Device, MemoryBudget};
#[cfg(feature = "gpu")]
use crate::gpu::{AdapterKind, Gpu, Instance, Options, Usage, instance};
use crate::job::{BackendChoice, Rule};
use crate::overlay::Overlay;
use crate::rays::Rays;

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
    pub(super) fn and(self, other: Used) -> Used {
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

/// An open backend.
pub struct Engine {
    #[cfg(feature = "gpu")]
    gpu: Option<Gpu>,
    #[cfg(feature = "gpu")]
    wanted_adapter: Option<String>,
    /// Where a lost device is opened again, if not where the system has its drivers.
    #[cfg(feature = "gpu")]
    instance: Option<Instance>,
    /// Whether the CPU continues where the GPU is lost for good. Where the GPU is wrong the CPU always does.
    #[cfg(feature = "gpu")]
    has_cpu_fallback: bool,
    /// Why the CPU meshes although a GPU was looked for, or had begun.
    pub fallback: Option<String>,
    /// Seconds that opening took.
    pub seconds: f64,
}

impl Engine {
    /// Prepares the CPU backend.
    pub fn cpu() -> Engine {
        Engine {
            #[cfg(feature = "gpu")]
            gpu: None,
            #[cfg(feature = "gpu")]
            wanted_adapter: None,
            #[cfg(feature = "gpu")]
            instance: None,
            #[cfg(feature = "gpu")]
            has_cpu_fallback: false,
            fallback: None,
            seconds: 0.0,
        }
    }

    /// Opens the backend of a job; `adapter` is a part of the name of the GPU to use, where there are several. With `Auto`
    /// and no such name the CPU takes over where no GPU can be opened, or only one that computes on the processor, which is slower, and
    /// later where it is lost for good; `fallback` then says why.
    ///
    /// # Errors
    /// `no-adapter`, `device-failed`, `device-wrong`: only if the GPU was asked for.
    pub async fn open(choice: BackendChoice, adapter: Option<&str>) -> Result<Engine> {
        if choice == BackendChoice::Cpu {
            return Ok(Engine::cpu());
        }
        let start = Instant::now();
        let engine = if choice == BackendChoice::Auto && adapter.is_none() {
            match Engine::open_hardware().await {
                Ok(engine) => engine.with_cpu_fallback(),
                Err(error) => Engine { fallback: Some(error.to_string()), ..Engine::cpu() },
            }
        } else {
            Engine::open_gpu(adapter).await?
        };
        Ok(Engine { seconds: start.elapsed().as_secs_f64(), ..engine })
    }

    /// Lets the CPU take over where the GPU is lost for good.
    pub fn with_cpu_fallback(self) -> Engine {
        Engine {
            #[cfg(feature = "gpu")]
            has_cpu_fallback: true,
            ..self
        }
    }

    /// Opens the preferred GPU unless it is a driver that computes on the processor. In browsers `www/adapter.js` knows that, and has asked.
    async fn open_hardware() -> Result<Engine> {
        #[cfg(all(feature = "gpu", not(target_arch = "wasm32")))]
        {
            let facts = crate::gpu::adapter(None).await?;
            if facts.kind == AdapterKind::Software {
                let message = format!("{facts} computes on the processor, where the CPU backend is faster");
                return Err(Error::new("no-adapter", message, "choose the GPU backend to use it nevertheless"));
            }
        }
        Engine::open_gpu(None).await
    }

    #[cfg(feature = "gpu")]
    async fn open_gpu(adapter: Option<&str>) -> Result<Engine> {
        let gpu = Gpu::open(adapter).await?;
        Ok(Engine { gpu: Some(gpu), wanted_adapter: adapter.map(String::from), ..Engine::cpu() })
    }

    /// Opens the backend of a job as [`Engine::open`] does, with the adapters of an instance of the caller's.
    ///
    /// # Errors
    /// Those of [`Engine::open`].
    #[cfg(all(feature = "web", target_arch = "wasm32"))]
    pub(crate) async fn open_in(instance: Instance, choice: BackendChoice) -> Result<Engine> {
        if choice == BackendChoice::Cpu {
            return Ok(Engine::cpu());
        }
        let start = Instant::now();
        let is_auto = choice == BackendChoice::Auto;
        let engine = match Gpu::open_in(&instance, None, None).await {
            Ok(gpu) => Engine { gpu: Some(gpu), instance: Some(instance), has_cpu_fallback: is_auto, ..Engine::cpu() },
            Err(error) if is_auto => Engine { fallback: Some(error.to_string()), ..Engine::cpu() },
            Err(error) => return Err(error),
        };
        Ok(Engine { seconds: start.elapsed().as_secs_f64(), ..engine })
    }

    /// Prepares a GPU that the caller has opened. Where its device is lost, one of an adapter of the same name takes its place;
    /// there being none is an error, unless [`Engine::with_cpu_fallback`] says otherwise.
    #[cfg(feature = "gpu")]
    pub fn with_gpu(gpu: Gpu) -> Engine {
        let wanted_adapter = Some(gpu.facts.name.clone());
        Engine { gpu: Some(gpu), wanted_adapter, ..Engine::cpu() }
    }

    #[cfg(not(feature = "gpu"))]
    async fn open_gpu(_: Option<&str>) -> Result<Engine> {
        Err(crate::error::Error::new("no-adapter", "this build has no GPU backend", "build with the feature gpu"))
    }

    /// "gpu" or "cpu".
    pub fn backend(&self) -> &'static str {
        if self.adapter().is_some() { "gpu" } else { "cpu" }
    }

    /// Name and driver of the GPU; None on the CPU.
    pub fn adapter(&self) -> Option<(&str, &str)> {
        #[cfg(feature = "gpu")]
        return self.gpu.as_ref().map(|gpu| (gpu.facts.name.as_str(), gpu.facts.driver.as_str()));
        #[cfg(not(feature = "gpu"))]
        None
    }

    /// Whether the GPU is a driver that computes on the processor.
    pub fn is_software(&self) -> bool {
        #[cfg(feature = "gpu")]
        return self.gpu.as_ref().is_some_and(|gpu| gpu.facts.kind == AdapterKind::Software);
        #[cfg(not(feature = "gpu"))]
        false
    }

    /// Whose memory holds the buffers. Drivers on the processor, and GPUs on its chip, have them in the host's memory.
    pub fn device(&self) -> Device {
        #[cfg(feature = "gpu")]
        if let Some(gpu) = &self.gpu {
            return if gpu.facts.kind.shares_memory() { Device::Shared } else { Device::Own };
        }
        Device::None
    }

    /// Frees the buffers that wait on the device for the next mesh if they have more than so many bytes.
    pub fn clear_pool_over(&self, max_bytes: u64) {
        #[cfg(feature = "gpu")]
        if let Some(gpu) = &self.gpu {
            gpu.clear_pool_over(max_bytes);
        }
        #[cfg(not(feature = "gpu"))]
        let _ = max_bytes;
    }

    /// Meshes a frame; also returns the memory used.
    ///
    /// # Errors
    /// `cancelled`; `device-lost` when the device was lost too often, or for good, and there is no CPU fallback.
    pub async fn columns(&mut self, cast: &Cast<'_>, control: &Control) -> Result<(Columns, Used)> {
        let mut builder = ColumnsBuilder::new(*cast.rays, u64::MAX, None);
        let used = self.build(cast, &MemoryBudget::unlimited(cast.rays), &mut builder, &mut None, control).await?;
        Ok((builder.finish()?, used))
    }

    /// Casts all rays at a frame and hands out their crossings, some rows of rays after the other; with their facets, if asked. A GPU
    /// casts at most so many rays at once.
    ///
    /// # Errors
    /// Those of [`Engine::columns`].
    pub async fn crossings(
        &mut self,
        cast: &Cast<'_>,
        with_facets: bool,
        most_rays: u64,
        control: &Control,
        take: &mut impl FnMut(Vec<Crossings>),
    ) -> Result<Used> {
        let n_i = cast.rays.counts[0];
        #[cfg_attr(not(feature = "gpu"), expect(unused_mut))]
        let (mut n_rows, mut used) = (0, Used::default());
        #[cfg(feature = "gpu")]
        {
            let most_rows = u32::try_from(most_rays / u64::from(n_i)).unwrap_or(u32::MAX).max(1);
            let run = async |gpu: &Gpu, options: &Options, usage: &mut Usage| {
                let rows = n_rows..cast.rays.counts[1];
                let take = &mut |more: Vec<Crossings>| {
                    n_rows += more.iter().map(|crossings| (crossings.offsets.len() - 1) as u32 / n_i).sum::<u32>();
                    take(more);
                };
                gpu.crossings(cast, (options, with_facets), control, rows, usage, take).await
            };
            if self.on_gpu(most_rows, &mut used, run).await? {
                return Ok(used);
            }
        }
        let mut strips = cpu::Strips::new(cast, None).from_ray(u64::from(n_rows) * u64::from(n_i));
        while let Some(crossings) = strips.crossings(with_facets, control)? {
            take(crossings);
            control.pause().await;
        }
        Ok(Used { host_bytes: used.host_bytes.max(strips.n_bytes()), ..used })
    }

    /// Casts the rays that decide something apart from the rays of the mesh, `main`. A GPU casts at most so many at once.
    ///
    /// # Errors
    /// Those of [`Engine::columns`].
    pub(super) async fn axis_crossings(
        &mut self,
        casts: &[AxisCasts],
        main: &Rays,
        most_rays: u64,
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
                used = used.and(self.crossings(&cast, false, most_rays, control, take).await?);
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
    pub(super) async fn build(
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
            let run = async |gpu: &Gpu, options: &Options, usage: &mut Usage| {
                let first_row = (builder.n_rays() / u64::from(cast.rays.counts[0])) as u32;
                let take = &mut |band: Band| builder.push(laid(overlay, vec![band]));
                gpu.hand_out_bands(cast, options, control, first_row..cast.rays.counts[1], usage, take).await
            };
            // what the GPU has finished before it fails stays: it was checked
            if self.on_gpu(budget.most_rows, &mut used, run).await? {
                return Ok(Used { host_bytes: UPLOAD_FACET_BYTES * cast.frame.facets.len() as u64, ..used });
            }
        }
        let strips = cpu::Strips::new(cast, None).in_rounds_of(budget.most_strips);
        let mut strips = strips.from_ray(builder.n_rays());
        while let Some(bands) = strips.round(control)? {
            builder.push(laid(overlay, bands))?;
            control.pause().await;
        }
        Ok(Used { host_bytes: used.host_bytes.max(strips.n_bytes()), ..used })
    }

    /// Runs something on the GPU, in bands of at most so many ray rows, and again on a new device where it is lost; `run` goes on where
    /// it stopped. Returns false where there is no GPU, or where it fails and the CPU shall go on.
    #[cfg(feature = "gpu")]
    async fn on_gpu(
        &mut self,
        most_rows: u32,
        used: &mut Used,
        mut run: impl AsyncFnMut(&Gpu, &Options, &mut Usage) -> Result<()>,
    ) -> Result<bool> {
        let mut options = Options { most_rows: Some(most_rows), ..Options::default() };
        let (mut usage, mut reopenings) = (Usage { rows_of_band: 64, ..Usage::default() }, 0);
        while let Some(gpu) = &self.gpu {
            let result = run(gpu, &options, &mut usage).await;
            *used = Used { device_bytes: usage.peak_bytes, checked: Some(usage.checked), ..*used };
            let Err(mut error) = result else { return Ok(true) };
            if error.code() == "device-lost" && reopenings < MAX_REOPENINGS {
                reopenings += 1;
                options.rows_per_band = Some((usage.rows_of_band / 2).max(1));
                let instance = self.instance.get_or_insert_with(instance);
                match Gpu::open_in(instance, self.wanted_adapter.as_deref(), None).await {
                    Ok(gpu) => {
                        self.gpu = Some(gpu);
                        continue;
                    }
                    Err(again) => error = lost_for_good(&error, &again),
                }
            }
            if error.code() == "device-wrong" || self.has_cpu_fallback && error.code() == "device-lost" {
                self.gpu = None;
                self.fallback = Some(error.to_string());
                return Ok(false);
            }
            return Err(error);
        }
        Ok(false)
    }
}

/// Bands with the open geometries put over them, if there are any.
fn laid(overlay: &mut Option<Overlay>, bands: Vec<Band>) -> Vec<Band> {
    match overlay {
        Some(overlay) => overlay.lay(bands),
        None => bands,
    }
}

/// The error of a device that was lost and cannot be opened again.
#[cfg(feature = "gpu")]
fn lost_for_good(lost: &Error, again: &Error) -> Error {
    Error::new("device-lost", format!("{lost}; opening it again: {again}"), lost.hint())
}
