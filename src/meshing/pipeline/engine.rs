//! The backend: the GPU or the CPU, chosen once, used for many meshes.

// the clock, which wasm's std does not have
#[cfg(not(target_arch = "wasm32"))]
pub(super) use std::time::Instant;
#[cfg(target_arch = "wasm32")]
pub(super) use web_time::Instant;

use crate::meshing::estimate::Device;
use hexcast_core::base::error::{Error, Result};
use hexcast_core::input::job::BackendChoice;
#[cfg(feature = "gpu")]
use hexcast_gpu::{AdapterKind, Gpu, Instance};

mod run;

pub use run::Used;

/// An open backend.
#[non_exhaustive]
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
    /// Whether there is a GPU, and it failed: a finding says so. No GPU, or one in software, is nothing to warn about.
    pub has_failed: bool,
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
            has_failed: false,
            seconds: 0.0,
        }
    }

    /// The CPU backend, as the GPU cannot be opened.
    fn in_place_of_gpu(error: &Error) -> Engine {
        Engine { fallback: Some(error.to_string()), has_failed: error.code() != "no-adapter", ..Engine::cpu() }
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
                Err(error) => Engine::in_place_of_gpu(&error),
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

    /// Opens the preferred GPU unless it is a driver that computes on the processor. In browsers `www/core/adapter.js` knows that, and has
    /// asked.
    async fn open_hardware() -> Result<Engine> {
        #[cfg(all(feature = "gpu", not(target_arch = "wasm32")))]
        {
            let facts = hexcast_gpu::adapter(None).await?;
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
            Err(error) if is_auto => Engine::in_place_of_gpu(&error),
            Err(error) => return Err(error),
        };
        Ok(Engine { seconds: start.elapsed().as_secs_f64(), ..engine })
    }

    /// Prepares a GPU that the caller has opened. Where its device is lost, one of an adapter of the same name takes its place;
    /// there being none is an error, unless [`Engine::with_cpu_fallback`] says otherwise. A device of [`Gpu::from_device`] has none in its
    /// place.
    #[cfg(feature = "gpu")]
    pub fn with_gpu(gpu: Gpu) -> Engine {
        let wanted_adapter = Some(gpu.facts.name.clone());
        Engine { gpu: Some(gpu), wanted_adapter, ..Engine::cpu() }
    }

    #[cfg(not(feature = "gpu"))]
    async fn open_gpu(_: Option<&str>) -> Result<Engine> {
        Err(Error::new("no-adapter", "this build has no GPU backend", "build with the feature gpu"))
    }

    /// The GPU; None on the CPU.
    #[cfg(feature = "gpu")]
    pub fn gpu(&self) -> Option<&Gpu> {
        self.gpu.as_ref()
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
}
