//! Every kernel against its CPU definition on the case table, then the whole line.
//!
//! The kernels run as they ship, on the adapter that the system prefers or the one named by `HEXCAST_TEST_ADAPTER` (a part of
//! its name). No adapter is a failure, unless `HEXCAST_TEST_WITHOUT_GPU=1` says that the machine is known to have none.

use std::sync::OnceLock;

use hexcast::columns::{Band, Columns};
use hexcast::control::{CancelToken, Control};
use hexcast::cpu;
use hexcast::crossings::{Crossings, crossings};
use hexcast::frame::Frame;
use hexcast::gpu::{Cast, Gpu, Options};
use hexcast::lattice::{Lattice, lattice};
use hexcast::map::{Mapping, map};
use hexcast::rays::Rays;

use super::cases::{Case, cases};

const BIN: [u32; 2] = [8, 8];

/// The device, opened once; None only where a variable says that there is none.
pub(crate) fn gpu() -> Option<&'static Gpu> {
    static GPU: OnceLock<Option<Gpu>> = OnceLock::new();
    GPU.get_or_init(|| {
        let wanted = std::env::var("HEXCAST_TEST_ADAPTER").ok();
        match pollster::block_on(Gpu::open(wanted.as_deref())) {
            Ok(gpu) => {
                println!("adapter: {} ({}, {})", gpu.facts.name, gpu.facts.driver, gpu.facts.api);
                Some(gpu)
            }
            Err(error) if std::env::var("HEXCAST_TEST_WITHOUT_GPU").as_deref() == Ok("1") => {
                println!("no GPU, as HEXCAST_TEST_WITHOUT_GPU says: {error}");
                None
            }
            Err(error) => {
                panic!("{error}: install a Vulkan driver such as lavapipe, or set HEXCAST_TEST_WITHOUT_GPU=1")
            }
        }
    })
    .as_ref()
}

/// Runs a check on every case of the table with rays along every axis.
fn on_every_case(check: impl Fn(&Gpu, &Case, &Cast)) {
    let Some(gpu) = gpu() else { return };
    let cases = cases();
    for case in &cases {
        let frame = Frame::new(&case.geometries, &case.lines).unwrap_or_else(|error| panic!("{}: {error}", case.name));
        for axis in 0..3 {
            let rays = Rays::new(axis, case.lines.dims);
            check(gpu, case, &Cast { frame: &frame, rays: &rays, rule: case.rule });
        }
    }
    println!("{} cases along 3 axes on {}", cases.len(), gpu.facts.name);
}

/// The CPU's lattice with the kernels' bins.
fn cpu_lattice(cast: &Cast) -> Lattice {
    lattice(cast.frame, cast.rays, BIN, 0..Lattice::n_rows(cast.rays, BIN))
}

/// The CPU's crossings of all rays, sorted within a ray.
fn cpu_crossings(cast: &Cast, lattice: &Lattice) -> Crossings {
    let mut all = Crossings { first_ray: 0, offsets: vec![0], events: vec![] };
    for row in lattice.rows.clone() {
        let part = crossings(cast.frame, cast.rays, lattice, row);
        let base = all.events.len() as u32;
        all.offsets.extend(part.offsets[1..].iter().map(|offset| base + offset));
        all.events.extend(part.events);
    }
    sorted(all)
}

/// Crossings are a set: their order within a ray means nothing.
fn sorted(mut crossings: Crossings) -> Crossings {
    for ray in crossings.offsets.windows(2) {
        crossings.events[ray[0] as usize..ray[1] as usize].sort_unstable();
    }
    crossings
}

fn cpu_band(cast: &Cast, crossings: &Crossings) -> Band {
    let flag_of_rank = &cast.frame.ranks.flag_of_rank;
    map(crossings, &Mapping { rule: cast.rule, flag_of_rank, depth: cast.rays.depth })
}

fn ok<T>(case: &Case, result: hexcast::Result<T>) -> T {
    result.unwrap_or_else(|error| panic!("{}: {error}", case.name))
}

#[test]
fn the_lattice_kernels_find_the_facets_of_every_bin() {
    on_every_case(|gpu, case, cast| {
        let mut found = ok(case, pollster::block_on(gpu.lattice(cast)));
        let expected = cpu_lattice(cast);
        for bin in found.offsets.clone().windows(2) {
            found.facets[bin[0] as usize..bin[1] as usize].sort_unstable();
        }
        assert!(found == expected, "{} along {}: {found:?}\nexpected {expected:?}", case.name, cast.rays.axis);
    });
}

