//! What a broken driver would do, by changing the text of kernels before they are compiled: every change that changes a result is caught
//! by the check that names the kernel; guesses that are off change nothing; and where a device is wrong the cells are right all
//! the same, with a warning that names it.

use std::sync::Arc;

use hexcast::control::Control;
use hexcast::estimate::BandLimit;
use hexcast::geometry::Geometry;
use hexcast::gpu::{Gpu, kernel_texts};
use hexcast::lines::Lines;
use hexcast::mesh::Mesh;
use hexcast::pipeline::Engine;
use hexcast_core::grid::frame::Frame;
use hexcast_core::grid::rays::Rays;
use hexcast_core::stages::cast::Cast;
use hexcast_core::stages::cpu;
use hexcast_core::stages::crossings::Crossings;
use hexcast_core::stages::map::Rule;

use super::kernels;
use crate::cases::{Case, cases};
use crate::kernel_checks::{self, Checked};
use crate::models;

/// Opens the adapter of the kernel tests with one kernel changed, or all; each text must hold the place once at least.
fn open(known: &Gpu, kernel: Option<&'static str>, from: &str, to: &str) -> hexcast::Result<Gpu> {
    let concerned: Vec<_> =
        kernel_texts().into_iter().filter(|text| kernel.is_none_or(|name| name == text.name)).collect();
    assert!(concerned.iter().any(|text| text.text.contains(from)), "{kernel:?} has no {from}");
    let (from, to) = (from.to_string(), to.to_string());
    let edit = move |name: &str, text: String| {
        if kernel.is_none_or(|kernel| kernel == name) { text.replace(&from, &to) } else { text }
    };
    pollster::block_on(Gpu::open_edited(Some(&known.facts.name), Some(Arc::new(edit))))
}

/// A few cases that between them reach every branch of every kernel.
fn some_cases() -> Vec<Case> {
    const NAMES: [&str; 16] = [
        "sphere",
        "terrain-on-rays",
        "roofs",
        "tiny-facets",
        "many-crossings",
        "wide",
        "crowd",
        "priorities-nonzero",
        "overlapping-shells-nonzero",
        "soup-3",
        "crumbs-1",
        "no-lid-z",
        "plates-200-1-3-nonzero",
        "large-and-small",
        "micrometres",
        "open-among-closed",
    ];
    let found: Vec<Case> = cases().into_iter().filter(|case| NAMES.contains(&case.name.as_str())).collect();
    assert_eq!(found.len(), NAMES.len());
    found
}

