//! Cells that differ in size: the same laws as of equal ones, on the CPU, against the oracle; and the lists that decide them.

use hexcast::columns::Columns;
use hexcast::control::Control;
use hexcast::geometry::Geometry;
use hexcast::job::{GeometryJob, Job, LinesJob, PerAxis};
use hexcast::lines::Lines;
use hexcast::mesh::Mesh;
use hexcast::pipeline::{Engine, MeshOptions};
use hexcast::report::MeshFacts;
use hexcast::sources::Source;
use hexcast::write::{self, Compress, Format, Options};
use hexcast::{Result, column_file};
use hexcast_core::stages::map::Rule;

use super::backends::{BACKENDS, Backend, cpu_flags, flags, mesh};
use super::cases::{Case, cases};
use super::compare::assert_same;
use super::models;
use super::oracle;
use super::soups::{Random, anywhere, soup, thinned};

fn assert_as_the_oracle(label: &str, case: &Case) -> usize {
    let expected = oracle::flags(&case.geometries, &case.lines, case.rule);
    for axis in 0..3 {
        let columns = mesh(Backend::Cpu, case, axis);
        assert_same(&format!("{label}, axis {axis}"), &expected, &flags(&columns), case.lines.dims());
        assert_eq!(columns.odd_rays(), 0, "{label}, axis {axis}: odd rays on a closed surface");
    }
    expected.iter().filter(|flag| **flag != 0).count()
}

#[test]
fn soups_on_graded_lines_agree_with_the_oracle_along_every_axis() {
    let [mut n_graded, mut n_inside] = [0; 2];
    for seed in 2000..2400 {
        let (mut case, mut random) = (soup(seed), Random::new(seed));
        case.lines = if seed % 2 == 0 { thinned(&case.lines, &mut random) } else { anywhere(&case.lines, &mut random) };
        if !oracle::is_closed(&case.geometries, &case.lines, case.rule) {
            continue;
        }
        n_graded += usize::from(case.lines.is_graded());
        n_inside += assert_as_the_oracle(&format!("seed {seed}"), &case);
    }
    assert!(n_graded > 250 && n_inside > 2000, "{n_graded} graded, {n_inside} cells inside");
}

#[test]
fn every_way_to_cast_agrees_on_graded_lines() {
    for seed in 2500..2560 {
        let (mut case, mut random) = (soup(seed), Random::new(seed));
        case.lines = thinned(&case.lines, &mut random);
        let expected = cpu_flags(&case, 0);
        for &backend in BACKENDS {
            for axis in 0..3 {
                let found = flags(&mesh(backend, &case, axis));
                assert_same(&format!("seed {seed}, {backend:?}, axis {axis}"), &expected, &found, case.lines.dims());
            }
        }
    }
}

/// The tables of equal cells give what the fast path gives, in the whole table of cases.
#[test]
fn equal_cells_as_lists_give_the_same_flags() {
    let mut n_cases = 0;
    for case in cases() {
        // where f64 cannot hold the sizes, lists round otherwise
        let is_exact = (0..3).all(|axis| {
            let list = case.lines.list(axis);
            list.windows(2).all(|two| two[1] - two[0] == case.lines.smallest()[axis])
        });
        if !is_exact || case.lines.n_cells() > 100_000 {
            continue;
        }
        let listed = Case { lines: case.lines.as_lists(), ..case.clone() };
        assert!(listed.lines.is_graded());
        for axis in 0..3 {
            let same = |columns: &Columns| (flags(columns), columns.odd_rays(), columns.n_crossings());
            let [one, other] = [&case, &listed].map(|case| mesh(Backend::Cpu, case, axis));
            assert!(same(&one) == same(&other), "{}, axis {axis}", case.name);
        }
        n_cases += 1;
    }
    assert!(n_cases > 60, "{n_cases} cases");
}

fn job(lists: [Vec<f64>; 3]) -> Job {
    let [x, y, z] = lists;
    set!(Job { lines: Some(LinesJob { x, y, z }), geometries: vec![GeometryJob::new("body.stl")], ..Job::default() })
}

fn meshed(facets: &models::Facets, job: &Job) -> Result<(Mesh, MeshFacts)> {
    let sources = vec![Source::from_facets("body.stl", facets.clone())?];
    let (options, control) = (MeshOptions::default(), Control::default());
    pollster::block_on(hexcast::pipeline::mesh(job, sources, &options, &mut Engine::cpu(), &control))
}

fn lists() -> [Vec<f64>; 3] {
    let grown = |ratio: f64| {
        let mut list = vec![0.0];
        let mut size = 0.05;
        while list[list.len() - 1] < 8.0 {
            list.push(list[list.len() - 1] + size);
            size = (size * ratio).min(0.8);
        }
        list
    };
    [grown(1.2), grown(1.3), grown(1.1)]
}

