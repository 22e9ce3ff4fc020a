//! Octrees of jobs: flags of leaves against the uniform mesh of their size, the sizes around surfaces, lines, what is refused, and the command.

use hexcast::control::Control;
use hexcast::job::{Axis, GeometryJob, GradedJob, Job, LinesJob, LinksJob, PerAxis};
use hexcast::mesh::Mesh;
use hexcast::mesh::octree::Octree;
use hexcast::pipeline::{self, Engine, MeshOptions};
use hexcast::refine::{Refined, Refinement, refine};
use hexcast::sources::Source;
use hexcast::{Error, Result};

use super::cli::{Folder, SPOT, done, hexcast, json};
use super::models::{Facets, cuboid, sphere};

const BOX: [f64; 6] = [0.0, 0.0, 0.0, 4.0, 3.0, 2.0];

fn job_of(bodies: &[Facets]) -> (Job, Vec<Source>) {
    let names: Vec<String> = (0..bodies.len()).map(|index| format!("{index}.stl")).collect();
    let sources = names.iter().zip(bodies).map(|(name, facets)| Source::from_facets(name, facets.clone()));
    let job = Job::new(names.iter().map(GeometryJob::new).collect());
    (set!(Job { domain: Some(BOX), ..job }), sources.collect::<Result<_>>().expect("facets"))
}

fn refined(job: &Job, sources: &[Source], how: &Refinement) -> Result<Refined> {
    pollster::block_on(refine(job, sources, how, &mut Engine::cpu(), &Control::default()))
}

fn meshed(job: &Job, sources: &[Source]) -> Mesh {
    let (options, control, mut engine) = (MeshOptions::default(), Control::default(), Engine::cpu());
    pollster::block_on(pipeline::mesh(job, sources.to_vec(), &options, &mut engine, &control)).expect("a mesh").0
}

/// All leaves: level, cell, flag.
fn leaves(tree: &Octree) -> Vec<(usize, [u32; 3], u8)> {
    let mut found = Vec::new();
    for level in 0..tree.n_levels() {
        for z in 0..tree.dims(level)[2] {
            tree.for_plane(level, z, |y, run| found.extend(run.cells().map(|x| (level, [x, y, z], run.flag))))
                .expect("a plane");
        }
    }
    found
}

/// Compares the leaves with meshes of each size, and returns of each finest cell the level of its leaf.
fn compare(found: &Refined, uniform: &[Mesh]) -> Vec<u8> {
    let tree = &found.octree;
    let last = uniform.len() - 1;
    let [nx, ny, nz] = uniform[last].dims();
    let mut levels = vec![u8::MAX; (nx * ny * nz) as usize];
    for (level, cell, flag) in leaves(tree) {
        assert_eq!(tree.dims(level), uniform[level].dims());
        assert_eq!(flag, uniform[level].flag(cell).expect("a cell"), "level {level}, cell {cell:?}");
        let size = 1 << (last - level);
        let [x, y, z] = cell.map(|at| at * size);
        for index in (z..z + size)
            .flat_map(|z| (y..y + size).flat_map(move |y| (x..x + size).map(move |x| x + nx * (y + ny * z))))
        {
            assert_eq!(levels[index as usize], u8::MAX, "two leaves in a cell");
            levels[index as usize] = level as u8;
        }
    }
    assert!(!levels.contains(&u8::MAX), "a cell without a leaf");
    levels
}

/// Indices of cells that touch over a face, with their flags.
fn neighbours(mesh: &Mesh, mut found: impl FnMut([usize; 2], [u8; 2])) {
    let [nx, ny, nz] = mesh.dims();
    let all = mesh.box_flags(&[0..nx, 0..ny, 0..nz]).expect("all flags");
    for index in 0..all.len() {
        let cell = [index as u32 % nx, index as u32 / nx % ny, index as u32 / (nx * ny)];
        for (axis, step) in [1, nx, nx * ny].into_iter().enumerate() {
            if cell[axis] + 1 < mesh.dims()[axis] {
                let other = index + step as usize;
                found([index, other], [all[index], all[other]]);
            }
        }
    }
}

