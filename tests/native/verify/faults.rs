//! Faults: wrong cells, wrong lines and wrong jobs are found and named; what cannot be checked is an error.

use hexcast::column_file;
use hexcast::columns::{Band, Columns, run};
use hexcast::job::{Fill, GeometryJob, GradedJob, HaloEdge, Job, Open, PartJob, PerAxis, Rule};
use hexcast::lines::Lines;
use hexcast::mesh::Mesh;

use super::super::cli::{Folder, SPOT, hexcast};
use super::super::models;
use super::super::open_surfaces::without;
use super::{AXES, Meshed};

/// The mesh of a file after its runs were changed: `change` gets each ray's index and the flags of its cells.
pub(super) fn changed(of: &Meshed, change: impl Fn(u64, &mut [u8])) -> Mesh {
    let mut bytes = &of.folder.bytes("mesh.hxc")[..];
    let mesh = column_file::read(&mut bytes, u64::MAX).expect("a column file");
    let rays = mesh.columns().rays();
    let mut band = Band::default();
    for ray in 0..rays.n_rays() {
        let runs = mesh.columns().ray(ray).expect("in memory").into_owned();
        let mut flags: Vec<u8> = (0..rays.depth).map(|cell| hexcast::columns::flag_at(&runs, cell)).collect();
        change(ray, &mut flags);
        let mut last = 0;
        for (cell, &flag) in (0u32..).zip(&flags) {
            if flag != last {
                band.runs.push(run(cell, flag));
            }
            last = flag;
        }
        band.ends.push(band.runs.len() as u32);
    }
    let columns = Columns::new(*rays, vec![band]).unwrap();
    let (lines, names) = (mesh.lines().clone(), mesh.names().to_vec());
    Mesh::new(lines, columns, names, mesh.unit().map(String::from)).unwrap()
}

fn spheres() -> Vec<models::Facets> {
    vec![models::sphere([4.0; 3], 3.1, 24), models::sphere([5.0, 4.5, 4.2], 2.0, 16)]
}

fn job() -> Job {
    set!(Job { dims: Some([20, 22, 24]), domain: Some([0.0, 0.0, 0.0, 8.0, 8.0, 8.0]), ..Job::default() })
}

#[test]
fn a_single_wrong_cell_is_named() {
    for axis in AXES {
        let meshed = Meshed::new(&spheres(), set!(Job { axis, ..job() }));
        meshed.is_right("spheres");
        let right = changed(&meshed, |_, _| {});
        // far from all surfaces, at the first and the last cell, and inside
        for (ray, cell) in [(0, 0), (77, 3), (219, 11), (300, 19), (439, 0)] {
            let wrong = changed(&meshed, |index, flags| {
                if index == ray {
                    flags[cell] = if flags[cell] == 7 { 8 } else { 7 };
                }
            });
            let rays = wrong.columns().rays();
            meshed.write(&wrong);
            let (code, text) = meshed.verify(&[]);
            let mut place = [cell as u64; 3];
            (place[rays.across[0]], place[rays.across[1]]) =
                (ray % u64::from(rays.counts[0]), ray / u64::from(rays.counts[0]));
            let [x, y, z] =
                [0, 1, 2].map(|k| wrong.lines().origin()[k] + (place[k] as f64 + 0.5) * wrong.lines().smallest()[k]);
            let named = format!("Wrong cell: {place:?} at ({x}, {y}, {z}) has flag 7, expected ");
            assert!(code == Some(9) && text.contains(&named), "{named}: {code:?}\n{text}");
            assert!(text.contains("The mesh is not that of the job. Wrong cells: 1."), "{text}");
            meshed.write(&right);
        }
    }
}

#[test]
fn all_wrong_cells_are_counted_and_the_first_are_named() {
    let meshed = Meshed::new(&spheres(), job());
    let wrong = changed(&meshed, |ray, flags| {
        if ray % 100 == 13 {
            flags[2..9].fill(99)
        }
    });
    meshed.write(&wrong);
    let (code, text) = meshed.verify(&[]);
    // 22 x 24 rays along x or their like
    let n = 7 * (0..wrong.columns().rays().n_rays()).filter(|ray| ray % 100 == 13).count();
    assert!(code == Some(9) && text.contains(&format!("Wrong cells: {n}.")), "{text}");
    assert_eq!(text.matches("Wrong cell: ").count(), 5, "{text}");
}

