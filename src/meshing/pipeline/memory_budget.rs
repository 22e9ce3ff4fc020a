//! How much memory the columns and the work get, and where columns go that do not fit.

use sha2::{Digest, Sha256};

use super::engine::Engine;
use super::options::{DEFAULT_MAX_BYTES, MeshOptions, SpillTarget};
use super::prepare::Prepared;
use crate::meshing::estimate::{Allowed, Estimate, MemoryBudget};
use crate::meshing::report::InputReport;
use hexcast_core::base::checksum::hex;
use hexcast_core::base::control::Control;
use hexcast_core::base::error::{Error, Result};
use hexcast_core::base::memory::Memory;
use hexcast_core::cells::columns::{ColumnsBuilder, Head, Named};
use hexcast_core::grid::closed::Closed;
use hexcast_core::grid::frame::Frame;
use hexcast_core::input::geometry::{Fill, Open, SharedFacets};
use hexcast_core::input::job::{BackendChoice, ByteSize, Job};
use hexcast_core::set;

/// Least limit of a device's memory: even a row of bins at a time, with few facets, takes some buffers.
const LEAST_DEVICE_BYTES: u64 = 1 << 20;

/// Bytes of a facet as it was read, and as it is snapped.
const READ_BYTES: u64 = 36;
const SNAPPED_BYTES: u64 = 38;
/// Bytes of a facet of an open geometry while it is turned to agree with others, and its holes are looked for: corners, their numbers, uses of
/// edges, and lists of these that grow.
const TURNED_BYTES: u64 = 280;

/// What a job allows, of which the program and the facets that were read are held.
///
/// # Errors
/// `memory` where there is no room for these facets.
pub(super) fn memory_of(job: &Job, options: &MeshOptions, prepared: &Prepared, control: &Control) -> Result<Memory> {
    let max_bytes = job.max_memory.map_or(DEFAULT_MAX_BYTES, |size| size.0);
    let memory = control.memory.again(max_bytes, options.program_bytes);
    let facets = || prepared.geometries.iter().map(|geometry| &geometry.facets);
    memory.take_held(facets().map(SharedFacets::n_bytes).sum(), "the facets as they were read")?.keep();
    let of_chunk = facets().map(SharedFacets::chunk_bytes).max().unwrap_or(0);
    memory.take(of_chunk, "facets that are read again, some at a time,")?.keep();
    Ok(memory)
}

/// Refuses copies of facets that do not fit: of geometries that are decided apart, for what is measured at them, and near a window.
///
/// # Errors
/// `memory`.
pub(super) fn check_copies(
    job: &Job,
    (frame, closed): (&Frame, &[Closed]),
    prepared: &Prepared,
    memory: &Memory,
) -> Result<()> {
    let n_all = frame.facets.len() as u64;
    let mut bytes = if job.is_measured() { SNAPPED_BYTES * n_all } else { 0 };
    let mut has_parts = false;
    for (position, &index) in frame.ranks.geometry_at.iter().enumerate() {
        let (n, geometry) = (frame.range_at(position).len() as u64, &prepared.geometries[index]);
        let is_open = !closed[position].by(job.rule) && !matches!(geometry.open, Open::Parity | Open::Error);
        let is_filled = geometry.fill != Fill::Centre;
        bytes += n * (if is_open { TURNED_BYTES } else { 0 } + if is_filled { READ_BYTES } else { 0 });
        has_parts |= is_open || is_filled || geometry.invert;
    }
    bytes += SNAPPED_BYTES * n_all * (u64::from(has_parts) + u64::from(prepared.window.is_some()));
    memory.check(bytes, "copies of facets, for open, filled, inverted or measured geometries and windows,")
}