/// One token of a kernel's text, and what stands in its place.
const MUTATIONS: &[(&str, &str, &str)] = &[
    ("scan_reduce", "sums[block] = partial[0]", "sums[block] = partial[1]"),
    ("scan_reduce", "min(b, 0xffffffffu - a)", "max(b, 0xffffffffu - a)"),
    ("scan_apply", "partial[local - 1u]", "partial[local]"),
    ("scan_apply", "before = bases[block]", "before = 0u"),
    ("scan_apply", "reach *= 2u", "reach *= 4u"),
    ("lattice", "bin * params.n_layers + f.layer], 1u", "bin * params.n_layers + f.layer], 2u"),
    ("lattice", "bin * params.n_layers + f.layer]", "bin * params.n_layers]"),
    ("lattice", "(hits.x | hits.y) != 0u", "(hits.x & hits.y) != 0u"),
    ("lattice", "| rank, hits)", "| rank, hits.yx)"),
    ("lattice", "(bin << RANK_BITS) | rank", "bin << RANK_BITS"),
    ("lattice", "let n_rows = min(", "let n_rows = max("),
    ("lattice", "select(1u, 0u, tie_is_inside)", "select(0u, 1u, tie_is_inside)"),
    ("lattice", "a < 0 || (a == 0 && b < 0)", "a < 0 || (a == 0 && b > 0)"),
    ("lattice", "q += w.b;", "q += w.a;"),
    ("lattice", "(1u << n_inside) - 1u", "0xffu"),
    ("lattice", "index / segments", "index % segments"),
    ("lattice", "vec4<i32>(0, 1, 2, 3)", "vec4<i32>(0, 1, 2, 2)"),
    ("lattice", "w.column * i32(BIN), i32(params.first_row", "w.column * i32(BIN) + 1, i32(params.first_row"),
    ("lattice", "flipped == (params.axis == 1u)", "flipped == (params.axis == 2u)"),
    ("intersect", "flipped == (params.axis == 1u)", "flipped == (params.axis == 2u)"),
    ("intersect", "select(16u + (plane.tag >> 9u), 0u, is_exact)", "select(15u + (plane.tag >> 9u), 0u, is_exact)"),
    ("intersect", "step_j.cells << 16u", "step_j.cells << 15u"),
    ("intersect", "(high.whole << 16u) | low.whole", "(high.whole << 16u) & low.whole"),
    ("intersect", "16000.0 *", "1.0 *"),
    ("intersect", "params.axis == 2u && i_is_level", "params.axis == 1u && i_is_level"),
    ("intersect", "multiply_signed(dz.y, dy.z)", "multiply_signed(dz.z, dy.z)"),
    ("intersect", "select(~q.whole, 0u - q.whole, is_whole)", "select(~q.whole, ~q.whole, is_whole)"),
    ("intersect", "f.z.x - base", "f.z.y - base"),
    ("map", "(1u - params.rule)", "params.rule"),
    ("map", "s.open.low.x ^= select", "s.open.low.x = select"),
    ("map", "cell < params.depth", "cell <= params.depth"),
    ("map", "select(1u, 0u, (h.fraction", "select(0u, 1u, (h.fraction"),
    ("map", "(winner >> 9u)", "(winner >> 10u)"),
    ("map", "opens = is_due & !closes", "opens = is_due & closes"),
    ("map", "cell != next >> 9u", "cell == next >> 9u"),
    ("map", "countOneBits(open) << 27u", "countOneBits(open) << 28u"),
    ("map", "row.n_crossings - row.n_runs", "row.n_crossings"),
    ("map", "step.cells * row", "step.cells"),
    ("map", "events >> vec4<u32>(9u)) < vec4<u32>(until)", "events >> vec4<u32>(9u)) > vec4<u32>(until)"),
    ("map", "cell >= done", "cell > done"),
    ("map", "open & vec4<u32>(0x1ffu)", "open & vec4<u32>(0x001u)"),
    ("map", "written.n_places + u32(is_linked)", "written.n_places"),
    ("map", "max(vec4<u32>(list.low.w, list.high.xyz), v)", "max(vec4<u32>(list.low.z, list.high.xyz), v)"),
    ("map", "select(0u, s.last_is_run, is_open)", "0u"),
    ("intersect_deep", "select(1, 0, centre_is_above)", "select(0, 1, centre_is_above)"),
    ("intersect_deep", "(ray << 27u)", "(ray << 26u)"),
    ("intersect_deep", "left &= left - 1u", "left = 0u"),
    ("intersect_deep", "multiply96(plane.slope_j, i32(row))", "multiply96(plane.slope_i, i32(row))"),
    ("intersect_deep", "i32(params.depth)", "i32(params.depth) - 1"),
    ("intersect_deep", "row * params.n_across", "row"),
    ("intersect_deep", "params.first_facet + facet", "facet"),
    ("intersect_deep", "params.event_capacity + place]", "params.event_capacity]"),
    ("intersect_deep", "params.with_facets == 1u", "params.with_facets == 2u"),
    ("intersect_graded", "select(1, 0, centre_is_above)", "select(0, 1, centre_is_above)"),
    ("intersect_graded", "(high.rest.x << 13u) | low", "high.rest.x << 13u"),
    ("intersect_graded", "float64(high.rest) * 8192.0", "float64(high.rest)"),
    ("intersect_graded", "(high.whole << 13u) | q.whole", "high.whole << 13u"),
    ("intersect_graded", "row_place(first.y + row) - f.y.x", "row_place(first.y) - f.y.x"),
    ("intersect_graded", "ray_place(first.x + ray) - f.x.x", "ray_place(ray) - f.x.x"),
    ("intersect_graded", "params.n_i + params.depth + min(j", "params.n_i + min(j"),
    ("intersect_graded", "min(j, params.end_row - 1u)", "min(j, params.end_row - 2u)"),
    ("intersect_graded", "centres[middle] < place", "centres[middle] <= place"),
    ("intersect_graded", "SEARCH_LOOPS: u32 = 6u", "SEARCH_LOOPS: u32 = 1u"),
    ("intersect_graded", "before + params.first_row, before", "before, before"),
    ("intersect_graded", "high.x + 1", "high.x"),
    ("intersect_graded", "select(vec3<u32>(1u), vec3<u32>(0u), tie_is_inside)", "vec3<u32>(0u)"),
    ("intersect_graded", "(w.b < vec3<i32>(0))", "(w.b > vec3<i32>(0))"),
    ("intersect_graded", "now.a > zero", "now.a < zero"),
    ("intersect_graded", "row_place(j + BIN - 1u)", "row_place(j)"),
    ("intersect_graded", "bits |= is_inside(across[ray], down) << ray", "bits |= is_inside(across[ray], down)"),
    ("intersect_graded", "(1u << min(params.n_i - i, BIN)) - 1u", "0xffu"),
    ("intersect_graded", "select(0u, inside, row < n_rows)", "inside"),
    ("map_deep", "cell < params.depth", "cell <= params.depth"),
    ("map_deep", "other < key", "other <= key"),
    ("map_deep", "i < local)", "i > local + 64u)"),
    ("map_deep", "i < BIN * params.n_ranks", "i < params.n_ranks"),
    ("map_deep", "params.rule == 0u", "params.rule != 0u"),
    ("map_deep", "vec4<u32>(1u, 33u, 65u, 97u)", "vec4<u32>(1u, 33u, 65u, 96u)"),
    ("map_deep", "(bits + 7u) / 8u", "(bits - 1u) / 8u"),
    ("map_deep", "events[to_half + counters[counter]] = event", "events[to_half + counters[counter] + 1u] = event"),
    ("map_deep", "is_last && winner != code", "winner != code"),
    ("map_deep", "sum += counters", "sum = counters"),
    ("expand", "runs[middle] >> 8u <= cell", "runs[middle] >> 8u < cell"),
    ("expand", "at >= slab.skip", "at > slab.skip"),
    ("expand", "&& at < end", "&& at <= end"),
    ("expand", "if low == first", "if low + 1u == first"),
    ("expand", "slab.axis == 1u", "slab.axis == 2u"),
    ("expand", "SEARCH_STEPS: u32 = 19u", "SEARCH_STEPS: u32 = 2u"),
    ("order", "i < lane", "i <= lane"),
    ("order", "var before = places", "var before = 0u"),
    ("order", "first + before + (n - 1u) / 4u", "first + before"),
    ("order", "(*walk).end -= 1u", "(*walk).end -= 0u"),
    ("order", "ray % params.n_i / BIN", "ray / BIN"),
    ("order", "(w.pending & 0xffu) != flag", "true"),
    ("order", "(8u * (code % 4u))", "(8u * (code % 2u))"),
    ("order", "16u * row + 8u", "16u * row + 7u"),
    ("order", "offsets[ray + 1u] - sources.base", "offsets[ray + 1u]"),
    ("order", "(walk.pending & 0xffu) != 0u", "(walk.pending & 0xffu) != 1u"),
    ("order", "& ~LINKED) >> 27u", "& ~LINKED) >> 26u"),
];

