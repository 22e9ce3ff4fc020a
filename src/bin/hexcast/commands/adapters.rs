//! `hexcast adapters`: which GPUs there are.

use hexcast::Result;
use hexcast::gpu::{AdapterFacts, AdapterKind, adapters};
use indicatif::BinaryBytes;

/// List the GPU adapters of this machine, for --adapter
#[derive(clap::Args)]
#[command(after_help = "Example:\n    hexcast adapters --json")]
pub(crate) struct Arguments {
    /// Print a JSON list
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let adapters = pollster::block_on(adapters());
    if arguments.json {
        // a list of strings and numbers always has a JSON form
        return crate::screen::terminal::print_exact(&format!(
            "{}\n",
            serde_json::to_string_pretty(&adapters).unwrap_or_default()
        ));
    }
    if adapters.is_empty() {
        return crate::screen::terminal::print("no GPU adapter: `hexcast mesh` uses the CPU\n");
    }
    crate::screen::terminal::print(&adapters.iter().map(in_words).collect::<String>())
}

fn in_words(adapter: &AdapterFacts) -> String {
    let kind = match adapter.kind {
        AdapterKind::Discrete => "graphics card",
        AdapterKind::Integrated => "integrated",
        AdapterKind::Virtual => "virtual",
        AdapterKind::Software => "in software",
        _ => "unknown kind",
    };
    let AdapterFacts { name, driver, api, max_binding_bytes, .. } = adapter;
    format!("{name}: {kind}, {api}, driver {driver}, buffers of up to {}\n", BinaryBytes(*max_binding_bytes))
}
