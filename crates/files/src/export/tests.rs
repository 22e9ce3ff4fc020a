//! Exporters against what a reader of their text or bytes finds, cell by cell, on a mesh that looks different along every axis.

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::path::PathBuf;

use super::*;
use hexcast_core::base::error::Error;
use hexcast_derived::testing::{parts, pattern, pattern_flag, pattern_flags};

mod facts;
mod fields;
mod solids;
mod surfaces;

/// Files in memory; those that need a place in a folder.
struct Held {
    files: BTreeMap<String, Vec<u8>>,
    folder: tempfile::TempDir,
}

impl Default for Held {
    fn default() -> Held {
        Held { files: BTreeMap::new(), folder: tempfile::tempdir().unwrap() }
    }
}

impl Files for Held {
    fn create(&mut self, name: &str) -> Result<Box<dyn Write + '_>> {
        assert!(!self.files.contains_key(name), "{name} is written twice");
        Ok(Box::new(self.files.entry(name.to_string()).or_default()))
    }

    fn place(&mut self, name: &str) -> Result<PathBuf> {
        Ok(self.folder.path().join(name))
    }
}

/// The pattern with substances: flag 1 is a conductor, the others insulate.
fn made_of(axis: usize) -> Mesh {
    let mut mesh = pattern(axis, DIMS, 3);
    parts(&mut mesh).names[0].material.pec = true;
    for (index, flag, eps_r) in [(1, 2, 2.25), (2, 3, 4.5)] {
        parts(&mut mesh).names.insert(index, hexcast_derived::mesh::Named::new(flag, format!("flag_{flag}")));
        parts(&mut mesh).names[index].material.eps_r = Some(eps_r);
    }
    mesh
}

const DIMS: [u32; 3] = [9, 5, 7];

fn exported(mesh: &Mesh, exporter: Exporter, name: &str, options: &ExportOptions) -> Result<BTreeMap<String, Vec<u8>>> {
    let mut files = Held::default();
    export(mesh, exporter, name, options, &mut files, &Control::default())?;
    for entry in std::fs::read_dir(files.folder.path()).unwrap().flatten() {
        let name = entry.file_name().into_string().unwrap();
        assert!(files.files.insert(name, std::fs::read(entry.path()).unwrap()).is_none());
    }
    let mut expected = exporter.file_names(name);
    expected.sort();
    assert_eq!(files.files.keys().cloned().collect::<Vec<_>>(), expected);
    Ok(files.files)
}

fn text_of(mesh: &Mesh, exporter: Exporter, name: &str, options: &ExportOptions) -> String {
    String::from_utf8(exported(mesh, exporter, name, options).unwrap().remove(name).unwrap()).unwrap()
}

#[test]
fn an_exporter_is_found_by_the_end_of_a_path() {
    let table = [
        ("a.foam", Some(Exporter::Foam)),
        ("x/constant/polyMesh", Some(Exporter::Foam)),
        ("constant/polyMesh/", Some(Exporter::Foam)),
        ("C:\\run\\constant\\polyMesh", Some(Exporter::Foam)),
        ("polyMesh", None),
        ("myconstant/polyMesh", None),
        ("beam.INP", Some(Exporter::Abaqus)),
        (".inp", None),
        ("a.msh", Some(Exporter::Gmsh)),
        ("a.nrrd", Some(Exporter::Nrrd)),
        ("a.xdmf", Some(Exporter::Xdmf)),
        ("board.csx.xml", Some(Exporter::Csx)),
        ("board.xml", None),
        ("run/geometry.xml", Some(Exporter::Openmc)),
        ("geometry.xml", Some(Exporter::Openmc)),
        ("mygeometry.xml", None),
        ("soil.in", Some(Exporter::Gprmax)),
        ("case.eb/", Some(Exporter::Amrex)),
        ("a.vox", Some(Exporter::Vox)),
        ("a.glb", Some(Exporter::Glb)),
        ("part.STL", Some(Exporter::Stl)),
        ("a.binvox", Some(Exporter::Binvox)),
        ("a.raw", None),
        ("nrrd", None),
    ];
    for (path, expected) in table {
        assert_eq!(Exporter::of_name(path), expected, "{path}");
    }
    assert!(Exporter::ALL.iter().all(|exporter| Exporter::ENDINGS.iter().any(|(_, other)| other == exporter)));
}

#[test]
fn an_embedded_boundary_needs_surfaces() {
    let options = ExportOptions::default();
    let error = Exporter::Amrex.check(&pattern(0, DIMS, 3), &options).unwrap_err();
    assert_eq!(error.code(), "job-conflict");
    assert!(error.to_string().contains("where surfaces cross its lines"), "{error}");
}

