//! The memory budget: how the memory allowed is divided among what meshing holds, or why it is too little.
//!
//! Estimate, what is allowed -> [`MemoryBudget`]. The current work, a round of strips on the CPU or the bands in flight on a GPU, is made
//! as small as it must be. The GPU backend keeps to the bytes that it gets: where bands need more than estimated they become smaller.
//! Weakness: rays are taken to be as crowded everywhere as half again the mean.

use super::Estimate;
use super::memory_limits::{Allowed, Device};
use super::work::Work;
use hexcast_core::base::error::{Error, MORE_MEMORY, Result};
use hexcast_core::grid::rays::Rays;
use hexcast_core::input::job::ByteSize;
use hexcast_core::stages::cpu;
use hexcast_derived::mesh::SLAB_BYTES;
use hexcast_files::write::Options;

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
pub(crate) struct MemoryBudget {
    /// Bytes for the columns.
    pub(crate) columns: u64,
    /// Limits of bands on the GPU.
    pub(crate) bands: BandLimit,
    /// Most strips of a round on the CPU.
    pub(crate) most_strips: u32,
    /// Least bytes of memory that the mesh takes.
    pub(crate) needed: u64,
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

impl Estimate {
    /// Least bytes of memory that the mesh takes, of those that are allowed.
    ///
    /// # Errors
    /// `memory` where that is more than is allowed, with the numbers.
    pub fn needed_bytes(&self, allowed: &Allowed) -> Result<u64> {
        MemoryBudget::new(self, allowed).map(|budget| budget.needed)
    }
}

impl MemoryBudget {
    /// The budget where only the memory of a device may be limited.
    pub(crate) fn unlimited(rays: &Rays, max_device_bytes: u64) -> MemoryBudget {
        let bands = BandLimit { n_rays: rays.n_rays(), device_bytes: max_device_bytes };
        MemoryBudget { columns: u64::MAX, bands, most_strips: cpu::STRIPS_PER_ROUND, needed: 0 }
    }

    /// Shares out the memory allowed.
    ///
    /// # Errors
    /// `memory` where it is too little, with the numbers.
    pub(crate) fn new(estimate: &Estimate, allowed: &Allowed) -> Result<MemoryBudget> {
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
            let spilled_text = ByteSize(spilled).to_string();
            if spilled <= max_bytes {
                MORE_MEMORY.into()
            } else if spilled >= needed || spilled_text == needed_text.to_string() {
                format!("allow {needed_text} with max_memory (--max-memory), or mesh fewer facets or fewer cells")
            } else {
                let spilled = spilled_text;
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
    use super::super::device::BIN;
    use super::*;
    use hexcast_core::grid::lines::Lines;
    use hexcast_core::input::geometry::Geometry;

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
        let geometry = Geometry::new("walls", 1, wall(0.2).chain(wall(0.8)).collect::<Vec<_>>()).unwrap();
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
                let allowed = |max_bytes| {
                    let allowed = Allowed::new(max_bytes).with_program_bytes(10_000_000);
                    allowed.with_device(device, u64::MAX).with_spill(can_spill)
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
        Allowed::new(1).with_device(device, max_device_bytes).with_spill(true)
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
