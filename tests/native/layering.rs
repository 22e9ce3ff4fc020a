//! The architecture, held to the source: who may use whom, and what the core must not know.
//!
//! Cargo holds the crates apart. Within them a module may use earlier ones of the line only, and a group therefore earlier groups. The test reads
//! every path of all crates, unit tests apart. A file that has no place in the table fails: give it one.

use std::collections::BTreeSet;
use std::iter::Peekable;
use std::path::{Path, PathBuf};
use std::str::Chars;

mod checker;
mod circles;
mod paths_of_command;

/// The groups of all crates and their modules, in the order of the line: each may use those before it. All before `derived` are the core, and
/// the job below it; `derived`, `files` and `gpu` are crates of their own. `gpu`, `web` and `bin` are one module each; `bin` and `web` stand side
/// by side.
const GROUPS: &[(&str, &[&str])] = &[
    (
        "base",
        &["error", "finding", "parallel", "memory", "control", "sort", "network", "checksum", "zlib", "length", "set"],
    ),
    ("input", &["choices", "job", "geometry", "edges", "surface", "preview", "read", "sources"]),
    ("grid", &["domain", "lines", "totals", "frame", "closed", "volume_bound", "rays", "window"]),
    ("cells", &["columns", "flags", "volumes", "fingerprint"]),
    (
        "stages",
        &[
            "cast",
            "facet",
            "snapping",
            "lattice",
            "pillars",
            "crossings",
            "map",
            "slots",
            "inside",
            "cpu",
            "kept",
            "axis_crossings",
            "expected_crossings",
        ],
    ),
    ("open_surfaces", &["open", "sheet", "doubt", "overlay", "points"]),
    ("testing", &[]),
    (
        "derived",
        &[
            "fractions",
            "links",
            "staggered",
            "walls",
            "mesh",
            "certificate",
            "cut",
            "cut_cells",
            "difference",
            "skin",
            "leak",
            "gaps",
            "distance",
            "testing",
        ],
    ),
    ("files", &["colours", "picture", "shards", "write", "export"]),
    ("gpu", &[]),
    (
        "meshing",
        &[
            "report", "measured", "parts", "estimate", "pipeline", "scene", "converge", "refine", "machine", "files",
            "mesher",
        ],
    ),
    ("web", &[]),
    ("bin", &[]),
];

/// The folders of the command, whose crate's root is its own.
const COMMAND: &[&str] = &["commands", "files", "options", "screen"];

/// What core and files must not know, besides what is none of their dependencies: files, clocks, terminals, processes.
const UNKNOWN_TO_CORE: &[&str] = &[
    "std::fs",
    "std::time",
    "std::env",
    "std::process",
    "std::net",
    "std::io::stdout",
    "std::io::stderr",
    "std::io::stdin",
    "Instant",
    "SystemTime",
    "println!",
    "eprintln!",
    "print!",
    "eprint!",
    "dbg!",
    "clap",
];
/// What a module of the core says all the same: fields of a job are the options of the command, where that is built.
const KNOWN_TO: &[(&str, &str)] = &[("input::job", "clap"), ("input::choices", "clap")];
/// A kernel whose host code called its definition would prove nothing: it uses the stages' types only.
const UNKNOWN_TO_GPU: &[&str] = &[
    "crate::stages::cpu::columns",
    "crate::stages::cpu::Strips",
    "crate::stages::facet",
    "crate::stages::lattice::lattice",
    "crate::stages::crossings::crossings",
    "crate::stages::map::map",
    "crate::stages::slots",
    "std::fs",
    "println!",
    "eprintln!",
];
/// The pipeline chooses a backend; it talks to no device, page, file or terminal itself.
const UNKNOWN_TO_PIPELINE: &[&str] =
    &["wgpu", "bytemuck", "std::fs", "web_sys", "js_sys", "wasm_bindgen", "println!", "eprintln!", "indicatif", "clap"];

/// Files are read and meshes waited for; nothing is printed, and no device is talked to.
const UNKNOWN_TO_MESHER: &[&str] =
    &["wgpu", "bytemuck", "web_sys", "js_sys", "wasm_bindgen", "println!", "eprintln!", "indicatif", "clap"];

