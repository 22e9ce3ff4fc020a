use super::*;
use crate::input::geometry::Facet;

mod ascii;
mod polygons;
mod scenes;

const TETRAHEDRON: [Facet; 4] = [
    [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]],
    [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
    [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]],
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
];
const OUTWARD: [[f32; 3]; 4] = [[0.0, 0.0, -1.0], [0.0, -1.0, 0.0], [-1.0, 0.0, 0.0], [1.0, 1.0, 1.0]];

/// A binary STL with the given header, count and attribute word.
fn binary_with(header: &[u8], count: u32, facets: &[Facet], attribute: u16) -> Vec<u8> {
    let mut bytes = header.to_vec();
    bytes.resize(80, 0);
    bytes.extend(count.to_le_bytes());
    for (index, facet) in facets.iter().enumerate() {
        for number in OUTWARD[index % 4].iter().chain(facet.as_flattened()) {
            bytes.extend(number.to_le_bytes());
        }
        bytes.extend(attribute.to_le_bytes());
    }
    bytes
}

fn binary(facets: &[Facet]) -> Vec<u8> {
    binary_with(b"made by a test", facets.len() as u32, facets, 0)
}

fn ascii_facet(normal: &str, facet: &Facet) -> String {
    let mut text = format!("  facet normal {normal}\n    outer loop\n");
    for [x, y, z] in facet {
        text += &format!("      vertex {x:e} {y} {z}\n");
    }
    text + "    endloop\n  endfacet\n"
}

fn ascii(name: &str, facets: &[Facet]) -> String {
    let body: String =
        facets.iter().zip(OUTWARD).map(|(facet, [x, y, z])| ascii_facet(&format!("{x} {y} {z}"), facet)).collect();
    format!("solid {name}\n{body}endsolid {name}\n")
}

#[track_caller]
fn good(bytes: impl AsRef<[u8]>) -> Contents {
    read_bytes(bytes.as_ref()).expect("the bytes are a good file")
}

/// The code and the message of a file that must not be read.
#[track_caller]
fn bad(bytes: impl AsRef<[u8]>) -> (&'static str, String) {
    let error = read_bytes(bytes.as_ref()).expect_err("the bytes are no good file");
    assert!(!error.hint().is_empty(), "no hint: {error}");
    (error.code(), error.to_string())
}

#[track_caller]
fn assert_bad(bytes: impl AsRef<[u8]>, code: &str, parts: &[&str]) {
    let (found, message) = bad(bytes);
    assert_eq!(found, code, "{message}");
    for part in parts {
        assert!(message.contains(part), "\"{part}\" is not in \"{message}\"");
    }
}

fn in_chunks(bytes: &[u8], size: usize) -> Result<Contents> {
    let mut reader = Reader::new(bytes.len() as u64);
    for chunk in bytes.chunks(size) {
        reader.push(chunk)?;
    }
    reader.finish()
}

#[test]
fn binary_and_ascii_give_the_same_facets() {
    let (from_binary, from_ascii) = (good(binary(&TETRAHEDRON)), good(ascii("corner", &TETRAHEDRON)));
    assert_eq!(from_binary.solids, [Solid { name: String::new(), facets: TETRAHEDRON.to_vec().into() }]);
    assert_eq!(from_ascii.solids, [Solid { name: "corner".into(), facets: TETRAHEDRON.to_vec().into() }]);
    assert_eq!((from_binary.format, from_ascii.format), (Format::StlBinary, Format::StlAscii));
    assert_eq!((from_binary.format.name(), from_ascii.format.name()), ("STL, binary", "STL, ASCII"));
    assert_eq!((from_binary.n_bytes, from_ascii.n_bytes), (284, ascii("corner", &TETRAHEDRON).len() as u64));
    for contents in [from_binary, from_ascii] {
        assert_eq!((contents.n_facets, contents.has_colours, contents.warnings), (4, false, vec![]));
        assert_eq!((contents.wrong_normals, contents.zero_normals, contents.zero_area), (0, 0, 0));
    }
}

#[test]
fn chunks_of_any_size_give_the_same() {
    let two = format!("\u{feff}{}\r\n{}", ascii("one", &TETRAHEDRON).replace('\n', "\r\n"), ascii("two", &TETRAHEDRON));
    let mut trailing = binary(&TETRAHEDRON);
    trailing.extend([b'!'; 70]);
    let bad_number = two.replace("vertex 1e0 0 0", "vertex nan 0 0");
    let cut = &two[..two.len() - 60];
    let files =
        [two.as_bytes(), &binary(&TETRAHEDRON), &trailing, bad_number.as_bytes(), cut.as_bytes(), &trailing[..200]];
    for (index, file) in files.iter().enumerate() {
        let whole = read_bytes(file);
        assert_eq!(whole.is_ok(), index < 3, "file {index}");
        for size in 1..=file.len() {
            assert_eq!(in_chunks(file, size), whole, "file {index}, chunks of {size}");
        }
    }
}

