use std::io::Read;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use flate2::read::ZlibDecoder;
use sha2::{Digest, Sha256};

use super::*;
use hexcast_core::base::checksum::hex;
use hexcast_derived::testing::{pattern, pattern_flags};

mod large;

fn small(options: Options) -> Options {
    Options { slab_bytes: 50, ..options }
}

fn bytes(mesh: &Mesh, format: Format, options: &Options) -> (Vec<u8>, Written) {
    let mut out = Vec::new();
    let written = write(mesh, format, options, &mut out, &Control::default()).unwrap();
    assert_eq!(written.n_bytes, out.len() as u64);
    if let Some(size) = exact_size(mesh, format, options) {
        assert_eq!(size, out.len() as u64, "{format:?} {options:?}");
    }
    (out, written)
}

fn zlib() -> Options {
    Options { compress: Compress::Zlib(6), ..Options::default() }
}

fn packed() -> Options {
    Options { bits: true, ..Options::default() }
}

/// The flags as bits, cell by cell.
fn bits_of(flags: &[u8], nx: usize) -> Vec<u8> {
    let mut out = Vec::new();
    for row in flags.chunks(nx) {
        for eight in row.chunks(8) {
            out.push(eight.iter().enumerate().map(|(bit, &flag)| u8::from(flag != 0) << bit).sum());
        }
    }
    out
}

#[test]
fn raw_is_the_flags_and_their_hash() {
    for axis in 0..3 {
        let mesh = pattern(axis, [9, 5, 7], 3);
        let (file, plain) = bytes(&mesh, Format::Raw, &small(Options::default()));
        assert_eq!((file, plain.sha256), (pattern_flags([9, 5, 7], 3), None));
        let (file, written) = bytes(&mesh, Format::Raw, &small(Options { sha256: true, ..Options::default() }));
        assert_eq!(file, pattern_flags([9, 5, 7], 3));
        assert_eq!(written.sha256, Some(mesh.flags_sha256(&Control::default()).unwrap()));
    }
}

#[test]
fn npy_is_a_header_and_raw() {
    let mesh = pattern(1, [9, 5, 7], 3);
    let (file, _) = bytes(&mesh, Format::Npy, &small(Options::default()));
    assert_eq!(file[..8], *b"\x93NUMPY\x01\x00");
    assert_eq!(file[128..], pattern_flags([9, 5, 7], 3));
}

#[test]
fn bits_pack_rows_in_raw_and_npy() {
    for dims in [[9, 5, 7], [16, 3, 4], [7, 11, 2]] {
        let mesh = pattern(2, dims, 1);
        let expected = bits_of(&pattern_flags(dims, 1), dims[0] as usize);
        let (raw, written) = bytes(&mesh, Format::Raw, &small(Options { sha256: true, ..packed() }));
        assert_eq!(raw, expected, "{dims:?}");
        assert_eq!(written.sha256, Some(hex(&Sha256::digest(&raw))));
        let (npy, _) = bytes(&mesh, Format::Npy, &small(packed()));
        assert_eq!(npy[128..], expected, "{dims:?}");
    }
}

#[test]
fn vti_appends_the_flags_after_their_length() {
    let dims = [9, 5, 7];
    let (file, _) = bytes(&pattern(0, dims, 3), Format::Vti, &small(Options::default()));
    let text = String::from_utf8_lossy(&file).into_owned();
    for part in [
        "header_type=\"UInt64\">",
        "WholeExtent=\"0 9 0 5 0 7\" Origin=\"-1.5 0.1 1e-7\" Spacing=\"0.5 0.25 0.3333333333333333\"",
        "Name=\"unit\" NumberOfTuples=\"1\" format=\"ascii\">109 109 0<",
        "Name=\"flag_values\" NumberOfTuples=\"2\" format=\"ascii\">1 7<",
        "<CellData Scalars=\"flag\">",
    ] {
        assert!(text.contains(part), "{part} is not in {text}");
    }
    let data = file.windows(4).position(|four| four == b"   _").unwrap() + 4;
    assert_eq!(file[data..data + 8], 315u64.to_le_bytes());
    assert_eq!(file[data + 8..data + 8 + 315], pattern_flags(dims, 3));
    assert_eq!(file[data + 8 + 315..], *b"\n  </AppendedData>\n</VTKFile>\n");
}

