//! What an output cannot do is said before the mesh is made.

use super::cli::{Folder, SPOT, hexcast};

/// Corners of a triangle: the mesh itself is refused, but only after all outputs were looked at.
const OPEN: &str = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 1\nendloop\nendfacet\nendsolid a\n";

#[test]
fn what_an_output_cannot_do_is_said_before_the_mesh_is_made() {
    let folder = Folder::new();
    let (open, path) = (folder.path("open.stl"), |name: &str| folder.path(name));
    std::fs::write(&open, OPEN).unwrap();
    let mesh = ["mesh", &open, "--backend", "cpu", "--open", "error"];
    let failed = |arguments: &[&str]| {
        let output = hexcast(&[&mesh[..], arguments].concat());
        assert!(!output.status.success(), "{arguments:?}");
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    let small = ["--cells", "8"];
    assert!(failed(&small).contains("error[surface-open]"));
    let (raw, zip, foam) = (path("a.raw"), path("a.zarr.zip"), path("a.foam"));
    let odd_shards = ["--zarr-chunks", "4,4,4", "--zarr-shards", "6,8,8"];
    // with the halo there are 10 cells on each axis, and chunks may have as many
    let halo = ["--dims", "8,8,8", "--window", "0,0,0,8,8,8", "--halo", "1"];
    let wide_chunks = ["--zarr-chunks", "16,16,16", "--zarr-shards", "8,8,8"];
    let huge = ["--dims", "9000,9000,262142", "--max-cells", "1e15", "--compress=none"];
    let table: &[(&[&[&str]], &str)] = &[
        (&[&small, &["--bits", "--axis-order", "xyz", "-o", &raw]], "bits are given with an axis order or a map"),
        (&[&small, &["--bits", "--map", "1=2", "-o", &raw]], "bits are given with an axis order or a map"),
        (&[&small, &odd_shards, &["--fractions", &path("f.zarr")]], "shards of 6 cells along x are not a multiple"),
        (&[&small, &odd_shards, &["--fractions", &zip]], "shards of 6 cells along x are not a multiple"),
        (&[&halo, &wide_chunks, &["-o", &zip]], "shards of 8 cells along x are not a multiple of the chunks, 10"),
        (
            &[&halo, &wide_chunks, &["-o", &path("a.zarr")]],
            "shards of 8 cells along x are not a multiple of the chunks, 10",
        ),
        (
            &[&small, &["--unit", "m", "--patches", "side", "--open-patches", "inlet", "-o", &foam]],
            "the patch \"inlet\" is to be open, and patches do not have the names of solids",
        ),
        (
            &[&small, &["--unit", "m", "--patches", "solid", "--open-patches", "inlet", "-o", &foam]],
            "there is no patch \"inlet\" to be open; those of solids are ",
        ),
        #[cfg(unix)]
        (&[&huge[..4], &["-o", &raw]], "a.raw takes 21233502000000 bytes at least, and the disk has "),
        #[cfg(unix)]
        (&[&huge, &["-o", &path("a.nrrd")]], "a.nrrd takes 21233502000000 bytes at least, and the disk has "),
        #[cfg(unix)]
        (
            &[&huge, &["-o", &path("a.npy"), "-o", &path("a.vtr")]],
            " take 42467004000000 bytes at least, and the disk has ",
        ),
    ];
    for (arguments, says) in table {
        let said = failed(&arguments.concat());
        assert!(said.contains(says), "{arguments:?}: {said}");
        assert_eq!(folder.names(), ["open.stl"], "{arguments:?}");
    }
    // a picture and a store of another mesh
    let said =
        failed(&[&small[..], &["--view", &format!("{}:size=9000", path("a.png")), "--max-memory", "90MB"]].concat());
    assert!(said.contains("a view of 9000 x 9000 pixels takes "), "{said}");
    let (store, shards) = (path("b.zarr"), ["--zarr-chunks", "4,4,4", "--zarr-shards", "8,8,4", "--part", "1/2"]);
    let common = [&small[..], &shards, &["-o", &store]].concat();
    let begun = hexcast(&[&["mesh", SPOT, "--backend", "cpu"], &common[..]].concat());
    assert!(begun.status.success(), "{begun:?}");
    let said = failed(&common);
    assert!(said.contains("b.zarr: the store is that of another mesh: zarr.json differs"), "{said}");
}
