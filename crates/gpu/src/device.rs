//! Finding an adapter, opening a device, and hearing of its failures.

use std::fmt;
use std::sync::Arc;

use serde::Serialize;
use std::time::Duration;
use wgpu::{Adapter, DeviceDescriptor, DeviceType, Instance, InstanceDescriptor, Limits, RequestAdapterOptions};

use crate::device_bytes::Held;
use crate::failure::Failure;
#[cfg(not(target_arch = "wasm32"))]
use crate::failure::{answers, listen};
use crate::needs::check_limits;
use crate::pace::Instant;
use hexcast_core::base::control::Control;
use hexcast_core::base::error::{Error, Result};

/// What kind of machine an adapter is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum AdapterKind {
    /// A graphics card of its own.
    Discrete,
    /// A part of the processor's chip.
    Integrated,
    /// A share of a card in a virtual machine.
    Virtual,
    /// A driver that computes on the processor (lavapipe, SwiftShader, WARP).
    Software,
    /// Not told, as in browsers.
    Unknown,
}

impl AdapterKind {
    /// Whether buffers lie in the host's memory.
    pub fn shares_memory(self) -> bool {
        matches!(self, AdapterKind::Software | AdapterKind::Integrated)
    }
}

/// What is known of an adapter.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct AdapterFacts {
    /// Name of the adapter.
    pub name: String,
    /// Name and version of its driver.
    pub driver: String,
    /// The interface it is reached by: vulkan, metal, dx12 or webgpu.
    pub api: String,
    /// What it is.
    pub kind: AdapterKind,
    /// Largest buffer, in bytes, that a kernel can see at once.
    pub max_binding_bytes: u64,
}

impl fmt::Display for AdapterFacts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the GPU adapter \"{}\" (driver {})", self.name, self.driver)
    }
}

/// An open device, and what its driver has said since; a clone is the same device.
#[derive(Clone)]
pub(crate) struct Opened {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    /// The bytes of all buffers that kernels use.
    pub(crate) held: Arc<Held>,
    pub(super) failure: Arc<Failure>,
    /// Whether the device is the caller's, and so its handlers are.
    pub(crate) is_callers: bool,
}

/// Lists the adapters that this machine offers.
pub async fn adapters() -> Vec<AdapterFacts> {
    instance().enumerate_adapters(wgpu::Backends::all()).await.iter().map(facts).collect()
}

/// Finds the adapter that [`crate::Gpu::open`] would open.
///
/// # Errors
/// `no-adapter`, as for [`crate::Gpu::open`].
pub async fn adapter(wanted: Option<&str>) -> Result<AdapterFacts> {
    find(&instance(), wanted).await.map(|adapter| facts(&adapter))
}

pub(crate) async fn find(instance: &Instance, wanted: Option<&str>) -> Result<Adapter> {
    match wanted {
        // browsers offer one adapter, without a name
        Some(name) if cfg!(not(target_arch = "wasm32")) => named_adapter(instance, name).await,
        _ => preferred_adapter(instance).await,
    }
}

/// The limits that hexcast asks for when it opens a device of an adapter: the buffer sizes that the adapter offers, and WebGPU's default
/// limits for everything else. A caller who opens a device for [`crate::Gpu::from_device`] may ask for these, or for more.
pub fn device_limits(adapter: &Adapter) -> Limits {
    let offered = adapter.limits();
    Limits {
        max_storage_buffer_binding_size: offered.max_storage_buffer_binding_size,
        max_buffer_size: offered.max_buffer_size,
        ..Limits::default()
    }
}

impl Opened {
    /// Opens a device with the buffer sizes that the adapter offers, and WebGPU's default limits for everything else.
    ///
    /// # Errors
    /// `device-failed`: the driver refused.
    pub(crate) async fn new(adapter: &Adapter) -> Result<Opened> {
        let required_limits = device_limits(adapter);
        let descriptor = DeviceDescriptor { label: Some("hexcast"), required_limits, ..Default::default() };
        let refused = |error| Error::new("device-failed", format!("the driver refused the device: {error}"), USE_CPU);
        let (device, queue) = adapter.request_device(&descriptor).await.map_err(refused)?;
        // in JavaScript it may be the caller's
        check_limits(&device.limits())?;
        let failure = Arc::new(Failure::default());
        let heard = failure.clone();
        device.on_uncaptured_error(Arc::new(move |error| {
            heard.note(Error::new("device-failed", format!("the GPU driver reported: {error}"), USE_CPU));
        }));
        let heard = failure.clone();
        device.set_device_lost_callback(move |reason, message| {
            heard.note(lost(&format_args!("{reason:?}: {message}")));
        });
        Ok(Opened { device, queue, held: Arc::default(), failure, is_callers: false })
    }

    /// Begins to record commands.
    pub(crate) fn encoder(&self) -> wgpu::CommandEncoder {
        self.device.create_command_encoder(&Default::default())
    }

    /// Takes a device of the caller's, whose handlers stay the caller's.
    pub(crate) fn of_caller(device: &wgpu::Device, queue: &wgpu::Queue) -> Opened {
        let (held, failure) = (Arc::default(), Arc::default());
        Opened { device: device.clone(), queue: queue.clone(), held, failure, is_callers: true }
    }

    /// Returns the failure that the driver reported, if it did.
    pub(crate) fn check(&self) -> Result<()> {
        #[cfg(not(target_arch = "wasm32"))]
        if self.is_callers {
            listen(&self.device, &self.failure);
        }
        self.failure.check()
    }

