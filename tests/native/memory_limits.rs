//! A limit of memory is kept from the first byte: readers are counted by what they allocate, the command by what the system says it held.

use std::io::Write;
use std::process::{Command, Stdio};
use std::time::Duration;

use flate2::Compression;
use flate2::write::GzEncoder;
use hexcast::memory::Memory;
use hexcast::read::{Contents, Reader, read_bytes};

use super::cli::{Folder, SPOT};

/// Bytes that a reader may take besides what grows with its input: buffers, tables of decoders, sentences.
const FIXED: u64 = 700_000;

fn packed(bytes: &[u8]) -> Vec<u8> {
    let mut out = GzEncoder::new(Vec::new(), Compression::fast());
    out.write_all(bytes).expect("memory takes all");
    out.finish().expect("memory takes all")
}

/// A ZIP archive of one model.
fn three_mf(model: &[u8]) -> Vec<u8> {
    let mut archive = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    archive.start_file("3D/3dmodel.model", zip::write::SimpleFileOptions::default()).expect("a file");
    archive.write_all(model).expect("memory takes all");
    archive.finish().expect("an archive").into_inner()
}

fn glb(json: &str) -> Vec<u8> {
    let mut json = json.as_bytes().to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let head = [0x4654_6c67, 2, 20 + json.len() as u32, json.len() as u32, 0x4e4f_534a];
    [head.map(u32::to_le_bytes).as_flattened(), &json].concat()
}

/// A binary STL of facets without common corners.
fn stl(n_facets: u32) -> Vec<u8> {
    let mut bytes = vec![0; 80];
    bytes.extend(n_facets.to_le_bytes());
    for facet in 0..n_facets {
        let at = [facet % 100, facet / 100 % 100, facet / 10_000].map(|cell| cell as f32);
        let corners = [[0.0, 0.0, 0.0], [0.5, 0.0, 0.1], [0.0, 0.5, 0.2]];
        bytes.extend([0; 12]);
        for corner in corners {
            (0..3).for_each(|axis| bytes.extend((at[axis] + corner[axis]).to_le_bytes()));
        }
        bytes.extend([0; 2]);
    }
    bytes
}

const FACET: &str = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
const MODEL: &str = "<model xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\"><resources>";

