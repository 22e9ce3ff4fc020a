mod codec;

use std::io::{Cursor, Read};
use std::sync::Arc;

use serde_json::json;
use zarrs::array::{Array, ArrayMetadataOptions, CodecOptions};
use zarrs::storage::store::MemoryStore;
use zarrs::storage::{
    ListableStorageTraits, ReadableStorageTraits, ReadableWritableListableStorage, StoreKey, WritableStorageTraits,
};

use super::*;
use crate::shards::Shards;
use crate::write::{Compress, Format};
use hexcast_core::base::control::at_once;
use hexcast_core::base::error::Result;
use hexcast_core::cells::columns::{Band, Columns, run};
use hexcast_core::cells::flags::flags_of_box;
use hexcast_core::grid::rays::Rays;
use hexcast_core::input::job::{ByteSize, Levels, ZarrJob};
use hexcast_core::set;
use hexcast_core::testing::band_of;
use hexcast_derived::mesh::level::Pyramid;
use hexcast_derived::testing::{no_fractions, pattern, pattern_flags};

fn options(compress: Compress, shard_bytes: u64) -> Options {
    let zarr = set!(ZarrJob { shard_bytes: Some(ByteSize(shard_bytes)), ..ZarrJob::default() });
    Options { compress, zarr, ..Options::default() }
}

/// Sets values of a store of `zarrs`.
fn set(store: &dyn WritableStorageTraits, key: &str, value: &[u8]) -> Result<()> {
    store.set(&StoreKey::new(key).unwrap(), value.to_vec().into()).unwrap();
    Ok(())
}

fn written(mesh: &Mesh, compress: Compress, shard_bytes: u64) -> (ReadableWritableListableStorage, u64) {
    codec::register();
    let store = Arc::new(MemoryStore::new());
    let options = options(compress, shard_bytes);
    let mut n_cells = 0;
    write(mesh, &options, &|key, value| set(&*store, key, value), &Control::default(), |n| n_cells += n).unwrap();
    (store, n_cells)
}

#[test]
fn flags_centres_and_attributes_read_back() {
    let dims = [70, 9, 67];
    for axis in 0..3 {
        let mesh = pattern(axis, dims, 3);
        for compress in [Compress::None, Compress::Zlib(1)] {
            for shard_bytes in [1, 5_000, 1 << 20] {
                let (store, n_cells) = written(&mesh, compress, shard_bytes);
                assert_eq!(n_cells, mesh.n_cells());
                Stored::new("", &store.get(&StoreKey::new(Stored::METADATA).unwrap()).unwrap().unwrap()).unwrap();
                let array = Array::open(store.clone(), "/flag").unwrap();
                assert_eq!(array.shape(), [67, 9, 70]);
                let flags: Vec<u8> = array.retrieve_array_subset(&array.subset_all()).unwrap();
                assert!(flags == pattern_flags(dims, 3), "axis {axis}, shards of {shard_bytes}, {compress:?}");
                let attributes = array.attributes();
                assert!(attributes.keys().all(|key| !key.starts_with('_')), "{attributes:?}");
                assert_eq!(attributes["origin"], json!(mesh.lines().origin()));
                assert_eq!(attributes["lines"]["x"].as_array().unwrap().len(), 71);
                assert_eq!((&attributes["unit"], &attributes["flags"][0]["name"]), (&json!("mm"), &json!("copper")));
                let x = Array::open(store, "/x").unwrap();
                let x: Vec<f64> = x.retrieve_array_subset(&x.subset_all()).unwrap();
                assert_eq!((x.len(), x[0]), (70, -1.5 + 0.25));
            }
        }
    }
}