#[test]
fn another_job_is_found() {
    let meshed = Meshed::new(&spheres(), job());
    let entry = |index: usize, entry: GeometryJob| {
        let mut other = meshed.job.clone();
        other.geometries[index] = set!(GeometryJob { file: other.geometries[index].file.clone(), ..entry });
        other
    };
    let one = set!(Job { geometries: meshed.job.geometries[..1].to_vec(), ..meshed.job.clone() });
    let others = [
        ("moved by a cell", entry(0, set!(GeometryJob { translate: Some([0.0, 0.4, 0.0]), ..GeometryJob::default() }))),
        (
            "moved by a twentieth",
            entry(1, set!(GeometryJob { translate: Some([0.02, 0.0, 0.0]), ..GeometryJob::default() })),
        ),
        ("turned", entry(1, set!(GeometryJob { rotate: Some([0.0, 0.0, 5.0]), ..GeometryJob::default() }))),
        ("scaled", entry(0, set!(GeometryJob { scale: Some(PerAxis::All(1.02)), ..GeometryJob::default() }))),
        ("priority", entry(0, set!(GeometryJob { priority: 1, ..GeometryJob::default() }))),
        ("flag", entry(1, set!(GeometryJob { flag: Some(5), ..GeometryJob::default() }))),
        ("one missing", one),
    ];
    for (what, other) in others {
        meshed.write_job(&other);
        let (code, text) = meshed.verify(&[]);
        assert!(code == Some(9) && text.contains("Wrong cell: "), "{what}: {code:?}\n{text}");
        assert!(!text.contains("Wrong lines"), "{what}: {text}");
    }
    let nested = vec![models::joined([models::cube([1.0; 3], 6.0), models::cube([2.0; 3], 3.0)])];
    let meshed = Meshed::new(&nested, job());
    meshed.write_job(&set!(Job { rule: Rule::Nonzero, ..meshed.job.clone() }));
    let (code, text) = meshed.verify(&[]);
    assert!(code == Some(9) && text.contains("has flag 0, expected 1"), "{code:?}\n{text}");
}

#[test]
fn another_way_with_holes_is_found() {
    let torn = without(&models::sphere([4.0; 3], 3.1, 24), 0.3, 1);
    let meshed = Meshed::new(&[torn], job());
    for open in [Open::Vote, Open::Parity] {
        meshed.write_job(&set!(Job { open, ..meshed.job.clone() }));
        let (code, text) = meshed.verify(&[]);
        assert!(code == Some(9) && text.contains("Wrong cell: "), "{open:?}: {code:?}\n{text}");
    }
    meshed.write_job(&set!(Job { open: Open::Error, ..meshed.job.clone() }));
    let (code, text) = meshed.verify(&[]);
    assert!(code == Some(3) && text.contains("is not closed, which the job makes an error"), "{code:?}\n{text}");
}

#[test]
fn other_lines_are_found() {
    let meshed = Meshed::new(&spheres(), job());
    let mesh = changed(&meshed, |_, _| {});
    let (origin, spacing, dims) = (mesh.lines().origin(), mesh.lines().smallest(), mesh.lines().dims());
    let lines = |origin, spacing, dims| Lines::new(origin, spacing, dims).unwrap();
    for lines in [
        lines([origin[0], origin[1] + 1e-9, origin[2]], spacing, dims),
        lines(origin, [spacing[0], spacing[1], spacing[2] * 1.01], dims),
    ] {
        meshed.write(&Mesh::new(lines, mesh.columns().clone(), mesh.names().to_vec(), None).unwrap());
        let (code, text) = meshed.verify(&[]);
        assert!(code == Some(9) && text.contains("Wrong lines: along "), "{code:?}\n{text}");
    }
    meshed.write(&mesh);
    for other in [
        set!(Job { dims: Some([20, 22, 25]), ..meshed.job.clone() }),
        set!(Job { dims: None, cells: Some(22), ..meshed.job.clone() }),
        set!(Job { domain: None, ..meshed.job.clone() }),
        set!(Job { dims: None, cell_size: Some(PerAxis::All(0.4)), ..meshed.job.clone() }),
    ] {
        meshed.write_job(&other);
        let (code, text) = meshed.verify(&[]);
        assert!(code == Some(9) && text.contains("Wrong lines: along "), "{other:?}: {code:?}\n{text}");
    }
}

