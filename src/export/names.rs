//! Names of flags that every program takes: letters, digits and `_`, a letter first, each once, whatever their case.

use crate::mesh::{Mesh, Named};

/// Name of flag 0 where the job does not say.
const BACKGROUND: &str = "background";

/// The name of each flag, at most `longest` characters (16 or more), and none of those taken.
pub(super) fn names(mesh: &Mesh, longest: usize, taken: &[&str]) -> Vec<String> {
    let mut seen: Vec<String> = taken.iter().map(|name| name.to_ascii_lowercase()).collect();
    let mut all = Vec::with_capacity(256);
    for flag in 0..=255u8 {
        let named = mesh.names.iter().find(|named| named.flag == flag).map(|named| named.name.as_str());
        let default = if flag == 0 { BACKGROUND.into() } else { format!("flag_{flag}") };
        let first = plain(named.unwrap_or(&default));
        let mut ending = String::new();
        let mut n = 0;
        let name = loop {
            let name = format!("{}{ending}", &first[..first.len().min(longest - ending.len())]);
            if !seen.contains(&name.to_ascii_lowercase()) {
                break name;
            }
            ending = if n == 0 { format!("_{flag}") } else { format!("_{flag}_{n}") };
            n += 1;
        };
        seen.push(name.to_ascii_lowercase());
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
