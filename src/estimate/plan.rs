//! The memory budget: how the memory allowed is divided among what meshing holds, or why it is too little.
//!
//! Estimate, what is allowed -> [`MemoryBudget`]. The current work, a round of strips on the CPU or the bands in flight on a GPU, is made
//! as small as it must be. Bytes that a device holds count too where its memory is the host's: drivers on the processor
//! (lavapipe, SwiftShader, WARP) and GPUs on the processor's chip, which take their buffers from the same memory.
//! The GPU backend keeps to the bytes that it gets: where bands need more than estimated they become smaller.
//! Weakness: rays are taken to be as crowded everywhere as half again the mean.

use super::costs::Estimate;
use super::device::{BIN, IN_FLIGHT, UNEVEN};
use crate::cast::sizes::{MOST_BAND, whole_bins};
use crate::cpu;
use crate::error::{Error, MORE_MEMORY, Result};
use crate::job::ByteSize;
use crate::mesh::SLAB_BYTES;
use crate::parallel::current_num_threads;
use crate::rays::Rays;
use crate::write::Options;

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
    fn slack(self) -> u64 {
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

/// Limits of the bands of a GPU.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BandLimit {
    /// Most rays of a band, if that is a row of bins at least.
    pub n_rays: u64,
    /// Most bytes of buffers that the device holds at once, for all bands in flight.
    pub device_bytes: u64,
}

/// Shares of the memory allowed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MemoryBudget {
    /// Bytes for the columns.
    pub columns: u64,
    /// Limits of bands on the GPU.
    pub bands: BandLimit,
    /// Most strips of a round on the CPU.
    pub most_strips: u32,
    /// Least bytes of memory that the mesh takes.
    pub needed: u64,
}

/// What stays in memory of columns that spilled, besides their index: the pieces read last.
const LEAST_COLUMNS: u64 = 1 << 20;
/// Rays of a piece in the store at least, on average, and bytes of its record.
const PIECE_RAYS: u64 = 1 << 15;
const RECORD_BYTES: u64 = 64;

/// Bytes of flags to write at a time within a budget: two of these slabs are held, beside the columns.
pub fn slab_bytes(max_bytes: u64) -> u64 {
    (max_bytes / 16).clamp(1 << 16, SLAB_BYTES as u64)
}

/// Compressed bytes to hold until the sizes of all blocks of a file are known, within a budget.
pub fn block_cache_bytes(max_bytes: u64) -> u64 {
    (Options::default().block_cache_bytes as u64).min(max_bytes / 16)
}

impl MemoryBudget {
    /// The budget where only the memory of a device may be limited.
    pub fn unlimited(rays: &Rays, max_device_bytes: u64) -> MemoryBudget {
        let bands = BandLimit { n_rays: rays.n_rays(), device_bytes: max_device_bytes };
        MemoryBudget { columns: u64::MAX, bands, most_strips: cpu::STRIPS_PER_ROUND, needed: 0 }
    }

    /// Shares out the memory allowed.
    ///
    /// # Errors
    /// `memory` where it is too little, with the numbers.
    pub fn new(estimate: &Estimate, allowed: &Allowed) -> Result<MemoryBudget> {
        let budget = MemoryBudget::unchecked(estimate, allowed);
        if budget.needed <= allowed.max_bytes { Ok(budget) } else { Err(too_little(estimate, allowed, budget.needed)) }
    }

    fn unchecked(estimate: &Estimate, allowed: &Allowed) -> MemoryBudget {
        let Allowed { max_bytes, program_bytes, device, max_device_bytes, can_spill, .. } = *allowed;
        let work = Work::new(estimate, allowed);
        let fixed = estimate.host.facets + work.fixed();
        let least_columns = least_columns(estimate, can_spill);
        let own = max_bytes.saturating_sub(program_bytes);
        let left = (own - own / device.slack()).saturating_sub(fixed);
        // a quarter more than estimated; where columns may go elsewhere they leave half of the memory to the work
        let wanted = estimate.host.columns.saturating_add(estimate.host.columns / 4);
        let mut for_work = left.saturating_sub(wanted);
        if can_spill {
            for_work = for_work.max(left / 2);
        }
        let units = work.most_within(for_work);
        let writing =
            flag_bytes(estimate, allowed).saturating_add(2 * slab_bytes(max_bytes) + block_cache_bytes(max_bytes));
        // twice what bands are estimated to need, if there is as much
        let room = for_work.saturating_sub(work.cost(units));
        let device_bytes = match device {
            Device::Shared => work.shared(units).saturating_add(room.min(work.shared(units))).min(max_device_bytes),
            _ => max_device_bytes,
        };
        let cost = work.host_cost(units) + if device == Device::Shared { device_bytes } else { 0 };
        let columns = left.saturating_sub(cost).min(own.saturating_sub(writing)).max(least_columns);
        let (most_rows, most_strips) =
            if device == Device::None { (estimate.rows(), units as u32) } else { (units, 1) };
        let bands = BandLimit { n_rays: most_rows * estimate.rays_across(), device_bytes };
        MemoryBudget { columns, bands, most_strips, needed: needed(allowed, &work) }
    }
}

