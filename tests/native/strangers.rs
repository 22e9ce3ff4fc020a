//! What strangers and a failing system do to the command line: odd names and files, folders that vanish, disks that fill, runs
//! that are killed.

use std::path::Path;
use std::process::{Command, Output, Stdio};

use hexcast::gpu::{AdapterKind, adapter};

use super::cli::{Folder, SPOT, done, hexcast, json};

/// Standard error of a run that must end with an exit code.
#[track_caller]
pub(super) fn fails(arguments: &[&str], code: i32) -> String {
    let output = hexcast(arguments);
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {error}");
    error
}

#[test]
fn a_strict_run_with_warnings_writes_its_outputs_and_fails() {
    let folder = Folder::new();
    let output = folder.path("a.raw");
    let far = ["mesh", SPOT, "--domain", "5,5,5,6,6,6", "--cells", "4", "--backend", "cpu", "-q", "-o", &output];
    done(&far);
    std::fs::remove_file(&output).unwrap();
    let error = fails(&[&far[..], &["--strict"]].concat(), 8);
    assert!(error.contains("warning: geometry \"spot\" (flag 1) got no cell"), "{error}");
    assert!(error.contains("1 warning, and --strict is given"), "{error}");
    assert_eq!(folder.names(), ["a.raw", "a.raw.json"]);

    // what is odd about a file is a warning, too
    let cut = ["mesh", "tests/fixtures/ascii_missing_endsolid.stl", "--cells", "4", "--backend", "cpu", "-q"];
    let quiet = hexcast(&cut);
    let words = String::from_utf8_lossy(&quiet.stderr);
    assert!(
        quiet.status.success() && words.starts_with("warning: ") && words.contains("line 29: the file ends"),
        "{words}"
    );
    let error = fails(&[&cut[..], &["--strict"]].concat(), 8);
    assert!(error.contains("ascii_missing_endsolid.stl: line 29: the file ends without"), "{error}");

    done(&["mesh", SPOT, "--cells", "8", "--backend", "cpu", "-q", "--strict"]);
    assert!(done(&["--help"]).contains("8  warnings, and --strict"));
}

#[test]
fn no_gpu_and_one_in_software_are_no_warning_and_said_once() {
    let folder = Folder::new();
    let report = folder.path("report.json");
    let auto = ["mesh", SPOT, "--cells", "8", "--strict", "--report", &report];
    let mut runs = vec![(without_driver as fn(&[&str]) -> Output, "no GPU adapter")];
    if pollster::block_on(adapter(None)).expect("a GPU").kind == AdapterKind::Software {
        runs.push((|arguments| hexcast(arguments), "computes on the processor"));
    } else {
        let printed = done(&auto);
        assert!(
            printed.starts_with("backend     GPU") && folder.json("report.json")["fallback"].is_null(),
            "{printed}"
        );
    }
    for (run, why) in runs {
        let plain = run(&auto);
        let (printed, errors) = (String::from_utf8_lossy(&plain.stdout), String::from_utf8_lossy(&plain.stderr));
        assert!(plain.status.success() && !errors.contains("warning"), "{errors}");
        assert!(printed.starts_with("backend     CPU") && !printed.contains(why), "{printed}");
        let made = folder.json("report.json");
        assert!(made["fallback"].as_str().is_some_and(|text| text.contains(why)), "{}", made["fallback"]);
        assert_eq!((&made["findings"], &made["warnings"]), (&serde_json::json!([]), &serde_json::json!([])));

        let verbose = run(&[&auto[..], &["-v"]].concat());
        let words = [verbose.stdout, verbose.stderr].concat();
        assert_eq!(String::from_utf8_lossy(&words).matches(why).count(), 1, "{}", String::from_utf8_lossy(&words));
    }
    // nobody looked for a GPU
    done(&[&auto[..], &["--backend", "cpu"]].concat());
    assert!(folder.json("report.json")["fallback"].is_null());

    let output = without_driver(&[&auto[..], &["--domain", "5,5,5,6,6,6"]].concat());
    let words = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(8), "{words}");
    assert!(words.contains("1 warning, and --strict is given"), "{words}");
}

