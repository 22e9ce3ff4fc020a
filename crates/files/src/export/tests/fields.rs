//! Files for electromagnetic and neutron codes, and to look at: every cell read back by a small reader of each format.

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};
use rust_hdf5::H5File;

use super::*;
use hexcast_derived::testing::{parts, pattern_flags};

/// The pattern with cubes for cells.
fn cubic(axis: usize) -> Mesh {
    let mut mesh = made_of(axis);
    *parts(&mut mesh).lines = hexcast_core::grid::lines::Lines::new([-1.5, 0.1, 1e-7], [0.5; 3], DIMS).unwrap();
    mesh
}

/// Elements of a document with their attributes and the text in them; an element that ends is `/` + its name.
fn elements(text: &str) -> Vec<(String, BTreeMap<String, String>, String)> {
    let mut reader = Reader::from_str(text);
    let mut all: Vec<(String, BTreeMap<String, String>, String)> = Vec::new();
    let read = |start: &BytesStart| {
        let pairs = start.attributes().map(|pair| {
            let pair = pair.unwrap();
            let value = pair.normalized_value(quick_xml::XmlVersion::default()).unwrap().into_owned();
            (String::from_utf8(pair.key.0.to_vec()).unwrap(), value)
        });
        (String::from_utf8(start.name().0.to_vec()).unwrap(), pairs.collect(), String::new())
    };
    loop {
        match reader.read_event().unwrap() {
            Event::Start(start) | Event::Empty(start) => all.push(read(&start)),
            Event::End(end) => all.push((
                format!("/{}", String::from_utf8(end.name().0.to_vec()).unwrap()),
                BTreeMap::new(),
                String::new(),
            )),
            Event::Text(text) => {
                if let Some(last) = all.last_mut() {
                    last.2 += &text.decode().unwrap();
                }
            }
            Event::Eof => return all,
            _ => {}
        }
    }
}

fn numbers(text: &str) -> Vec<f64> {
    text.split([',', ' ', '\n']).filter(|word| !word.is_empty()).map(|word| word.parse().unwrap()).collect()
}

#[test]
fn boxes_for_openems_are_the_cells_and_meet_no_other() {
    for (axis, flags) in [(0, vec![1, 2, 3]), (1, vec![0, 2]), (2, vec![3])] {
        let mut mesh = made_of(axis);
        parts(&mut mesh).names.push(hexcast_derived::mesh::Named::new(0, "air"));
        parts(&mut mesh).names.last_mut().unwrap().material.eps_r = Some(1.0006);
        let options = ExportOptions::default().with_flags(flags.clone()).with_slab_bytes(40);
        let text = text_of(&mesh, Exporter::Csx, "a.csx.xml", &options);
        let elements = elements(&text);
        let lines: Vec<Vec<f64>> = elements
            .iter()
            .filter(|(name, ..)| name.ends_with("Lines") && !name.starts_with('/'))
            .map(|one| numbers(&one.2))
            .collect();
        for (axis, lines) in lines.iter().enumerate() {
            let expected = mesh.lines().list(axis);
            assert_eq!(lines.len(), expected.len());
            // decimals within the rounding of numbers of 24 bits
            let most = expected.iter().fold(0.0, |most: f64, line| most.max(line.abs())) / f64::from(1 << 24);
            assert!(lines.iter().zip(&expected).all(|(line, other)| (line - other).abs() <= most), "{lines:?}");
        }
        let [nx, ny, _] = DIMS.map(|n| n as usize);
        let mut found = vec![None; pattern_flags(DIMS, 3).len()];
        let (mut flag, mut corners) = (0, Vec::new());
        for (name, attributes, _) in &elements {
            match name.as_str() {
                "RectilinearGrid" => assert_eq!(attributes["DeltaUnit"], "0.001"),
                "BackgroundMaterial" => {
                    assert_eq!(attributes["Epsilon"], if flags.contains(&0) { "1.0" } else { "1.0006" })
                }
                "Metal" | "Material" => {
                    flag = ["air", "copper", "flag_2", "flag_3"].iter().position(|n| *n == attributes["Name"]).unwrap();
                    assert_eq!(name == "Metal", flag == 1);
                }
                "Property" if flag == 2 => assert_eq!(attributes["Epsilon"], "2.25"),
                "Box" => assert_eq!(attributes["Priority"], if flag == 1 { "20" } else { "10" }),
                "P1" | "P2" => {
                    let at = |axis: usize, key: &str| {
                        let number: f64 = attributes[key].parse().unwrap();
                        lines[axis].iter().position(|line| *line == number).unwrap()
                    };
                    corners.push([at(0, "X"), at(1, "Y"), at(2, "Z")]);
                }
                "/Box" => {
                    let (high, low) = (corners.pop().unwrap(), corners.pop().unwrap());
                    for z in low[2]..high[2] {
                        for y in low[1]..high[1] {
                            for x in low[0]..high[0] {
                                assert_eq!(found[x + nx * (y + ny * z)].replace(flag as u8), None);
                            }
                        }
                    }
                }
                _ => {}
            }
        }
        let expected = pattern_flags(DIMS, 3).into_iter().map(|flag| Some(flag).filter(|flag| flags.contains(flag)));
        assert_eq!(found, expected.collect::<Vec<_>>(), "axis {axis}, {flags:?}");
    }
}

