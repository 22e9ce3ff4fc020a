//! Surfaces, read back: each edge joins two triangles, the triangles at a corner form one ring, and the volume is that of the cells.

use super::solids::CELL;
use super::*;
use hexcast_derived::testing::mesh_of;
use serde_json::Value;

type Triangles = Vec<[u32; 3]>;

/// Name, flag, corners and triangles of each mesh of a GLB.
fn meshes(bytes: &[u8]) -> Vec<(String, u8, Vec<[f32; 3]>, Triangles)> {
    let number = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    assert_eq!((&bytes[..4], number(4), number(8)), (&b"glTF"[..], 2, bytes.len()));
    let n_text = number(12);
    assert_eq!((n_text % 4, &bytes[16..20]), (0, &b"JSON"[..]));
    let document: Value = serde_json::from_slice(&bytes[20..20 + n_text]).unwrap();
    let start = 28 + n_text;
    assert_eq!((number(20 + n_text), &bytes[24 + n_text..start]), (bytes.len() - start, &b"BIN\0"[..]));
    let words = |accessor: &Value| -> Vec<[u8; 4]> {
        let accessor = &document["accessors"][accessor.as_u64().unwrap() as usize];
        let view = &document["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
        let [at, n] = ["byteOffset", "byteLength"].map(|key| view[key].as_u64().unwrap() as usize);
        let parts = if accessor["type"] == "VEC3" { 3 } else { 1 };
        assert_eq!(n, 4 * parts * accessor["count"].as_u64().unwrap() as usize);
        bytes[start + at..start + at + n].as_chunks().0.to_vec()
    };
    let mesh = |of: &Value| {
        let primitive = &of["primitives"][0];
        let corners: Vec<f32> =
            words(&primitive["attributes"]["POSITION"]).into_iter().map(f32::from_le_bytes).collect();
        let triangles: Vec<u32> = words(&primitive["indices"]).into_iter().map(u32::from_le_bytes).collect();
        let flag = of["extras"]["flag"].as_u64().unwrap() as u8;
        (of["name"].as_str().unwrap().into(), flag, corners.as_chunks().0.to_vec(), triangles.as_chunks().0.to_vec())
    };
    document["meshes"].as_array().unwrap().iter().map(mesh).collect()
}

fn volume(corners: &[[f32; 3]], triangles: &Triangles) -> f64 {
    let at = |corner: u32| corners[corner as usize].map(f64::from);
    let six = |[a, b, c]: [[f64; 3]; 3]| {
        a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])
    };
    triangles.iter().map(|triangle| six(triangle.map(at))).sum::<f64>() / 6.0
}

/// Holds that a surface is a closed manifold without flat triangles.
fn check(corners: &[[f32; 3]], triangles: &Triangles) {
    let mut next = BTreeMap::new();
    for &[a, b, c] in triangles {
        let at = |corner: u32| corners[corner as usize];
        let [u, v] = [b, c].map(|to| [0, 1, 2].map(|axis| at(to)[axis] - at(a)[axis]));
        assert!((0..3).any(|axis| u[axis] * v[(axis + 1) % 3] != u[(axis + 1) % 3] * v[axis]), "flat");
        for edge in [[a, b, c], [b, c, a], [c, a, b]] {
            // around a corner, the triangle after an edge
            assert!(next.insert((edge[0], edge[1]), edge[2]).is_none(), "an edge has two triangles on one side");
        }
    }
    let mut degrees = vec![0; corners.len()];
    for &(from, to) in next.keys() {
        assert!(next.contains_key(&(to, from)), "an edge is open");
        degrees[from as usize] += 1;
    }
    let firsts: BTreeMap<u32, u32> = next.keys().copied().collect();
    for (corner, degree) in degrees.into_iter().enumerate() {
        let corner = corner as u32;
        let (first, mut n) = (firsts[&corner], 1);
        let mut at = next[&(corner, first)];
        while at != first {
            (at, n) = (next[&(corner, at)], n + 1);
        }
        assert_eq!(n, degree, "the triangles at a corner form one ring");
    }
}