#[test]
fn shards_and_metadata_are_those_that_zarrs_writes() {
    for (axis, dims) in [(0, [70, 9, 67]), (1, [33, 64, 20]), (2, [5, 6, 7])] {
        let mesh = pattern(axis, dims, 3);
        for (compress, shard_bytes) in [(Compress::None, 5_000), (Compress::Zlib(6), 1), (Compress::Zlib(6), 1 << 20)] {
            let (store, _) = written(&mesh, compress, shard_bytes);
            let get = |key: &str| store.get(&StoreKey::new(key).unwrap()).unwrap().expect("a value");
            let keys: Vec<String> = Stored::new("", &get(Stored::METADATA)).unwrap().keys().collect();
            let array = Array::open(store.clone(), "/flag").unwrap();
            let theirs: ReadableWritableListableStorage = Arc::new(MemoryStore::new());
            let again = Array::new_with_metadata(theirs.clone(), "/flag", array.metadata().clone()).unwrap();
            let mut options = ArrayMetadataOptions::default();
            options.set_include_zarrs_metadata(false);
            again.store_metadata_opt(&options).unwrap();
            let serial = CodecOptions::default().with_concurrent_target(1).with_store_empty_chunks(true);
            for key in &keys {
                let index: Vec<u64> = key[Stored::SHARDS.len()..].split('/').map(|n| n.parse().unwrap()).collect();
                let numbers: Vec<u8> = array.retrieve_chunk(&index).unwrap();
                again.store_chunk_opt(&index, numbers, &serial).unwrap();
            }
            for key in keys.iter().map(String::as_str).chain([Stored::METADATA]) {
                let expected = theirs.get(&StoreKey::new(key).unwrap()).unwrap().expect("a value");
                assert!(get(key) == expected, "{key} of {dims:?}, {compress:?}, {shard_bytes}");
            }
        }
    }
}

#[test]
fn an_archive_has_the_files_of_the_store_as_they_are() {
    let mesh = pattern(2, [70, 9, 67], 3);
    let (store, _) = written(&mesh, Compress::Zlib(6), 5_000);
    let mut bytes = Vec::new();
    let options = options(Compress::Zlib(6), 5_000);
    crate::write::write(&mesh, Format::ZarrZip, &options, &mut bytes, &Control::default()).unwrap();
    let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).unwrap();
    let keys = store.list().unwrap();
    assert!(keys.len() > 10 && archive.len() == keys.len());
    for key in keys {
        let mut entry = archive.by_name(key.as_str()).unwrap();
        assert_eq!(entry.compression(), zip::CompressionMethod::Stored);
        let mut found = Vec::new();
        entry.read_to_end(&mut found).unwrap();
        assert!(found == store.get(&key).unwrap().expect("a value"), "{key}");
    }
}

#[test]
fn coarser_levels_are_stores_of_the_coarser_meshes() {
    codec::register();
    for (axis, rule, sparse) in [(0, Levels::Any, false), (1, Levels::Majority, true), (2, Levels::Any, true)] {
        let mesh = pattern(axis, [300, 70, 67], 3);
        let store: ReadableWritableListableStorage = Arc::new(MemoryStore::new());
        let mut given = options(Compress::Zlib(1), 100_000);
        given.zarr = set!(ZarrJob { levels: Some(rule), sparse, ..given.zarr });
        write(&mesh, &given, &|key, value| set(&*store, key, value), &Control::default(), |_| ()).unwrap();
        let get = |key: &str| store.get(&StoreKey::new(key).unwrap()).unwrap().expect("a value");
        let group: serde_json::Value = serde_json::from_slice(&get("zarr.json")).unwrap();
        let image = &group["attributes"]["ome"]["multiscales"][0];
        assert_eq!((&image["axes"][2]["unit"], image["datasets"].as_array().unwrap().len()), (&json!("millimeter"), 4));
        assert_eq!(
            Stored::levels(&get("zarr.json")).unwrap(),
            (["1", "2", "3"].map(|n| format!("levels/{n}/")).to_vec(), Some(rule))
        );
        let (mut coarse, pyramid) = (mesh.clone(), Pyramid::of(&mesh, rule));
        let mut known = Vec::new();
        for level in 0..4 {
            if level > 0 {
                coarse = at_once(pyramid.next(&coarse, &Control::default())).unwrap();
            }
            let path = image["datasets"][level]["path"].as_str().unwrap();
            let array = Array::open(store.clone(), &format!("/{path}")).unwrap();
            let [nx, ny, nz] = coarse.dims();
            assert_eq!(array.shape(), [nz, ny, nx].map(u64::from));
            let flags: Vec<u8> = array.retrieve_array_subset(&array.subset_all()).unwrap();
            assert!(flags == flags_of_box(coarse.columns(), &[0..nx, 0..ny, 0..nz]).unwrap(), "level {level}");
            // the middle of the first cell, and the distance to the next, as the arrays beside have them
            let x = Array::open(store.clone(), &format!("/{}x", path.strip_suffix("flag").unwrap())).unwrap();
            let x: Vec<f64> = x.retrieve_array_subset(&x.subset_all()).unwrap();
            let transforms = &image["datasets"][level]["coordinateTransformations"];
            assert_eq!(
                (&transforms[1]["translation"][2], &transforms[0]["scale"][2]),
                (&json!(x[0]), &json!(x[1] - x[0]))
            );
            // what the group says of its arrays is what these say
            let told = &group["consolidated_metadata"]["metadata"][path];
            assert_eq!(*told, serde_json::from_slice::<serde_json::Value>(&get(&format!("{path}/zarr.json"))).unwrap());
            let stored = Stored::new(path.strip_suffix("flag").unwrap(), &get(&format!("{path}/zarr.json"))).unwrap();
            assert_eq!(stored.is_sparse(), sparse);
            known.extend(stored.keys());
        }
        let keys: Vec<String> = store.list().unwrap().iter().map(|key| key.to_string()).collect();
        let shards: Vec<&String> = keys.iter().filter(|key| Stored::is_of_shard(key)).collect();
        assert!(shards.iter().all(|key| known.contains(key)) && shards.len() > 8, "{shards:?}");
        assert!(if sparse { shards.len() <= known.len() } else { shards.len() == known.len() });
        // as an archive
        let mut bytes = Vec::new();
        crate::write::write(&mesh, Format::ZarrZip, &given, &mut bytes, &Control::default()).unwrap();
        let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).unwrap();
        assert_eq!(archive.len(), keys.len());
        for key in &keys {
            let mut found = Vec::new();
            archive.by_name(key).unwrap().read_to_end(&mut found).unwrap();
            assert!(found == get(key), "{key}");
        }
    }
}