/// Inputs that stand for much more than their bytes, or are read to lists that grow.
fn inputs(n: usize) -> Vec<(&'static str, Vec<u8>)> {
    let object = "<object id=\"1\"><mesh><vertices><vertex x=\"0\" y=\"0\" z=\"0\"/><vertex x=\"1\" y=\"0\" z=\"0\"/>\
                  <vertex x=\"0\" y=\"1\" z=\"0\"/></vertices><triangles>";
    let end = "</triangles></mesh></object></resources><build>";
    let built = |triangles: usize, items: usize, blanks: &str| {
        let triangles = "<triangle v1=\"0\" v2=\"1\" v3=\"2\"/>".repeat(triangles);
        let items = "<item objectid=\"1\"/>".repeat(items);
        three_mf(format!("{MODEL}{object}{triangles}{end}{blanks}{items}</build></model>").as_bytes())
    };
    let off = format!("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n{n} {}", "0 ".repeat(n));
    vec![
        ("binary STL", stl(n as u32 / 20)),
        ("ASCII STL", format!("solid s\n{}endsolid s\n", FACET.repeat(n / 20)).into_bytes()),
        ("ASCII STL of solids", format!("solid name\n{FACET}endsolid\n").repeat(n / 40).into_bytes()),
        ("newlines, packed", packed(format!("solid s\n{}{FACET}endsolid\n", "\n".repeat(4 * n)).as_bytes())),
        ("binary STL, packed", packed(&stl(n as u32 / 20))),
        ("OBJ of corners, packed", packed(format!("{}f 1 2 3\n", "v 0 0 1\n".repeat(n)).as_bytes())),
        ("OBJ of a long polygon", format!("v 0 0 0\nf {}\n", "1 ".repeat(n)).into_bytes()),
        ("OBJ of groups", format!("v 0 0 0\n{}", (0..n / 8).map(|g| format!("g {g}\nf 1 1 1\n")).collect::<String>()).into_bytes()),
        ("OBJ of joined lines", format!("v 0 0 0\nf 1 1 1 \\\n{}\n", "1 ".repeat(n)).into_bytes()),
        ("OFF of a long polygon", off.into_bytes()),
        ("PLY of a long list", [
            "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n\
                     element face 1\nproperty list uint uchar vertex_indices\nend_header\n".as_bytes().to_vec(),
            vec![0; 12], (n as u32).to_le_bytes().to_vec(), vec![0; n]].concat()),
        ("PLY of properties", format!("ply\nformat ascii 1.0\nelement vertex 1\n{}end_header\n", "property int i\n".repeat(n / 16)).into_bytes()),
        ("3MF of triangles", built(n / 20, 1, "")),
        ("3MF of items", built(1, n / 20, "")),
        ("3MF of blanks", built(1, 1, &" ".repeat(4 * n))),
        ("3MF of a long tag", built(1, 1, &format!("<item objectid=\"1\"{}/>", " ".repeat(4 * n)))),
        ("3MF of objects", three_mf(format!("{MODEL}{}", (0..n / 20).map(|id| format!("<object id=\"{id}\"/>")).collect::<String>()).as_bytes())),
        ("3MF of components", three_mf(format!("{MODEL}<object id=\"1\"><components>{}", "<component objectid=\"2\"/>".repeat(n / 20)).as_bytes())),
        ("GLB of nodes", glb(&format!("{{\"nodes\":[{}{{}}]}}", "{},".repeat(n / 4)))),
        ("GLB of children", glb(&format!("{{\"nodes\":[{{\"children\":[{}0]}}]}}", "0,".repeat(n)))),
        ("GLB of empty names", glb(&format!("{{\"extensionsUsed\":[{}\"\"]}}", "\"\",".repeat(n / 3)))),
    ]
}

/// Reads a file in chunks within a limit.
fn read_within(bytes: &[u8], memory: &Memory) -> hexcast::Result<Contents> {
    let mut reader = Reader::within(bytes.len() as u64, memory);
    bytes.chunks(1 << 16).try_for_each(|chunk| reader.push(chunk))?;
    reader.finish()
}

#[test]
fn readers_allocate_no_more_than_they_are_allowed() {
    let mut n_refused = 0;
    for (what, bytes) in inputs(1_000_000) {
        for max in [1_000_000, 4_000_000, 16_000_000, 64_000_000, 1_000_000_000] {
            let mut found = None;
            let measured = allocation_counter::measure(|| found = Some(read_within(&bytes, &Memory::limited(max, 0))));
            let found = found.expect("it was read");
            let said = found.as_ref().err().map(ToString::to_string);
            assert!(measured.bytes_max <= max + FIXED, "{what}: {} bytes within {max}: {said:?}", measured.bytes_max);
            match found {
                Err(error) if error.code() == "memory" => {
                    n_refused += 1;
                    assert!(max < 1_000_000_000 && !error.hint().is_empty(), "{what}: {error}");
                    assert!(error.to_string().contains("are allowed"), "{what}: {error}");
                }
                // what is read is the same as without a limit
                found => assert!(found == read_bytes(&bytes), "{what} within {max}"),
            }
        }
    }
    assert!(n_refused > 40, "{n_refused}");
}

#[test]
fn room_of_files_that_were_refused_or_dropped_comes_back() {
    let memory = Memory::limited(100_000_000, 0);
    for (what, bytes) in inputs(200_000) {
        let held_before = held(&memory);
        let read = read_within(&bytes, &memory);
        let (n_facets, after) = (read.map_or(0, |contents| contents.n_facets), held(&memory));
        // facets stay, and the names of their solids; lists that grew have up to twice the room
        assert!(
            after - held_before <= 2 * 36 * n_facets + 400 * n_facets + 4096,
            "{what}: {n_facets} facets, {}",
            after - held_before
        );
    }
}

