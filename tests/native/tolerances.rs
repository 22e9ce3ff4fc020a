//! How far an estimate may be from what is real: one table for all tests, with the reasons.

/// What is estimated, the largest factor between estimate and reality, and why it is not less.
const TOLERANCES: &[(&str, f64, &str)] = &[
    ("crossings", 1.25, "rays at grid points sample an area: the number is exact only on average over all offsets"),
    ("columns", 1.25, "a run a crossing, and crossings are estimated"),
    ("host", 1.25, "facets are exact, columns and lattice follow from crossings"),
    ("device", 1.25, "buffers are rounded up, and follow from crossings and facets of a bin"),
    ("vti", 1.01, "all but the length of the head is exact"),
    ("hxc", 1.25, "bytes a run depend on how far neighbouring rays differ; 2 is usual"),
    ("vti_zlib", 3.0, "a rule of thumb: what zlib makes of flags depends on the shape"),
    ("hxc_zlib", 3.0, "the same"),
];

/// Says that an estimate is too far from what is real, if it is.
pub(crate) fn far_off(name: &str, estimated: u64, real: u64) -> Option<String> {
    let (_, factor, _) = TOLERANCES.iter().find(|(known, ..)| *known == name).expect("it is in the table");
    let ratio = estimated as f64 / real as f64;
    let is_near = (1.0 / factor..=*factor).contains(&ratio);
    (!is_near).then(|| format!("{name}: {estimated} estimated, {real} real, {ratio:.2}"))
}

#[test]
fn estimates_that_are_too_far_off_are_found() {
    for (name, factor, why) in TOLERANCES {
        assert!(!why.is_empty());
        let real = 1_000_000;
        for (share, is_far) in [(1.0, false), (0.999 * factor, false), (1.001 * factor, true), (0.999 / factor, true)] {
            assert_eq!(far_off(name, (share * real as f64) as u64, real).is_some(), is_far, "{name}, {share}");
        }
    }
}