#[test]
fn cells_of_another_fill_window_or_gap_are_found() {
    let of = |entry: GeometryJob| set!(Job { geometries: vec![entry; 2], ..job() });
    let filled = |fill| of(set!(GeometryJob { fill: Some(fill), ..GeometryJob::default() }));
    let jobs = [
        job(),
        filled(Fill::Separating),
        filled(Fill::Conservative),
        of(set!(GeometryJob { shell: true, ..GeometryJob::default() })),
        of(set!(GeometryJob { shell: true, fill: Some(Fill::Conservative), ..GeometryJob::default() })),
        of(set!(GeometryJob { invert: true, ..GeometryJob::default() })),
    ];
    for (nth, job) in jobs.iter().enumerate() {
        let meshed = Meshed::new(&spheres(), job.clone());
        meshed.is_right(&format!("job {nth}"));
        let with_files = |of: &Job| {
            let mut other = of.clone();
            other.geometries.resize(2, GeometryJob::new("."));
            other
                .geometries
                .iter_mut()
                .zip(&meshed.job.geometries)
                .for_each(|(to, from)| to.file.clone_from(&from.file));
            other
        };
        for other in jobs.iter().filter(|other| *other != job) {
            meshed.write_job(&with_files(other));
            let (code, text) = meshed.verify(&[]);
            assert!(code == Some(9) && text.contains("Wrong cell: "), "{nth} as {other:?}: {code:?}\n{text}");
        }
    }
    let walls = vec![models::joined([
        models::cuboid([1.0; 3], [3.0, 7.0, 7.0]),
        models::cuboid([4.6, 1.0, 1.0], [6.0, 7.0, 7.0]),
    ])];
    let meshed = Meshed::new(&walls, set!(Job { close_gaps: Some(5), ..job() }));
    meshed.is_right("a gap");
    for other in
        [set!(Job { close_gaps: Some(3), ..meshed.job.clone() }), set!(Job { gap_flag: Some(9), ..meshed.job.clone() })]
    {
        meshed.write_job(&other);
        let (code, text) = meshed.verify(&[]);
        assert!(code == Some(9) && text.contains("Wrong cell: "), "{other:?}: {code:?}\n{text}");
    }
    let halo = |edge| set!(Job { window: Some([0, 3, 15, 9, 12, 24]), halo: Some(2), halo_edge: Some(edge), ..job() });
    let cube = vec![models::cube([2.0; 3], 6.0)];
    let meshed = Meshed::new(&cube, halo(HaloEdge::Clamp));
    meshed.is_right("a halo");
    meshed.write_job(&set!(Job { halo_edge: None, ..meshed.job.clone() }));
    let (code, text) = meshed.verify(&[]);
    assert!(code == Some(9) && text.contains("has flag 1, expected 0"), "{code:?}\n{text}");
    for (window, part) in [(Some([0, 3, 14, 9, 12, 23]), None), (None, None), (None, Some(PartJob::new(1, [1, 1, 2])))]
    {
        meshed.write_job(&set!(Job { window, part, halo: part.map(|_| 2), halo_edge: None, ..meshed.job.clone() }));
        let (code, text) = meshed.verify(&[]);
        assert!(code == Some(9) && text.contains("Wrong lines: along "), "{window:?}: {code:?}\n{text}");
    }
}

