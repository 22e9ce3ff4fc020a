//! Puts into the shared library the name by which programs look for it: before 1.0 a minor version may change the interface, so
//! `libhexcast.so.0.1`. Windows has the name of the file.

use std::env::var;

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    let of = |name: &str| var(name).unwrap_or_default();
    let (major, minor) = (of("CARGO_PKG_VERSION_MAJOR"), of("CARGO_PKG_VERSION_MINOR"));
    let arguments = match of("CARGO_CFG_TARGET_OS").as_str() {
        "windows" => vec![],
        "macos" | "ios" => vec![
            format!("-Wl,-install_name,@rpath/libhexcast.{major}.{minor}.dylib"),
            format!("-Wl,-compatibility_version,{major}.{minor}"),
            format!("-Wl,-current_version,{}", of("CARGO_PKG_VERSION")),
        ],
        _ => vec![format!("-Wl,-soname,libhexcast.so.{major}.{minor}")],
    };
    for argument in arguments {
        println!("cargo:rustc-cdylib-link-arg={argument}");
    }
}
