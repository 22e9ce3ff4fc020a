use std::sync::Arc;

use proptest::prelude::*;

use super::*;
use crate::write::{Format, Options, write};
use hexcast_core::base::checksum::crc32;
use hexcast_core::base::zlib;
use hexcast_core::cells::columns::file::piece::PIECE_HEAD;
use hexcast_core::cells::columns::{Band, Columns, ColumnsBuilder, MemoryStore, codec, run};
use hexcast_core::grid::lines::Lines;
use hexcast_core::grid::rays::Rays;
use hexcast_core::set;
use hexcast_derived::testing::{parts, pattern};

mod opened;

fn options(zlib: bool) -> Options {
    Options { compress: if zlib { Compress::Zlib(1) } else { Compress::None }, ..Options::default() }
}

fn bytes(mesh: &Mesh, zlib: bool) -> Vec<u8> {
    let mut out = Vec::new();
    let written = write(mesh, Format::Columns, &options(zlib), &mut out, &Control::default()).unwrap();
    assert_eq!(written.n_bytes, out.len() as u64);
    out
}

fn code(bytes: &[u8]) -> &'static str {
    opened(bytes).map_or_else(|error| error.code(), |_| "accepted")
}

/// Opens a file without reading its pieces and then reads all of them.
fn opened(bytes: &[u8]) -> Result<Mesh> {
    let mesh = read(&mut &bytes[..], 1 << 25)?;
    assert!(mesh.columns().is_spilled());
    mesh.columns().for_rays(0..mesh.columns().rays().n_rays(), |_| ())?;
    Ok(mesh)
}

/// The bands of a mesh, of `n` rays each.
fn bands(mesh: &Mesh, n: usize) -> Vec<Band> {
    let n_rays = mesh.columns().rays().n_rays() as usize;
    let band = |first: usize| {
        let rays = first..(first + n).min(n_rays);
        let runs: Vec<Vec<u32>> = rays.map(|ray| mesh.columns().ray(ray as u64).unwrap().into_owned()).collect();
        let ends = runs.iter().scan(0, |end, runs| {
            *end += runs.len() as u32;
            Some(*end)
        });
        let counts = if first == 0 { [mesh.columns().odd_rays(), mesh.columns().n_crossings()] } else { [0; 2] };
        set!(Band {
            first_ray: first as u64,
            ends: ends.collect(),
            runs: runs.concat(),
            odd_rays: counts[0],
            n_crossings: counts[1],
            ..Band::default()
        })
    };
    (0..n_rays).step_by(n).map(band).collect()
}

/// The same mesh with its bands split after every `n` rays.
fn split(mesh: &Mesh, n: usize) -> Mesh {
    let mut split = mesh.clone();
    *parts(&mut split).columns = Columns::new(*mesh.columns().rays(), bands(mesh, n)).unwrap();
    split
}

/// A mesh of one ray band with the runs given for each ray.
fn mesh_of(dims: [u32; 3], rays: impl Iterator<Item = Vec<u32>>) -> Mesh {
    let mut band = Band::default();
    for runs in rays {
        band.runs.extend(runs);
        band.ends.push(band.runs.len() as u32);
    }
    let lines = hexcast_core::grid::lines::Lines::new([0.0; 3], [1.0; 3], dims).unwrap();
    Mesh::new(lines, Columns::new(Rays::new(2, dims), vec![band]).unwrap(), vec![], None).unwrap()
}

/// The file with new bytes at an offset, and the checksums of head and first piece corrected.
fn forged(file: &[u8], at: usize, new: &[u8]) -> Vec<u8> {
    let mut file = file.to_vec();
    file[at..at + new.len()].copy_from_slice(new);
    let head = 16 + u32::from_le_bytes(file[12..16].try_into().unwrap()) as usize;
    let sum = crc32(&file[..head]);
    file[head..head + 4].copy_from_slice(&sum);
    let piece = head + 4;
    let stored = u32::from_le_bytes(file[piece + 16..piece + 20].try_into().unwrap()) as usize;
    let start = piece + PIECE_HEAD;
    let stored = start..(start + stored).min(file.len());
    let sum = crc32(&file[stored]);
    file[piece + 20..piece + 24].copy_from_slice(&sum);
    let sum = crc32(&file[piece..piece + 40]);
    file[piece + 40..piece + 44].copy_from_slice(&sum);
    file
}

