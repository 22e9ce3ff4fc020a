//! The examples in Rust do what they say.

use hexcast::Mesher;
use hexcast::control::Control;
use hexcast::job::{GeometryJob, Job};

use super::cli::{Folder, SPOT, done};

macro_rules! example {
    ($name:ident, $file:literal) => {
        #[path = $file]
        #[allow(dead_code, reason = "its main is for cargo run")]
        mod $name;
    };
}

example!(facets_to_query, "../../examples/facets_to_query.rs");
example!(many_meshes, "../../examples/many_meshes.rs");
example!(progress_and_cancel, "../../examples/progress_and_cancel.rs");
example!(stl_to_vti, "../../examples/stl_to_vti.rs");
example!(window, "../../examples/window.rs");

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
