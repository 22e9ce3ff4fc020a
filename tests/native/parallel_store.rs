//! Zarr stores that processes fill part by part: the bytes of the undivided run, in any order, repeated, killed; and what is missing or wrong.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::{Value, json};

use super::cli::{Folder, SPOT, done, hexcast, json as json_of};

/// All files of a folder by their names in it.
pub(super) fn files(root: &str) -> BTreeMap<String, Vec<u8>> {
    let (mut files, mut folders) = (BTreeMap::new(), vec![PathBuf::from(root)]);
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let name = path.strip_prefix(root).expect("below").to_string_lossy().into_owned();
                files.insert(name, std::fs::read(&path).expect("a file"));
            }
        }
    }
    files
}

/// How many files a folder has, in which others write at the same time: what goes while it is counted, such as the temporary file
/// of a shard that gets its name, does not count.
fn count_files(folder: &Path) -> usize {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    entries.map(|entry| if entry.path().is_dir() { count_files(&entry.path()) } else { 1 }).sum()
}

#[track_caller]
fn assert_same(one: &str, other: &str) {
    let (one, other) = (files(one), files(other));
    let names: [Vec<&String>; 2] = [&one, &other].map(|files| files.keys().collect());
    assert_eq!(names[0], names[1]);
    let differing: Vec<&String> = one.keys().filter(|name| one[*name] != other[*name]).collect();
    assert!(differing.is_empty(), "{differing:?}");
}

const MESH: [&str; 8] = ["mesh", SPOT, "--cells", "100", "--backend", "cpu", "-q", "--zarr-shards=64KiB"];

#[test]
fn parts_fill_the_store_of_the_undivided_run() {
    let folder = Folder::new();
    let (whole, parted) = (folder.path("whole.zarr"), folder.path("parted.zarr"));
    let shapes = ["--compress=none", "--zarr-chunks", "32,16,8", "--zarr-shards", "32,48,24"];
    for (of, options) in [("4", &["--unit", "mm", "--zarr-shards=64KiB"][..]), ("1x2x2", &shapes)] {
        let mesh = &MESH[..7];
        done(&[mesh, options, &["-o", &whole]].concat());
        // from the last to the first, the middle ones twice
        for k in (1..=4).rev().chain(2..4) {
            done(&[mesh, options, &["-o", &parted, "--part", &format!("{k}/{of}")]].concat());
        }
        assert_same(&whole, &parted);
        std::fs::remove_dir_all(&parted).unwrap();
    }
}

#[test]
fn parts_at_the_same_time_and_killed_ones_that_are_repeated_leave_no_trace() {
    let folder = Folder::new();
    let (whole, parted) = (folder.path("whole.zarr"), folder.path("parted.zarr"));
    let mesh = ["mesh", SPOT, "--cells", "600", "--backend", "cpu", "-q", "--zarr-shards=128KiB", "--compress=9"];
    done(&[&mesh[..], &["-o", &whole]].concat());
    let start = |k: usize| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_hexcast"));
        command.current_dir(env!("CARGO_MANIFEST_DIR")).args(mesh).args(["-o", &parted, "--part", &format!("{k}/3")]);
        // on one thread, so that there are seconds in which it can be killed
        command.args(["--threads", "1"]).stderr(Stdio::piped()).spawn().expect("hexcast starts")
    };
    let mut running: Vec<_> = (1..=3).map(start).collect();
    // in the middle of its shards
    let mut killed = running.pop().expect("three");
    while count_files(Path::new(&parted)) < 12 {
        assert!(killed.try_wait().expect("its state").is_none(), "it ended before it could be killed");
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    killed.kill().expect("it runs");
    killed.wait().expect("it ended");
    for child in running {
        let output = child.wait_with_output().expect("it ends");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }
    assert!(start(3).wait().expect("it ends").success());
    assert_same(&whole, &parted);
}

