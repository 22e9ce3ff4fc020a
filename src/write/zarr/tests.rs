use zarrs::storage::store::MemoryStore;
use zarrs::storage::{ListableStorageTraits, ReadableStorageTraits, ReadableWritableListableStorage, StoreKey};
use zarrs_codec::{Codec, CodecRuntimePluginV3, register_codec_v3};

use super::*;
use crate::mesh::tests::{pattern, pattern_flags};

fn written(mesh: &Mesh, compress: Compress, slab_bytes: usize) -> (ReadableWritableListableStorage, u64) {
    let store: ReadableWritableListableStorage = Arc::new(MemoryStore::new());
    let options = Options { compress, slab_bytes, ..Options::default() };
    let mut n_cells = 0;
    write(mesh, &options, store.clone().writable(), &Control::default(), |n| n_cells += n).unwrap();
    (store, n_cells)
}

#[test]
fn flags_centres_and_attributes_read_back() {
    register_codec_v3(CodecRuntimePluginV3::new(|name| name == "gzip", |_| Ok(Codec::BytesToBytes(Arc::new(Gzip(1))))));
    let dims = [70, 9, 67];
    for axis in 0..3 {
        let mesh = pattern(axis, dims, 3);
        for compress in [Compress::None, Compress::Zlib(1)] {
            for slab_bytes in [1, 5_000, 1 << 20] {
                let (store, n_cells) = written(&mesh, compress, slab_bytes);
                assert_eq!(n_cells, mesh.n_cells());
                let array = Array::open(store.clone(), "/flag").unwrap();
                assert_eq!(array.shape(), [67, 9, 70]);
                let flags: Vec<u8> = array.retrieve_array_subset(&array.subset_all()).unwrap();
                assert!(flags == pattern_flags(dims, 3), "axis {axis}, slabs of {slab_bytes}, {compress:?}");
                let attributes = array.attributes();
                assert!(attributes.keys().all(|key| !key.starts_with('_')), "{attributes:?}");
                assert_eq!(attributes["origin"], json!(mesh.lines.origin));
                assert_eq!(attributes["lines"]["x"].as_array().unwrap().len(), 71);
                assert_eq!((&attributes["unit"], &attributes["flags"][0]["name"]), (&json!("mm"), &json!("copper")));
                let x = Array::open(store, "/x").unwrap();
                let x: Vec<f64> = x.retrieve_array_subset(&x.subset_all()).unwrap();
                assert_eq!((x.len(), x[0]), (70, -1.5 + 0.25));
            }
        }
    }
}

/// Every key of what is written by so many threads, with its bytes.
fn stored(mesh: &Mesh, compress: Compress, slab_bytes: usize, threads: usize) -> Vec<(String, Vec<u8>)> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let (store, _) = pool.install(|| written(mesh, compress, slab_bytes));
    let bytes = |key: &StoreKey| store.get(key).unwrap().expect("a value").to_vec();
    store.list().unwrap().iter().map(|key| (key.to_string(), bytes(key))).collect()
}

#[test]
fn the_bytes_do_not_depend_on_the_threads_or_the_run() {
    for axis in 0..3 {
        let mesh = pattern(axis, [150, 90, 140], 3);
        for (compress, slab_bytes) in
            [(Compress::None, 1 << 20), (Compress::Zlib(1), 1 << 20), (Compress::Zlib(6), 1 << 24)]
        {
            let one = stored(&mesh, compress, slab_bytes, 1);
            let shards = one.iter().filter(|(key, _)| key.starts_with("flag/c/")).count();
            assert!(shards >= if slab_bytes == 1 << 20 { 4 } else { 1 }, "{shards} shards");
            for threads in [1, 2, 3, 8] {
                let again = stored(&mesh, compress, slab_bytes, threads);
                assert!(again == one, "axis {axis}, {compress:?}, slabs of {slab_bytes}, {threads} threads");
            }
        }
    }
}

#[test]
fn shards_are_slabs_of_whole_chunks() {
    let slab = 32 << 20;
    let table = [
        ([70, 9, 67], [67, 9, 70], [64, 9, 64]),
        ([1000, 1000, 1000], [0, 0, 1024], [64, 64, 64]),
        ([10_000, 10_000, 10_000], [32, 96, 10_240], [32, 32, 256]),
        ([200_000, 10, 10], [8, 10, 200_000], [8, 8, 4096]),
    ];
    for (dims, _, _) in table {
        let Layout { shard, chunk } = Layout::new(dims, slab);
        let bytes: u64 = shard.iter().map(|&n| u64::from(n)).product();
        assert!(bytes <= slab as u64, "{dims:?}: {shard:?}");
        assert!((0..3).all(|axis| shard[axis].is_multiple_of(chunk[axis])), "{dims:?}: {shard:?} of {chunk:?}");
        assert!(shard[2] >= dims[0], "{dims:?}: {shard:?}");
    }
    assert_eq!(Layout::new([1000; 3], slab), Layout { shard: [64, 512, 1024], chunk: [64; 3] });
    assert_eq!(Layout::new([3, 2, 1], slab), Layout { shard: [1, 2, 3], chunk: [1, 2, 3] });
}

#[test]
fn empty_shards_are_left_out_and_cancel_stops() {
    let mesh = pattern(0, [9, 5, 7], 3);
    let control = Control::default();
    control.cancel.cancel();
    let store = Arc::new(MemoryStore::new());
    let error = write(&mesh, &Options::default(), store.clone(), &control, |_| ()).unwrap_err();
    assert_eq!(error.code(), "cancelled");
    let bits = Options { bits: true, ..Options::default() };
    let error = write(&mesh, &bits, store, &Control::default(), |_| ()).unwrap_err();
    assert_eq!(error.code(), "job-conflict");
}