/// Runs the command where no driver of a GPU is found.
fn without_driver(arguments: &[&str]) -> Output {
    let command = &mut Command::new(env!("CARGO_BIN_EXE_hexcast"));
    command.args(arguments).env("VK_DRIVER_FILES", "/none").env("VK_ICD_FILENAMES", "/none").output().unwrap()
}

/// Sends a signal.
#[cfg(unix)]
#[track_caller]
fn signal(child: &std::process::Child, name: &str) {
    let killed = Command::new("kill").args([name, &child.id().to_string()]).status().expect("kill runs");
    assert!(killed.success());
}

/// Starts hexcast and waits until a condition holds.
#[cfg(unix)]
fn start_until(arguments: &[&str], is_reached: impl Fn() -> bool) -> std::process::Child {
    use std::time::{Duration, Instant};
    let mut command = Command::new(env!("CARGO_BIN_EXE_hexcast"));
    command.current_dir(env!("CARGO_MANIFEST_DIR")).args(arguments).stdout(Stdio::null()).stderr(Stdio::piped());
    let mut child = command.spawn().expect("hexcast starts");
    let start = Instant::now();
    while !is_reached() {
        if start.elapsed() > Duration::from_secs(60) {
            child.kill().expect("hexcast runs");
            panic!("{arguments:?}: nothing happened");
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    child
}

/// Folders of the first shards, `flag/c/0` and so on, in the temporary folder of a Zarr output.
#[cfg(unix)]
fn shard_folders(folder: &Folder) -> Vec<std::path::PathBuf> {
    let hidden = folder.names().into_iter().filter(|name| name.starts_with(".hexcast-"));
    let chunks = hidden.map(|name| Path::new(&folder.path(&name)).join("new/flag/c"));
    let entries = chunks.filter_map(|chunks| std::fs::read_dir(chunks).ok()).flatten().flatten();
    entries.map(|entry| entry.path()).collect()
}

/// A folder of Zarr that is cleaned away, by a job that tidies temporary folders, while it is written.
#[cfg(unix)]
#[test]
fn a_zarr_folder_that_loses_shards_is_an_error() {
    for vanishes_whole in [false, true] {
        let folder = Folder::new();
        let zarr = folder.path("a.zarr");
        let size = ["mesh", SPOT, "--dims", "600,600,9600", "--backend", "cpu", "--max-memory", "64MB"];
        let child = start_until(&[&size[..], &["--axis", "z", "-q", "-o", &zarr]].concat(), || {
            shard_folders(&folder).len() > 2
        });
        signal(&child, "-STOP");
        let mut shards = shard_folders(&folder);
        shards.sort();
        let lost = if vanishes_whole { shards[0].ancestors().nth(4).expect("a folder") } else { &shards[0] };
        std::fs::remove_dir_all(lost).unwrap();
        signal(&child, "-CONT");
        let ended = child.wait_with_output().expect("hexcast ends");
        let error = String::from_utf8_lossy(&ended.stderr);
        assert_eq!(ended.status.code(), Some(7), "{error}");
        assert!(error.contains("error[io]") && error.contains("a.zarr"), "{error}");
        // or the folder of the shard that was being written was gone
        let is_checked = error.contains("files that were written are missing or have another length");
        let is_noticed = error.contains("writing ") && error.contains("No such file or directory");
        assert!(is_checked && error.contains("\nhint: ") || is_noticed, "{error}");
        assert!(!Path::new(&zarr).exists(), "{:?}", folder.names());
    }
}

#[cfg(unix)]
#[test]
fn the_next_run_removes_what_a_killed_one_left() {
    for name in ["a.vti", "a.zarr"] {
        let folder = Folder::new();
        let (output, other) = (folder.path(name), folder.path("b.vti"));
        let size = ["mesh", SPOT, "--dims", "2000,2000,100000", "--axis", "z", "--backend", "cpu"];
        let is_hidden = |name: &String| name.starts_with(".hexcast-");
        let large = [&size[..], &["-q", "-o", &output]].concat();
        let mut killed = start_until(&large, || folder.names().iter().any(is_hidden));
        signal(&killed, "-KILL");
        killed.wait().expect("hexcast ends");
        let left: Vec<String> = folder.names().into_iter().filter(is_hidden).collect();
        assert_eq!(left.len(), 1, "{left:?}");

        // files of other makers and outputs, and of a run that is alive
        std::fs::write(folder.path(".hexcast-mine.part"), "precious").unwrap();
        let live = start_until(&large, || {
            folder.names().iter().any(|name| name.starts_with(".hexcast-a") && !left.contains(name))
        });
        let small = ["mesh", SPOT, "--cells", "8", "--backend", "cpu", "-q", "-o"];
        done(&[&small[..], &[&other]].concat());
        done(&[&small[..], &[&output]].concat());
        let hidden: Vec<String> = folder.names().into_iter().filter(is_hidden).collect();
        signal(&live, "-INT");
        assert_eq!(live.wait_with_output().expect("hexcast ends").status.code(), Some(130));
        assert_eq!(hidden.len(), 2, "{hidden:?}");
        assert!(hidden.iter().all(|name| !left.contains(name)), "{hidden:?}");
        assert_eq!(folder.bytes(".hexcast-mine.part"), b"precious");
        let mut names = vec![".hexcast-mine.part", name, "b.vti"];
        names.sort_unstable();
        assert_eq!(folder.names(), names);
    }
}

/// Killed after the old folder was moved away, and before the new one had its name.
#[test]
fn a_folder_that_a_killed_run_had_moved_away_comes_back() {
    let folder = Folder::new();
    let orphan = ".hexcast-a.zarr-AbCd12.part";
    std::fs::create_dir_all(folder.path(&format!("{orphan}/new"))).unwrap();
    std::fs::create_dir(folder.path(&format!("{orphan}/old"))).unwrap();
    std::fs::write(folder.path(&format!("{orphan}/old/zarr.json")), "precious").unwrap();
    fails(&["mesh", "tests/fixtures/bin_empty.stl", "-o", &folder.path("a.zarr")], 3);
    assert_eq!((folder.names(), folder.bytes("a.zarr/zarr.json")), (vec!["a.zarr".to_string()], b"precious".to_vec()));
}

#[cfg(unix)]
#[test]
fn what_is_not_a_file_of_hexcast_is_neither_written_nor_removed() {
    use std::os::unix::fs::FileTypeExt;
    let folder = Folder::new();
    let output = folder.path("a.raw");
    let partial = folder.path("a.raw.partial");
    let make_fifo = |path: &str| assert!(Command::new("mkfifo").arg(path).status().expect("mkfifo runs").success());
    let is_fifo = |path: &str| std::fs::symlink_metadata(path).is_ok_and(|metadata| metadata.file_type().is_fifo());
    let mesh = ["mesh", SPOT, "--cells", "8", "--backend", "cpu", "-q", "-o", &output];
    let resume = [&mesh[..], &["--resume"]].concat();

    make_fifo(&partial);
    assert!(fails(&resume, 7).contains("a.raw.partial exists and is not a file"));
    assert!(is_fifo(&partial));
    std::fs::remove_file(&partial).unwrap();

    std::fs::create_dir(&partial).unwrap();
    assert!(fails(&resume, 7).contains("a.raw.partial exists and is not a file"));
    std::fs::remove_dir(&partial).unwrap();

    std::fs::write(folder.path("mine"), "precious").unwrap();
    std::os::unix::fs::symlink("mine", &partial).unwrap();
    assert!(fails(&resume, 7).contains("a.raw.partial exists and is not a file"));
    assert_eq!(folder.bytes("mine"), b"precious");
    std::fs::remove_file(&partial).unwrap();

    // also where the run fails before it looks into the file
    std::fs::write(&partial, "notes").unwrap();
    let early = fails(&["mesh", "no-such.stl", "--resume", "-o", &output], 4);
    assert!(early.contains("is not a hexcast file") && !early.contains("kept:"), "{early}");
    assert_eq!(folder.bytes("a.raw.partial"), b"notes");

    let (pipe, null) = (folder.path("b.raw"), folder.path("null.json"));
    make_fifo(&pipe);
    std::os::unix::fs::symlink("/dev/null", &null).unwrap();
    for arguments in [["mesh", SPOT, "-o", &pipe], ["mesh", SPOT, "--report", &null]] {
        let error = fails(&[&arguments[..], &["--cells", "8", "--backend", "cpu", "-q"]].concat(), 7);
        assert!(error.contains("exists and is not a file"), "{error}");
    }
    assert!(is_fifo(&pipe) && is_link(&null));

    #[cfg(target_os = "linux")]
    {
        let mut command = Command::new(env!("CARGO_BIN_EXE_hexcast"));
        command.args(["mesh", SPOT, "--cells", "8", "--backend", "cpu", "-q", "--report", "/dev/stdout"]);
        let shown = std::fs::File::create(folder.path("shown")).expect("a file");
        let output = command.stdout(shown).output().expect("hexcast starts");
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(7) && error.contains("exists and is not a file"), "{error}");
    }
}

#[cfg(unix)]
fn is_link(path: &str) -> bool {
    std::fs::symlink_metadata(path).is_ok_and(|metadata| metadata.is_symlink())
}

#[cfg(unix)]
#[test]
fn an_output_that_is_a_link_writes_what_it_leads_to() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("disk")).unwrap();
    let mesh = ["mesh", SPOT, "--cells", "8", "--backend", "cpu", "-q", "-o"];
    std::fs::write(folder.path("disk/old.npy"), "old").unwrap();
    // one to a file, one to a link to a file that is not there yet, one to a folder
    for (link, target) in
        [("a.npy", "disk/old.npy"), ("b.npy", "c.npy"), ("c.npy", "disk/new.npy"), ("d.zarr", "disk/d.zarr")]
    {
        std::os::unix::fs::symlink(target, folder.path(link)).unwrap();
    }
    done(&[&mesh[..], &[&folder.path("a.npy")]].concat());
    done(&[&mesh[..], &[&folder.path("b.npy")]].concat());
    // a second time over the folder that the first has made
    done(&[&mesh[..], &[&folder.path("d.zarr")]].concat());
    done(&[&mesh[..], &[&folder.path("d.zarr")]].concat());
    assert!(["a.npy", "b.npy", "c.npy", "d.zarr"].iter().all(|link| is_link(&folder.path(link))));
    assert_eq!(folder.bytes("disk/old.npy")[..6], *b"\x93NUMPY");
    assert_eq!(folder.bytes("disk/new.npy"), folder.bytes("disk/old.npy"));
    assert_eq!(folder.json("disk/d.zarr/zarr.json")["node_type"], "group");
    assert_eq!(std::fs::read_dir(folder.path("disk")).unwrap().count(), 3);
    assert_eq!(folder.names(), ["a.npy", "b.npy", "c.npy", "d.zarr", "disk"]);

    let (old, link) = (folder.path("disk/old.npy"), folder.path("a.npy"));
    assert!(fails(&[&mesh[..], &[&old, "-o", &link]].concat(), 4).contains("is written twice"));
    std::os::unix::fs::symlink("e.npy", folder.path("e.npy")).unwrap();
    assert!(fails(&[&mesh[..], &[&folder.path("e.npy")]].concat(), 7).contains("links in a circle"));
}

