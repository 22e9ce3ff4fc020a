//! The golden files: what every case of the table gives, in one short text a case, on every backend.
//!
//! `tests/golden/NAME.txt` is compared as a whole with what the CPU, a GPU, the browser's CPU and the browser's GPU make of
//! case NAME. `HEXCAST_BLESS=1 cargo test --test native golden_cpu` writes them anew, with the CPU definition; read the
//! difference before you commit it. It refuses where `CI` is set.

use std::fmt::Write as _;

use hexcast::columns::Columns;
use hexcast_core::cells::flags::flags_of_box;
use sha2::{Digest, Sha256};

use super::cases::Case;

#[path = "../golden/files.rs"]
mod files;

/// Names of the cases that have a file and what the file holds, in the order of the table.
pub(crate) use files::FILES;

/// What a golden file says: cells and volume a flag, odd rays and the hash of all flags, once for all axes that agree.
pub(crate) fn text(case: &Case, along: &[Columns; 3]) -> String {
    let results = along.each_ref().map(|columns| result(case, columns));
    let mut text = format!("{}: {}\n", case.name, case.why);
    let [nx, ny, nz] = case.lines.dims();
    let _ = writeln!(text, "dims {nx} {ny} {nz}, {} facets, {:?}", case.n_facets(), case.rule);
    for (axis, found) in results.iter().enumerate() {
        if results[..axis].contains(found) {
            continue;
        }
        let same: Vec<&str> = (axis..3).filter(|&other| results[other] == *found).map(|i| ["x", "y", "z"][i]).collect();
        let _ = write!(text, "\nrays along {}\n{found}", same.join(", "));
    }
    text
}

/// The part of a file for rays along one axis.
fn result(case: &Case, columns: &Columns) -> String {
    let mut text = String::new();
    for (flag, &n) in columns.cells_per_flag().iter().enumerate().filter(|&(_, &n)| n > 0) {
        let _ = writeln!(text, "flag {flag}: {n} cells, volume {:?}", n as f64 * case.lines.cell_volume().unwrap());
    }
    let _ = writeln!(text, "odd rays {}", columns.odd_rays());
    let hash = Sha256::digest(flags_of_box(columns, &columns.dims().map(|n| 0..n)).expect("columns in memory"));
    let hex: String = hash.iter().map(|byte| format!("{byte:02x}")).collect();
    let _ = writeln!(text, "sha256 {hex}");
    text
}

/// Holds a case, meshed along x, y and z, to its file.
#[track_caller]
pub(crate) fn assert_golden(case: &Case, along: &[Columns; 3]) {
    let expected = FILES.iter().find(|(name, _)| *name == case.name).map_or("no file", |(_, text)| text);
    let found = text(case, along);
    assert!(found == expected, "{} differs from its golden file:\n{expected}\nfound:\n{found}", case.name);
}

/// The cases in the order of the table are the files in theirs: none lacks the other.
pub(crate) fn assert_complete(cases: &[Case]) {
    let names: Vec<&str> = cases.iter().map(|case| case.name.as_str()).collect();
    let files: Vec<&str> = FILES.iter().map(|(name, _)| *name).collect();
    assert_eq!(names, files, "HEXCAST_BLESS=1 cargo test --test native golden_cpu writes the files");
}