/// Where the first piece starts.
fn first_piece(file: &[u8]) -> usize {
    20 + u32::from_le_bytes(file[12..16].try_into().unwrap()) as usize
}

#[test]
fn a_file_reads_back_for_every_ray_axis_and_split() {
    for axis in 0..3 {
        let mesh = pattern(axis, [9, 5, 7], 3);
        for zlib in [false, true] {
            let whole = bytes(&mesh, zlib);
            for n in [1, 4, 1000] {
                let file = bytes(&split(&mesh, n), zlib);
                assert_eq!(file, whole, "axis {axis}, bands of {n} rays");
                let back = opened(&file).unwrap();
                assert_eq!(back, mesh, "axis {axis}, bands of {n} rays");
                assert_eq!([back.columns().odd_rays(), back.columns().n_crossings()], [2, 1234567]);
                assert_eq!(back.columns().n_runs(), mesh.columns().n_runs());
                assert_eq!(back.columns().cells_per_flag(), mesh.columns().cells_per_flag());
            }
        }
    }
}

#[test]
fn many_pieces_read_back_and_stay_within_their_limits() {
    let dims = [700, 700, 20];
    let runs = |ray: u32| (0..ray * 31 % 7).map(|k| run(2 * k + ray % 3, (k % 2 + 1) as u8)).collect();
    let mesh = mesh_of(dims, (0..490_000).map(runs));
    let pieces = super::pieces(mesh.columns()).unwrap();
    assert!(pieces.len() > 7, "{}", pieces.len());
    for rays in &pieces {
        let n_runs: usize = rays.clone().map(|ray| mesh.columns().ray(ray).unwrap().len()).sum();
        assert!(rays.end - rays.start <= 1 << 16 && n_runs <= 1 << 18);
    }
    for zlib in [false, true] {
        assert_eq!(opened(&bytes(&mesh, zlib)).unwrap(), mesh);
    }
}

#[test]
fn a_ray_may_have_more_runs_than_a_piece() {
    let depth = (1 << 18) + 5;
    let full = |_| (0..depth).map(|cell| run(cell, (1 + cell % 2) as u8)).collect();
    let mesh = mesh_of([1, 3, depth], (0..3).map(full));
    assert_eq!(super::pieces(mesh.columns()).unwrap(), [0..1, 1..2, 2..3]);
    assert_eq!(opened(&bytes(&mesh, true)).unwrap(), mesh);
}

#[test]
fn the_bytes_are_those_of_the_layout() {
    // rays of 300 cells: [5, 200) flag 2, [200, 300) flag 0; nothing; [4, 300) flag 3
    let mesh = mesh_of([3, 1, 300], [vec![run(5, 2), run(200, 0)], vec![], vec![run(4, 3)]].into_iter());
    let file = bytes(&mesh, false);
    let mut expected = b"\x89HXC\r\n\x1a\n\x02\0\0\0\x46\0\0\0".to_vec();
    expected.extend(b"\0\x03\0\0\0\x01\0\0\0\x2c\x01\0\0\x02\0\0\0");
    (0..3).for_each(|_| expected.extend(0f64.to_le_bytes()));
    (0..3).for_each(|_| expected.extend(1f64.to_le_bytes()));
    expected.extend([0, 0, 0, 0, 0]);
    assert_eq!(file[..86], expected);
    assert_eq!(file[90..106], *b"BAND\x03\0\0\0\x03\0\0\0\x0a\0\0\0");
    // counts 2, 0, 1; cells 2 * 5, 2 * 195 = 0x186 as a varint, 2 * 4; flags
    assert_eq!(file[134..144], [2, 0, 1, 10, 0x86, 0x03, 8, 2, 0, 3]);
    assert_eq!(file[144..176], *b"ENDS\x01\0\0\0\0\0\0\0\x5a\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\x03\0\0\0");
    // no odd rays, no crossings; 195 cells of flag 2, 296 of flag 3
    assert_eq!(file[180..200], *b"\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\x02\0\0\0");
    assert_eq!(file[200..218], *b"\x02\xc3\0\0\0\0\0\0\0\x03\x28\x01\0\0\0\0\0\0");
    assert_eq!(file[222..], *b"\x90\0\0\0\0\0\0\0HXC END\n");
    // the checksum of the nine digits is the published check value
    assert_eq!(crc32(b"123456789"), 0xcbf4_3926u32.to_le_bytes());
}