    /// Finds the cause of a failure. What is done with a lost device fails in many ways, and browsers tell of the loss itself
    /// some moments later, or too late. So a buffer that cannot be read, of a device that reported no error, is that of a lost device.
    pub(crate) async fn cause(&self, error: Error, control: &Control) -> Error {
        #[cfg(not(target_arch = "wasm32"))]
        if self.is_callers {
            let is_lost = error.code() == "device-failed" && !answers(&self.device).await;
            return if is_lost { lost(&error) } else { error };
        }
        let start = Instant::now();
        while error.code() == "device-failed" && start.elapsed() < DEVICE_LOST_GRACE {
            control.pause().await;
            // natively callbacks come from here; what it returns is what the callbacks tell
            let _ = self.device.poll(wgpu::PollType::Poll);
            match self.check() {
                Err(told) if told.code() == "device-lost" => return told,
                _ => {}
            }
        }
        match self.check() {
            Ok(()) if error.code() == "device-failed" => lost(&error),
            _ => error,
        }
    }
}

/// Time within which a browser tells that a device was lost: a message between two of its processes, on a busy machine.
const DEVICE_LOST_GRACE: Duration = Duration::from_millis(500);

pub(crate) const USE_CPU: &str = "use the CPU backend, or update the GPU driver";

fn lost(how: &dyn fmt::Display) -> Error {
    Error::new("device-lost", format!("the GPU device was lost ({how})"), USE_CPU)
}

/// Reaches the drivers of this machine; in JavaScript `navigator.gpu` as it is at this moment.
pub fn instance() -> Instance {
    let descriptor = InstanceDescriptor::new_without_display_handle();
    // browsers have no environment variables
    Instance::new(if cfg!(target_arch = "wasm32") { descriptor } else { descriptor.with_env() })
}

async fn preferred_adapter(instance: &Instance) -> Result<Adapter> {
    let options =
        RequestAdapterOptions { power_preference: wgpu::PowerPreference::HighPerformance, ..Default::default() };
    instance.request_adapter(&options).await.map_err(|error| {
        Error::new(
            "no-adapter",
            format!("no GPU adapter was found: {}", of_backends(&error.to_string())),
            "use the CPU backend, or install a GPU driver",
        )
    })
}

/// What wgpu says of each API, but for those of other systems.
fn of_backends(error: &str) -> String {
    let parts = error.split("; ").flat_map(|part| part.split(", "));
    let own: Vec<&str> =
        parts.filter(|part| !part.ends_with("not compiled in") && !part.starts_with("No suitable")).collect();
    if own.is_empty() { error.to_string() } else { own.join(", ") }
}

async fn named_adapter(instance: &Instance, name: &str) -> Result<Adapter> {
    let mut adapters = instance.enumerate_adapters(wgpu::Backends::all()).await;
    let lower = name.to_ascii_lowercase();
    let position = adapters.iter().position(|adapter| adapter.get_info().name.to_ascii_lowercase().contains(&lower));
    match position {
        Some(index) => Ok(adapters.swap_remove(index)),
        None => {
            let names: Vec<String> = adapters.iter().map(|adapter| adapter.get_info().name).collect();
            let message =
                format!("no GPU adapter is named \"{name}\"; there are {}: {}", names.len(), names.join(", "));
            Err(Error::new("no-adapter", message, "choose one of these, or the CPU backend"))
        }
    }
}

pub(crate) fn facts(adapter: &Adapter) -> AdapterFacts {
    facts_of(adapter.get_info(), &adapter.limits())
}

/// What is known of the adapter of a device, and its buffers.
pub(super) fn facts_of(info: wgpu::AdapterInfo, limits: &Limits) -> AdapterFacts {
    let kind = match info.device_type {
        DeviceType::DiscreteGpu => AdapterKind::Discrete,
        DeviceType::IntegratedGpu => AdapterKind::Integrated,
        DeviceType::VirtualGpu => AdapterKind::Virtual,
        DeviceType::Cpu => AdapterKind::Software,
        DeviceType::Other => AdapterKind::Unknown,
    };
    AdapterFacts {
        name: info.name,
        driver: [info.driver, info.driver_info].join(" ").trim().to_string(),
        api: info.backend.to_str().to_string(),
        kind,
        max_binding_bytes: limits.max_storage_buffer_binding_size,
    }
}

#[cfg(test)]
mod tests {
    use super::super::buffers::Array;
    use super::super::readback::Staging;
    use super::*;

    /// What became of a buffer of a destroyed device that told nothing, or reported an error before.
    fn cause_of_unread(reported: Option<Error>) -> Error {
        pollster::block_on(async {
            let adapter = find(&instance(), None).await.unwrap();
            let opened = Opened::new(&adapter).await.unwrap();
            // what the device tells is not heard
            let deaf = Opened { failure: Arc::default(), ..opened };
            let words: Array<u32> = Array::storage(&deaf, "words", 4);
            deaf.device.destroy();
            let read = Staging::default().read(&deaf, deaf.encoder(), [words.all()]).await;
            let error = read.map(|[words]| words).unwrap_err();
            assert!(error.to_string().contains("could not be read"), "{error}");
            reported.into_iter().for_each(|error| deaf.failure.note(error));
            deaf.cause(error, &Control::default()).await
        })
    }

    #[test]
    fn a_buffer_that_cannot_be_read_is_that_of_a_lost_device_even_if_the_loss_is_never_told() {
        let error = cause_of_unread(None);
        assert_eq!(error.code(), "device-lost");
        assert!(
            error.to_string().starts_with("the GPU device was lost (the GPU's result could not be read"),
            "{error}"
        );
    }

    #[test]
    fn it_is_no_lost_device_where_the_driver_reported_an_error() {
        let error = cause_of_unread(Some(Error::new("device-failed", "the GPU driver reported: no", USE_CPU)));
        assert_eq!(error.code(), "device-failed");
    }
}
