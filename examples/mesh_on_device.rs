//! A mesh that never leaves the GPU: a program with a wgpu device of its own meshes on it, and counts the cells of each flag by a kernel of its
//! own, straight from the runs. Only the 256 counts come to the host.
//!
//!     cargo run --example mesh_on_device -- part.stl

use hexcast::gpu::wgpu::util::{BufferInitDescriptor, DeviceExt};
use hexcast::gpu::{DeviceMesh, device_limits, wgpu};
use hexcast::{Error, GeometryJob, Job, Mesher, Result};
use wgpu::{BindGroupDescriptor, BindGroupEntry, BufferDescriptor, BufferUsages, Device, MapMode, PollType, Queue};

/// Counts the cells of each flag: a thread takes a ray, and goes through its runs.
const COUNT: &str = "
    // number of rays, cells of a ray
    @group(0) @binding(0) var<uniform> rays: vec4<u32>;
    @group(0) @binding(1) var<storage, read> offsets: array<u32>;
    @group(0) @binding(2) var<storage, read> runs: array<u32>;
    @group(0) @binding(3) var<storage, read_write> counts: array<atomic<u32>, 256>;

    @compute @workgroup_size(64)
    fn count(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
             @builtin(local_invocation_index) local: u32) {
        let ray = (group.y * groups.x + group.x) * 64u + local;
        if ray >= rays.x {
            return;
        }
        // before the first run there is background
        var flag = 0u;
        var cell = 0u;
        for (var at = offsets[ray]; at < offsets[ray + 1u]; at++) {
            atomicAdd(&counts[flag], (runs[at] >> 8u) - cell);
            flag = runs[at] & 0xffu;
            cell = runs[at] >> 8u;
        }
        atomicAdd(&counts[flag], rays.y - cell);
    }";

/// A device of the program's own, with the limits that it wants; hexcast needs no features.
pub(crate) fn device() -> std::result::Result<(Device, Queue), Box<dyn std::error::Error>> {
    pollster::block_on(async {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle().with_env());
        let adapter = instance.request_adapter(&wgpu::RequestAdapterOptions::default()).await?;
        let limits = wgpu::Limits { max_bind_groups: 2, ..device_limits(&adapter) };
        let descriptor = wgpu::DeviceDescriptor { required_limits: limits, ..Default::default() };
        Ok(adapter.request_device(&descriptor).await?)
    })
}

/// Numbers of cells of the 256 flags, counted on the device.
pub(crate) fn cells_per_flag(device: &Device, queue: &Queue, mesh: &DeviceMesh) -> [u32; 256] {
    let depth = mesh.dims()[mesh.ray_axis()];
    let numbers = [mesh.n_rays() as u32, depth, 0, 0].map(u32::to_le_bytes);
    let rays = device.create_buffer_init(&BufferInitDescriptor {
        label: None,
        contents: numbers.as_flattened(),
        usage: BufferUsages::UNIFORM,
    });
    let buffer =
        |usage| device.create_buffer(&BufferDescriptor { label: None, size: 1024, usage, mapped_at_creation: false });
    let counts = buffer(BufferUsages::STORAGE | BufferUsages::COPY_SRC);
    let read = buffer(BufferUsages::MAP_READ | BufferUsages::COPY_DST);
    let source = wgpu::ShaderSource::Wgsl(COUNT.into());
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label: None, source });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: None,
        layout: None,
        module: &module,
        entry_point: Some("count"),
        compilation_options: Default::default(),
        cache: None,
    });
    let buffers = [(0, &rays), (1, mesh.offsets()), (2, mesh.runs()), (3, &counts)];
    let entries = buffers.map(|(binding, buffer)| BindGroupEntry { binding, resource: buffer.as_entire_binding() });
    let layout = pipeline.get_bind_group_layout(0);
    let group = device.create_bind_group(&BindGroupDescriptor { label: None, layout: &layout, entries: &entries });
    let mut encoder = device.create_command_encoder(&Default::default());
    let mut pass = encoder.begin_compute_pass(&Default::default());
    pass.set_pipeline(&pipeline);
    pass.set_bind_group(0, &group, &[]);
    let n_groups = mesh.n_rays().div_ceil(64) as u32;
    let rows = n_groups.div_ceil(65_535).max(1);
    pass.dispatch_workgroups(n_groups.div_ceil(rows), rows, 1);
    drop(pass);
    encoder.copy_buffer_to_buffer(&counts, 0, &read, 0, 1024);
    queue.submit([encoder.finish()]);
    read.map_async(MapMode::Read, .., |mapped| mapped.expect("the counts are read"));
    device.poll(PollType::wait_indefinitely()).expect("the device is there");
    let bytes = read.get_mapped_range(..).expect("the counts are read");
    let mut words = bytes.chunks_exact(4).map(|word| u32::from_le_bytes([word[0], word[1], word[2], word[3]]));
    [(); 256].map(|()| words.next().unwrap_or_default())
}

/// Meshes a file on a device of the program's own, and counts its cells there.
pub(crate) fn counted(file: &str) -> Result<[u32; 256]> {
    let (device, queue) = device().map_err(|error| Error::new("no-adapter", error.to_string(), ""))?;
    let mut job = Job::new(vec![GeometryJob::new(file)]);
    job.cells = Some(100);
    let mesh = Mesher::with_device(device.clone(), queue.clone())?.mesh_on_device(&job)?;
    Ok(cells_per_flag(&device, &queue, &mesh))
}

fn main() -> Result<()> {
    let Some(file) = std::env::args().nth(1) else {
        return Err(Error::new("job-value", "the name of an STL file is needed", ""));
    };
    for (flag, cells) in counted(&file)?.into_iter().enumerate().filter(|(_, cells)| *cells > 0) {
        println!("flag {flag}: {cells} cells");
    }
    Ok(())
}