#[test]
fn every_truncation_is_an_error() {
    for zlib in [false, true] {
        let file = bytes(&pattern(2, [5, 4, 6], 3), zlib);
        for n in 0..file.len() {
            let error = opened(&file[..n]).unwrap_err();
            assert_eq!(error.code(), "columns-corrupt", "{n} of {} bytes", file.len());
            let says = [format!("ends at byte {n},"), format!("of {n} bytes has no end")];
            assert!(says.iter().any(|says| error.to_string().contains(says)), "{error}");
        }
        let longer = [file.as_slice(), b"x"].concat();
        assert_eq!(code(&longer), "columns-corrupt");
    }
}

#[test]
fn every_changed_byte_is_an_error() {
    for zlib in [false, true] {
        let file = bytes(&pattern(1, [5, 4, 6], 3), zlib);
        for at in 0..file.len() {
            for change in [1, 0x80, 0xff] {
                let mut damaged = file.clone();
                damaged[at] ^= change;
                // version 3 is known, too
                let is_newer = (8..12).contains(&at) && damaged[8..12] != [3, 0, 0, 0];
                let expected = if is_newer { "columns-version" } else { "columns-corrupt" };
                assert_eq!(code(&damaged), expected, "byte {at} ^ {change}");
            }
        }
    }
}

#[test]
fn lies_with_right_checksums_are_errors() {
    let mesh = mesh_of([3, 1, 300], [vec![run(5, 2), run(200, 0)], vec![], vec![run(4, 3)]].into_iter());
    let file = bytes(&mesh, false);
    assert_eq!(code(&forged(&file, 0, b"")), "accepted");
    let piece = first_piece(&file);
    let content = piece + PIECE_HEAD;
    let lies: &[(&str, usize, &[u8], &str)] = &[
        ("identity 2", 16, &[2], "2 where 0 or 1"),
        ("no cells", 17, &[0; 4], "[0, 1, 300] cells"),
        ("2^24 + 1 cells", 17, &[1, 0, 0, 1], "16777217"),
        ("2^72 cells", 17, &[0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1], "16777216, 16777216, 16777216"),
        (
            "2^62 cells, of which three rays follow",
            17,
            &[0, 0, 0, 1, 0, 0, 0, 1, 0, 0x40, 0, 0],
            "piece 0 of the index does not fit",
        ),
        ("axis 3", 29, &[3], "ray axis 3"),
        ("compression 2", 30, &[2], "compression 2"),
        ("content is not zlib", 30, &[1], "piece at byte 90: corrupt deflate"),
        ("unknown kind of lines", 31, &[1], "kind 1"),
        ("origin not finite", 33, &f64::NAN.to_le_bytes(), "NaN"),
        ("spacing negative", 57, &(-1f64).to_le_bytes(), "size -1"),
        ("unit 2", 81, &[2], "2 where 0 or 1"),
        ("a unit that is not there", 81, &[1], "4 bytes, and 0 follow"),
        ("2^32 - 1 names", 82, &[0xff; 4], "1 bytes, and 0 follow"),
        ("no rays", piece + 4, &[0; 4], "its head says 0 rays"),
        ("more rays than the box", piece + 4, &[4], "its head says 4 rays"),
        ("2^32 - 1 rays", piece + 4, &[0xff; 4], "its head says 4294967295 rays"),
        ("2^32 - 1 runs", piece + 8, &[0xff; 4], "4294967295 runs"),
        ("2^18 runs", piece + 8, &[0, 0, 4, 0], "its head says 3 rays, 262144 runs"),
        ("more runs than cells", piece + 4, &[1, 0, 0, 0, 0x2d, 1], "its head says 1 rays, 301 runs"),
        ("fewer runs", piece + 8, &[2], "ray 2 has 1 runs"),
        ("longer content", piece + 12, &[0xff; 4], "10 bytes, its head says 4294967295"),
        ("2^32 - 1 stored bytes", piece + 16, &[0xff; 4], "3 runs, 4294967295 bytes"),
        ("counts above the runs", content, &[3], "ray 2 has 1 runs"),
        ("counts below the runs", content, &[1], "have 2 runs, its head says 3"),
        ("a count without end", content, &[0xff; 3], "ray 0 has 23068671 runs"),
        ("a first cell below 0", content + 3, &[1], "cell -1 of 300"),
        ("a cell not after the one before", content + 4, &[0x80, 0], "cell 5 of 300"),
        ("a cell past the ray", content + 4, &[0xfe, 0x7f], "cell 8196 of 300"),
        ("first flag 0", content + 7, &[0], "repeats flag 0"),
        ("flag repeated", content + 8, &[2], "run 1 repeats flag 2"),
    ];
    for (name, at, new, says) in lies {
        let error = opened(&forged(&file, *at, new)).unwrap_err();
        assert_eq!(error.code(), "columns-corrupt", "{name}");
        assert!(error.to_string().contains(says), "{name}: {error}");
    }
}

