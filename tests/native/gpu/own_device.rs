//! Meshes on a device of the caller's own: the runs and flags in its buffers are those of the CPU, its handlers stay the caller's, and what cannot
//! be is an error.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use hexcast::columns::BoxRuns;
use hexcast::control::Control;
use hexcast::gpu::{Cells, DeviceMesh, Expander, Gpu, device_limits, instance, wgpu};
use hexcast::job::{AxisChoice, GeometryJob, GradedJob, HaloEdge, Job, Open, PartJob, PerAxis};
use hexcast::pipeline::{Engine, MeshOptions};
use hexcast::sources::Source;
use hexcast::{Mesh, Mesher};
use wgpu::{Buffer, BufferDescriptor, BufferUsages, Device, DeviceDescriptor, Limits, Queue};

use super::flags_buffer::read;
use crate::models;

type Own = (Device, Queue);

fn own_device(limits: impl Fn(&wgpu::Adapter) -> Limits) -> Own {
    pollster::block_on(async {
        let adapter = instance().request_adapter(&Default::default()).await.expect("an adapter");
        let descriptor = DeviceDescriptor { required_limits: limits(&adapter), ..Default::default() };
        adapter.request_device(&descriptor).await.expect("a device")
    })
}

fn mesher(own: &Own) -> Mesher {
    Mesher::with_device(own.0.clone(), own.1.clone()).expect("the device suffices")
}

/// All words of a buffer, by the caller's own means.
fn words(own: &Own, buffer: &Buffer) -> Vec<u32> {
    let word = |bytes: &[u8]| u32::from_le_bytes(bytes.try_into().expect("four bytes"));
    read(own, buffer).chunks_exact(4).map(word).collect()
}

/// A torus that touches a sphere; what the job does not say of them is as in `job`.
fn sources() -> Vec<Source> {
    let parts = [models::torus([0.0; 3], [2.0, 0.7], 24), models::sphere([2.0, 0.0, 0.5], 1.0, 16)];
    parts.into_iter().map(|facets| Source::from_facets("part", facets).expect("facets")).collect()
}

fn job(flags: [u8; 2]) -> Job {
    Job::new(flags.map(|flag| set!(GeometryJob { flag: Some(flag), ..GeometryJob::new("part") })).to_vec())
}

/// The mesh of the CPU, and that of a device.
fn both(own: &Own, job: &Job) -> (Mesh, DeviceMesh) {
    let (options, control) = (MeshOptions::default(), Control::default());
    let (mesh, _) =
        Mesher::with_engine(Engine::cpu()).mesh_sources(job, sources(), &options, &control).expect("a mesh");
    let on_device = mesher(own).mesh_sources_on_device(job, sources(), &options, &control).expect("a mesh");
    (mesh, on_device)
}

/// Buffers with the runs and flags of a mesh, and facts that are its own.
fn assert_is(own: &Own, mesh: &Mesh, found: &DeviceMesh, is_checked: bool) {
    let cells = mesh.dims().map(|n| 0..n);
    let BoxRuns { offsets, runs } = mesh.box_runs(&cells).expect("in memory");
    assert_eq!((found.n_rays() + 1, found.n_runs()), (offsets.len() as u64, runs.len() as u64));
    assert!(words(own, found.offsets())[..offsets.len()] == offsets, "offsets");
    assert!(words(own, found.runs())[..runs.len()] == runs, "runs");
    let needed = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
    assert!(found.runs().usage().contains(needed) && found.offsets().usage().contains(needed));
    assert_eq!((found.dims(), found.lines(), found.names()), (mesh.dims(), mesh.lines(), mesh.names()));
    assert_eq!((found.ray_axis(), found.unit()), (mesh.columns().rays().axis, mesh.unit()));
    let counts = [mesh.columns().n_crossings(), mesh.columns().odd_rays()];
    assert_eq!([found.n_crossings(), found.odd_rays()], counts);
    let [n_checked, n_differing] = found.device_check();
    assert!((n_checked > 0) == is_checked && n_differing == 0);
    for (form, bytes) in [(Cells::Bytes, mesh.box_flags(&cells)), (Cells::Bits, mesh.box_bits(&cells))] {
        let mut bytes = bytes.expect("in memory");
        bytes.resize(bytes.len().next_multiple_of(4), 0);
        let flags = words(own, &pollster::block_on(found.flags_buffer(form)).expect("it fits"));
        assert!(flags.iter().flat_map(|word| word.to_le_bytes()).eq(bytes), "{form:?}");
    }
}

