//! Every kernel against its CPU definition on the case table, then the whole line and the golden files: what the native
//! tests (`kernels.rs`) and those in a browser (`tests/web/kernels.rs`) both run, each on a device of its own.
//!
//! The kernels run as they ship. A check returns how many cases it ran, or a sentence that names the kernel and the case.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::future::poll_fn;
use std::pin::Pin;
use std::task::Poll;

use hexcast::columns::{Band, Columns};
use hexcast::control::{CancelToken, Control};
use hexcast::gpu::{Cells, Forced, Gpu, Options, Tiles, Usage};
use hexcast::lines::Lines;
use hexcast::mesh::Mesh;
use hexcast_core::grid::frame::Frame;
use hexcast_core::grid::rays::Rays;
use hexcast_core::stages::cast::Cast;
use hexcast_core::stages::cpu;
use hexcast_core::stages::crossings::{Crossings, crossings};
use hexcast_core::stages::facet::Projected;
use hexcast_core::stages::lattice::lattice;

use super::cases::{Case, cases};
use super::golden::{assert_complete, assert_golden};
use super::soups::{Random, stack, thinned};

/// What a check found: the number of cases, or what is wrong.
pub(crate) type Checked = Result<usize, String>;

/// Rays of a bin along both axes across.
const BIN: u32 = 8;