#[test]
fn a_list_of_equal_cells_gives_the_bytes_of_a_cell_size() {
    let body = models::sphere([4.0; 3], 3.3, 24);
    let uniform = set!(Job {
        cell_size: Some(PerAxis::All(0.1)),
        domain: Some([0.0, 0.0, 0.0, 8.0, 8.0, 8.0]),
        geometries: vec![GeometryJob::new("body.stl")],
        ..Job::default()
    });
    let (mesh, facts) = meshed(&body, &uniform).unwrap();
    let list: Vec<f64> = (0..=80).map(|line| f64::from(line) * 0.1).collect();
    let (listed, listed_facts) = meshed(&body, &job([list.clone(), list.clone(), list])).unwrap();
    assert_eq!(listed.lines(), mesh.lines());
    assert_eq!(listed_facts.flags_hash, facts.flags_hash);
    for format in Format::FILES {
        assert!(bytes(&mesh, format) == bytes(&listed, format), "{format:?}");
    }
}

fn bytes(mesh: &Mesh, format: Format) -> Vec<u8> {
    let mut out = Vec::new();
    write::write(mesh, format, &Options::default(), &mut out, &Control::default()).unwrap();
    out
}

#[test]
fn a_window_has_the_flags_that_the_whole_has_there() {
    let body = models::torus([4.0; 3], [2.4, 1.1], 24);
    let mut open = models::sphere([4.0; 3], 3.3, 16);
    open.truncate(open.len() - 20);
    for (facets, is_open) in [(body, false), (open, true)] {
        let whole = job(lists());
        let (mesh, facts) = meshed(&facets, &whole).unwrap();
        assert_eq!(facts.open.len(), usize::from(is_open));
        let [nx, ny, nz] = mesh.dims();
        for [first, end] in [[[0; 3], [nx, ny, nz]], [[3, 5, 7], [nx - 2, ny - 4, nz - 1]], [[9, 9, 9], [10, 11, 12]]] {
            for axis in [hexcast::job::AxisChoice::X, hexcast::job::AxisChoice::Y, hexcast::job::AxisChoice::Z] {
                let window = [first, end].concat().try_into().ok();
                let (part, _) = meshed(&facets, &set!(Job { window, axis, ..whole.clone() })).unwrap();
                for z in first[2]..end[2] {
                    for y in first[1]..end[1] {
                        for x in first[0]..end[0] {
                            let own = part.flag([x - first[0], y - first[1], z - first[2]]).unwrap();
                            assert_eq!(own, mesh.flag([x, y, z]).unwrap(), "cell {x} {y} {z} of {first:?} to {end:?}");
                        }
                    }
                }
                assert_eq!(part.lines().list(0), mesh.lines().list(0)[first[0] as usize..=end[0] as usize]);
            }
        }
    }
}

#[test]
fn volumes_are_those_of_the_cells() {
    let body = models::sphere([4.0; 3], 3.3, 24);
    let (mesh, facts) = meshed(&body, &job(lists())).unwrap();
    let lines = [0, 1, 2].map(|axis| mesh.lines().list(axis));
    let mut volume = 0.0;
    let [nx, ny, nz] = mesh.dims();
    for z in 0..nz {
        for y in 0..ny {
            for x in 0..nx {
                if mesh.flag([x, y, z]).unwrap() == 1 {
                    let size = |axis: usize, cell: u32| lines[axis][cell as usize + 1] - lines[axis][cell as usize];
                    volume += size(0, x) * size(1, y) * size(2, z);
                }
            }
        }
    }
    let flag = &facts.flags[0];
    assert!((flag.volume - volume).abs() < 1e-9 * volume, "{} and {volume}", flag.volume);
    assert_eq!((flag.volume_bound, facts.spacing), (None, None));
    let grading = facts.grading.expect("cells differ");
    assert_eq!([&grading.x, &grading.y, &grading.z], [&lines[0], &lines[1], &lines[2]]);
    assert!((grading.ratio[1] - 1.3).abs() < 1e-9 && grading.smallest[0] > 0.0499, "{grading:?}");
    let least = 1.0 / grading.smallest.iter().map(|size| size.powi(-2)).sum::<f64>().sqrt();
    assert!((grading.courant_length - least).abs() < 1e-12 && grading.courant_seconds.is_none());
    let with_unit = set!(Job { unit: Some("mm".into()), ..job(lists()) });
    let (_, facts) = meshed(&body, &with_unit).unwrap();
    let seconds = facts.grading.unwrap().courant_seconds.unwrap();
    assert!((seconds * 299_792_458.0 * 1000.0 / least - 1.0).abs() < 1e-12);
}