#[test]
fn leaves_are_cells_of_the_uniform_mesh_of_their_size() {
    let (job, sources) = job_of(&[sphere([1.4, 1.3, 0.9], 0.77, 16), cuboid([2.3, 0.4, 0.2], [3.1, 2.6, 1.7])]);
    let of_level = |level: u32| set!(Job { dims: Some([8 << level, 6 << level, 4 << level]), ..job.clone() });
    let uniform: Vec<Mesh> = (0..4).map(|level| meshed(&of_level(level), &sources)).collect();
    for axis in [Axis::X, Axis::Z] {
        let job = set!(Job {
            axis: if axis == Axis::X { hexcast::job::AxisChoice::X } else { hexcast::job::AxisChoice::Z },
            ..of_level(0)
        });
        let found = refined(&job, &sources, &Refinement::new(3)).expect("leaves");
        assert_eq!(found.lines, *uniform[0].lines());
        let levels = compare(&found, &uniform);
        neighbours(&uniform[3], |[one, other], flags| {
            assert!(
                flags[0] == flags[1] || [one, other].map(|index| levels[index]) == [3, 3],
                "a surface without finest cells"
            );
            assert!(levels[one].abs_diff(levels[other]) <= 1, "levels {} and {}", levels[one], levels[other]);
        });
        let n_leaves: u64 = (0..4).map(|level| found.octree.n_leaves(level)).sum();
        assert!(n_leaves < uniform[3].n_cells() / 2, "{n_leaves} leaves");
    }
    // surfaces of one body alone, and a box
    let mut how = Refinement::new(3);
    how.level_of_flags = vec![(1, 1)];
    how.boxes = vec![([0.0, 0.0, 0.0, 0.6, 0.5, 0.5], 2)];
    let levels = compare(&refined(&of_level(0), &sources, &how).expect("leaves"), &uniform);
    // the surface of each is that of the cells which it gets
    for (level, body) in [(1, 1), (3, 2)] {
        neighbours(&uniform[level], |cells, flags| {
            let finest = flags.map(|flag| [0, 1, 3][usize::from(flag)]).into_iter().max();
            if flags[0] != flags[1] && finest == Some(level) {
                assert!(flags.contains(&body));
                let [nx, ny, _] = uniform[level].dims().map(|n| n as usize);
                let size = 8 >> level;
                let at = |cell: usize| size * (cell % nx + 64 * (cell / nx % ny + 48 * (cell / (nx * ny))));
                assert!(cells.iter().all(|cell| usize::from(levels[at(*cell)]) >= level), "{flags:?}");
            }
        });
    }
    // two cells of level 0 along x, one along y and z
    let in_box = (0..8).flat_map(|z| (0..8).flat_map(move |y| (0..16).map(move |x| x + 64 * (y + 48 * z))));
    assert!(in_box.into_iter().all(|index: usize| levels[index] >= 2));
    assert_eq!(levels[64 * (47 + 48 * 31)], 0);
}

#[test]
fn lines_that_are_not_equally_spaced_are_halved_cell_by_cell() {
    let (job, sources) = job_of(&[sphere([1.4, 1.3, 0.9], 0.77, 16)]);
    let graded = GradedJob::new(PerAxis::All(0.5));
    let job = set!(Job { graded: Some(graded), ..job });
    let found = refined(&job, &sources, &Refinement::new(2)).expect("leaves");
    let uniform: Vec<Mesh> = (0..3)
        .map(|level| {
            let list = |axis: usize| {
                let lines = found.lines.list(axis);
                let n = 1 << level;
                let within = |ends: &[f64]| {
                    (0..n).map(move |part| part as f64).map({
                        let ends = [ends[0], ends[1]];
                        move |part| ends[0] + (ends[1] - ends[0]) * part / n as f64
                    })
                };
                lines.windows(2).flat_map(within).chain(lines.last().copied()).collect::<Vec<f64>>()
            };
            let lists = set!(LinesJob { x: list(0), y: list(1), z: list(2), ..LinesJob::default() });
            meshed(&set!(Job { graded: None, domain: None, lines: Some(lists), ..job.clone() }), &sources)
        })
        .collect();
    compare(&found, &uniform);
}