/// Two tetrahedra, one outside the domain, with the names given.
fn two_solids(names: [&str; 2]) -> String {
    let solid = |(name, shift): (&str, i32)| {
        let corner = |[x, y, z]: [i32; 3]| format!("vertex {} {y} {z}\n", x + shift);
        let corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]];
        let facets = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]].map(|facet| {
            let vertices: String = facet.iter().map(|&index: &usize| corner(corners[index])).collect();
            format!("facet normal 0 0 0\nouter loop\n{vertices}endloop\nendfacet\n")
        });
        format!("solid {name}\n{}endsolid {name}\n", facets.concat())
    };
    names.into_iter().zip([0, 9]).map(solid).collect()
}

#[test]
fn names_cannot_move_the_cursor() {
    let folder = Folder::new();
    let stl = folder.path("\u{1b}[31mred.stl");
    let names = ["\u{1b}]0;title\u{7}steel", "\u{9b}2Jcopper\u{202e}"];
    std::fs::write(&stl, two_solids(names)).unwrap();
    let mesh = ["mesh", &stl, "--split", "--domain", "0,0,0,1,1,1", "--cells", "4", "--backend", "cpu"];
    let runs: [Vec<&str>; 4] = [
        [&mesh[..], &["-v"]].concat(),
        vec!["info", &stl],
        vec!["info", "no\u{1b}[2Jsuch.stl"],
        vec!["mesh", &stl, "-o", "a\u{1b}c.txt"],
    ];
    let mut shown = String::new();
    for arguments in runs {
        let output = hexcast(&arguments);
        let text = String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned();
        let odd = text.chars().find(|c| c.is_control() && *c != '\n' || ('\u{202a}'..='\u{202e}').contains(c));
        assert_eq!(odd, None, "{arguments:?}: {text:?}");
        shown += &text;
    }
    for part in ["\\u{1b}]0;title\\u{7}steel", "\\u{9b}2Jcopper\\u{202e}", "\\u{1b}[31mred.stl", "no\\u{1b}[2Jsuch"] {
        assert!(shown.contains(part), "{part}: {shown}");
    }
    // a name does not make lines of its own
    let named = json(&[&mesh[..], &["--json"]].concat());
    assert_eq!(named["geometries"][0]["name"], names[0]);
    assert_eq!(named["inputs"][0]["file"], *stl);
    let forged = folder.path("a.stl");
    std::fs::copy(SPOT, &forged).unwrap();
    let argument = format!("{forged}:name=spot\nerror[io]: all is lost");
    let text = done(&["mesh", &argument, "--cells", "4", "--backend", "cpu", "-v"]);
    assert!(text.contains("spot\\nerror[io]") && !text.contains("\nerror[io]"), "{text}");
}

