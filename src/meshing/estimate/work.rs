//! The memory of the current work: of a round of strips on the CPU, or of the bands in flight on a GPU.

use super::Estimate;
use super::device::{BIN, IN_FLIGHT, UNEVEN};
use super::memory_limits::{Allowed, Device};
use hexcast_core::base::parallel::current_num_threads;
use hexcast_core::stages::cast::sizes::{MOST_BAND, whole_bins};
use hexcast_core::stages::cpu;

/// What the allocator keeps of what each core beyond two has freed; the slack counts for two. Measured: 1.6 MB.
const KEPT_OF_CORE: u64 = 1_700_000;

/// The current work, by its size: strips of a round on the CPU, ray rows of a band on a GPU.
pub(super) struct Work<'a> {
    pub(super) estimate: &'a Estimate,
    device: Device,
    max_device_bytes: u64,
    can_spill: bool,
    slot_bytes: u64,
}

impl<'a> Work<'a> {
    pub(super) fn new(estimate: &'a Estimate, allowed: &Allowed) -> Work<'a> {
        let Allowed { device, max_device_bytes, can_spill, slot_bytes, .. } = *allowed;
        Work { estimate, device, max_device_bytes, can_spill, slot_bytes }
    }

    /// Bytes of host memory that do not depend on the size.
    pub(super) fn fixed(&self) -> u64 {
        let (estimate, n_cores) = (self.estimate, current_num_threads() as u64);
        let kept = KEPT_OF_CORE * n_cores.saturating_sub(2);
        if self.device != Device::None {
            return kept;
        }
        // a strip on every core: its crossings as they are found and in order, or in slots, with its runs and what the slots do not hold
        let rays = estimate.strip_rays().min(estimate.rays) as f64;
        let crossings = UNEVEN * self.per_ray(estimate.crossings);
        let in_slots = self.slot_bytes as f64 + 8.0 * crossings + 12.0 * (crossings - 8.0).max(0.0);
        kept + estimate.host.lattice + n_cores * (rays * in_slots.max(8.0 + 12.0 * crossings)) as u64
    }

    /// Bytes that building the lattice of the CPU backend takes besides it: its pairs, in lists that grow.
    pub(super) fn building(&self) -> u64 {
        if self.device == Device::None { 4 * self.estimate.host.lattice } else { 0 }
    }

    /// The least size.
    pub(super) fn least(&self) -> u64 {
        if self.device == Device::None { 1 } else { BIN.min(self.estimate.rows()) }
    }

    /// The largest size that takes at most so many bytes, or the least.
    pub(super) fn most_within(&self, max_bytes: u64) -> u64 {
        let mut units = match self.device {
            Device::None => u64::from(cpu::STRIPS_PER_ROUND),
            _ => self.estimate.rows().min((MOST_BAND / self.estimate.rays_across()).max(BIN)),
        };
        while units > self.least() && self.cost(units) > max_bytes {
            let fewer = units * 3 / 4;
            units = if self.device == Device::None { fewer } else { whole_bins(fewer) }.max(self.least());
        }
        units
    }

    /// Bytes of host memory that work of a size takes, with the device's if it shares that.
    pub(super) fn cost(&self, units: u64) -> u64 {
        self.host_cost(units) + self.shared(units)
    }

    /// Those of them that a device holds: as many as it must be allowed.
    pub(super) fn shared(&self, rows: u64) -> u64 {
        match self.device {
            Device::Shared => self.estimate.device_limit_of(rows.min(self.estimate.rows())).min(self.max_device_bytes),
            _ => 0,
        }
    }

    /// The others.
    pub(super) fn host_cost(&self, units: u64) -> u64 {
        let estimate = self.estimate;
        let rows = if self.device == Device::None { units * estimate.strip_rows() } else { units }.min(estimate.rows());
        let rays = (rows * estimate.rays_across()) as f64;
        let uneven = if rows == estimate.rows() { 1.0 } else { UNEVEN };
        let runs = self.per_ray(estimate.runs) * uneven;
        // unpacked bands are in memory beside the packed ones, and what spills is encoded first
        let unpacked = rays * (4.0 + if self.can_spill { 1.0 + 6.0 * runs } else { 0.0 });
        if self.device == Device::None {
            return unpacked as u64;
        }
        let in_flight = IN_FLIGHT.min(estimate.rows().div_ceil(rows)) as f64;
        // what is read back comes by a buffer that the host can see
        let places = estimate.places() / estimate.rays as f64 * uneven;
        // that buffer is a quarter larger than needed
        let staging = in_flight * rays * 1.25 * (1.0 + 16.0 * places);
        (unpacked + staging) as u64 + estimate.upload_bytes_of(rows)
    }

    fn per_ray(&self, n: u64) -> f64 {
        n as f64 / self.estimate.rays as f64
    }
}
