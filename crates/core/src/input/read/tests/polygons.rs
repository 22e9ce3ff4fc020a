//! OBJ, OFF, PLY and gzip: the facets of the same model as STL, and what is wrong with files.

use std::io::Write;

use flate2::Compression;
use flate2::write::GzEncoder;

use super::*;

/// The corners of the tetrahedron and its polygons, by index.
const CORNERS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const INDICES: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

fn lines(items: impl IntoIterator<Item = String>) -> String {
    items.into_iter().map(|item| item + "\n").collect()
}

fn obj() -> String {
    let corners = lines(CORNERS.iter().map(|[x, y, z]| format!("v {x} {y} {z}")));
    let polygons = lines(INDICES.iter().map(|of| format!("f {}/1 {}//2 {}", of[0] + 1, of[1] + 1, of[2] as i64 - 4)));
    format!("# a remark\nmtllib none.mtl\n{corners}vn 0 0 1\no lid\n{polygons}")
}

fn off() -> String {
    let corners = lines(CORNERS.iter().map(|[x, y, z]| format!("{x} {y} {z} 255 0 0")));
    let polygons = lines(INDICES.iter().map(|[a, b, c]| format!("3 {a} {b} {c} 0.5")));
    format!("COFF\n# a remark\n4 4 6\n\n{corners}{polygons}")
}

fn ply_header(format: &str, float: &str) -> String {
    format!(
        "ply\nformat {format} 1.0\ncomment by hand\nelement vertex 4\nproperty {float} x\nproperty {float} y\nproperty uchar red\n\
         property {float} z\nelement face 4\nproperty list uchar int vertex_indices\nproperty list uint8 short more\nend_header\n"
    )
}

fn ply_text() -> String {
    let corners = lines(CORNERS.iter().map(|[x, y, z]| format!("{x} {y} 7 {z}")));
    let polygons = lines(INDICES.iter().map(|[a, b, c]| format!("3 {a} {b} {c} 2 5 6")));
    format!("{}{corners}{polygons}", ply_header("ascii", "float"))
}

fn ply_binary(is_big: bool) -> Vec<u8> {
    let mut bytes =
        ply_header(if is_big { "binary_big_endian" } else { "binary_little_endian" }, "double").into_bytes();
    let mut put = |number: &[u8]| {
        let mut number = number.to_vec();
        if is_big {
            number.reverse();
        }
        bytes.extend(number);
    };
    for [x, y, z] in CORNERS.map(|corner| corner.map(|number| f64::from(number).to_le_bytes())) {
        put(&x);
        put(&y);
        put(&[7]);
        put(&z);
    }
    for of in INDICES {
        put(&[3]);
        of.iter().for_each(|&index| put(&(index as i32).to_le_bytes()));
        put(&[2]);
        put(&5i16.to_le_bytes());
        put(&6i16.to_le_bytes());
    }
    bytes
}