#[test]
fn a_column_file_keeps_the_lines_and_equal_cells_keep_their_version() {
    let body = models::sphere([4.0; 3], 3.3, 24);
    let (mesh, _) = meshed(&body, &job(lists())).unwrap();
    for compress in [Compress::None, Compress::Zlib(6)] {
        let mut file = Vec::new();
        let options = Options::default().with_compress(compress);
        write::write(&mesh, Format::Columns, &options, &mut file, &Control::default()).unwrap();
        assert_eq!(file[8], 3);
        let read = column_file::read(&mut std::io::Cursor::new(file), u64::MAX).unwrap();
        assert_eq!(read.lines(), mesh.lines());
        assert_eq!(bytes(&read, Format::Raw), bytes(&mesh, Format::Raw));
    }
    let uniform = set!(Job { cells: Some(8), geometries: vec![GeometryJob::new("body.stl")], ..Job::default() });
    assert_eq!(bytes(&meshed(&body, &uniform).unwrap().0, Format::Columns)[8], 2);
}

#[test]
fn a_rectilinear_grid_lists_its_lines() {
    let body = models::sphere([4.0; 3], 3.3, 24);
    let (mesh, _) = meshed(&body, &job(lists())).unwrap();
    let file = bytes(&mesh, Format::Vtr);
    let text = String::from_utf8_lossy(&file);
    let [nx, ny, nz] = mesh.dims();
    assert!(text.contains(&format!("<RectilinearGrid WholeExtent=\"0 {nx} 0 {ny} 0 {nz}\">")), "{}", &text[..300]);
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let start = text.find(&format!("Name=\"{name}\" format=\"ascii\">")).expect("an array") + 24;
        let numbers = &text[start..start + text[start..].find('<').unwrap()];
        let numbers: Vec<f64> = numbers.split(' ').map(|number| number.parse().unwrap()).collect();
        assert_eq!(numbers, mesh.lines().list(axis));
    }
    let data = file.windows(4).position(|four| four == b"   _").unwrap() + 4;
    assert_eq!(file[data..data + 8], mesh.n_cells().to_le_bytes());
    let flags = bytes(&mesh, Format::Raw);
    assert_eq!(file[data + 8..data + 8 + flags.len()], flags);
}

#[test]
fn an_archive_has_flags_and_lines() {
    let body = models::sphere([4.0; 3], 3.3, 24);
    let (mesh, _) = meshed(&body, &job(lists())).unwrap();
    for compress in [Compress::None, Compress::Zlib(6)] {
        let mut file = Vec::new();
        let options = Options::default().with_compress(compress).with_slab_bytes(5000);
        write::write(&mesh, Format::Npz, &options, &mut file, &Control::default()).unwrap();
        let mut archive = zip::ZipArchive::new(std::io::Cursor::new(file)).unwrap();
        let mut array = |name: &str| {
            let mut bytes = Vec::new();
            std::io::copy(&mut archive.by_name(name).unwrap(), &mut bytes).unwrap();
            let data = bytes.split_off(128);
            (String::from_utf8_lossy(&bytes[10..]).trim_end().to_string(), data)
        };
        for (axis, name) in ["x.npy", "y.npy", "z.npy"].into_iter().enumerate() {
            let list = mesh.lines().list(axis);
            let (head, data) = array(name);
            assert_eq!(head, format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({},), }}", list.len()));
            assert_eq!(data, list.iter().flat_map(|line| line.to_le_bytes()).collect::<Vec<u8>>());
        }
        let (head, data) = array("flag.npy");
        let [nx, ny, nz] = mesh.dims();
        assert_eq!(head, format!("{{'descr': '|u1', 'fortran_order': False, 'shape': ({nz}, {ny}, {nx}), }}"));
        assert!(data == bytes(&mesh, Format::Raw));
    }
}

#[test]
fn what_is_known_of_equal_cells_only_is_refused() {
    let body = models::sphere([4.0; 3], 3.3, 8);
    let (mesh, _) = meshed(&body, &job(lists())).unwrap();
    let error =
        write::write(&mesh, Format::Vti, &Options::default(), &mut Vec::new(), &Control::default()).unwrap_err();
    assert!(error.code() == "lines-graded" && error.hint().contains(".vtr"), "{error}");
}

