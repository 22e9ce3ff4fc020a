//! Every file of `tests/fixtures` against what is known about it. Facets, edges and shells were counted and volumes and
//! areas summed by an independent program.

use hexcast::geometry::{Facet, Geometry};
use hexcast::read::{Contents, Format, read_bytes};
use hexcast::surface::surface;
use std::path::PathBuf;

/// What a file that can be read holds.
struct Good {
    file: &'static str,
    format: Format,
    solids: &'static [&'static str],
    n_facets: u64,
    open_edges: u64,
    shells: u64,
    zero_normals: u64,
    has_colours: bool,
    warnings: &'static [&'static str],
    /// None where the surface is open.
    volume: Option<f64>,
    area: f64,
}

/// A binary file without remarks; the base of the rows below.
const PLAIN: Good = Good {
    file: "",
    format: Format::StlBinary,
    solids: &[""],
    n_facets: 0,
    open_edges: 0,
    shells: 1,
    zero_normals: 0,
    has_colours: false,
    warnings: &[],
    volume: None,
    area: 0.0,
};

const TETRAHEDRON: Good =
    Good { format: Format::StlAscii, n_facets: 4, volume: Some(0.166666667), area: 2.3660254, ..PLAIN };

/// A ball and two rods.
const SCENE: Good = Good { n_facets: 136, shells: 3, volume: Some(17.820975), area: 53.2822473, ..PLAIN };

const GOOD: &[Good] = &[
    Good { file: "spot.stl", n_facets: 5856, volume: Some(0.718258789), area: 5.7095188, ..PLAIN },
    Good { file: "scene.stl", ..SCENE },
    Good { file: "scene.glb", format: Format::Glb, solids: &["ball", "rod", "mirrored"], ..SCENE },
    Good { file: "scene.3mf", format: Format::ThreeMf, solids: &["ball", "rod", "rod_1"], ..SCENE },
    Good { file: "featuretype.stl", n_facets: 3476, open_edges: 576, area: 53.8273861, ..PLAIN },
    Good { file: "bin_header_solid_cube.stl", n_facets: 12, volume: Some(1e6), area: 6e4, ..PLAIN },
    Good {
        file: "bin_color_magics.stl",
        n_facets: 260,
        has_colours: true,
        volume: Some(7938.68188),
        area: 2499.02488,
        ..PLAIN
    },
    Good {
        file: "ascii_two_solids_mixed_case.stl",
        format: Format::StlAscii,
        solids: &["CubeExportedFromCAD", "TranslatedCubeExportedFromCAD"],
        n_facets: 24,
        shells: 2,
        volume: Some(2.0),
        area: 12.0,
        ..PLAIN
    },
    Good {
        file: "ascii_missing_endsolid.stl",
        solids: &["tetrahedron"],
        warnings: &["line 29: the file ends without \"endsolid\""],
        ..TETRAHEDRON
    },
    Good { file: "ascii_nan_normal.stl", solids: &["notANumberNormal"], ..TETRAHEDRON },
    Good { file: "ascii_zero_normals.stl", solids: &["tetrahedron"], zero_normals: 4, ..TETRAHEDRON },
];

/// Files that cannot be read: the code, and what the message must say.
const BAD: &[(&str, &str, &str)] = &[
    ("ascii_empty.stl", "stl-empty", "no facet"),
    ("ascii_quad_facet.stl", "stl-syntax", "line 7"),
    ("bin_count_too_big.stl", "stl-truncated", "66 facets"),
    ("bin_empty.stl", "stl-empty", "0 facets"),
];

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures")
}

fn read(file: &str) -> hexcast::Result<Contents> {
    read_bytes(&std::fs::read(folder().join(file)).expect("the fixture is there"))
}

#[track_caller]
fn assert_near(found: f64, expected: f64, what: &str) {
    assert!((found - expected).abs() <= 1e-8 * expected.abs(), "{what}: {found}, expected {expected}");
}

#[test]
fn good_fixtures_hold_what_is_known_about_them() {
    for good in GOOD {
        let file = good.file;
        let contents = read(file).unwrap_or_else(|error| panic!("{file}: {error}"));
        let names: Vec<&str> = contents.solids.iter().map(|solid| solid.name.as_str()).collect();
        assert_eq!((contents.format, names.as_slice()), (good.format, good.solids), "{file}");
        assert_eq!((contents.n_facets, contents.zero_normals), (good.n_facets, good.zero_normals), "{file}");
        assert_eq!(contents.has_colours, good.has_colours, "{file}");
        assert_eq!(contents.warnings, good.warnings, "{file}");
        let facets: Vec<Facet> =
            contents.solids.iter().flat_map(|solid| solid.facets.slice().iter().copied()).collect();
        let found = surface(&facets);
        assert_eq!(
            (found.n_facets, found.open_edges, found.shells),
            (good.n_facets, good.open_edges, good.shells),
            "{file}"
        );
        assert_eq!((found.watertight, found.closed_oriented), (good.volume.is_some(), good.volume.is_some()), "{file}");
        assert_near(found.area, good.area, file);
        if let Some(volume) = good.volume {
            assert_near(Geometry::new("", 1, facets).unwrap().signed_volume(), volume, file);
        }
    }
}

#[test]
fn bad_fixtures_are_refused_with_their_reason() {
    for (file, code, part) in BAD {
        let error = read(file).expect_err(file);
        assert_eq!(error.code(), *code, "{file}: {error}");
        assert!(error.to_string().contains(part) && !error.hint().is_empty(), "{file}: {error}");
    }
}

#[test]
fn every_fixture_is_listed_once() {
    let mut listed: Vec<&str> = GOOD.iter().map(|good| good.file).chain(BAD.iter().map(|(file, ..)| *file)).collect();
    listed.sort_unstable();
    let entries = std::fs::read_dir(folder()).expect("the folder is there");
    let mut found: Vec<String> = entries
        .map(|entry| entry.expect("an entry").file_name().into_string().expect("UTF-8"))
        .filter(|name| [".stl", ".glb", ".3mf"].iter().any(|ending| name.ends_with(ending)))
        .collect();
    found.sort_unstable();
    assert_eq!(found, listed);
}