#[test]
fn sparse_stores_have_the_shards_with_flags_alone() {
    let rays = Rays::new(0, [100, 90, 80]);
    // one cell
    let mut band = Band::default();
    band.ends = (0..rays.n_rays()).map(|ray| u32::from(ray > 4 + 90 * 70)).collect();
    band.ends[4 + 90 * 70 + 1..].fill(2);
    band.ends[4 + 90 * 70] = 2;
    band.runs = vec![run(50, 7), run(51, 0)];
    let columns = Columns::new(rays, vec![band]).unwrap();
    let lines = pattern(0, [100, 90, 80], 3).lines().clone();
    let mesh = Mesh::new(lines, columns, Vec::new(), None).unwrap();
    let shapes = set!(ZarrJob { chunks: Some([16; 3]), shards: Some([32; 3]), sparse: true, ..ZarrJob::default() });
    let options = Options { zarr: shapes, ..Options::default() };
    let keys = std::sync::Mutex::new(Vec::new());
    let keep = |key: &str, _: &[u8]| {
        keys.lock().unwrap().push(key.to_string());
        Ok(())
    };
    write(&mesh, &options, &keep, &Control::default(), |_| ()).unwrap();
    let mut keys = keys.into_inner().unwrap();
    keys.retain(|key| Stored::is_of_shard(key));
    assert_eq!(keys, ["flag/c/2/0/1"]);
}

#[test]
fn sparse_stores_of_other_numbers_have_all_shards() {
    // cells that are cut may have no flag, and all cells have a distance: what has no flags is not empty
    let mesh = Mesh::new(
        pattern(0, [100, 90, 80], 3).lines().clone(),
        Columns::new(Rays::new(0, [100, 90, 80]), vec![band_of(&Rays::new(0, [100, 90, 80]), |_| 0)]).unwrap(),
        Vec::new(),
        None,
    );
    let zarr = set!(ZarrJob { chunks: Some([16; 3]), shards: Some([64; 3]), sparse: true, ..ZarrJob::default() });
    let options = Options { zarr, ..Options::default() };
    let keys = std::sync::Mutex::new(Vec::new());
    let keep = |key: &str, value: &[u8]| {
        keys.lock().unwrap().push((key.to_string(), String::from_utf8_lossy(value).contains("sparse")));
        Ok(())
    };
    write_solid(&mesh.unwrap(), &no_fractions([100, 90, 80]), &options, &keep, &Control::default()).unwrap();
    let keys = keys.into_inner().unwrap();
    assert_eq!(keys.iter().filter(|(key, _)| key.starts_with("solid/c/")).count(), 8);
    assert!(keys.iter().all(|(_, says_sparse)| !says_sparse));
}