/// Compares the estimate of a job with the memory allowed, of which open geometries and cells along surfaces take `parts_bytes`; the facets of the
/// frame are cast.
///
/// # Errors
/// `memory`; `cancelled`.
pub(super) async fn memory_budget(
    job: &Job,
    options: &MeshOptions,
    prepared: &Prepared,
    (engine, frame, parts_bytes): (&Engine, &Frame, u64),
    control: &Control,
) -> Result<MemoryBudget> {
    let max_bytes = job.max_memory.map_or(DEFAULT_MAX_BYTES, |size| size.0);
    if parts_bytes > max_bytes.saturating_sub(options.program_bytes) {
        let (needed, max) = (ByteSize(parts_bytes), ByteSize(max_bytes));
        let message = format!(
            "to decide geometries that are not closed or are filled takes about {needed} of memory; {max} are allowed"
        );
        let hint = "allow more with max_memory (--max-memory), use larger cells, close the surfaces, leave them to the rays of one \
                    axis with open = \"parity\" (--open parity), or fill = \"centre\" (--fill centre)";
        return Err(Error::new("memory", message, hint));
    }
    let can_spill = !matches!(options.spill, SpillTarget::None);
    let max_device_bytes = options.max_device_bytes.unwrap_or(u64::MAX);
    if max_device_bytes < LEAST_DEVICE_BYTES {
        let (least, max) = (ByteSize(LEAST_DEVICE_BYTES), ByteSize(max_device_bytes));
        let message = format!("a GPU needs {least} of its memory at least; {max} are allowed");
        return Err(Error::new("memory", message, "allow more (--max-device-memory), or use the CPU (--backend cpu)"));
    }
    if max_bytes == u64::MAX && !can_spill {
        return Ok(MemoryBudget::unlimited(&prepared.rays, max_device_bytes));
    }
    let (geometries, lines, rays) = (&prepared.geometries, &prepared.lines, &prepared.rays);
    let is_cast_whole = parts_bytes == 0 && prepared.window.is_none() && !frame.is_graded();
    let estimate = match is_cast_whole {
        true => Estimate::of_frame(frame, geometries, lines, rays),
        false => Estimate::with_rests(geometries, lines, rays, control).await?,
    };
    let allowed = Allowed::new(max_bytes).with_program_bytes(options.program_bytes + parts_bytes);
    let allowed = allowed.with_device(engine.device(), max_device_bytes).with_spill(can_spill);
    let allowed = allowed.with_rays(job.rule, prepared.geometries.len(), prepared.rays.depth);
    MemoryBudget::new(&estimate, &allowed.with_flags(options.flags_in_memory))
}

/// A builder without rays yet, or with those that an interrupted run of the same job left.
///
/// # Errors
/// Those of [`ColumnsBuilder::resume`]; `job-value` where the names are too long for the head of a column file.
pub(super) fn columns_builder(
    job: &Job,
    spill: &SpillTarget,
    max_bytes: u64,
    prepared: &Prepared,
    (names, inputs): (&[Named], &[InputReport]),
) -> Result<ColumnsBuilder> {
    let rays = prepared.rays;
    let head = |identity: Option<[u8; 32]>| {
        // a job with another unit is the same job
        let unit = prepared.unit.clone().filter(|_| identity.is_none());
        Head { identity, rays, zlib: false, lines: prepared.lines.clone(), unit, names: names.to_vec() }.encode()
    };
    match spill {
        SpillTarget::None => Ok(ColumnsBuilder::new(rays, max_bytes, None)),
        SpillTarget::Temporary(store) => Ok(ColumnsBuilder::new(rays, max_bytes, Some((head(None)?, store.clone())))),
        SpillTarget::Resumable(store) => {
            ColumnsBuilder::resume(rays, max_bytes, head(Some(identity(job, prepared, inputs)?))?, store.clone())
        }
    }
}

/// Hashes everything that decides the columns: the version, the job without backend and memory, the hashes of its files, or of all
/// facets where some were in memory, the lines and the rays.
fn identity(job: &Job, prepared: &Prepared, inputs: &[InputReport]) -> Result<[u8; 32]> {
    // gaps are closed in finished columns
    let job =
        set!(Job { close_gaps: None, gap_flag: None, certify: false, quick: false, thin_cells: None, ..job.clone() });
    let job = set!(Job { backend: BackendChoice::Auto, max_memory: None, max_cells: None, unit: None, ..job });
    let hash = |input: &InputReport| input.blake3.clone().map_or_else(|| hash_of_facets(prepared), Ok);
    let files: Vec<String> = inputs.iter().map(hash).collect::<Result<_>>()?;
    let facts = [
        env!("CARGO_PKG_VERSION").to_string(),
        job.to_json(),
        files.join(" "),
        format!("{:?} {:?}", prepared.lines, prepared.rays),
    ];
    Ok(Sha256::digest(facts.join("\n")).into())
}

/// SHA-256 of the facets of all geometries: their numbers, 4 bytes each, little-endian.
fn hash_of_facets(prepared: &Prepared) -> Result<String> {
    let mut hash = Sha256::new();
    for geometry in &prepared.geometries {
        geometry.facets.for_each(|facet| {
            hash.update(facet.as_flattened().iter().flat_map(|number| number.to_le_bytes()).collect::<Vec<u8>>());
        })?;
    }
    Ok(hex(&hash.finalize()))
}
