//! The GPU backend: the stages as WGSL kernels, in bands of ray rows.
//!
//! # Theory
//! The stages and their values are those of the CPU definition; nothing but their types is shared. A band goes through
//! `lattice` -> scan -> `intersect` -> `map`, and rows that these cannot decide through `intersect_deep` ->
//! scan -> `map_deep`. Atomics only count and hand out places; the order they give is sorted away, so the columns are the
//! same bytes on every device and for every band. No invocation of any kernel runs more than 2^14 loops (`passes.rs`).
//!
//! A device is not trusted. It is probed when it is opened; all its results are checked for impossible values (`runs.rs`); one
//! ray in 256 is cast again by the CPU definition (`check.rs`). If a result is wrong, its band is thrown away, and meshing fails
//! with `device-wrong`: the engine then continues on the CPU.
//!
//! # Practice
//! - [`Gpu`]: a device, its compiled kernels and its pool. Expensive (a tenth of a second to seconds): make one, use it for many meshes.
//! - `Worker`: the buffers of one band at a time; up to three of them work on a mesh. It lives as long as the mesh; its buffers go
//!   to the pool, which keeps 256 MiB of them for the next mesh.
//! - `Launched`: a band on the device; lives until its results are read back.
//!
//! All calls are async because a browser cannot block; natively they complete on the calling thread under any executor.

use std::collections::VecDeque;
use std::sync::Arc;

use hexcast_core::base::control::Control;
use hexcast_core::base::error::{Error, Result};
use hexcast_core::cells::columns::{Band, Columns};
use hexcast_core::stages::cast::Cast;
use hexcast_core::stages::cast::sizes::{BANDS_IN_FLIGHT, BIN, upload_bytes};

mod band;
mod buffers;
mod check;
mod crossings;
mod device;
mod device_bytes;
mod device_mesh;
mod expand;
mod failure;
mod inspect;
mod kernels;
mod layout;
mod needs;
mod pace;
mod passes;
mod probe;
mod readback;
mod resident;
mod runs;
#[cfg(not(target_arch = "wasm32"))]
mod warm_up;

#[doc(hidden)]
pub use band::Forced;
use band::{Context, Launched, Outcome, Worker};
use buffers::BufferPool;
#[doc(hidden)]
pub use buffers::SCAN_BLOCK;
pub use device::{AdapterFacts, AdapterKind, adapter, adapters, device_limits, instance};
use device::{Opened, find};
pub use device_mesh::DeviceMesh;
pub use expand::{Cells, Expander};
#[doc(hidden)]
pub use inspect::Tiles;
use kernels::Kernels;
pub use kernels::expand_text;
#[doc(hidden)]
pub use kernels::{Edit, Kernel, KernelText, Slot, kernel_texts};
#[doc(hidden)]
pub use layout::Params;
use pace::Pace;
#[doc(hidden)]
pub use passes::{DEEP_ITEMS_OF_THREAD, GRADED_ITEMS_OF_THREAD, ITEMS_OF_THREAD, Profile, TILES_OF_THREAD};
#[doc(hidden)]
pub use probe::MOST_LOOPS;
#[doc(hidden)]
pub use runs::{DEEP, LEFT, LINKED};
// of the devices, queues and buffers here
pub use wgpu;
pub use wgpu::{Device, Instance, Queue};

/// Time that a band aims at: long enough to hide its overhead, which on a software driver is some ten milliseconds; short
/// enough that no driver gives up on it, and that Cancel does not wait.
const BAND_SECONDS: f64 = 0.25;
/// The same where a browser draws its pages with the same GPU: a frame at 60 a second.
const FRAME_SECONDS: f64 = 0.016;

/// An open device with all kernels compiled.
#[non_exhaustive]
pub struct Gpu {
    /// What it runs on.
    pub facts: AdapterFacts,
    opened: Opened,
    kernels: Arc<Kernels>,
    pool: BufferPool,
}

/// How a mesh is run; no choice changes the result.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[doc(hidden)]
pub struct Options {
    /// Fixes the number of ray rows of a band; otherwise it follows from the limits and the speed of the device.
    pub rows_per_band: Option<u32>,
    /// Most ray rows of a band, if not what the device allows.
    pub most_rows: Option<u32>,
    /// Most bytes of buffers that the device holds at once, if not what it has. Bands are as small as that takes; what a device cannot do
    /// in so many bytes the CPU does.
    pub max_bytes: Option<u64>,
    /// Waits for every kernel and measures it.
    pub profile: bool,
    /// For tests.
    pub forced: Forced,
}

