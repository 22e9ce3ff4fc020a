//! Memory: what the estimate says beside what a mesh took, and meshes that put their columns aside, stop and go on.

use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex};

use hexcast::columns::Store;
use hexcast::control::{CancelToken, Control};
use hexcast::estimate::{Device, Estimate};
use hexcast::job::{AxisChoice, BackendChoice, ByteSize, GeometryJob, Job};
use hexcast::mesh::Mesh;
use hexcast::pipeline::{Aside, Engine, Task, mesh_task, prepare};
use hexcast::report::Report;
use hexcast::sources::Source;
use hexcast::write::{Format, Options, write};

/// A store in memory.
#[derive(Default)]
struct Bytes(Mutex<Vec<u8>>);

impl Store for Bytes {
    fn append(&self, bytes: &[u8]) -> std::io::Result<u64> {
        let mut held = self.0.lock().unwrap();
        held.extend_from_slice(bytes);
        Ok((held.len() - bytes.len()) as u64)
    }

    fn read(&self, at: u64, bytes: &mut [u8]) -> std::io::Result<()> {
        let held = self.0.lock().unwrap();
        let found = held.get(at as usize..at as usize + bytes.len()).ok_or(std::io::ErrorKind::UnexpectedEof)?;
        bytes.copy_from_slice(found);
        Ok(())
    }

    fn truncate(&self, n_bytes: u64) -> std::io::Result<()> {
        self.0.lock().unwrap().truncate(n_bytes as usize);
        Ok(())
    }
}

fn sources(job: &Job) -> Vec<Source> {
    let read = |geometry: &GeometryJob| {
        let path = format!("{}/tests/fixtures/{}", env!("CARGO_MANIFEST_DIR"), geometry.file);
        let bytes = std::fs::read(path).expect("the fixture is there");
        let contents = hexcast::read::read_bytes(&bytes).expect("the fixture is sound");
        Source { file: geometry.file.clone(), contents, sha256: format!("{} bytes", bytes.len()) }
    };
    job.geometries.iter().map(read).collect()
}

fn job(file: &str, dims: [u32; 3], axis: AxisChoice) -> Job {
    Job { geometries: vec![GeometryJob::new(file)], dims: Some(dims), axis, ..Job::default() }
}

fn engine(backend: BackendChoice) -> Engine {
    pollster::block_on(Engine::open(backend, None)).unwrap_or_else(|error| panic!("{backend:?}: {error}"))
}

fn run(job: &Job, engine: &mut Engine, aside: Aside, control: &Control) -> hexcast::Result<(Mesh, Report)> {
    let task = Task { job, read_seconds: 0.0, aside, flags_in_memory: false, program_bytes: 0 };
    pollster::block_on(mesh_task(task, sources(job), engine, control))
}

/// What is estimated too far from what is real.
#[derive(Default)]
struct Far(Vec<String>);

impl Far {
    fn compare(&mut self, estimated: u64, real: u64, what: &str) {
        let ratio = estimated as f64 / real as f64;
        if !(0.75..1.25).contains(&ratio) {
            self.0.push(format!("{what}: {estimated} estimated, {real} real, {ratio:.2}"));
        }
    }
}

#[test]
fn estimates_are_within_a_quarter_of_what_meshes_take() {
    let mut far = Far::default();
    for backend in [BackendChoice::Cpu, BackendChoice::Gpu] {
        let on_gpu = backend == BackendChoice::Gpu;
        for file in ["spot.stl", "featuretype.stl", "bin_color_magics.stl", "bin_header_solid_cube.stl"] {
            for axis in [AxisChoice::X, AxisChoice::Y, AxisChoice::Z] {
                for dims in [[40, 48, 56], [130, 120, 110], [300, 310, 320]] {
                    let job = job(file, dims, axis);
                    let what = format!("{file}, {dims:?} along {axis:?} on {backend:?}");
                    let prepared = prepare(&job, sources(&job)).unwrap();
                    let estimate = Estimate::new(&prepared.geometries, &prepared.lines, &prepared.rays);
                    // one of its own: an engine that has meshed before has larger buffers
                    let (mesh, report) = run(&job, &mut engine(backend), Aside::Nowhere, &Control::default()).unwrap();
                    far.compare(estimate.crossings, report.crossings, &format!("{what}: crossings"));
                    far.compare(estimate.host.columns, mesh.columns.n_bytes(), &format!("{what}: columns"));
                    far.compare(
                        estimate.host.meshing(on_gpu),
                        report.peak_bytes.meshing,
                        &format!("{what}: host bytes"),
                    );
                    if on_gpu {
                        far.compare(estimate.device_bytes, report.peak_bytes.device, &format!("{what}: device bytes"));
                    }
                    let size = |format| {
                        let mut out = std::io::sink();
                        write(&mesh, format, &Options::default(), &mut out, &Control::default()).unwrap().n_bytes
                    };
                    let files = &estimate.file_bytes;
                    assert_eq!([size(Format::Raw), size(Format::Npy)], [files.raw, files.npy], "{what}");
                    far.compare(files.vti, size(Format::Vti), &format!("{what}: .vti"));
                    far.compare(files.hxc, size(Format::Columns), &format!("{what}: .hxc"));
                }
            }
        }
    }
    assert!(far.0.is_empty(), "{}", far.0.join("\n"));
}