/// A source file: its module (such as `grid::frame`, or `gpu`), its name, and its code without comments and tests.
struct Source {
    name: String,
    module: String,
    code: String,
}

impl Source {
    fn new(name: &str, text: &str) -> Source {
        let module = module_of(name.trim_end_matches(".rs").split('/'));
        Source { module, code: code_of(text), name: name.into() }
    }
}

/// The folders of the crates, and what their files are below here.
const CRATES: &[(&str, &str)] = &[
    ("crates/job/src", ""),
    ("crates/core/src", ""),
    ("crates/derived/src", "derived"),
    ("crates/files/src", "files"),
    ("crates/gpu/src", "gpu"),
    ("src", ""),
];

/// The files of all crates as if they were modules of one: those of the core and the root by their place, of another crate below its name.
fn sources() -> Vec<Source> {
    CRATES.iter().flat_map(|(folder, name)| sources_of(folder, name)).collect()
}

fn sources_of(folder: &str, within: &str) -> Vec<Source> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let mut paths = Vec::new();
    collect(&root, &mut paths);
    let relative = |path: &PathBuf| path.strip_prefix(&root).expect("below src").to_string_lossy().replace('\\', "/");
    // what the core lists, the root passes on
    let is_left_out = |name: &str| {
        name.ends_with("/tests.rs")
            || name.contains("/tests/")
            || name == "lib.rs" && ["crates/job/src", "crates/core/src"].contains(&folder)
    };
    let of_file = |name: String| {
        let text = std::fs::read_to_string(root.join(&name)).expect("source is readable");
        // the command names the library as its callers do
        if name.starts_with("bin/") {
            return Source::new(&name, &text);
        }
        let shown = match (within, name.as_str()) {
            ("", _) => name,
            (_, "lib.rs") => format!("{within}.rs"),
            _ => format!("{within}/{name}"),
        };
        let own = if within.is_empty() { "crate::".into() } else { format!("crate::{within}::") };
        let text = text.replace("crate::", &own).replace("hexcast_core::set;", "crate::base::set::set;");
        let text = text.replace("hexcast_job::", "crate::").replace("hexcast_core::", "crate::");
        let text = text.replace("hexcast_derived::", "crate::derived::");
        let text = text.replace("hexcast_files::", "crate::files::").replace("hexcast_gpu::", "crate::gpu::");
        Source::new(&shown, &text)
    };
    paths.iter().map(relative).filter(|name| !is_left_out(name)).map(of_file).collect()
}