/// What a mesh has used of the device, and what was found in its results.
#[derive(Debug, Clone, Default, PartialEq)]
#[doc(hidden)]
pub struct Usage {
    /// Most bytes of buffers held at once, with those that wait for the next mesh.
    pub peak_bytes: u64,
    /// Most bytes on the host of facets on their way to the device.
    pub host_bytes: u64,
    /// Bands that were finished.
    pub n_bands: u32,
    /// Ray rows of the last of them.
    pub rows_of_band: u32,
    /// Rays that the CPU cast again, and those of them whose cells differed.
    pub checked: [u64; 2],
    /// Rows of eight rays that were left to the deep kernels.
    pub deep: u64,
    /// Rays that the CPU cast because no kernel could.
    pub left: u64,
    /// Seconds in each kernel, if asked for.
    pub profile: Option<Profile>,
}

impl Gpu {
    /// Opens the adapter that the system prefers for heavy work, or the first whose name contains `wanted`.
    ///
    /// # Errors
    /// - `no-adapter`: there is none, or none of that name.
    /// - `device-failed`: the driver refused the device or a kernel.
    /// - `device-wrong`: the driver fails a check of what every mesh relies on.
    pub async fn open(wanted: Option<&str>) -> Result<Gpu> {
        Gpu::open_in(&instance(), wanted, None).await
    }

    /// The same, with kernels whose text is changed before they are compiled: for tests of what a broken driver would do.
    ///
    /// # Errors
    /// Those of [`Gpu::open`].
    #[doc(hidden)]
    pub async fn open_edited(wanted: Option<&str>, edit: Option<Edit>) -> Result<Gpu> {
        Gpu::open_in(&instance(), wanted, edit).await
    }

    /// The same, of an instance that the caller has.
    ///
    /// # Errors
    /// Those of [`Gpu::open`].
    #[doc(hidden)]
    pub async fn open_in(instance: &wgpu::Instance, wanted: Option<&str>, edit: Option<Edit>) -> Result<Gpu> {
        let adapter = find(instance, wanted).await?;
        let opened = Opened::new(&adapter).await?;
        let kernels = Kernels::shared(&opened.device, edit);
        let gpu = Gpu { facts: device::facts(&adapter), opened, kernels, pool: BufferPool::default() };
        gpu.prepare().await?;
        Ok(gpu)
    }

    /// Takes a device of the caller's and its queue: whatever instance, adapter, limits and features they came with. Meshes are made there,
    /// beside the caller's own work, and `Mesher::mesh_on_device` leaves their runs there. Both are handles: clones are the same
    /// device.
    ///
    /// The device needs no features, and the limits of [`device_limits`] at most: `Limits::default()` suffices. Buffers as large as the
    /// adapter offers make bands larger. hexcast leaves the handlers of the device alone (`on_uncaptured_error`, `set_device_lost_callback`):
    /// its own errors come back from its calls, and those of the caller go where they went. It never destroys the device. A lost device
    /// is an error, as no other could have the caller's buffers. Natively only: in browsers the JavaScript package has it.
    ///
    /// # Errors
    /// - `device-failed`: a limit of the device is too small, with all that are; or the driver refused a kernel.
    /// - `device-wrong`: the driver fails a check of what every mesh relies on.
    /// - `device-lost`: it is.
    #[cfg(not(target_arch = "wasm32"))]
    pub async fn from_device(device: Device, queue: Queue) -> Result<Gpu> {
        let limits = device.limits();
        needs::check_limits(&limits)?;
        let facts = device::facts_of(device.adapter_info(), &limits);
        let kernels = Kernels::shared(&device, None);
        let gpu = Gpu { facts, opened: Opened::of_caller(&device, &queue), kernels, pool: BufferPool::default() };
        gpu.scoped(gpu.prepare()).await.map(|()| gpu)
    }

    /// Compiles the kernels that nearly every mesh needs, and looks whether the device computes as it must.
    async fn prepare(&self) -> Result<()> {
        self.kernels.compile_common(self.opened.is_callers);
        #[cfg(not(target_arch = "wasm32"))]
        if self.facts.kind == AdapterKind::Software {
            warm_up::warm_up(self.context(u64::MAX))?;
        }
        probe::probe(&self.opened, &self.kernels, &self.facts.to_string()).await?;
        self.opened.check()
    }

