//! GLB and 3MF: the facets of the same model as STL, what their descriptions can say, and what is wrong with files.

use std::io::Write;

use flate2::Compression;
use flate2::write::DeflateEncoder;
use rawzip::{CompressionMethod, ZipArchiveWriter};
use serde_json::{Value, json};

use super::*;

/// The corners of a tetrahedron and its facets, by index.
const CORNERS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const INDICES: [[u16; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

/// A file of a description and the bytes of its buffer.
fn glb(root: &Value, buffer: &[u8]) -> Vec<u8> {
    let mut json = root.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend((20 + json.len() as u32 + 8 + buffer.len() as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", &json[..]), (b"BIN\0", buffer)] {
        bytes.extend((chunk.len() as u32).to_le_bytes());
        bytes.extend(kind);
        bytes.extend(chunk);
    }
    bytes
}

/// 48 bytes of corners, then 24 of indices.
fn buffer() -> Vec<u8> {
    let corners = CORNERS.as_flattened().iter().flat_map(|number| number.to_le_bytes());
    corners.chain(INDICES.as_flattened().iter().flat_map(|index| index.to_le_bytes())).collect()
}

/// One node with one mesh.
fn tetrahedron() -> Value {
    json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"name": "tip", "mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 24},
        ],
        "buffers": [{"byteLength": 72}],
    })
}

/// The facets of the tetrahedron, each corner moved to another place.
fn moved(to: impl Fn([f32; 3]) -> [f32; 3]) -> Vec<[[f32; 3]; 3]> {
    INDICES.iter().map(|of| of.map(|index| to(CORNERS[usize::from(index)]))).collect()
}

fn facets_of(bytes: &[u8]) -> Vec<(String, Vec<[[f32; 3]; 3]>)> {
    let contents = read_bytes(bytes).unwrap();
    contents.solids.iter().map(|solid| (solid.name.clone(), solid.facets.iter().copied().collect())).collect()
}

fn message(bytes: &[u8]) -> String {
    read_bytes(bytes).unwrap_err().to_string()
}

/// A 3MF of these files; the second is packed.
fn package(files: &[(&str, &str)]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut archive = ZipArchiveWriter::new(&mut bytes);
    for (number, (name, text)) in files.iter().enumerate() {
        let method = if number == 1 { CompressionMethod::DEFLATE } else { CompressionMethod::STORE };
        let (mut entry, config) = archive.new_file(name).compression_method(method).start().unwrap();
        let descriptor = if number == 1 {
            let mut writer = config.wrap(DeflateEncoder::new(&mut entry, Compression::default()));
            writer.write_all(text.as_bytes()).unwrap();
            let (encoder, descriptor) = writer.finish().unwrap();
            encoder.finish().unwrap();
            descriptor
        } else {
            let mut writer = config.wrap(&mut entry);
            writer.write_all(text.as_bytes()).unwrap();
            writer.finish().unwrap().1
        };
        entry.finish(descriptor).unwrap();
    }
    archive.finish().unwrap();
    bytes
}

const RELATIONS: &str = "<Relationships><Relationship Id='r1' Target='/3D/here.model' \
    Type='http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel'/></Relationships>";

fn object(id: u32, about: &str) -> String {
    let corners: String = CORNERS.iter().map(|[x, y, z]| format!("<vertex x='{x}' y='{y}' z='{z}'/>")).collect();
    let facets: String = INDICES.iter().map(|[a, b, c]| format!("<triangle v1='{a}' v2='{b}' v3='{c}'/>")).collect();
    format!(
        "<object id='{id}' {about}><mesh><vertices>{corners}</vertices><triangles>{facets}</triangles></mesh></object>"
    )
}

fn model(about: &str, objects: &str, items: &str) -> String {
    format!("<?xml version='1.0'?><model {about}><resources>{objects}</resources><build>{items}</build></model>")
}

fn three_mf(about: &str, objects: &str, items: &str) -> Vec<u8> {
    package(&[("_rels/.rels", RELATIONS), ("3D/here.model", &model(about, objects, items))])
}

