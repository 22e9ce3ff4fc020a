//! Flags on a device of the caller's own: a buffer that holds what the host expands, whatever the limits of the device.

use hexcast::gpu::{Cells, Expander, instance};
use hexcast::job::Job;
use hexcast::mesh::Mesh;
use hexcast::pipeline::Engine;
use hexcast_core::cells::flags::CellBox;
use wgpu::{BufferDescriptor, BufferUsages, Device, DeviceDescriptor, Limits, MapMode, PollType, Queue};

use crate::models;
use crate::open_surfaces::meshed;

/// A device that no [`hexcast::gpu::Gpu`] opened.
fn own_device(limits: Limits) -> (Device, Queue) {
    pollster::block_on(async {
        let adapter = instance().request_adapter(&Default::default()).await.expect("an adapter");
        let descriptor = DeviceDescriptor { required_limits: limits, ..Default::default() };
        adapter.request_device(&descriptor).await.expect("a device")
    })
}

/// A torus that touches a sphere of another flag.
fn mesh(axis: usize) -> Mesh {
    let parts = [models::torus([0.0; 3], [2.0, 0.7], 24), models::sphere([2.0, 0.0, 0.5], 1.0, 16)];
    let job = set!(Job { geometries: vec![Default::default(); 2], dims: Some([41, 53, 37]), ..Job::default() });
    meshed(&parts, &job, axis, &mut Engine::cpu()).expect("a mesh").0
}

/// All bytes of a buffer, by the caller's own means.
pub(super) fn read((device, queue): &(Device, Queue), buffer: &wgpu::Buffer) -> Vec<u8> {
    let usage = BufferUsages::MAP_READ | BufferUsages::COPY_DST;
    let copy =
        device.create_buffer(&BufferDescriptor { label: None, size: buffer.size(), usage, mapped_at_creation: false });
    let mut encoder = device.create_command_encoder(&Default::default());
    encoder.copy_buffer_to_buffer(buffer, 0, &copy, 0, buffer.size());
    queue.submit([encoder.finish()]);
    copy.map_async(MapMode::Read, .., |mapped| mapped.expect("it is mapped"));
    device.poll(PollType::wait_indefinitely()).expect("the device is there");
    copy.get_mapped_range(..).expect("it is mapped").to_vec()
}

fn assert_expands(own: &(Device, Queue), mesh: &Mesh, cells: &CellBox) {
    let expander = Expander::new(&own.0, &own.1);
    let of_host = [(Cells::Bytes, mesh.box_flags(cells)), (Cells::Bits, mesh.box_bits(cells))];
    for (form, expected) in of_host {
        let mut expected = expected.expect("columns in memory");
        expected.resize(expected.len().next_multiple_of(4), 0);
        let buffer = pollster::block_on(expander.flags_buffer(mesh, cells, form)).expect("it fits");
        let needed = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        assert!(buffer.usage().contains(needed));
        assert!(read(own, &buffer) == expected, "{form:?} of {cells:?}, rays along {}", mesh.columns().rays().axis);
    }
}

#[test]
fn a_buffer_of_the_callers_device_has_the_flags_of_the_host_along_every_axis() {
    let own = own_device(Limits::default());
    for axis in 0..3 {
        let mesh = mesh(axis);
        assert!(mesh.box_flags(&[0..41, 0..53, 0..37]).expect("in memory").contains(&2));
        for cells in [[0..41, 0..53, 0..37], [3..39, 17..53, 9..10], [20..21, 0..53, 5..30], [7..8, 8..9, 9..10]] {
            assert_expands(&own, &mesh, &cells);
        }
    }
}

#[test]
fn a_device_with_small_bindings_gets_its_flags_slab_by_slab() {
    // 1280 bytes of a binding: slabs of 64 cells, a row each, that share words
    let own = own_device(Limits { max_storage_buffer_binding_size: 1280, ..Limits::default() });
    for axis in 0..3 {
        assert_expands(&own, &mesh(axis), &[1..40, 3..50, 2..7]);
    }
}

#[test]
fn what_a_buffer_cannot_hold_or_a_mesh_has_not_is_refused() {
    let (device, queue) = own_device(Limits { max_buffer_size: 50_000, ..Limits::default() });
    let expander = Expander::new(&device, &queue);
    let mesh = mesh(0);
    let refused = |cells: CellBox, form| {
        pollster::block_on(expander.flags_buffer(&mesh, &cells, form)).map(|_| ()).expect_err("it is refused")
    };
    let error = refused([0..41, 0..53, 0..37], Cells::Bytes);
    assert_eq!(error.code(), "memory");
    let expected = "the flags of 41 x 53 x 37 cells take 80404 bytes; a buffer of this device has 50000";
    assert_eq!(error.to_string(), expected);
    assert!(pollster::block_on(expander.flags_buffer(&mesh, &[0..41, 0..53, 0..37], Cells::Bits)).is_ok());
    for cells in [[0..42, 0..1, 0..1], [0..1, 5..5, 0..1]] {
        let error = refused(cells, Cells::Bits);
        assert_eq!(error.code(), "job-value");
        assert!(error.to_string().contains("the mesh of 41 x 53 x 37"), "{error}");
    }
}