    /// Whether the device is the caller's: it is not opened again where it is lost.
    #[doc(hidden)]
    pub fn is_callers(&self) -> bool {
        self.opened.is_callers
    }

    /// Does something with the device, and hears of its errors. Of a device of the caller's each call begins without those of the last.
    async fn scoped<T>(&self, work: impl Future<Output = Result<T>>) -> Result<T> {
        if !self.opened.is_callers {
            return work.await;
        }
        self.opened.failure.forget();
        #[cfg(not(target_arch = "wasm32"))]
        let done = failure::Scoped::new((&self.opened.device, &self.opened.failure), work).await;
        #[cfg(target_arch = "wasm32")]
        let done = work.await;
        match done.and_then(|done| self.opened.check().map(|()| done)) {
            Ok(done) => Ok(done),
            Err(error) => Err(self.opened.cause(error, &Control::default()).await),
        }
    }

    /// The device, for kernels of the caller's own beside ours.
    pub fn device(&self) -> &Device {
        &self.opened.device
    }

    /// The queue of the device.
    pub fn queue(&self) -> &Queue {
        &self.opened.queue
    }

    /// Frees the buffers that are kept for the next mesh if they have more than so many bytes.
    #[doc(hidden)]
    pub fn clear_pool_over(&self, max_bytes: u64) {
        self.pool.clear_over(max_bytes);
        // natively buffers go when the device is asked how it is; what it returns is told elsewhere
        let _ = self.opened.device.poll(wgpu::PollType::Poll);
    }

    /// Meshes the box.
    ///
    /// # Errors
    /// `cancelled`; `device-failed`, `device-lost`; `device-wrong` where the results of the device cannot be right.
    #[doc(hidden)]
    pub async fn columns(&self, cast: &Cast<'_>, control: &Control) -> Result<Columns> {
        let mut bands = Vec::new();
        self.continue_columns(cast, &Options::default(), control, &mut bands).await?;
        Columns::new(*cast.rays, bands)
    }

    /// Meshes the rays after those of `bands` and appends theirs; on an error `bands` holds all that was finished.
    ///
    /// # Errors
    /// Those of [`Gpu::columns`].
    #[doc(hidden)]
    pub async fn continue_columns(
        &self,
        cast: &Cast<'_>,
        options: &Options,
        control: &Control,
        bands: &mut Vec<Band>,
    ) -> Result<Usage> {
        let n_rays: u64 = bands.iter().map(|band| band.ends.len() as u64).sum();
        let first_row = (n_rays / u64::from(cast.rays.counts[0])) as u32;
        let mut usage = Usage::default();
        let take = &mut |band| {
            bands.push(band);
            Ok(())
        };
        self.hand_out_bands(cast, options, control, first_row..cast.rays.counts[1], &mut usage, take).await?;
        Ok(usage)
    }

    /// Meshes some ray rows and hands out band after band, in order, while the device works on the next; adds to `usage`.
    ///
    /// # Errors
    /// Those of [`Gpu::columns`], and those of `take`.
    #[doc(hidden)]
    pub async fn hand_out_bands(
        &self,
        cast: &Cast<'_>,
        options: &Options,
        control: &Control,
        ray_rows: std::ops::Range<u32>,
        usage: &mut Usage,
        take: &mut impl FnMut(Band) -> Result<()>,
    ) -> Result<()> {
        let context = self.begin(options);
        self.scoped(self.bands((context, options), cast, control, ray_rows, (usage, take))).await
    }

