//! A mesh whose runs are on a device, in buffers that the caller's kernels read.
//!
//! Layout, as of [`BoxRuns`](hexcast_core::columns::BoxRuns): `offsets` has a word a ray, the index of its first run, and one more, the number of runs. Ray
//! `i + n_i * j` goes through the cells with index i on the first and j on the second axis across the rays ([`DeviceMesh::ray_axis`]). `runs`
//! has a word a run, `cell << 8 | flag`, ascending along each ray: all cells from `cell` on, to that of the next run of the ray, have the flag. Cells
//! before the first run of a ray have flag 0, as all of a ray without runs have.

use std::fmt;
use std::sync::Arc;

use wgpu::Buffer;

use crate::buffers::{Array, Part};
use crate::device::Opened;
use crate::expand::{Cells, Expander, expand_all, within_scopes};
use crate::kernels::Kernels;
use crate::readback::Staging;
use crate::resident::{Kept, Resident, most_bytes, too_large};
use crate::{Gpu, Options, Usage};
use hexcast_core::base::control::Control;
use hexcast_core::base::error::Result;
use hexcast_core::cells::columns::{BoxRuns, Named};
use hexcast_core::grid::lines::Lines;
use hexcast_core::grid::rays::Rays;
use hexcast_core::stages::cast::Cast;
use hexcast_derived::mesh::Mesh;

/// A mesh on a device. Its buffers have the usages `STORAGE`, `COPY_SRC` and `COPY_DST`, and may be longer than what they hold.
pub struct DeviceMesh {
    opened: Opened,
    kernels: Arc<Kernels>,
    offsets: Buffer,
    runs: Buffer,
    n_runs: u64,
    n_crossings: u64,
    odd_rays: u64,
    checked: [u64; 2],
    rays: Rays,
    lines: Lines,
    names: Vec<Named>,
    unit: Option<String>,
}

impl fmt::Debug for DeviceMesh {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut shown = f.debug_struct("DeviceMesh");
        shown.field("offsets", &self.offsets).field("runs", &self.runs).field("n_runs", &self.n_runs);
        shown.field("rays", &self.rays).finish_non_exhaustive()
    }
}

/// Runs on a device, and what is known of them.
pub struct DeviceRuns {
    pub(super) offsets: Array<u32>,
    pub(super) runs: Array<u32>,
    pub(super) kept: Kept,
    checked: [u64; 2],
    rays: Rays,
}

impl DeviceMesh {
    /// A mesh of runs, of the lines and names that it has.
    #[doc(hidden)]
    pub fn new(gpu: &Gpu, runs: DeviceRuns, lines: Lines, names: Vec<Named>, unit: Option<String>) -> DeviceMesh {
        let DeviceRuns { offsets, runs, kept, checked, rays } = runs;
        let Kept { n_runs, n_crossings, odd_rays, .. } = kept;
        let (offsets, runs) = (offsets.buffer, runs.buffer);
        let (opened, kernels) = (gpu.opened.clone(), gpu.kernels.clone());
        DeviceMesh { opened, kernels, offsets, runs, n_runs, n_crossings, odd_rays, checked, rays, lines, names, unit }
    }

    /// The first run of each ray, then the number of runs: [`DeviceMesh::n_rays`] + 1 words, `array<u32>` in WGSL.
    pub fn offsets(&self) -> &Buffer {
        &self.offsets
    }

    /// The runs, ray after ray: [`DeviceMesh::n_runs`] words, `cell << 8 | flag`, `array<u32>` in WGSL.
    pub fn runs(&self) -> &Buffer {
        &self.runs
    }

    /// Number of runs.
    pub fn n_runs(&self) -> u64 {
        self.n_runs
    }

    /// Number of rays: cells of one axis across them times those of the other.
    pub fn n_rays(&self) -> u64 {
        self.rays.n_rays()
    }

    /// Axis of the rays, 0, 1 or 2. The axes across them are the other two, ascending.
    pub fn ray_axis(&self) -> usize {
        self.rays.axis
    }

    /// Number of cells on x, y, z.
    pub fn dims(&self) -> [u32; 3] {
        self.lines.dims()
    }

    /// The lines between the cells.
    pub fn lines(&self) -> &Lines {
        &self.lines
    }

    /// Names of the flags.
    pub fn names(&self) -> &[Named] {
        &self.names
    }

    /// Unit of the lengths, where it is known.
    pub fn unit(&self) -> Option<&str> {
        self.unit.as_deref()
    }

    /// Number of crossings of rays and facets.
    pub fn n_crossings(&self) -> u64 {
        self.n_crossings
    }

    /// Rays that do not leave every geometry that they enter.
    pub fn odd_rays(&self) -> u64 {
        self.odd_rays
    }

    /// Rays that the CPU has cast again to check the device, and those of them whose cells differed, which is none; both 0 for an upload.
    pub fn device_check(&self) -> [u64; 2] {
        self.checked
    }

