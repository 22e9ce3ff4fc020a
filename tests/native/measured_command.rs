//! Links and fractions as a user of the command line meets them: files, reports, surfaces that are not closed, refusals.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use super::cli::{Folder, SPOT, done, hexcast, json as report_of};

/// A record of `.links`.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Record {
    cell: [u32; 3],
    q: f32,
    facet: i32,
    geometry: i16,
    direction: u8,
    flag: u8,
}

/// Reads `.links` as the documentation has it: directions and records.
fn records(bytes: &[u8]) -> (Vec<[i8; 3]>, [u32; 3], Vec<Record>) {
    let u32_at = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    assert_eq!((&bytes[..8], u32_at(8)), (&b"HEXLINKS"[..], 1));
    let (n_directions, n) = (u32_at(12) as usize, u64::from_le_bytes(bytes[32..40].try_into().unwrap()) as usize);
    let directions = bytes[40..40 + 3 * n_directions].chunks_exact(3).map(|of| [0, 1, 2].map(|axis| of[axis] as i8));
    let start = (40 + 3 * n_directions).next_multiple_of(8);
    assert_eq!(bytes.len(), start + 24 * n);
    let record = |at: usize| Record {
        cell: [0, 4, 8].map(|by| u32_at(at + by)),
        q: f32::from_bits(u32_at(at + 12)),
        facet: u32_at(at + 16) as i32,
        geometry: u32_at(at + 20) as i16,
        direction: bytes[at + 22],
        flag: bytes[at + 23],
    };
    (directions.collect(), [16, 20, 24].map(u32_at), (0..n).map(|index| record(start + 24 * index)).collect())
}