#[test]
fn a_stream_that_inflates_beyond_its_head_is_an_error() {
    let mesh = mesh_of([3, 1, 300], [vec![], vec![], vec![]].into_iter());
    let file = bytes(&mesh, true);
    let piece = first_piece(&file);
    let bomb = zlib::compress(&vec![0; 1 << 24], 9).unwrap();
    let mut file = [&file[..piece + PIECE_HEAD], &bomb].concat();
    file[piece + 16..piece + 20].copy_from_slice(&(bomb.len() as u32).to_le_bytes());
    assert_eq!(code(&forged(&file, piece + 12, &(1u32 << 24).to_le_bytes())), "columns-corrupt");
}

#[test]
fn a_newer_version_is_distinguished_from_damage() {
    let mut file = bytes(&pattern(0, [2, 2, 2], 1), false);
    file[8] = 5;
    assert_eq!(code(&file), "columns-version");
    assert_eq!(code(b"solid cube\nfacet normal 0 0 1\n"), "columns-corrupt");
}

#[test]
fn memory_and_cancel_are_obeyed() {
    let mesh = pattern(0, [9, 5, 7], 3);
    let file = bytes(&mesh, false);
    let needed = 2 * file.len() as u64;
    let read = |max_bytes| read(&mut file.as_slice(), max_bytes);
    assert_eq!(read(needed).unwrap(), mesh);
    assert_eq!(read(needed - 2).unwrap_err().code(), "memory");
    let control = Control::default();
    control.cancel.cancel();
    let error = write(&mesh, Format::Columns, &options(true), &mut Vec::new(), &control).unwrap_err();
    assert_eq!(error.code(), "cancelled");
}

/// Any columns of rays of up to 60 cells.
fn any_mesh() -> impl Strategy<Value = Mesh> {
    let ray = prop::collection::btree_map(0..60u32, 0..4u8, 0..12).prop_map(|changes| {
        let mut last = 0;
        let changed = changes.into_iter().filter(|&(_, flag)| std::mem::replace(&mut last, flag) != flag);
        changed.map(|(cell, flag)| run(cell, flag)).collect::<Vec<_>>()
    });
    prop::collection::vec(ray, 12).prop_map(|rays| mesh_of([4, 3, 60], rays.into_iter()))
}

