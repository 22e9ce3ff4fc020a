use super::*;
use crate::cells::columns::file::head::Head;
use crate::cells::columns::file::piece::PIECE_HEAD;
use crate::cells::columns::{MemoryStore, run};
use crate::cells::flags::flags_of_box;
use crate::grid::lines::Lines;

/// Bands of some rows of a box of 5 x 7 rays with up to 4 runs each.
fn bands(rays: &Rays, rows: u32) -> Vec<Band> {
    let starts = (0..rays.counts[1]).step_by(rows as usize);
    starts
        .map(|start| {
            let first_ray = u64::from(start * rays.counts[0]);
            let mut band = Band { first_ray, odd_rays: 1, n_crossings: 3, ..Band::default() };
            for ray in start * rays.counts[0]..(start + rows).min(rays.counts[1]) * rays.counts[0] {
                band.runs.extend((0..ray % 5).map(|k| run(ray % 3 + 2 * k, 1 + (k % 2) as u8)));
                band.ends.push(band.runs.len() as u32);
            }
            band
        })
        .collect()
}

/// The head of a file of these rays.
fn head(rays: &Rays, dims: [u32; 3], identity: Option<[u8; 32]>) -> Vec<u8> {
    let lines = Lines::new([0.0; 3], [1.0; 3], dims).unwrap();
    Head { identity, rays: *rays, zlib: false, lines, unit: None, names: Vec::new() }.encode().unwrap()
}

fn built(mut builder: ColumnsBuilder, bands: Vec<Band>) -> Columns {
    bands.into_iter().for_each(|band| builder.push(vec![band]).unwrap());
    builder.finish().unwrap()
}

#[test]
fn columns_in_a_store_answer_as_those_in_memory() {
    for axis in 0..3 {
        let mut dims = [5, 5, 7];
        dims[axis] = 12;
        let rays = Rays::new(axis, dims);
        let held = Columns::new(rays, bands(&rays, 2)).unwrap();
        // from the first band on, in the middle, never
        let all_bytes = held.n_bytes();
        for max_bytes in [0, 150, all_bytes - 1, all_bytes, u64::MAX] {
            let store = Arc::new(MemoryStore::default());
            let target = (head(&rays, dims, None), store.clone() as Arc<dyn Store>);
            let columns = built(ColumnsBuilder::new(rays, max_bytes, Some(target)), bands(&rays, 2));
            assert_eq!(columns.is_spilled(), max_bytes < all_bytes);
            assert_eq!(columns.is_spilled(), !store.bytes().is_empty());
            assert_eq!(columns, held);
            (0..rays.n_rays()).for_each(|ray| assert_eq!(columns.ray(ray), held.ray(ray)));
            assert_eq!(columns.padded([[0; 3]; 2], crate::input::job::HaloEdge::Clamp).is_err(), columns.is_spilled());
            assert_eq!(columns.cells_per_flag(), held.cells_per_flag());
            let counts = |columns: &Columns| [columns.n_runs(), columns.n_crossings(), columns.odd_rays()];
            assert_eq!(counts(&columns), counts(&held));
            for cells in [dims.map(|n| 0..n), dims.map(|n| 1..n - 1)] {
                let flags = flags_of_box(&held, &cells).unwrap();
                assert_eq!(flags_of_box(&columns, &cells).unwrap(), flags);
            }
            assert_eq!(columns.flag([3, 4, 2]), held.flag([3, 4, 2]));
        }
    }
}

#[test]
fn a_band_of_more_rays_than_a_piece_has_its_counts_once() {
    // the first of two pieces ends with a row
    let dims = [256, 264, 9];
    let rays = Rays::new(2, dims);
    let all = || bands(&rays, 264);
    assert!(all().len() == 1 && rays.n_rays() > u64::from(crate::cells::columns::codec::PIECE_RAYS));
    let store = Arc::new(MemoryStore::default());
    let keep = || ColumnsBuilder::resume(rays, 0, head(&rays, dims, Some([7; 32])), store.clone()).unwrap();
    let columns = built(keep(), all());
    assert_eq!((columns.odd_rays(), columns.n_crossings()), (1, 3));
    // the band is taken up whole or not at all
    let n_bytes = store.bytes().len();
    store.bytes().truncate(n_bytes - 3000);
    assert_eq!(keep().n_rays(), 0);
}