#[test]
fn runs_and_flags_in_the_callers_buffers_are_those_of_the_cpu() {
    // of other geometries with the same flag runs are joined
    let own = own_device(|_| Limits::default());
    for (axis, flags) in [(AxisChoice::X, [7, 200]), (AxisChoice::Y, [7, 7]), (AxisChoice::Z, [7, 200])] {
        let (mesh, found) = both(&own, &set!(Job { dims: Some([41, 53, 37]), axis, ..job(flags) }));
        assert_is(&own, &mesh, &found, true);
    }
    let window = set!(Job { dims: Some([41, 53, 37]), window: Some([3, 5, 7, 30, 50, 31]), ..job([1, 2]) });
    let graded = set!(Job { graded: Some(GradedJob::new(PerAxis::All(0.25))), ..job([1, 2]) });
    for job in [window, graded, set!(Job { cells: Some(60), part: Some(PartJob::new(2, [1, 2, 1])), ..job([1, 2]) })] {
        let (mesh, found) = both(&own, &job);
        assert_is(&own, &mesh, &found, true);
    }
}

#[test]
fn a_mesh_of_many_bands_and_large_buffers_is_whole() {
    let own = own_device(device_limits);
    let (mesh, found) = both(&own, &set!(Job { cells: Some(400), ..job([1, 2]) }));
    assert_is(&own, &mesh, &found, true);
    // as small as they may be: many bands
    let options = MeshOptions::default().with_max_device_bytes(Some(4 << 20));
    let job = set!(Job { cells: Some(400), ..job([1, 2]) });
    let few = mesher(&own).mesh_sources_on_device(&job, sources(), &options, &Control::default()).expect("a mesh");
    assert_is(&own, &mesh, &few, true);
}

#[test]
fn a_mesh_for_the_host_is_uploaded_to_the_same_buffers() {
    let own = own_device(|_| Limits::default());
    let mut cpu = Mesher::with_engine(Engine::cpu());
    let job = set!(Job { dims: Some([41, 53, 37]), close_gaps: Some(2), ..job([7, 200]) });
    let (mesh, _) = cpu.mesh_sources(&job, sources(), &MeshOptions::default(), &Control::default()).expect("a mesh");
    let expander = Expander::new(&own.0, &own.1);
    assert_is(&own, &mesh, &pollster::block_on(expander.upload(&mesh)).expect("it fits"), false);
    let gpu = pollster::block_on(Gpu::from_device(own.0.clone(), own.1.clone())).expect("the device suffices");
    assert_is(&own, &mesh, &pollster::block_on(gpu.upload(&mesh)).expect("it fits"), false);
}

#[test]
fn the_usual_mesh_on_the_callers_device_is_that_of_the_cpu() {
    let own = own_device(|_| Limits::default());
    let job = set!(Job { dims: Some([41, 53, 37]), ..job([7, 200]) });
    let (options, control) = (MeshOptions::default(), Control::default());
    let (found, report) = mesher(&own).mesh_sources(&job, sources(), &options, &control).expect("a mesh");
    assert_eq!(report.mesh.backend, "gpu");
    assert!(found == both(&own, &job).0);
}

fn refused(own: &Own, job: &Job) -> hexcast::Error {
    let (options, control) = (MeshOptions::default(), Control::default());
    let made = mesher(own).mesh_sources_on_device(job, sources(), &options, &control);
    made.expect_err("it is refused")
}

