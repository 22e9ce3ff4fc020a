//! Memory: estimates beside what meshes took; meshes whose columns spill; meshes that stop and continue.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use hexcast::columns::MemoryStore;
use hexcast::control::{CancelToken, Control};
use hexcast::estimate::{Device, Estimate};
use hexcast::job::{AxisChoice, BackendChoice, ByteSize, GeometryJob, Job};
use hexcast::mesh::Mesh;
use hexcast::pipeline::{self, Engine, MeshOptions, SpillTarget, prepare};
use hexcast::report::MeshFacts;
use hexcast::sources::Source;
use hexcast::write::{Format, Options, write};

use super::tolerances::far_off;

fn sources(job: &Job) -> Vec<Source> {
    let read = |geometry: &GeometryJob| {
        let path = format!("{}/tests/fixtures/{}", env!("CARGO_MANIFEST_DIR"), geometry.file);
        let bytes = std::fs::read(path).expect("the fixture is there");
        let contents = hexcast::read::read_bytes(&bytes).expect("the fixture is sound");
        Source::new(geometry.file.clone(), contents, Some(format!("{} bytes", bytes.len())))
    };
    job.geometries.iter().map(read).collect()
}

fn job(file: &str, dims: [u32; 3], axis: AxisChoice) -> Job {
    set!(Job { geometries: vec![GeometryJob::new(file)], dims: Some(dims), axis, ..Job::default() })
}

fn engine(backend: BackendChoice) -> Engine {
    pollster::block_on(Engine::open(backend, None)).unwrap_or_else(|error| panic!("{backend:?}: {error}"))
}

fn run(job: &Job, engine: &mut Engine, spill: SpillTarget, control: &Control) -> hexcast::Result<(Mesh, MeshFacts)> {
    mesh(job, engine, &MeshOptions::default().with_spill(spill), control)
}

fn mesh(
    job: &Job,
    engine: &mut Engine,
    options: &MeshOptions,
    control: &Control,
) -> hexcast::Result<(Mesh, MeshFacts)> {
    on_two_threads(|| pollster::block_on(pipeline::mesh(job, sources(job), options, engine, control)))
}

/// Does something on two threads: what is enough memory depends on them.
pub(crate) fn on_two_threads<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("two threads").install(work)
}

