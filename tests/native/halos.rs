//! Halos of windows: the cells of the whole mesh around a window, and beyond the box background or the nearest of its cells.

use super::cli::{Folder, SPOT, hexcast, json};

#[test]
fn a_halo_has_the_cells_of_the_whole_and_background_or_the_nearest_beyond_it() {
    let folder = Folder::new();
    let open = "tests/fixtures/featuretype.stl";
    for (model, axis) in [(SPOT, "x"), (open, "y"), (SPOT, "z")] {
        let arguments = ["--cells", "40", "--backend", "cpu", "--axis", axis, "--invert"];
        let whole = folder.path("whole.raw");
        let report = json(&[&["mesh", model, "-o", &whole, "--json"], &arguments[..]].concat());
        let dims: Vec<i64> = report["dims"].as_array().unwrap().iter().map(|n| n.as_i64().unwrap()).collect();
        let flags = folder.bytes("whole.raw");
        let all = [0, 0, 0, dims[0], dims[1], dims[2]];
        let inside = [5, 2, 3, 9, dims[1] - 1, dims[2] - 2];
        for (window, halo) in [(all, 2i64), (inside, 3), ([0, 3, 5, 4, dims[1], 9], 4), (inside, 0)] {
            let (output, text) = (folder.path("part.raw"), window.map(|cell| cell.to_string()).join(","));
            let halo_text = halo.to_string();
            for edge in [None, Some("background"), Some("clamp")] {
                let words = ["mesh", model, "--window", &text, "--halo", &halo_text, "-o", &output, "--json"];
                let edge_words: Vec<&str> = edge.into_iter().flat_map(|edge| ["--halo-edge", edge]).collect();
                let report = json(&[&words, &edge_words[..], &arguments[..]].concat());
                assert_eq!(report["job"]["halo_edge"], edge.unwrap_or("background"));
                let [first, end] = [0, 3].map(|at| [0, 1, 2].map(|axis| window[at + axis]));
                assert_eq!((&report["window"]["first"], &report["window"]["end"]), (&first.into(), &end.into()));
                assert_eq!(report["window"]["halo"], halo);
                let found = folder.bytes("part.raw");
                let mut next = found.iter();
                let along = |axis: usize| first[axis] - halo..end[axis] + halo;
                for (k, j) in along(2).flat_map(|k| along(1).map(move |j| (k, j))) {
                    for i in along(0) {
                        let is_inside = [i, j, k].iter().zip(&dims).all(|(cell, n)| (0..*n).contains(cell));
                        let nearest = [i, j, k]
                            .iter()
                            .zip(&dims)
                            .map(|(cell, n)| *cell.clamp(&0, &(n - 1)))
                            .collect::<Vec<i64>>();
                        let of_nearest = flags[((nearest[2] * dims[1] + nearest[1]) * dims[0] + nearest[0]) as usize];
                        let expected = if is_inside || edge == Some("clamp") { of_nearest } else { 0 };
                        assert_eq!(
                            next.next(),
                            Some(&expected),
                            "{model}, axis {axis}, {text}, halo {halo}, {edge:?}: {i}, {j}, {k}"
                        );
                    }
                }
                assert_eq!(next.next(), None);
                let spacing = report["spacing"][0].as_f64().unwrap();
                let box_of = report["window"]["origin"][0].as_f64().unwrap();
                let expected = box_of + (first[0] - halo) as f64 * spacing;
                assert_eq!(report["origin"][0].as_f64(), Some(expected));
            }
        }
    }
}

#[test]
fn halos_that_go_around_nothing_are_refused() {
    for (arguments, words) in [
        (&["--halo", "1"][..], "without window or part"),
        (&["--halo-edge", "clamp", "--window", "0,0,0,1,1,1"], "halo_edge is given without halo"),
        (&["--halo", "70000", "--window", "0,0,0,1,1,1"], "0 to 65535"),
    ] {
        let output = hexcast(&[&["mesh", SPOT, "--cells", "9"], arguments].concat());
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(4) && error.contains(words), "{error}");
    }
}
