//! The header is that of the functions.
//!
//! After a change write it with `HEXCAST_BLESS=1 cargo test -p hexcast-c`, which is refused where `CI` is set.

use std::path::Path;

#[test]
fn the_header_is_that_of_the_functions() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config = cbindgen::Config::from_file(root.join("cbindgen.toml")).expect("cbindgen.toml is sound");
    // its modules follow
    let builder = cbindgen::Builder::new().with_config(config).with_src(root.join("src/lib.rs"));
    let mut made = Vec::new();
    builder.generate().expect("the source is sound").write(&mut made);
    let made = String::from_utf8(made).expect("cbindgen writes UTF-8");
    let path = root.join("include/hexcast.h");
    if std::env::var_os("HEXCAST_BLESS").is_some() {
        assert!(std::env::var_os("CI").is_none(), "CI must not write what it checks");
        std::fs::write(&path, &made).expect("the header can be written");
    }
    let committed = std::fs::read_to_string(&path).expect("include/hexcast.h is there");
    assert_eq!(committed.lines().collect::<Vec<_>>(), made.lines().collect::<Vec<_>>());
    for function in ["hexcast_version(", "hexcast_mesh(", "hexcast_mesh_fill_box(", "hexcast_error_free("] {
        assert_eq!(committed.matches(function).count(), 1, "{function} is declared once");
    }
}