/// Runs the check that names a kernel.
fn check(gpu: &Gpu, kernel: &str, cases: &[Case]) -> Checked {
    pollster::block_on(async {
        match kernel {
            "scan_reduce" | "scan_apply" => kernel_checks::scans_sum_all_numbers_before_each(gpu).await,
            "lattice" => kernel_checks::check_lattice(gpu, cases).await,
            "intersect" => kernel_checks::check_intersect(gpu, cases).await,
            "map" => kernel_checks::check_map(gpu, cases).await,
            "intersect_deep" => kernel_checks::check_intersect_deep(gpu, cases).await,
            "intersect_graded" => kernel_checks::check_intersect_graded(gpu, cases).await,
            "map_deep" => kernel_checks::check_map_deep(gpu, cases).await,
            "expand" => kernel_checks::check_expand(gpu, cases).await,
            "order" => kernel_checks::check_order(gpu, cases).await,
            _ => panic!("no check of {kernel}"),
        }
    })
}

/// Changes that change no result: a facet's direction is no matter of the lattice.
const EQUAL: &[&str] = &["lattice: flipped == (params.axis == 1u)"];

#[test]
fn every_mutation_of_a_kernel_is_caught_by_its_check() {
    let known = kernels::gpu();
    let cases = some_cases();
    for kernel in kernel_texts().iter().map(|kernel| kernel.name).filter(|name| *name != "probe") {
        let found = check(known, kernel, &cases);
        assert!(found.is_ok(), "{kernel} as it is: {found:?}");
        assert!(MUTATIONS.iter().any(|(name, ..)| *name == kernel), "no mutation of {kernel}");
    }
    let mut survivors = Vec::new();
    for &(kernel, from, to) in MUTATIONS {
        // one that the probe or the compiler refuses is caught as well
        let caught = match open(known, Some(kernel), from, to) {
            Ok(gpu) => check(&gpu, kernel, &cases).err(),
            Err(error) => Some(format!("{kernel}: {error}")),
        };
        let name = format!("{kernel}: {from}");
        match caught {
            Some(what) => assert!(what.contains(kernel), "{name} was caught by another check: {what}"),
            None if EQUAL.contains(&name.as_str()) => {}
            None => survivors.push(format!("{name} -> {to}")),
        }
    }
    assert!(MUTATIONS.len() >= 40 && survivors.is_empty(), "not caught:\n{}", survivors.join("\n"));
    println!("{} mutations on {}", MUTATIONS.len(), known.facts.name);
}

