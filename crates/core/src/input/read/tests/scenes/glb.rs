//! GLB.

use serde_json::{Value, json};

use super::*;

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
    // neither a smaller copy is mirrored nor one that is flat
    for scale in [[0.5, 0.5, 0.5], [1.0, 1.0, 0.0]] {
        let mut root = tetrahedron();
        root["nodes"][0]["scale"] = json!(scale);
        let small = moved(|at| [0, 1, 2].map(|axis| at[axis] * scale[axis] as f32));
        assert_eq!(facets_of(&glb(&root, &buffer()))[0].1, small);
    }
    // without scenes what is in no other node is shown
    let with_scenes = glb(&root, &buffer());
    root.as_object_mut().unwrap().remove("scenes");
    assert_eq!(facets_of(&glb(&root, &buffer())), facets_of(&with_scenes));
}

/// Twice the area of a facet in the plane z = 0, positive where it turns from x to y.
fn doubled_area([a, b, c]: &[[f32; 3]; 3]) -> f32 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
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
    // every other triangle of a strip is turned, also behind the third
    let many: Vec<[f32; 3]> = (0..7u8).map(|k| [f32::from(k / 2), f32::from(k % 2), 0.0]).collect();
    let bytes: Vec<u8> = many.as_flattened().iter().flat_map(|number| number.to_le_bytes()).collect();
    root["meshes"][0]["primitives"][0]["mode"] = 5.into();
    root["accessors"][0]["count"] = 7.into();
    root["bufferViews"][0]["byteLength"] = 84.into();
    let normals = facets_of(&glb(&root, &bytes))[0].1.iter().map(doubled_area).collect::<Vec<_>>();
    assert_eq!(normals, [-1.0; 5]);
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
    // the type, its size, the number that stands for 1, and whether -1 is there
    for (kind, size, most, is_signed) in
        [(5120, 1, 127i64, true), (5121, 1, 255, false), (5122, 2, 32767, true), (5123, 2, 65535, false)]
    {
        for is_normalized in [true, false] {
            let sign = if is_signed { -1 } else { 1 };
            let numbers = CORNERS.map(|at| [at[0] as i64 * most, at[1] as i64 * sign * most, at[2] as i64 * most, 9]);
            let bytes = numbers.as_flattened().iter().flat_map(|number| number.to_le_bytes()[..size].to_vec());
            let bytes: Vec<u8> = bytes.chain(buffer()[48..].to_vec()).collect();
            let mut root = tetrahedron();
            root["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
            root["accessors"][0] = json!({"bufferView": 0, "componentType": kind, "count": 4, "type": "VEC3"});
            root["accessors"][0]["normalized"] = is_normalized.into();
            root["bufferViews"] = json!([
                {"buffer": 0, "byteLength": 16 * size, "byteStride": 4 * size},
                {"buffer": 0, "byteOffset": 16 * size, "byteLength": 24},
            ]);
            let unit = if is_normalized { 1.0 } else { most as f32 };
            let expected = moved(|[x, y, z]| [unit * x, 0.0 + unit * sign as f32 * y, unit * z]);
            assert_eq!(facets_of(&glb(&root, &bytes))[0].1, expected, "{kind}, {is_normalized}");
        }
    }
}

