//! Tests: flags of columns that are read from a store, slab by slab.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use hexcast_core::base::control::Control;
use hexcast_core::cells::columns::{Band, ColumnsBuilder, Head, MemoryStore, Store, run, sealed};
use hexcast_core::grid::lines::Lines;
use hexcast_core::grid::rays::Rays;
use hexcast_core::set;

use super::Mesh;

/// A store that counts the bytes read from it.
#[derive(Default)]
struct Counting {
    memory: MemoryStore,
    n_read: AtomicU64,
}

impl sealed::Sealed for Counting {}

impl Store for Counting {
    fn append(&self, bytes: &[u8]) -> std::io::Result<u64> {
        self.memory.append(bytes)
    }

    fn read(&self, at: u64, bytes: &mut [u8]) -> std::io::Result<()> {
        self.n_read.fetch_add(bytes.len() as u64, Ordering::Relaxed);
        self.memory.read(at, bytes)
    }

    fn truncate(&self, n_bytes: u64) -> std::io::Result<()> {
        self.memory.truncate(n_bytes)
    }
}

const SIDE: u32 = 60;
const DEPTH: u32 = 400;

/// Rays with some 50 runs each, in bands of 10 rows.
fn bands() -> Vec<Band> {
    let rows = |first: u32| {
        let mut band = set!(Band { first_ray: u64::from(first * SIDE), ..Band::default() });
        for ray in first * SIDE..(first + 10) * SIDE {
            let cells = (0..50).map(|k| k * 8 + (ray * 7 + k * 3) % 8);
            band.runs.extend(cells.zip([3, 0, 1, 2].into_iter().cycle()).map(|(cell, flag)| run(cell, flag)));
            band.ends.push(band.runs.len() as u32);
        }
        band
    };
    (0..SIDE).step_by(10).map(rows).collect()
}

pub(super) fn mesh(max_bytes: u64, store: Option<Arc<dyn Store>>) -> Mesh {
    let dims = [SIDE, SIDE, DEPTH];
    let (rays, lines) = (Rays::new(2, dims), Lines::new([0.0; 3], [1.0; 3], dims).unwrap());
    let head = Head { identity: None, rays, zlib: false, lines: lines.clone(), unit: None, names: vec![] };
    let head = head.encode().unwrap();
    let mut builder = ColumnsBuilder::new(rays, max_bytes, store.map(|store| (head, store)));
    bands().into_iter().for_each(|band| builder.push(vec![band]).unwrap());
    Mesh::new(lines, builder.finish().unwrap(), vec![], None).unwrap()
}

fn all_flags(mesh: &Mesh, slab_bytes: usize) -> Vec<u8> {
    let mut flags = Vec::new();
    mesh.for_each_slab(slab_bytes, &Control::default(), |slab| {
        flags.extend_from_slice(slab);
        Ok(())
    })
    .unwrap();
    flags
}

fn all_bits(mesh: &Mesh, slab_bytes: usize) -> Vec<u8> {
    let mut bits = Vec::new();
    mesh.for_each_slab_of_bits(slab_bytes, &Control::default(), |slab| {
        bits.extend_from_slice(slab);
        Ok(())
    })
    .unwrap();
    bits
}

#[test]
fn slabs_across_the_rays_read_the_store_a_few_times() {
    let whole = mesh(u64::MAX, None);
    let expected = all_flags(&whole, 1 << 20);
    let expected_bits = all_bits(&whole, 1 << 20);
    let n_bytes = whole.columns.n_bytes();
    // planes of 3600 cells: one a slab, five, or half a one
    for slab_bytes in [3600, 18_000, 1800] {
        for (max_bytes, most_readings) in [(n_bytes - 1, 3), (n_bytes / 2, 6), (n_bytes / 8, 24), (n_bytes / 20, 80)] {
            let store = Arc::new(Counting::default());
            let mesh = mesh(max_bytes, Some(store.clone()));
            assert!(mesh.columns.is_spilled());
            // twice: the second begins again at the first cell
            for _ in 0..2 {
                store.n_read.store(0, Ordering::Relaxed);
                assert!(all_flags(&mesh, slab_bytes) == expected, "slabs of {slab_bytes} in {max_bytes}");
                let readings = store.n_read.load(Ordering::Relaxed) as f64 / mesh.columns.spilled_bytes() as f64;
                assert!(
                    readings <= f64::from(most_readings),
                    "{readings} readings, slabs of {slab_bytes} in {max_bytes}"
                );
            }
            store.n_read.store(0, Ordering::Relaxed);
            assert!(all_bits(&mesh, slab_bytes / 8) == expected_bits, "bits, slabs of {slab_bytes}");
            let readings = store.n_read.load(Ordering::Relaxed) as f64 / mesh.columns.spilled_bytes() as f64;
            assert!(readings <= f64::from(most_readings), "{readings} readings for bits in {max_bytes}");
            let slabs = mesh.columns.for_slab(&(200..201)).unwrap();
            assert!(slabs.n_bytes() <= max_bytes, "{} held of {max_bytes}", slabs.n_bytes());
        }
    }
}

#[test]
fn boxes_and_columns_without_memory_for_slabs_are_read_from_the_store() {
    let expected = mesh(u64::MAX, None);
    for max_bytes in [0, 3000, 100_000] {
        let mesh = mesh(max_bytes, Some(Arc::new(MemoryStore::default())));
        assert!(all_flags(&mesh, 50_000) == all_flags(&expected, 50_000), "{max_bytes} bytes");
        let boxes = [[0..60, 0..60, 399..400], [0..60, 0..60, 17..90], [3..4, 5..50, 100..380], [0..60, 0..60, 7..7]];
        for cells in boxes {
            let flags = expected.box_flags(&cells).unwrap();
            assert!(mesh.box_flags(&cells).unwrap() == flags, "{cells:?} of {max_bytes} bytes");
            assert!(mesh.box_bits(&cells).unwrap() == expected.box_bits(&cells).unwrap(), "bits of {cells:?}");
        }
    }
}
