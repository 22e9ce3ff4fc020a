//! Column files from outside, by the command line: memory stays within the limit, whatever they hold.

use std::path::Path;
use std::process::{Command, Output};

use flate2::Crc;
use flate2::write::ZlibEncoder;
use std::io::Write;

/// Rays of a piece: the most that one may have.
const RAYS: u32 = 1 << 16;
/// Pieces: 197 million runs, which take 790 MB in memory.
const PIECES: u32 = 750;

fn with_crc(mut bytes: Vec<u8>) -> Vec<u8> {
    let mut crc = Crc::new();
    crc.update(&bytes);
    bytes.extend(crc.sum().to_le_bytes());
    bytes
}

fn numbers(numbers: &[u32]) -> Vec<u8> {
    numbers.iter().flat_map(|number| number.to_le_bytes()).collect()
}

/// A file whose rays along x, 8 cells each, all have the same four runs; zlib makes a few bytes of a piece.
fn crafted() -> Vec<u8> {
    let without_identity = vec![0];
    let mut body = [without_identity, numbers(&[8, 256, 256 * PIECES]), vec![0, 1, 0, 0]].concat();
    [0.0, 0.0, 0.0, 1.0, 1.0, 1.0f64].iter().for_each(|number| body.extend(number.to_le_bytes()));
    body.extend([0; 5]);
    let start = numbers(&[2, body.len() as u32]);
    let mut file = with_crc([b"\x89HXC\r\n\x1a\n".to_vec(), start, body].concat());
    let content =
        [vec![4; RAYS as usize], vec![2; 4], vec![0; 4 * RAYS as usize - 4], [1, 2].repeat(2 * RAYS as usize)];
    let content = content.concat();
    let mut zlib = ZlibEncoder::new(Vec::new(), flate2::Compression::best());
    zlib.write_all(&content).unwrap();
    let stored = zlib.finish().unwrap();
    let crc = with_crc(stored.clone()).split_off(stored.len());
    let sizes = numbers(&[RAYS, 4 * RAYS, content.len() as u32, stored.len() as u32]);
    let piece = [with_crc([&b"PIEC"[..], &sizes, &crc, &[0; 16]].concat()), stored].concat();
    let mut end = [&b"ENDS"[..], &u64::from(PIECES).to_le_bytes()].concat();
    for index in 0..PIECES {
        end.extend((file.len() as u64).to_le_bytes());
        end.extend(u64::from(index * RAYS).to_le_bytes());
        file.extend(&piece);
    }
    let n_rays = u64::from(PIECES) * u64::from(RAYS);
    end.extend((4 * n_rays).to_le_bytes());
    end.extend([0; 16]);
    end.extend(numbers(&[2]));
    for (flag, cells) in [(1u8, 2 * n_rays), (2, 5 * n_rays)] {
        end.push(flag);
        end.extend(cells.to_le_bytes());
    }
    let place = (file.len() as u64).to_le_bytes();
    [file, with_crc(end), place.to_vec(), b"HXC END\n".to_vec()].concat()
}

/// Runs hexcast where no more than so many kilobytes can be addressed, on two threads: the allocator addresses as much for each.
fn hexcast_within(kilobytes: u32, arguments: &[&str]) -> Output {
    let script = format!("ulimit -v {kilobytes} && exec \"$0\" \"$@\"");
    let mut command = Command::new("bash");
    command.args(["-c", &script, env!("CARGO_BIN_EXE_hexcast")]).args(arguments);
    command.env("RAYON_NUM_THREADS", "2").output().expect("bash starts")
}

#[test]
#[cfg(target_os = "linux")]
fn a_small_file_of_many_runs_is_opened_and_converted_in_little_memory() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).to_str().expect("UTF-8").to_string();
    let (file, again) = (path("crafted.hxc"), path("again.hxc"));
    let bytes = crafted();
    assert!(bytes.len() < 1_000_000, "{} bytes", bytes.len());
    std::fs::write(&file, bytes).expect("a file");

    let info = hexcast_within(500_000, &["info", "--json", &file]);
    let error = String::from_utf8_lossy(&info.stderr);
    assert!(info.status.success(), "{error}");
    let report: serde_json::Value = serde_json::from_slice(&info.stdout).expect("JSON");
    let n_rays = u64::from(PIECES) * u64::from(RAYS);
    assert_eq!(report[0]["rays"], n_rays);
    assert_eq!(report[0]["runs"], 4 * n_rays);
    assert_eq!(report[0]["cells"], 8 * n_rays);
    assert_eq!(report[0]["flags"][0]["cells"], 2 * n_rays);
    assert_eq!(report[0]["flags"][1]["cells"], 5 * n_rays);

    let limit = ["--max-memory", "100MB", "--compress=1", "--quiet"];
    let convert = hexcast_within(500_000, &[&["convert", &file, &again], &limit[..]].concat());
    let error = String::from_utf8_lossy(&convert.stderr);
    assert!(convert.status.success(), "{error}");
    assert!(Path::new(&again).metadata().expect("a file").len() > 100_000);
}

#[test]
fn info_says_of_a_column_file_what_the_report_said() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("a.hxc").to_str().expect("UTF-8").to_string();
    let spot = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/fixtures/spot.stl");
    let hexcast = |arguments: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_hexcast")).args(arguments).output().expect("hexcast starts");
        assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).expect("UTF-8")
    };
    let cow = format!("{spot}:name=cow,flag=7");
    let mesh = ["mesh", &cow, "--cells", "40", "--unit", "mm", "--backend", "cpu", "--json", "-o", &file];
    let report: serde_json::Value = serde_json::from_str(&hexcast(&mesh)).expect("JSON");
    let list: serde_json::Value = serde_json::from_str(&hexcast(&["info", "--json", &file, spot])).expect("JSON");
    for key in ["unit", "dims", "origin", "spacing", "ray_axis", "rays", "crossings", "runs", "odd_rays", "cells"] {
        assert_eq!(list[0][key], report[key], "{key}");
    }
    for key in ["flag", "name", "cells", "volume"] {
        assert_eq!(list[0]["flags"][0][key], report["flags"][0][key], "{key}");
    }
    assert_eq!(list[1]["watertight"], true);
    let words = hexcast(&["info", &file]);
    assert!(words.contains("column file") && words.contains("7 \"cow\""), "{words}");
}
