use super::*;

#[test]
fn line_ends_blanks_and_case_do_not_matter() {
    let plain = ascii("Part 7", &TETRAHEDRON);
    let expected = good(&plain).solids;
    let upper = plain.to_uppercase().replace("PART 7", "Part 7");
    let cases = [
        plain.replace('\n', "\r\n"),
        plain.replace('\n', "\r"),
        plain.replace('\n', "\n\n  \t\n"),
        plain.replace('\n', " \t\n\t"),
        plain.replace(' ', " \t ").replace("Part \t 7", "Part 7"),
        plain.trim_end().to_string(),
        format!("\n\r\n  {plain}\n\n"),
        format!("\u{feff}{plain}"),
        format!("{plain}\0\0\0\u{1a}"),
        plain.replace("endsolid Part 7", "endsolid another"),
        plain.replace("endsolid Part 7", "endsolid"),
        upper,
    ];
    for (index, text) in cases.iter().enumerate() {
        let contents = good(text);
        assert_eq!(contents.solids, expected, "case {index}");
        assert_eq!(contents.warnings, Vec::<String>::new(), "case {index}");
    }
}

#[test]
fn lines_are_counted_alike_for_every_line_end() {
    let text = ascii("a", &TETRAHEDRON).replacen("outer loop", "outer", 2);
    for end in ["\n", "\r\n", "\r"] {
        assert_bad(text.replace('\n', end), "stl-syntax", &["line 3:", "\"outer\"", "\"outer loop\""]);
    }
}

#[test]
fn several_solids_keep_their_names() {
    let text = [ascii("", &TETRAHEDRON[..1]), ascii("two words", &TETRAHEDRON), ascii("Ä", &TETRAHEDRON[1..])].concat();
    let contents = good(text);
    let found: Vec<(&str, usize)> = contents.solids.iter().map(|s| (s.name.as_str(), s.facets.len())).collect();
    assert_eq!(found, [("", 1), ("two words", 4), ("Ä", 3)]);
    assert_eq!(contents.n_facets, 8);
}

#[test]
fn names_that_are_no_utf8_are_read_with_replacements() {
    let text = ascii("NAME", &TETRAHEDRON).into_bytes();
    let at = 6;
    for odd in [b'\xff', b'\x01'] {
        let mut text = text.clone();
        text[at] = odd;
        let contents = good(text);
        assert_eq!(contents.solids[0].name, format!("{}AME", String::from_utf8_lossy(&[odd])));
        assert_eq!(contents.n_facets, 4);
    }
}

#[test]
fn a_missing_endsolid_and_a_solid_without_facets_are_warned_about() {
    let text = ascii("one", &TETRAHEDRON);
    let without = text.replace("endsolid one\n", "");
    let contents = good(&without);
    assert_eq!(contents.warnings, ["line 29: the file ends without \"endsolid\""]);
    let contents = good(format!("{without}{text}"));
    assert_eq!((contents.solids.len(), contents.n_facets), (2, 8));
    assert_eq!(contents.warnings.len(), 1);
    assert!(contents.warnings[0].starts_with("line 30:"), "{}", contents.warnings[0]);
    let contents = good(format!("solid none\nendsolid none\n{text}"));
    assert_eq!((contents.solids.len(), contents.solids[0].name.as_str()), (1, "one"));
    assert_eq!(contents.warnings, ["line 1: solid \"none\" without facets left out"]);
    let contents = good(format!("solid none\n{text}solid more"));
    assert_eq!((contents.solids.len(), contents.solids[0].name.as_str()), (1, "one"));
    let warnings = [
        "line 2: a \"solid\" begins before the \"endsolid\" of the last",
        "line 1: solid \"none\" without facets left out",
        "line 32: the file ends without \"endsolid\"",
        "line 32: solid \"more\" without facets left out",
    ];
    assert_eq!(contents.warnings, warnings);
}

#[test]
fn warnings_are_bounded() {
    let contents = good(format!("{}{}", "solid\nendsolid\n".repeat(1000), ascii("", &TETRAHEDRON)));
    assert_eq!(contents.warnings.len(), 17);
    assert_eq!(contents.warnings[16], "984 more warnings of these kinds");
    let contents = good(format!("{}{}", "solid\nendsolid\n".repeat(17), ascii("", &TETRAHEDRON)));
    assert_eq!(contents.warnings[16..], ["1 more warnings of these kinds"]);
}

#[test]
fn numbers_are_read_to_the_nearest_single() {
    let facet = "solid\nfacet normal 0 0 1\nouter loop\nvertex 0.1 -1.5E+3 +2.e-2\nvertex 1e-50 16777217 .5\n\
                 vertex 3.4028235e38 -0 1.00000017881393432617187499\nendloop\nendfacet\nendsolid\n";
    let expected = [[0.1, -1500.0, 0.02], [0.0, 16_777_216.0, 0.5], [f32::MAX, -0.0, 1.000_000_1]];
    let found = good(facet).solids[0].facets.slice()[0];
    assert_eq!(found.map(|corner| corner.map(f32::to_bits)), expected.map(|corner| corner.map(f32::to_bits)));
}