#[test]
fn a_cuboid_is_one_box() {
    let mut mesh = made_of(0);
    let cells = [(0, 9), (0, 5), (0, 7)].map(|(start, end)| start..end);
    assert_eq!(mesh.box_flags(&cells).unwrap().len(), 315);
    let rays = hexcast_core::grid::rays::Rays::new(2, DIMS);
    let mut band = hexcast_core::cells::columns::Band::default();
    for ray in 0..rays.n_rays() {
        if (2..6).contains(&(ray % 9)) && (1..4).contains(&(ray / 9)) {
            band.runs.extend([hexcast_core::cells::columns::run(3, 2), hexcast_core::cells::columns::run(6, 0)]);
        }
        band.ends.push(band.runs.len() as u32);
    }
    *parts(&mut mesh).columns = hexcast_core::cells::columns::Columns::new(rays, vec![band]).unwrap();
    let text = text_of(&mesh, Exporter::Csx, "a.csx.xml", &ExportOptions::default());
    assert_eq!(elements(&text).iter().filter(|(name, ..)| name == "Box").count(), 1);
}

/// A mesh with the faces of two plates: one of 3 x 2 faces with a notch, across z, and one of a single face, across x.
fn with_plates() -> Mesh {
    use hexcast_derived::staggered::SheetFace;
    let mut mesh = cubic(0);
    *parts(&mut mesh).lines = hexcast_core::grid::lines::Lines::new([-1.5, 0.5, 0.0], [0.5; 3], DIMS).unwrap();
    parts(&mut mesh).names.push(hexcast_derived::mesh::Named::new(9, "strip"));
    parts(&mut mesh).names.last_mut().unwrap().material.pec = true;
    let across_z = [[2, 1], [3, 1], [4, 1], [2, 2], [3, 2]].map(|[x, y]| SheetFace::new(2, [x, y, 7], 9));
    let plates = [SheetFace::new(0, [4, 0, 3], 9)].into_iter().chain(across_z).collect();
    mesh.with_plates(plates)
}

#[test]
fn plates_are_boxes_without_thickness_and_no_flag_of_theirs_is_left_out_silently() {
    let mesh = with_plates();
    let only = ExportOptions::default().with_flags(vec![9]);
    let text = text_of(&mesh, Exporter::Csx, "a.csx.xml", &only);
    let elements = elements(&text);
    let corner = |name: &str| {
        let of_name = elements.iter().filter(|(other, ..)| other == name);
        of_name
            .map(|(_, attributes, _)| ["X", "Y", "Z"].map(|key| attributes[key].parse::<f64>().unwrap()))
            .collect::<Vec<_>>()
    };
    let line = |place: [u32; 3]| [0, 1, 2].map(|axis| [-1.5, 0.5, 0.0][axis] + 0.5 * f64::from(place[axis]));
    let [x, row, rest] =
        [[[4, 0, 3], [4, 1, 4]], [[2, 1, 7], [5, 2, 7]], [[2, 2, 7], [4, 3, 7]]].map(|ends| ends.map(line));
    let both: Vec<[[f64; 3]; 2]> = corner("P1").into_iter().zip(corner("P2")).map(|(low, high)| [low, high]).collect();
    assert_eq!(both, [x, row, rest]);
    assert_eq!(elements.iter().filter(|(name, ..)| name == "Metal").count(), 1);
    let mut held = Held::default();
    export(&mesh, Exporter::Gprmax, "a.in", &ExportOptions::default(), &mut held, &Control::default()).unwrap();
    let input = String::from_utf8(held.files["a.in"].clone()).unwrap();
    let expected = "#plate: 0.002 0.0 0.0015 0.002 0.0005 0.002 pec\n#plate: 0.001 0.0005 0.0035 0.0025 0.001 0.0035 pec\n\
                    #plate: 0.001 0.001 0.0035 0.002 0.0015 0.0035 pec\n";
    assert!(input.ends_with(expected), "{input}");
    // of what conducts a little a program would need the thickness
    for (pec, sigma) in [(false, None), (false, Some(5.8e7))] {
        let mut mesh = with_plates();
        let material = &mut parts(&mut mesh).names.last_mut().unwrap().material;
        (material.pec, material.sigma) = (pec, sigma);
        for exporter in [Exporter::Csx, Exporter::Gprmax] {
            let error = exported(&mesh, exporter, "a.in", &ExportOptions::default()).unwrap_err();
            assert!(error.code() == "export-material" && error.to_string().contains("\"strip\""), "{error}");
            assert!(exporter.check(&mesh, &ExportOptions::default().with_flags(vec![1, 2])).is_ok());
        }
    }
    // as a column file has them
    let without = with_plates().with_plates(Vec::new());
    let lost = |mesh: &Mesh, exporter: Exporter, options: &ExportOptions| exporter.lost_conductors(mesh, options).len();
    assert_eq!(lost(&without, Exporter::Csx, &ExportOptions::default()), 1);
    assert_eq!(lost(&without, Exporter::Gprmax, &ExportOptions::default().with_flags(vec![1])), 0);
    assert_eq!(lost(&mesh, Exporter::Csx, &ExportOptions::default()), 0);
    // what holds cells alone says that there is none
    assert_eq!(exported(&mesh, Exporter::Foam, "a.foam", &only).unwrap_err().code(), "job-conflict");
}

