//! The comparer of flags: lengths first, then the first cell that differs and how many do.

/// Describes how two arrays of flags over `dims` cells differ, or None if they are equal.
pub(crate) fn difference(expected: &[u8], actual: &[u8], dims: [u32; 3]) -> Option<String> {
    let n_cells = dims.iter().map(|&n| n as usize).product::<usize>();
    if expected.len() != n_cells || actual.len() != n_cells {
        return Some(format!("{n_cells} cells, {} flags expected, {} found", expected.len(), actual.len()));
    }
    let n_differ = (0..n_cells).filter(|&cell| expected[cell] != actual[cell]).count();
    let first = (0..n_cells).find(|&cell| expected[cell] != actual[cell])?;
    let [nx, ny] = [dims[0] as usize, dims[1] as usize];
    let place = [first % nx, first / nx % ny, first / nx / ny];
    let (wanted, found) = (expected[first], actual[first]);
    Some(format!("{n_differ} of {n_cells} cells differ, first {place:?}: flag {wanted} expected, {found} found"))
}

/// Panics with the label and the difference if there is one.
#[track_caller]
pub(crate) fn assert_same(label: &str, expected: &[u8], actual: &[u8], dims: [u32; 3]) {
    if let Some(difference) = difference(expected, actual, dims) {
        panic!("{label}: {difference}");
    }
}

#[test]
fn the_comparer_accepts_equal_flags() {
    assert_eq!(difference(&[1, 2, 3, 4], &[1, 2, 3, 4], [2, 1, 2]), None);
}

#[test]
fn the_comparer_finds_one_flag_of_many() {
    let found = difference(
        &[0; 24],
        &{
            let mut f = [0; 24];
            f[23] = 1;
            f
        },
        [2, 3, 4],
    )
    .unwrap();
    assert_eq!(found, "1 of 24 cells differ, first [1, 2, 3]: flag 0 expected, 1 found");
}

#[test]
fn the_comparer_finds_missing_cells() {
    assert!(difference(&[0; 8], &[0; 7], [2; 3]).is_some());
    assert!(difference(&[0; 7], &[0; 7], [2; 3]).is_some());
    assert!(difference(&[], &[], [2; 3]).is_some());
}

#[test]
#[should_panic(expected = "cube: 1 of 8 cells differ")]
fn a_wrong_mesh_fails() {
    assert_same("cube", &[1; 8], &[1, 1, 1, 1, 1, 1, 1, 0], [2; 3]);
}