#[test]
fn files_longer_than_the_head_and_the_chunk_are_read_whole() {
    let facets: Vec<Facet> = (0..30_000).map(|i| [[i as f32; 3], [1.0, 2.5, -3.0], [0.25, -0.0, 7e9]]).collect();
    let (from_binary, from_ascii) = (binary(&facets), {
        let body: String = facets.iter().map(|facet| ascii_facet("0 0 0", facet)).collect();
        format!("solid\n{body}endsolid")
    });
    // padding, which is no facet
    let padded = [&from_binary[..], &[0; 170]].concat();
    for file in [&from_binary[..], from_ascii.as_bytes(), &padded] {
        let contents = read_bytes(file).expect("good");
        assert_eq!(contents.solids[0].facets.slice(), facets);
        for size in [49, 1023, 1024, 1025, 65_537] {
            assert_eq!(in_chunks(file, size), Ok(contents.clone()), "chunks of {size}");
        }
    }
}

#[test]
fn binary_headers_may_begin_with_solid() {
    for header in [&b"solid"[..], b"solid exported by CAD", b"SOLID a\nfacet normal 0 0 1\nouter loop", b"\xff\xfe"] {
        let contents = good(binary_with(header, 4, &TETRAHEDRON, 0));
        assert_eq!((contents.format, contents.n_facets), (Format::StlBinary, 4));
    }
    let mut trailing = binary_with(b"solid exported by CAD", 4, &TETRAHEDRON, 0);
    trailing.extend(b"xyz");
    assert_eq!(good(trailing).format, Format::StlBinary);
}

#[test]
fn a_count_beyond_the_end_is_truncated_and_allocates_nothing() {
    assert_bad(
        binary_with(b"", 66, &TETRAHEDRON, 0),
        "stl-truncated",
        &["66 facets", "byte 80", "byte 3384", "byte 284", "4 whole"],
    );
    assert_bad(&binary(&TETRAHEDRON)[..283], "stl-truncated", &["4 facets", "byte 283", "3 whole"]);
    let huge = binary_with(b"", u32::MAX, &TETRAHEDRON[..2], 0);
    assert_bad(&huge, "stl-truncated", &["4294967295 facets", "2 whole"]);
    let mut reader = Reader::new(huge.len() as u64);
    assert_eq!(reader.push(&huge).map_err(|error| error.code()), Err("stl-truncated"));
}

#[test]
fn a_length_that_lies_beyond_memory_is_an_error() {
    let mut reader = Reader::new(84 + 50 * u64::from(u32::MAX));
    let mut head = vec![0u8; 80];
    head.extend([0xff; 4]);
    head.resize(2048, 0);
    // 150 GB may or may not be promised; it must not abort
    if let Err(error) = reader.push(&head) {
        assert_eq!(error.code(), "memory");
    }
}

#[test]
fn trailing_bytes_are_left_out_with_their_number() {
    for tail in [&b"x"[..], &[0; 50], &[0; 100], &[b' '; 50], &[7; 333]] {
        let mut bytes = binary(&TETRAHEDRON);
        bytes.extend(tail);
        let contents = good(&bytes);
        assert_eq!(contents.solids[0].facets.slice(), TETRAHEDRON);
        assert_eq!(contents.warnings.len(), 1);
        let warning = &contents.warnings[0];
        assert!(warning.contains(&format!("{} bytes", tail.len())) && warning.contains("byte 284"), "{warning}");
    }
}