#[test]
fn an_error_of_a_job_file_quotes_little_of_a_long_line() {
    let folder = Folder::new();
    let long = "é".repeat(100_000);
    let geometries = "geometries = [{file = \"a.stl\"}]";
    let texts = [
        ("a.toml", format!("unit = \"{long}\" oops \"{long}\"\n{geometries}\n")),
        ("b.toml", format!("cells = \"{long}\"\n{geometries}\n")),
        ("c.toml", format!("{long} = 1\n")),
        ("d.toml", format!("{geometries}\n\"{long}\" = 1\n")),
        ("e.json", format!("{{\"cells\": \"{long}\"}}")),
        ("f.json", format!("{{\"{long}\": 1}}")),
    ];
    for (name, text) in texts {
        let job = folder.path(name);
        std::fs::write(&job, text).unwrap();
        let error = fails(&["mesh", "--job", &job], 4);
        assert!(error.len() < 2_000, "{name}: {} bytes", error.len());
        // of JSON the key says where it is
        assert!(
            error.contains(if name.ends_with("toml") { "column" } else { ".json: " }) && error.contains("..."),
            "{name}: {error}"
        );
    }
    // the caret is under the word that is wrong
    let error = fails(&["mesh", "--job", &folder.path("a.toml")], 4);
    let lines: Vec<Vec<char>> = error.lines().map(|line| line.chars().collect()).collect();
    let caret = lines.iter().find_map(|line| line.iter().position(|c| *c == '^')).expect("a caret");
    let quoted = lines.iter().find(|line| line.starts_with(&['1', ' ', '|'])).expect("the line");
    assert!(quoted[caret..].starts_with(&['o', 'o', 'p', 's']), "{error}");
}