fn collect(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("folder is readable") {
        let path = entry.expect("entry is readable").path();
        if path.is_dir() {
            collect(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
    found.sort();
}

/// Drops comments, the text of strings, and inline test modules (from `#[cfg(test)]` before `mod` with a body to its end).
fn code_of(text: &str) -> String {
    let mut code = String::new();
    let mut lines = text.lines().peekable();
    while let Some(line) = lines.next() {
        if line == "#[cfg(test)]" && lines.peek().is_some_and(|next| next.contains("mod ") && next.ends_with('{')) {
            // rustfmt ends a module of the file's level with a brace in the first column
            lines.find(|line| *line == "}");
            continue;
        }
        code.push_str(&without_scope(&without_strings_and_comments(line)));
        code.push('\n');
    }
    code
}

/// Drops the module within which an item is visible, which is no use of that module.
fn without_scope(line: &str) -> String {
    let scope = line.split_once("pub(in ").and_then(|(before, rest)| Some((before, rest.split_once(')')?.1)));
    scope.map_or(line.into(), |(before, after)| format!("{before}pub{after}"))
}

fn without_strings_and_comments(line: &str) -> String {
    let mut kept = String::new();
    let mut in_string = false;
    let mut before = ' ';
    for c in line.chars() {
        if c == '"' && before != '\\' && before != '\'' {
            in_string = !in_string;
        } else if !in_string {
            if c == '/' && before == '/' {
                kept.pop();
                break;
            }
            kept.push(c);
        }
        before = if before == '\\' { ' ' } else { c };
    }
    kept
}

/// Every path of code that starts with `root`, such as `crate::a::b`, groups in braces taken apart.
fn paths(code: &str, root: &str) -> BTreeSet<String> {
    let start = format!("{root}::");
    // `std::read::x` is no path that starts with `read`
    let is_whole = |at: usize| !code[..at].chars().next_back().is_some_and(|c| is_word(c) || [':', '$'].contains(&c));
    let starts = code.match_indices(&start).filter(|(at, _)| is_whole(*at));
    let mut found = BTreeSet::new();
    for (at, _) in starts {
        expand(&start, &mut code[at + start.len()..].chars().peekable(), &mut found);
    }
    found
}

/// Reads `a::b`, `a::*` or `{a, b::{self, c}}` and adds every full path to `found`.
fn expand(prefix: &str, rest: &mut Peekable<Chars>, found: &mut BTreeSet<String>) {
    let skip_space = |rest: &mut Peekable<Chars>| while rest.next_if(|c| c.is_whitespace()).is_some() {};
    skip_space(rest);
    if rest.next_if_eq(&'{').is_some() {
        loop {
            expand(prefix, rest, found);
            // past `as name` to the comma or the end of the group
            while rest.next_if(|&c| c != ',' && c != '}').is_some() {}
            if rest.next() != Some(',') {
                return;
            }
        }
    }
    let mut path = prefix.to_string();
    if rest.next_if_eq(&'*').is_some() {
        path.push('*');
    }
    while let Some(c) = rest.next_if(|&c| is_word(c)) {
        path.push(c);
    }
    if rest.next_if_eq(&':').is_some() && rest.next_if_eq(&':').is_some() {
        expand(&format!("{path}::"), rest, found);
    } else if path != prefix {
        found.insert(path.strip_suffix("::self").map_or(path.clone(), str::to_string));
    }
}

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// Whether code names a word or macro, or a path of `crate` or `std` or below it.
fn names(code: &str, word: &str) -> bool {
    if let Some((root @ ("crate" | "std"), _)) = word.split_once("::") {
        return paths(code, root).iter().any(|path| *path == word || path.starts_with(&format!("{word}::")));
    }
    code.match_indices(word).any(|(at, found)| {
        let before = code[..at].chars().next_back();
        let after = code[at + found.len()..].chars().next();
        !before.is_some_and(is_word) && (word.ends_with('!') || !after.is_some_and(is_word))
    })
}

/// The module of a path in parts, such as `grid::frame` of `grid`, `frame`, `ranks`.
fn module_of<'a>(mut parts: impl Iterator<Item = &'a str>) -> String {
    let first = parts.next().unwrap_or_default();
    let has_modules = GROUPS.iter().any(|(group, modules)| *group == first && !modules.is_empty());
    parts.next().filter(|_| has_modules).map_or(first.into(), |module| format!("{first}::{module}"))
}

/// Place of a module in the order of all modules.
fn place(module: &str) -> Option<usize> {
    let of_group = |(group, modules): &(&str, &[&str])| match modules {
        [] => vec![group.to_string()],
        _ => modules.iter().map(|module| format!("{group}::{module}")).collect(),
    };
    GROUPS.iter().flat_map(of_group).position(|known| known == module)
}

/// Every breach of the order by one file.
fn breaches(source: &Source) -> Vec<String> {
    let Source { name, module, code } = source;
    let Some(own) = place(module) else {
        return vec![format!("{name} has no place in the layers: add `{module}` to the table of this test")];
    };
    let mut found = Vec::new();
    let modules: BTreeSet<String> =
        paths(code, "crate").iter().map(|path| module_of(path.split("::").skip(1))).collect();
    for used in modules {
        if module == "bin" && COMMAND.iter().any(|folder| used.split("::").next() == Some(folder)) {
            continue;
        }
        // the crate's root re-exports its error
        let used = if ["Error", "Result"].contains(&used.as_str()) { "base::error".into() } else { used };
        match place(&used) {
            Some(place) if place <= own && !(module == "bin" && used == "web") => {}
            Some(_) => found.push(format!("{name} uses `{used}`, which comes after `{module}`")),
            None => found.push(format!("{name} uses `crate::{used}`, which has no place in the layers")),
        }
    }
    let is_first_of_module = name.trim_end_matches(".rs").replace('/', "::") == *module;
    if is_first_of_module && names(code, "super") {
        found.push(format!("{name} uses `super`: say `crate`, so that the order can be read"));
    }
    let unknown = match module.as_str() {
        "gpu" => UNKNOWN_TO_GPU,
        "meshing::pipeline" | "meshing::converge" | "meshing::refine" => UNKNOWN_TO_PIPELINE,
        // they read files, as their callers would
        "meshing::machine" | "meshing::files" | "meshing::mesher" => UNKNOWN_TO_MESHER,
        "web" | "bin" | "testing" | "derived::testing" => &[],
        _ => UNKNOWN_TO_CORE,
    };
    let unknown = unknown.iter().filter(|word| !KNOWN_TO.contains(&(module, word)));
    found.extend(unknown.filter(|word| names(code, word)).map(|word| format!("{name} names `{word}`")));
    found
}

#[test]
fn every_file_uses_earlier_layers_only() {
    let sources = sources();
    assert!(sources.len() >= 15, "{} files found", sources.len());
    let found: Vec<String> =
        sources.iter().filter(|s| !["lib", "derived", "files"].contains(&&s.module[..])).flat_map(breaches).collect();
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn the_roots_of_crates_only_list_modules() {
    for (folder, _) in CRATES.iter().filter(|(_, name)| *name != "gpu") {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder).join("lib.rs");
        let code = code_of(&std::fs::read_to_string(&path).expect("a crate has a root"));
        // of a list of names that are passed on, the first line says what it is
        let mut is_in_list = false;
        for line in code.lines().map(str::trim).filter(|line| !line.is_empty()) {
            let starts = ["pub mod ", "pub use ", "#[cfg(", "#![", "#[doc", "}"];
            assert!(is_in_list || starts.iter().any(|start| line.starts_with(start)), "{folder}/lib.rs: {line}");
            is_in_list = (is_in_list || line.starts_with("pub use ")) && !line.ends_with(';');
        }
    }
}

#[test]
fn breaches_are_found() {
    let breaches_of = |name: &str, text: &str| breaches(&Source::new(name, text));
    let table = [
        ("grid/lines.rs", "use crate::grid::frame::Frame;", 1),
        ("grid/frame.rs", "use crate::grid::lines::Lines;", 0),
        ("grid/frame.rs", "use crate::{base::error::{Error, Result}, stages::map::Rule, grid::lines};", 1),
        (
            "grid/frame.rs",
            "// use crate::stages::map::Rule;\nlet text = \"crate::stages::map\"; // crate::stages::map",
            0,
        ),
        ("grid/frame.rs", "let x = 1;\n#[cfg(test)]\nmod tests {\n    use crate::stages::map;\n}\n", 0),
        (
            "grid/frame.rs",
            "#[cfg(test)]\nmod tests {\n    use crate::grid::lines;\n}\nfn f() { crate::stages::map::map() }",
            1,
        ),
        ("grid/frame.rs", "fn f(r: super::map::Rule) {}", 1),
        ("input/read/obj.rs", "use std::{io::{self, Read}, fs::File as F};", 1),
        ("input/read/obj.rs", "use super::sniff; use crate::Result; println!(\"x\");", 1),
        ("stages/map.rs", "let t = std::time::Instant::now();", 2),
        ("stages/map.rs", "use std::{cell::Cell, fmt}; fn fsx() { pretty_println!() }", 0),
        ("gpu/line.rs", "use crate::cells::columns::Columns; use crate::stages::map::Rule;", 0),
        (
            "gpu/line.rs",
            "use crate::stages::map::{Rule, map}; use crate::{stages::cpu::columns, grid::frame::Frame};",
            2,
        ),
        ("gpu/line.rs", "use crate::meshing::pipeline::Job;", 1),
        ("files/write.rs", "use crate::gpu::Device;", 1),
        ("bin/hexcast/main.rs", "use clap::Parser; use crate::web::Page;", 1),
        ("grid/helpers.rs", "", 1),
        ("helpers.rs", "", 1),
        ("stages/cpu.rs", "use crate::base::helpers::x;", 1),
    ];
    for (name, text, n_breaches) in table {
        assert_eq!(breaches_of(name, text).len(), n_breaches, "{name}: {text}: {:?}", breaches_of(name, text));
    }
}