/// Least bytes of memory that a mesh takes.
fn needed(allowed: &Allowed, work: &Work) -> u64 {
    let Work { estimate, .. } = *work;
    let columns = least_columns(estimate, allowed.can_spill);
    let meshing = estimate.host.facets + work.fixed() + work.cost(work.least()) + columns;
    let slack = allowed.device.slack();
    let meshing = allowed.program_bytes.saturating_add((meshing / (slack - 1) + 1) * slack);
    let building = allowed.program_bytes + estimate.host.facets + work.building();
    let held = (allowed.program_bytes + columns).saturating_add(flag_bytes(estimate, allowed));
    // slabs and cached blocks are three sixteenths of what is allowed, up to their own limits
    let most = held.saturating_add(2 * SLAB_BYTES as u64 + block_cache_bytes(u64::MAX));
    meshing.max(building).max(held.saturating_add(held / 13 * 3).min(most))
}

fn least_columns(estimate: &Estimate, can_spill: bool) -> u64 {
    let records = estimate.rays.div_ceil(PIECE_RAYS) * RECORD_BYTES;
    if can_spill { estimate.host.columns.min(LEAST_COLUMNS + records) } else { estimate.host.columns }
}

fn flag_bytes(estimate: &Estimate, allowed: &Allowed) -> u64 {
    if allowed.flags { estimate.cells } else { 0 }
}

/// The current work, by its size: strips of a round on the CPU, ray rows of a band on a GPU.
struct Work<'a> {
    estimate: &'a Estimate,
    device: Device,
    max_device_bytes: u64,
    can_spill: bool,
}

