//! The checks of `kernel_checks` on a native device.
//!
//! The kernels run on the adapter that the system prefers or the one named by `HEXCAST_TEST_ADAPTER` (a part of its name).
//! No adapter is a failure, unless `HEXCAST_TEST_WITHOUT_GPU=1` says that the machine is known to have none.

use std::sync::OnceLock;

use hexcast::gpu::Gpu;

use super::kernel_checks::{self, every_check};

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

macro_rules! native_test {
    ($name:ident) => {
        #[test]
        fn $name() {
            let Some(gpu) = gpu() else { return };
            let n_cases = pollster::block_on(kernel_checks::$name(gpu)).unwrap_or_else(|what| panic!("{what}"));
            println!("{n_cases} cases on {}", gpu.facts.name);
        }
    };
}
every_check!(native_test);