#[test]
fn executors_may_move_a_mesh_on_a_device_between_their_threads() {
    fn is_send<T: Send>(value: T) -> T {
        value
    }
    let (device, queue) = own_device(|_| Limits::default());
    let gpu = pollster::block_on(is_send(Gpu::from_device(device, queue))).expect("the device suffices");
    let (engine, options, control) = (Engine::with_gpu(gpu), MeshOptions::default(), Control::default());
    let job = set!(Job { dims: Some([20, 20, 20]), ..job([1, 2]) });
    let future = is_send(hexcast::pipeline::mesh_on_device(&job, sources(), &options, &engine, &control));
    assert!(pollster::block_on(future).expect("a mesh").n_runs() > 0);
}

#[test]
fn what_the_host_makes_of_the_cells_is_refused_with_what_to_do() {
    let own = own_device(|_| Limits::default());
    let job = set!(Job { dims: Some([20, 20, 20]), ..job([7, 200]) });
    let of_part =
        set!(Job { window: Some([0, 0, 0, 9, 9, 9]), halo: Some(1), halo_edge: Some(HaloEdge::Clamp), ..job.clone() });
    for (name, job) in [
        ("close_gaps", set!(Job { close_gaps: Some(2), ..job.clone() })),
        ("halo", of_part),
        ("certify", set!(Job { certify: true, ..job.clone() })),
    ] {
        let error = refused(&own, &job);
        assert_eq!(error.code(), "job-conflict");
        assert!(error.to_string().starts_with(&format!("{name} ")) && error.hint().contains("Gpu::upload"), "{error}");
    }
    let mut facets = models::sphere([0.0; 3], 1.0, 16);
    facets.truncate(facets.len() - 40);
    let open = vec![Source::from_facets("bowl", facets).expect("facets")];
    let job = set!(Job {
        dims: Some([20; 3]),
        ..Job::new(vec![set!(GeometryJob { open: Some(Open::Winding), ..GeometryJob::new("bowl") })])
    });
    let error = mesher(&own).mesh_sources_on_device(&job, open, &MeshOptions::default(), &Control::default());
    assert_eq!(error.expect_err("it is open").code(), "job-conflict");
    let error = Mesher::with_engine(Engine::cpu())
        .mesh_sources_on_device(&job, vec![], &MeshOptions::default(), &Control::default())
        .expect_err("it has no device");
    assert_eq!(error.code(), "no-adapter");
}

#[test]
fn a_device_with_too_small_limits_is_refused_with_the_numbers() {
    let limits = Limits { max_storage_buffers_per_shader_stage: 4, max_buffer_size: 1 << 16, ..Limits::default() };
    let limits = Limits { max_storage_buffer_binding_size: 1 << 16, ..limits };
    let (device, queue) = own_device(|_| limits.clone());
    let error = Mesher::with_device(device, queue).map(|_| ()).expect_err("it is too small");
    assert_eq!(error.code(), "device-failed");
    let said = "max_storage_buffers_per_shader_stage is 4, and 8 is needed; \
                max_storage_buffer_binding_size is 65536, and 1048576 is needed; max_buffer_size is 65536, and 1048576 is needed";
    assert!(error.to_string().contains(said), "{error}");
    assert!(error.hint().contains("device_limits"), "{}", error.hint());
}