#[test]
fn runs_that_stay_on_a_wrong_device_are_an_error_or_right() {
    let known = kernels::gpu();
    let geometries = [Geometry::new("ball", 1, models::sphere([0.0; 3], 1.0, 24)).unwrap()];
    let lines = Lines::new([-1.1; 3], [2.2 / 96.0; 3], [96; 3]).unwrap();
    let frame = Frame::new(&geometries, &lines).unwrap();
    let rays = Rays::new(2, lines.dims());
    let cast = Cast { frame: &frame, rays: &rays, rule: Rule::Parity };
    let runs =
        |columns| Mesh::new(lines.clone(), columns, vec![], None).unwrap().box_runs(&[0..96, 0..96, 0..96]).unwrap();
    let expected = runs(cpu::columns(&cast, &Control::default()).unwrap());
    let mut n_refused = 0;
    for &(kernel, from, to) in MUTATIONS.iter().filter(|(kernel, ..)| *kernel != "expand") {
        let Ok(gpu) = open(known, Some(kernel), from, to) else { continue };
        match pollster::block_on(gpu.ordered(&cast, &Default::default())) {
            Ok((found, _)) if found == expected => {}
            // too few rays for a sample: the host, which sees all runs, finds no fault either
            Ok((found, _)) => {
                let columns = pollster::block_on(gpu.columns(&cast, &Control::default()));
                let on_host =
                    runs(columns.unwrap_or_else(|error| panic!("{kernel}: {from} -> {to}: {error} on the host")));
                assert!(kernel != "order" && on_host == found, "{kernel}: {from} -> {to}: wrong runs");
            }
            Err(error) => {
                let is_told = ["device-wrong", "device-failed", "device-lost", "memory"].contains(&error.code());
                assert!(is_told, "{kernel}: {from}: {error}");
                n_refused += 1;
            }
        }
    }
    assert!(n_refused >= 20, "{n_refused} are refused");
}

#[test]
fn guesses_of_quotients_may_be_off() {
    let known = kernels::gpu();
    let faults = [
        ("return value / divisor;", "return value / divisor * (1.0 + 1.0 / 131072.0);"),
        ("return value / divisor;", "return value / divisor * (1.0 - 1.0 / 131072.0);"),
        ("return value / divisor;", "return value / divisor * (1.0 + 1.0 / 65536.0);"),
        (
            "let first = u32(min(guess(size, by), 1073741824.0));",
            "let first = u32(min(guess(size, by), 1073741824.0)) + 1u;",
        ),
        (
            "let first = u32(min(guess(size, by), 1073741824.0));",
            "let first = max(u32(min(guess(size, by), 1073741824.0)), 1u) - 1u;",
        ),
    ];
    let cases = some_cases();
    for (from, to) in &faults {
        let gpu = open(known, None, from, to).expect("it is a device like any other");
        for kernel in ["intersect", "intersect_deep", "intersect_graded"] {
            check(&gpu, kernel, &cases).unwrap_or_else(|what| panic!("{to}: {what}"));
        }
        let golden = pollster::block_on(kernel_checks::the_whole_line_gives_the_golden_files(&gpu));
        golden.unwrap_or_else(|what| panic!("{to}: {what}"));
    }
    // larger errors than the proof allows are caught
    let gpu = open(known, None, faults[0].0, "return value / divisor * 1.01;").expect("it is a device like any other");
    assert!(check(&gpu, "intersect", &cases).is_err());
}

