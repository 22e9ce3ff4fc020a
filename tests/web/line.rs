//! The line in the browser: the CPU definition in wasm, and the browser's WebGPU held to it.

use hexcast::columns::Columns;
use hexcast::control::Control;
use hexcast::gpu::Gpu;
use hexcast_core::grid::frame::Frame;
use hexcast_core::grid::rays::Rays;
use hexcast_core::stages::cast::Cast;
use hexcast_core::stages::cpu;
use js_sys::{Function, Promise, Reflect};
use wasm_bindgen::{JsCast, JsValue};
use wasm_bindgen_futures::JsFuture;
use wasm_bindgen_test::{console_log, wasm_bindgen_test};

use super::cases::{Case, cases, one, unit_cells};
use super::golden::{assert_complete, assert_golden};
use super::models::cube;

#[wasm_bindgen_test]
fn sines_have_their_fixed_bits() {
    super::angles::assert_fixed_bits();
}

/// A cube of 4 x 4 x 4 cells whose faces go through centres.
fn cube_case() -> Case {
    one("cube", "64 cells, whoever counts", unit_cells([8; 3]), cube([1.5; 3], 4.0))
}

fn cpu_columns(cast: &Cast) -> Columns {
    cpu::columns(cast, &Control::default()).expect("nobody cancels")
}

async fn gpu_columns(gpu: &Gpu, case: &Case, cast: &Cast<'_>) -> Columns {
    let columns = gpu.columns(cast, &Control::default()).await;
    columns.unwrap_or_else(|error| panic!("{}: {error}", case.name))
}

fn frame(case: &Case) -> Frame {
    Frame::new(&case.geometries, &case.lines).unwrap_or_else(|error| panic!("{}: {error}", case.name))
}

fn n_full(columns: &Columns) -> u64 {
    columns.cells_per_flag()[1]
}

#[wasm_bindgen_test]
fn the_cpu_line_fills_a_cube() {
    let case = cube_case();
    let frame = frame(&case);
    for axis in 0..3 {
        let rays = Rays::new(axis, case.lines.dims());
        let columns = cpu_columns(&Cast { frame: &frame, rays: &rays, rule: case.rule });
        assert_eq!((n_full(&columns), columns.odd_rays()), (64, 0), "along {axis}");
    }
}

#[wasm_bindgen_test]
async fn the_browser_has_an_adapter() {
    let get = |object: &JsValue, key: &str| Reflect::get(object, &JsValue::from_str(key)).expect("an object");
    let gpu = get(&get(&js_sys::global(), "navigator"), "gpu");
    assert!(!gpu.is_undefined(), "navigator.gpu is missing: start the browser with WebGPU");
    let request: Function = get(&gpu, "requestAdapter").unchecked_into();
    let promise: Promise = request.call0(&gpu).expect("requestAdapter does not throw").unchecked_into();
    let adapter = JsFuture::from(promise).await.expect("requestAdapter does not reject");
    assert!(!adapter.is_null(), "navigator.gpu has no adapter");
    let info = get(&adapter, "info");
    let text = |key: &str| get(&info, key).as_string().unwrap_or_default();
    console_log!("adapter: {} {} {} (browser)", text("vendor"), text("architecture"), text("description"));
}

#[wasm_bindgen_test]
async fn the_gpu_fills_a_cube() {
    let case = cube_case();
    let frame = frame(&case);
    let rays = Rays::new(2, case.lines.dims());
    let cast = Cast { frame: &frame, rays: &rays, rule: case.rule };
    let gpu = Gpu::open(None).await.expect("an adapter");
    let columns = gpu_columns(&gpu, &case, &cast).await;
    assert_eq!(n_full(&columns), 64);
    assert!(columns == cpu_columns(&cast));
}

#[wasm_bindgen_test]
fn the_cpu_gives_the_golden_files() {
    let cases = cases();
    assert_complete(&cases);
    for case in &cases {
        let frame = frame(case);
        let along = [0, 1, 2].map(|axis| {
            let rays = Rays::new(axis, case.lines.dims());
            cpu_columns(&Cast { frame: &frame, rays: &rays, rule: case.rule })
        });
        assert_golden(case, &along);
    }
    console_log!("{} golden files on the browser's CPU", cases.len());
}