proptest! {
    #[test]
    fn any_columns_read_back(mesh in any_mesh(), zlib: bool) {
        prop_assert_eq!(opened(&bytes(&mesh, zlib)).unwrap(), mesh);
    }

    #[test]
    fn any_content_is_decoded_to_sound_runs_or_refused(
        content in prop::collection::vec(prop_oneof![0..6u8, any::<u8>()], 0..40),
        n_rays in 1..6u32,
        n_runs in 0..20u32,
    ) {
        if let Ok(band) = codec::decode(&content, n_rays, n_runs, 60) {
            prop_assert_eq!([band.ends.len(), band.runs.len()], [n_rays as usize, n_runs as usize]);
            for ray in 0..n_rays as usize {
                prop_assert!(band.ray(ray).windows(2).all(|two| two[0] >> 8 < two[1] >> 8));
                prop_assert!(band.ray(ray).iter().all(|run| run >> 8 < 60));
            }
        }
    }

    #[test]
    fn any_forged_bytes_are_read_or_refused(
        mesh in any_mesh(),
        zlib: bool,
        index in any::<prop::sample::Index>(),
        new in prop::collection::vec(any::<u8>(), 1..5),
    ) {
        let file = bytes(&mesh, zlib);
        // not the numbers by which `forged` finds its way
        let at = 16 + index.index(file.len() - 16 - new.len());
        let code = code(&forged(&file, at, &new));
        prop_assert!(["accepted", "columns-corrupt"].contains(&code), "{code}");
    }
}

#[test]
fn materials_and_the_name_of_the_background_read_back_in_a_version_of_their_own() {
    let plain = pattern(1, [5, 4, 6], 3);
    for lists in [false, true] {
        let mut mesh = plain.clone();
        if lists {
            *parts(&mut mesh).lines = Lines::from_lists([
                vec![0.0, 1.0, 2.0, 4.0, 5.0, 6.0],
                (0..5).map(f64::from).collect(),
                (0..7).map(f64::from).collect(),
            ])
            .unwrap();
        }
        let version = bytes(&mesh, false)[8];
        assert_eq!(version, if lists { 3 } else { 2 });
        parts(&mut mesh).names.push(hexcast_derived::mesh::Named::new(0, "air"));
        parts(&mut mesh).names[1].material.eps_r = Some(2.2);
        parts(&mut mesh).names[1].material.pec = true;
        let file = bytes(&mesh, true);
        assert_eq!(file[8], 4);
        let read = opened(&file).unwrap();
        assert_eq!((read.names(), read.lines(), read.unit()), (mesh.names(), mesh.lines(), mesh.unit()));
        parts(&mut mesh).names[1].material.nu = Some(0.7);
        assert_eq!(code(&bytes(&mesh, true)), "columns-corrupt");
    }
}

#[test]
fn columns_that_spilled_are_read_as_a_column_file() {
    // rows of many rays, and a band of more rays than a piece has
    for (axis, dims, rows) in [(0, [12, 5, 7], 2), (1, [5, 12, 7], 1), (2, [5, 7, 12], 3), (2, [256, 264, 9], 264)] {
        let mesh = pattern(axis, dims, 3);
        let rays = *mesh.columns().rays();
        let head = head(&mesh, false);
        let store = Arc::new(MemoryStore::default());
        let mut builder = ColumnsBuilder::new(rays, 0, Some((head.encode().unwrap(), store.clone())));
        bands(&mesh, rows * rays.counts[0] as usize).into_iter().for_each(|band| builder.push(vec![band]).unwrap());
        let columns = builder.finish().unwrap();
        assert!(columns.is_spilled());
        let file = store.bytes().clone();
        let read = read(&mut &file[..], u64::MAX).unwrap();
        let counts = |columns: &Columns| [columns.n_runs(), columns.n_crossings(), columns.odd_rays()];
        assert_eq!((counts(read.columns()), counts(&columns)), (counts(mesh.columns()), counts(mesh.columns())));
        assert_eq!((read.columns(), &columns), (mesh.columns(), mesh.columns()));
        assert_eq!((read.lines(), read.names(), read.unit()), (mesh.lines(), mesh.names(), mesh.unit()));
    }
}