fn refused(arguments: &[&str]) -> String {
    let output = hexcast(arguments);
    assert!(!output.status.success(), "{arguments:?} succeeds");
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Meshes with links, and holds these to the flags: a link from 0 to another flag wherever neighbours have them, and no other but through walls.
fn assert_links_fit_flags(what: &str, arguments: &[&str]) -> Value {
    let folder = Folder::new();
    let [raw, links] = ["mesh.raw", "mesh.links"].map(|name| folder.path(name));
    let outputs = ["-o", &raw, "--links", &links, "--json", "--backend", "cpu"];
    let report = report_of(&[&["mesh"], arguments, &outputs].concat());
    let (directions, dims, records) = records(&folder.bytes("mesh.links"));
    assert_eq!(json!(dims), report["dims"]);
    let flags = folder.bytes("mesh.raw");
    let at = |[x, y, z]: [u32; 3]| flags[(x + dims[0] * (y + dims[1] * z)) as usize];
    let mut known: BTreeMap<([u32; 3], u8), Record> = BTreeMap::new();
    for record in &records {
        assert!(record.q > 0.0 && record.q <= 1.0 && at(record.cell) == 0, "{what}: {record:?}");
        assert!(known.insert((record.cell, record.direction), *record).is_none(), "{what}: twice: {record:?}");
    }
    let (mut n, mut n_cells) = (0, 0);
    for index in 0..dims.iter().product::<u32>() {
        let cell = [index % dims[0], index / dims[0] % dims[1], index / (dims[0] * dims[1])];
        n_cells += u64::from((0..directions.len() as u8).any(|direction| known.contains_key(&(cell, direction))));
        for (direction, step) in (0u8..).zip(&directions).skip(1) {
            let other = [0, 1, 2].map(|axis: usize| cell[axis].wrapping_add_signed(step[axis].into()));
            let is_in = (0..3).all(|axis| other[axis] < dims[axis]);
            if at(cell) == 0 && is_in && at(other) != 0 {
                let record =
                    known.get(&(cell, direction)).unwrap_or_else(|| panic!("{what}: none at {cell:?} {step:?}"));
                assert_eq!(record.flag, at(other), "{what}: {record:?}");
                n += 1;
            }
        }
    }
    let through = records.iter().filter(|record| record.flag == 0).count();
    let without = records.iter().filter(|record| record.facet < 0).count();
    assert_eq!(records.len(), n + through, "{what}");
    let counted = &report["links"];
    assert_eq!(counted["links"], json!(records.len()), "{what}");
    assert_eq!(counted["cells"], json!(n_cells), "{what}");
    assert_eq!((&counted["through_walls"], &counted["without_facet"]), (&json!(through), &json!(without)), "{what}");
    report
}

#[test]
fn links_fit_the_flags_of_all_kinds_of_geometries() {
    let closed = assert_links_fit_flags("closed", &[SPOT, "--cells", "40", "--padding-cells", "2"]);
    assert_eq!(closed["links"]["without_facet"], 0);
    assert_eq!(closed["links"]["stencil"], "D3Q19");
    let all = assert_links_fit_flags("D3Q27", &[SPOT, "--cells", "24", "--lattice", "D3Q27", "--rule", "nonzero"]);
    assert_eq!(all["links"]["without_facet"], 0);
    // without thickness: all links go through it
    let shell = format!("{SPOT}:fill=separating,shell=true");
    let along = assert_links_fit_flags("shell", &[&shell, "--cells", "24", "--padding-cells", "1"]);
    assert!(along["links"]["without_facet"].as_u64().unwrap() > 0, "{along}");
    let gaps = assert_links_fit_flags("gaps", &[SPOT, "--cells", "30", "--close-gaps", "4"]);
    assert!(gaps["links"]["without_facet"].as_u64().unwrap() > 0, "{gaps}");
    let folder = Folder::new();
    // five sides of a box
    let corner = |bits: usize| [0, 1, 2].map(|axis| if bits >> axis & 1 == 1 { "1" } else { "0" }).join(" ");
    let facets =
        [[0, 4, 6], [0, 6, 2], [1, 3, 7], [1, 7, 5], [0, 1, 5], [0, 5, 4], [2, 6, 7], [2, 7, 3], [4, 5, 7], [4, 7, 6]];
    let facet = |of: [usize; 3]| {
        format!("facet normal 0 0 0\nouter loop\nvertex {}\nendloop\nendfacet\n", of.map(corner).join("\nvertex "))
    };
    let open = folder.path("open.stl");
    std::fs::write(&open, format!("solid\n{}endsolid\n", facets.map(facet).concat())).unwrap();
    let found = assert_links_fit_flags("open", &[&open, "--cells", "12", "--padding-cells", "2"]);
    assert!(found["links"]["without_facet"].as_u64().unwrap() > 0, "{found}");
    let message = refused(&["mesh", &open, "--cells", "12", "--backend", "cpu", "--fractions", &folder.path("f.npz")]);
    assert!(message.contains("is not closed: it has no volume to measure fractions of"), "{message}");
}

#[test]
fn archives_hold_the_records_and_fractions_the_volume() {
    let folder = Folder::new();
    let [links, archive, fractions] = ["a.links", "a.npz", "f.npz"].map(|name| folder.path(name));
    let mesh = ["mesh", SPOT, "--cells", "30", "--backend", "cpu", "--json", "--compress=none"];
    report_of(&[&mesh[..7], &["--links", &links, "--stencil", "D3Q15"]].concat());
    let report =
        report_of(&[&mesh[..], &["--links", &archive, "--stencil", "D3Q15", "--fractions", &fractions]].concat());
    let (directions, _, records) = records(&folder.bytes("a.links"));
    assert_eq!(directions.len(), 15);
    let bytes = folder.bytes("a.npz");
    let column = |of: &dyn Fn(&Record) -> Vec<u8>| records.iter().flat_map(of).collect::<Vec<u8>>();
    let columns = [
        column(&|record| record.cell[2].to_le_bytes().to_vec()),
        column(&|record| record.q.to_le_bytes().to_vec()),
        column(&|record| record.facet.to_le_bytes().to_vec()),
        column(&|record| record.geometry.to_le_bytes().to_vec()),
        column(&|record| vec![record.direction]),
    ];
    for (index, column) in columns.iter().enumerate() {
        assert!(bytes.windows(column.len()).any(|window| window == column), "column {index}");
    }
    let volumes = &report["fractions"]["volumes"];
    let [outside, inside] = [0, 1].map(|index| volumes[index]["volume"].as_f64().unwrap());
    let of_mesh = report["flags"][0]["mesh_volume"].as_f64().unwrap();
    assert!((inside / of_mesh - 1.0).abs() < 2e-3, "{inside} of {of_mesh}");
    let size: f64 = report["spacing"].as_array().unwrap().iter().map(|size| size.as_f64().unwrap()).product();
    let all = size * report["cells"].as_f64().unwrap();
    assert!(((outside + inside) / all - 1.0).abs() < 1e-9, "{outside} and {inside} of {all}");
}

/// The bytes of an array in an archive that is not compressed.
fn array(archive: &[u8], name: &str) -> Vec<u8> {
    // name, header, data: the archive has the length of the data in the header's shape
    let at = archive.windows(name.len()).position(|window| window == name.as_bytes()).unwrap() + name.len();
    let magic = at + archive[at..].windows(6).position(|window| window == b"\x93NUMPY").unwrap();
    let n_header = usize::from(u16::from_le_bytes([archive[magic + 8], archive[magic + 9]]));
    let header = String::from_utf8_lossy(&archive[magic + 10..magic + 10 + n_header]).into_owned();
    let shape = header.split_once("'shape': (").unwrap().1.split_once(')').unwrap().0;
    let n: usize = shape.split(',').filter_map(|n| n.trim().parse::<usize>().ok()).product();
    let size: usize = header.split_once("'descr': '").unwrap().1[2..3].parse().unwrap();
    archive[magic + 10 + n_header..][..n * size].to_vec()
}

fn f32s(bytes: &[u8]) -> Vec<f32> {
    bytes.chunks_exact(4).map(|four| f32::from_le_bytes(four.try_into().unwrap())).collect()
}

/// A box from a corner to another as an ASCII solid.
fn solid_box(low: [f32; 3], high: [f32; 3]) -> String {
    let corner = |bits: usize| {
        [0, 1, 2].map(|axis| if bits >> axis & 1 == 1 { high[axis] } else { low[axis] }.to_string()).join(" ")
    };
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let facets = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]);
    let text = facets.map(|of| {
        format!("facet normal 0 0 0\nouter loop\nvertex {}\nendloop\nendfacet\n", of.map(corner).join("\nvertex "))
    });
    format!("solid\n{}endsolid\n", text.collect::<String>())
}