#[test]
fn lists_that_are_no_lines_and_keys_that_contradict_them_are_refused() {
    let body = models::sphere([4.0; 3], 3.3, 8);
    let with = |x: Vec<f64>| job([x, vec![0.0, 8.0], vec![0.0, 8.0]]);
    for (x, part) in [
        (vec![], "lines.x has 0 lines"),
        (vec![0.0], "lines.x has 1 lines"),
        (vec![0.0, 4.0, 4.0], "lines.x[2] is 4.0"),
        (vec![0.0, f64::NAN, 4.0], "lines.x[1] is NaN"),
    ] {
        let error = meshed(&body, &with(x)).unwrap_err();
        assert!(error.code() == "lines-wrong" && error.to_string().contains(part), "{error}");
    }
    let whole = || with(vec![0.0, 1.0, 8.0]);
    for job in [
        set!(Job { cells: Some(3), ..whole() }),
        set!(Job { domain: Some([0.0, 0.0, 0.0, 1.0, 1.0, 1.0]), ..whole() }),
        set!(Job { padding: Some(hexcast::job::Padding::Cells(PerAxis::All(1))), ..whole() }),
        set!(Job { geometries: vec![set!(GeometryJob { metal: true, ..GeometryJob::new("body.stl") })], ..whole() }),
    ] {
        assert_eq!(job.validate().unwrap_err().code(), "job-conflict");
    }
    let far = with(vec![0.0, 1e-6, 8.0]);
    let error = meshed(&body, &far).unwrap_err();
    assert!(error.code() == "lines-too-fine" && error.to_string().contains("smallest cell along x"), "{error}");
}

#[test]
fn several_geometries_and_rules_agree_on_graded_lines() {
    let [outer, inner] = [models::sphere([4.0; 3], 3.4, 16), models::sphere([4.5; 3], 2.0, 16)];
    let geometries = vec![Geometry::new("a", 1, outer).unwrap(), Geometry::new("b", 2, inner).unwrap()];
    for rule in [Rule::Parity, Rule::Nonzero] {
        let lines = Lines::from_lists(lists().map(|list| list.into_iter().step_by(3).collect())).unwrap();
        let case = Case { name: "two".into(), why: "", geometries: geometries.clone(), lines, rule };
        assert!(assert_as_the_oracle("two", &case) > 20);
    }
}

/// A casing of 10^3 cells with walls of one cell and a hole of 2 x 1 cells, whose corners stand where `line` puts the lines of its cells.
fn casing(line: impl Fn(f32) -> f32) -> models::Facets {
    let walls = models::joined([
        models::cuboid([2.0; 3], [12.0; 3]),
        models::flipped(models::cuboid([3.0; 3], [11.0; 3])),
        models::flipped(models::cuboid([6.0, 8.0, 11.0], [8.0, 9.0, 12.0])),
    ]);
    models::mapped(&walls, |corner| corner.map(&line))
}

#[test]
fn boxes_that_are_stretched_with_their_lines_have_the_same_cells() {
    let stretched = |at: f32| at + at * at / 16.0;
    let list = |line: &dyn Fn(f32) -> f32| (0..=14u8).map(|index| f64::from(line(index.into()))).collect::<Vec<f64>>();
    for close_gaps in [None, Some(2), Some(3)] {
        let made = |line: &dyn Fn(f32) -> f32| {
            let [x, y, z] = [list(line), list(line), list(line)];
            meshed(&casing(line), &set!(Job { close_gaps, ..job([x, y, z]) })).unwrap()
        };
        let [(equal, facts), (graded, graded_facts)] = [made(&|at| at), made(&stretched)];
        assert!(!equal.lines().is_graded() && graded.lines().is_graded());
        assert_eq!(bytes(&equal, Format::Raw), bytes(&graded, Format::Raw), "close_gaps {close_gaps:?}");
        let n_closed = |facts: &MeshFacts| facts.gaps.as_ref().map(|gaps| (gaps.cells, gaps.gaps));
        assert_eq!(n_closed(&facts), n_closed(&graded_facts));
        if close_gaps == Some(2) {
            // the cells 6 and 7, 8, 11
            let size = |index: f32| f64::from(stretched(index + 1.0) - stretched(index));
            let volume = (size(6.0) + size(7.0)) * size(8.0) * size(11.0);
            assert_eq!(graded_facts.flags[1].volume, volume);
        }
        let question = |line: &dyn Fn(f32) -> f32| {
            hexcast::leak::Question::new([7.0; 3].map(|at| f64::from(line(at))), [f64::from(line(1.0)); 3])
        };
        let leak = |mesh: &Mesh, line| hexcast::leak::leak(mesh, &question(line), &Control::default()).unwrap();
        let [of_equal, of_graded] = [leak(&equal, &|at| at), leak(&graded, &stretched)];
        let path = |leak: &hexcast::leak::Leak| leak.path.as_ref().map(|path| (path.steps, path.cells.clone()));
        assert_eq!(path(&of_equal), path(&of_graded));
        assert_eq!(of_equal.path.is_some(), close_gaps.is_none());
        if let (Some(path), Some(narrowest)) = (&of_graded.path, &of_graded.narrowest) {
            let along =
                |axis: usize| path.points.windows(2).map(|two| (two[1][axis] - two[0][axis]).abs()).sum::<f64>();
            assert!((path.length - (0..3).map(along).sum::<f64>()).abs() < 1e-9);
            assert_eq!(
                narrowest.bounds,
                narrowest.cells.map(|cell| cell.map(|index| f64::from(stretched(index as f32))))
            );
        }
    }
}