/// A sphere in several bands.
fn ball() -> (Frame, Rays) {
    let geometries = [
        Geometry::new("ball", 3, models::sphere([0.0; 3], 1.0, 24)).unwrap(),
        Geometry::new("shell", 5, models::sphere([0.0, 0.1, 0.0], 0.9, 20)).unwrap(),
    ];
    let lines = Lines::new([-1.1; 3], [2.2 / 130.0, 2.2 / 120.0, 2.2 / 110.0], [130, 120, 110]).expect("lines");
    (Frame::new(&geometries, &lines).expect("frame"), Rays::new(2, lines.dims()))
}

/// The same on lines of which every seventh is left out.
fn graded_ball() -> (Frame, Rays) {
    let geometries = [Geometry::new("ball", 3, models::sphere([0.0; 3], 1.0, 24)).unwrap()];
    let list = (0..160).filter(|line| line % 7 != 3).map(|line| -1.2 + 0.015 * f64::from(line)).collect::<Vec<f64>>();
    let lines = Lines::from_lists([0; 3].map(|_| list.clone())).expect("lines");
    (Frame::new(&geometries, &lines).expect("frame"), Rays::new(2, lines.dims()))
}

#[test]
fn a_device_that_is_wrong_costs_no_cell_and_is_named() {
    let known = kernels::gpu();
    let [equal, graded] = [ball(), graded_ball()];
    let casts = [&equal, &graded].map(|(frame, rays)| Cast { frame, rays, rule: Rule::Parity });
    let expected = casts.map(|cast| cpu::columns(&cast, &Control::default()).expect("columns"));
    let faults = [
        ("drops work", "map", "*tile < end; *tile += 2u", "*tile + 2u < end; *tile += 2u"),
        ("drops chunks", "map", "chunks[chunk] = vec2<u32>(row.place", "chunks[chunk ^ 1u] = vec2<u32>(row.place"),
        ("wrong order", "map", "List(vec4<u32>(key, open.low.xyz)", "List(vec4<u32>(key ^ 2u, open.low.xyz)"),
        ("wrong cell", "map", "vec4<u32>((cell << 8u) | code)", "vec4<u32>(((cell + 1u) << 8u) | code)"),
        ("cells past the end", "map", "vec4<u32>((cell << 8u) | code)", "vec4<u32>(((cell + 4000u) << 8u) | code)"),
        ("unknown geometry", "map", "vec4<u32>((cell << 8u) | code)", "vec4<u32>((cell << 8u) | (code * 77u))"),
        ("huge count", "map", "row.counts);\n", "row.counts | 0x0fu);\n"),
        ("huge place", "map", "vec2<u32>(row.place |", "vec2<u32>(0x7ffffffu |"),
        ("many deep rows", "map", "atomicAdd(&totals.n_deep, 1u)", "atomicAdd(&totals.n_deep, 99999u)"),
        ("garbage", "map", "runs[*place] = words", "runs[*place] = words * 2654435761u"),
        ("garbage in tiles", "intersect", "height.fraction);", "height.fraction * 3u);"),
        ("facets lost", "lattice", "(hits.x | hits.y) != 0u", "hits.x != 0u"),
        ("another place", "intersect_graded", "centres[middle] <", "centres[middle] / 2 <"),
        ("another cell", "intersect_graded", "(cell << 9u)", "((cell ^ 1u) << 9u)"),
        ("crossings lost", "intersect_graded", "left &= left - 1u", "left = 0u"),
    ];
    for (what, kernel, from, to) in faults {
        let index = usize::from(kernel == "intersect_graded");
        let (cast, expected) = (casts[index], &expected[index]);
        let gpu = open(known, Some(kernel), from, to).expect("the probe does not see it");
        let mut engine = Engine::with_gpu(gpu);
        let (columns, used) = pollster::block_on(engine.columns(&cast, &Control::default())).expect(what);
        assert!(columns == *expected, "{what}: other cells");
        let [rays, differing] = used.checked.expect("a GPU has begun");
        if what == "many deep rows" && engine.fallback.is_none() {
            // no row is deep here, so the fault shows nowhere
            continue;
        }
        let why = engine.fallback.clone().unwrap_or_else(|| panic!("{what}: nothing was said"));
        assert!(why.contains(&known.facts.name) && why.contains(&known.facts.driver), "{what}: {why}");
        assert!(rays >= differing && differing > 0 && engine.backend() == "cpu", "{what}: {differing} of {rays}");
    }
}

