//! `hexcast verify`: it agrees with the mesher on every case, and it finds every fault that is put in.

mod faults;
pub(crate) mod sweep;

use hexcast::control::Control;
use hexcast::geometry::{Facet, Placing};
use hexcast::job::{AxisChoice, GeometryJob, Job, Open, Rule};
use hexcast::mesh::Mesh;
use hexcast::pipeline::{Engine, MeshOptions, mesh};
use hexcast::read::read_bytes;
use hexcast::sources::Source;
use hexcast::write::{Compress, Format, Options, write};

use super::cases::cases;
use super::cli::{Folder, SPOT, hexcast};
use super::models::{self, Facets};
use super::open_surfaces::without;
use super::soups::{Random, soup};

/// A binary STL.
pub(crate) fn stl(facets: &[Facet]) -> Vec<u8> {
    let mut bytes = [&[0; 80][..], &(facets.len() as u32).to_le_bytes()].concat();
    for facet in facets {
        bytes.extend([0; 12]);
        bytes.extend(facet.as_flattened().iter().flat_map(|number| number.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

/// A folder with the files of a job, the job, and its mesh.
struct Meshed {
    folder: Folder,
    job: Job,
}

impl Meshed {
    /// Meshes surfaces in memory; the entries of the job get the files `0.stl`, `1.stl`, ...
    fn new(surfaces: &[Facets], job: Job) -> Meshed {
        Meshed::if_meshed(surfaces, job).expect("a mesh")
    }

    /// The same; None of a job that is refused.
    fn if_meshed(surfaces: &[Facets], mut job: Job) -> Option<Meshed> {
        let folder = Folder::new();
        job.geometries.resize(surfaces.len(), GeometryJob::new("."));
        let mut sources = Vec::new();
        for (index, (entry, facets)) in job.geometries.iter_mut().zip(surfaces).enumerate() {
            entry.file = folder.path(&format!("{index}.stl"));
            let bytes = stl(facets);
            std::fs::write(&entry.file, &bytes).expect("the folder is there");
            let contents = read_bytes(&bytes).expect("a binary STL");
            sources.push(Source::new(entry.file.clone(), contents, None));
        }
        let (mut engine, options, control) = (Engine::cpu(), MeshOptions::default(), Control::default());
        let meshed = pollster::block_on(mesh(&job, sources, &options, &mut engine, &control));
        let made = Meshed { folder, job };
        made.write(&meshed.ok()?.0);
        made.write_job(&made.job);
        Some(made)
    }

    fn write(&self, mesh: &Mesh) {
        let options = Options::default().with_compress(Compress::None);
        let mut file = std::fs::File::create(self.folder.path("mesh.hxc")).expect("a file");
        write(mesh, Format::Columns, &options, &mut file, &Control::default()).expect("the mesh is written");
    }

    fn write_job(&self, job: &Job) {
        std::fs::write(self.folder.path("job.json"), job.to_json()).expect("the folder is there");
    }

    /// Runs the check; its exit code and what it prints.
    fn verify(&self, more: &[&str]) -> (Option<i32>, String) {
        let (mesh, job) = (self.folder.path("mesh.hxc"), self.folder.path("job.json"));
        let output = hexcast(&[&["verify", &mesh, "--job", &job], more].concat());
        let text = [output.stdout, output.stderr].concat();
        (output.status.code(), String::from_utf8(text).expect("UTF-8"))
    }

    #[track_caller]
    fn is_right(&self, what: &str) -> String {
        let (code, text) = self.verify(&[]);
        assert!(
            code == Some(0) && text.contains("All cells that were checked are as the job defines them."),
            "{what}: {code:?}\n{text}"
        );
        text
    }
}

pub(crate) const AXES: [AxisChoice; 3] = [AxisChoice::X, AxisChoice::Y, AxisChoice::Z];
const OPEN: [Open; 3] = [Open::Winding, Open::Vote, Open::Parity];

#[test]
fn the_case_table_is_verified() {
    let mut n_checked = 0;
    for (index, case) in cases().into_iter().enumerate() {
        let geometries: Vec<_> = case.geometries.iter().filter(|geometry| !geometry.facets.is_empty()).collect();
        // transforms have a test of their own
        let is_placed = geometries.iter().any(|geometry| geometry.world_from_file != Placing::default());
        if geometries.is_empty() || is_placed {
            continue;
        }
        let entry = |geometry: &&hexcast::geometry::Geometry| {
            set!(GeometryJob {
                flag: Some(geometry.flag),
                priority: geometry.priority,
                open: Some(OPEN[index % 3]),
                ..GeometryJob::new(".")
            })
        };
        let end = |axis: usize| case.lines.line(axis, case.lines.dims()[axis]);
        let [x, y, z] = case.lines.origin();
        let job = set!(Job {
            geometries: geometries.iter().map(entry).collect(),
            domain: Some([x, y, z, end(0), end(1), end(2)]),
            dims: Some(case.lines.dims()),
            rule: case.rule,
            axis: AXES[index / 3 % 3],
            ..Job::default()
        });
        let surfaces: Vec<Facets> = geometries.iter().map(|geometry| geometry.facets.slice().to_vec()).collect();
        Meshed::new(&surfaces, job).is_right(&case.name);
        n_checked += 1;
    }
    assert!(n_checked >= 100, "{n_checked} cases");
}

#[test]
fn holes_ties_and_every_policy_are_verified() {
    let mut n_doubtful = 0;
    for seed in 0..40 {
        let mut case = soup(seed);
        let mut random = Random::new(seed);
        let geometries = std::mem::take(&mut case.geometries);
        let surfaces: Vec<Facets> = geometries
            .iter()
            .map(|geometry| without(geometry.facets.slice(), [0.15, 0.4][seed as usize % 2], random.below(1 << 40)))
            .collect();
        if surfaces.iter().any(Vec::is_empty) {
            continue;
        }
        let end = |axis: usize| case.lines.line(axis, case.lines.dims()[axis]);
        let [x, y, z] = case.lines.origin();
        let job = set!(Job {
            domain: Some([x, y, z, end(0), end(1), end(2)]),
            dims: Some(case.lines.dims().map(|n| n + random.below(9) as u32)),
            open: OPEN[random.below(3) as usize],
            axis: AXES[random.below(3) as usize],
            rule: case.rule,
            ..Job::default()
        });
        let text = Meshed::new(&surfaces, job.clone()).is_right(&format!("seed {seed}, {job:?}"));
        n_doubtful += usize::from(text.contains("Doubtful cells"));
    }
    assert!(n_doubtful > 4, "{n_doubtful} soups had doubtful cells");
}

/// A strip that is turned by half a turn on its way round.
fn moebius(n: usize) -> Facets {
    let at = |i: usize, side: f64| -> [f32; 3] {
        let (sine, cosine) = libm::sincos(2.0 * std::f64::consts::PI * i as f64 / n as f64);
        let (tilt_sine, tilt) = libm::sincos(std::f64::consts::PI * i as f64 / n as f64);
        let away = 2.5 + side * tilt;
        [4.0 + away * cosine, 4.1 + away * sine, 4.2 + side * tilt_sine].map(|place| place as f32)
    };
    let quad = |i: usize| {
        let [a, b] = [at(i, -1.2), at(i, 1.2)];
        // the end is the start, upside down
        let [c, d] = if i + 1 == n { [at(0, -1.2), at(0, 1.2)] } else { [at(i + 1, 1.2), at(i + 1, -1.2)] };
        [[a, b, c], [a, c, d]]
    };
    (0..n).flat_map(quad).collect()
}

#[test]
fn surfaces_without_sides_and_turned_facets_are_verified() {
    let mut inside_out = models::sphere([4.0; 3], 3.2, 18);
    inside_out.truncate(200);
    inside_out.iter_mut().step_by(3).for_each(|facet| facet.swap(0, 1));
    let domain = Some([0.0, 0.0, 0.0, 8.0, 8.0, 8.0]);
    for (name, surface) in [("moebius", moebius(21)), ("turned", inside_out)] {
        for rule in [Rule::Parity, Rule::Nonzero] {
            for open in OPEN {
                let job = set!(Job { dims: Some([13, 14, 15]), domain, rule, open, ..Job::default() });
                Meshed::new(std::slice::from_ref(&surface), job).is_right(&format!("{name}, {rule:?}, {open:?}"));
            }
        }
    }
}

#[test]
fn models_placings_and_lines_are_verified() {
    let facets_of = |file: &str| -> Facets {
        let solids = read_bytes(&std::fs::read(file).expect("a fixture")).expect("an STL").solids;
        solids.iter().flat_map(|solid| solid.facets.slice().to_vec()).collect()
    };
    let (spot, part) = (facets_of(SPOT), facets_of("tests/fixtures/featuretype.stl"));
    let torn = without(&spot, 0.02, 1);
    let turned = set!(GeometryJob {
        scale: Some(hexcast::job::PerAxis::Each([1.5, -1.0, 0.8])),
        rotate: Some([30.0, -1040.5, 90.0]),
        about: Some([0.1, -0.3, 0.25]),
        translate: Some([0.3, 0.2, 0.1]),
        ..GeometryJob::new(".")
    });
    let padding = Some(hexcast::job::Padding::Cells(hexcast::job::PerAxis::Each([1, 0, 3])));
    let length = Some(hexcast::job::Padding::Length(hexcast::job::PerAxis::All(0.07)));
    let plain = set!(Job { cells: Some(60), ..Job::default() });
    for axis in AXES {
        let job = set!(Job { axis, ..plain.clone() });
        let text = Meshed::new(std::slice::from_ref(&spot), job.clone()).is_right("spot");
        assert!(!text.contains("not closed"), "{text}");
        let text = Meshed::new(std::slice::from_ref(&torn), set!(Job { padding, cells: Some(24), ..job.clone() }))
            .is_right("spot with holes");
        assert!(text.contains("0.stl is not closed") && text.contains(", of which 0 are too close to call"), "{text}");
        Meshed::new(std::slice::from_ref(&part), set!(Job { rule: Rule::Nonzero, ..job.clone() }))
            .is_right("featuretype");
        let geometries = vec![GeometryJob::new("."), turned.clone()];
        Meshed::new(&[spot.clone(), spot.clone()], set!(Job { geometries, padding: length, ..job })).is_right("turned");
    }
    let sized = |size| set!(Job { cell_size: Some(hexcast::job::PerAxis::All(size)), ..Job::default() });
    Meshed::new(&[models::cube([0.1; 3], 1.0)], sized(0.1)).is_right("a size");
    let optimal = set!(Job { max_cell_size: Some(0.3), ..Job::default() });
    let two = [models::cube([0.0; 3], 1.5), models::cube([0.5; 3], 2.5)];
    Meshed::new(&two, optimal).is_right("the optimum");
}

#[test]
fn ascii_files_split_solids_and_arguments_are_taken_as_by_mesh() {
    let folder = Folder::new();
    let output = folder.path("mesh.hxc");
    let two = "tests/fixtures/ascii_two_solids_mixed_case.stl";
    let missing = "tests/fixtures/ascii_missing_endsolid.stl";
    let arguments: &[&[&str]] = &[
        &[&format!("{two}:split=true,flag=3"), "--cells", "24"],
        &[&format!("{two}:split=true,flag=3,same_flag=true"), "--cells", "24"],
        &[two, missing, "--dims", "9,10,11", "--rule", "nonzero"],
        &["tests/fixtures/bin_header_solid_cube.stl:rotate=10/20/30", SPOT, "--cell-size", "2", "--padding-cells", "2"],
    ];
    for arguments in arguments {
        let made = hexcast(&[&["mesh", "--backend", "cpu", "-q", "-o", &output], *arguments].concat());
        assert!(made.status.success(), "{made:?}");
        let verified = hexcast(&[&["verify", &output], *arguments].concat());
        assert!(verified.status.success(), "{arguments:?}: {verified:?}");
    }
}

#[test]
fn files_of_other_formats_are_checked_and_named() {
    let folder = Folder::new();
    let output = folder.path("mesh.hxc");
    let packed = folder.path("spot.stl.gz");
    let mut gzip = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    std::io::Write::write_all(&mut gzip, &std::fs::read(SPOT).expect("a fixture")).expect("memory");
    std::fs::write(&packed, gzip.finish().expect("memory")).expect("the folder is there");
    let obj = folder.path("box.obj");
    std::fs::write(&obj, "v 0 0 0\nv 3 0 0\nv 0 3 0\nv 0 0 3\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n").expect("a file");
    let scene = "tests/fixtures/scene.3mf";
    let glb = "tests/fixtures/scene.glb:split=true";
    for (file, says) in [(&packed[..], "(gzip)"), (&obj, "(OBJ)"), (scene, "(3MF)"), (glb, "(GLB)")] {
        let made = hexcast(&["mesh", file, "--cells", "24", "--backend", "cpu", "-q", "-o", &output]);
        assert!(made.status.success(), "{made:?}");
        let verified = hexcast(&["verify", &output, file, "--cells", "24"]);
        let text = String::from_utf8_lossy(&verified.stdout);
        assert!(verified.status.success(), "{file}: {verified:?}");
        let line = text.lines().find(|line| line.starts_with("The facets of "));
        assert!(line.is_some_and(|line| line.contains("as the mesher reads them")), "{text}");
        assert!(line.is_some_and(|line| line.contains(says)), "{says}: {text}");
    }
    let verified = hexcast(&["verify", &output, scene, "--cells", "25"]);
    assert_eq!(verified.status.code(), Some(9), "{verified:?}");
}
