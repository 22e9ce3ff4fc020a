//! Who meshes: the GPU or the CPU, chosen once, used for many meshes.

use web_time::Instant;

use crate::columns::Columns;
use crate::control::Control;
use crate::cpu;
use crate::error::Result;
use crate::frame::Frame;
use crate::job::{BackendChoice, Rule};
use crate::rays::Rays;

/// Times that a lost device is opened again.
#[cfg(feature = "gpu")]
const MAX_REOPENINGS: u32 = 3;

/// Who meshes, ready to work.
pub struct Engine {
    #[cfg(feature = "gpu")]
    gpu: Option<crate::gpu::Gpu>,
    #[cfg(feature = "gpu")]
    wanted_adapter: Option<String>,
    /// Why the CPU meshes although a GPU was looked for.
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
            fallback: None,
            seconds: 0.0,
        }
    }

    /// Opens the backend of a job; `adapter` is a part of the name of the GPU to use, where there are several.
    ///
    /// # Errors
    /// `no-adapter`, `device-failed`: only if the GPU was asked for; otherwise the CPU takes over and `fallback` says why.
    pub async fn open(choice: BackendChoice, adapter: Option<&str>) -> Result<Engine> {
        if choice == BackendChoice::Cpu {
            return Ok(Engine::cpu());
        }
        let start = Instant::now();
        let mut engine = Engine::open_gpu(adapter).await;
        if let Err(error) = &engine
            && choice == BackendChoice::Auto
            && adapter.is_none()
        {
            engine = Ok(Engine { fallback: Some(error.to_string()), ..Engine::cpu() });
        }
        engine.map(|engine| Engine { seconds: start.elapsed().as_secs_f64(), ..engine })
    }

    #[cfg(feature = "gpu")]
    async fn open_gpu(adapter: Option<&str>) -> Result<Engine> {
        let gpu = crate::gpu::Gpu::open(adapter).await?;
        Ok(Engine { gpu: Some(gpu), wanted_adapter: adapter.map(String::from), ..Engine::cpu() })
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

    /// Whether the GPU is one in name only: a driver that computes on the processor.
    pub fn is_software(&self) -> bool {
        #[cfg(feature = "gpu")]
        return self.gpu.as_ref().is_some_and(|gpu| gpu.facts.kind == crate::gpu::AdapterKind::Software);
        #[cfg(not(feature = "gpu"))]
        false
    }

    /// Meshes a frame; also returns the most bytes held on the device.
    ///
    /// # Errors
    /// `cancelled`, the limits of the device, and `device-lost` when it was lost too often.
    pub async fn columns(
        &mut self,
        frame: &Frame,
        rays: &Rays,
        rule: Rule,
        control: &Control,
    ) -> Result<(Columns, u64)> {
        #[cfg(feature = "gpu")]
        if self.gpu.is_some() {
            return self.gpu_columns(&crate::gpu::Cast { frame, rays, rule }, control).await;
        }
        let mut strips = cpu::Strips::new(frame, rays, rule, None);
        let mut bands = Vec::new();
        while let Some(mut more) = strips.round(control)? {
            bands.append(&mut more);
            control.pause().await;
        }
        Ok((Columns::new(*rays, bands), 0))
    }

    #[cfg(feature = "gpu")]
    async fn gpu_columns(&mut self, cast: &crate::gpu::Cast<'_>, control: &Control) -> Result<(Columns, u64)> {
        let mut bands = Vec::new();
        let mut options = crate::gpu::Options::default();
        let mut reopenings = 0;
        while let Some(gpu) = &self.gpu {
            match gpu.continue_columns(cast, &options, control, &mut bands).await {
                Ok(usage) => return Ok((Columns::new(*cast.rays, bands), usage.peak_bytes)),
                Err(error) if error.code() == "device-lost" && reopenings < MAX_REOPENINGS => {
                    reopenings += 1;
                    let rows = bands.last().map_or(64, |band| band.ends.len() as u64 / u64::from(cast.rays.counts[0]));
                    options.rows_per_band = Some((rows / 2).max(1) as u32);
                    self.gpu = Some(crate::gpu::Gpu::open(self.wanted_adapter.as_deref()).await?);
                }
                Err(error) => return Err(error),
            }
        }
        unreachable!("a GPU mesh has a GPU")
    }
}
