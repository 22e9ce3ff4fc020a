//! Points, faces and elements, read back and compared with the flags by the middles and volumes of cells.

use super::*;
use hexcast_derived::testing::parts;

/// Flag of each exported cell by its middle, rounded to a millionth.
pub(super) type Cells = BTreeMap<[i64; 3], u8>;

/// What must come out: cells of these flags, `scale` times as large as the mesh.
pub(super) fn expected(flags: &[u8], scale: f64) -> Cells {
    let mesh = pattern(0, DIMS, 3);
    let mut cells = Cells::new();
    for z in 0..DIMS[2] {
        for y in 0..DIMS[1] {
            for x in 0..DIMS[0] {
                let flag = pattern_flag([x, y, z], 3);
                if flags.contains(&flag) {
                    let at = [x, y, z];
                    cells.insert(key([0, 1, 2].map(|axis| scale * mesh.lines().centre(axis, at[axis]))), flag);
                }
            }
        }
    }
    cells
}

pub(super) fn key(middle: [f64; 3]) -> [i64; 3] {
    middle.map(|number| (number * 1e9).round() as i64)
}

pub(super) fn middle(corners: &[[f64; 3]]) -> [f64; 3] {
    [0, 1, 2].map(|axis| corners.iter().map(|corner| corner[axis]).sum::<f64>() / corners.len() as f64)
}

/// Six times the volume of a cell by its corners below and above, against the clock from above: positive where the order is right.
pub(super) fn volume(corners: &[[f64; 3]]) -> f64 {
    let edge = |to: usize| [0, 1, 2].map(|axis| corners[to][axis] - corners[0][axis]);
    let ([a, b, c], [d, e, f], [g, h, i]) = (edge(1), edge(3), edge(4));
    a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
}

pub(super) const CELL: f64 = 0.5 * 0.25 / 3.0;

#[test]
fn an_abaqus_file_has_the_cells_sets_and_surfaces() {
    for axis in 0..3 {
        for flags in [vec![1, 2, 3], vec![0], vec![2, 0]] {
            let mut mesh = pattern(axis, DIMS, 3);
            parts(&mut mesh).names[0].material.youngs_modulus = Some(2.1e11);
            parts(&mut mesh).names[0].material.nu = Some(0.3);
            let options = ExportOptions::default().with_flags(flags.clone()).with_slab_bytes(40);
            let text = text_of(&mesh, Exporter::Abaqus, "a.inp", &options);
            let (mut points, mut elements, mut found) = (BTreeMap::new(), BTreeMap::new(), Cells::new());
            let (mut sets, mut surfaces) = (BTreeMap::<String, Vec<u64>>::new(), BTreeMap::<String, u64>::new());
            let mut section = String::new();
            for line in text.lines() {
                assert!(
                    line.split(',').all(|field| field.trim().len() <= 20) || line.starts_with(['*', 'h']),
                    "{line}"
                );
                if line.starts_with('*') {
                    section = line.to_string();
                    continue;
                }
                let numbers: Vec<f64> = line.split(',').filter_map(|field| field.trim().parse().ok()).collect();
                let name = section.rsplit('=').next().unwrap().to_string();
                if section.starts_with("*NODE") {
                    points.insert(numbers[0] as u64, [numbers[1], numbers[2], numbers[3]]);
                } else if let Some(name) = section.strip_prefix("*ELEMENT, TYPE=C3D8I, ELSET=") {
                    let flag =
                        ["background", "copper", "flag_2", "flag_3"].iter().position(|other| *other == name).unwrap()
                            as u8;
                    let corners: Vec<[f64; 3]> = numbers[1..].iter().map(|point| points[&(*point as u64)]).collect();
                    assert!((volume(&corners) / (CELL * 1e-9) - 1.0).abs() < 1e-9);
                    assert_eq!(found.insert(key(middle(&corners)), flag), None);
                    elements.insert(numbers[0] as u64, flag);
                } else if section.starts_with("*NSET") {
                    sets.entry(name).or_default().extend(numbers.iter().map(|number| *number as u64));
                } else if section.starts_with("*SURFACE") {
                    *surfaces.entry(section.clone()).or_default() += 1;
                    assert!(elements.contains_key(&(numbers[0] as u64)));
                }
            }
            assert_eq!(found, expected(&flags, 1e-3), "axis {axis}, {flags:?}");
            let used: std::collections::BTreeSet<u64> = sets["XMIN"].iter().copied().collect();
            let on_side = |point: &[f64; 3]| (point[0] + 1.5e-3).abs() < 1e-12;
            assert_eq!(used, points.iter().filter(|(_, at)| on_side(at)).map(|(number, _)| *number).collect());
            assert_eq!(surfaces.len(), flags.len());
            assert_eq!(text.contains("*ELASTIC\n2.100000000000e11, 3.000000000000e-1\n"), flags.contains(&1));
        }
    }
}