#[test]
fn levels_of_a_part_are_refused() {
    let mesh = pattern(0, [64, 64, 128], 3);
    let zarr =
        set!(ZarrJob { shards: Some([64; 3]), chunks: Some([32; 3]), levels: Some(Levels::Any), ..ZarrJob::default() });
    let options = Options { zarr, ..Options::default() };
    let (part, place) = (cut(&mesh, [[0; 3], [64; 3]]), Place { whole: mesh.lines().clone(), first: [0; 3] });
    let none = |_: &str, _: &[u8]| panic!("nothing is written");
    let error = write_part(&part, &place, &options, &none, &Control::default(), |_| ()).unwrap_err();
    assert_eq!(error.code(), "job-conflict");
}

#[test]
fn graded_lines_are_shown_by_numbers_of_cells() {
    let mesh = pattern(0, [66, 3, 2], 3);
    let mut lists = [0, 1, 2].map(|axis| mesh.lines().list(axis));
    lists[0][66] += 1.0;
    let lines = Lines::from_lists(lists).unwrap();
    let mut given = options(Compress::None, 1 << 20);
    given.zarr.levels = Some(Levels::Majority);
    let group: serde_json::Value =
        serde_json::from_slice(&metadata(&lines, mesh.names(), mesh.unit(), &given).unwrap()).unwrap();
    let image = &group["attributes"]["ome"]["multiscales"][0];
    assert_eq!(image["axes"][0], json!({ "name": "z", "type": "space" }));
    let of_level = |level: usize| &image["datasets"][level]["coordinateTransformations"];
    assert_eq!(of_level(0)[1], json!({ "type": "translation", "translation": [0.0, 0.0, 0.0] }));
    assert_eq!(of_level(1)[0], json!({ "type": "scale", "scale": [2.0, 2.0, 2.0] }));
    assert_eq!(of_level(1)[1], json!({ "type": "translation", "translation": [0.5, 0.5, 0.5] }));
    assert!(image["metadata"]["description"].as_str().unwrap().contains("numbers of cells"));
}

/// Every key of what is written by so many threads, with its bytes.
fn stored(mesh: &Mesh, compress: Compress, shard_bytes: u64, threads: usize) -> Vec<(String, Vec<u8>)> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let (store, _) = pool.install(|| written(mesh, compress, shard_bytes));
    let bytes = |key: &StoreKey| store.get(key).unwrap().expect("a value").to_vec();
    store.list().unwrap().iter().map(|key| (key.to_string(), bytes(key))).collect()
}

#[test]
fn the_bytes_do_not_depend_on_the_threads_or_the_run() {
    for axis in 0..3 {
        let mesh = pattern(axis, [150, 90, 140], 3);
        for (compress, shard_bytes) in
            [(Compress::None, 1 << 18), (Compress::Zlib(1), 1 << 18), (Compress::Zlib(6), 1 << 24)]
        {
            let one = stored(&mesh, compress, shard_bytes, 1);
            let shards = one.iter().filter(|(key, _)| key.starts_with("flag/c/")).count();
            assert!(shards >= if shard_bytes == 1 << 18 { 4 } else { 1 }, "{shards} shards");
            for threads in [1, 2, 3, 8] {
                let again = stored(&mesh, compress, shard_bytes, threads);
                assert!(again == one, "axis {axis}, {compress:?}, shards of {shard_bytes}, {threads} threads");
            }
        }
    }
}

#[test]
fn bits_are_refused_and_cancel_stops() {
    let mesh = pattern(0, [9, 5, 7], 3);
    let control = Control::default();
    control.cancel.cancel();
    let none = |_: &str, _: &[u8]| Ok(());
    let error = write(&mesh, &Options::default(), &none, &control, |_| ()).unwrap_err();
    assert_eq!(error.code(), "cancelled");
    let bits = Options { bits: true, ..Options::default() };
    let error = write(&mesh, &bits, &none, &Control::default(), |_| ()).unwrap_err();
    assert_eq!(error.code(), "job-conflict");
}

/// The cells of a mesh in a box, as a mesh of their own.
fn cut(mesh: &Mesh, cells: [[u32; 3]; 2]) -> Mesh {
    let lines = mesh.lines().window(cells);
    let rays = Rays::new(mesh.columns().rays().axis, lines.dims());
    let mut band = Band::default();
    for ray in 0..rays.n_rays() as u32 {
        let mut last = 0;
        for along in 0..rays.depth {
            let cell = rays.cell([ray % rays.counts[0], ray / rays.counts[0], along]);
            let flag = mesh.flag([0, 1, 2].map(|axis| cells[0][axis] + cell[axis])).unwrap();
            if flag != last {
                band.runs.push(run(along, flag));
                last = flag;
            }
        }
        band.ends.push(band.runs.len() as u32);
    }
    Mesh::new(lines, Columns::new(rays, vec![band]).unwrap(), mesh.names().to_vec(), mesh.unit().map(str::to_string))
        .unwrap()
}