#[test]
fn vti_blocks_follow_their_table_whatever_is_cached() {
    // 2.6 blocks of 1 MiB
    let dims = [160, 130, 131];
    let mesh = pattern(2, dims, 3);
    let options = Options { slab_bytes: 300_000, ..zlib() };
    let (file, _) = bytes(&mesh, Format::Vti, &options);
    let data = file.windows(4).position(|four| four == b"   _").unwrap() + 4;
    let number = |index: usize| {
        let at = data + 8 * index;
        u64::from_le_bytes(file[at..at + 8].try_into().unwrap())
    };
    assert_eq!([number(0), number(1), number(2)], [3, 1 << 20, mesh.n_cells() % (1 << 20)]);
    let mut at = data + 8 * 6;
    let mut flags = Vec::new();
    for size in [number(3), number(4), number(5)] {
        let end = at + size as usize;
        ZlibDecoder::new(&file[at..end]).read_to_end(&mut flags).unwrap();
        at = end;
    }
    assert!(flags == pattern_flags(dims, 3), "the blocks do not hold the flags");
    assert_eq!(file[at..], *b"\n  </AppendedData>\n</VTKFile>\n");
    let first = number(3) as usize;
    for block_cache_bytes in [0, first - 1, first, first + 1] {
        let (again, _) = bytes(&mesh, Format::Vti, &Options { block_cache_bytes, ..options });
        assert!(again == file, "{block_cache_bytes} bytes cached");
    }
}

#[test]
fn vti_of_whole_blocks_has_no_partial_one() {
    let mesh = pattern(0, [256, 64, 128], 2);
    let (file, _) = bytes(&mesh, Format::Vti, &zlib());
    let data = file.windows(4).position(|four| four == b"   _").unwrap() + 4;
    let expected: Vec<u8> = [2u64, 1 << 20, 0].iter().flat_map(|number| number.to_le_bytes()).collect();
    assert_eq!(file[data..data + 24], expected);
}

#[test]
fn the_sidecar_is_json_with_numbers_that_round_trip() {
    let mesh = pattern(0, [9, 5, 7], 3);
    let (_, written) = bytes(&mesh, Format::Raw, &Options { sha256: true, ..Options::default() });
    let text = sidecar_json(&mesh, &Options::default(), &written);
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(json["dims"], serde_json::json!([9, 5, 7]));
    assert_eq!(json["origin"][2].as_f64(), Some(1e-7));
    assert_eq!(json["spacing"][2].as_f64(), Some(1.0 / 3.0));
    assert_eq!(json["unit"], "mm");
    assert_eq!(json["dtype"], "uint8");
    assert_eq!(json["sha256"], written.sha256.unwrap());
    assert_eq!(json["flags_hash"], hexcast_core::cells::fingerprint::flags_hash(mesh.columns()).unwrap());
    let z: Vec<f64> = json["lines"]["z"].as_array().unwrap().iter().map(|line| line.as_f64().unwrap()).collect();
    assert_eq!(z, (0..8).map(|index| 1e-7 + f64::from(index) * (1.0 / 3.0)).collect::<Vec<_>>());
    let cells = pattern_flags([9, 5, 7], 3).iter().filter(|&&flag| flag == 1).count();
    assert_eq!(json["flags"][0], serde_json::json!({"flag": 1, "name": "copper", "cells": cells}));
    assert_eq!(json["flags"][3]["name"], "Gehäuse <A&B> \"1\"");
    assert_eq!(text.lines().count(), 16);
    let json: serde_json::Value = serde_json::from_str(&sidecar_json(&mesh, &packed(), &bytes_written())).unwrap();
    assert_eq!(json["row_bytes"], 2);
}

fn bytes_written() -> Written {
    Written { n_bytes: 70, sha256: None }
}

#[test]
fn names_have_the_format() {
    for format in Format::ALL {
        assert_eq!(Format::of_name(&format!("a.b/c.{}", format.extension())), Ok(format));
    }
    assert_eq!(Format::of_name("OUT.VTI"), Ok(Format::Vti));
    assert_eq!(Format::of_name("a/OUT.Zarr.ZIP"), Ok(Format::ZarrZip));
    assert_eq!(
        Format::ALL.iter().filter(|format| !Format::FILES.contains(format)).collect::<Vec<_>>(),
        [&Format::Zarr]
    );
    let mesh = pattern(0, [4, 3, 2], 1);
    let error = write(&mesh, Format::Zarr, &Options::default(), &mut Vec::new(), &Control::default()).unwrap_err();
    assert_eq!((error.code(), error.to_string().contains("folder of many files")), ("job-conflict", true));
    for name in ["out", "out.", "out.stl", "out.zip", "", ".vti", "folder/.vti", ".zarr.zip", "folder/.zarr.zip"] {
        assert_eq!(Format::of_name(name).unwrap_err().code(), "output-name", "{name}");
    }
}

