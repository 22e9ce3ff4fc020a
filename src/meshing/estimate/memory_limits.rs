//! How much memory a mesh may take, of the host and of the device.
//!
//! The buffers of a device count as host memory, too, if they lie there: for software drivers (lavapipe, SwiftShader, WARP) and
//! for integrated GPUs.

use hexcast_core::input::job::Rule;
use hexcast_core::stages::slots::bytes_of_ray;

/// Whose memory holds the buffers of the device.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Device {
    /// There is none: the CPU meshes.
    None,
    /// The device has memory of its own.
    Own,
    /// They lie in the host's memory.
    Shared,
}

impl Device {
    /// The part of the memory, one in so many, that allocators and drivers keep of what was freed; measured.
    pub(super) fn slack(self) -> u64 {
        if self == Device::None { 10 } else { 5 }
    }
}

/// What a mesh may take.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Allowed {
    /// Most bytes of memory.
    pub max_bytes: u64,
    /// Bytes of these that the program and its driver take, whatever they mesh.
    pub program_bytes: u64,
    /// Who meshes.
    pub device: Device,
    /// Most bytes of buffers on the device.
    pub max_device_bytes: u64,
    /// Whether columns may go elsewhere.
    pub can_spill: bool,
    /// Whether all flags will be held in memory.
    pub flags: bool,
    /// Bytes that the CPU takes for each ray of a strip, besides those of its crossings.
    pub slot_bytes: u64,
}

impl Allowed {
    /// So many bytes of memory for a mesh on the CPU, whose columns stay in memory; nothing of the program counts.
    pub fn new(max_bytes: u64) -> Allowed {
        let (program_bytes, device, max_device_bytes) = (0, Device::None, u64::MAX);
        // of the most geometries
        let slot_bytes = bytes_of_ray(Rule::Nonzero, 2, 0);
        Allowed { max_bytes, program_bytes, device, max_device_bytes, can_spill: false, flags: false, slot_bytes }
    }

    /// Counts the program and its driver.
    pub fn with_program_bytes(self, program_bytes: u64) -> Allowed {
        Allowed { program_bytes, ..self }
    }

    /// Says who meshes, and most bytes of buffers there.
    pub fn with_device(self, device: Device, max_device_bytes: u64) -> Allowed {
        Allowed { device, max_device_bytes, ..self }
    }

    /// Says what the rays are, whose crossings take less where there is one geometry: the rule, geometries, and cells of a ray.
    pub fn with_rays(self, rule: Rule, n_geometries: usize, depth: u32) -> Allowed {
        Allowed { slot_bytes: bytes_of_ray(rule, n_geometries, depth), ..self }
    }

    /// Says whether columns may spill.
    pub fn with_spill(self, can_spill: bool) -> Allowed {
        Allowed { can_spill, ..self }
    }

    /// Says whether all flags will be held in memory.
    pub fn with_flags(self, flags: bool) -> Allowed {
        Allowed { flags, ..self }
    }
}
