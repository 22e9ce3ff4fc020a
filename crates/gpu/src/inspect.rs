//! What single kernels leave in their buffers, over the whole box in one band, for tests that hold each to its CPU definition. Meshing
//! does not use it.

use crate::band::{Forced, Launched, Worker, begin};
use crate::buffers::{Array, Part, Sums};
use crate::device_mesh::DeviceRuns;
use crate::expand::Cells;
use crate::readback::Staging;
use crate::{Gpu, Options};
use hexcast_core::base::control::Control;
use hexcast_core::base::error::{Error, Result};
use hexcast_core::cells::columns::BoxRuns;
use hexcast_core::cells::flags::CellBox;
use hexcast_core::stages::cast::Cast;
use hexcast_core::stages::cast::sizes::MAX_TILES;
use hexcast_derived::mesh::Mesh;

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
    /// What `lattice` found, in no order: index of the facet in the frame, bin, rank in its bin and layer, hits of rows 0 to 3 and 4 to 7.
    pub found: Vec<[u32; 5]>,
    /// What `intersect` made of it: the two parts of each tile.
    pub tiles: Vec<[u32; 8]>,
}

#[doc(hidden)]
impl Gpu {
    /// Runs the lattice and `intersect` by themselves, with up to so many layers: for tests.
    ///
    /// # Errors
    /// Those of [`Gpu::columns`]; `too-many-crossings` where the box does not fit one band.
    pub async fn tiles(&self, cast: &Cast<'_>, layers: u32) -> Result<Tiles> {
        let context = self.context(u64::MAX);
        let forced = Forced { layers: Some(layers), ..Forced::default() };
        let mut worker = Worker::new(context, *cast, forced);
        let launched = worker.prepare(0..cast.rays.counts[1])?.ok_or_else(too_large)?;
        let Launched { params, facets, .. } = launched;
        let Some(buffers) = worker.buffers.take() else { return Err(too_large()) };
        let mut passes = begin(context, worker.profile.as_mut());
        passes.lattice(&buffers, &params);
        passes.intersect(&buffers, &params);
        let offsets = buffers.bin_offsets.first(params.n_counters() + 1);
        let parts = [offsets, buffers.found_totals.first(1), buffers.found.all(), buffers.tiles.all()];
        let read = worker.staging.read(context.opened, passes.encoder, parts).await?;
        let [offsets, n_found, found, tiles] = read;
        let n_tiles = offsets[offsets.len() - 1];
        if u64::from(n_tiles) > buffers.capacity.n_tiles {
            return Err(too_large());
        }
        let found = found.chunks_exact(4).take(n_found[0] as usize);
        let found =
            found.map(|f| [facets.index(f[0] as usize), f[1] / MAX_TILES, f[1] % MAX_TILES, f[2], f[3]]).collect();
        let tiles = tiles.chunks_exact(8).take(n_tiles as usize);
        let tiles = tiles.map(|tile| tile.try_into().unwrap_or_default()).collect();
        let layer_ends = facets.layer_ends().into();
        Ok(Tiles { n_layers: params.n_layers, n_across: params.n_across, layer_ends, offsets, found, tiles })
    }

    /// Replaces numbers by the sums of all before them, as the scan kernels do: for tests.
    ///
    /// # Errors
    /// Those of [`Gpu::columns`].
    pub async fn scanned(&self, numbers: &[u32]) -> Result<Vec<u32>> {
        let opened = &self.opened;
        let n = numbers.len() as u64;
        let array = Array::storage(opened, "numbers", n);
        array.write(&opened.queue, numbers);
        let mut passes = begin(self.context(u64::MAX), None);
        passes.scan(array.first(n), &Sums::new(opened, n), 0);
        let [scanned] = Staging::default().read(opened, passes.encoder, [array.first(n)]).await?;
        Ok(scanned)
    }
}

#[doc(hidden)]
impl Gpu {
    /// The bytes of [`Gpu::flags_buffer`]: for tests.
    ///
    /// # Errors
    /// Those of [`Gpu::flags_buffer`].
    pub async fn expanded(&self, mesh: &Mesh, cells: &CellBox, form: Cells) -> Result<Vec<u8>> {
        let buffer = &self.flags_buffer(mesh, cells, form).await?;
        let all = Part { buffer, words: 1, bytes: [0, buffer.size()] };
        let [words] = Staging::default().read(&self.opened, self.opened.encoder(), [all]).await?;
        Ok(bytemuck::cast_slice(&words).to_vec())
    }
}

#[doc(hidden)]
impl Gpu {
    /// The runs that stay on the device: offsets, runs, and the numbers of crossings and of odd rays: for tests.
    ///
    /// # Errors
    /// Those of [`crate::meshing::pipeline::mesh_on_device`].
    pub async fn ordered(&self, cast: &Cast<'_>, options: &Options) -> Result<(BoxRuns, [u64; 2])> {
        let DeviceRuns { offsets, runs, kept, .. } = self.resident(cast, options, &Control::default()).await?;
        let parts = [offsets.first(cast.rays.n_rays() + 1), runs.first(kept.n_runs)];
        let [offsets, runs] = Staging::default().read(&self.opened, self.opened.encoder(), parts).await?;
        Ok((BoxRuns { offsets, runs }, [kept.n_crossings, kept.odd_rays]))
    }
}

fn too_large() -> Error {
    Error::new("too-many-crossings", "this box does not fit one band", "take a smaller one")
}