    /// Expands all flags to a new buffer of the same device, as [`Expander::flags_buffer`] does of a mesh on the host: it has the usages
    /// `STORAGE`, `COPY_SRC` and `COPY_DST`. Waits for the device.
    ///
    /// # Errors
    /// - `memory`: they are more bytes than a buffer has that a kernel of the device sees.
    /// - `device-failed`: the driver reported an error; `device-lost`: the device is lost.
    pub async fn flags_buffer(&self, form: Cells) -> Result<Buffer> {
        let (opened, of) = (&self.opened, (self.rays.axis, self.dims()));
        told(opened, expand_all(opened, &self.kernels, of, self.parts(), form).await).await
    }

    fn parts(&self) -> [Part<'_>; 2] {
        [&self.offsets, &self.runs].map(|buffer| Part { buffer, words: 1, bytes: [0, buffer.size()] })
    }
}

impl Gpu {
    /// Meshes the box, and leaves the runs on the device.
    ///
    /// # Errors
    /// Those of [`Gpu::columns`]; `memory` where they are more than a buffer holds; `too-many-crossings` where a ray has too many runs.
    #[doc(hidden)]
    pub async fn resident(&self, cast: &Cast<'_>, options: &Options, control: &Control) -> Result<DeviceRuns> {
        let context = self.begin(options);
        self.scoped(async {
            let resident = Resident::new(&self.opened, cast.rays)?;
            let mut usage = Usage::default();
            let rows = 0..cast.rays.counts[1];
            let context = crate::Context { resident: Some(&resident), ..context };
            self.bands((context, options), cast, control, rows, (&mut usage, &mut |_| Ok(()))).await?;
            let (offsets, runs, kept) = match resident.finish(&self.opened).await {
                Ok(finished) => finished,
                Err(error) => return Err(self.opened.cause(error, control).await),
            };
            Ok(DeviceRuns { offsets, runs, kept, checked: usage.checked, rays: *cast.rays })
        })
        .await
    }

    /// Copies the runs of a mesh to this device, in the layout of [`DeviceMesh`]: for meshes that were made elsewhere, read from files, or of
    /// jobs that a device does not mesh alone.
    ///
    /// # Errors
    /// Those of [`Expander::upload`].
    pub async fn upload(&self, mesh: &Mesh) -> Result<DeviceMesh> {
        upload(&self.opened, &self.kernels, mesh).await
    }
}

impl Expander {
    /// Copies the runs of a mesh to the device, in the layout of [`DeviceMesh`].
    ///
    /// # Errors
    /// - `memory`: they are more than a buffer of the device holds.
    /// - `device-failed`: the driver reported an error; `device-lost`: the device is lost.
    /// - `io`: the columns are in a store that fails.
    pub async fn upload(&self, mesh: &Mesh) -> Result<DeviceMesh> {
        upload(&self.opened, &self.kernels, mesh).await
    }
}

/// Waits for the device, and finds the cause where something failed: one that is lost does as if all were well, until it is read from.
async fn told<T>(opened: &Opened, done: Result<T>) -> Result<T> {
    let read = match done {
        Ok(done) => Staging::default().read(opened, opened.encoder(), []).await.map(|[]| done),
        Err(error) => Err(error),
    };
    match read {
        Ok(done) => Ok(done),
        Err(error) => Err(opened.cause(error, &Control::default()).await),
    }
}

async fn upload(opened: &Opened, kernels: &Arc<Kernels>, mesh: &Mesh) -> Result<DeviceMesh> {
    let (columns, allowed) = (mesh.columns(), most_bytes(opened));
    for (what, n) in [("offsets", columns.rays().n_rays() + 1), ("runs", columns.n_runs())] {
        if 4 * n > allowed {
            return Err(too_large(&format!("{n} {what}"), 4 * n, allowed));
        }
    }
    let BoxRuns { offsets, runs } = mesh.box_runs(&mesh.dims().map(|n| 0..n))?;
    let n_runs = runs.len() as u64;
    let written = within_scopes(opened, || {
        Ok([("offsets", offsets), ("runs", runs)].map(|(label, words)| {
            let array = Array::storage(opened, label, words.len() as u64);
            array.write(&opened.queue, &words);
            array.buffer
        }))
    })
    .await;
    let [offsets, runs] = told(opened, written).await?;
    let (n_crossings, odd_rays, checked) = (columns.n_crossings(), columns.odd_rays(), [0; 2]);
    let (lines, names, unit) = (mesh.lines().clone(), mesh.names().to_vec(), mesh.unit().map(str::to_string));
    let (opened, kernels, rays) = (opened.clone(), kernels.clone(), *columns.rays());
    Ok(DeviceMesh { opened, kernels, offsets, runs, n_runs, n_crossings, odd_rays, checked, rays, lines, names, unit })
}