#[test]
fn a_count_below_the_facets_of_the_file_is_an_error() {
    assert_bad(binary_with(b"", 3, &TETRAHEDRON, 0), "stl-count", &["3 facets", "284 bytes", "can hold 4"]);
    assert_bad(binary_with(b"", 0, &TETRAHEDRON, 0), "stl-count", &["0 facets", "can hold 4"]);
    assert_bad(binary_with(b"", 0, &TETRAHEDRON[..1], 0), "stl-count", &["0 facets", "can hold 1"]);
    let small = TETRAHEDRON.map(|facet| facet.map(|corner| corner.map(|number| 1e-9 * number)));
    assert_bad(binary_with(b"", 3, &small, 0), "stl-count", &["3 facets", "can hold 4"]);
    let many: Vec<Facet> = TETRAHEDRON.iter().copied().cycle().take(200).collect();
    assert_bad(binary_with(b"", 7, &many, 0), "stl-count", &["7 facets", "can hold 200"]);
    // facets behind the announced ones are counted in whatever slices they come
    for size in [50, 333, 1100] {
        let error = in_chunks(&binary_with(b"", 150, &many, 0), size).unwrap_err();
        assert!(error.code() == "stl-count" && error.to_string().contains("can hold 200"), "{error}");
    }
    // padding may be as long as what is before it, and a page more
    let padded = |n: usize| [binary(&TETRAHEDRON), vec![0; n]].concat();
    assert_eq!(good(padded(284 + 4096)).warnings.len(), 1);
    assert_bad(padded(284 + 4097), "stl-count", &["announces 4 facets", "of 4665 bytes can hold 91"]);
}

#[test]
fn empty_files_have_no_facet() {
    assert_bad(b"", "stl-empty", &["0 bytes"]);
    let error = Reader::new(0).finish().unwrap_err();
    assert_eq!((error.code(), error.to_string().as_str()), ("stl-empty", "the file has 0 bytes"));
    assert_bad(binary(&[]), "stl-empty", &["0 facets", "byte 80"]);
    assert_bad("solid a\nendsolid a\nsolid b\nendsolid b\n", "stl-empty", &["4 lines"]);
    assert_bad("solid a", "stl-empty", &["1 lines"]);
    assert_bad("solid", "stl-empty", &["1 lines"]);
}

#[test]
fn other_files_are_not_stl() {
    assert_bad(b"# a comment\nv 0 0 0\n", "stl-empty", &["no facet among 1 corners of OBJ"]);
    assert_bad(b"a comment\nv 0 0 0\n", "stl-not-stl", &["a comment", "OBJ with a statement such as"]);
    assert_bad([b"<!DOCTYPE html>".as_slice(), &[b' '; 200]].concat(), "stl-not-stl", &["<!DOCTYPE html>"]);
    assert_bad(b"solidity\nfacet", "stl-not-stl", &["solidity"]);
    assert_bad([0u8; 83], "stl-not-stl", &["83 bytes"]);
    assert_bad([[0u8; 80].as_slice(), &[5, 0, 0, 0]].concat(), "stl-truncated", &["announces 5 facets"]);
    assert_bad("v 0 0 0\n\x7f", "stl-not-stl", &["9 bytes that are not text"]);
    assert_bad([b"\x1f\x8b\x08".as_slice(), &[0; 300]].concat(), "file-syntax", &["gzip"]);
    assert_bad(b"\xff\xfes\0o\0l\0i\0d\0", "stl-not-stl", &["UTF-16"]);
    assert_bad("   \r\n\t", "stl-not-stl", &[]);
}

#[test]
fn corners_that_are_no_numbers_are_named_by_byte() {
    let places = (0..3).flat_map(|corner| ["x", "y", "z"].map(|axis| (corner, axis)));
    for (value, (at, (corner, axis))) in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY]
        .iter()
        .flat_map(|value| places.clone().enumerate().map(move |of| (value, of)))
    {
        let mut facets = TETRAHEDRON;
        facets[2].as_flattened_mut()[at] = *value;
        let byte = 196 + 4 * at;
        let place = format!("facet 3 of 4: {axis} of corner {} is {value} (byte {byte})", corner + 1);
        assert_bad(binary(&facets), "stl-not-finite", &[&place]);
        assert_eq!(binary(&facets)[byte..byte + 4], value.to_le_bytes());
    }
}

#[test]
fn of_many_corners_that_are_no_numbers_the_first_is_named() {
    let mut facets = vec![[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]; 9000];
    facets[8500][0][0] = f32::NAN;
    facets[5003][2][1] = f32::INFINITY;
    facets[5004][0][0] = f32::NAN;
    let parts = ["facet 5004 of 9000", "y of corner 3", &format!("byte {}", 84 + 50 * 5003 + 12 + 4 * 7)];
    assert_bad(binary(&facets), "stl-not-finite", &parts);
    let mut reader = Reader::new(84 + 50 * 9000);
    let first_error = binary(&facets).chunks(3001).find_map(|chunk| reader.push(chunk).err());
    assert!(first_error.unwrap().to_string().contains("facet 5004 of 9000"));
}