/// Bytes of the host's memory that meshing took, the device's if it has none of its own.
fn of_host(report: &Report, engine: &Engine) -> u64 {
    let shared = if engine.device() == Device::Shared { report.peak_bytes.device } else { 0 };
    report.peak_bytes.meshing + shared
}

/// More rays than one round of the CPU and than the first band of the GPU.
fn long_job() -> Job {
    job("spot.stl", [9, 1100, 1100], AxisChoice::X)
}

#[test]
fn columns_put_aside_make_the_same_files() {
    for backend in [BackendChoice::Cpu, BackendChoice::Gpu] {
        let mut engine = engine(backend);
        for axis in [AxisChoice::X, AxisChoice::Z] {
            let job = Job { axis, ..long_job() };
            let (whole, report) = run(&job, &mut engine, Aside::Nowhere, &Control::default()).unwrap();
            assert_eq!(report.peak_bytes.spilled, 0);
            let tight = Job { max_memory: Some(ByteSize(12_000_000)), ..job.clone() };
            let store = Arc::new(Bytes::default());
            let (mesh, report) = run(&tight, &mut engine, Aside::Spill(store), &Control::default()).unwrap();
            assert_eq!(mesh.columns.is_spilled(), report.peak_bytes.spilled > 0);
            if axis == AxisChoice::X {
                assert!(mesh.columns.is_spilled() && mesh.columns.n_bytes() < 100_000);
                assert!(of_host(&report, &engine) < 12_000_000, "{:?}", report.peak_bytes);
            }
            assert_eq!(mesh.columns.cells_per_flag(), whole.columns.cells_per_flag());
            for format in Format::ALL {
                let bytes = |mesh: &Mesh| {
                    let mut out = Vec::new();
                    write(mesh, format, &Options::default(), &mut out, &Control::default()).unwrap();
                    out
                };
                assert!(bytes(&mesh) == bytes(&whole), "{format:?} on {backend:?} along {axis:?}");
            }
        }
    }
}

/// A control that stops after some reports of progress, and the number of them so far.
fn stopping_after(n: u32) -> (Control, Arc<AtomicU32>) {
    let (token, count) = (CancelToken::default(), Arc::new(AtomicU32::new(0)));
    let (stop, counted) = (token.clone(), count.clone());
    let mut control = Control::with_progress(move |_| {
        if counted.fetch_add(1, Ordering::Relaxed) + 1 == n {
            stop.cancel();
        }
    });
    control.cancel = token;
    (control, count)
}

#[test]
fn an_interrupted_mesh_goes_on_from_its_last_band() {
    let job = long_job();
    let mut engines = [engine(BackendChoice::Cpu), engine(BackendChoice::Gpu)];
    // whoever began it and whoever goes on
    for (first, second) in [(0, 0), (1, 1), (0, 1), (1, 0)] {
        let (control, n_whole) = stopping_after(u32::MAX);
        let (whole, _) = run(&job, &mut engines[second], Aside::Nowhere, &control).unwrap();
        let store = Arc::new(Bytes::default());
        let (control, n_first) = stopping_after(1);
        let error = run(&job, &mut engines[first], Aside::Keep(store.clone()), &control).unwrap_err();
        assert_eq!((error.code(), n_first.load(Ordering::Relaxed)), ("cancelled", 1));
        let (control, n_second) = stopping_after(u32::MAX);
        let (mesh, report) = run(&job, &mut engines[second], Aside::Keep(store.clone()), &control).unwrap();
        assert!(report.rays_kept > 0 && report.rays_kept < report.rays, "{} kept", report.rays_kept);
        let [n_whole, n_second] = [n_whole, n_second].map(|n| n.load(Ordering::Relaxed));
        if first == second && first == 0 {
            assert!(n_second < n_whole, "{n_second} rounds, {n_whole} undisturbed");
        }
        assert_eq!(mesh, whole);
        let counts = |mesh: &Mesh| [mesh.columns.n_crossings(), mesh.columns.odd_rays(), mesh.columns.n_runs()];
        assert_eq!(counts(&mesh), counts(&whole));
        // all is there now
        let (control, n_third) = stopping_after(1);
        let (again, report) = run(&job, &mut engines[first], Aside::Keep(store.clone()), &control).unwrap();
        assert_eq!((again == whole, report.rays_kept, n_third.load(Ordering::Relaxed)), (true, report.rays, 0));
        let other = Job { dims: Some([10, 1100, 1100]), ..job.clone() };
        let error = run(&other, &mut engines[first], Aside::Keep(store), &Control::default()).unwrap_err();
        assert_eq!(error.code(), "job-conflict");
    }
}

