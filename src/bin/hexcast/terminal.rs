//! What people see: errors, a progress bar on a terminal, numbers they can read.

use std::io::IsTerminal;
use std::time::Duration;

use hexcast::Error;
use hexcast::control::{CancelToken, Control};
use hexcast::error::Result;
use indicatif::{ProgressBar, ProgressStyle};

/// Prints an error on standard error.
pub(crate) fn show_error(error: &Error) {
    eprintln!("error[{}]: {error}", error.code());
    if !error.hint().is_empty() {
        eprintln!("hint: {}", error.hint());
    }
}

/// A control that Ctrl-C cancels.
pub(crate) fn control(bar: &ProgressBar) -> Result<Control> {
    let token = CancelToken::default();
    let switch = token.clone();
    ctrlc::set_handler(move || switch.cancel())
        .map_err(|error| Error::io("listening for Ctrl-C", std::io::Error::other(error)))?;
    let bar = bar.clone();
    let mut control = Control::with_progress(move |at| {
        bar.set_length(at.n_rays);
        bar.set_position(at.rays_done);
    });
    control.cancel = token;
    Ok(control)
}

/// A progress bar on a terminal, nothing elsewhere.
pub(crate) fn bar(quiet: bool) -> ProgressBar {
    if quiet || !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new_spinner();
    bar.enable_steady_tick(Duration::from_millis(100));
    bar
}

/// Shows what is being done, with a bar where the amount is known.
pub(crate) fn phase(bar: &ProgressBar, what: &str, has_length: bool) {
    let template = if has_length { "{msg:8} {wide_bar} {percent}% {eta} left" } else { "{spinner} {msg}" };
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style);
    }
    bar.set_message(what.to_string());
}

/// A whole number with thin groups: 12 345 678.
pub(crate) fn grouped(n: u64) -> String {
    let digits = n.to_string();
    let mut text = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

/// Bytes in the unit that fits: 12.3 MB.
pub(crate) fn bytes(n: f64) -> String {
    let units = ["B", "kB", "MB", "GB", "TB", "PB"];
    let mut value = n;
    let mut unit = 0;
    while value >= 1000.0 && unit + 1 < units.len() {
        value /= 1000.0;
        unit += 1;
    }
    if unit == 0 { format!("{value:.0} B") } else { format!("{value:.1} {}", units[unit]) }
}

/// Seconds as people say them.
pub(crate) fn seconds(s: f64) -> String {
    if s < 1.0 { format!("{:.0} ms", s * 1e3) } else { format!("{s:.2} s") }
}

/// Three numbers in a row.
pub(crate) fn three<T: std::fmt::Display>(numbers: [T; 3], between: &str) -> String {
    numbers.map(|number| number.to_string()).join(between)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_readable() {
        assert_eq!([grouped(0), grouped(999), grouped(1000), grouped(1234567)], ["0", "999", "1 000", "1 234 567"]);
        assert_eq!([bytes(12.0), bytes(999.0), bytes(1234.0), bytes(2.5e9)], ["12 B", "999 B", "1.2 kB", "2.5 GB"]);
        assert_eq!([seconds(0.0123), seconds(12.345)], ["12 ms", "12.35 s"]);
    }
}