#[test]
fn surfaces_of_glb_are_closed_manifolds_with_the_volumes_of_the_cells() {
    for axis in 0..3 {
        for flags in [vec![1, 2, 3], vec![0], vec![2, 0]] {
            let mesh = pattern(axis, DIMS, 3);
            let cells = mesh.columns().cells_per_flag();
            let options = ExportOptions::default().with_flags(flags.clone()).with_slab_bytes(40);
            let bytes = exported(&mesh, Exporter::Glb, "a.glb", &options).unwrap().remove("a.glb").unwrap();
            let made = meshes(&bytes);
            let mut wanted = flags.clone();
            wanted.sort_unstable();
            assert_eq!(made.iter().map(|(_, flag, ..)| *flag).collect::<Vec<_>>(), wanted);
            for (name, flag, corners, triangles) in &made {
                check(corners, triangles);
                let expected = cells[usize::from(*flag)] as f64 * CELL;
                assert!((volume(corners, triangles) / expected - 1.0).abs() < 1e-5, "{name}");
            }
            assert!(flags != [1, 2, 3] || made[0].0 == "copper");
        }
    }
}

/// All ways in which cells can meet at a point and along its edges.
#[test]
fn any_three_by_three_by_three_cells_have_a_closed_surface() {
    let mut seed = 1u64;
    for _ in 0..3000 {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        let bits = seed >> 37;
        let has = |x: u32, y: u32, z: u32| bits >> (x + 3 * y + 9 * z) & 1 == 1;
        let flags: Vec<u8> = (0..27).map(|at| u8::from(has(at % 3, at / 3 % 3, at / 9))).collect();
        if !flags.contains(&1) {
            continue;
        }
        let mesh = mesh_of(0, [3, 3, 3], |[x, y, z]| flags[(x + 3 * (y + 3 * z)) as usize]);
        let bytes =
            exported(&mesh, Exporter::Glb, "a.glb", &ExportOptions::default()).unwrap().remove("a.glb").unwrap();
        let [(_, 1, corners, triangles)] = &meshes(&bytes)[..] else { panic!("one surface") };
        check(corners, triangles);
        let n = flags.iter().filter(|flag| **flag == 1).count() as f64;
        // of cells of 0.5 x 0.25 x 0.125
        assert!((volume(corners, triangles) * 64.0 - n).abs() < 1e-4);
    }
}

#[test]
fn facets_of_stl_have_the_volumes_of_the_cells_as_text_and_binary() {
    let mesh = pattern(2, DIMS, 3);
    let cells = mesh.columns().cells_per_flag();
    let read = |options: &ExportOptions| {
        let bytes = exported(&mesh, Exporter::Stl, "a.stl", options).unwrap().remove("a.stl").unwrap();
        hexcast_core::read::read_bytes(&bytes).unwrap()
    };
    let of_solid = |facets: &[[[f32; 3]; 3]]| {
        let triangles = (0..facets.len() as u32).map(|facet| [0, 1, 2].map(|corner| 3 * facet + corner)).collect();
        volume(facets.as_flattened(), &triangles)
    };
    let binary = read(&ExportOptions::default());
    let text = read(&ExportOptions::default().with_ascii(true));
    assert_eq!((binary.n_facets, binary.wrong_normals, text.wrong_normals), (text.n_facets, 0, 0));
    assert!(binary.has_colours);
    let names: Vec<&str> = text.solids.iter().map(|solid| &solid.name[..]).collect();
    assert_eq!(names, ["copper", "flag_2", "flag_3"]);
    for (flag, solid) in (1..).zip(&text.solids) {
        let expected = cells[flag] as f64 * CELL;
        assert!((of_solid(solid.facets.in_memory("this").unwrap()) / expected - 1.0).abs() < 1e-4, "{}", solid.name);
    }
    let together = [1, 2, 3].map(|flag| cells[flag] as f64 * CELL).iter().sum::<f64>();
    assert!((of_solid(binary.solids[0].facets.in_memory("this").unwrap()) / together - 1.0).abs() < 1e-4);
}

#[test]
fn lines_that_are_equal_as_32_bit_numbers_are_refused() {
    let mut mesh = pattern(0, DIMS, 3);
    *parts(&mut mesh).lines = hexcast_core::grid::lines::Lines::new([1e9, 0.0, 0.0], [0.5; 3], DIMS).unwrap();
    let error = exported(&mesh, Exporter::Stl, "a.stl", &ExportOptions::default()).unwrap_err();
    assert_eq!((error.code(), error.to_string().contains("across x")), ("lines-too-fine", true), "{error}");
    // counted from the first line they differ
    exported(&mesh, Exporter::Glb, "a.glb", &ExportOptions::default()).unwrap();
}