/// Bytes that are held of 100 MB, found by asking.
fn held(memory: &Memory) -> u64 {
    let (mut fits, mut fails) = (0, 100_000_001);
    while fits + 1 < fails {
        let middle = (fits + fails) / 2;
        if memory.check(middle, "bytes").is_ok() { fits = middle } else { fails = middle }
    }
    100_000_000 - fits
}

/// What the command says, its exit code, and the most bytes that it held, looked at every other millisecond.
pub(crate) fn watched(arguments: &[&str]) -> (i32, String, u64) {
    watched_on(2, arguments)
}

/// The same on so many threads: what is enough memory depends on them, as each keeps some of what it has freed.
fn watched_on(n_threads: u32, arguments: &[&str]) -> (i32, String, u64) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hexcast"));
    let command = command.args(arguments).env("RAYON_NUM_THREADS", n_threads.to_string());
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("it runs");
    let status = format!("/proc/{}/status", child.id());
    let mut peak = 0;
    let code = loop {
        let text = std::fs::read_to_string(&status).unwrap_or_default();
        let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:")?.trim().strip_suffix(" kB"));
        peak =
            line.and_then(|kilobytes| kilobytes.trim().parse::<u64>().ok()).map_or(peak, |kilobytes| kilobytes << 10);
        if let Some(status) = child.try_wait().expect("it is ours") {
            break status.code().unwrap_or(-1);
        }
        std::thread::sleep(Duration::from_millis(2));
    };
    let mut said = String::new();
    std::io::Read::read_to_string(&mut child.stderr.take().expect("it is piped"), &mut said).expect("text");
    (code, said, peak)
}

#[test]
fn the_command_keeps_its_limit_whatever_it_reads() {
    let folder = Folder::new();
    for (number, (what, bytes)) in inputs(4_000_000).into_iter().enumerate() {
        let name = folder.path(&format!("{number}"));
        std::fs::write(&name, bytes).expect("written");
        let (code, said, peak) = watched(&[
            "mesh",
            &name,
            "--cells",
            "8",
            "--backend",
            "cpu",
            "--open",
            "parity",
            "--max-memory",
            "100MB",
            "-q",
        ]);
        assert!(peak <= 100_000_000, "{said}\n{what}: {peak} bytes, exit code {code}");
        assert!([0, 3, 4, 5].contains(&code), "{what}: {code}: {said}");
        std::fs::remove_file(&name).expect("removed");
    }
}

#[test]
fn facets_without_common_corners_are_meshed_or_refused_within_the_limit() {
    let folder = Folder::new();
    let name = folder.path("soup.stl");
    std::fs::write(&name, stl(400_000)).expect("written");
    let mut codes = Vec::new();
    for max in ["50MB", "60MB", "80MB", "85MB", "100MB", "120MB", "200MB", "400MB"] {
        // to decide cells of so many open edges takes minutes where it is allowed
        let ways: &[&str] = if max == "50MB" { &["parity", "winding", "vote"] } else { &["parity"] };
        for open in ways {
            let (code, said, peak) = watched(&[
                "mesh",
                &name,
                "--cells",
                "4",
                "--backend",
                "cpu",
                "--open",
                open,
                "--max-memory",
                max,
                "-q",
            ]);
            let limit: u64 = max.trim_end_matches("MB").parse::<u64>().expect("a number") * 1_000_000;
            assert!(peak <= limit, "{said}\n--open {open} within {max}: {peak} bytes, exit code {code}");
            assert!(code == 0 || code == 5 && said.contains("are allowed"), "{max}: {code}: {said}");
            codes.push(code);
        }
    }
    assert!(codes.contains(&0) && codes.contains(&5), "{codes:?}");
}

