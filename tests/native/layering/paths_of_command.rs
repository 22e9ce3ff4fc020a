//! The command opens files and gives them names in one place, which knows all that are read and written.

use super::sources;

/// What makes, opens, renames or replaces files, and where it may be written.
const OPENS: &[(&str, &[&str])] = &[
    ("File::create", TEMPORARY),
    ("File::options", &["files/ledger.rs", "files/temporary.rs"]),
    ("OpenOptions", &[]),
    ("File::open", &[]),
    ("open_file", &["files/ledger.rs"]),
    ("fs::write", &[]),
    ("fs::copy", &[]),
    ("fs::rename", &["files/ledger.rs", "files/temporary.rs"]),
    ("fs::hard_link", &[]),
    ("NamedTempFile", &["files/ledger.rs", "files/output_file.rs", "files/temporary.rs"]),
    ("TempDir", TEMPORARY),
    ("tempfile_in", TEMPORARY),
    ("tempdir_in", TEMPORARY),
    // what a store has, which its own process may have written
    ("fs::read(", &["files/place_of_store.rs", "commands/verify/stl.rs"]),
    // what the system says of the process and the machine
    ("fs::read_to_string", &["screen/memory.rs", "commands/adapters.rs"]),
    ("FilesystemStore::new", &[]),
];
const TEMPORARY: &[&str] = &["files/temporary.rs"];

#[test]
fn every_file_that_the_command_opens_goes_through_the_ledger() {
    let all = sources();
    let own: Vec<_> = all.iter().filter_map(|of| Some((of.name.strip_prefix("bin/hexcast/")?, of))).collect();
    assert!(own.len() > 40, "{}", own.len());
    let is_known = |places: &[&str], name: &str| places.contains(&name);
    for (word, places) in OPENS {
        let found: Vec<&str> =
            own.iter().filter(|(_, source)| has(&source.code, word)).map(|(name, _)| *name).collect();
        let others: Vec<&&str> = found.iter().filter(|name| !is_known(places, name)).collect();
        assert!(others.is_empty(), "{others:?} of src/bin/hexcast use {word}: open files by `ledger`");
        let unused: Vec<&&str> = places.iter().filter(|place| !found.contains(place)).collect();
        assert!(unused.is_empty(), "{word} is no longer in {unused:?}");
    }
}

/// Whether code has a word, and not only as the end of a longer one.
fn has(code: &str, word: &str) -> bool {
    let is_within = |at: usize| code[..at].ends_with(|before: char| before.is_alphanumeric() || before == '_');
    code.match_indices(word).any(|(at, _)| !is_within(at))
}