#[test]
fn what_cannot_be_is_refused() {
    let (job, sources) = job_of(&[sphere([1.4, 1.3, 0.9], 0.77, 8)]);
    let job = set!(Job { dims: Some([8, 6, 4]), ..job });
    let code = |job: &Job, how: &Refinement| refined(job, &sources, how).expect_err("refused").code();
    let one = Refinement::new(1);
    assert_eq!(code(&set!(Job { window: Some([0, 0, 0, 2, 2, 2]), ..job.clone() }), &one), "job-conflict");
    assert_eq!(code(&set!(Job { close_gaps: Some(2), ..job.clone() }), &one), "job-conflict");
    assert_eq!(code(&set!(Job { links: Some(LinksJob::default()), ..job.clone() }), &one), "job-conflict");
    assert_eq!(code(&set!(Job { max_cells: Some(1000), ..job.clone() }), &one), "too-many-cells");
    assert_eq!(code(&job, &Refinement::new(17)), "job-value");
    assert_eq!(code(&set!(Job { dims: Some([1 << 20, 1, 1]), ..job.clone() }), &Refinement::new(16)), "too-many-cells");
    let with = |level_of_flags: &[(u8, u8)], boxes: &[([f64; 6], u8)]| {
        let mut how = Refinement::new(1);
        (how.level_of_flags, how.boxes) = (level_of_flags.to_vec(), boxes.to_vec());
        how
    };
    assert_eq!(code(&job, &with(&[(1, 2)], &[])), "job-value");
    assert_eq!(code(&job, &with(&[(0, 1)], &[])), "job-value");
    assert_eq!(code(&job, &with(&[], &[([5.0, 0.0, 0.0, 6.0, 1.0, 1.0], 1)])), "job-value");
    assert_eq!(code(&job, &with(&[], &[([1.0, 0.0, 0.0, 1.0, 1.0, 1.0], 1)])), "job-value");
    let control = Control::default();
    control.cancel.cancel();
    let found = pollster::block_on(refine(&job, &sources, &one, &mut Engine::cpu(), &control));
    assert_eq!(found.expect_err("cancelled"), Error::Cancelled);
}

#[test]
fn the_command_counts_leaves_and_writes_them() {
    let folder = Folder::new();
    let file = folder.path("leaves.npz");
    let arguments = ["refine", SPOT, "--cells", "8", "--levels", "2", "--backend", "cpu"];
    let text = done(&[&arguments[..], &["-o", &file]].concat());
    assert!(text.starts_with("level 0 ") && text.contains("% of the") && text.lines().count() == 4, "{text}");
    let found = json(&[&arguments[..], &["--json"]].concat());
    let n = |level: usize| found["levels"][level]["leaves"].as_u64().expect("a count");
    assert_eq!(n(0) + n(1) + n(2), found["leaves"].as_u64().expect("a sum"));
    // as many numbers as leaves, all cells of their level
    let mut archive = zip::ZipArchive::new(std::fs::File::open(&file).expect("a file")).expect("an archive");
    let mut array = |name: &str| {
        let mut bytes = Vec::new();
        std::io::Read::read_to_end(&mut archive.by_name(&format!("{name}.npy")).expect(name), &mut bytes).expect(name);
        let head = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
        bytes.split_off(head)
    };
    let levels = array("level");
    for level in 0..3 {
        assert_eq!(levels.iter().filter(|of| usize::from(**of) == level).count() as u64, n(level));
    }
    for (axis, name) in ["i", "j", "k"].into_iter().enumerate() {
        let numbers = array(name);
        assert_eq!(numbers.len(), 4 * levels.len());
        for (number, level) in numbers.chunks_exact(4).zip(&levels) {
            let dims = found["levels"][usize::from(*level)]["dims"][axis].as_u64().expect("a number of cells");
            assert!(u64::from(u32::from_le_bytes([number[0], number[1], number[2], number[3]])) < dims);
        }
    }
    let flags = array("flag");
    assert!(flags.len() == levels.len() && flags.contains(&1) && flags.contains(&0));
    for (more, says) in [
        (["-o", "a.vtu"], "written to .npz only"),
        (["--level", "1"], "is not FLAG=N"),
        (["--level", "1=3"], "2 is the finest"),
        (["--box", "0,0,0,1,1=1"], "is not X0,Y0,Z0"),
        (["--box", "90,90,90,91,91,91=1"], "give a box that has some of the cells"),
    ] {
        let refused = hexcast(&[&arguments[..], &more].concat());
        let said = String::from_utf8_lossy(&refused.stderr);
        assert!(!refused.status.success() && said.contains(says), "{said}");
    }
}
