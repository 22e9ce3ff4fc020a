//! What single kernels leave in their buffers, over the whole box in one band, for tests that hold each to its CPU definition. A mesh
//! does not come here.

use super::band::{Context, Forced, Launched, Worker};
use super::buffers::{Array, Sums};
use super::passes::Passes;
use super::readback::Staging;
use crate::cast::Cast;
use crate::error::{Error, Result};

/// The lattice with its tiles.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Tiles {
    /// Numbers of layers, and of bins in a row of bins.
    pub n_layers: u32,
    /// Bins in a row of bins.
    pub n_across: u32,
    /// The first cell after each layer.
    pub layer_ends: Vec<u32>,
    /// First tile of each layer of each bin, then the end.
    pub offsets: Vec<u32>,
    /// What `lattice_fill` wrote: index of the facet in the frame, bin, hits of rows 0 to 3 and 4 to 7.
    pub begun: Vec<[u32; 4]>,
    /// What `intersect` made of it: the two parts of each tile.
    pub tiles: Vec<[u32; 8]>,
}

/// Runs the lattice and `intersect`, with up to so many layers.
///
/// # Errors
/// Those of [`super::Gpu::columns`]; `too-many-crossings` where the box does not fit one band.
pub(crate) async fn tiles(context: Context<'_>, cast: &Cast<'_>, layers: u32) -> Result<Tiles> {
    let forced = Forced { layers: Some(layers), ..Forced::default() };
    let mut worker = Worker::new(context, *cast, forced);
    let launched = worker.prepare(0..cast.rays.counts[1])?.ok_or_else(too_large)?;
    let Launched { params, facets, .. } = launched;
    let Some(buffers) = worker.buffers.take() else { return Err(too_large()) };
    let mut read = async |is_complete: bool| {
        let mut passes = worker.passes();
        if is_complete {
            passes.intersect(&buffers, &params);
        } else {
            passes.lattice(&buffers, &params);
        }
        let encoder = passes.encoder;
        let parts = [buffers.bin_offsets.first(params.n_counters() + 1), buffers.tiles.all()];
        let pending = worker.staging.submit(context.opened, encoder, parts);
        worker.staging.words(context.opened, pending).await
    };
    let [offsets, begun] = read(false).await?;
    let n_tiles = offsets[offsets.len() - 1] as usize;
    if n_tiles as u64 > buffers.capacity.n_tiles {
        return Err(too_large());
    }
    let begun = begun.chunks_exact(8).take(n_tiles);
    let begun = begun.map(|t| [facets.index(t[0] as usize), t[1], t[2], t[3]]).collect();
    let [_, tiles] = read(true).await?;
    let tiles = tiles.chunks_exact(8).take(n_tiles).map(|tile| tile.try_into().unwrap_or_default()).collect();
    let layer_ends = facets.layer_ends().into();
    Ok(Tiles { n_layers: params.n_layers, n_across: params.n_across, layer_ends, offsets, begun, tiles })
}

/// Replaces numbers by the sums of all before them, as the scan kernels do.
///
/// # Errors
/// Those of [`super::Gpu::columns`].
pub(crate) async fn scanned(context: Context<'_>, numbers: &[u32]) -> Result<Vec<u32>> {
    let array = Array::storage(&context.opened.device, "numbers", numbers.len() as u64);
    array.write(&context.opened.queue, numbers);
    let sums = Sums::new(&context.opened.device, numbers.len() as u64);
    let encoder = context.opened.device.create_command_encoder(&Default::default());
    let mut passes = Passes {
        opened: context.opened,
        kernels: context.kernels,
        is_software: context.is_software,
        encoder,
        profile: None,
    };
    passes.scan(array.first(numbers.len() as u64), &sums, 0);
    let encoder = passes.encoder;
    let mut staging = Staging::default();
    let pending = staging.submit(context.opened, encoder, [array.first(numbers.len() as u64)]);
    let [scanned] = staging.words(context.opened, pending).await?;
    Ok(scanned)
}

fn too_large() -> Error {
    Error::new("too-many-crossings", "this box does not fit one band", "take a smaller one")
}