    /// The same within a context, which says where the runs go.
    async fn bands<'a>(
        &'a self,
        (mut context, options): (Context<'a>, &Options),
        cast: &Cast<'a>,
        control: &Control,
        ray_rows: std::ops::Range<u32>,
        (usage, take): (&mut Usage, &mut impl FnMut(Band) -> Result<()>),
    ) -> Result<()> {
        let n_i = cast.rays.counts[0];
        let mut pace = Pace::new(options.rows_per_band, options.most_rows, n_i, self.band_seconds());
        let mut next = ray_rows.start;
        let mut idle = vec![Worker::new(context, *cast, options.forced)];
        idle[0].profile = options.profile.then(Profile::new);
        let mut in_flight_most = if options.profile { 1 } else { BANDS_IN_FLIGHT };
        let mut in_flight: VecDeque<(Worker, Launched)> = VecDeque::new();
        loop {
            control.check()?;
            while next < ray_rows.end && in_flight.len() < in_flight_most {
                let range = next..next.saturating_add(pace.rows).min(ray_rows.end);
                let sibling = || in_flight.front().map(|(first, _)| first.sibling());
                let worker = idle.pop().or_else(sibling);
                let mut worker = worker.unwrap_or_else(|| Worker::new(context, *cast, options.forced));
                match worker.launch(range.clone())? {
                    Some(launched) => {
                        in_flight.push_back((worker, launched));
                        next = range.end;
                    }
                    None if range.end - range.start > BIN => {
                        pace.limit((range.end - range.start).div_ceil(2));
                        idle.push(worker);
                    }
                    None => {
                        // from now on each band has the memory of all, once those before are done
                        (context.n_bands, in_flight_most) = (1, 1);
                        idle.drain(..).chain([worker]).for_each(Worker::end);
                    }
                }
            }
            let facets = in_flight.iter().map(|(_, launched)| launched.facets.len() as u64);
            usage.host_bytes = usage.host_bytes.max(upload_bytes(facets.clone().sum(), facets.max().unwrap_or(0)));
            usage.peak_bytes = usage.peak_bytes.max(self.opened.held.peak());
            let Some((mut worker, launched)) = in_flight.pop_front() else { break };
            let range = launched.rows.clone();
            match worker.complete(launched).await {
                Err(error) => return Err(self.opened.cause(error, control).await),
                Ok(Outcome::Done(band, [n_checked, n_deep, n_left])) => {
                    usage.checked[0] += n_checked;
                    usage.deep += n_deep;
                    usage.left += n_left;
                    take(band)?;
                }
                Ok(Outcome::Wrong(what, checked)) => return Err(self.wrong(usage, &what, checked)),
                Ok(again @ (Outcome::Again | Outcome::TooMany)) => {
                    if matches!(again, Outcome::TooMany) {
                        pace.limit((range.end - range.start).div_ceil(2));
                    }
                    // the bands behind it stand on their own, but columns are handed out in order: start again from here
                    in_flight.clear();
                    idle.clear();
                    // their buffers go when the device is done with them
                    let _ = self.opened.device.poll(wgpu::PollType::wait_indefinitely());
                    next = range.start;
                    idle.push(worker);
                    continue;
                }
            }
            control.pause().await;
            control.advance(u64::from(range.end) * u64::from(n_i), cast.rays.n_rays());
            pace.finished(range.end - range.start, worker.host_seconds);
            usage.n_bands += 1;
            usage.rows_of_band = range.end - range.start;
            usage.profile = worker.profile.clone();
            if worker.context.n_bands == context.n_bands { idle.push(worker) } else { worker.end() }
        }
        idle.into_iter().for_each(Worker::end);
        Ok(())
    }

    /// The error of a device that returned what is wrong: a sentence, the rays that were looked at, and those that were wrong.
    fn wrong(&self, usage: &mut Usage, what: &str, checked: [u64; 2]) -> Error {
        usage.checked = [0, 1].map(|i| usage.checked[i] + checked[i]);
        Error::new("device-wrong", format!("the results of {} are wrong: {what}", self.facts), device::USE_CPU)
    }

    fn context(&self, max_bytes: u64) -> Context<'_> {
        let is_software = self.facts.kind == AdapterKind::Software;
        let n_bands = BANDS_IN_FLIGHT as u64;
        let (opened, kernels, pool) = (&self.opened, &self.kernels, &self.pool);
        Context { opened, kernels, pool, is_software, max_bytes, n_bands, resident: None }
    }

    /// Frees what waits for this mesh if it is too much for it, and counts from now on what the device holds.
    fn begin(&self, options: &Options) -> Context<'_> {
        let max_bytes = options.max_bytes.unwrap_or(u64::MAX);
        self.clear_pool_over(max_bytes);
        self.opened.held.begin();
        self.context(max_bytes)
    }

    fn band_seconds(&self) -> f64 {
        let draws_pages = cfg!(target_arch = "wasm32") && self.facts.kind != AdapterKind::Software;
        if draws_pages { FRAME_SECONDS } else { BAND_SECONDS }
    }
}
