//! The checks of `kernel_checks` on the browser's WebGPU.

use hexcast::gpu::Gpu;
use js_sys::Date;
use wasm_bindgen_test::{console_log, wasm_bindgen_test};

use super::kernel_checks::{self, every_check};

macro_rules! web_test {
    ($name:ident) => {
        #[wasm_bindgen_test]
        async fn $name() {
            let gpu = Gpu::open(None).await.expect("an adapter");
            let start = Date::now();
            let n_cases = kernel_checks::$name(&gpu).await.unwrap_or_else(|what| panic!("{what}"));
            console_log!("{n_cases} cases on the browser's GPU in {:.1} s", (Date::now() - start) / 1e3);
        }
    };
}
every_check!(web_test);
