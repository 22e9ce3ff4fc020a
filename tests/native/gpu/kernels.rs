//! The checks of `kernel_checks` on a native device.
//!
//! The kernels run on the adapter that the system prefers or the one named by `HEXCAST_TEST_ADAPTER` (a part of its name).

use std::sync::OnceLock;

use hexcast::gpu::Gpu;

use crate::kernel_checks::{self, every_check};

/// The device, opened once.
pub(crate) fn gpu() -> &'static Gpu {
    static GPU: OnceLock<Gpu> = OnceLock::new();
    GPU.get_or_init(|| {
        let wanted = std::env::var("HEXCAST_TEST_ADAPTER").ok();
        let gpu = pollster::block_on(Gpu::open(wanted.as_deref())).unwrap_or_else(|error| {
            panic!("{error}: install a Vulkan driver such as lavapipe, or leave out the tests of it with --skip gpu")
        });
        println!("adapter: {} ({}, {})", gpu.facts.name, gpu.facts.driver, gpu.facts.api);
        gpu
    })
}

macro_rules! native_test {
    ($name:ident) => {
        #[test]
        fn $name() {
            let gpu = gpu();
            let n_cases = pollster::block_on(kernel_checks::$name(gpu)).unwrap_or_else(|what| panic!("{what}"));
            println!("{n_cases} cases on {}", gpu.facts.name);
        }
    };
}
every_check!(native_test);