#[test]
fn what_is_held_at_most_is_counted() {
    let rays = Rays::new(0, [12, 5, 7]);
    let unpacked = |band: &Band| 4 * (band.ends.len() + band.runs.len()) as u64;
    // four bytes a block of 64 rays, one a ray, four a run
    let packed = |band: &Band| (4 + band.ends.len() + 4 * band.runs.capacity()) as u64;
    let exact = || -> Vec<Band> {
        bands(&rays, 2).into_iter().map(|band| Band { runs: band.runs.into_boxed_slice().into_vec(), ..band }).collect()
    };
    let store = Arc::new(MemoryStore::default());
    for max_bytes in [u64::MAX, 50, exact().iter().take(2).map(packed).sum::<u64>()] {
        let target = (head(&rays, [12, 5, 7], None), Arc::new(MemoryStore::default()) as Arc<dyn Store>);
        let mut builder = ColumnsBuilder::new(rays, max_bytes, Some(target));
        let (mut held, mut most) = (0, 0);
        for band in exact() {
            most = most.max(held + unpacked(&band));
            held += packed(&band);
            most = most.max(held);
            builder.push(vec![band]).unwrap();
            // once they exceed the limit they are in the store
            held = if held > max_bytes { 0 } else { held };
            assert_eq!(builder.peak_bytes, most, "{max_bytes}");
        }
    }
    let resumed = || ColumnsBuilder::resume(rays, u64::MAX, head(&rays, [12, 5, 7], None), store.clone()).unwrap();
    let n_bytes = built(resumed(), exact()).n_bytes();
    assert_eq!(resumed().peak_bytes, n_bytes);
}

#[test]
fn bands_that_end_within_a_row_or_beyond_the_box_are_not_taken_up() {
    let (small, large) = (Rays::new(0, [12, 5, 7]), Rays::new(0, [12, 5, 9]));
    let head = head(&small, [12, 5, 7], Some([7; 32]));
    let resume = |rays, store: &Arc<MemoryStore>| ColumnsBuilder::resume(rays, 0, head.clone(), store.clone()).unwrap();
    let store = Arc::new(MemoryStore::default());
    bands(&large, 2).into_iter().for_each({
        let mut builder = resume(large, &store);
        move |band| builder.push(vec![band]).unwrap()
    });
    assert_eq!(resume(small, &store).n_rays(), 30);
    let store = Arc::new(MemoryStore::default());
    let mut builder = resume(small, &store);
    for first_ray in [0, 7, 14] {
        builder.push(vec![Band { first_ray, ends: vec![0; 7], ..Band::default() }]).unwrap();
    }
    assert_eq!(resume(small, &store).n_rays(), 0);
    let mut builder = resume(small, &store);
    for (first_ray, n) in [(0, 7), (7, 8), (15, 6)] {
        builder.push(vec![Band { first_ray, ends: vec![0; n], ..Band::default() }]).unwrap();
    }
    assert_eq!(resume(small, &store).n_rays(), 15);
}

#[test]
fn without_a_store_the_limit_is_an_error_with_numbers() {
    let rays = Rays::new(0, [12, 5, 7]);
    let mut builder = ColumnsBuilder::new(rays, 100, None);
    let error = bands(&rays, 1).into_iter().find_map(|band| builder.push(vec![band]).err()).unwrap();
    assert!(error.code() == "memory" && error.to_string().contains("and 100 are left"), "{error}");
}

#[test]
fn a_store_that_was_cut_short_is_taken_up_at_the_last_whole_row() {
    let rays = Rays::new(0, [12, 5, 7]);
    let whole = Columns::new(rays, bands(&rays, 2)).unwrap();
    let store = Arc::new(MemoryStore::default());
    let keep = |store: &Arc<MemoryStore>, max_bytes| {
        ColumnsBuilder::resume(rays, max_bytes, head(&rays, [12, 5, 7], Some([7; 32])), store.clone()).unwrap()
    };
    assert_eq!(built(keep(&store, u64::MAX), bands(&rays, 2)), whole);
    let bytes = store.bytes().clone();
    for max_bytes in [0, u64::MAX] {
        let mut taken = std::collections::BTreeSet::new();
        for length in 0..=bytes.len() {
            let store = Arc::new(MemoryStore::default());
            store.bytes().extend(&bytes[..length]);
            let builder = keep(&store, max_bytes);
            let n_rays = builder.n_rays();
            assert!(n_rays <= rays.n_rays());
            taken.insert(n_rays);
            let rest = bands(&rays, 2).into_iter().filter(|band| band.first_ray >= n_rays).collect();
            let columns = built(builder, rest);
            assert_eq!(columns, whole, "{length} bytes");
            assert_eq!([columns.odd_rays(), columns.n_crossings()], [4, 12], "{length} bytes");
            assert_eq!(*store.bytes(), bytes, "{length} bytes");
        }
        assert_eq!(taken.into_iter().collect::<Vec<_>>(), [0, 10, 20, 30, 35]);
    }
}