#[test]
fn corners_that_are_no_numbers_are_named_by_line() {
    let text = ascii("a", &TETRAHEDRON);
    // corner 2 of facet 2 stands on line 12
    let with = |number: &str| {
        let lines: Vec<&str> = text.lines().collect();
        let line = format!("vertex 0 {number} 0");
        [&lines[..11], &[line.as_str()], &lines[12..]].concat().join("\n")
    };
    for number in ["nan", "NaN", "-nan(ind)", "inf", "-Infinity", "1.#QNAN", "1.#INF"] {
        assert_bad(with(number), "stl-not-finite", &["line 12: y of corner 2 of facet 2", number]);
    }
    assert_bad(with("1e39"), "stl-not-finite", &["line 12", "1e39", "3.4e38"]);
    assert_bad(with("-3.5e38"), "stl-not-finite", &["line 12", "-3.5e38"]);
    for number in ["0,5", "1x", "0x10", "--1", "1e", "\u{fffd}"] {
        assert_bad(with(number), "stl-syntax", &["line 12: y of corner 2 of facet 2", "is not a number"]);
    }
    assert_bad(with(""), "stl-syntax", &["line 12: z of corner 2 of facet 2 is missing"]);
    assert_bad(with("0 0"), "stl-syntax", &["line 12", "\"0\" after the three numbers"]);
}

#[test]
fn grammar_errors_name_the_line_and_what_was_expected() {
    let text = ascii("a", &TETRAHEDRON);
    let without = |number: usize| {
        let lines = text.lines().enumerate().filter(|(index, _)| index + 1 != number);
        lines.map(|(_, line)| line).collect::<Vec<_>>().join("\n")
    };
    assert_bad(without(2), "stl-syntax", &["line 2: \"outer loop\"", "\"facet normal\" or \"endsolid\""]);
    assert_bad(without(3), "stl-syntax", &["line 3: \"vertex", "\"outer loop\""]);
    assert_bad(without(6), "stl-syntax", &["line 6: \"endloop\"", "\"vertex\" 3 of 3"]);
    assert_bad(without(7), "stl-syntax", &["line 7: \"endfacet\"", "\"endloop\""]);
    assert_bad(without(8), "stl-syntax", &["line 8: \"facet normal", "\"endfacet\""]);
    assert_bad(format!("{text}facet normal 0 0 1\n"), "stl-syntax", &["line 31: \"facet", "\"solid\""]);
    assert_bad(text.replacen("endfacet", "end\0facet", 1), "stl-syntax", &["line 8: \"end\\0facet\""]);
    // words as long as those of the grammar
    for (word, other) in
        [("vertex", "vortex"), ("endloop", "endlope"), ("endfacet", "endfaced"), ("endsolid", "endsolod")]
    {
        assert_bad(text.replacen(word, other, 1), "stl-syntax", &[&format!("\"{other}")]);
    }
    for other in ["hello", "tale of a solid"] {
        assert_bad(format!("{text}{other}\n"), "stl-syntax", &["line 31: ", other, "\"solid\""]);
    }
}

#[test]
fn a_quad_is_an_error_that_names_its_line() {
    let text = ascii("a", &TETRAHEDRON).replacen("    endloop", "vertex 5 5 5\n    endloop", 1);
    assert_bad(text, "stl-syntax", &["line 7: a fourth vertex", "facet of line 2"]);
}

#[test]
fn text_cut_inside_a_facet_is_truncated() {
    let text = ascii("a", &TETRAHEDRON);
    let cut = text.lines().take(13).collect::<Vec<_>>().join("\n");
    let parts = ["after line 13", "facet of line 9", "\"endloop\"", "1 facets are whole"];
    assert_bad(cut, "stl-truncated", &parts);
}

#[test]
fn long_lines_end_the_reading_before_they_fill_the_memory() {
    let text = format!("solid a\n{}", "x".repeat(1 << 17));
    let mut reader = Reader::new(u64::MAX);
    let mut pushed = 0;
    let error = text.as_bytes().chunks(1000).cycle().find_map(|chunk| {
        pushed += chunk.len();
        reader.push(chunk).err()
    });
    assert_eq!(error.map(|error| (error.code(), error.to_string().contains("line 2"))), Some(("stl-syntax", true)));
    assert!(pushed < 70_000, "{pushed} bytes");
    assert_bad(&text, "stl-syntax", &["line 2 is longer than 65536 bytes"]);
    // the longest name, in the first line and after the bytes that decide the format
    for before in [String::new(), ascii("a", &TETRAHEDRON) + &"\n".repeat(1024)] {
        let named = |n: usize| format!("{before}{}", ascii("name", &TETRAHEDRON).replacen("name", &"n".repeat(n), 1));
        let longest = named((1 << 16) - "solid ".len());
        let beyond = named((1 << 16) - "solid ".len() + 1);
        assert!(good(&longest).solids.iter().any(|solid| solid.name.len() == (1 << 16) - 6));
        assert_eq!(in_chunks(longest.as_bytes(), 1000), Ok(good(&longest)));
        let place = format!("line {} is longer than 65536 bytes", 1 + before.lines().count());
        assert_bad(&beyond, "stl-syntax", &[&place]);
        assert_eq!(in_chunks(beyond.as_bytes(), 1000).map_err(|error| error.to_string()), Err(place));
    }
}