fn packed(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

fn facets(contents: &Contents) -> Vec<Facet> {
    contents.solids.iter().flat_map(|solid| solid.facets.slice().iter().copied()).collect()
}

#[test]
fn every_format_has_the_facets_of_the_stl() {
    let expected = facets(&good(binary(&TETRAHEDRON)));
    let files: [(Vec<u8>, Format); 8] = [
        (obj().into(), Format::Obj),
        (obj().replace('\n', "\r\n").into(), Format::Obj),
        (off().into(), Format::Off),
        (ply_text().into(), Format::PlyAscii),
        (ply_binary(false), Format::PlyBinary),
        (ply_binary(true), Format::PlyBinary),
        (packed(&binary(&TETRAHEDRON)), Format::StlBinary),
        (packed(off().as_bytes()), Format::Off),
    ];
    for (file, format) in files {
        let contents = good(&file);
        assert_eq!((contents.format, contents.n_facets, contents.n_bytes), (format, 4, file.len() as u64));
        assert_eq!(facets(&contents), expected, "{format:?}");
        assert_eq!((contents.wrong_normals, contents.zero_normals, contents.zero_area), (0, 0, 0));
        assert!(contents.warnings.is_empty(), "{:?}", contents.warnings);
        // the slices that it comes in do not matter
        let mut reader = Reader::new(file.len() as u64);
        file.chunks(7).for_each(|chunk| reader.push(chunk).unwrap());
        assert_eq!(reader.finish().unwrap(), contents);
    }
}

#[test]
fn groups_and_objects_of_obj_are_solids() {
    let text =
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\no lid\ng lid top\nf 1 2 3\nf 1 2 \\\n3\ng\nf 3 2 1\ng lid top\nf 1 2 3\n";
    let contents = good(text);
    let solids: Vec<_> = contents.solids.iter().map(|solid| (solid.name.as_str(), solid.facets.len())).collect();
    assert_eq!(solids, [("", 1), ("lid top", 2), ("", 1), ("lid top", 1)]);
}

#[test]
fn polygons_are_fans_and_those_that_are_not_planar_are_counted() {
    let square = "OFF 4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n";
    let contents = good(square);
    let [a, b, c, d] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    assert_eq!((facets(&contents), contents.warnings.len()), (vec![[a, b, c], [a, c, d]], 0));
    let contents = good(square.replace("1 1 0", "1 1 0.1"));
    assert!(contents.warnings[0].contains("1 polygons of more than three corners are not planar, the first at line 6"));
    let two = square.replace("4 1 0", "4 2 0").replace("1 1 0", "1 1 0.1") + "4 3 2 1 0\n";
    assert!(good(&two).warnings[0].starts_with("2 polygons") && good(&two).warnings[0].contains("first at line 6:"));
    let contents = good("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2\nf 1 2 3\ncurv 0 1 1 2\nsurf 1\n");
    assert_eq!(contents.warnings.len(), 2, "{:?}", contents.warnings);
    assert!(
        contents.warnings[0].starts_with("2 statements that are not polygons are ignored, such as curv at line 6")
            && contents.warnings[1].starts_with("1 polygons of fewer")
    );
    // three corners on a line, whose middle f64 rounds: no area, and no polygon of more than three corners
    let contents = good("v 0.1 0.2 0.3\nv 0.2 0.4 0.6\nv 0.4 0.8 1.2\nv 1 0 0\nf 1 2 3\nf 1 2 4\n");
    assert_eq!((contents.n_facets, contents.zero_area, contents.warnings), (2, 1, vec![]));
}

#[test]
fn lists_of_a_ply_have_whole_numbers_of_values_and_elements_may_have_none() {
    let header = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                  element nothing 9\nelement face 2\nproperty list float int vertex_indices\nend_header\n";
    let corners = "0 0 0\n1 0 0\n0 1 0\n";
    let contents = good(format!("{header}{corners}3 0 1 2\n0\n"));
    assert_eq!(
        (contents.n_facets, contents.warnings),
        (1, vec!["1 polygons of fewer than three corners are left out".to_string()])
    );
    for n in ["-1", "1.5", "-0.5", "nan"] {
        let number: f64 = n.parse().unwrap();
        assert_bad(
            format!("{header}{corners}3 0 1 2\n{n} 0 0\n"),
            "file-syntax",
            &[&format!("line 15: a list of {number} values")],
        );
    }
    // words that one line has too many are not those that the next has too few
    let moved = format!("{header}0 0 0 5\n1 0\n0 1 0\n3 0 1 2\n0\n");
    assert_bad(moved, "file-syntax", &["line 12: a number is needed"]);
    let far = format!("{header}0 0 0\n1 1e99 0\n0 1 0\n3 0 1 2\n0\n");
    assert_bad(far, "stl-not-finite", &["line 12: a coordinate is inf"]);
    let twice = header.replacen("ply\n", "ply\nply\n", 1);
    assert_bad(twice, "file-syntax", &["line 2: no line of a header of PLY begins like this"]);
    for axis in ["x", "y", "z"] {
        let without = header.replace(&format!("float {axis}"), "float w");
        assert_bad(format!("{without}{corners}3 0 1 2\n0\n"), "file-syntax", &["no x, y and z"]);
    }
    // of the last list the first of two values begins four bytes before the end
    let whole = ply_binary(false);
    let place = format!("byte {}: the file ends before all elements", whole.len() - 4);
    assert_bad(&whole[..whole.len() - 3], "file-syntax", &[&place]);
}

#[test]
fn packed_files_may_be_longer_than_the_slices_they_are_unpacked_in() {
    let many: Vec<Facet> = TETRAHEDRON.iter().copied().cycle().take(45_000).collect();
    let contents = good(packed(&binary(&many)));
    assert_eq!((contents.n_facets, contents.format), (45_000, Format::StlBinary));
}

#[test]
fn what_is_wrong_is_named_with_its_place() {
    let wrong = |text: &str, from: &str, to: &str| text.replacen(from, to, 1);
    let cases: [(Vec<u8>, &str, &str); 23] = [
        (
            wrong(&obj(), "v 1 0 0", "v 1 x 0").into(),
            "file-syntax",
            "line 4: three coordinates are needed, in \"v 1 x 0\"",
        ),
        (wrong(&obj(), "v 1 0 0", "v 1 inf 0").into(), "stl-not-finite", "line 4"),
        (wrong(&obj(), "v 1 0 0", "v 1 1e99 0").into(), "stl-not-finite", "line 4"),
        ("v 0 0 0\nf 1 2 3\n".into(), "file-syntax", "line 2: there is no corner 2 of 1 so far"),
        ("v 0 0 0\nf 1 -2 1\n".into(), "file-syntax", "there is no corner -2 of 1"),
        ("v 0 0 0\nf 0 1 1\n".into(), "file-syntax", "there is no corner 0 of 1"),
        ("v 0 0 0\nv 1 1 1\n".into(), "stl-empty", "no facet among 2 corners of OBJ"),
        (wrong(&off(), "4 4 6", "4 5 6").into(), "file-syntax", "the file ends before 5 polygons"),
        (
            wrong(&off(), "4 4 6", "9999999999999 4 6").into(),
            "file-syntax",
            "the file ends before 9999999999999 corners",
        ),
        (wrong(&off(), "COFF", "4OFF").into(), "file-syntax", "line 1: corners of more or fewer"),
        (wrong(&obj(), "vn 0 0 1", "$n 0 0 1").into(), "file-syntax", "line 7: no statement of OBJ begins like this"),
        (wrong(&off(), "COFF", "STCN4OFF").into(), "file-syntax", "line 1: corners of more or fewer"),
        (wrong(&off(), "COFF", "STCNn4OFF").into(), "stl-not-stl", "text that begins with \"STCNn4OFF\""),
        (wrong(&off(), "COFF", "COFF BINARY").into(), "file-syntax", "line 1: binary OFF cannot be read"),
        (wrong(&off(), "3 0 1 3", "3 0 1 4").into(), "file-syntax", "line 10: there is no corner 4 of 4"),
        (wrong(&off(), "3 0 1 3 0.5", "3 0 1").into(), "file-syntax", "3 indices are announced, and 2 are there"),
        (
            wrong(&off(), "3 0 1 3", "4 0 1").into(),
            "file-syntax",
            "a polygon needs indices of corners, in \"4 0 1 0.5\"",
        ),
        (wrong(&ply_text(), "3 0 1 3", "3 0 1 4").into(), "file-syntax", "there is no corner 4 of 4"),
        (wrong(&ply_text(), "property float z", "property float w").into(), "file-syntax", "no x, y and z"),
        (wrong(&ply_text(), "ascii", "morse").into(), "file-syntax", "line 2: the format is neither"),
        (ply_binary(true)[..ply_binary(true).len() - 3].to_vec(), "file-syntax", "the file ends before all elements"),
        (packed(obj().as_bytes())[..60].to_vec(), "file-syntax", "packed by gzip"),
        (packed(&packed(obj().as_bytes())), "file-syntax", "twice"),
    ];
    for (index, (file, code, part)) in cases.into_iter().enumerate() {
        let (found, message) = bad(file);
        assert!(found == code && message.contains(part), "case {index}: {found}: {message}");
    }
}

#[test]
fn announced_numbers_take_no_memory() {
    let text = wrong_counts();
    let taken = allocation_counter::measure(|| assert_eq!(bad(&text).0, "file-syntax"));
    assert!(taken.bytes_max < 1 << 16, "{} bytes", taken.bytes_max);
}

fn wrong_counts() -> String {
    ply_text().replace("element vertex 4", "element vertex 4000000000")
}
