//! `hexcast adapters`: the GPUs of this machine.

use hexcast::error::Result;

use crate::terminal::bytes;

pub(crate) fn run(json: bool) -> Result<()> {
    let adapters = pollster::block_on(hexcast::gpu::adapters());
    if json {
        println!("{}", serde_json::to_string_pretty(&adapters).unwrap_or_default());
        return Ok(());
    }
    if adapters.is_empty() {
        println!("no GPU adapter: meshes are made on the CPU");
    }
    for adapter in adapters {
        let binding = bytes(adapter.max_binding_bytes as f64);
        println!("{} ({}, {:?}): {}; buffers up to {binding}", adapter.name, adapter.api, adapter.kind, adapter.driver);
    }
    Ok(())
}
