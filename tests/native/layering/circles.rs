//! Circles of imports between the files of `src/`: none.
//!
//! Every file is a node. It has an edge to each file that defines an item which its code names through `crate::`, `super::`,
//! `self::` or one of its own modules. `mod x;` and a `pub use x::..` of items that the file itself does not use are listings,
//! not edges. An item that a file only passes on is followed to the file that defines it. Calls of methods are not seen.

use std::collections::{BTreeMap, BTreeSet};

use super::{Source, is_word, names, paths, sources};

/// A file's module path, such as `["crate", "read", "sniff"]`; the command line is a crate of its own.
fn module_path(name: &str) -> Vec<String> {
    let bare = name.trim_end_matches(".rs");
    let (root, rest) = match bare.strip_prefix("bin/hexcast/") {
        Some(rest) => ("bin", rest),
        None => ("crate", bare),
    };
    let rest = if ["lib", "main"].contains(&rest) { "" } else { rest };
    std::iter::once(root).chain(rest.split('/').filter(|part| !part.is_empty())).map(str::to_string).collect()
}

/// The files by module path, and what each says about others.
struct Graph<'a> {
    files: BTreeMap<Vec<String>, &'a Source>,
}

impl<'a> Graph<'a> {
    fn new(sources: &'a [Source]) -> Graph<'a> {
        Graph { files: sources.iter().map(|source| (module_path(&source.name), source)).collect() }
    }

    /// Every path that a file names, as a path from its crate's root.
    fn named(&self, module: &[String], code: &str) -> BTreeSet<Vec<String>> {
        let absolute = |start: &[String], path: &str, n_skipped: usize| {
            let rest = path.split("::").skip(n_skipped).map(str::to_string);
            start.iter().cloned().chain(rest).collect::<Vec<String>>()
        };
        let mut found = BTreeSet::new();
        found.extend(paths(code, "crate").iter().map(|path| absolute(&module[..1], path, 1)));
        found.extend(paths(code, "self").iter().map(|path| absolute(module, path, 1)));
        for path in paths(code, "super") {
            let n_up = path.split("::").take_while(|part| *part == "super").count();
            assert!(n_up < module.len(), "{module:?} names {path}");
            found.insert(absolute(&module[..module.len() - n_up], &path, n_up));
        }
        // modules of the file, and at the root groups
        let below = self.files.keys().filter(|other| other.len() > module.len() && other.starts_with(module));
        for child in below.map(|other| &other[module.len()]).collect::<BTreeSet<_>>() {
            found.extend(paths(code, child).iter().map(|path| absolute(module, path, 0)));
        }
        found
    }

    /// The file that defines what a path names, past the files that only pass it on.
    fn definer(&self, path: &[String], n_left: usize) -> Option<&'a Source> {
        let n_module = (1..=path.len()).rev().find(|&n| self.files.contains_key(&path[..n]))?;
        let (module, item) = path.split_at(n_module);
        let file = self.files[module];
        let passed_on = item.first().filter(|_| n_left > 0).and_then(|item| {
            let named = self.named(module, &uses(&file.code));
            named.into_iter().find(|other| other.last() == Some(item) && other[..] != *path)
        });
        match passed_on {
            Some(other) => self.definer(&[&other[..], &item[1..]].concat(), n_left - 1),
            None => Some(file),
        }
    }

    /// The files that a file uses.
    fn used_by(&self, source: &Source) -> BTreeSet<&'a str> {
        let module = module_path(&source.name);
        let body = body(&source.code);
        let private = self.named(&module, &format!("{}\n{body}", statements(&source.code, "use ")));
        let listed = self.named(&module, &public_uses(&source.code));
        let listed = listed.into_iter().filter(|path| path.last().is_some_and(|item| names(&body, item)));
        let used = private.into_iter().chain(listed).filter_map(|path| self.definer(&path, 8));
        used.map(|used| used.name.as_str()).filter(|used| *used != source.name).collect()
    }
}

/// The statements of a file that begin with a keyword, at the beginning of a line.
fn statements(code: &str, keyword: &str) -> String {
    split(code, |statement| statement.starts_with(keyword)).0
}

fn is_public_use(statement: &str) -> bool {
    statement.starts_with("pub")
        && statement.split_once("use ").is_some_and(|(before, _)| !before.contains(';'))
        && statement.split_whitespace().nth(1) == Some("use")
}

fn public_uses(code: &str) -> String {
    split(code, is_public_use).0
}

/// All `use` statements of a file.
fn uses(code: &str) -> String {
    split(code, |statement| statement.starts_with("use ") || is_public_use(statement)).0
}

/// The code without `use` and `mod` statements.
fn body(code: &str) -> String {
    let is_listing = |statement: &str| {
        let rest = statement.strip_prefix("pub(crate) ").or(statement.strip_prefix("pub ")).unwrap_or(statement);
        rest.starts_with("use ") || rest.starts_with("mod ") && rest.ends_with(';') || is_public_use(statement)
    };
    split(code, is_listing).1
}

/// Takes statements that begin in the first column apart: those that fit, and all else.
fn split(code: &str, fits: impl Fn(&str) -> bool) -> (String, String) {
    let (mut taken, mut rest) = (String::new(), String::new());
    let mut lines = code.lines();
    while let Some(line) = lines.next() {
        let mut statement = line.to_string();
        if statement.starts_with("use ") || is_public_use(line) {
            while !statement.trim_end().ends_with(';') {
                let Some(next) = lines.next() else { break };
                statement.push('\n');
                statement.push_str(next);
            }
        }
        let out = if fits(&statement) { &mut taken } else { &mut rest };
        out.push_str(&statement);
        out.push('\n');
    }
    (taken, rest)
}