#[test]
fn estimates_are_near_what_meshes_take_on_cpu_and_gpu() {
    let mut wrong = Vec::new();
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
                    let (mesh, facts) =
                        run(&job, &mut engine(backend), SpillTarget::None, &Control::default()).unwrap();
                    let size = |format| {
                        let mut out = std::io::sink();
                        write(&mesh, format, &Options::default(), &mut out, &Control::default()).unwrap().n_bytes
                    };
                    let files = &estimate.file_bytes;
                    assert_eq!([size(Format::Raw), size(Format::Npy)], [files.raw, files.npy], "{what}");
                    let mut pairs = vec![
                        ("crossings", estimate.crossings, facts.crossings),
                        ("columns", estimate.host.columns, mesh.columns().n_bytes()),
                        ("host", estimate.host.meshing(on_gpu), facts.peak_bytes.meshing),
                        ("vti", files.vti, size(Format::Vti)),
                        ("hxc", files.hxc, size(Format::Columns)),
                    ];
                    pairs.extend(on_gpu.then_some(("device", estimate.device_bytes, facts.peak_bytes.device)));
                    let far = pairs.iter().filter_map(|&(name, estimated, real)| far_off(name, estimated, real));
                    wrong.extend(far.map(|far| format!("{what}: {far}")));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Bytes of the host's memory that meshing took, the device's if it has none of its own.
fn of_host(report: &MeshFacts, engine: &Engine) -> u64 {
    let shared = if engine.device() == Device::Shared { report.peak_bytes.device } else { 0 };
    report.peak_bytes.meshing + shared
}

/// A job with more rays than one round of the CPU and than the first band of the GPU.
fn long_job() -> Job {
    job("spot.stl", [9, 1100, 1100], AxisChoice::X)
}

/// The same with rays along z.
fn long_job_along_z() -> Job {
    job("spot.stl", [1100, 1100, 9], AxisChoice::Z)
}

#[test]
fn columns_that_spill_make_the_same_files_on_cpu_and_gpu() {
    for backend in [BackendChoice::Cpu, BackendChoice::Gpu] {
        let mut engine = engine(backend);
        for job in [long_job(), long_job_along_z()] {
            let what = format!("{backend:?} along {:?}", job.axis);
            let (whole, facts) = run(&job, &mut engine, SpillTarget::None, &Control::default()).unwrap();
            assert_eq!(facts.peak_bytes.spilled, 0, "{what}");
            let tight = set!(Job { max_memory: Some(ByteSize(12_000_000)), ..job });
            let store = Arc::new(MemoryStore::default());
            let (mesh, facts) = run(&tight, &mut engine, SpillTarget::Temporary(store), &Control::default()).unwrap();
            assert!(mesh.columns().is_spilled() && facts.peak_bytes.spilled > 1_000_000, "{what}");
            assert!(mesh.columns().n_bytes() < 100_000, "{what}: {}", mesh.columns().n_bytes());
            assert!(of_host(&facts, &engine) < 12_000_000, "{what}: {:?}", facts.peak_bytes);
            assert_eq!(mesh.columns().cells_per_flag(), whole.columns().cells_per_flag(), "{what}");
            for format in Format::FILES {
                let bytes = |mesh: &Mesh| {
                    let mut out = Vec::new();
                    write(mesh, format, &Options::default(), &mut out, &Control::default()).unwrap();
                    out
                };
                assert!(bytes(&mesh) == bytes(&whole), "{format:?} on {what}");
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
fn doubtful_cells_on_rays_that_an_interrupted_mesh_has_kept_are_found_again() {
    let job = long_job();
    let mut open = sources(&job);
    let solid = &mut open[0].contents.solids[0];
    solid.facets = solid.facets.slice()[20..].to_vec().into();
    let run = |spill: SpillTarget, control: &Control| {
        let options = MeshOptions::default().with_spill(spill);
        pollster::block_on(pipeline::mesh(&job, open.clone(), &options, &mut Engine::cpu(), control))
    };
    let (_, whole) = run(SpillTarget::None, &Control::default()).unwrap();
    let store = Arc::new(MemoryStore::default());
    run(SpillTarget::Resumable(store.clone()), &stopping_after(1).0).unwrap_err();
    let (_, report) = run(SpillTarget::Resumable(store), &Control::default()).unwrap();
    assert!(report.rays_kept > 0 && report.rays_kept < report.rays, "{} kept", report.rays_kept);
    assert!(whole.doubtful.cells > 100, "{:?}", whole.doubtful);
    assert_eq!((report.doubtful, report.open), (whole.doubtful, whole.open));
}

#[test]
fn an_interrupted_mesh_continues_from_its_last_band_on_cpu_and_gpu() {
    let job = long_job();
    let mut engines = [engine(BackendChoice::Cpu), engine(BackendChoice::Gpu)];
    // the backend that begins, and the one that continues
    for (first, second) in [(0, 0), (1, 1), (0, 1), (1, 0)] {
        let (control, n_whole) = stopping_after(u32::MAX);
        let (whole, _) = run(&job, &mut engines[second], SpillTarget::None, &control).unwrap();
        let store = Arc::new(MemoryStore::default());
        let (control, n_first) = stopping_after(1);
        let error = run(&job, &mut engines[first], SpillTarget::Resumable(store.clone()), &control).unwrap_err();
        assert_eq!((error.code(), n_first.load(Ordering::Relaxed)), ("cancelled", 1));
        let (control, n_second) = stopping_after(u32::MAX);
        let (mesh, report) = run(&job, &mut engines[second], SpillTarget::Resumable(store.clone()), &control).unwrap();
        assert!(report.rays_kept > 0 && report.rays_kept < report.rays, "{} kept", report.rays_kept);
        let [n_whole, n_second] = [n_whole, n_second].map(|n| n.load(Ordering::Relaxed));
        if first == second && first == 0 {
            assert!(n_second < n_whole, "{n_second} rounds, {n_whole} undisturbed");
        }
        assert_eq!(mesh, whole);
        let counts = |mesh: &Mesh| [mesh.columns().n_crossings(), mesh.columns().odd_rays(), mesh.columns().n_runs()];
        assert_eq!(counts(&mesh), counts(&whole));
        // all is there now
        let (control, n_third) = stopping_after(1);
        let (again, report) = run(&job, &mut engines[first], SpillTarget::Resumable(store.clone()), &control).unwrap();
        assert_eq!((again == whole, report.rays_kept, n_third.load(Ordering::Relaxed)), (true, report.rays, 0));
        let other = set!(Job { dims: Some([10, 1100, 1100]), ..job.clone() });
        let error = run(&other, &mut engines[first], SpillTarget::Resumable(store), &Control::default()).unwrap_err();
        assert_eq!(error.code(), "columns-other");
    }
}

#[test]
fn a_mesh_that_does_not_fit_is_refused_before_it_starts() {
    let mut cpu = engine(BackendChoice::Cpu);
    let (control, n_rounds) = stopping_after(u32::MAX);
    let job = set!(Job { max_memory: Some(ByteSize(4_000_000)), ..long_job() });
    let error = run(&job, &mut cpu, SpillTarget::None, &control).unwrap_err();
    assert_eq!((error.code(), n_rounds.load(Ordering::Relaxed)), ("memory", 0));
    let text = error.to_string();
    assert!(text.contains("(columns 6.51 MB, facets") && text.contains("4.00 MB are allowed"), "{text}");
    assert!(error.hint().contains("--spill"), "{}", error.hint());

    let job = set!(Job { max_memory: Some(ByteSize(100_000_000)), cells: Some(700), dims: None, ..long_job() });
    let options = MeshOptions::default().with_flags_in_memory(true);
    let error = mesh(&job, &mut cpu, &options, &control).unwrap_err();
    assert_eq!((error.code(), n_rounds.load(Ordering::Relaxed)), ("memory", 0));
    assert!(error.to_string().contains("flags in memory") && error.hint().contains("--flags-in-memory"), "{error}");
}

#[test]
fn bands_and_rounds_are_as_small_as_the_budget_demands_on_cpu_and_gpu() {
    let job = job("spot.stl", [900, 1000, 1100], AxisChoice::X);
    for backend in [BackendChoice::Cpu, BackendChoice::Gpu] {
        let mut engine = engine(backend);
        let (whole, _) = run(&job, &mut engine, SpillTarget::None, &Control::default()).unwrap();
        let mut n_meshed = 0;
        for mega in [1, 2, 4, 8, 12, 16, 24, 40, 80, 200] {
            let max_memory = Some(ByteSize(mega * 1_000_000));
            for spill in [SpillTarget::None, SpillTarget::Temporary(Arc::new(MemoryStore::default()))] {
                match run(&set!(Job { max_memory, ..job.clone() }), &mut engine, spill, &Control::default()) {
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
fn buffers_of_a_gpu_count_as_the_hosts_memory_only_where_they_are_in_it() {
    let job = set!(Job { max_memory: Some(ByteSize(3_600_000)), ..long_job() });
    let (cpu, mut gpu) = (&mut engine(BackendChoice::Cpu), engine(BackendChoice::Gpu));
    let spill = || SpillTarget::Temporary(Arc::new(MemoryStore::default()));
    run(&job, cpu, spill(), &Control::default()).unwrap();
    let on_gpu = run(&job, &mut gpu, spill(), &Control::default());
    match gpu.device() {
        Device::Shared => {
            let error = on_gpu.unwrap_err();
            assert!(error.code() == "memory" && error.to_string().contains("bands on the GPU"), "{error}");
            assert!(error.hint().contains("--backend cpu"), "{}", error.hint());
        }
        Device::Own => assert!(on_gpu.unwrap().1.peak_bytes.device > 3_500_000),
        _ => panic!("a GPU was asked for"),
    }
    // what the program takes counts, too
    let job = set!(Job { max_memory: Some(ByteSize(4_200_000)), ..job });
    let options = MeshOptions::default().with_spill(spill()).with_program_bytes(3_000_000);
    let error = mesh(&job, cpu, &options, &Control::default()).unwrap_err();
    assert!(error.to_string().contains("program and driver 3.00 MB"), "{error}");
}
