//! The examples in Rust do what they say.

use hexcast::Mesher;
use hexcast::control::Control;
use hexcast::job::{GeometryJob, Job};

use super::cli::{Folder, SPOT, done, json};

macro_rules! example {
    ($name:ident, $file:literal) => {
        #[path = $file]
        #[allow(dead_code, reason = "its main is for cargo run")]
        mod $name;
    };
}

example!(for_solvers, "../../examples/for_solvers.rs");
example!(facets_to_query, "../../examples/facets_to_query.rs");
example!(many_meshes, "../../examples/many_meshes.rs");
example!(mesh_on_device, "../../examples/mesh_on_device.rs");
example!(moving_body, "../../examples/moving_body.rs");
example!(progress_and_cancel, "../../examples/progress_and_cancel.rs");
example!(stl_to_vti, "../../examples/stl_to_vti.rs");
example!(window, "../../examples/window.rs");

/// The program of docs/libraries.md: the lines between the braces.
fn program_of_the_document(mut file: Vec<u8>) -> hexcast::Result<Vec<u8>> {
    use hexcast::control::Control;
    use hexcast::job::{GeometryJob, Job};
    use hexcast::mesher::{Mesher, MesherOptions};
    use hexcast::write::{Format, Options, write};

    let mut job = Job::new(vec![GeometryJob::new("part.stl")]);
    job.cells = Some(256);
    let (mesh, report) = Mesher::new(MesherOptions::default())?.mesh(&job)?; // or pipeline::mesh, for executors
    let flags = mesh.box_flags(&[0..64, 0..64, 0..1])?; // one byte per cell, x fastest
    write(&mesh, Format::Vti, &Options::default(), &mut file, &Control::default())?;
    assert!(flags.len() == 64 * 64 && !report.to_json().is_empty());
    Ok(file)
}

#[test]
fn the_program_of_the_document_compiles_as_it_is_there() {
    let document = include_str!("../../docs/libraries.md");
    let program = document.split("```rust\n").nth(1).and_then(|rest| rest.split("```").next()).expect("there is one");
    assert!(program.lines().filter(|line| line.starts_with("use ")).count() >= 4, "{program}");
    for line in program.lines().filter(|line| !line.is_empty()) {
        assert!(include_str!("examples.rs").lines().any(|own| own.trim() == line), "{line}");
    }
    // nobody has that file here
    let error = program_of_the_document(Vec::new()).expect_err("there is no such file");
    assert!(error.to_string().contains("part.stl"), "{error}");
}

#[test]
fn an_stl_becomes_the_vti_of_the_command() {
    let folder = Folder::new();
    let file = folder.path("spot.vti");
    done(&["mesh", SPOT, "--cells", "64", "--compress=6", "--backend", "cpu", "-o", &file]);
    let stl = std::fs::read(SPOT).expect("the fixture is there");
    assert_eq!(stl_to_vti::vti_of_stl(SPOT, &stl).unwrap(), std::fs::read(file).unwrap());
}

#[test]
fn an_octahedron_has_the_cells_whose_centres_are_inside() {
    let mesh = facets_to_query::meshed().unwrap();
    assert_eq!(mesh.dims(), [20; 3]);
    for (index, &flag) in mesh.box_flags(&[0..20, 0..20, 0..20]).unwrap().iter().enumerate() {
        // twice the distance of the centre from that of the box, in cells
        let odd = |cell: usize| (2 * cell as i32 - 19).abs();
        let sum = odd(index % 20) + odd(index / 20 % 20) + odd(index / 400);
        // those of 20 would be on the surface, but a sum of three odd numbers is odd
        assert_eq!(flag, if sum < 20 { 7 } else { 0 }, "cell {index}");
    }
    facets_to_query::main().unwrap();
}

#[test]
fn a_quarter_turn_keeps_the_number_of_cells() {
    let source = hexcast::files::read_file(SPOT, &Control::default()).unwrap();
    let cells = many_meshes::cells_of_turns(&source, 3).unwrap();
    assert_eq!(cells.len(), 4);
    // a quarter turn mirrors the box, and the cells begin at its other end
    assert!(cells[0].abs_diff(cells[3]) <= cells[0] / 100, "{cells:?}");
    assert!(cells.iter().all(|&cells| cells > 0) && cells[0] != cells[1], "{cells:?}");
}

#[test]
fn a_body_that_moves_changes_some_cells_at_every_step() {
    let source = hexcast::files::read_file(SPOT, &Control::default()).unwrap();
    let cells = moving_body::cells_of_steps(&source, 3, 0.1).unwrap();
    assert!(cells.len() == 3 && cells.iter().all(|&cells| cells > 100), "{cells:?}");
}

#[test]
fn a_gpu_counts_the_cells_of_a_mesh_that_stays_there() {
    let counted = mesh_on_device::counted(SPOT).unwrap();
    let job = set!(Job { geometries: vec![GeometryJob::new(SPOT)], cells: Some(100), ..Job::default() });
    let cpu = hexcast::MesherOptions::default().with_backend(hexcast::job::BackendChoice::Cpu);
    let (mesh, _) = Mesher::new(cpu).unwrap().mesh(&job).unwrap();
    let mut expected = [0; 256];
    for flag in mesh.box_flags(&mesh.dims().map(|n| 0..n)).unwrap() {
        expected[usize::from(flag)] += 1;
    }
    assert_eq!(counted, expected);
    assert!(counted[0] > 0 && counted[1] > 10_000, "{counted:?}");
}