#[test]
fn info_prints_the_first_of_many_solids() {
    let folder = Folder::new();
    let stl = folder.path("many.stl");
    let text: String = (0..50).map(|n| two_solids([&format!("left{n}"), &format!("right{n}")])).collect();
    std::fs::write(&stl, text).unwrap();
    let text = done(&["info", &stl]);
    assert_eq!(text.matches("\": 4 facets").count(), 20, "{text}");
    assert!(text.contains("80 more solids; --json lists all"), "{text}");
    assert_eq!(json(&["info", "--json", &stl])[0]["solids"].as_array().unwrap().len(), 100);
}

#[cfg(unix)]
#[test]
fn an_input_without_an_end_is_given_up_at_the_limit_of_memory() {
    for command in [&["mesh", "/dev/zero", "--backend", "cpu"][..], &["estimate", "/dev/zero"]] {
        let error = fails(&[command, &["--max-memory", "100MB"]].concat(), 5);
        assert!(error.contains("error[memory]: /dev/zero"), "{error}");
        assert!(error.contains("100.00 MB are allowed") && error.contains("\nhint: "), "{error}");
    }
    let error = fails(&["mesh", "--job", "/dev/zero"], 4);
    assert!(error.contains("error[job-syntax]: /dev/zero has more than 67108864 bytes"), "{error}");

    // a pipe that would be small enough on disk
    let mut zeros = Command::new("head").args(["-c", "60000000", "/dev/zero"]).stdout(Stdio::piped()).spawn().unwrap();
    let pipe = zeros.stdout.take().expect("a pipe");
    let mut command = Command::new(env!("CARGO_BIN_EXE_hexcast"));
    command.args(["mesh", "/dev/stdin", "--backend", "cpu", "--max-memory", "80MB"]).stdin(pipe);
    let output = command.output().expect("hexcast starts");
    // it holds the pipe, and head waits for a reader
    drop(command);
    zeros.wait().expect("head ends");
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(5) && error.contains("error[memory]: /dev/stdin"), "{error}");
}

