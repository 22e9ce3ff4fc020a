//! GLB and 3MF: the facets of the same model as STL, what their descriptions can say, and what is wrong with files.

use super::*;

mod glb;
mod three_mf;

/// The corners of a tetrahedron and its facets, by index.
const CORNERS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const INDICES: [[u16; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

/// The facets of the tetrahedron, each corner moved to another place.
fn moved(to: impl Fn([f32; 3]) -> [f32; 3]) -> Vec<[[f32; 3]; 3]> {
    INDICES.iter().map(|of| of.map(|index| to(CORNERS[usize::from(index)]))).collect()
}

fn facets_of(bytes: &[u8]) -> Vec<(String, Vec<[[f32; 3]; 3]>)> {
    let contents = read_bytes(bytes).unwrap();
    contents.solids.iter().map(|solid| (solid.name.clone(), solid.facets.slice().to_vec())).collect()
}

fn message(bytes: &[u8]) -> String {
    read_bytes(bytes).unwrap_err().to_string()
}

#[test]
fn files_of_another_program_hold_the_facets_of_its_stl() {
    let [stl, glb, three_mf] = ["stl", "glb", "3mf"].map(|ending| {
        let path = format!("{}/../../tests/fixtures/scene.{ending}", env!("CARGO_MANIFEST_DIR"));
        read_bytes(&std::fs::read(path).unwrap()).unwrap()
    });
    assert_eq!((stl.unit, glb.unit, three_mf.unit), (None, Some("m"), Some("mm")));
    assert_eq!((glb.format, three_mf.format), (Format::Glb, Format::ThreeMf));
    let expected = &stl.solids[0].facets;
    for contents in [&glb, &three_mf] {
        assert_eq!((contents.solids.len(), contents.n_facets, contents.warnings.len()), (3, 136, 0));
        let facets = contents.solids.iter().flat_map(|solid| solid.facets.slice().iter());
        for (facet, expected) in facets.zip(expected.slice().iter()) {
            // the other program rounds corners before it turns the mirrored ones round
            let is_near = |(one, other): (&[f32; 3], &[f32; 3])| (0..3).all(|k| (one[k] - other[k]).abs() < 1e-6);
            let turns = [0, 1, 2].map(|by| [0, 1, 2].map(|corner| facet[(corner + by) % 3]));
            assert!(turns.iter().any(|turned| turned.iter().zip(expected).all(is_near)), "{facet:?} {expected:?}");
        }
    }
    assert_eq!(glb.solids.iter().map(|solid| &solid.name[..]).collect::<Vec<_>>(), ["ball", "rod", "mirrored"]);
}
