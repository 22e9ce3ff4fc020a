//! Parts of a mesh, as processes make them one by one: together they are the whole, and cost about the same.

use super::cli::{Folder, SPOT, hexcast, json};

fn numbers<const N: usize>(value: &serde_json::Value) -> [usize; N] {
    let list = value.as_array().expect("a list");
    assert_eq!(list.len(), N);
    std::array::from_fn(|index| list[index].as_u64().expect("a number") as usize)
}

#[test]
fn parts_together_are_the_whole() {
    let folder = Folder::new();
    let arguments = ["--cells", "40", "--padding-cells", "2", "--backend", "cpu"];
    let whole = folder.path("whole.raw");
    let report = json(&[&["mesh", SPOT, "-o", &whole, "--json"], &arguments[..]].concat());
    let [nx, ny, nz] = numbers::<3>(&report["dims"]);
    let expected = folder.bytes("whole.raw");
    for of in ["5", "2x3x2"] {
        let parts = json(&[&["parts", SPOT, "--n", of], &arguments[..]].concat());
        assert_eq!(numbers::<3>(&parts["dims"]), [nx, ny, nz]);
        let parts = parts["parts"].as_array().expect("a list").clone();
        assert_eq!(parts.len(), if of == "5" { 5 } else { 12 });
        let mut together = vec![u8::MAX; nx * ny * nz];
        for part in parts {
            let output = folder.path("part.raw");
            let name = part["part"].as_str().expect("a text");
            let report = json(&[&["mesh", SPOT, "--part", name, "-o", &output, "--json"], &arguments[..]].concat());
            let [i0, j0, k0, i1, j1, k1] = numbers::<6>(&part["window"]);
            assert_eq!(numbers::<3>(&report["window"]["first"]), [i0, j0, k0]);
            assert_eq!(numbers::<3>(&report["window"]["of"]), [nx, ny, nz]);
            assert_eq!(report["cells"], part["cells"]);
            let mut flags = folder.bytes("part.raw").into_iter();
            for k in k0..k1 {
                for j in j0..j1 {
                    for i in i0..i1 {
                        let flag = &mut together[(k * ny + j) * nx + i];
                        assert_eq!(*flag, u8::MAX, "two parts have cell {i}, {j}, {k}");
                        *flag = flags.next().expect("a byte a cell");
                    }
                }
            }
        }
        assert!(together == expected, "{of} parts");
    }
}

#[test]
fn wrong_parts_are_refused_with_what_would_do() {
    let refused = |arguments: &[&str], code: i32, words: &str| {
        let output = hexcast(arguments);
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(code) && error.contains(words), "{arguments:?}: {error}");
    };
    refused(&["mesh", SPOT, "--part", "5/4"], 2, "such as 3/64 or 3/4x4x4");
    refused(&["mesh", SPOT, "--part", "1/4", "--window", "0,0,0,1,1,1"], 2, "cannot be used with");
    refused(&["mesh", SPOT, "--cells", "10", "--part", "1/99"], 4, "99 parts along z, which has 10 cells");
    refused(&["mesh", SPOT, "--part", "1/4", "--close-gaps", "3"], 4, "close_gaps and part are given together");
    refused(&["parts", SPOT, "--n", "0"], 2, "a number such as 64");
    refused(&["parts", SPOT, "--n", "4", "--part", "1/4"], 4, "divides whole meshes");
}