#[test]
fn a_geometry_for_gprmax_has_the_cells() {
    for (axis, flags) in [(0, vec![1, 2, 3]), (1, vec![3, 1]), (2, vec![2])] {
        let mesh = cubic(axis);
        let options = ExportOptions::default().with_flags(flags.clone()).with_slab_bytes(300);
        let mut held = Held::default();
        export(&mesh, Exporter::Gprmax, "a b.in", &options, &mut held, &Control::default()).unwrap();
        let file = H5File::open(held.folder.path().join("a_b_geo.h5")).unwrap();
        let keys = file.dataset("material_keys").unwrap().read_vlen_strings().unwrap();
        let data = file.dataset("data").unwrap();
        assert_eq!(data.shape(), DIMS.map(|n| n as usize));
        let found = data.read_raw::<i16>().unwrap();
        let mut expected = Vec::new();
        let [nx, ny, nz] = DIMS;
        for (x, y, z) in (0..nx).flat_map(|x| (0..ny).flat_map(move |y| (0..nz).map(move |z| (x, y, z)))) {
            let flag = pattern_flag([x, y, z], 3);
            let name = ["air", "copper", "flag_2", "flag_3"][usize::from(flag)];
            let place = keys.iter().position(|key| key == name).filter(|_| flags.contains(&flag));
            expected.push(place.map_or(-1, |place| place as i16));
        }
        assert_eq!(found, expected, "axis {axis}, {flags:?}");
        let input = String::from_utf8(held.files["a b.in"].clone()).unwrap();
        let cell = file.dataset("data").map(|_| "#dx_dy_dz: 0.0005 0.0005 0.0005\n").unwrap();
        assert!(input.contains(cell) && input.contains("read: 0 0 0 a_b_geo.h5 a_b_materials y\n"), "{input}");
        let materials: serde_json::Value = serde_json::from_slice(&held.files["a_b_materials.json"]).unwrap();
        assert_eq!(materials["materials"].as_object().unwrap().len(), flags.len());
        let base = &materials["materials"]["flag_2"]["base"];
        assert_eq!(base["relative_permittivity"].as_f64(), flags.contains(&2).then_some(2.25));
    }
}