#[test]
fn lines_that_do_not_keep_what_is_promised_are_found() {
    let graded = set!(GradedJob { min_size: Some(0.05), growth: Some(1.4), ..GradedJob::new(PerAxis::All(0.8)) });
    let (dims, domain, three) = (None, None, set!(GeometryJob { min_cells: Some(3), ..GeometryJob::default() }));
    let meshed = Meshed::new(
        &[models::cube([0.0; 3], 8.0), models::cuboid([3.0; 3], [3.3, 5.0, 7.0])],
        set!(Job { dims, domain, graded: Some(graded), geometries: vec![GeometryJob::new("."), three], ..job() }),
    );
    assert!(!meshed.is_right("graded lines").contains("generates"));
    let others = [
        ("is 0.", set!(GradedJob { max_size: PerAxis::All(0.5), ..graded })),
        ("not 0.2 to", set!(GradedJob { min_size: Some(0.2), ..graded })),
        ("are neighbours, with a growth of 1.2", set!(GradedJob { growth: Some(1.2), ..graded })),
        ("with 1 cells beyond", set!(GradedJob { absorbing: Some(PerAxis::All(1)), ..graded })),
    ];
    for (words, other) in others {
        meshed.write_job(&set!(Job { graded: Some(other), ..meshed.job.clone() }));
        let (code, text) = meshed.verify(&[]);
        assert!(code == Some(9) && text.contains(words), "{words}: {code:?}\n{text}");
    }
    let with = |change: fn(&mut GeometryJob)| {
        let mut other = meshed.job.clone();
        change(&mut other.geometries[1]);
        other
    };
    let others = [
        ("across it, not 60", with(|entry| entry.min_cells = Some(60))),
        ("a cell within ", with(|entry| entry.max_size = Some(0.05))),
        ("has no line", with(|entry| entry.translate = Some([0.0, 0.0, 0.35]))),
    ];
    for (words, other) in others {
        meshed.write_job(&other);
        let (code, text) = meshed.verify(&[]);
        assert!(code == Some(9) && text.contains(words), "{words}: {code:?}\n{text}");
    }
    let meshed = Meshed::new(
        &[models::cube([0.0; 3], 8.0), models::cuboid([3.0; 3], [3.3, 5.0, 7.0])],
        set!(Job { dims, domain, graded: Some(graded), window: Some([2, 2, 2, 7, 8, 9]), ..job() }),
    );
    let text = meshed.is_right("a window of graded lines");
    assert!(text.contains("The lines of the whole box are as the mesher generates them"), "{text}");
}

#[test]
fn a_sample_checks_some_planes() {
    let meshed = Meshed::new(&spheres(), job());
    let (code, text) = meshed.verify(&["--sample", "2000", "--seed", "5"]);
    assert!(code == Some(0), "{text}");
    let n: u64 = text.split(' ').nth(1).expect("a number").replace(',', "").parse().expect("a number");
    assert!((2000..5280).contains(&n) && n.is_multiple_of(20 * 22), "{text}");
}

#[test]
fn what_cannot_be_checked_is_an_error() {
    let folder = Folder::new();
    let meshed = Meshed::new(&spheres(), job());
    let (mesh, vti) = (meshed.folder.path("mesh.hxc"), folder.path("a.vti"));
    std::fs::write(&vti, "<?xml version=\"1.0\"?>").expect("the folder is there");
    let cases: &[(&[&str], i32, &str)] = &[
        (&["verify", &mesh], 2, "required"),
        (&["verify", &vti, SPOT], 3, "error[columns-corrupt]"),
        (&["verify", "no-such.hxc", SPOT], 7, "there is no such file"),
        (&["verify", &mesh, "no-such.stl"], 7, "reading no-such.stl"),
        (&["verify", &mesh, "README.md"], 3, "give the file that was meshed"),
        (&["verify", &mesh, &format!("{SPOT}:solid=lid")], 4, "has no solid \"lid\""),
        (&["verify", &mesh, SPOT, "--sample", "0"], 2, "at least 1"),
        (&["verify", &mesh, SPOT, "--max-memory", "2kB"], 5, "a plane of the mesh has 440 cells; each thread can hold"),
    ];
    for (arguments, code, part) in cases {
        let output = hexcast(arguments);
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(*code) && error.contains(part), "{arguments:?}: {error}");
        assert!(output.stdout.is_empty(), "{arguments:?}");
    }
}