#[test]
fn a_mesh_that_does_not_fit_is_refused_before_it_starts() {
    let mut cpu = engine(BackendChoice::Cpu);
    let (control, n_rounds) = stopping_after(u32::MAX);
    let job = Job { max_memory: Some(ByteSize(4_000_000)), ..long_job() };
    let error = run(&job, &mut cpu, Aside::Nowhere, &control).unwrap_err();
    assert_eq!((error.code(), n_rounds.load(Ordering::Relaxed)), ("memory", 0));
    let text = error.to_string();
    assert!(text.contains("(columns 6.51 MB, facets") && text.contains("4.00 MB are allowed"), "{text}");
    assert!(error.hint().contains("--spill"), "{}", error.hint());

    let job = Job { max_memory: Some(ByteSize(100_000_000)), cells: Some(700), dims: None, ..long_job() };
    let task = Task { job: &job, read_seconds: 0.0, aside: Aside::Nowhere, flags_in_memory: true, program_bytes: 0 };
    let error = pollster::block_on(mesh_task(task, sources(&job), &mut cpu, &control)).unwrap_err();
    assert_eq!((error.code(), n_rounds.load(Ordering::Relaxed)), ("memory", 0));
    assert!(error.to_string().contains("flags in memory") && error.hint().contains("--flags-in-memory"), "{error}");
}

#[test]
fn bands_and_rounds_are_made_as_small_as_the_budget_asks() {
    let job = job("spot.stl", [900, 1000, 1100], AxisChoice::X);
    for backend in [BackendChoice::Cpu, BackendChoice::Gpu] {
        let mut engine = engine(backend);
        let (whole, _) = run(&job, &mut engine, Aside::Nowhere, &Control::default()).unwrap();
        let mut n_meshed = 0;
        for mega in [1, 2, 4, 8, 12, 16, 24, 40, 80, 200] {
            let max_memory = Some(ByteSize(mega * 1_000_000));
            for aside in [Aside::Nowhere, Aside::Spill(Arc::new(Bytes::default()))] {
                match run(&Job { max_memory, ..job.clone() }, &mut engine, aside, &Control::default()) {
                    Ok((mesh, report)) => {
                        let bytes = of_host(&report, &engine);
                        assert!(bytes <= mega * 1_000_000, "{backend:?}, {mega} MB: {:?}", report.peak_bytes);
                        assert!(mesh == whole, "{backend:?}, {mega} MB");
                        n_meshed += 1;
                    }
                    Err(error) => {
                        assert_eq!(error.code(), "memory", "{error}");
                        assert!(mega < 80, "{backend:?}, {mega} MB: {error}");
                    }
                }
            }
        }
        assert!(n_meshed >= 6, "{n_meshed} on {backend:?}");
    }
}

#[test]
fn buffers_of_a_device_without_memory_of_its_own_count_as_the_hosts() {
    let job = Job { max_memory: Some(ByteSize(3_500_000)), ..long_job() };
    let (cpu, mut gpu) = (&mut engine(BackendChoice::Cpu), engine(BackendChoice::Gpu));
    let spill = || Aside::Spill(Arc::new(Bytes::default()));
    run(&job, cpu, spill(), &Control::default()).unwrap();
    if gpu.device() == Device::Shared {
        let error = run(&job, &mut gpu, spill(), &Control::default()).unwrap_err();
        let text = error.to_string();
        assert!(error.code() == "memory" && text.contains("bands on the GPU"), "{text}");
        assert!(error.hint().contains("--backend cpu"), "{}", error.hint());
    }
    // what the program takes counts, too
    let task = Task { job: &job, read_seconds: 0.0, aside: spill(), flags_in_memory: false, program_bytes: 3_200_000 };
    let error = pollster::block_on(mesh_task(task, sources(&job), cpu, &Control::default())).unwrap_err();
    assert!(error.to_string().contains("program and driver 3.20 MB"), "{error}");
}