#[test]
fn files_of_another_program_hold_the_facets_of_its_stl() {
    let [stl, glb, three_mf] = ["stl", "glb", "3mf"].map(|ending| {
        let path = format!("{}/tests/fixtures/scene.{ending}", env!("CARGO_MANIFEST_DIR"));
        read_bytes(&std::fs::read(path).unwrap()).unwrap()
    });
    assert_eq!((stl.unit, glb.unit, three_mf.unit), (None, Some("m"), Some("mm")));
    assert_eq!((glb.format, three_mf.format), (Format::Glb, Format::ThreeMf));
    let expected = &stl.solids[0].facets;
    for contents in [&glb, &three_mf] {
        assert_eq!((contents.solids.len(), contents.n_facets, contents.warnings.len()), (3, 136, 0));
        let facets = contents.solids.iter().flat_map(|solid| solid.facets.iter());
        for (facet, expected) in facets.zip(expected.iter()) {
            // the other program rounds corners before it turns the mirrored ones round
            let is_near = |(one, other): (&[f32; 3], &[f32; 3])| (0..3).all(|k| (one[k] - other[k]).abs() < 1e-6);
            let turns = [0, 1, 2].map(|by| [0, 1, 2].map(|corner| facet[(corner + by) % 3]));
            assert!(turns.iter().any(|turned| turned.iter().zip(expected).all(is_near)), "{facet:?} {expected:?}");
        }
    }
    assert_eq!(glb.solids.iter().map(|solid| &solid.name[..]).collect::<Vec<_>>(), ["ball", "rod", "mirrored"]);
}

#[test]
fn nodes_place_meshes_and_turn_mirrored_ones_round() {
    let mut root = tetrahedron();
    assert_eq!(facets_of(&glb(&root, &buffer())), [("tip".to_string(), moved(|at| at))]);
    // a child, twice as large along x, turned by a quarter about z, in a parent that is moved; beside it a mirrored copy
    let half = 0.5f64.sqrt();
    root["scenes"] = json!([{"nodes": [0, 2]}]);
    root["nodes"] = json!([
        {"translation": [10, 0, 0], "children": [1]},
        {"name": "tip", "mesh": 0, "scale": [2, 1, 1], "rotation": [0, 0, half, half]},
        {"name": "tip", "mesh": 0, "matrix": [-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 5, 1]},
    ]);
    let found = facets_of(&glb(&root, &buffer()));
    let near = |found: &[[[f32; 3]; 3]], expected: Vec<[[f32; 3]; 3]>| {
        assert_eq!(found.len(), expected.len());
        let pairs = found.as_flattened().as_flattened().iter().zip(expected.as_flattened().as_flattened());
        pairs.for_each(|(one, other)| assert!((one - other).abs() < 1e-6, "{found:?} {expected:?}"));
    };
    assert_eq!(found.len(), 2, "two nodes of one name are two solids");
    near(&found[0].1, moved(|[x, y, z]| [10.0 - y, 2.0 * x, z]));
    let mirrored: Vec<_> = moved(|[x, y, z]| [-x, y, z + 5.0]).into_iter().map(|[a, b, c]| [a, c, b]).collect();
    near(&found[1].1, mirrored);
    // without scenes what is in no other node is shown
    let with_scenes = glb(&root, &buffer());
    root.as_object_mut().unwrap().remove("scenes");
    assert_eq!(facets_of(&glb(&root, &buffer())), facets_of(&with_scenes));
}