#[test]
fn runs_that_no_buffer_of_the_device_holds_are_an_error() {
    let limits = Limits { max_buffer_size: 1 << 20, max_storage_buffer_binding_size: 1 << 20, ..Limits::default() };
    let own = own_device(|_| limits.clone());
    // 512 x 512 rays: more offsets than fit
    let error = refused(&own, &set!(Job { dims: Some([512, 512, 16]), axis: AxisChoice::Z, ..job([1, 2]) }));
    assert_eq!(error.code(), "memory");
    let expected =
        "the offsets of 262144 rays take 1048580 bytes; a buffer that a kernel of this device sees has at most 1048576";
    assert_eq!(error.to_string(), expected);
    // the offsets fit, and of the runs not all
    let error = refused(&own, &set!(Job { dims: Some([500, 500, 400]), axis: AxisChoice::Z, ..job([1, 2]) }));
    assert!(error.code() == "memory" && error.to_string().contains("runs, and maybe more,"), "{error}");
    // but less does
    let (mesh, found) = both(&own, &set!(Job { dims: Some([100, 100, 100]), ..job([1, 2]) }));
    assert!(
        words(&own, found.runs())[..found.n_runs() as usize] == mesh.box_runs(&[0..100, 0..100, 0..100]).unwrap().runs
    );
    let error = pollster::block_on(
        both(&own, &set!(Job { dims: Some([160, 160, 100]), ..job([1, 2]) })).1.flags_buffer(Cells::Bytes),
    );
    assert_eq!(error.expect_err("the flags do not fit").code(), "memory");
}

#[test]
fn a_lost_device_is_an_error_wherever_it_is_lost() {
    let job = set!(Job { cells: Some(300), ..job([1, 2]) });
    for rays_before in [0, 1, 10_000] {
        let own = own_device(|_| Limits::default());
        let mut mesher = mesher(&own);
        let device = own.0.clone();
        if rays_before == 0 {
            device.destroy();
        }
        let control = Control::with_progress(move |at| {
            if at.rays_done >= rays_before {
                device.destroy();
            }
        });
        let options = MeshOptions::default().with_max_device_bytes(Some(8 << 20));
        let error = mesher.mesh_sources_on_device(&job, sources(), &options, &control).expect_err("it is lost");
        assert_eq!(error.code(), "device-lost", "{error}");
        // none takes its place
        let error = mesher.mesh_sources(&job, sources(), &options, &Control::default()).expect_err("it is lost");
        assert_eq!(error.code(), "device-lost", "{error}");
        let (device, queue) = own.clone();
        assert!(Mesher::with_device(device, queue).is_err());
    }
    let own = own_device(|_| Limits::default());
    let (mesh, found) = both(&own, &job);
    let expander = Expander::new(&own.0, &own.1);
    own.0.destroy();
    let error = pollster::block_on(found.flags_buffer(Cells::Bits)).expect_err("it is lost");
    assert_eq!(error.code(), "device-lost", "{error}");
    assert_eq!(pollster::block_on(expander.upload(&mesh)).expect_err("it is lost").code(), "device-lost");
}

#[test]
fn errors_of_the_caller_are_told_to_the_caller_and_those_of_hexcast_to_hexcast() {
    let own = own_device(|_| Limits::default());
    let n_heard = Arc::new(AtomicU32::new(0));
    let heard = n_heard.clone();
    own.0.on_uncaptured_error(Arc::new(move |_| {
        heard.fetch_add(1, Ordering::Relaxed);
    }));
    let wrong = |device: &Device| {
        let size = 1 << 40;
        device.create_buffer(&BufferDescriptor {
            label: None,
            size,
            usage: BufferUsages::STORAGE,
            mapped_at_creation: false,
        })
    };
    let mut mesher = mesher(&own);
    let job = set!(Job { dims: Some([41, 53, 37]), ..job([1, 2]) });
    drop(wrong(&own.0));
    assert_eq!(n_heard.load(Ordering::Relaxed), 1);
    let found = mesher.mesh_sources_on_device(&job, sources(), &MeshOptions::default(), &Control::default());
    let found = found.expect("the error was not of this call");
    assert_eq!(n_heard.load(Ordering::Relaxed), 1);
    drop(wrong(&own.0));
    assert_eq!(n_heard.load(Ordering::Relaxed), 2);
    assert_is(&own, &both(&own, &job).0, &found, true);
}