#[test]
fn wrong_crossings_are_cast_again_by_the_cpu() {
    let known = kernels::gpu();
    let (frame, rays) = ball();
    let cast = Cast { frame: &frame, rays: &rays, rule: Rule::Parity };
    let found = |engine: &mut Engine| {
        let mut all = Vec::new();
        let rays = |crossings: &Crossings| {
            (0..crossings.offsets.len() - 1).map(|ray| crossings.of_ray(ray)).collect::<Vec<_>>()
        };
        let take = &mut |more: Vec<Crossings>| all.extend(more.iter().flat_map(rays));
        let control = Control::default();
        let limits = BandLimit { n_rays: 1 << 12, device_bytes: u64::MAX };
        let used = pollster::block_on(engine.crossings(&cast, true, limits, &control, take)).expect("crossings");
        (all, used.checked)
    };
    let (expected, none) = found(&mut Engine::cpu());
    assert!(none.is_none() && expected.iter().flatten().count() > 10_000);
    let faults = [
        ("another cell", "(cell << 9u)", "((cell ^ 1u) << 9u)"),
        ("a cell past the end", "(cell << 9u)", "((cell + 400u) << 9u)"),
        ("another ray", "(ray << 27u)", "((ray ^ 1u) << 27u)"),
        ("an unknown geometry", "(tag & 0x1ffu)", "(tag | 0x1feu)"),
        ("an unknown facet", "params.first_facet + facet", "99999999u"),
        ("the facet beside it", "params.first_facet + facet", "facet ^ 1u"),
        ("a crossing in place of another", "events[place] =", "events[place / 2u] ="),
        ("crossings lost", "of_row != 0u", "of_row > 1u"),
    ];
    for (what, from, to) in faults {
        let mut engine = Engine::with_gpu(open(known, Some("intersect_deep"), from, to).expect("it can be opened"));
        let (crossings, checked) = found(&mut engine);
        assert!(crossings == expected, "{what}: other crossings");
        let [rays, differing] = checked.expect("a GPU has begun");
        let why = engine.fallback.clone().unwrap_or_else(|| panic!("{what}: nothing was said"));
        assert!(why.contains(&known.facts.name) && rays >= differing && differing > 0, "{what}: {why}");
    }
}

#[test]
fn a_driver_that_fails_the_probe_is_refused() {
    let known = kernels::gpu();
    let faults = [
        ("i < LOOPS; i++", "i < min(LOOPS, 16000u); i++", "loops"),
        ("state * 1664525u", "min(state, 0x7fffffffu) * 1664525u", "wrap around"),
        ("bits << by", "bits << min(by, 30u)", "shifts"),
        ("countOneBits(bits)", "countOneBits(bits >> 1u)", "bit counts"),
        ("f32(2u * local + 3u))", "f32(2u * local + 3u) * 1.00001)", "division"),
        ("atomicAdd(&answers.sum, local + 1u)", "atomicStore(&answers.sum, local + 1u)", "atomic"),
        ("garbage |= zeros[i]", "garbage |= zeros[i] + 1u", "workgroup memory"),
        ("buffer_7[0] = 7u", "buffer_7[0] = 6u", "storage buffers"),
    ];
    for (from, to, check) in faults {
        let error = open(known, Some("probe"), from, to).err().unwrap_or_else(|| panic!("{check} was not asked for"));
        let text = error.to_string();
        assert_eq!(error.code(), "device-wrong", "{text}");
        assert!(text.contains(&known.facts.name) && text.contains(&known.facts.driver), "{text}");
        assert!(text.contains(check) && error.hint().contains("CPU"), "{text}");
    }
}