#[test]
fn a_count_that_does_not_fit_is_refused_before_the_facets_are_read() {
    let folder = Folder::new();
    let name = folder.path("large.stl");
    let mut file = std::fs::File::create(&name).expect("made");
    file.write_all(&[[0; 80].as_slice(), &20_000_000u32.to_le_bytes()].concat()).expect("written");
    // a hole as long as the facets
    file.set_len(84 + 50 * 20_000_000).expect("made longer");
    let (code, said, peak) = watched(&["info", &name, "--max-memory", "280MiB"]);
    assert!(
        code == 5 && said.contains("announces 20000000 facets") && said.contains("take 720.00 MB"),
        "{code}: {said}"
    );
    assert!(peak < 60_000_000, "{peak}");
}

#[test]
fn info_examines_edges_within_its_limit() {
    let folder = Folder::new();
    let name = folder.path("soup.stl");
    std::fs::write(&name, stl(400_000)).expect("written");
    let mut codes = Vec::new();
    for max in [20, 40, 60, 80, 100, 120, 200] {
        let (code, said, peak) = watched(&["info", &name, "--max-memory", &format!("{max}MB")]);
        assert!(peak <= max * 1_000_000, "{said}\nwithin {max} MB: {peak} bytes, exit code {code}");
        assert!(code == 0 || code == 5 && said.contains("are allowed"), "{max} MB: {code}: {said}");
        codes.push(code);
    }
    assert!(codes.is_sorted_by(|one, next| one >= next) && codes[0] == 5 && codes[6] == 0, "{codes:?}");
}

#[test]
fn info_keeps_the_facets_of_one_file_at_a_time() {
    let folder = Folder::new();
    let names: Vec<String> = (0..6).map(|number| folder.path(&format!("{number}.stl"))).collect();
    names.iter().for_each(|name| std::fs::write(name, stl(400_000)).expect("written"));
    let files: Vec<&str> = names.iter().map(String::as_str).collect();
    let (code, said, peak) = watched(&[&["info", "--max-memory", "120MB"], &files[..]].concat());
    assert!(code == 0 && peak <= 120_000_000, "{code}, {peak} bytes: {said}");
}

#[test]
fn a_picture_for_which_there_is_no_room_is_refused_before_the_mesh_is_made() {
    let folder = Folder::new();
    let [mesh, slice, view] = ["mesh.hxc", "slice.png", "view.png"].map(|name| folder.path(name));
    let [of_slice, of_view] = [format!("{slice}:axis=z,size=3000"), format!("{view}:size=3000")];
    for (n_threads, picture) in [(2, ["--slice", &of_slice]), (2, ["--view", &of_view]), (16, ["--view", &of_view])] {
        let mut codes = Vec::new();
        for max in [60, 80, 90, 100, 110, 120, 140, 200] {
            let max_memory = format!("{max}MB");
            let limit = ["--max-memory", &max_memory, "-q", "--backend", "cpu", "-o", &mesh];
            let arguments = [&["mesh", SPOT, "--cells", "400"], &limit[..], &picture].concat();
            let (code, said, peak) = watched_on(n_threads, &arguments);
            assert!(
                peak <= max * 1_000_000,
                "{said}\n{picture:?} on {n_threads} threads within {max} MB: {peak} bytes, exit code {code}"
            );
            assert!(code == 0 || code == 5 && said.contains("pixels"), "{picture:?} within {max} MB: {code}: {said}");
            let is_made = std::fs::remove_file(&mesh).is_ok();
            // how many rectangles a view has is known once the mesh is made
            let is_of_surface = picture[0] == "--view" && max > 90;
            assert!(is_made == (code == 0) || is_of_surface, "{picture:?} within {max} MB: {said}");
            codes.push(code);
        }
        assert!(codes.is_sorted_by(|one, next| one >= next) && codes[0] == 5 && codes[7] == 0, "{codes:?}");
    }
}
