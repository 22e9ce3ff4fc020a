//! What parts of the report say, of facts made by hand.

use crate::meshing::mesher::Mesher;
use crate::meshing::pipeline::Engine;
use crate::meshing::report::{
    CallerFacts, CertificateReport, ColumnsReport, DoubtReport, FractionsReport, GeometryReport, LinksReport,
    OpenReport, Report, is_cut,
};
use hexcast_core::cells::columns::{Band, Columns, Named, run};
use hexcast_core::grid::closed::{BadEdges, EdgeGroup};
use hexcast_core::grid::lines::Lines;
use hexcast_core::grid::rays::Rays;
use hexcast_core::input::edges::BadEdge;
use hexcast_core::input::geometry::{Geometry, Open};
use hexcast_core::input::job::{GeometryJob, Job};
use hexcast_core::open_surfaces::doubt::Doubtful;
use hexcast_core::set;
use hexcast_derived::certificate::{Certificate, FlagGap, Overlap, ThinWall};
use hexcast_derived::fractions::Fractions;
use hexcast_derived::links::Link;
use hexcast_derived::mesh::Mesh;
use hexcast_derived::testing::{links_of, no_fractions};

fn geometry(name: &str, bad_edges: BadEdges) -> GeometryReport {
    let facets = vec![[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]];
    GeometryReport::new(&Geometry::new(name, 1, facets).unwrap(), bad_edges)
}

#[test]
fn a_box_is_cut_where_it_reaches_beyond_a_centre_outside() {
    // cells of 1 at the first end and of 4 at the second
    let lines = Lines::from_lists([0, 1, 2].map(|_| vec![0.0, 1.0, 3.0, 7.0])).unwrap();
    for axis in 0..3 {
        for (low, high, expected) in
            [(-0.5, 9.0, false), (1.0, 2.0, false), (-0.51, 2.0, true), (1.0, 9.01, true), (1.0, 8.0, false)]
        {
            let mut bounds = [[1.0; 3], [2.0; 3]];
            (bounds[0][axis], bounds[1][axis]) = (low, high);
            assert_eq!(is_cut(bounds, &lines), expected, "{low} to {high} along axis {axis}");
        }
    }
}

#[test]
fn a_warning_of_an_open_geometry_says_what_is_open_and_who_decided() {
    let lines = Lines::new([0.0; 3], [1.0; 3], [2, 3, 4]).unwrap();
    let report = |policy, added_facets| OpenReport {
        geometry: "a".into(),
        policy,
        open_edges: 5,
        holes: 2,
        added_facets,
        longest_at: [1.0, 2.0, 3.5],
        turned: 7,
        odd_rays: [1, 2, 3],
        doubtful_cells: 4,
        index: 0,
    };
    let group = |kind, n: u64| EdgeGroup {
        kind,
        edges: 9,
        length: 1.0,
        bounds: [[0.0; 3], [1.0; 3]],
        facets: (0..n).collect(),
    };
    let edges = |open, flipped, worst| BadEdges { open, flipped, nonmanifold: 0, worst };
    let is_open = "a\" is not closed: open edges 5, loops 2, the longest edge at (1, 2, 3.5)";
    let is_flipped = "a\" is not closed: edges between facets that face opposite ways 6, facets turned 7";
    let added = "; facets added where one was missing between three open edges: 2";
    let end = "; rays that do not leave it as often as they enter: 1 along x, 2 along y, 3 along z; 4 of 24 cells were doubtful and were \
               decided by";
    for (open, flipped, policy, n_added, expected) in [
        (5, 0, Open::Winding, 0, format!("{is_open}{end} the winding number")),
        (5, 6, Open::Vote, 2, format!("{is_open}{added}{end} most of their even rays")),
        (0, 6, Open::Winding, 0, format!("{is_flipped}{end} the winding number")),
        (0, 1, Open::Vote, 0, format!("{}{end} most of their even rays", is_flipped.replace("ways 6", "ways 1"))),
        (0, 0, Open::Winding, 0, format!("{is_open}{end} the winding number")),
    ] {
        let found = report(policy, n_added).finding(&geometry("a", edges(open, flipped, vec![])), &lines).sentence;
        assert_eq!(found, format!("geometry \"{expected}"));
    }
    let worst = vec![group(BadEdge::Open, 8), group(BadEdge::Flipped, 3)];
    let found = |open| report(Open::Winding, 0).finding(&geometry("a", edges(open, 6, worst.clone())), &lines).sentence;
    let [of_open, of_flipped] = [
        "; 9 of them between (0, 0, 0) and (1, 1, 1), of facets 0, 1, 2, 3, 4, 5, 6, 7 and maybe others, counted from 0",
        "; 9 of them between (0, 0, 0) and (1, 1, 1), of facets 0, 1, 2, counted from 0",
    ];
    assert!(found(5).contains(of_open) && found(0).contains(of_flipped), "{} {}", found(5), found(0));
}

#[test]
fn links_are_counted_by_cells_and_by_what_is_behind_them() {
    let link = |x: u32, direction: u8, flag: u8, facet: i32| {
        set!(Link { cell: [x, 0, 0], q: 0.5, facet, direction, flag, ..Link::default() })
    };
    let planes = vec![
        vec![link(0, 0, 1, 0), link(0, 1, 1, -1), link(1, 0, 2, 3)],
        vec![],
        vec![link(0, 0, 0, 5), link(2, 2, 0, 6), link(3, 0, 7, 7), link(3, 1, 3, -1)],
    ];
    let links = links_of([4, 1, 3], vec![0, 7], planes);
    let LinksReport { links, cells, through_walls, without_facet, fluid, .. } = LinksReport::new(&links);
    assert_eq!((links, cells, through_walls, without_facet, fluid), (7, 5, 3, 2, vec![0, 7]));
}

