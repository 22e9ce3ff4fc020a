//! How much memory a mesh may take, of the host and of the device.
//!
//! The buffers of a device count as host memory, too, if they lie there: for software drivers (lavapipe, SwiftShader, WARP) and
//! for integrated GPUs.

/// Whose memory holds the buffers of the device.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
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
}