/// Groups of files of which each uses every other, if only through the rest; sorted.
fn circles(sources: &[Source]) -> Vec<Vec<&str>> {
    let graph = Graph::new(sources);
    let mut edges = BTreeMap::new();
    for source in sources {
        edges.insert(source.name.as_str(), graph.used_by(source));
    }
    let reached: BTreeMap<&str, BTreeSet<&str>> = edges.keys().map(|name| (*name, reached(&edges, name))).collect();
    let mut circles = BTreeSet::new();
    for (name, others) in &reached {
        let circle: Vec<&str> = others.iter().copied().filter(|other| reached[other].contains(name)).collect();
        circles.extend((!circle.is_empty()).then_some(circle));
    }
    circles.into_iter().collect()
}

/// All that can be reached from a file, step by step.
fn reached<'a>(edges: &BTreeMap<&'a str, BTreeSet<&'a str>>, start: &str) -> BTreeSet<&'a str> {
    let (mut seen, mut open) = (BTreeSet::new(), vec![start]);
    while let Some(name) = open.pop() {
        for next in &edges[name] {
            if seen.insert(*next) {
                open.push(next);
            }
        }
    }
    seen
}

#[test]
fn no_files_import_each_other_in_a_circle() {
    let sources = sources();
    let circles: Vec<String> = circles(&sources).iter().map(|circle| circle.join(" - ")).collect();
    assert!(circles.is_empty(), "files that import each other in a circle:\n{}", circles.join("\n"));
}

#[test]
fn planted_circles_are_found() {
    // what it is; files and their text; circles in them
    type Case = (&'static str, &'static [(&'static str, &'static str)], usize);
    let table: &[Case] = &[
        (
            "two files of a folder",
            &[("a.rs", "mod b;\nmod c;"), ("a/b.rs", "use super::c::C;"), ("a/c.rs", "use super::b;")],
            1,
        ),
        ("one way only", &[("a.rs", "mod b;\nmod c;\nuse c::C;"), ("a/b.rs", ""), ("a/c.rs", "use super::b::B;")], 0),
        (
            "a parent that uses what its child makes of its items",
            &[("a.rs", "mod b;\nuse b::f;"), ("a/b.rs", "use super::A;")],
            1,
        ),
        (
            "a parent that names its child by a path",
            &[("a.rs", "mod b;\nfn g() { b::f() }"), ("a/b.rs", "fn f(a: super::A) {}")],
            1,
        ),
        ("a parent that only lists", &[("a.rs", "mod b;\npub use b::{B,\n    C};"), ("a/b.rs", "use super::A;")], 0),
        (
            "a parent that uses what it lists",
            &[("a.rs", "mod b;\npub(crate) use b::B;\nstruct A(B);"), ("a/b.rs", "use super::A;")],
            1,
        ),
        (
            "an item that the parent passes on from the other child",
            &[("a.rs", "mod b;\nmod c;\npub use c::C;\nuse b::f;"), ("a/b.rs", "use super::C;"), ("a/c.rs", "")],
            0,
        ),
        (
            "the same, which the other child needs",
            &[
                ("a.rs", "mod b;\nmod c;\npub use c::C;"),
                ("a/b.rs", "use super::C;"),
                ("a/c.rs", "use crate::a::b::f;"),
            ],
            1,
        ),
        (
            "three files, one through a group",
            &[
                ("a.rs", "mod b;\nmod c;\nmod d;"),
                ("a/b.rs", "use super::{A, c::{self, C}};"),
                ("a/c.rs", "fn f() { crate::a::d::g() }"),
                ("a/d.rs", "use super::b::*;"),
            ],
            1,
        ),
        (
            "two levels up",
            &[("a.rs", "mod b;\nuse b::B;"), ("a/b.rs", "mod c;"), ("a/b/c.rs", "use super::super::A;")],
            0,
        ),
        (
            "two levels up and down again",
            &[("a.rs", "mod b;\nfn f() { b::c::g() }"), ("a/b.rs", "pub mod c;"), ("a/b/c.rs", "use super::super::A;")],
            1,
        ),
        ("a folder that uses a later one", &[("a/x.rs", "use crate::b::B;"), ("b.rs", "use crate::a::x::X;")], 1),
        ("the scope of an item", &[("a.rs", "mod b;\nfn g() { b::f() }"), ("a/b.rs", "pub(in crate::a) fn f() {}")], 0),
        (
            "comments and tests",
            &[("a.rs", "mod b;\n// use b::B;"), ("a/b.rs", "#[cfg(test)]\nmod tests {\n    use super::*;\n}")],
            0,
        ),
        (
            "the command line",
            &[("bin/hexcast/main.rs", "mod b;\nfn main() { b::run() }"), ("bin/hexcast/b.rs", "use super::print;")],
            1,
        ),
    ];
    for (what, files, n_circles) in table {
        let sources: Vec<Source> = files.iter().map(|(name, text)| Source::new(name, text)).collect();
        let found = circles(&sources);
        assert_eq!(found.len(), *n_circles, "{what}: {found:?}");
    }
}

#[test]
fn words_of_paths_are_taken_apart() {
    let found = paths("use super::{a::*, b::{self, c}, D}; x::super_::y(); super::super::E", "super");
    let found: Vec<&str> = found.iter().map(String::as_str).collect();
    assert_eq!(found, ["super::D", "super::a::*", "super::b", "super::b::c", "super::super::E"]);
    assert!(is_word('_') && !is_word(':'));
}