#[test]
fn the_intersection_kernels_find_every_crossing_from_the_definitions_lattice() {
    on_every_case(|gpu, case, cast| {
        let lattice = cpu_lattice(cast);
        let found = sorted(ok(case, pollster::block_on(gpu.crossings(cast, &lattice))));
        let expected = cpu_crossings(cast, &lattice);
        assert!(found == expected, "{} along {}: {found:?}\nexpected {expected:?}", case.name, cast.rays.axis);
    });
}

#[test]
fn the_mapping_kernels_make_the_runs_from_the_definitions_crossings() {
    on_every_case(|gpu, case, cast| {
        let crossings = cpu_crossings(cast, &cpu_lattice(cast));
        let found = ok(case, pollster::block_on(gpu.map(cast, &crossings)));
        let expected = cpu_band(cast, &crossings);
        assert!(found == expected, "{} along {}: {found:?}\nexpected {expected:?}", case.name, cast.rays.axis);
    });
}

#[test]
fn the_definition_goes_on_from_any_stage_of_the_kernels() {
    on_every_case(|gpu, case, cast| {
        let lattice = ok(case, pollster::block_on(gpu.lattice(cast)));
        let expected = cpu_crossings(cast, &cpu_lattice(cast));
        assert!(cpu_crossings(cast, &lattice) == expected, "{}: crossings from the kernels' lattice", case.name);
        let crossings = ok(case, pollster::block_on(gpu.crossings(cast, &lattice)));
        let band = cpu_band(cast, &crossings);
        assert!(band == cpu_band(cast, &expected), "{}: runs from the kernels' crossings", case.name);
    });
}

#[test]
fn the_whole_line_gives_the_definitions_columns() {
    on_every_case(|gpu, case, cast| {
        let found = ok(case, pollster::block_on(gpu.columns(cast, &Control::default())));
        let expected = ok(case, cpu::columns(cast.frame, cast.rays, cast.rule, &Control::default()));
        assert!(found == expected, "{} along {}", case.name, cast.rays.axis);
        assert_eq!(found.odd_rays(), expected.odd_rays(), "{}: odd rays", case.name);
        assert_eq!(found.n_crossings(), expected.n_crossings(), "{}: crossings", case.name);
    });
}

#[test]
fn bands_of_any_number_of_ray_rows_give_the_same_columns() {
    on_every_case(|gpu, case, cast| {
        let expected = ok(case, cpu::columns(cast.frame, cast.rays, cast.rule, &Control::default()));
        // a band is a trip to the device: single rows only where there are few
        let single = cast.rays.counts[1] <= 12;
        for rows in [1, 3, 13].into_iter().filter(|&rows| rows > 1 || single) {
            let options = Options { rows_per_band: Some(rows), profile: false };
            let mut bands = Vec::new();
            ok(case, pollster::block_on(gpu.continue_columns(cast, &options, &Control::default(), &mut bands)));
            assert!(Columns::new(*cast.rays, bands) == expected, "{} in bands of {rows} rows", case.name);
        }
    });
}

#[test]
fn a_mesh_goes_on_where_it_was_left() {
    let Some(gpu) = gpu() else { return };
    let case = &cases()[0];
    let frame = ok(case, Frame::new(&case.geometries, &case.lines));
    let rays = Rays::new(0, case.lines.dims);
    let cast = Cast { frame: &frame, rays: &rays, rule: case.rule };
    let whole = ok(case, pollster::block_on(gpu.columns(&cast, &Control::default())));
    let options = Options { rows_per_band: Some(2), profile: false };
    let token = CancelToken::default();
    let stop = token.clone();
    let mut stopping = Control::with_progress(move |_| stop.cancel());
    stopping.cancel = token;
    let mut bands = Vec::new();
    let error = pollster::block_on(gpu.continue_columns(&cast, &options, &stopping, &mut bands)).unwrap_err();
    assert_eq!((error.code(), bands.len()), ("cancelled", 1));
    ok(case, pollster::block_on(gpu.continue_columns(&cast, &options, &Control::default(), &mut bands)));
    assert!(bands.len() > 1 && Columns::new(rays, bands) == whole);
}
