//! What the kernels need of a device. It is less than WebGPU's default limits, and no feature.

use wgpu::Limits;

use hexcast_core::base::error::{Error, Result};

/// What kernels need of a device: the name of a limit, what it is there, and what is needed.
fn needs(limits: &Limits) -> [(&'static str, u64, u64); 10] {
    [
        ("max_bindings_per_bind_group", limits.max_bindings_per_bind_group.into(), 9),
        ("max_storage_buffers_per_shader_stage", limits.max_storage_buffers_per_shader_stage.into(), 8),
        ("max_uniform_buffers_per_shader_stage", limits.max_uniform_buffers_per_shader_stage.into(), 2),
        ("max_uniform_buffer_binding_size", limits.max_uniform_buffer_binding_size, 512),
        ("max_compute_workgroup_storage_size", limits.max_compute_workgroup_storage_size.into(), 8464),
        ("max_compute_invocations_per_workgroup", limits.max_compute_invocations_per_workgroup.into(), 256),
        ("max_compute_workgroup_size_x", limits.max_compute_workgroup_size_x.into(), 256),
        ("max_compute_workgroups_per_dimension", limits.max_compute_workgroups_per_dimension.into(), 65_535),
        ("max_storage_buffer_binding_size", limits.max_storage_buffer_binding_size, 1 << 20),
        ("max_buffer_size", limits.max_buffer_size, 1 << 20),
    ]
}

/// Refuses a device whose limits are too small for the kernels.
///
/// # Errors
/// `device-failed`: with each limit that is, what it is and what is needed.
pub(super) fn check_limits(limits: &Limits) -> Result<()> {
    let few = needs(limits).into_iter().filter(|(_, has, needed)| has < needed);
    let few: Vec<String> = few.map(|(name, has, needed)| format!("{name} is {has}, and {needed} is needed")).collect();
    if few.is_empty() {
        return Ok(());
    }
    let message = format!("the limits of this device are too small to mesh on it: {}", few.join("; "));
    let hint = "request the device with these limits at least (requiredLimits; in Rust required_limits, which \
                gpu::device_limits makes of an adapter); no features are needed";
    Err(Error::new("device-failed", message, hint))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::kernel_texts;

    #[test]
    fn the_limits_are_those_of_the_kernels() {
        let most = |of: fn(&naga::Module) -> u64| {
            let modules = kernel_texts().into_iter().map(|kernel| naga::front::wgsl::parse_str(&kernel.text).unwrap());
            modules.map(|module| of(&module)).max().unwrap()
        };
        let n_storage = most(|module| {
            module
                .global_variables
                .iter()
                .filter(|(_, g)| matches!(g.space, naga::AddressSpace::Storage { .. }))
                .count() as u64
        });
        let n_uniform = most(|module| {
            module.global_variables.iter().filter(|(_, g)| g.space == naga::AddressSpace::Uniform).count() as u64
        });
        let threads = most(|module| u64::from(module.entry_points[0].workgroup_size[0]));
        let workgroup_bytes = most(|module| {
            let of = module.global_variables.iter().filter(|(_, g)| g.space == naga::AddressSpace::WorkGroup);
            of.map(|(_, g)| u64::from(module.types[g.ty].inner.size(module.to_ctx())).next_multiple_of(16)).sum()
        });
        let uniform_bytes = most(|module| {
            let of = module.global_variables.iter().filter(|(_, g)| g.space == naga::AddressSpace::Uniform);
            of.map(|(_, g)| u64::from(module.types[g.ty].inner.size(module.to_ctx()))).max().unwrap_or(0)
        });
        let found = [
            ("max_storage_buffers_per_shader_stage", n_storage),
            ("max_uniform_buffers_per_shader_stage", n_uniform),
            ("max_compute_workgroup_size_x", threads),
            ("max_compute_workgroup_storage_size", workgroup_bytes),
            ("max_uniform_buffer_binding_size", uniform_bytes),
        ];
        let needed = needs(&Limits::default());
        for (name, value) in found {
            let (.., needed) = needed.iter().find(|(known, ..)| *known == name).unwrap();
            assert!(*needed == value, "{name}: {needed} are asked for, {value} are used");
        }
        check_limits(&Limits::default()).unwrap();
    }
}
