//! The check of `hexcast verify`: a second program, so that agreement means something.

use std::collections::BTreeSet;

use super::{paths, sources};

/// What the check may use of the library: what is asked for, the reader of what is checked, errors and cancel.
const LIBRARY: &[&str] = &["Error", "Result", "control", "job", "mesh::Mesh"];
/// What the command around it may use of the other commands.
const COMMANDS: &[&str] = &["crate::files::reading", "crate::options::arguments", "crate::screen::terminal"];
/// Most lines of code, imports among them, without comments and blank lines.
const MOST_LINES: usize = 925;

#[test]
fn the_check_shares_no_code_with_the_mesher_and_is_short() {
    let sources = sources();
    let is_own = |name: &str| name.starts_with("bin/hexcast/commands/verify/");
    let own: Vec<&str> = sources.iter().filter(|source| is_own(&source.name)).map(|source| &source.name[..]).collect();
    assert!(own.len() >= 4, "{own:?}");
    let mut n_lines = 0;
    for source in
        sources.iter().filter(|source| is_own(&source.name) || source.name == "bin/hexcast/commands/verify.rs")
    {
        let name = &source.name;
        for path in paths(&source.code, "hexcast") {
            let path = path.trim_start_matches("hexcast::");
            let is_allowed = LIBRARY.iter().any(|known| path == *known || path.starts_with(&format!("{known}::")));
            assert!(is_allowed, "src/{name} uses hexcast::{path}");
        }
        let modules: BTreeSet<String> = own
            .iter()
            .map(|name| format!("super::{}", &name["bin/hexcast/commands/verify/".len()..name.len() - 3]))
            .collect();
        for path in paths(&source.code, "super") {
            let start = path.splitn(3, "::").take(2).collect::<Vec<_>>().join("::");
            assert!(is_own(name) && modules.contains(&start), "src/{name} uses {path}");
        }
        for path in paths(&source.code, "crate") {
            let start = path.splitn(4, "::").take(3).collect::<Vec<_>>().join("::");
            assert!(!is_own(name) && COMMANDS.contains(&&start[..]), "src/{name} uses {path}");
        }
        n_lines += if is_own(name) { source.code.lines().filter(|line| !line.trim().is_empty()).count() } else { 0 };
    }
    assert!(n_lines <= MOST_LINES, "the check has {n_lines} lines of code");
}