/// 4 TB, of which 20 bytes in a million are other than 0.
#[cfg(unix)]
#[test]
fn outputs_that_the_disk_has_no_room_for_are_refused_before_they_are_written() {
    let folder = Folder::new();
    let size = ["mesh", SPOT, "--dims", "4000,4000,262142", "--axis", "z", "--backend", "cpu"];
    let (raw, vti) = (folder.path("a.raw"), folder.path("a.vti"));
    let outputs = ["--max-cells", "1e13", "--compress=none", "-o", &raw, "-o", &vti];
    let error = fails(&[&size[..], &outputs].concat(), 7);
    assert!(error.contains("error[io]") && error.contains("bytes are missing"), "{error}");
    // both files count, and the second has a head and a tail
    assert!(error.contains(&format!("take {}", 2 * 4_194_272_000_000_u64)[..9]), "{error}");
    assert!(error.contains("a.raw and ") && error.contains("a.vti take "), "{error}");
    assert!(folder.names().is_empty(), "{:?}", folder.names());
}

#[test]
fn more_cells_than_a_typing_error_would_ask_for_need_an_argument() {
    let job = |cells: &'static [&'static str]| [&["estimate", SPOT][..], cells].concat();
    let ways: [&[&str]; 5] = [
        &["--cells", "20000"],
        &["--dims", "10001,10000,10000"],
        &["--cell-size", "1e-4"],
        &["--max-cell-size", "1e-4"],
        &["--cells", "1000", "--padding-cells", "9000"],
    ];
    for way in ways {
        let error = fails(&job(way), 5);
        assert!(error.contains("error[too-many-cells]") && error.contains("at most 1000000000000"), "{error}");
        assert!(error.contains("hint: ") && error.contains("--max-cells"), "{error}");
    }
    done(&[&job(ways[1])[..], &["--max-cells", "1000100000000"]].concat());
    done(&[&job(ways[1])[..], &["--max-cells", "2e12"]].concat());
    let error = fails(&["mesh", SPOT, "--dims", "10,10,10", "--max-cells", "999"], 5);
    assert!(error.contains("10 x 10 x 10 = 1000 cells") && error.contains("at most 999"), "{error}");
    fails(&["mesh", SPOT, "--max-cells", "0"], 2);
}

/// End points at 0, 1, 9 and 9.37: lengths whose common divisor is a thirtieth of the largest size.
#[test]
fn a_chosen_size_far_below_the_largest_is_a_warning() {
    let folder = Folder::new();
    let stl = folder.path("two.stl");
    std::fs::write(&stl, two_solids(["left", "right"])).unwrap();
    let mesh = ["mesh", &stl, "--split", "--backend", "cpu", "--max-cell-size", "0.3", "--quick", "--json"];
    let fine = json(&[&mesh[..], &["--tolerance", "0.2"]].concat());
    assert_eq!(fine["warnings"], serde_json::json!([]), "{fine}");
    std::fs::write(&stl, two_solids(["left", "right"]).replace("vertex 10 ", "vertex 9.37 ")).unwrap();
    let report = json(&[&mesh[..], &["--tolerance", "0.001"]].concat());
    let warning = report["warnings"][0].as_str().expect("a warning");
    for part in ["along x", "less than half of 0.3", "a tolerance of", "cells off"] {
        assert!(warning.contains(part), "{part}: {warning}");
    }
    assert_eq!(report["warnings"].as_array().unwrap().len(), 1, "{report}");
}