#[test]
fn strips_fans_lists_without_indices_and_sparse_corners_are_read() {
    let mut root = tetrahedron();
    let square = [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
    let bytes: Vec<u8> = square.as_flattened().iter().flat_map(|number| number.to_le_bytes()).collect();
    root["meshes"][0]["primitives"][0] = json!({"attributes": {"POSITION": 0}, "mode": 5});
    let strip = facets_of(&glb(&root, &bytes));
    assert_eq!(strip[0].1, [[square[0], square[1], square[2]], [square[1], square[3], square[2]]]);
    root["meshes"][0]["primitives"][0]["mode"] = 6.into();
    let fan = facets_of(&glb(&root, &bytes));
    assert_eq!(fan[0].1, [[square[1], square[2], square[0]], [square[2], square[3], square[0]]]);
    root["meshes"][0]["primitives"][0]["mode"] = 4.into();
    assert!(message(&glb(&root, &bytes)).contains("4 indices are not three a triangle"));
    // the last corner is replaced; the others of an accessor without a view are at the origin
    let mut root = tetrahedron();
    let mut bytes = buffer();
    bytes.extend([3, 0, 0, 0]);
    bytes.extend([7.0f32, 8.0, 9.0].iter().flat_map(|number| number.to_le_bytes()));
    root["buffers"][0]["byteLength"] = 88.into();
    let views = root["bufferViews"].as_array_mut().unwrap();
    views.extend([
        json!({"buffer": 0, "byteOffset": 72, "byteLength": 4}),
        json!({"buffer": 0, "byteOffset": 76, "byteLength": 12}),
    ]);
    let sparse = json!({"count": 1, "indices": {"bufferView": 2, "componentType": 5121}, "values": {"bufferView": 3}});
    root["accessors"][0]["sparse"] = sparse.clone();
    let last = |[x, y, z]: [f32; 3]| if z == 1.0 { [7.0, 8.0, 9.0] } else { [x, y, z] };
    assert_eq!(facets_of(&glb(&root, &bytes))[0].1, moved(last));
    root["accessors"][0] = json!({"componentType": 5126, "count": 4, "type": "VEC3", "sparse": sparse});
    assert_eq!(facets_of(&glb(&root, &bytes))[0].1, moved(|at| if at[2] == 1.0 { [7.0, 8.0, 9.0] } else { [0.0; 3] }));
}

#[test]
fn corners_may_be_small_integers() {
    let mut root = tetrahedron();
    let bytes: Vec<u8> = CORNERS
        .iter()
        .flat_map(|at| [at[0] as i8 * 127, at[1] as i8 * -127, at[2] as i8 * 127, 9])
        .map(|b| b as u8)
        .collect();
    let bytes: Vec<u8> = bytes.into_iter().chain(buffer()[48..].to_vec()).collect();
    root["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    root["accessors"][0] =
        json!({"bufferView": 0, "componentType": 5120, "count": 4, "type": "VEC3", "normalized": true});
    root["bufferViews"] =
        json!([{"buffer": 0, "byteLength": 16, "byteStride": 4}, {"buffer": 0, "byteOffset": 16, "byteLength": 24}]);
    assert_eq!(facets_of(&glb(&root, &bytes))[0].1, moved(|[x, y, z]| [x, 0.0 - y, z]));
}

#[test]
fn what_is_wrong_with_a_glb_is_said() {
    let cases: Vec<(&str, Value, &str)> = vec![
        ("/scene", json!(3), "there is no scene 3, counted from 0, of 1"),
        ("/scenes/0/nodes", json!([1]), "there is no node 1, counted from 0, of 1"),
        ("/scenes/0/nodes", json!([0, 0]), "node 0 is in the scene twice"),
        ("/nodes/0/children", json!([0]), "node 0 is in the scene twice"),
        ("/nodes/0/mesh", json!(1), "there is no mesh 1"),
        ("/meshes/0/primitives/0/indices", json!(0), "accessor 0 is of VEC3, not SCALAR"),
        ("/meshes/0/primitives/0/attributes/POSITION", json!(7), "there is no accessor 7"),
        ("/accessors/0/count", json!(5), "buffer view 0 holds fewer than 5 elements of 12 bytes, 12 apart"),
        ("/accessors/0/count", json!(u64::MAX), "holds fewer than 18446744073709551615 elements"),
        ("/accessors/0/count", json!(3), "a triangle has corner 3, counted from 0, of 3"),
        ("/accessors/0/count", json!(0), "a triangle has corner 0, counted from 0, of 0"),
        ("/accessors/0/componentType", json!(5130), "the type 5130"),
        ("/accessors/1/componentType", json!(5126), "indices have the type 5126"),
        (
            "/accessors/0",
            json!({"componentType": 5126, "count": 1e15 as u64, "type": "VEC3"}),
            "1000000000000000 elements and no bytes",
        ),
        ("/bufferViews/0/byteStride", json!(4), "holds fewer than 4 elements of 12 bytes, 4 apart"),
        ("/bufferViews/0/byteLength", json!(47), "holds fewer than 4 elements"),
        ("/bufferViews/0/byteOffset", json!(u64::MAX), "holds fewer than 4 elements"),
        ("/bufferViews/0/byteStride", json!(1u64 << 32), "holds fewer than 4 elements of 12 bytes, 4294967296 apart"),
        (
            "/extensionsUsed",
            json!(["EXT_mesh_gpu_instancing"]),
            "the extension EXT_mesh_gpu_instancing, which cannot be read",
        ),
        ("/buffers/0/uri", json!("more.bin"), "its numbers lie in another file"),
        (
            "/extensionsRequired",
            json!(["KHR_draco_mesh_compression"]),
            "needs the extension KHR_draco_mesh_compression,",
        ),
        ("/nodes", json!(7), "its description is not that of glTF: invalid type"),
    ];
    for (place, value, expected) in cases {
        let mut root = tetrahedron();
        let (parent, key) = place.rsplit_once('/').unwrap();
        let parent = root.pointer_mut(parent).unwrap();
        match key.parse::<usize>() {
            Ok(index) => parent[index] = value,
            Err(_) => parent[key] = value,
        }
        let found = message(&glb(&root, &buffer()));
        assert!(found.contains(expected), "{place}: {found}");
    }
    let whole = glb(&tetrahedron(), &buffer());
    for cut in [12, 21, 400, whole.len() - 1] {
        assert!(message(&whole[..cut]).starts_with("GLB: "), "{cut}: {}", message(&whole[..cut]));
    }
    let mut old = whole.clone();
    old[4] = 1;
    assert_eq!(message(&old), "GLB: its version is 1, and only 2 can be read");
    let mut root = tetrahedron();
    root["meshes"][0]["primitives"][0]["mode"] = 1.into();
    assert!(message(&glb(&root, &buffer())).contains("no facet"), "{}", message(&glb(&root, &buffer())));
}

#[test]
fn skins_morphs_and_lines_are_passed_over_with_a_warning() {
    let mut root = tetrahedron();
    root["nodes"][0]["skin"] = 0.into();
    let primitives = root["meshes"][0]["primitives"].as_array_mut().unwrap();
    primitives[0]["targets"] = json!([{"POSITION": 0}]);
    primitives.push(json!({"attributes": {"POSITION": 0}, "mode": 0}));
    let contents = read_bytes(&glb(&root, &buffer())).unwrap();
    assert_eq!(contents.n_facets, 4);
    let warnings = [
        "1 primitives of lines or points are passed over",
        "1 nodes have a skin; they are read in the pose in which they were modelled, so that place and size may be off",
        "1 primitives have morph targets; they are read without them",
    ];
    assert_eq!(contents.warnings, warnings);
}

#[test]
fn the_build_of_a_3mf_places_objects() {
    let parts = "<object id='5'><components><component objectid='1' transform='0 2 0 -1 0 0 0 0 1 10 0 0'/>\
        <component objectid='1'/></components></object>";
    let objects = object(1, "name='a &amp; b' type='model'") + parts;
    let items = "<item objectid='1'/><item objectid='5' transform='-1 0 0 0 1 0 0 0 1 0 0 5'/>";
    let bytes = three_mf("unit='inch'", &objects, items);
    assert_eq!(read_bytes(&bytes).unwrap().unit, Some("in"));
    let turned = |of: Vec<[[f32; 3]; 3]>| of.into_iter().map(|[a, b, c]| [a, c, b]).collect::<Vec<_>>();
    let placed = turned(moved(|[x, y, z]| [-(10.0 - y), 2.0 * x, z + 5.0]));
    let plain = turned(moved(|[x, y, z]| [0.0 - x, y, z + 5.0]));
    assert_eq!(facets_of(&bytes), [("a & b".to_string(), moved(|at| at)), (String::new(), [placed, plain].concat())]);
}

#[test]
fn objects_may_lie_in_other_files_of_the_archive() {
    let first = model(
        "xmlns:p='http://schemas.microsoft.com/3dmanufacturing/production/2015/06' requiredextensions='p'",
        "<object id='9' name='whole'><components><component p:path='/3D/Objects/One &amp; only.model' objectid='1'/></components></object>",
        "<item objectid='9'/><item p:path='/3D/Objects/One.model' objectid='1' printable='0'/>",
    );
    let files = [
        ("_rels/.rels", RELATIONS),
        ("3D/here.model", &first[..]),
        ("3D/Objects/One & only.model", &model("", &object(1, ""), "")),
        ("3D/Objects/One.model", &model("", &object(1, ""), "")),
    ];
    let contents = read_bytes(&package(&files)).unwrap();
    assert_eq!((contents.solids[0].name.as_str(), contents.n_facets), ("whole", 4));
    assert_eq!(contents.warnings, ["1 items that are not to be printed are left out"]);
    let inches = model("unit='inch'", &object(1, ""), "");
    let unlike = package(&[files[0], files[1], files[2], ("3D/Objects/One.model", &inches)]);
    assert!(message(&unlike).contains("is in mm and 3d/objects/one.model in in"), "{}", message(&unlike));
}

#[test]
fn what_is_wrong_with_a_3mf_is_said() {
    let item = "<item objectid='1'/>";
    let support = object(1, "type='support'") + &object(2, "");
    let contents = read_bytes(&three_mf("", &support, "<item objectid='1'/><item objectid='2'/>")).unwrap();
    assert_eq!(
        (contents.n_facets, &contents.warnings[..]),
        (
            4,
            &["1 supports and modifiers (objects of type support, solidsupport or other) are left out".to_string()][..]
        )
    );
    let modifier = object(1, "type='other'")
        + "<object id='2'><components><component objectid='1'/><component objectid='3'/></components></object>"
        + &object(3, "");
    let contents = read_bytes(&three_mf("", &modifier, "<item objectid='2'/>")).unwrap();
    assert_eq!((contents.n_facets, contents.warnings.len()), (4, 1));
    // 2^59 placings of nothing, in a few kilobytes
    let twice = |id: u32| {
        format!(
            "<object id='{id}'><components><component objectid='{0}'/><component objectid='{0}'/></components></object>",
            id - 1
        )
    };
    let doubled = object(1, "type='support'") + &(2..=60).map(twice).collect::<String>();
    let slices = object(1, "").replace("<object", "<object s:meshresolution='lowres'");
    let around = "<object id='1'><components><component objectid='1'/></components></object>";
    let beams = object(1, "").replace("</mesh>", "<b:beamlattice minlength='1'/></mesh>");
    let cases = [
        (three_mf("unit='ell'", &object(1, ""), item), "\"ell\" is none of its units"),
        (three_mf("", &object(1, ""), ""), "its build has no item"),
        (three_mf("", "", item), "3d/here.model has no object 1"),
        (three_mf("", around, item), "objects are nested more than 100 deep"),
        (three_mf("", &beams, item), "it has a beam lattice"),
        (three_mf("", &slices, item), "an object is made of slices"),
        (three_mf("", &doubled, "<item objectid='60'/>"), "536870912 corners and facets in all, copies among them"),
        (
            three_mf("xmlns:sc='http://x/securecontent/2019/04' requiredextensions='sc'", "", ""),
            "needs the extension sc (http://x/securecontent/2019/04)",
        ),
        (three_mf("", &object(1, "").replace("v3='3'", "v3='4'"), item), "there is no corner 4 of 4, counted from 0"),
        (three_mf("", &object(1, "").replace("x='1'", "x='one'"), item), "an element \"vertex\" has no number \"x\""),
        (
            three_mf("", &object(1, ""), "<item objectid='1' transform='1 0 0'/>"),
            "transform=\"1 0 0\" is not 12 numbers",
        ),
        (package(&[("a.txt", "text"), ("b.txt", "text")]), "a ZIP archive of 2 files without a model of 3MF"),
        (
            package(&[("_rels/.rels", RELATIONS), ("3D/here.model", "<model><resources></build></model>")]),
            "3d/here.model: ",
        ),
        (package(&[("_rels/.rels", RELATIONS), ("3D/here.model", "<svg/>")]), "the first element is not \"model\""),
    ];
    for (bytes, expected) in cases {
        let found = message(&bytes);
        assert!(found.contains(expected), "{expected}: {found}");
    }
    let whole = three_mf("", &object(1, ""), item);
    assert!(message(&whole[..whole.len() - 30]).contains("the ZIP archive is damaged"));
    // a byte of the packed model
    let mut damaged = whole.clone();
    let mut places = (0..whole.len() - 13).filter(|&at| &whole[at..at + 13] == b"3D/here.model");
    damaged[places.nth(1).unwrap() + 60] ^= 0x40;
    assert!(message(&damaged).starts_with("3d/here.model: 3MF: "), "{}", message(&damaged));
}