#[test]
fn dense_fractions_are_flags_and_entries_together() {
    assert_dense(&[SPOT, "--cells", "25"]);
    // many planes without a cut cell, below, between and above those with some
    let folder = Folder::new();
    let boxes = [[12.4f32, 17.0], [45.3, 50.8]].map(|[from, to]| solid_box([0.0, 0.0, from], [20.0, 100.0, to]));
    let file = folder.path("boxes.stl");
    std::fs::write(&file, boxes.concat()).unwrap();
    assert_dense(&[&file, "--domain", "0", "0", "0", "20", "100", "80", "--dims", "20,100,80"]);
}

fn assert_dense(scene: &[&str]) {
    let folder = Folder::new();
    let path = |name: &str| folder.path(name);
    let mesh = [&["mesh"], scene, &["--backend", "cpu", "--json", "--compress=none"]].concat();
    let more = ["--fraction-faces", "--fraction-surfaces"];
    let report = report_of(&[&mesh[..], &["-o", &path("m.raw"), "--fractions", &path("f.npz")], &more[..]].concat());
    let flags = folder.bytes("m.raw");
    let archive = folder.bytes("f.npz");
    let cells: Vec<u64> =
        array(&archive, "cell.npy").chunks_exact(8).map(|of| u64::from_le_bytes(of.try_into().unwrap())).collect();
    let (of_flags, fractions) = (array(&archive, "flag.npy"), f32s(&array(&archive, "fraction.npy")));
    let mut expected: Vec<f32> = flags.iter().map(|&flag| f32::from(u8::from(flag != 0))).collect();
    for ((cell, flag), fraction) in cells.iter().zip(&of_flags).zip(&fractions) {
        if *flag != 0 {
            expected[*cell as usize] = *fraction;
        }
    }
    assert_eq!(f32s(&array(&archive, "faces.npy")).len(), 6 * cells.len());
    let n_surfaces = array(&archive, "surface_cell.npy").len() / 8;
    assert!(n_surfaces >= cells.len() / 2);
    assert_eq!(f32s(&array(&archive, "surface_normal.npy")).len(), 3 * n_surfaces);
    let area: f64 = f32s(&array(&archive, "surface_area.npy")).into_iter().map(f64::from).sum();
    let of_report = report["fractions"]["areas"][0].as_f64().unwrap();
    assert!((area / of_report - 1.0).abs() < 1e-6, "{area} of {of_report}");
    for name in ["d.npy", "d.vti", "d.vtr"] {
        report_of(&[&mesh[..], &["--fractions", &path(name)]].concat());
        let bytes = folder.bytes(name);
        let known: Vec<u8> = expected.iter().flat_map(|solid| solid.to_le_bytes()).collect();
        let tail = if name == "d.npy" { 0 } else { b"\n  </AppendedData>\n</VTKFile>\n".len() };
        assert!(bytes[..bytes.len() - tail].ends_with(&known), "{name}");
        let head = String::from_utf8_lossy(&bytes[..1000]).into_owned();
        let has = |text: &str| assert!(head.contains(text), "{name}: {head}");
        if name == "d.npy" { has("'descr': '<f4'") } else { has(r#"type="Float32" Name="solid""#) }
    }
    assert!(expected.iter().any(|solid| (0.1..0.9).contains(solid)));
    // compressed and in slabs of few bytes it is the same
    let plain = &mesh[..mesh.len() - 1];
    let run = |output: &str, more: &[&str]| report_of(&[plain, &["--fractions", output], more].concat());
    run(&path("z.vti"), &["--compress"]);
    assert!(folder.bytes("z.vti").len() < 4 * expected.len());
    // a store of one chunk holds them as they are, then its index
    let chunk = report["dims"].to_string().replace(['[', ']'], "");
    run(&path("z.zarr"), &["--compress=none", "--zarr-chunks", &chunk, "--zarr-shards", &chunk]);
    let shard = folder.bytes("z.zarr/solid/c/0/0/0");
    let known: Vec<u8> = expected.iter().flat_map(|solid| solid.to_le_bytes()).collect();
    assert_eq!(&shard[..known.len()], known);
    assert_eq!(shard.len(), known.len() + 16 + 4);
    // in many shards it holds the same
    run(&path("y.zarr"), &["--compress=none", "--zarr-chunks", "7,4,5", "--zarr-shards", "14,8,20"]);
    let store = std::sync::Arc::new(zarrs::filesystem::FilesystemStore::new(path("y.zarr")).unwrap());
    let solid = zarrs::array::Array::open(store, "/solid").unwrap();
    let read: Vec<f32> = solid.retrieve_array_subset(&solid.subset_all()).unwrap();
    assert_eq!(read, expected);
}

#[test]
fn files_and_reports_of_parts_are_those_of_the_whole_together() {
    let folder = Folder::new();
    let path = |name: &str| folder.path(name);
    let mesh = ["mesh", SPOT, "--cells", "20", "--backend", "cpu", "--fraction-surfaces", "--stencil", "D3Q27"];
    let outputs = |of: &str| {
        let files = [".links", ".npz", ".npy", ".json"].map(|ending| path(&format!("{of}{ending}")));
        let [links, fractions, staggered, report] = files;
        let names = ["--links", &links, "--fractions", &fractions, "--report", &report].map(String::from);
        (names, staggered)
    };
    let run = |of: &str, more: &[&str]| {
        let (names, _) = outputs(of);
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        done(&[&mesh[..], &["-q"], &names, more].concat());
    };
    run("whole", &[]);
    let (_, dims, expected) = records(&folder.bytes("whole.links"));
    let mut found: Vec<Record> = Vec::new();
    let mut reports = Vec::new();
    for part in 1..=4 {
        let (name, of) = (format!("part{part}"), format!("{part}/1x2x2"));
        run(&name, &["--part", &of]);
        let bytes = folder.bytes(&format!("{name}.links"));
        let version = bytes[8];
        let (origin, bytes) = match version {
            1 => ([0; 3], bytes),
            2 => {
                let at = |at: usize| i32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
                let origin = [40, 44, 48].map(at);
                assert_eq!(at(52), 0);
                // as version 1 has it
                let rest = [&bytes[..8], &[1], &bytes[9..40], &bytes[56..]].concat();
                (origin, rest)
            }
            _ => panic!("version {version}"),
        };
        assert_eq!((version == 1), part == 1, "the first begins where the box does");
        let (_, of_part, links) = records(&bytes);
        assert!(of_part[1] < dims[1] && of_part[2] < dims[2]);
        found.extend(links.into_iter().map(|link| {
            let cell = [0, 1, 2].map(|axis| link.cell[axis] + origin[axis] as u32);
            Record { cell, ..link }
        }));
        reports.push(path(&format!("{name}.json")));
    }
    let place = |link: &Record| (link.cell[2], link.cell[1], link.cell[0], link.direction);
    found.sort_by_key(place);
    assert!(found == expected && found.len() > 3000, "{} links, {} expected", found.len(), expected.len());
    let names: Vec<&str> = reports.iter().map(String::as_str).collect();
    let (merged, whole) = (report_of(&[&["merge"], &names[..]].concat()), folder.json("whole.json"));
    assert_eq!(merged["links"], whole["links"]);
    assert_eq!(merged["fractions"], whole["fractions"]);
}

#[test]
fn a_run_that_fails_leaves_no_file_of_what_was_measured() {
    let folder = Folder::new();
    let path = |name: &str| folder.path(name);
    std::fs::write(path("lines.json"), r#"{"x": [-1, 0, 0.5, 1], "y": [-1, 0, 1], "z": [-1, 1]}"#).unwrap();
    let lists = path("lines.json");
    let (links, fractions) = (path("a.links"), path("f.vti"));
    let mesh = ["mesh", SPOT, "--lines", &lists, "--backend", "cpu", "--links", &links, "--stencil", "D3Q7"];
    let message = refused(&[&mesh[..], &["--fractions", &fractions]].concat());
    assert!(message.contains("cells differ in size, and .vti holds equal ones only"), "{message}");
    assert_eq!(std::fs::read_dir(path("")).unwrap().count(), 1, "files are left");
}

#[test]
fn what_cannot_be_measured_is_refused_with_a_sentence() {
    let folder = Folder::new();
    let path = |name: &str| folder.path(name);
    let with = |more: &[&str]| refused(&[&["mesh", SPOT, "--cells", "9", "--backend", "cpu"], more].concat());
    for (more, sentence) in [
        (vec!["--links", &path("a.csv")], "no format of links has the extension \"csv\""),
        (vec!["--fractions", &path("a.raw")], "no format of fractions of cells has this ending"),
        (vec!["--links", &path("a.npz"), "--fractions", &path("a.npz")], "is written twice"),
        (vec!["--links", &path("a.npz"), "-o", &path("a.npz")], "is written twice"),
        (
            vec!["--fractions", &path("a.npy"), "--window", "0,0,0,2,2,2", "--halo", "1"],
            "only the cells within the halo are measured",
        ),
        (vec!["--staggered", &path("a.npz"), "--part", "1/2", "--halo", "1"], "staggered is given with a halo"),
        (vec!["--fractions", &path("a.npz"), "--fraction-rays", "3"], "1, 2, 4, 8 or 16"),
        (
            vec!["--fractions", &path("a.npz"), "--fraction-method", "exact", "--fraction-rays", "4"],
            "exact fractions are measured without rays",
        ),
        (
            vec!["--fractions", &path("a.npz"), "--fraction-method", "rays", "--fraction-edges"],
            "edges is given, which rays do not measure",
        ),
        (
            vec!["--fractions", &path("a.npz"), "--fraction-rays", "2", "--fraction-centroids"],
            "centroids is given, which rays do not measure",
        ),
        (vec!["--fractions", &path("a.npz"), "--close-gaps", "3"], "fractions are given with close_gaps"),
        (vec!["--fractions", &path("a.npz"), "--fill", "separating"], "has cells along its surface"),
    ] {
        let message = with(&more);
        assert!(message.contains(sentence), "{more:?}: {message}");
    }
    let lists = path("lines.json");
    std::fs::write(&lists, r#"{"x": [-1, 0, 0.5, 1], "y": [-1, 0, 1], "z": [-1, 1]}"#).unwrap();
    let message = refused(&["mesh", SPOT, "--lines", &lists, "--backend", "cpu", "--links", &path("a.npz")]);
    assert!(message.contains("links of D3Q19 need equal ones"), "{message}");
    assert!(std::fs::read_dir(path("")).unwrap().count() == 1, "files are left");
}

/// Where a disk is full, as a limit of the size of files is: what the command says, a line an error and a line a hint.
#[test]
#[cfg(unix)]
fn errors_of_a_full_disk_say_what_was_written_and_nothing_else_is_printed() {
    let folder = Folder::new();
    let cases = [
        ("--links", "a.npz", "writing the links: "),
        ("--links", "a.links", "writing the links: "),
        ("--links", "a.h5", "writing HDF5: "),
        ("--fractions", "b.npz", "writing the fractions: "),
        ("--staggered", "c.npz", "writing the staggered grid: "),
        ("-o", "d.npz", "writing the mesh: "),
        ("-o", "d.xdmf", "writing HDF5: "),
    ];
    for (option, name, said) in cases {
        let path = folder.path(name);
        // in blocks of 512 or 1024 bytes
        let script = "trap '' XFSZ; ulimit -f 16; exec \"$0\" \"$@\"";
        let mut command = std::process::Command::new("bash");
        command.args(["-c", script, env!("CARGO_BIN_EXE_hexcast"), "mesh", SPOT, "--cells", "120", "--backend", "cpu"]);
        let output = command.args(["-q", "--compress=none", option, &path]).output().expect("bash starts");
        let printed = String::from_utf8(output.stderr).expect("text");
        let errors: Vec<&str> = printed.lines().filter(|line| !line.starts_with("warning")).collect();
        assert_eq!(output.status.code(), Some(7), "{name}: {printed}");
        assert!(errors.len() == 1 && errors[0].starts_with("error[io]: ") && errors[0].contains(said), "{printed}");
        assert!(!std::path::Path::new(&path).exists(), "{name}");
    }
}
