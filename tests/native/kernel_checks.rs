//! Every kernel against its CPU definition on the case table, then the whole line and the golden files: what the native
//! tests (`kernels.rs`) and those in a browser (`tests/web/kernels.rs`) both run, each on a device of its own.
//!
//! The kernels run as they ship. A check returns how many cases it ran, for the reader of the test's output.

use std::future::poll_fn;
use std::pin::Pin;
use std::task::Poll;

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
use super::golden::{assert_complete, assert_golden};

const BIN: [u32; 2] = [8, 8];

/// Declares a test of each check: `$test` makes a test of a name and a function of `&Gpu`, so that no check is forgotten
/// in one of the two places.
macro_rules! every_check {
    ($test:ident) => {
        $test!(the_lattice_kernels_find_the_facets_of_every_bin);
        $test!(the_intersection_kernels_find_every_crossing_from_the_definitions_lattice);
        $test!(the_mapping_kernels_make_the_runs_from_the_definitions_crossings);
        $test!(the_definition_goes_on_from_any_stage_of_the_kernels);
        $test!(the_whole_line_gives_the_definitions_columns);
        $test!(the_whole_line_gives_the_golden_files);
        $test!(bands_of_any_number_of_ray_rows_give_the_same_columns);
        $test!(a_mesh_goes_on_where_it_was_left);
    };
}
pub(crate) use every_check;

fn frame(case: &Case) -> Frame {
    Frame::new(&case.geometries, &case.lines).unwrap_or_else(|error| panic!("{}: {error}", case.name))
}

/// Cases checked at once: a browser may look only every tenth of a second whether the device has answered.
const AT_ONCE: usize = 12;

/// Runs futures on this thread until all are done.
async fn together<'a>(futures: impl IntoIterator<Item = impl Future<Output = ()> + 'a>) {
    let mut pending: Vec<Pin<Box<dyn Future<Output = ()> + 'a>>> = Vec::new();
    for future in futures {
        pending.push(Box::pin(future));
    }
    poll_fn(|context| {
        pending.retain_mut(|future| future.as_mut().poll(context).is_pending());
        if pending.is_empty() { Poll::Ready(()) } else { Poll::Pending }
    })
    .await;
}

/// Runs a check on every case of the table.
async fn on_every_case(check: impl AsyncFn(&Case)) -> usize {
    let cases = cases();
    for some in cases.chunks(AT_ONCE) {
        together(some.iter().map(|case| check(case))).await;
    }
    cases.len()
}