#[test]
fn an_xdmf_has_the_cells_and_their_corners() {
    for (axis, flags) in [(0, vec![1, 2, 3]), (1, vec![0]), (2, vec![3, 1])] {
        let mesh = pattern(axis, DIMS, 3);
        let options = ExportOptions::default().with_flags(flags.clone()).with_slab_bytes(40);
        let options = options.with_compress(crate::write::Compress::Zlib(1));
        let mut held = Held::default();
        export(&mesh, Exporter::Xdmf, "a.xdmf", &options, &mut held, &Control::default()).unwrap();
        let file = H5File::open(held.folder.path().join("a.h5")).unwrap();
        let points = file.dataset("points").unwrap().read_raw::<f64>().unwrap();
        let cells = file.dataset("cells").unwrap().read_raw::<u64>().unwrap();
        let found_flags = file.dataset("flag").unwrap().read_raw::<u8>().unwrap();
        let mut found = BTreeMap::new();
        for (corners, flag) in cells.chunks_exact(8).zip(&found_flags) {
            let corners: Vec<[f64; 3]> =
                corners.iter().map(|corner| points[3 * *corner as usize..][..3].try_into().unwrap()).collect();
            assert!((solids::volume(&corners) / solids::CELL - 1.0).abs() < 1e-9);
            assert_eq!(found.insert(solids::key(solids::middle(&corners)), *flag), None);
        }
        assert_eq!((cells.len(), found), (8 * found_flags.len(), solids::expected(&flags, 1.0)), "axis {axis}");
        let document = String::from_utf8(held.files["a.xdmf"].clone()).unwrap();
        let items: Vec<_> = elements(&document).into_iter().filter(|(name, ..)| name == "DataItem").collect();
        let dimensions =
            [format!("{} 8", found_flags.len()), format!("{} 3", points.len() / 3), found_flags.len().to_string()];
        assert_eq!(items.iter().map(|item| item.1["Dimensions"].clone()).collect::<Vec<_>>(), dimensions);
        assert_eq!(items[0].2, "a.h5:/cells");
        let names = ["flag 1", "flag 7", "unit"].map(|name| file.attr_string(name).unwrap());
        assert_eq!(names, ["copper", "Geh\u{e4}use <A&B> \"1\"", "mm"]);
    }
}

#[test]
fn a_lattice_for_openmc_has_the_cells_in_centimetres() {
    for (axis, flags) in [(0, vec![1, 2, 3]), (1, vec![0, 2])] {
        let mesh = pattern(axis, DIMS, 3);
        let options = ExportOptions::default().with_flags(flags.clone()).with_slab_bytes(40);
        let elements = elements(&text_of(&mesh, Exporter::Openmc, "geometry.xml", &options));
        let one = |name: &str| elements.iter().find(|(other, ..)| other == name).unwrap();
        assert_eq!(numbers(&one("pitch").2)[..2], [0.05, 0.025]);
        assert_eq!(numbers(&one("lower_left").2), [-0.15, 0.01, 1e-8]);
        assert_eq!(numbers(&one("dimension").2), DIMS.map(f64::from));
        let universes = numbers(&one("universes").2);
        let [nx, ny, nz] = DIMS;
        let mut expected = Vec::new();
        for z in 0..nz {
            for y in (0..ny).rev() {
                expected.extend((0..nx).map(|x| f64::from(pattern_flag([x, y, z], 3)) + 1.0));
            }
        }
        assert_eq!(universes, expected);
        for (_, cell, _) in elements.iter().filter(|(name, cell, _)| name == "cell" && cell.contains_key("material")) {
            let flag = cell["universe"].parse::<u8>().unwrap() - 1;
            let material = if flag == 0 { "256".to_string() } else { flag.to_string() };
            assert_eq!(cell["material"], if flags.contains(&flag) { material } else { "void".into() });
        }
        let planes: Vec<f64> = elements
            .iter()
            .filter(|(name, ..)| name == "surface")
            .map(|one| one.1["coeffs"].parse().unwrap())
            .collect();
        let ends = [-0.15, 0.3, 0.01, 0.135, 1e-8, 7.0 / 30.0 + 1e-8];
        assert!(planes.iter().zip(ends).all(|(a, b)| (a - b).abs() < 1e-15) && planes.len() == 6, "{planes:?}");
    }
}

#[test]
fn a_binvox_is_a_cube_with_the_cells() {
    for (axis, flags) in [(0, vec![1, 2, 3]), (1, vec![0]), (2, vec![3])] {
        let mesh = cubic(axis);
        let options = ExportOptions::default().with_flags(flags.clone()).with_slab_bytes(40);
        let bytes = exported(&mesh, Exporter::Binvox, "a.binvox", &options).unwrap().remove("a.binvox").unwrap();
        let header = b"#binvox 1\ndim 9 9 9\ntranslate -1.5 0.1 1e-7\nscale 4.5\ndata\n";
        let runs = bytes.strip_prefix(header).unwrap();
        let bits: Vec<u8> = runs.chunks_exact(2).flat_map(|run| vec![run[0]; usize::from(run[1])]).collect();
        let mut expected = Vec::new();
        for (x, z, y) in (0..9).flat_map(|x| (0..9).flat_map(move |z| (0..9).map(move |y| (x, z, y)))) {
            let is_inside = y < DIMS[1] && z < DIMS[2];
            expected.push(u8::from(is_inside && flags.contains(&pattern_flag([x, y, z], 3))));
        }
        assert_eq!(bits, expected, "axis {axis}, {flags:?}");
    }
    let refused = exported(&made_of(0), Exporter::Binvox, "a.binvox", &ExportOptions::default()).unwrap_err();
    assert_eq!(refused.code(), "lines-graded");
}