#[test]
fn elements_may_lie_apart_and_those_without_bytes_are_zero() {
    // 252 bytes from corner to corner are the most that glTF allows
    let apart = |stride: usize| {
        let mut bytes = vec![9; 3 * stride + 12];
        for (place, corner) in bytes.chunks_mut(stride).zip(buffer().chunks(12)) {
            place[..12].copy_from_slice(corner);
        }
        let n = bytes.len().next_multiple_of(4);
        bytes.resize(n, 0);
        bytes.extend(&buffer()[48..]);
        let mut root = tetrahedron();
        root["bufferViews"] = json!([
            {"buffer": 0, "byteLength": n, "byteStride": stride},
            {"buffer": 0, "byteOffset": n, "byteLength": 24},
        ]);
        glb(&root, &bytes)
    };
    assert_eq!(facets_of(&apart(252))[0].1, moved(|at| at));
    assert!(message(&apart(253)).contains("elements of 12 bytes, 253 apart"), "{}", message(&apart(253)));
    // indices without bytes, as many as the file has bytes at most
    let mut root = tetrahedron();
    root["accessors"][1] = json!({"componentType": 5123, "count": 72, "type": "SCALAR"});
    assert_eq!(facets_of(&glb(&root, &buffer()))[0].1, [[CORNERS[0]; 3]; 24]);
    root["accessors"][1]["count"] = 73.into();
    assert!(message(&glb(&root, &buffer())).contains("73 elements and no bytes"));
}

#[test]
fn nodes_may_be_nested_five_hundred_deep() {
    let nested = |n: usize| {
        let mut root = tetrahedron();
        let mut nodes: Vec<Value> = (1..n).map(|child| json!({"children": [child]})).collect();
        nodes.push(json!({"mesh": 0}));
        root["nodes"] = json!(nodes);
        glb(&root, &buffer())
    };
    assert_eq!(facets_of(&nested(501))[0].1, moved(|at| at));
    assert_eq!(message(&nested(502)), "GLB: nodes are nested more than 500 deep");
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
        (
            "/accessors/0",
            json!({"bufferView": 0, "byteOffset": 1e6 as u64, "componentType": 5126, "count": 0, "type": "VEC3"}),
            "a triangle has corner 0, counted from 0, of 0",
        ),
        (
            "/accessors/0",
            json!({"bufferView": 0, "byteOffset": 40, "componentType": 5126, "count": 1, "type": "VEC3"}),
            "buffer view 0 holds fewer than 1 elements of 12 bytes",
        ),
        (
            "/accessors/0/sparse",
            json!({"count": 1, "indices": {"bufferView": 1}, "values": {"bufferView": 0}}),
            "indices have the type 0,",
        ),
        ("/meshes/0/primitives/0/mode", json!(7), "no facet among 0 corners of GLB"),
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
    // the last chunk is an empty description
    let empty = [&whole[..12], &0u32.to_le_bytes(), b"JSON"].concat();
    assert!(message(&empty).contains("its description is not that of glTF"), "{}", message(&empty));
    for cut in [12, 21, 400, whole.len() - 1] {
        assert!(message(&whole[..cut]).starts_with("GLB: "), "{cut}: {}", message(&whole[..cut]));
    }
    // the place is said once
    let mut far = buffer();
    far[..4].copy_from_slice(&f32::INFINITY.to_le_bytes());
    let found = message(&glb(&tetrahedron(), &far));
    assert!(
        found.contains("primitive 0: corner 0, counted from 0: a coordinate is ")
            && found.matches("node 0").count() == 1,
        "{found}"
    );
    // further chunks, whatever their kind, are passed over
    let mut longer = whole.clone();
    for kind in [b"JSON", b"BIN\0", b"MORE"] {
        longer.extend(4u32.to_le_bytes());
        longer.extend(kind);
        longer.extend([7; 4]);
    }
    assert_eq!(facets_of(&longer), facets_of(&whole));
    let end = 20 + u32::from_le_bytes([whole[12], whole[13], whole[14], whole[15]]) as usize;
    let second = [&whole[..end], &4u32.to_le_bytes(), b"JSON", &[7; 4], &whole[end..]].concat();
    assert_eq!(facets_of(&second), facets_of(&whole));
    let mut old = whole.clone();
    old[4] = 1;
    assert_eq!(message(&old), "GLB: its version is 1, and only 2 can be read");
    let mut root = tetrahedron();
    root["meshes"][0]["primitives"][0]["mode"] = 1.into();
    assert!(message(&glb(&root, &buffer())).contains("no facet"), "{}", message(&glb(&root, &buffer())));
}