#[test]
fn normals_are_counted_and_never_decide() {
    let facet = &TETRAHEDRON[3];
    let normals = [
        "0 0 0",
        "-0 0 0",
        "-1 0 0",
        "0 -1 0",
        "0 0 -1",
        "-1 -1 -1",
        "1 1 1",
        "nan nan nan",
        "-inf 0 0",
        "a b",
        "",
        "-1e39 0 0",
        "0 0 -2",
    ];
    let body: String = normals.iter().map(|normal| ascii_facet(normal, facet)).collect();
    let contents = good(format!("solid\n{body}endsolid\n"));
    assert_eq!(contents.solids[0].facets.slice(), vec![*facet; normals.len()]);
    assert_eq!((contents.zero_normals, contents.wrong_normals), (2, 5));

    let mut bytes = binary(&TETRAHEDRON);
    bytes[84..88].copy_from_slice(&f32::NAN.to_le_bytes());
    bytes[134 + 4..134 + 8].copy_from_slice(&1f32.to_le_bytes());
    bytes[184..196].fill(0);
    let contents = good(bytes);
    assert_eq!(contents.solids[0].facets.slice(), TETRAHEDRON);
    assert_eq!((contents.zero_normals, contents.wrong_normals), (1, 1));
}

#[test]
fn facets_without_area_are_kept_and_counted() {
    let facets = [TETRAHEDRON[0], [[1.0; 3]; 3], [[0.0; 3], [1.0; 3], [3.0; 3]], TETRAHEDRON[3]];
    for contents in [good(binary(&facets)), good(ascii("a", &facets))] {
        assert_eq!(contents.solids[0].facets.slice(), facets);
        assert_eq!((contents.n_facets, contents.zero_area), (4, 2));
    }
}

#[test]
fn colours_are_noticed() {
    assert!(good(binary_with(b"COLOR=abcd,MATERIAL=", 4, &TETRAHEDRON, 0)).has_colours);
    assert!(good(binary_with(b"", 4, &TETRAHEDRON, 0x4e73)).has_colours);
    assert!(good(binary_with(b"", 4, &TETRAHEDRON, 1)).has_colours);
    assert!(!good(binary_with(b"colourless", 4, &TETRAHEDRON, 0)).has_colours);
    // 61 is a "=" behind the header
    let many: Vec<Facet> = TETRAHEDRON.iter().copied().cycle().take(61).collect();
    assert!(!good(binary_with(&[[b' '; 75].as_slice(), b"COLOR"].concat(), 61, &many, 0)).has_colours);
}

#[test]
fn a_file_that_changes_its_length_is_an_error() {
    let bytes = binary(&TETRAHEDRON);
    let read = |n_bytes| {
        let mut reader = Reader::new(n_bytes);
        reader.push(&bytes).and_then(|()| reader.finish()).map_err(|error| error.code())
    };
    assert_eq!(read(283), Err("io"));
    assert_eq!(read(285), Err("io"));
    assert!(read(284).is_ok());
}

#[test]
fn an_error_is_returned_again() {
    let mut reader = Reader::new(1000);
    let text = format!("solid a\n{}", "garbage\n".repeat(124));
    let first = reader.push(text.as_bytes());
    assert_eq!(first.as_ref().map_err(Error::code), Err("stl-syntax"));
    assert_eq!(reader.push(b""), first);
    assert_eq!(reader.finish().map(|_| ()), first);
}

#[test]
fn no_mutation_of_a_good_file_panics_or_depends_on_the_chunks() {
    let mut state = 1u64;
    let mut random = |n: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % n
    };
    let files = [binary(&TETRAHEDRON), ascii("a", &TETRAHEDRON).into_bytes()];
    for round in 0..4000 {
        let mut bytes = files[round % 2].clone();
        for _ in 0..=random(3) {
            let at = random(bytes.len());
            match random(4) {
                0 => bytes[at] = random(256) as u8,
                1 => bytes.truncate(at.max(1)),
                2 => bytes.insert(at, b"\n\r \0e-.9"[random(8)]),
                _ => _ = bytes.remove(at),
            }
            if bytes.is_empty() {
                bytes.push(b's');
            }
        }
        let whole = read_bytes(&bytes);
        if let Ok(contents) = &whole {
            assert!(
                contents
                    .solids
                    .iter()
                    .flat_map(|s| s.facets.slice().as_flattened().as_flattened())
                    .all(|c| c.is_finite())
            );
            assert_eq!(contents.n_facets, contents.solids.iter().map(|s| s.facets.len() as u64).sum::<u64>());
        }
        assert_eq!(in_chunks(&bytes, 1 + random(90)), whole, "round {round}: {bytes:?}");
    }
}