#[test]
fn parts_together_are_the_whole_mesh() {
    let job = set!(Job { geometries: vec![GeometryJob::new(SPOT)], cells: Some(100), ..Job::default() });
    let (whole, _) = Mesher::new(hexcast::MesherOptions::default()).unwrap().mesh(&job).unwrap();
    let [nx, ny, nz] = whole.dims();
    let mut next = 0;
    for index in 1..=4 {
        let (part, first) = window::part(SPOT, index, 4).unwrap();
        let n = part.dims()[2];
        assert_eq!((first, part.dims()), ([0, 0, next], [nx, ny, n]));
        let flags = part.box_flags(&[0..nx, 0..ny, 0..n]).unwrap();
        assert_eq!(flags, whole.box_flags(&[0..nx, 0..ny, next..next + n]).unwrap());
        next += n;
    }
    assert_eq!(next, nz);
}

#[test]
fn a_cancel_ends_a_mesh_before_all_rays_are_done() {
    let (told, result) = progress_and_cancel::cancelled_after(0.0);
    assert_eq!(result.unwrap_err().code(), "cancelled");
    let last = told.last().expect("some rays were done");
    assert!(last.rays_done < last.n_rays && last.n_rays == 4_000_000, "{last:?}");
    let (told, result) = progress_and_cancel::cancelled_after(2.0);
    assert_eq!(result, Ok(()));
    assert!(
        told.is_sorted_by_key(|progress| progress.rays_done) && told.last().is_some_and(|p| p.rays_done == p.n_rays)
    );
}

#[test]
fn what_solvers_ask_for_is_as_the_command_writes_it() {
    let folder = Folder::new();
    let path = |name: &str| folder.path(name);
    let mut mesher = Mesher::new(hexcast::MesherOptions::default()).unwrap();
    for (name, [low, high]) in
        [("board.stl", [[0.0, 0.0, 0.0], [30.0, 20.0, 1.5]]), ("patch.stl", [[5.0, 4.0, 1.5], [20.0, 11.0, 1.75]])]
    {
        let facets = super::models::cuboid(low, high);
        let corners =
            facets.iter().map(|facet| facet.as_flattened().iter().flat_map(|c| c.to_le_bytes()).collect::<Vec<u8>>());
        let facets = corners.flat_map(|corners| [&[0; 12][..], &corners, &[0; 2]].concat());
        let stl: Vec<u8> = [0; 80].into_iter().chain(12u32.to_le_bytes()).chain(facets).collect();
        std::fs::write(path(name), stl).unwrap();
    }
    let (board, patch) = (path("board.stl"), path("patch.stl"));
    let sized = [format!("{board}:min_cells=4"), format!("{patch}:metal=true,max_size=0.5")];
    let lines =
        ["--graded=2", "--min-size=0.02", "--absorbing=8", "--padding-length=20", "--unit=mm", "--compress=none"];
    done(&[&["mesh", &sized[0], &sized[1], "-o", &path("a.vtr")], &lines[..]].concat());
    let (vtr, step) = for_solvers::graded(&mut mesher, &board, &patch).unwrap();
    assert!(vtr == folder.bytes("a.vtr") && step.is_some_and(|step| step > 0.0 && step < 0.5), "{step:?}");
    done(&["estimate", &board, "--cells=32", "-o", &path("a.svg")]);
    assert_eq!(for_solvers::drawn(&board).unwrap().into_bytes(), folder.bytes("a.svg"));
    let mesh = ["mesh", SPOT, "--cells=32"];
    done(&[&mesh[..], &["--padding-cells=2", "--stencil=D3Q27", "--links", &path("a.links")]].concat());
    let (records, nearest) = for_solvers::links(&mut mesher, SPOT).unwrap();
    assert!(records == folder.bytes("a.links") && nearest > 0.0 && nearest < 0.1, "{nearest}");
    let fractions = ["--fraction-surfaces", "--fractions", &path("f.npz")];
    let report = json(&[&mesh[..], &fractions, &["--staggered", &path("y.npz"), "--json"]].concat());
    let (npz, volume) = for_solvers::fractions(&mut mesher, SPOT).unwrap();
    assert!(npz == folder.bytes("f.npz"));
    assert_eq!(report["fractions"]["volumes"][1], serde_json::json!({ "flag": 1, "volume": volume }));
    let (npz, inside) = for_solvers::staggered(&mut mesher, SPOT).unwrap();
    assert!(npz == folder.bytes("y.npz"));
    assert_eq!(report["staggered"]["components"][0]["flags"][1], serde_json::json!({ "flag": 1, "points": inside }));
    assert_eq!(for_solvers::points(&mesher, SPOT).unwrap(), [1, 0]);
}

/// The Rust of the documentation is that of the example.
#[test]
fn documents_quote_the_example() {
    let tight = |text: &str| text.split_whitespace().collect::<String>();
    let read = |name: &str| std::fs::read_to_string(format!("{}/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap();
    let example = tight(&read("examples/for_solvers.rs"));
    for page in ["lines", "links", "fractions", "staggered", "points"] {
        let text = read(&format!("docs/{page}.md"));
        let quoted: Vec<&str> = text.split("```rust\n").skip(1).filter_map(|rest| rest.split("```").next()).collect();
        assert!(!quoted.is_empty(), "{page} has no example in Rust");
        for code in quoted {
            assert!(example.contains(&tight(code)), "{page}: {code}");
        }
    }
}