/// Runs a check on every case of the table with rays along every axis.
async fn on_every_cast(check: impl AsyncFn(&Case, &Cast<'_>)) -> usize {
    on_every_case(async |case| {
        let frame = frame(case);
        for axis in 0..3 {
            let rays = Rays::new(axis, case.lines.dims);
            check(case, &Cast { frame: &frame, rays: &rays, rule: case.rule }).await;
        }
    })
    .await
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

pub(crate) async fn the_lattice_kernels_find_the_facets_of_every_bin(gpu: &Gpu) -> usize {
    on_every_cast(async |case, cast| {
        let mut found = ok(case, gpu.lattice(cast).await);
        let expected = cpu_lattice(cast);
        for bin in found.offsets.clone().windows(2) {
            found.facets[bin[0] as usize..bin[1] as usize].sort_unstable();
        }
        assert!(found == expected, "{} along {}: {found:?}\nexpected {expected:?}", case.name, cast.rays.axis);
    })
    .await
}

pub(crate) async fn the_intersection_kernels_find_every_crossing_from_the_definitions_lattice(gpu: &Gpu) -> usize {
    on_every_cast(async |case, cast| {
        let lattice = cpu_lattice(cast);
        let found = sorted(ok(case, gpu.crossings(cast, &lattice).await));
        let expected = cpu_crossings(cast, &lattice);
        assert!(found == expected, "{} along {}: {found:?}\nexpected {expected:?}", case.name, cast.rays.axis);
    })
    .await
}

pub(crate) async fn the_mapping_kernels_make_the_runs_from_the_definitions_crossings(gpu: &Gpu) -> usize {
    on_every_cast(async |case, cast| {
        let crossings = cpu_crossings(cast, &cpu_lattice(cast));
        let found = ok(case, gpu.map(cast, &crossings).await);
        let expected = cpu_band(cast, &crossings);
        assert!(found == expected, "{} along {}: {found:?}\nexpected {expected:?}", case.name, cast.rays.axis);
    })
    .await
}

pub(crate) async fn the_definition_goes_on_from_any_stage_of_the_kernels(gpu: &Gpu) -> usize {
    on_every_cast(async |case, cast| {
        let lattice = ok(case, gpu.lattice(cast).await);
        let expected = cpu_crossings(cast, &cpu_lattice(cast));
        assert!(cpu_crossings(cast, &lattice) == expected, "{}: crossings from the kernels' lattice", case.name);
        let crossings = ok(case, gpu.crossings(cast, &lattice).await);
        let band = cpu_band(cast, &crossings);
        assert!(band == cpu_band(cast, &expected), "{}: runs from the kernels' crossings", case.name);
    })
    .await
}

pub(crate) async fn the_whole_line_gives_the_definitions_columns(gpu: &Gpu) -> usize {
    on_every_cast(async |case, cast| {
        let found = ok(case, gpu.columns(cast, &Control::default()).await);
        let expected = ok(case, cpu::columns(cast.frame, cast.rays, cast.rule, &Control::default()));
        assert!(found == expected, "{} along {}", case.name, cast.rays.axis);
        assert_eq!(found.odd_rays(), expected.odd_rays(), "{}: odd rays", case.name);
        assert_eq!(found.n_crossings(), expected.n_crossings(), "{}: crossings", case.name);
    })
    .await
}

pub(crate) async fn the_whole_line_gives_the_golden_files(gpu: &Gpu) -> usize {
    assert_complete(&cases());
    on_every_case(async |case| {
        let frame = frame(case);
        let mut along = Vec::new();
        for axis in 0..3 {
            let rays = Rays::new(axis, case.lines.dims);
            let cast = Cast { frame: &frame, rays: &rays, rule: case.rule };
            along.push(ok(case, gpu.columns(&cast, &Control::default()).await));
        }
        assert_golden(case, &along.try_into().expect("three axes"));
    })
    .await
}

pub(crate) async fn bands_of_any_number_of_ray_rows_give_the_same_columns(gpu: &Gpu) -> usize {
    on_every_cast(async |case, cast| {
        let expected = ok(case, cpu::columns(cast.frame, cast.rays, cast.rule, &Control::default()));
        // a band is a trip to the device, up to a tenth of a second in a browser: single rows only where there are few
        let most = |rows| if rows == 1 || cfg!(target_arch = "wasm32") { 12 } else { u32::MAX };
        for rows in [1, 3, 13].into_iter().filter(|&rows| cast.rays.counts[1].div_ceil(rows) <= most(rows)) {
            let options = Options { rows_per_band: Some(rows), ..Options::default() };
            let mut bands = Vec::new();
            ok(case, gpu.continue_columns(cast, &options, &Control::default(), &mut bands).await);
            assert!(Columns::new(*cast.rays, bands) == expected, "{} in bands of {rows} rows", case.name);
        }
    })
    .await
}

pub(crate) async fn a_mesh_goes_on_where_it_was_left(gpu: &Gpu) -> usize {
    let case = &cases()[0];
    let frame = frame(case);
    let rays = Rays::new(0, case.lines.dims);
    let cast = Cast { frame: &frame, rays: &rays, rule: case.rule };
    let whole = ok(case, gpu.columns(&cast, &Control::default()).await);
    let options = Options { rows_per_band: Some(2), ..Options::default() };
    let token = CancelToken::default();
    let stop = token.clone();
    let mut stopping = Control::with_progress(move |_| stop.cancel());
    stopping.cancel = token;
    let mut bands = Vec::new();
    let error = gpu.continue_columns(&cast, &options, &stopping, &mut bands).await.unwrap_err();
    assert_eq!((error.code(), bands.len()), ("cancelled", 1));
    ok(case, gpu.continue_columns(&cast, &options, &Control::default(), &mut bands).await);
    assert!(bands.len() > 1 && Columns::new(rays, bands) == whole);
    1
}
