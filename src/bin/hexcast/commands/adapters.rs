//! `hexcast adapters`: which GPUs there are, and what of this machine a report of a fault should say.

use std::fs::read_to_string;

use hexcast::Result;
use hexcast::gpu::{AdapterFacts, AdapterKind, adapters};
use hexcast::machine;
use indicatif::BinaryBytes;

use crate::screen::terminal::{print, print_exact};

/// List the GPU adapters of this machine, for --adapter
#[derive(clap::Args)]
#[command(after_help = "Examples:\n    hexcast adapters --json\n    hexcast adapters --report > machine.txt")]
pub(crate) struct Arguments {
    /// Print a JSON list
    #[arg(long)]
    json: bool,
    /// Print what a report of a fault should say of this machine: versions, system, threads, memory and its limits, GPUs and drivers. It names no file, user or host
    #[arg(long, conflicts_with = "json")]
    report: bool,
}

pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let adapters = pollster::block_on(adapters());
    if arguments.json {
        // a list of strings and numbers always has a JSON form
        return print_exact(&format!("{}\n", serde_json::to_string_pretty(&adapters).unwrap_or_default()));
    }
    if arguments.report {
        return print_exact(&report(&adapters));
    }
    if adapters.is_empty() {
        return print("no GPU adapter: `hexcast mesh` uses the CPU\n");
    }
    print(&adapters.iter().map(in_words).collect::<String>())
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

/// One line for each fact, with a name before it; facts that the system does not say are missing.
fn report(adapters: &[AdapterFacts]) -> String {
    let build = if cfg!(debug_assertions) { "debug build" } else { "release build" };
    let s3 = if cfg!(feature = "s3") { "with S3" } else { "without S3" };
    let (arch, os) = (std::env::consts::ARCH, std::env::consts::OS);
    let mut lines = vec![("hexcast", format!("{}, {build}, {s3}, {arch} {os}", env!("CARGO_PKG_VERSION")))];
    let mut add = |name, fact: Option<String>| lines.extend(fact.map(|fact| (name, fact)));
    add("system", value_in("/etc/os-release", "PRETTY_NAME=").map(|name| name.trim_matches('"').to_string()));
    add("kernel", read_to_string("/proc/sys/kernel/osrelease").ok().map(|text| text.trim().to_string()));
    add(
        "processor",
        value_in("/proc/cpuinfo", "model name").map(|name| name.trim_start_matches([' ', '\t', ':']).into()),
    );
    add("threads", threads());
    add("memory", memory());
    add("limit", machine::group_limit_bytes().map(|bytes| format!("{} by a control group", BinaryBytes(bytes))));
    let text: String = lines.iter().map(|(name, fact)| format!("{name:10}{fact}\n")).collect();
    let gpus: String = adapters.iter().map(|adapter| format!("{:10}{}", "gpu", in_words(adapter))).collect();
    text + if gpus.is_empty() { "gpu       none\n" } else { &gpus }
}

/// Those that the quotas of control groups and the affinity of the process leave, and those of the machine.
fn threads() -> Option<String> {
    let available = std::thread::available_parallelism().ok()?;
    let of_machine = read_to_string("/proc/cpuinfo").ok().map(|text| text.matches("\nprocessor").count() + 1);
    let set =
        std::env::var("RAYON_NUM_THREADS").map(|number| format!(", RAYON_NUM_THREADS={number}")).unwrap_or_default();
    let of = of_machine.map(|number| format!(" of {number}")).unwrap_or_default();
    Some(format!("{available}{of} for this process{set}"))
}

fn memory() -> Option<String> {
    let [total, available] = [machine::total_bytes(), machine::available_bytes()].map(|bytes| bytes.map(BinaryBytes));
    match (total, available) {
        (Some(total), Some(available)) => Some(format!("{total}, of which this process may take {available}")),
        (_, available) => available.map(|available| format!("this process may take {available}")),
    }
}

/// What follows a word at the beginning of a line of a file.
fn value_in(file: &str, word: &str) -> Option<String> {
    read_to_string(file).ok()?.lines().find_map(|line| line.strip_prefix(word)).map(String::from)
}