#[test]
fn a_vox_has_the_cells_that_are_shown() {
    let mesh = cubic(1);
    let options = ExportOptions::default().with_flags(vec![2, 3]).with_slab_bytes(40);
    let bytes = exported(&mesh, Exporter::Vox, "a.vox", &options).unwrap().remove("a.vox").unwrap();
    assert_eq!(bytes[16..20], (bytes.len() as u32 - 20).to_le_bytes());
    assert_eq!(bytes[32..44], [9, 0, 0, 0, 5, 0, 0, 0, 7, 0, 0, 0]);
    let n = u32::from_le_bytes(bytes[56..60].try_into().unwrap()) as usize;
    let found: Vec<[u8; 4]> = bytes[60..60 + 4 * n].chunks_exact(4).map(|voxel| voxel.try_into().unwrap()).collect();
    let mut expected = Vec::new();
    for (z, y, x) in (0..7).flat_map(|z| (0..5).flat_map(move |y| (0..9).map(move |x| (z, y, x)))) {
        let flag = pattern_flag([x, y, z], 3);
        if flag >= 2 {
            expected.push([x as u8, y as u8, z as u8, flag]);
        }
    }
    assert_eq!(found, expected);
    let refused = exported(&mesh, Exporter::Vox, "a.vox", &options.with_flags(vec![0, 1])).unwrap_err();
    assert_eq!(refused.code(), "job-conflict");
}

#[test]
fn what_flags_are_made_of_must_be_said() {
    let code = |mesh: &Mesh, exporter, options: &ExportOptions| {
        exported(mesh, exporter, "a.in", options).map_err(|error| error.code()).err()
    };
    let options = ExportOptions::default();
    for exporter in [Exporter::Csx, Exporter::Gprmax] {
        let mut mesh = cubic(0);
        parts(&mut mesh).names[1].material.eps_r = None;
        // a density tells nothing of fields
        parts(&mut mesh).names[1].material.density = Some(2.0);
        assert_eq!(code(&mesh, exporter, &options), Some("export-material"));
        assert_eq!(code(&mesh, exporter, &options.clone().with_flags(vec![1])), None);
        parts(&mut mesh).names.push(hexcast_derived::mesh::Named::new(0, "metal"));
        parts(&mut mesh).names.last_mut().unwrap().material.pec = true;
        assert_eq!(code(&mesh, exporter, &options.clone().with_flags(vec![1])), Some("job-conflict"));
        assert_eq!(code(&mesh, exporter, &options.clone().with_flags(vec![0, 1])), None);
    }
    let mut mesh = cubic(0);
    parts(&mut mesh).names[1].material.eps_r = Some(0.5);
    assert_eq!(code(&mesh, Exporter::Gprmax, &options), Some("job-value"));
    *parts(&mut mesh).lines = mesh.lines().as_lists();
    for exporter in [Exporter::Gprmax, Exporter::Openmc, Exporter::Vox, Exporter::Binvox] {
        assert_eq!(code(&mesh, exporter, &options), Some("lines-graded"));
    }
    *parts(&mut mesh).unit = None;
    for exporter in [Exporter::Csx, Exporter::Gprmax, Exporter::Openmc] {
        assert_eq!(code(&mesh, exporter, &options), Some("export-unit"));
    }
}

#[test]
fn more_cells_than_a_format_numbers_are_refused_with_both_numbers() {
    // all cells have flag 1
    let dims = [2048, 1024, 1024];
    let rays = hexcast_core::grid::rays::Rays::new(0, dims);
    let mut band = hexcast_core::cells::columns::Band::default();
    for ray in 1..=rays.n_rays() {
        band.runs.push(hexcast_core::cells::columns::run(0, 1));
        band.ends.push(ray as u32);
    }
    let lines = hexcast_core::grid::lines::Lines::new([0.0; 3], [1.0; 3], dims).unwrap();
    let columns = hexcast_core::cells::columns::Columns::new(rays, vec![band]).unwrap();
    let mesh = Mesh::new(lines, columns, Vec::new(), Some("mm".into())).unwrap();
    for (exporter, number) in [(Exporter::Vox, "8589934592"), (Exporter::Openmc, "2147483648")] {
        let error = exporter.check(&mesh, &ExportOptions::default()).unwrap_err();
        assert_eq!(error.code(), "export-too-large");
        assert!([number, "2147483647"].iter().all(|number| error.to_string().contains(number)), "{error}");
    }
}