#[test]
fn a_store_of_another_mesh_is_not_mixed_with_this_one() {
    let folder = Folder::new();
    let store = folder.path("a.zarr");
    let part = ["-o", &store, "--part", "1/2"];
    done(&[&MESH[..], &part].concat());
    let before = files(&store);
    for other in [["--cells", "90"], ["--unit", "mm"], ["--compress=6", "--zarr-chunks=16,16,16"]] {
        let rest: Vec<&str> = MESH.iter().copied().filter(|word| !["--cells", "100"].contains(word)).collect();
        let cells: &[&str] = if other[0] == "--cells" { &[] } else { &["--cells", "100"] };
        let refused = hexcast(&[&rest[..], cells, &other, &part].concat());
        let error = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert_eq!(refused.status.code(), Some(7), "{error}");
        assert!(error.contains("the store is that of another mesh") && error.contains("zarr.json differs"), "{error}");
    }
    assert_eq!(files(&store), before);
    let refused = |arguments: &[&str], words: &str| {
        let output = hexcast(&[&MESH[..], arguments].concat());
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(4) && error.contains(words), "{arguments:?}: {error}");
    };
    refused(&["-o", &store, "--part", "1/200"], "shards of");
    refused(&["-o", &store, "--part", "1/2", "--halo", "1"], "a store has every cell once");
}

#[test]
fn missing_and_wrong_shards_are_named() {
    let folder = Folder::new();
    let store = folder.path("a.zarr");
    let mesh = [&MESH[1..], &["--unit", "mm"]].concat();
    done(&[&["mesh"], &mesh[..], &["-o", &store]].concat());
    let job: Vec<&str> = mesh.iter().copied().filter(|word| *word != "-q" && !word.starts_with("--zarr")).collect();
    let verify = |by_job: bool| -> (Option<i32>, Value) {
        let job = if by_job { &job[..] } else { &[] };
        let output = hexcast(&[&["verify-store", &store, "--json"], job].concat());
        let found = serde_json::from_slice(&output.stdout);
        (
            output.status.code(),
            found.unwrap_or_else(|error| panic!("{error}: {}", String::from_utf8_lossy(&output.stderr))),
        )
    };
    let n_shards = files(&store).keys().filter(|name| name.starts_with("flag/c/")).count();
    assert!(n_shards > 10);
    for by_job in [false, true] {
        assert_eq!(verify(by_job), (Some(0), json!({"shards": n_shards, "missing": [], "wrong": [], "unknown": []})));
    }
    let file = |name: &str| Path::new(&store).join(name);
    std::fs::remove_file(file("flag/c/1/0/0")).unwrap();
    let bytes = std::fs::read(file("flag/c/0/0/0")).unwrap();
    std::fs::write(file("flag/c/0/0/0"), &bytes[..bytes.len() / 2]).unwrap();
    std::fs::write(file("flag/c/1/0/0.part"), "").unwrap();
    // sound by itself, of other cells
    std::fs::copy(file("flag/c/3/0/0"), file("flag/c/2/0/0")).unwrap();
    for by_job in [false, true] {
        let (code, found) = verify(by_job);
        assert_eq!((code, &found["missing"]), (Some(9), &json!(["flag/c/1/0/0"])));
        assert_eq!(found["unknown"], json!(["flag/c/1/0/0.part"]));
        let wrong: Vec<&str> =
            found["wrong"].as_array().unwrap().iter().map(|of| of["key"].as_str().unwrap()).collect();
        assert_eq!(wrong, if by_job { &["flag/c/0/0/0", "flag/c/2/0/0"][..] } else { &["flag/c/0/0/0"] });
    }
    let text = hexcast(&["verify-store", &store]);
    let text = String::from_utf8_lossy(&text.stdout).into_owned();
    assert!(
        text.contains("Missing: flag/c/1/0/0\n") && text.contains("Wrong: flag/c/0/0/0: it cannot be read"),
        "{text}"
    );
    let none = hexcast(&["verify-store", &folder.path("none.zarr")]);
    assert_eq!(none.status.code(), Some(7), "{}", String::from_utf8_lossy(&none.stderr));
}

#[test]
fn parts_of_stores_are_listed_as_they_are_cut() {
    let arguments = ["parts", SPOT, "--cells", "100", "--n", "3", "--zarr-shards=64KiB", "--zarr"];
    let listed = json_of(&arguments);
    let folder = Folder::new();
    for part in listed["parts"].as_array().expect("a list") {
        let name = part["part"].as_str().expect("a text");
        let report = json_of(
            &[&MESH[..6], &["--zarr-shards=64KiB", "--json", "-o", &folder.path("a.zarr"), "--part", name]].concat(),
        );
        assert_eq!((&report["cells"], &report["window"]["first"][2]), (&part["cells"], &part["window"][2]));
    }
}