impl<'a> Work<'a> {
    fn new(estimate: &'a Estimate, allowed: &Allowed) -> Work<'a> {
        let Allowed { device, max_device_bytes, can_spill, .. } = *allowed;
        Work { estimate, device, max_device_bytes, can_spill }
    }

    /// Bytes of host memory that do not depend on the size.
    fn fixed(&self) -> u64 {
        let estimate = self.estimate;
        if self.device != Device::None {
            return 0;
        }
        // crossings of a strip on every core, as they are found and in order
        let rays = estimate.strip_rays().min(estimate.rays) as f64;
        let of_core = rays * (8.0 + 12.0 * UNEVEN * self.per_ray(estimate.crossings));
        estimate.host.lattice + current_num_threads() as u64 * of_core as u64
    }

    /// Bytes that building the lattice of the CPU backend takes besides it: its pairs, in lists that grow.
    fn building(&self) -> u64 {
        if self.device == Device::None { 4 * self.estimate.host.lattice } else { 0 }
    }

    /// The least size.
    fn least(&self) -> u64 {
        if self.device == Device::None { 1 } else { BIN.min(self.estimate.rows()) }
    }

    /// The largest size that takes at most so many bytes, or the least.
    fn most_within(&self, max_bytes: u64) -> u64 {
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
    fn cost(&self, units: u64) -> u64 {
        self.host_cost(units) + self.shared(units)
    }

    /// Those of them that a device holds: as many as it must be allowed.
    fn shared(&self, rows: u64) -> u64 {
        match self.device {
            Device::Shared => self.estimate.device_limit_of(rows.min(self.estimate.rows())).min(self.max_device_bytes),
            _ => 0,
        }
    }

    /// The others.
    fn host_cost(&self, units: u64) -> u64 {
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

fn too_little(estimate: &Estimate, allowed: &Allowed, needed: u64) -> Error {
    let Allowed { max_bytes, program_bytes, device, can_spill, flags, .. } = *allowed;
    let work = Work::new(estimate, allowed);
    let mut parts = vec![
        ("columns", least_columns(estimate, can_spill)),
        ("facets", estimate.host.facets),
        (
            if device == Device::None { "rays at work" } else { "bands on the GPU" },
            (work.fixed() + work.cost(work.least())).max(work.building()),
        ),
    ];
    parts.extend((program_bytes > 0).then_some(("program and driver", program_bytes)));
    parts.extend(flags.then_some(("flags in memory", estimate.cells)));
    let rest = parts.iter().fold(needed, |rest, (_, bytes)| rest.saturating_sub(*bytes));
    parts.push(("output and allocator", rest));
    let parts: Vec<String> = parts.iter().map(|(what, bytes)| format!("{what} {}", ByteSize(*bytes))).collect();
    let (needed_text, max_text) = (ByteSize(needed), ByteSize(max_bytes));
    let message =
        format!("the mesh takes about {needed_text} of memory ({}); {max_text} are allowed", parts.join(", "));
    let on_cpu = || MemoryBudget::unchecked(estimate, &Allowed { device: Device::None, ..*allowed }).needed;
    let hint = match (flags, can_spill) {
        (true, _) => {
            "leave out --flags-in-memory: files are written without it; or allow more with --max-memory".into()
        }
        _ if device == Device::Shared && on_cpu() < needed => {
            format!(
                "allow {needed_text} with max_memory (--max-memory), or use the CPU (--backend cpu), which takes less"
            )
        }
        (_, false) => {
            let spilled = MemoryBudget::unchecked(estimate, &Allowed { can_spill: true, ..*allowed }).needed;
            if spilled <= max_bytes {
                MORE_MEMORY.into()
            } else {
                let spilled = ByteSize(spilled);
                format!(
                    "allow {needed_text} with max_memory (--max-memory), or {spilled} and let columns go to disk (--spill DIR)"
                )
            }
        }
        (_, true) => format!("allow {needed_text} with max_memory (--max-memory), or mesh fewer facets"),
    };
    Error::new("memory", message, hint)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Geometry;
    use crate::lines::Lines;

    /// What a wall of facets across all rays of a box would take.
    fn estimate(dims: [u32; 3]) -> Estimate {
        let n = 20;
        let corner = |i: u32, j: u32, height: f32| [height, i as f32 / n as f32, j as f32 / n as f32];
        let wall = |height| {
            let place = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
            place.flat_map(move |(i, j)| {
                let [a, b, c, d] = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(di, dj)| corner(i + di, j + dj, height));
                [[a, b, c], [b, c, d]]
            })
        };
        let geometry = Geometry::new("walls", 1, wall(0.2).chain(wall(0.8)).collect::<Vec<_>>());
        let lines = Lines::new([0.0; 3], dims.map(|n| 1.0 / f64::from(n)), dims).unwrap();
        Estimate::new(&[geometry], &lines, &Rays::new(0, dims))
    }

    #[test]
    fn what_is_needed_is_enough_and_shares_fit() {
        for dims in [[8, 40, 60], [8, 700, 900], [8, 5000, 3000]] {
            let estimate = estimate(dims);
            for (device, can_spill) in [Device::None, Device::Own, Device::Shared]
                .map(|d| [(d, false), (d, true)])
                .as_flattened()
                .iter()
                .copied()
            {
                let allowed = |max_bytes| Allowed {
                    max_bytes,
                    program_bytes: 10_000_000,
                    device,
                    max_device_bytes: u64::MAX,
                    can_spill,
                    flags: false,
                };
                let needed = MemoryBudget::unchecked(&estimate, &allowed(0)).needed;
                let what = format!("{dims:?}, {device:?}, {can_spill}");
                for max_bytes in [needed, 2 * needed, 10 * needed] {
                    let budget = MemoryBudget::new(&estimate, &allowed(max_bytes)).unwrap();
                    assert_eq!(budget.needed, needed, "{what}");
                    let work = Work::new(&estimate, &allowed(max_bytes));
                    let most_rows = budget.bands.n_rays / estimate.rays_across();
                    let units = if device == Device::None { budget.most_strips.into() } else { most_rows };
                    let shared = if device == Device::Shared { budget.bands.device_bytes } else { 0 };
                    assert!(shared >= work.shared(units), "{what}");
                    let held = 10_000_000 + estimate.host.facets + work.fixed() + work.host_cost(units) + shared;
                    let sum = held + budget.columns.min(estimate.host.columns);
                    assert!(units > 0 && sum <= max_bytes, "{what}: {sum} of {max_bytes}");
                }
                let error = MemoryBudget::new(&estimate, &allowed(needed - 1)).unwrap_err();
                assert!(error.code() == "memory" && !error.hint().is_empty(), "{what}: {error}");
            }
        }
    }

    #[test]
    fn only_devices_without_memory_of_their_own_take_the_hosts() {
        let estimate = estimate([8, 700, 900]);
        let needed = [Device::None, Device::Own, Device::Shared]
            .map(|device| MemoryBudget::unchecked(&estimate, &allowed_one_byte(device, u64::MAX)).needed);
        assert!(needed[2] > needed[1] + estimate.device_bytes_of(BIN), "{needed:?}");
    }

    fn allowed_one_byte(device: Device, max_device_bytes: u64) -> Allowed {
        Allowed { max_bytes: 1, program_bytes: 0, device, max_device_bytes, can_spill: true, flags: false }
    }

    #[test]
    fn a_limit_of_the_devices_memory_is_kept_and_counts_where_that_is_the_hosts() {
        let estimate = estimate([8, 700, 900]);
        let limit = estimate.device_limit_of(BIN) / 2;
        for device in [Device::Own, Device::Shared] {
            let [free, limited] =
                [u64::MAX, limit].map(|max| MemoryBudget::unchecked(&estimate, &allowed_one_byte(device, max)));
            assert_eq!(limited.bands.device_bytes, limit, "{device:?}");
            assert_eq!(limited.needed < free.needed, device == Device::Shared, "{device:?}");
        }
    }
}
