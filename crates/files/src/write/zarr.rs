//! Zarr v3 stores, in folders and elsewhere: the files of `write::store`, handed to a function one by one.
//!
//! Mesh, options -> keys and values. The shards of a batch are made side by side: [`write_part`] writes those of a window. [`Stored`] checks
//! what was written.
//!
//! Cost: what a row of chunks takes for each of up to four shards side by side, and what these compress to.

mod check;
#[cfg(test)]
mod tests;

pub use crate::write::Place;
use hexcast_core::base::control::{Control, at_once};
use hexcast_core::base::error::Result;
use hexcast_core::base::parallel::*;
use hexcast_core::cells::flags::n_cells;
use hexcast_core::grid::lines::Lines;
use hexcast_core::input::job::ZarrJob;
use hexcast_derived::distance::Distance;
use hexcast_derived::fractions::Fractions;
use hexcast_derived::mesh::{Mesh, Named};

use super::Options;
use super::measured::{distance, solid};
use super::store::{self, Head, OfCells, Store};
pub use check::Stored;

/// Most shards made side by side.
const MAX_SHARDS: usize = 4;

/// Sets the value of a key, on any thread: writes a file of that name, for example, or compares it with what is there.
pub type Set<'a> = dyn Fn(&str, &[u8]) -> Result<()> + Sync + 'a;

/// Writes a mesh to a store, value after value; `advance` is called with the number of cells of every batch of shards that was written,
/// those of coarser levels not.
///
/// # Errors
/// `job-conflict` for bits, which Zarr does not have; those of `set`; `cancelled`, looked at before every batch of shards;
/// those of [`Shards::new`].
pub fn write(mesh: &Mesh, options: &Options, set: &Set<'_>, control: &Control, advance: impl FnMut(u64)) -> Result<()> {
    write_part(mesh, &Place::of_whole(mesh), options, set, control, advance)
}

/// Writes the metadata of a store, the same whichever part writes it, and the shards of a part of its cells.
///
/// # Errors
/// Those of [`write()`]; `job-conflict` where the mesh begins or ends within a shard.
pub fn write_part(
    mesh: &Mesh,
    place: &Place,
    options: &Options,
    set: &Set<'_>,
    control: &Control,
    advance: impl FnMut(u64),
) -> Result<()> {
    put(&Store::new(mesh, place, OfCells::flags(), options)?, options, set, control, advance)
}

/// Refuses coarser levels of a part.
///
/// # Errors
/// `job-conflict`.
#[doc(hidden)]
pub fn check_levels_of_part(zarr: &ZarrJob) -> Result<()> {
    store::check_levels_of_part(zarr)
}

/// What a store of flags says of itself in the file `zarr.json`, for callers that have no mesh yet.
///
/// # Errors
/// Those of [`Shards::new`].
#[doc(hidden)]
pub fn metadata(whole: &Lines, names: &[Named], unit: Option<&str>, options: &Options) -> Result<Vec<u8>> {
    Head { whole, cells: &OfCells::flags(), zarr: options.zarr, compress: options.compress, names, unit }.group()
}

/// Writes the fraction of every cell that is not background as `solid` (float32) to a store of its own.
///
/// # Errors
/// Those of [`write()`]; `job-conflict` where mesh and fractions are not of the same box.
pub fn write_solid(
    mesh: &Mesh,
    fractions: &Fractions,
    options: &Options,
    set: &Set<'_>,
    control: &Control,
) -> Result<()> {
    let files = Store::new(mesh, &Place::of_whole(mesh), solid::cells_of_store(mesh, fractions)?, options)?;
    put(&files, options, set, control, |_| ())
}

/// Writes the signed distance of every cell as `distance` (float64) to a store of its own.
///
/// # Errors
/// Those of [`write()`]; `job-conflict` where mesh and distances are not of the same box, or they are those of nodes.
pub fn write_distance(
    mesh: &Mesh,
    distance: &Distance,
    options: &Options,
    set: &Set<'_>,
    control: &Control,
) -> Result<()> {
    let files = Store::new(mesh, &Place::of_whole(mesh), distance::cells_of_store(mesh, distance)?, options)?;
    put(&files, options, set, control, |_| ())
}

fn put(files: &Store, options: &Options, set: &Set<'_>, control: &Control, advance: impl FnMut(u64)) -> Result<()> {
    files.head()?.iter().try_for_each(|(key, value)| set(key, value))?;
    put_shards(files, (0, options), set, control, advance)?;
    let mut coarser = files.coarser()?;
    while let Some((level, mesh)) = at_once(coarser.next(&control.without_pauses()))? {
        put_shards(&files.of_level(mesh)?, (level, options), set, control, |_| ())?;
    }
    Ok(())
}

/// Writes the shards of a level.
fn put_shards(
    files: &Store,
    (level, options): (usize, &Options),
    set: &Set<'_>,
    control: &Control,
    mut advance: impl FnMut(u64),
) -> Result<()> {
    let n_at_once = (options.slab_bytes as u64 / files.shard_bytes()).clamp(1, MAX_SHARDS as u64);
    for batch in files.shards.chunks(current_num_threads().min(n_at_once as usize)) {
        control.check()?;
        batch.par_iter().try_for_each(|shard| match files.shard(shard)? {
            Some(bytes) => set(&files.name_of(level, shard), &bytes),
            None => Ok(()),
        })?;
        advance(batch.iter().map(|(_, cells)| n_cells(cells) as u64).sum());
    }
    Ok(())
}
