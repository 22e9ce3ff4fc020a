//! Flags in another order or as other numbers, for programs that want x slowest or a mask: `.raw`, `.npy` and `.npz`.
//!
//! Mesh, order, map -> bytes, slab by slab. With x slowest a slab is some planes across x, or rows along z of one, expanded and then
//! transposed in blocks that fit the cache. Cost: two slabs of memory; three times as long as the usual order.

use hexcast_core::base::control::Control;
use hexcast_core::base::error::Result;
use hexcast_core::base::parallel::*;
use hexcast_core::cells::flags::{CellBox, slabs_of_box};
use hexcast_derived::mesh::Mesh;

use super::{AxisOrder, Options};

/// Cells along x and z that are transposed together.
const BLOCK: usize = 64;

/// The boxes whose cells follow each other in a file with x slowest, of at most so many cells, but at least a row along z each.
fn boxes([nx, ny, nz]: [u32; 3], max_cells: usize) -> impl Iterator<Item = CellBox> {
    slabs_of_box(&[0..nz, 0..ny, 0..nx], max_cells).map(|[z, y, x]| [x, y, z])
}

/// The bytes of such a box.
fn bytes_of_box(mesh: &Mesh, options: &Options, cells: &CellBox) -> Result<Vec<u8>> {
    let flags = mesh.box_flags(cells)?;
    let bytes = match &options.map {
        Some(map) => mapped(flags, map),
        None => flags,
    };
    Ok(transposed(&bytes, [0, 1, 2].map(|axis| cells[axis].len())))
}

/// Hands the bytes of all cells to `consume` in the order and by the map of the options; a rest before every slab.
pub(super) async fn for_each_slab(
    mesh: &Mesh,
    options: &Options,
    control: &Control,
    consume: &mut dyn FnMut(&[u8]) -> Result<()>,
) -> Result<()> {
    match (options.axis_order, &options.map) {
        (AxisOrder::Zyx, None) => mesh.for_each_slab_with_rests(options.slab_bytes, control, consume).await,
        (AxisOrder::Zyx, Some(map)) => {
            let mut put = |flags: &[u8]| consume(&mapped(flags.to_vec(), map));
            mesh.for_each_slab_with_rests(options.slab_bytes, control, &mut put).await
        }
        (AxisOrder::Xyz, _) => {
            for cells in boxes(mesh.dims(), options.slab_bytes) {
                control.rest().await?;
                consume(&bytes_of_box(mesh, options, &cells)?)?;
            }
            control.check()
        }
    }
}

fn mapped(mut flags: Vec<u8>, map: &[u8; 256]) -> Vec<u8> {
    flags.iter_mut().for_each(|flag| *flag = map[usize::from(*flag)]);
    flags
}

/// The flags of a box with z fastest, from those with x fastest.
fn transposed(flags: &[u8], [nx, ny, nz]: [usize; 3]) -> Vec<u8> {
    let mut out = vec![0; flags.len()];
    out.par_chunks_mut(BLOCK * ny * nz).enumerate().for_each(|(block, out)| {
        let first = block * BLOCK;
        for y in 0..ny {
            for z in (0..nz).step_by(BLOCK) {
                for x in 0..(nx - first).min(BLOCK) {
                    let to = (x * ny + y) * nz;
                    for z in z..(z + BLOCK).min(nz) {
                        out[to + z] = flags[first + x + nx * (y + ny * z)];
                    }
                }
            }
        }
    });
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::write::{Compress, Format, sidecar_json, write};
    use hexcast_derived::testing::{pattern, pattern_flag, pattern_flags};

    #[test]
    fn cells_are_in_the_order_and_by_the_map_that_was_asked_for() {
        // more than a block along x and z
        let dims = [70, 3, 130];
        let mut map: [u8; 256] = std::array::from_fn(|flag| flag as u8);
        (map[0], map[1]) = (1, 0);
        for axis in 0..3 {
            let mesh = pattern(axis, dims, 3);
            for slab_bytes in [1, 5 * 3 * 130, 1 << 20] {
                let options = Options::default().with_slab_bytes(slab_bytes).with_axis_order(AxisOrder::Xyz);
                let mut expected = Vec::new();
                for x in 0..dims[0] {
                    for y in 0..dims[1] {
                        expected.extend((0..dims[2]).map(|z| pattern_flag([x, y, z], 3)));
                    }
                }
                let bytes = |options: &Options, format| {
                    let mut bytes = Vec::new();
                    write(&mesh, format, options, &mut bytes, &Control::default()).unwrap();
                    bytes
                };
                assert_eq!(bytes(&options, Format::Raw), expected);
                let npy = bytes(&options, Format::Npy);
                assert!(npy[..128].windows(12).any(|text| text == b"(70, 3, 130)") && npy[128..] == expected);
                let npz = bytes(&options.with_compress(Compress::None), Format::Npz);
                assert!(npz.windows(expected.len()).any(|window| window == expected));
                let mapped = Options { axis_order: AxisOrder::Zyx, ..options }.with_map(map);
                let changed = pattern_flags(dims, 3).iter().map(|flag| map[usize::from(*flag)]).collect::<Vec<_>>();
                assert_eq!(bytes(&mapped, Format::Raw), changed);
            }
        }
    }

    #[test]
    fn the_sidecar_tells_and_other_formats_refuse() {
        let mesh = pattern(0, [9, 5, 7], 1);
        let mut map = [0; 256];
        map.iter_mut().enumerate().for_each(|(flag, byte)| *byte = flag as u8);
        map[1] = 9;
        let options = Options::default().with_axis_order(AxisOrder::Xyz).with_map(map);
        let written = write(&mesh, Format::Raw, &options, &mut Vec::new(), &Control::default()).unwrap();
        let sidecar: serde_json::Value = serde_json::from_str(&sidecar_json(&mesh, &options, &written)).unwrap();
        assert!(sidecar["axis_order"].as_str().unwrap().ends_with("number z + nz * (y + ny * x)"));
        assert_eq!(sidecar["map"], serde_json::json!({"1": 9}));
        for (format, options) in
            [(Format::Vti, options), (Format::Columns, options), (Format::Raw, options.with_bits(true))]
        {
            let error = write(&mesh, format, &options, &mut Vec::new(), &Control::default()).unwrap_err();
            assert_eq!(error.code(), "job-conflict", "{format:?}");
        }
    }
}