#[test]
fn a_store_of_something_else_is_refused_and_left_alone() {
    let rays = Rays::new(0, [12, 5, 7]);
    let store = Arc::new(MemoryStore::default());
    let keep = |store: &Arc<MemoryStore>, identity: u8| {
        ColumnsBuilder::resume(rays, 0, head(&rays, [12, 5, 7], Some([identity; 32])), store.clone())
    };
    built(keep(&store, 7).unwrap(), bands(&rays, 2));
    let before = store.bytes().clone();
    let error = keep(&store, 8).err().unwrap();
    assert!(error.code() == "columns-other" && error.hint().contains("delete"), "{error}");
    assert_eq!(*store.bytes(), before);
    // a file that happens to have the name, shorter than a head
    store.bytes().truncate(20);
    for foreign in [&before[..20], b"notes", &[0]] {
        *store.bytes() = foreign.to_vec();
        let error = keep(&store, 8).err().unwrap();
        assert_eq!((error.code(), &store.bytes()[..]), ("columns-other", foreign));
        assert!(error.to_string().ends_with(&format!(": it has {} bytes", foreign.len())), "{error}");
    }
}

#[test]
fn bytes_that_begin_no_column_file_are_counted() {
    let rays = Rays::new(0, [12, 5, 7]);
    let head = head(&rays, [12, 5, 7], Some([7; 32]));
    for n in 1..head.len() {
        let store = Arc::new(MemoryStore::new(vec![b'x'; n]));
        let error = ColumnsBuilder::resume(rays, 0, head.clone(), store).err().unwrap();
        assert!(error.to_string().ends_with(&format!(": it has {n} bytes")), "{error}");
    }
}

#[test]
fn what_the_store_gives_back_is_checked() {
    let rays = Rays::new(0, [12, 5, 7]);
    let store = Arc::new(MemoryStore::default());
    let head = head(&rays, [12, 5, 7], None);
    let first = head.len();
    let columns = built(ColumnsBuilder::new(rays, 0, Some((head, store.clone()))), bands(&rays, 7));
    store.bytes()[first + PIECE_HEAD] ^= 1;
    let error = columns.ray(0).unwrap_err();
    assert!(error.code() == "io" && error.to_string().contains(&format!("damaged at byte {first}")), "{error}");
    store.bytes().clear();
    let error = columns.for_rays(0..1, |_| ()).unwrap_err();
    assert!(error.code() == "io" && error.to_string().contains("reading columns from the disk"), "{error}");
    assert_ne!(columns, columns.clone());
}

#[test]
fn a_store_of_another_mesh_is_refused_with_what_differs() {
    let encoded = |origin: f64, n: u32, axis: usize, names: &[&str]| {
        let dims = [n, 5, 7];
        let lines = Lines::new([origin, 0.0, 0.0], [1.0; 3], dims).unwrap();
        let names = (1..).zip(names).map(|(flag, name)| Named::new(flag, name.to_string())).collect();
        let head = Head { identity: Some([7; 32]), rays: Rays::new(axis, dims), zlib: false, lines, unit: None, names };
        (head.rays, head.encode().unwrap())
    };
    let (rays, before) = encoded(0.0, 12, 0, &["copper"]);
    let table = [
        (encoded(0.0, 13, 0, &["copper"]), "12 x 5 x 7 cells, where 13 x 5 x 7 are asked for"),
        (
            encoded(0.5, 12, 0, &["copper"]),
            "lines from [0.0, 0.0, 0.0], cells of [1.0, 1.0, 1.0], where [0.5, 0.0, 0.0]",
        ),
        (encoded(0.0, 12, 1, &["copper"]), "rays along x, where y is asked for"),
        (
            encoded(0.0, 12, 0, &["iron", "air"]),
            "the flags are 1 \"copper\", where 1 \"iron\", 2 \"air\" are asked for",
        ),
    ];
    for ((other, head), sentence) in table {
        let store = Arc::new(MemoryStore::default());
        built(ColumnsBuilder::resume(rays, 0, before.clone(), store.clone()).unwrap(), bands(&rays, 2));
        let error = ColumnsBuilder::resume(other, 0, head, store).err().unwrap();
        assert!(error.code() == "columns-other" && error.to_string().contains(sentence), "{error}");
    }
}