#[test]
fn a_certificate_names_geometries_flags_and_axes() {
    let lines = Lines::from_lists([vec![0.0, 1.0, 3.0], vec![0.0, 2.0, 3.0], vec![0.0, 4.0, 5.0]]).unwrap();
    let geometries = ["a", "b", "c"].map(|name| geometry(name, BadEdges::default()));
    let names = [Named::new(3, "three"), Named::new(5, "five")];
    let found = Certificate {
        thin_cells: 2,
        thin_walls: vec![ThinWall { geometry: 2, axis: 1, rays: 4, lost: 3, cells: 1, place: [1.0, 2.0, 3.0] }],
        overlaps: vec![Overlap {
            geometries: [1, 0],
            cells: 7,
            volume: 3.5,
            total: Default::default(),
            longest: 2,
            place: [3.0, 2.0, 1.0],
        }],
        gaps: vec![FlagGap { flags: [3, 5], axis: 2, cells: 6, first: [1, 0, 1], bounds: [[0, 0, 1], [2, 1, 2]] }],
    };
    let report = CertificateReport::new(&found, &geometries, &names, &lines);
    let (wall, overlap, gap) = (&report.thin_walls[0], &report.overlaps[0], &report.gaps[0]);
    assert_eq!((&wall.geometry[..], wall.axis, wall.index, wall.rays, wall.lost), ("c", "y", 2, 4, 3));
    assert_eq!((&overlap.winner[..], &overlap.loser[..], overlap.indices), ("b", "a", [1, 0]));
    assert_eq!((gap.names.each_ref().map(|name| &name[..]), gap.axis, gap.cells), (["three", "five"], "z", 6));
    assert_eq!((gap.place, gap.bounds), ([2.0, 1.0, 4.5], [[0.0, 0.0, 4.0], [3.0, 2.0, 5.0]]));
    let json = serde_json::to_string(&report).unwrap();
    assert_eq!(serde_json::from_str::<CertificateReport>(&json).unwrap(), report);
    assert!(serde_json::from_str::<CertificateReport>(&json.replace("\"z\"", "\"w\"")).is_err());
}

#[test]
fn flags_of_columns_are_those_with_cells_and_those_with_a_name() {
    let rays = Rays::new(2, [1, 1, 10]);
    let runs = vec![run(1, 255), run(3, 0), run(4, 2), run(5, 0), run(6, 1)];
    let columns = Columns::new(rays, vec![set!(Band { ends: vec![5], runs, ..Band::default() })]).unwrap();
    let lines = Lines::new([0.0; 3], [0.5; 3], [1, 1, 10]).unwrap();
    let names = vec![Named::new(1, "one"), Named::new(9, "nine"), Named::new(0, "air")];
    let mesh = Mesh::new(lines, columns, names, None).unwrap();
    let report = ColumnsReport::new(&mesh);
    let found: Vec<_> = report.flags.iter().map(|of| (of.flag, of.name, of.cells, of.volume)).collect();
    let of = |flag, name, cells: u64| (flag, name, cells, Some(cells as f64 * 0.125));
    assert_eq!(found, [of(1, "one", 4), of(2, "", 1), of(9, "nine", 0), of(255, "", 2)]);
}

#[test]
fn volumes_of_fractions_are_those_of_flags_that_have_any() {
    let mut volumes = vec![0.0; 256];
    (volumes[0], volumes[3], volumes[255]) = (2.0, 0.5, 1.0);
    let fractions = set!(Fractions { volumes, ..no_fractions([1; 3]) });
    let report = FractionsReport::new(&fractions);
    let found: Vec<_> = report.volumes.iter().map(|of| (of.flag, of.volume)).collect();
    assert_eq!((report.cut_cells, found), (0, vec![(0, 2.0), (3, 0.5), (255, 1.0)]));
}

#[test]
fn boxes_of_doubtful_cells_are_all_where_they_hold_as_many() {
    let boxes = vec![[[1, 2, 3], [3, 5, 7]], [[0; 3], [1, 1, 2]]];
    for (n_cells, are_all) in [(26, true), (27, false)] {
        let found = DoubtReport::new(&Doubtful { n_cells, boxes: boxes.clone(), mask: None });
        assert_eq!((found.cells, found.cells_in_boxes, found.are_all), (n_cells, 26, are_all));
    }
}

#[test]
fn seconds_of_a_report_are_those_of_the_mesh_and_of_its_caller() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/fixtures/scene.stl");
    let job = set!(Job { geometries: vec![GeometryJob::new(file)], cells: Some(4), ..Job::default() });
    let (_, report) = Mesher::with_engine(Engine::cpu()).mesh(&job).unwrap();
    let mut facts = report.mesh;
    (facts.seconds.lines, facts.seconds.snap, facts.seconds.columns) = (2.0, 4.0, 8.0);
    for (flags, total) in [(None, 15.0), (Some(16.0), 31.0)] {
        let caller = CallerFacts::default().with_read(1.0).with_flags(flags).with_hash(Some(32.0));
        let caller = caller.with_write(Some(64.0)).with_flags_sha256(Some("ab".into())).with_host_bytes(Some(7));
        let report = Report::new(facts.clone(), caller);
        let seconds = report.seconds;
        assert_eq!((seconds.total, seconds.read, seconds.flags), (total, 1.0, flags));
        assert_eq!((seconds.hash, seconds.write, report.peak_bytes.host), (Some(32.0), Some(64.0), Some(7)));
        assert_eq!((report.cells_per_second, report.flags_sha256.as_deref()), (facts.cells as f64 / total, Some("ab")));
        let json: serde_json::Value = serde_json::from_str(&report.to_json()).unwrap();
        assert_eq!(json["seconds"]["total"], total);
    }
}