#[test]
fn skins_and_lines_are_passed_over_with_a_warning() {
    let mut root = tetrahedron();
    root["nodes"][0]["skin"] = 0.into();
    let primitives = root["meshes"][0]["primitives"].as_array_mut().unwrap();
    primitives.push(json!({"attributes": {"POSITION": 0}, "mode": 0}));
    let contents = read_bytes(&glb(&root, &buffer())).unwrap();
    assert_eq!(contents.n_facets, 4);
    let warnings = [
        "1 primitives of lines or points are ignored",
        "1 nodes have a skin; they are read in the pose and at the place in which they were modelled, so that place and size may be off",
    ];
    assert_eq!(contents.warnings, warnings);
    root["extensionsUsed"] = json!(["KHR_node_visibility"]);
    let more = read_bytes(&glb(&root, &buffer())).unwrap().warnings;
    assert_eq!(more[2..], ["nodes may be hidden (KHR_node_visibility); they are read all the same"]);
}

#[test]
fn a_node_does_not_place_a_mesh_with_a_skin_but_what_is_in_it() {
    let mut root = tetrahedron();
    root["scenes"] = json!([{"nodes": [1]}]);
    root["nodes"] = json!([
        {"name": "skinned", "mesh": 0, "skin": 0, "translation": [5, 0, 0], "scale": [2, 2, 2], "children": [2]},
        {"translation": [0, 7, 0], "children": [0]},
        {"name": "child", "mesh": 0},
    ]);
    let found = facets_of(&glb(&root, &buffer()));
    assert_eq!(found[0], ("skinned".to_string(), moved(|at| at)));
    assert_eq!(found[1], ("child".to_string(), moved(|[x, y, z]| [5.0 + 2.0 * x, 7.0 + 2.0 * y, 2.0 * z])));
}

#[test]
fn morph_targets_move_corners_by_their_weights() {
    let mut root = tetrahedron();
    // the second target has a bytes' type of its own, as small files do, and moves all corners by 1 along y
    let mut bytes = buffer();
    bytes.extend([0, 127, 0, 9].repeat(4));
    root["buffers"][0]["byteLength"] = 88.into();
    let views = root["bufferViews"].as_array_mut().unwrap();
    views.push(json!({"buffer": 0, "byteOffset": 72, "byteLength": 16, "byteStride": 4}));
    let accessors = root["accessors"].as_array_mut().unwrap();
    accessors.push(json!({"bufferView": 2, "componentType": 5120, "normalized": true, "count": 4, "type": "VEC3"}));
    root["meshes"][0]["primitives"][0]["targets"] =
        json!([{"POSITION": 0}, {"POSITION": 2, "NORMAL": 9}, {"NORMAL": 9}]);
    let found = |root: &Value| {
        let contents = read_bytes(&glb(root, &bytes)).unwrap();
        assert!(contents.warnings.is_empty(), "{:?}", contents.warnings);
        facets_of(&glb(root, &bytes))[0].1.clone()
    };
    // without weights all are 0
    assert_eq!(found(&root), moved(|at| at));
    root["meshes"][0]["weights"] = json!([0.5, -2, 3]);
    assert_eq!(found(&root), moved(|[x, y, z]| [1.5 * x, 1.5 * y - 2.0, 1.5 * z]));
    // those of the node come before those of the mesh
    root["nodes"][0]["weights"] = json!([0, 1, 0]);
    assert_eq!(found(&root), moved(|[x, y, z]| [x, y + 1.0, z]));
    root["nodes"][0]["weights"] = json!([1]);
    assert!(message(&glb(&root, &bytes)).contains("there are 1 weights for 3 morph targets"));
    root["nodes"][0]["weights"] = json!([0, 1, 0]);
    root["accessors"][2]["count"] = 3.into();
    assert!(message(&glb(&root, &bytes)).contains("morph target 1 moves 3 corners of 4"));
}
