//! Disables Mesa's Vulkan layer that selects a default device: it asks Wayland for one, and prints errors where no session
//! runs.

use std::env::{args_os, current_exe, var_os};
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::Command;

/// The variable that disables the layer.
const DISABLE: &str = "NODEVICE_SELECT";
/// Variables by which a user selects a device through the layer.
const SELECT: [&str; 2] = ["MESA_VK_DEVICE_SELECT", "DRI_PRIME"];

/// Disables the layer where no session runs, unless the user has a use for it. The Vulkan loader reads the variable from the
/// environment, which a program can set for a new program only: this one replaces itself. Where that fails, it goes on.
pub(crate) fn disable_without_session() {
    let has_session = var_os("XDG_RUNTIME_DIR").is_some_and(|folder| Path::new(&folder).is_absolute());
    if has_session || SELECT.iter().chain([&DISABLE]).any(|name| var_os(name).is_some()) {
        return;
    }
    let mut arguments = args_os();
    if let (Ok(program), Some(name)) = (current_exe(), arguments.next()) {
        let _ = Command::new(program).arg0(name).args(arguments).env(DISABLE, "1").exec();
    }
}