/// Declares a test of each check: `$test` makes a test of a name and a function of `&Gpu`, so that no check is forgotten
/// in one of the two places.
macro_rules! every_check {
    ($test:ident) => {
        $test!(scans_sum_all_numbers_before_each);
        $test!(the_lattice_finds_what_each_facet_hits);
        $test!(intersect_makes_the_tiles_of_the_definition);
        $test!(map_gives_the_definitions_columns);
        $test!(intersect_deep_finds_every_crossing);
        $test!(intersect_graded_finds_every_crossing);
        $test!(map_deep_gives_the_definitions_columns);
        $test!(batches_of_facets_change_nothing);
        $test!(the_whole_line_gives_the_golden_files);
        $test!(bands_of_any_number_of_ray_rows_give_the_same_columns);
        $test!(a_mesh_goes_on_where_it_was_left);
        $test!(stacks_with_thousands_of_crossings_agree_with_the_definition);
        $test!(expand_gives_the_flags_of_the_host);
        $test!(order_gives_the_runs_of_the_host);
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

/// The cases that kernels are checked on one by one: all, but in a browser, where each takes many messages between processes, not those of
/// thousands of crossings, which the golden files check there.
fn cases_of_kernels() -> Vec<Case> {
    cases().into_iter().filter(|case| !cfg!(target_arch = "wasm32") || case.n_facets() <= 8_000).collect()
}

/// Runs a check of a kernel on cases; the first sentence that it returns, with the kernel and the case.
async fn on_cases(kernel: &str, cases: &[Case], check: impl AsyncFn(&Case) -> Result<(), String>) -> Checked {
    let found = RefCell::new(None);
    for some in cases.chunks(AT_ONCE) {
        let one = async |case: &Case| {
            if let Err(what) = check(case).await {
                found.borrow_mut().get_or_insert(format!("{kernel}: {}: {what}", case.name));
            }
        };
        together(some.iter().map(one)).await;
    }
    found.into_inner().map_or(Ok(cases.len()), Err)
}

/// Runs a check on cases with rays along every axis.
async fn on_casts(kernel: &str, cases: &[Case], check: impl AsyncFn(&Cast<'_>) -> Result<(), String>) -> Checked {
    on_cases(kernel, cases, async |case| {
        let frame = frame(case);
        for axis in 0..3 {
            let rays = Rays::new(axis, case.lines.dims());
            let cast = Cast { frame: &frame, rays: &rays, rule: case.rule };
            check(&cast).await.map_err(|what| format!("along {axis}: {what}"))?;
        }
        Ok(())
    })
    .await
}

fn text<T>(result: hexcast::Result<T>) -> Result<T, String> {
    result.map_err(|error| error.to_string())
}

fn expect(is_so: bool, otherwise: impl FnOnce() -> String) -> Result<(), String> {
    if is_so { Ok(()) } else { Err(otherwise()) }
}

fn cpu_columns(cast: &Cast) -> Columns {
    cpu::columns(cast, &Control::default()).expect("nobody cancels")
}

async fn gpu_columns(gpu: &Gpu, cast: &Cast<'_>, options: &Options) -> Result<(Columns, Usage), String> {
    let mut bands = Vec::new();
    let usage = text(gpu.continue_columns(cast, options, &Control::default(), &mut bands).await)?;
    Ok((Columns::new(*cast.rays, bands).unwrap(), usage))
}

async fn same_columns(gpu: &Gpu, cast: &Cast<'_>, options: &Options) -> Result<Usage, String> {
    let (found, usage) = gpu_columns(gpu, cast, options).await?;
    let expected = cpu_columns(cast);
    expect(found == expected, || format!("other columns with {options:?}"))?;
    let counts = [&found, &expected].map(|columns| (columns.odd_rays(), columns.n_crossings()));
    expect(counts[0] == counts[1], || format!("odd rays and crossings: {counts:?}"))?;
    Ok(usage)
}

pub(crate) async fn scans_sum_all_numbers_before_each(gpu: &Gpu) -> Checked {
    let mut random = Random::new(77);
    let lengths = [1, 2, 5, 255, 4095, 4096, 4097, 70_000];
    for n in lengths {
        for most in [3, u64::from(u32::MAX)] {
            let numbers: Vec<u32> = (0..n).map(|_| random.below(most) as u32).collect();
            let mut sum = 0u32;
            let mut before = |number| {
                let before = sum;
                sum = sum.saturating_add(number);
                before
            };
            let expected: Vec<u32> = numbers.iter().map(|&number| before(number)).collect();
            let found = text(gpu.scanned(&numbers).await)?;
            expect(found == expected, || format!("scan_reduce, scan_apply: {n} numbers below {most}"))?;
        }
    }
    Ok(2 * lengths.len())
}

/// What the definition says of a facet over a bin: hits of rows 0 to 3 and 4 to 7.
fn hits_of(facet: &Projected, [column, row]: [u32; 2], counts: [u32; 2]) -> [u32; 2] {
    let mut hits = [0; 2];
    for (j, i) in (0..BIN).flat_map(|j| (0..BIN).map(move |i| (j, i))) {
        let ray = [column * BIN + i, row * BIN + j];
        let [di, dj] = [0, 1].map(|side| i64::from(ray[side]) - i64::from(facet.rays[side][0]));
        let is_hit = (0..3).all(|e| facet.q[e] + facet.a[e] * di + facet.b[e] * dj >= 0);
        if is_hit && ray[0] < counts[0] && ray[1] < counts[1] {
            hits[j as usize / 4] |= 1 << (8 * (j % 4) + i);
        }
    }
    hits
}

/// The layer of a facet's lowest corner.
fn layer_of(cast: &Cast, tiles: &Tiles, facet: u32) -> u32 {
    let lowest = (expected_base(cast, facet) as i32).clamp(0, cast.rays.depth as i32) as u32;
    tiles.layer_ends.iter().take(tiles.n_layers as usize - 1).filter(|&&end| end <= lowest).count() as u32
}

/// (bin, layer, facet) -> hits, as the definition says.
fn expected_hits(cast: &Cast, tiles: &Tiles) -> BTreeMap<(u32, u32, u32), [u32; 2]> {
    let mut expected = BTreeMap::new();
    for (index, corners) in cast.frame.facets.iter().enumerate() {
        let Some(facet) = Projected::new(corners, cast.frame, cast.rays) else { continue };
        let layer = layer_of(cast, tiles, index as u32);
        let [columns, rows] = facet.rays.map(|[first, last]| first / BIN..=last / BIN);
        for row in rows {
            for column in columns.clone() {
                let hits = hits_of(&facet, [column, row], cast.rays.counts);
                if hits != [0; 2] {
                    let bin = row * tiles.n_across + column;
                    expected.insert((bin, layer, index as u32), hits);
                }
            }
        }
    }
    expected
}

/// Layers that checks ask for: none beside each other, and as many as there can be.
const LAYERS: [u32; 2] = [1, 128];

pub(crate) async fn the_lattice_finds_what_each_facet_hits(gpu: &Gpu) -> Checked {
    check_lattice(gpu, &cases_of_kernels()).await
}

pub(crate) async fn check_lattice(gpu: &Gpu, cases: &[Case]) -> Checked {
    on_casts("lattice", cases, async |cast| {
        for layers in LAYERS {
            let tiles = text(gpu.tiles(cast, layers).await)?;
            let mut found = BTreeMap::new();
            let mut ranks = vec![Vec::new(); tiles.offsets.len() - 1];
            for &[facet, bin, rank, low, high] in &tiles.found {
                let layer = layer_of(cast, &tiles, facet);
                let before = found.insert((bin, layer, facet), [low, high]);
                expect(before.is_none(), || format!("facet {facet} is twice in bin {bin}"))?;
                let slot = ranks.get_mut((bin * tiles.n_layers + layer) as usize);
                slot.ok_or_else(|| format!("bin {bin}, layer {layer}"))?.push(rank);
            }
            let expected = expected_hits(cast, &tiles);
            expect(found == expected, || format!("{layers} layers: {found:x?}, expected {expected:x?}"))?;
            for (ranks, ends) in ranks.iter_mut().zip(tiles.offsets.windows(2)) {
                ranks.sort_unstable();
                let is_counted = ranks.iter().copied().eq(0..ends[1] - ends[0]);
                expect(is_counted, || format!("ranks {ranks:?} of tiles {ends:?}"))?;
            }
        }
        Ok(())
    })
    .await
}

/// The eight words of a tile, by the definition's numbers; None where a step is nearly too steep for them.
fn expected_tile(cast: &Cast, tiles: &Tiles, found: [u32; 5]) -> Option<[u32; 8]> {
    let [index, bin, _, low, high] = found;
    let Cast { frame, rays, .. } = *cast;
    let f = frame.fraction_bits;
    let facet = Projected::new(&frame.facets[index as usize], frame, rays)?;
    let first = [bin % tiles.n_across * BIN, bin / tiles.n_across * BIN];
    let [di, dj] = [0, 1].map(|side| i128::from(first[side]) - i128::from(facet.rays[side][0]));
    let [slope_i, slope_j] = facet.slope.map(i128::from);
    let area = i128::from(facet.area);
    let height = facet.height + ((slope_i * di + slope_j * dj) << f);
    let on_unit = height & ((1 << f) - 1) == 0;
    let tie = u32::from(facet.tie_is_above && on_unit);
    let tag = tie << 9 | u32::from(frame.rank_of_facet(index as usize)) << 1 | u32::from(facet.exits);
    let steepest = slope_i.abs().max(slope_j.abs());
    if steepest > 16_010 * area {
        return Some([low, high, expected_base(cast, index), 0xffff_fff0, 0, 0, 0, 16 << 10 | tag]);
    }
    if steepest > 15_990 * area {
        return None;
    }
    let fixed = |value: i128| ((value << 32).div_euclid(area), (value << 32).rem_euclid(area) == 0);
    let [(z, z_exact), (si, i_exact), (sj, j_exact)] = [height >> f, slope_i, slope_j].map(fixed);
    let margin = if z_exact && i_exact && j_exact { 0 } else { 16 + tie };
    let steps = (si >> 32) as u32 & 0xffff | ((sj >> 32) as u32) << 16;
    Some([low, high, (z >> 32) as u32, z as u32, steps, si as u32, sj as u32, margin << 10 | tag])
}

/// The cell of the lowest corner of a facet.
fn expected_base(cast: &Cast, index: u32) -> u32 {
    let corners = &cast.frame.facets[index as usize];
    corners.iter().map(|corner| corner[cast.rays.axis] >> cast.frame.fraction_bits).min().unwrap_or(0) as u32
}

pub(crate) async fn intersect_makes_the_tiles_of_the_definition(gpu: &Gpu) -> Checked {
    check_intersect(gpu, &cases_of_kernels()).await
}

pub(crate) async fn check_intersect(gpu: &Gpu, cases: &[Case]) -> Checked {
    on_casts("intersect", cases, async |cast| {
        let tiles = text(gpu.tiles(cast, 1).await)?;
        for &found in &tiles.found {
            let [facet, bin, rank, ..] = found;
            let slot = bin * tiles.n_layers + layer_of(cast, &tiles, facet);
            let tile = tiles.tiles.get((tiles.offsets[slot as usize] + rank) as usize);
            let tile = tile.ok_or_else(|| format!("{found:x?} has no tile"))?;
            if let Some(expected) = expected_tile(cast, &tiles, found) {
                expect(*tile == expected, || format!("{found:x?} became {tile:x?}, expected {expected:x?}"))?;
            }
        }
        expect(tiles.found.len() == tiles.tiles.len(), || "fewer tiles than were found".into())
    })
    .await
}

pub(crate) async fn map_gives_the_definitions_columns(gpu: &Gpu) -> Checked {
    check_map(gpu, &cases_of_kernels()).await
}

/// Random stacks that are tried; a browser is slower.
const N_STACKS: u64 = if cfg!(target_arch = "wasm32") { 40 } else { 500 };

/// Rays along z, as the kernels choose and with all rows deep; some ray has thousands of crossings.
pub(crate) async fn stacks_with_thousands_of_crossings_agree_with_the_definition(gpu: &Gpu) -> Checked {
    let cases: Vec<Case> = (0..N_STACKS).map(stack).collect();
    let most = RefCell::new(0);
    let n = on_cases("all kernels", &cases, async |case| {
        let frame = frame(case);
        let rays = Rays::new(2, case.lines.dims());
        let cast = Cast { frame: &frame, rays: &rays, rule: case.rule };
        for deep in [false, true] {
            let forced = Forced { deep, ..Forced::default() };
            same_columns(gpu, &cast, &Options { forced, ..Options::default() }).await?;
        }
        let of_ray = cpu_columns(&cast).n_crossings() / rays.n_rays();
        most.replace_with(|&mut most| of_ray.max(most));
        Ok(())
    })
    .await?;
    expect(most.take() > 3000, || "no ray has thousands of crossings".into())?;
    Ok(n)
}

/// Cases with many crossings a ray, far enough from each other for 128 layers.
const LAYERED: [&str; 4] =
    ["many-crossings", "plates-200-1-1-parity", "plates-200-1-3-parity", "plates-200-1-3-nonzero"];

pub(crate) async fn check_map(gpu: &Gpu, cases: &[Case]) -> Checked {
    // with layers no row of these has too many crossings at a time, and the deep kernels must not hide what is wrong
    let layered: Vec<Case> = cases.iter().filter(|case| LAYERED.contains(&case.name.as_str())).cloned().collect();
    on_casts("map", &layered, async |cast| {
        let forced = Forced { layers: Some(128), ..Forced::default() };
        let usage = same_columns(gpu, cast, &Options { forced, ..Options::default() }).await?;
        expect(usage.deep == 0, || format!("{} rows are deep", usage.deep))
    })
    .await?;
    on_casts("map", cases, async |cast| {
        for layers in [None, Some(1), Some(128)] {
            let forced = Forced { layers, ..Forced::default() };
            same_columns(gpu, cast, &Options { forced, ..Options::default() }).await?;
        }
        Ok(())
    })
    .await
}

pub(crate) async fn intersect_deep_finds_every_crossing(gpu: &Gpu) -> Checked {
    check_intersect_deep(gpu, &cases_of_kernels()).await
}

/// The crossings of each ray, in order, each with its facet.
fn rays(crossings: &Crossings) -> Vec<Vec<[u32; 2]>> {
    (0..crossings.offsets.len() - 1).map(|ray| crossings.of_ray(ray)).collect()
}

pub(crate) async fn check_intersect_deep(gpu: &Gpu, cases: &[Case]) -> Checked {
    on_casts("intersect_deep", cases, async |cast| same_crossings(gpu, cast).await).await
}

pub(crate) async fn intersect_graded_finds_every_crossing(gpu: &Gpu) -> Checked {
    let small: Vec<Case> = cases().into_iter().filter(|case| case.n_facets() <= 2_000).collect();
    check_intersect_graded(gpu, &small).await
}

/// A case on some of its lines, which are lists then.
fn on_lists(case: &Case) -> Case {
    let lines = thinned(&case.lines, &mut Random::new(case.n_facets() as u64)).as_lists();
    Case { lines, ..case.clone() }
}

/// Crossings and columns where the places of rays and centres come from tables: on some of the lines of each case.
pub(crate) async fn check_intersect_graded(gpu: &Gpu, cases: &[Case]) -> Checked {
    let listed: Vec<Case> = cases.iter().map(on_lists).collect();
    on_casts("intersect_graded", &listed, async |cast| {
        expect(cast.frame.is_graded(), || "equal cells".into())?;
        same_crossings(gpu, cast).await?;
        same_columns(gpu, cast, &Options::default()).await.map(|_| ())
    })
    .await
}

async fn same_crossings(gpu: &Gpu, cast: &Cast<'_>) -> Result<(), String> {
    let lattice = lattice(cast.frame, cast.rays, [BIN, 1], 0..cast.rays.counts[1]);
    let rows = (0..cast.rays.counts[1]).map(|row| crossings(cast.frame, cast.rays, &lattice, row, true));
    let expected: Vec<Vec<[u32; 2]>> = rows.flat_map(|of_row| rays(&of_row)).collect();
    let third = cast.frame.facets.len() / 3 + 1;
    for (rows_per_band, facets_of_batch) in [(None, None), (Some(21), Some(third))] {
        let with_facets = facets_of_batch.is_some();
        let forced = Forced { facets_of_batch, ..Forced::default() };
        let options = Options { rows_per_band, forced, ..Options::default() };
        let (mut found, mut usage) = (Vec::new(), Usage::default());
        let take = &mut |more: Vec<Crossings>| found.extend(more.iter().flat_map(rays));
        let (asked, all) = ((&options, with_facets), 0..cast.rays.counts[1]);
        text(gpu.crossings(cast, asked, &Control::default(), all, &mut usage, take).await)?;
        let same = expected
            .iter()
            .flatten()
            .zip(found.iter().flatten())
            .all(|(one, other)| one[0] == other[0] && (!with_facets || one[1] == other[1]));
        let numbers = |rays: &[Vec<[u32; 2]>]| rays.iter().map(Vec::len).collect::<Vec<_>>();
        expect(usage.left == 0, || format!("the CPU casts {} rays", usage.left))?;
        expect(same && numbers(&found) == numbers(&expected), || format!("{found:x?}, expected {expected:x?}"))?;
    }
    Ok(())
}

pub(crate) async fn map_deep_gives_the_definitions_columns(gpu: &Gpu) -> Checked {
    check_map_deep(gpu, &cases_of_kernels()).await
}

/// All rows are deep. The CPU casts what is left; so closed surfaces with at most 8192 crossings a ray must leave nothing.
pub(crate) async fn check_map_deep(gpu: &Gpu, cases: &[Case]) -> Checked {
    on_casts("map_deep", cases, async |cast| {
        let forced = Forced { deep: true, ..Forced::default() };
        let usage = same_columns(gpu, cast, &Options { forced, ..Options::default() }).await?;
        let columns = cpu_columns(cast);
        let most = 8 * 8192.min(columns.n_crossings());
        if columns.odd_rays() == 0 && columns.n_crossings() <= most.min(8192) {
            expect(usage.left == 0, || format!("{} rays of {} are left", usage.left, cast.rays.n_rays()))?;
        }
        Ok(())
    })
    .await
}

pub(crate) async fn batches_of_facets_change_nothing(gpu: &Gpu) -> Checked {
    let small: Vec<Case> = cases().into_iter().filter(|case| case.n_facets() <= 300).collect();
    on_casts("intersect_deep in batches", &small, async |cast| {
        let forced = Forced { deep: true, facets_of_batch: Some(7), ..Forced::default() };
        same_columns(gpu, cast, &Options { forced, ..Options::default() }).await.map(|_| ())
    })
    .await
}

pub(crate) async fn the_whole_line_gives_the_golden_files(gpu: &Gpu) -> Checked {
    let cases = cases();
    assert_complete(&cases);
    on_cases("all kernels", &cases, async |case| {
        let frame = frame(case);
        let mut along = Vec::new();
        for axis in 0..3 {
            let rays = Rays::new(axis, case.lines.dims());
            let cast = Cast { frame: &frame, rays: &rays, rule: case.rule };
            along.push(text(gpu.columns(&cast, &Control::default()).await)?);
        }
        assert_golden(case, &along.try_into().expect("three axes"));
        Ok(())
    })
    .await
}

pub(crate) async fn bands_of_any_number_of_ray_rows_give_the_same_columns(gpu: &Gpu) -> Checked {
    on_casts("all kernels", &cases_of_kernels(), async |cast| {
        // a band is a trip to the device, up to a tenth of a second in a browser: single rows only where there are few
        let most = |rows| if rows == 1 || cfg!(target_arch = "wasm32") { 12 } else { 30 };
        for rows in [1, 3, 13].into_iter().filter(|&rows| cast.rays.counts[1].div_ceil(rows) <= most(rows)) {
            same_columns(gpu, cast, &Options { rows_per_band: Some(rows), ..Options::default() }).await?;
        }
        Ok(())
    })
    .await
}

pub(crate) async fn a_mesh_goes_on_where_it_was_left(gpu: &Gpu) -> Checked {
    let case = &cases()[0];
    let frame = frame(case);
    let rays = Rays::new(0, case.lines.dims());
    let cast = Cast { frame: &frame, rays: &rays, rule: case.rule };
    let whole = text(gpu.columns(&cast, &Control::default()).await)?;
    let options = Options { rows_per_band: Some(2), ..Options::default() };
    let token = CancelToken::default();
    let stop = token.clone();
    let mut stopping = Control::with_progress(move |_| stop.cancel());
    stopping.cancel = token;
    let mut bands: Vec<Band> = Vec::new();
    let error = gpu.continue_columns(&cast, &options, &stopping, &mut bands).await.unwrap_err();
    assert_eq!((error.code(), bands.len()), ("cancelled", 1));
    text(gpu.continue_columns(&cast, &options, &Control::default(), &mut bands).await)?;
    expect(bands.len() > 1 && Columns::new(rays, bands).unwrap() == whole, || "other columns".into())?;
    Ok(1)
}

pub(crate) async fn expand_gives_the_flags_of_the_host(gpu: &Gpu) -> Checked {
    check_expand(gpu, &cases_of_kernels()).await
}

/// Boxes of each mesh, the whole one among them; fewer in a browser, where each takes messages between processes.
const BOXES: usize = if cfg!(target_arch = "wasm32") { 2 } else { 4 };

pub(crate) async fn check_expand(gpu: &Gpu, cases: &[Case]) -> Checked {
    on_casts("expand", cases, async |cast| {
        let dims = cpu_columns(cast).dims();
        let lines = Lines::new([0.0; 3], [1.0; 3], dims).expect("lines of the case");
        let mesh = text(Mesh::new(lines, cpu_columns(cast), vec![], None))?;
        let mut random = Random::new(u64::from(dims[0] + dims[1] + dims[2]));
        for index in 0..BOXES {
            let cells = dims.map(|n| {
                let [one, other] = [0, 1].map(|_| random.below(n.into()) as u32);
                if index == 0 { 0..n } else { one.min(other)..one.max(other) + 1 }
            });
            for (form, expected) in [(Cells::Bytes, mesh.box_flags(&cells)), (Cells::Bits, mesh.box_bits(&cells))] {
                let mut expected = text(expected)?;
                expected.resize(expected.len().next_multiple_of(4), 0);
                let found = text(gpu.expanded(&mesh, &cells, form).await)?;
                expect(found == expected, || format!("{form:?} of {cells:?} of {dims:?}"))?;
            }
        }
        Ok(())
    })
    .await
}

pub(crate) async fn order_gives_the_runs_of_the_host(gpu: &Gpu) -> Checked {
    check_order(gpu, &cases_of_kernels()).await
}

/// Runs that stay on the device, and are put in order there: of rows that `map` has done in one layer and in many, of deep rows, in bands; and
/// where cells differ in size.
pub(crate) async fn check_order(gpu: &Gpu, cases: &[Case]) -> Checked {
    let deep = Forced { deep: true, ..Forced::default() };
    let layered = Forced { layers: Some(128), ..Forced::default() };
    on_casts("order", cases, async |cast| {
        for (forced, rows_per_band) in [(Forced::default(), None), (layered, Some(13)), (deep, None)] {
            let fits = rows_per_band.is_none_or(|rows| cast.rays.counts[1].div_ceil(rows) <= 12);
            if fits {
                same_runs(gpu, cast, &Options { forced, rows_per_band, ..Options::default() }).await?;
            }
        }
        Ok(())
    })
    .await?;
    let many: Vec<Case> = cases.iter().filter(|case| case.geometries.len() > 1).cloned().collect();
    on_cases("order", &many, async |case| {
        // runs of geometries with the same flag are joined
        let mut frame = frame(case);
        frame.ranks.flag_of_rank.iter_mut().for_each(|flag| *flag = 5 + *flag % 2);
        let rays = Rays::new(1, case.lines.dims());
        same_runs(gpu, &Cast { frame: &frame, rays: &rays, rule: case.rule }, &Options::default()).await
    })
    .await?;
    let small: Vec<Case> = cases.iter().filter(|case| case.n_facets() <= 300).map(on_lists).collect();
    on_casts("order", &small, async |cast| same_runs(gpu, cast, &Options::default()).await).await?;
    Ok(cases.len())
}

async fn same_runs(gpu: &Gpu, cast: &Cast<'_>, options: &Options) -> Result<(), String> {
    let columns = cpu_columns(cast);
    let counts = [columns.n_crossings(), columns.odd_rays()];
    let lines = Lines::new([0.0; 3], [1.0; 3], columns.dims()).expect("lines of the case");
    let mesh = text(Mesh::new(lines, columns, vec![], None))?;
    let expected = text(mesh.box_runs(&mesh.dims().map(|n| 0..n)))?;
    let ends = expected.offsets.windows(2).map(|ends| ends[1] - ends[0]);
    let ordered = gpu.ordered(cast, options).await;
    if ends.max().unwrap_or(0) > 8192 {
        // more than a kernel may go through
        let is_refused = ordered.as_ref().is_err_and(|error| error.code() == "too-many-crossings");
        return expect(is_refused, || format!("{ordered:?}"));
    }
    let (found, found_counts) = text(ordered)?;
    expect(found == expected, || format!("other runs with {options:?}"))?;
    expect(found_counts == counts, || format!("crossings and odd rays: {found_counts:?}, expected {counts:?}"))
}