#[test]
fn nrrd_has_a_header_and_all_flags() {
    for axis in 0..3 {
        let mesh = pattern(axis, DIMS, 3);
        let options = ExportOptions::default().with_slab_bytes(50);
        let bytes = exported(&mesh, Exporter::Nrrd, "a.nrrd", &options).unwrap().remove("a.nrrd").unwrap();
        assert_eq!(exact_size(&mesh, Exporter::Nrrd, &options), Some(bytes.len() as u64));
        let end = bytes.windows(2).position(|two| two == b"\n\n").unwrap() + 2;
        assert_eq!(bytes[end..], pattern_flags(DIMS, 3));
        let header = std::str::from_utf8(&bytes[..end]).unwrap();
        for line in
            ["sizes: 9 5 7", "space directions: (0.5,0,0) (0,0.25,0) (0,0,0.3333333333333333)", "flag 1:=copper"]
        {
            assert!(header.lines().any(|other| other == line), "{header}");
        }
        let origin = header.lines().find_map(|line| line.strip_prefix("space origin: (-1.25,0.225,")).unwrap();
        assert!((origin.trim_end_matches(')').parse::<f64>().unwrap() - (1e-7 + 1.0 / 6.0)).abs() < 1e-15);
    }
    let mut mesh = pattern(0, DIMS, 3);
    *parts(&mut mesh).lines = mesh.lines().as_lists();
    assert_eq!(
        exported(&mesh, Exporter::Nrrd, "a.nrrd", &ExportOptions::default()).unwrap_err().code(),
        "lines-graded"
    );
}

#[test]
fn a_unit_is_needed_where_lengths_are_metres_and_flags_must_be_there() {
    let mut mesh = pattern(0, DIMS, 3);
    let code = |mesh: &Mesh, exporter, options: &ExportOptions| {
        exported(mesh, exporter, "a.foam", options).map_err(|error| error.code()).err()
    };
    let some = |flags: &[u8]| ExportOptions::default().with_flags(flags.to_vec());
    assert_eq!(code(&mesh, Exporter::Foam, &some(&[1, 9])), Some("job-conflict"));
    assert_eq!(code(&mesh, Exporter::Gmsh, &some(&[])), Some("job-conflict"));
    for unit in [None, Some("furlong".to_string())] {
        *parts(&mut mesh).unit = unit;
        assert_eq!(code(&mesh, Exporter::Foam, &some(&[1])), Some("export-unit"));
        assert_eq!(code(&mesh, Exporter::Abaqus, &some(&[1])), Some("export-unit"));
        assert_eq!(exporter_error(&mesh), None);
    }
}

fn exporter_error(mesh: &Mesh) -> Option<Error> {
    exported(mesh, Exporter::Gmsh, "a.foam", &ExportOptions::default()).err()
}

#[test]
fn names_are_plain_and_each_is_there_once() {
    let mut mesh = pattern(0, DIMS, 3);
    let named = [
        (1, "cu"),
        (2, "CU"),
        (3, "xmin"),
        (4, "a b"),
        (5, "a_b"),
        (6, "7"),
        (7, "flag_9"),
        (0, "Luft & Äther"),
        (8, ""),
    ];
    *parts(&mut mesh).names = named.map(|(flag, name)| hexcast_derived::mesh::Named::new(flag, name)).to_vec();
    let all = names::names(&mesh, 16, &["xMin"]);
    let expected = ["Luft____ther", "cu", "CU_2", "xmin_3", "a_b", "a_b_5", "f_7", "flag_9", "f_", "flag_9_9"];
    assert_eq!(all[..10], expected);
    assert!(all.iter().all(|name| name.len() <= 16));
    let distinct: std::collections::BTreeSet<String> = all.iter().map(|name| name.to_lowercase()).collect();
    assert_eq!(distinct.len(), 256);
}

#[test]
fn cancel_stops_and_a_full_disk_is_said() {
    struct Full;
    impl Write for Full {
        fn write(&mut self, _: &[u8]) -> io::Result<usize> {
            Err(io::Error::other("no room"))
        }
        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }
    impl Files for Full {
        fn create(&mut self, _: &str) -> Result<Box<dyn Write + '_>> {
            Ok(Box::new(Full))
        }
        fn place(&mut self, _: &str) -> Result<PathBuf> {
            Err(Error::new("io", "no room", ""))
        }
    }
    let mut mesh = made_of(0);
    *parts(&mut mesh).lines = hexcast_core::grid::lines::Lines::new([0.0; 3], [0.5; 3], DIMS).unwrap();
    // an embedded boundary is made of surfaces, which this mesh does not know
    for exporter in Exporter::ALL.into_iter().filter(|exporter| !exporter.is_boundary()) {
        let options = ExportOptions::default();
        let error = export(&mesh, exporter, "a", &options, &mut Full, &Control::default()).unwrap_err();
        assert!(error.code() == "io" && error.to_string().contains("no room"), "{exporter:?}: {error}");
        let control = Control::default();
        control.cancel.cancel();
        assert_eq!(export(&mesh, exporter, "a", &options, &mut Held::default(), &control), Err(Error::Cancelled));
    }
}
