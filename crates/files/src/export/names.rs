//! Names of flags that every program takes: letters, digits and `_`, a letter first, each once, whatever their case.

use std::collections::BTreeSet;

use hexcast_derived::mesh::{Mesh, Named};

/// Name of flag 0 where the job does not say.
const BACKGROUND: &str = "background";

/// The name of each flag, at most `longest` characters (16 or more), and none of those taken.
pub(super) fn names(mesh: &Mesh, longest: usize, taken: &[&str]) -> Vec<String> {
    unique((0..=255u8).map(|flag| name(mesh, flag)), longest, taken)
}

/// The name of a flag as it is.
pub(super) fn name(mesh: &Mesh, flag: u8) -> String {
    let named = mesh.names().iter().find(|named| named.flag == flag).map(|named| named.name.clone());
    named.unwrap_or_else(|| if flag == 0 { BACKGROUND.into() } else { format!("flag_{flag}") })
}

/// Names that every program takes, each once: one that was there before gets its number, from 0.
pub(super) fn unique(wanted: impl IntoIterator<Item = String>, longest: usize, taken: &[&str]) -> Vec<String> {
    let mut seen: BTreeSet<String> = taken.iter().map(|name| name.to_ascii_lowercase()).collect();
    let mut all = Vec::new();
    for (number, wanted) in wanted.into_iter().enumerate() {
        let first = plain(&wanted);
        let mut ending = String::new();
        let mut n = 0;
        let name = loop {
            let name = format!("{}{ending}", &first[..first.len().min(longest - ending.len())]);
            if !seen.contains(&name.to_ascii_lowercase()) {
                break name;
            }
            ending = if n == 0 { format!("_{number}") } else { format!("_{number}_{n}") };
            n += 1;
        };
        seen.insert(name.to_ascii_lowercase());
        all.push(name);
    }
    all
}

/// A flag in a sentence, with its name if it has one.
pub(super) fn said(names: &[Named], flag: u8) -> String {
    let named = names.iter().find(|named| named.flag == flag);
    named.map_or(format!("flag {flag}"), |named| format!("flag {flag} (\"{}\")", named.name))
}

/// A name in ASCII: what is no letter, digit or `_` is `_`.
pub(super) fn plain(name: &str) -> String {
    let mut plain: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if !plain.starts_with(|c: char| c.is_ascii_alphabetic()) {
        plain.insert_str(0, "f_");
    }
    plain
}