#[test]
fn shards_of_coarser_levels_are_verified_too() {
    let folder = Folder::new();
    let store = folder.path("a.zarr");
    let mesh = ["mesh", SPOT, "--cells", "200", "--backend", "cpu", "-q", "--zarr-shards=64KiB", "--zarr-levels=any"];
    done(&[&mesh[..], &["-o", &store]].concat());
    let job = [SPOT, "--cells", "200", "--backend", "cpu"];
    let verify = |job: &[&str]| {
        let output = hexcast(&[&["verify-store", &store, "--json"], job].concat());
        let found: Value = serde_json::from_slice(&output.stdout).expect("JSON");
        let keys = found["wrong"].as_array().unwrap().iter().map(|of| of["key"].as_str().unwrap().to_string());
        (output.status.code(), found["missing"].clone(), keys.collect::<Vec<String>>(), found["unknown"].clone())
    };
    let right = (Some(0), json!([]), Vec::new(), json!([]));
    assert_eq!([verify(&[]), verify(&job)], [right.clone(), right.clone()]);
    let of_level = |level: u32| -> Vec<String> {
        let folder = format!("levels/{level}/flag/c/");
        files(&store).into_keys().filter(|key| key.starts_with(&folder)).collect()
    };
    assert!(of_level(1).len() > 2 && !of_level(2).is_empty() && of_level(3).is_empty());
    let (missing, broken) = (of_level(1).remove(1), of_level(2).remove(0));
    let file = |name: &str| Path::new(&store).join(name);
    std::fs::remove_file(file(&missing)).unwrap();
    std::fs::write(file(&broken), "").unwrap();
    std::fs::create_dir_all(file("levels/1/flag/c/90/0")).unwrap();
    std::fs::write(file("levels/1/flag/c/90/0/0"), "").unwrap();
    for job in [&[][..], &job] {
        let expected = (Some(9), json!([missing]), vec![broken.clone()], json!(["levels/1/flag/c/90/0/0"]));
        assert_eq!(verify(job), expected);
    }
    let refused = hexcast(&[&mesh[..], &["-o", &folder.path("b.zarr"), "--part", "1/2"]].concat());
    let error = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(refused.status.code() == Some(4) && error.contains("coarser levels are made of the whole mesh"), "{error}");
    assert!(!Path::new(&folder.path("b.zarr")).join("zarr.json").exists());

    // a shard without a flag is left out, and one that is there all the same is named
    std::fs::remove_dir_all(&store).unwrap();
    done(&[&mesh[..], &["--zarr-sparse", "-o", &store]].concat());
    let shards: Vec<String> = files(&store).into_keys().filter(|key| key.starts_with("flag/c/")).collect();
    let grid: Value = serde_json::from_slice(&std::fs::read(file("flag/zarr.json")).unwrap()).unwrap();
    let lengths = |of: &Value| -> Vec<u64> { serde_json::from_value(of.clone()).unwrap() };
    let of_shard = lengths(&grid["chunk_grid"]["configuration"]["chunk_shape"]);
    let n_of_grid: u64 = lengths(&grid["shape"]).iter().zip(of_shard).map(|(n, of)| n.div_ceil(of)).product();
    assert!(shards.len() > 4 && (shards.len() as u64) < n_of_grid, "{} of {n_of_grid}", shards.len());
    assert_eq!([verify(&[]), verify(&job)], [right.clone(), right]);
    let empty = (0..n_of_grid).map(|k| format!("flag/c/{k}/0/0")).find(|key| !shards.contains(key));
    let empty = empty.unwrap_or_else(|| "flag/c/0/1/0".into());
    std::fs::create_dir_all(file(&empty).parent().unwrap()).unwrap();
    std::fs::copy(file(&shards[0]), file(&empty)).unwrap();
    std::fs::remove_file(file(&shards[1])).unwrap();
    assert_eq!(verify(&job), (Some(9), json!([shards[1]]), vec![empty], json!([])));
}