#[test]
fn parts_in_any_order_and_repeated_fill_the_store_of_the_whole() {
    let dims = [70, 50, 40];
    let zarr = set!(ZarrJob { chunks: Some([16, 8, 8]), shards: Some([32, 16, 16]), ..ZarrJob::default() });
    for (axis, compress) in [(0, Compress::None), (1, Compress::Zlib(6)), (2, Compress::Zlib(1))] {
        let mesh = pattern(axis, dims, 3);
        let options = Options { compress, zarr, ..Options::default() };
        let whole = MemoryStore::new();
        write(&mesh, &options, &|key, value| set(&whole, key, value), &Control::default(), |_| ()).unwrap();
        let parted = MemoryStore::new();
        let set_part = |key: &str, value: &[u8]| set(&parted, key, value);
        let ends = [[0, 32, 70], [0, 16, 50], [0, 32, 40]];
        for of in [3usize, 6, 0, 7, 7, 1, 5, 2, 4, 3] {
            let first = [0, 1, 2].map(|axis| ends[axis][of >> axis & 1]);
            let end = [0, 1, 2].map(|axis| ends[axis][(of >> axis & 1) + 1]);
            let (part, place) = (cut(&mesh, [first, end]), Place { whole: mesh.lines().clone(), first });
            write_part(&part, &place, &options, &set_part, &Control::default(), |_| ()).unwrap();
        }
        let all = |store: &MemoryStore| -> Vec<(StoreKey, Option<zarrs::storage::Bytes>)> {
            store.list().unwrap().into_iter().map(|key| (key.clone(), store.get(&key).unwrap())).collect()
        };
        assert!(all(&whole) == all(&parted), "axis {axis}");
        assert_eq!(all(&whole).len(), 8 + 3 * 4 * 3);
        let odd = Place { whole: mesh.lines().clone(), first: [0, 0, 8] };
        let part = cut(&mesh, [[0, 0, 8], dims]);
        let error = write_part(&part, &odd, &options, &set_part, &Control::default(), |_| ()).unwrap_err();
        assert_eq!(error.to_string(), "cells 8 to 40 along z begin or end within a shard, of 16 cells");
    }
}

#[test]
fn every_wrong_byte_of_a_compressed_shard_is_found() {
    let mesh = pattern(0, [40, 20, 20], 3);
    let (store, _) = written(&mesh, Compress::Zlib(6), 4_000);
    let get = |key: &str| store.get(&StoreKey::new(key).unwrap()).unwrap().expect("a value").to_vec();
    let stored = Stored::new("", &get(Stored::METADATA)).unwrap();
    let keys: Vec<String> = stored.keys().collect();
    assert!(keys.len() > 2 && keys.iter().all(|key| stored.has(key)), "{keys:?}");
    assert!(
        ["flag/c/0/0", "flag/c/0/0/9", "flag/c/00/0/0", "flag/zarr.json", "flag/c/0/0/0/0"]
            .iter()
            .all(|key| !stored.has(key))
    );
    let (zarr, compress) = stored.options();
    let Shards { shard, chunk } = Shards::new([40, 20, 20], &options(Compress::None, 4_000).zarr).unwrap();
    assert_eq!((zarr.shards, zarr.chunks, compress), (Some(shard), Some(chunk), Compress::Zlib(6)));
    let shard = get(&keys[0]);
    stored.check(&shard).unwrap();
    let mut not_found = Vec::new();
    for at in 0..shard.len() {
        let mut wrong = shard.clone();
        wrong[at] ^= 0x10;
        if stored.check(&wrong).is_ok() {
            not_found.push(at);
        }
    }
    // the head of a gzip stream has bytes without meaning for its cells: the time and the system
    assert!(
        not_found.iter().all(|at| (4..10).contains(at)) || not_found.len() <= 7 * 8,
        "{not_found:?} of {}",
        shard.len()
    );
    for n in [0, 1, shard.len() / 2, shard.len() - 1] {
        assert_eq!(stored.check(&shard[..n]).unwrap_err().code(), "io", "{n} bytes");
    }
    assert_eq!(stored.check(&[&shard[..], &[0]].concat()).unwrap_err().code(), "io");
    assert_eq!(Stored::new("", b"{}").err().map(|error| error.code()), Some("io"));
}