#[test]
fn contradictions_are_refused_before_the_first_byte() {
    let cases = [
        (Format::Raw, zlib(), "job-conflict"),
        (Format::Npy, zlib(), "job-conflict"),
        (Format::Vti, packed(), "job-conflict"),
        (Format::Columns, packed(), "job-conflict"),
        (Format::Raw, packed(), "job-conflict"),
        (Format::Npy, packed(), "job-conflict"),
        (Format::Vti, Options { compress: Compress::Zlib(0), ..zlib() }, "job-value"),
        (Format::Columns, Options { compress: Compress::Zlib(10), ..zlib() }, "job-value"),
    ];
    let mesh = pattern(0, [9, 5, 7], 3);
    for (format, options, code) in cases {
        let mut out = Vec::new();
        let error = write(&mesh, format, &options, &mut out, &Control::default()).unwrap_err();
        assert_eq!((error.code(), out.len()), (code, 0), "{format:?} {options:?}");
    }
}

/// An output that fails, or cancels, after some bytes.
struct Stops<'a> {
    left: usize,
    cancel: Option<&'a Control>,
}

impl io::Write for Stops<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match (self.left.checked_sub(bytes.len()), self.cancel) {
            (Some(left), _) => self.left = left,
            (None, Some(control)) => control.cancel.cancel(),
            (None, None) => return Err(io::Error::other("disk full")),
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[test]
fn a_failing_output_and_cancel_end_the_writing() {
    // more than an archive holds back
    let mesh = pattern(0, [80, 80, 80], 1);
    for format in Format::FILES {
        let control = Control::default();
        let options = Options { slab_bytes: 4000, ..Options::default() };
        let error = write(&mesh, format, &options, &mut Stops { left: 900, cancel: None }, &control).unwrap_err();
        assert_eq!(error.to_string(), "writing the mesh: disk full", "{format:?}");
        if format != Format::Columns {
            let mut out = Stops { left: 5000, cancel: Some(&control) };
            assert_eq!(write(&mesh, format, &options, &mut out, &control), Err(Error::Cancelled), "{format:?}");
        }
    }
}

#[test]
fn files_do_not_depend_on_the_threads() {
    let options = |format, slab_bytes| match format {
        Format::Npz | Format::Vti | Format::Vtr | Format::Columns | Format::ZarrZip => Options { slab_bytes, ..zlib() },
        _ => Options { slab_bytes, ..Options::default() },
    };
    for axis in 0..3 {
        let mesh = pattern(axis, [190, 170, 160], 3);
        for (format, slab_bytes) in Format::FILES.iter().flat_map(|&format| [(format, 3_000_000), (format, 1 << 25)]) {
            let written_by = |threads| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| bytes(&mesh, format, &options(format, slab_bytes)))
            };
            let one = written_by(1);
            for threads in [1, 2, 7] {
                assert!(
                    written_by(threads) == one,
                    "{format:?} along {axis}, slabs of {slab_bytes}, {threads} threads"
                );
            }
        }
    }
}

#[test]
fn a_file_made_slab_by_slab_is_the_file() {
    let mesh = pattern(0, [9, 5, 7], 3);
    let mut made_of_slabs = 0;
    for format in Format::FILES {
        let options = Options::default();
        let mut written = Vec::new();
        write(&mesh, format, &options, &mut written, &Control::default()).unwrap();
        if let Some((mut made, tail)) = around(&mesh, format, &options).unwrap() {
            mesh.slabs(50).for_each(|cells| made.extend(mesh.box_flags(&cells).unwrap()));
            made.extend(tail);
            assert_eq!(made, written, "{format:?}");
            made_of_slabs += 1;
        }
    }
    assert_eq!(made_of_slabs, 4);
}

#[test]
fn files_that_are_written_with_rests_are_the_same() {
    let mesh = pattern(0, [300, 90, 80], 3);
    let options =
        [Options { compress: Compress::None, ..Options::default() }, zlib()].map(|of| of.with_slab_bytes(1000));
    for (format, options) in Format::FILES.into_iter().flat_map(|format| options.map(|options| (format, options))) {
        if check(format, &options).is_err() {
            continue;
        }
        let (n_rests, mut file) = (Arc::new(AtomicUsize::new(0)), Vec::new());
        let counted = n_rests.clone();
        let control = Control::default().pausing(move || {
            counted.fetch_add(1, Ordering::Relaxed);
            Box::pin(std::future::ready(()))
        });
        let written = at_once(Cells::flags(&mesh, &options).write(format, &mut file, &control)).unwrap();
        let (expected, _) = bytes(&mesh, format, &options);
        assert!(file == expected && written.n_bytes == expected.len() as u64, "{format:?}");
        let n_rests = n_rests.load(Ordering::Relaxed);
        let least = if format == Format::Columns {
            2
        } else if format == Format::ZarrZip {
            1
        } else {
            2000
        };
        assert!(n_rests >= least, "{format:?}: {n_rests} rests");
    }
}
