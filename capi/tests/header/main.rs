//! The header is that of the functions, and the module for Fortran that of the header.
//!
//! After a change write both with `HEXCAST_BLESS=1 cargo test -p hexcast-c`, which is refused where `CI` is set.

mod fortran;

use std::path::Path;

/// What the header has besides functions and structs. Its version is that of the crate.
fn macros() -> String {
    let version = env!("CARGO_PKG_VERSION");
    let [major, minor, patch] =
        [env!("CARGO_PKG_VERSION_MAJOR"), env!("CARGO_PKG_VERSION_MINOR"), env!("CARGO_PKG_VERSION_PATCH")];
    format!(
        r#"
// The version of this header; hexcast_version() is that of the library.
#define HEXCAST_VERSION_MAJOR {major}
#define HEXCAST_VERSION_MINOR {minor}
#define HEXCAST_VERSION_PATCH {patch}
#define HEXCAST_VERSION_STRING "{version}"

// The first cell, and the flag, of a run of hexcast_mesh_runs.
#define HEXCAST_RUN_FIRST(run) ((run) >> 8)
#define HEXCAST_RUN_FLAG(run) ((run) & 0xffu)"#
    )
}

fn made_header() -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut config = cbindgen::Config::from_file(root.join("cbindgen.toml")).expect("cbindgen.toml is sound");
    config.after_includes = Some(macros());
    // its modules follow
    let builder = cbindgen::Builder::new().with_config(config).with_src(root.join("src/lib.rs"));
    let mut made = Vec::new();
    builder.generate().expect("the source is sound").write(&mut made);
    String::from_utf8(made).expect("cbindgen writes UTF-8")
}

/// Compares a committed file with what is made, and returns it.
fn committed(file: &str, made: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(file);
    if std::env::var_os("HEXCAST_BLESS").is_some() {
        assert!(std::env::var_os("CI").is_none(), "CI must not write what it checks");
        std::fs::write(&path, made).expect("the file can be written");
    }
    let committed = std::fs::read_to_string(&path).expect("the file is there");
    assert_eq!(committed.lines().collect::<Vec<_>>(), made.lines().collect::<Vec<_>>(), "{file}");
    committed
}

#[test]
fn the_header_is_that_of_the_functions() {
    let header = committed("include/hexcast.h", &made_header());
    let declared = fortran::functions(&header);
    for function in ["hexcast_version", "hexcast_mesh", "hexcast_mesh_fill_box", "hexcast_error_free"] {
        assert_eq!(declared.iter().filter(|(_, name)| *name == function).count(), 1, "{function} is declared once");
    }
}

#[test]
fn the_fortran_module_is_that_of_the_header() {
    let header = made_header();
    let module = committed("fortran/hexcast.f90", &fortran::module(&header));
    // found in another way
    let n_functions =
        header.matches("**error);").count() + header.matches("(const struct HexcastError *error);").count();
    let n_others = [
        "version(void)",
        "error_free(",
        "mesh_free(",
        "mesher_free(",
        "mesh_doubt(",
        "mesh_lacks(",
        "mesh_report(",
        "scene_free(",
        "scene_told(",
    ];
    let n_functions =
        n_functions + n_others.iter().map(|of| header.matches(&format!("hexcast_{of}")).count()).sum::<usize>();
    assert_eq!(module.matches("bind(c, name='hexcast_").count(), n_functions);
    assert!(module.lines().all(|line| line.len() <= 132), "lines of Fortran end at 132");
}