#[test]
fn a_gmsh_file_has_the_cells() {
    for (axis, flags) in [(0, vec![1, 2, 3]), (1, vec![0, 3]), (2, vec![2])] {
        let mesh = pattern(axis, DIMS, 3);
        let options = ExportOptions::default().with_flags(flags.clone()).with_ascii(true).with_slab_bytes(40);
        let text = text_of(&mesh, Exporter::Gmsh, "a.msh", &options);
        let section = |name: &str| {
            let start = text.find(&format!("${name}\n")).unwrap() + name.len() + 2;
            let end = text.find(&format!("$End{name}\n")).unwrap();
            let lines = text[start..end].lines().filter(|line| !line.trim().is_empty());
            lines
                .map(|line| line.split_whitespace().map(|n| n.parse::<f64>().unwrap()).collect::<Vec<f64>>())
                .collect::<Vec<_>>()
        };
        let nodes = section("Nodes");
        let n = nodes[0][1] as usize;
        assert_eq!(nodes.len(), 2 + 2 * n);
        let point = |number: f64| <[f64; 3]>::try_from(nodes[1 + n + number as usize].clone()).unwrap();
        let mut found = Cells::new();
        let mut flag = 0;
        for line in &section("Elements")[1..] {
            if line.len() == 4 {
                flag = (line[1] as u64 % 256) as u8;
                continue;
            }
            let corners: Vec<[f64; 3]> = line[1..].iter().map(|number| point(*number)).collect();
            assert!((volume(&corners) / CELL - 1.0).abs() < 1e-9);
            assert_eq!(found.insert(key(middle(&corners)), flag), None);
        }
        assert_eq!(found, expected(&flags, 1.0), "axis {axis}, {flags:?}");
        let binary = ExportOptions { ascii: false, ..options };
        assert!(
            exported(&mesh, Exporter::Gmsh, "a.msh", &binary).unwrap()["a.msh"]
                .starts_with(b"$MeshFormat\n4.1 1 8\n\x01\0\0\0\n")
        );
    }
}

/// The items of a list of a polyMesh in text.
fn list(text: &str) -> Vec<Vec<f64>> {
    let body = &text[text.find("\n(\n").unwrap() + 3..text.rfind("\n)").unwrap()];
    let plain = |line: &str| line.replace("4(", " ").replace(['(', ')'], " ");
    body.lines().map(|line| plain(line).split_whitespace().map(|n| n.parse().unwrap()).collect()).collect()
}

#[test]
fn a_poly_mesh_has_the_cells_and_its_faces_are_in_order() {
    for (axis, flags) in [(0, vec![1, 2, 3]), (1, vec![0]), (2, vec![0, 2])] {
        let mesh = pattern(axis, DIMS, 3);
        let options = ExportOptions::default().with_flags(flags.clone()).with_ascii(true).with_slab_bytes(40);
        let files = exported(&mesh, Exporter::Foam, "a.foam", &options).unwrap();
        let text = |name: &str| String::from_utf8(files[&format!("constant/polyMesh/{name}")].clone()).unwrap();
        let points = list(&text("points"));
        let (faces, owner, neighbour) = (list(&text("faces")), list(&text("owner")), list(&text("neighbour")));
        assert_eq!((faces.len(), files["a.foam"].len()), (owner.len(), 0));
        let pairs: Vec<(f64, f64)> = owner.iter().zip(&neighbour).map(|(a, b)| (a[0], b[0])).collect();
        assert!(pairs.is_sorted() && pairs.iter().all(|(a, b)| a < b));
        let expected = expected(&flags, 1e-3);
        let n_cells = expected.len();
        let (mut volumes, mut middles, mut sides) = (vec![0.0; n_cells], vec![[0.0; 3]; n_cells], vec![0; n_cells]);
        for (index, face) in faces.iter().enumerate() {
            let at: Vec<&Vec<f64>> = face.iter().map(|&point| &points[point as usize]).collect();
            let [a, b, c] = [0, 1, 2].map(|axis| at[1][axis] - at[0][axis]);
            let [d, e, f] = [0, 1, 2].map(|axis| at[3][axis] - at[0][axis]);
            let area = [b * f - c * e, c * d - a * f, a * e - b * d];
            let middle = [0, 1, 2].map(|axis| at.iter().map(|point| point[axis]).sum::<f64>() / 4.0);
            let outward = (0..3).map(|axis| area[axis] * middle[axis]).sum::<f64>() / 3.0;
            let ends = [(Some(&owner[index]), 1.0), (neighbour.get(index), -1.0)];
            for (cell, sign) in ends.into_iter().filter_map(|(cell, sign)| Some((cell?[0] as usize, sign))) {
                volumes[cell] += sign * outward;
                sides[cell] += 1;
                (0..3).for_each(|axis| middles[cell][axis] += middle[axis] / 6.0);
            }
        }
        assert!(sides.iter().all(|n| *n == 6));
        assert!(volumes.iter().all(|volume| (volume / (CELL * 1e-9) - 1.0).abs() < 1e-6));
        let used: std::collections::BTreeSet<u64> = faces.iter().flatten().map(|point| *point as u64).collect();
        assert_eq!(used.len(), points.len());
        assert_eq!(
            middles.iter().map(|middle| key(*middle)).collect::<std::collections::BTreeSet<_>>(),
            expected.keys().copied().collect()
        );
        // zones: the flags of the numbers of cells
        let zones = text("cellZones");
        for (name, flag) in [("background", 0), ("copper", 1), ("flag_2", 2), ("flag_3", 3)] {
            let Some(start) = zones.find(&format!("\n{name}\n{{")) else {
                assert!(!flags.contains(&flag));
                continue;
            };
            let rest = &zones[start..];
            let body = &rest[rest.find("\n(\n").unwrap() + 3..rest.find("\n)").unwrap()];
            for cell in body.lines().map(|line| line.parse::<usize>().unwrap()) {
                assert_eq!(expected[&key(middles[cell])], flag);
            }
            assert_eq!(body.lines().count(), expected.values().filter(|other| **other == flag).count());
        }
        let (boundary, mut next) = (text("boundary"), neighbour.len());
        let number = |line: &str, word: &str| {
            line.trim().strip_prefix(word).map(|n| n.trim_end_matches(';').trim().parse::<usize>().unwrap())
        };
        let counts: Vec<usize> = boundary.lines().filter_map(|line| number(line, "nFaces")).collect();
        for (start, n) in boundary.lines().filter_map(|line| number(line, "startFace")).zip(counts) {
            assert_eq!(start, next);
            next += n;
        }
        assert_eq!(next, faces.len());
    }
}
