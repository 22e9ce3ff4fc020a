//! STL: the parsers of text and of records, and the choice between them by the first bytes.

use hexcast::Result;
use hexcast::read::{Contents, Format, Reader, read_bytes};

use super::harness::Target;
use super::mutate::Random;
use super::{MAX_MESSAGE, assert_error_is_good, kind, measured};

/// Bytes that a reader may hold for each of the file, and besides: 36 a facet, of which a binary file takes 50 and the shortest
/// text more, twice while a list grows and the old one is copied; names whose bytes are no UTF-8, three for each; messages.
const BYTES: [u64; 2] = [6, 16 << 10];

const WORDS: &[&str] = &[
    "solid",
    "endsolid",
    "facet normal",
    "outer loop",
    "vertex",
    "endloop",
    "endfacet",
    "solid a\n",
    "endsolid\n",
    "facet normal 0 0 1\n",
    "outer loop\n",
    "vertex 1 2 3\n",
    "endloop\n",
    "endfacet\n",
    "\n",
    "\r",
    "\r\n",
    "\t",
    " ",
    "\u{feff}",
    "\0",
    "\u{1a}",
    "\u{b}",
    "nan",
    "-inf",
    "1e39",
    "-1e-46",
    "1,5",
    "0x10",
    "1.#QNAN",
    "\u{1b}[2J",
    "é",
    "\u{85}",
    "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n",
    "COLOR=",
];

fn in_slices(bytes: &[u8], mut size: impl FnMut() -> usize) -> Result<Contents> {
    let mut reader = Reader::new(bytes.len() as u64);
    let mut rest = bytes;
    while !rest.is_empty() {
        let (slice, behind) = rest.split_at(size().clamp(1, rest.len()));
        reader.push(slice)?;
        rest = behind;
    }
    reader.finish()
}

/// The facets of a file, as a binary one.
fn rewritten(contents: &Contents) -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes.extend((contents.n_facets as u32).to_le_bytes());
    for facet in contents.solids.iter().flat_map(|solid| solid.facets.slice().iter()) {
        let numbers = [0.0; 3].iter().chain(facet.as_flattened());
        numbers.for_each(|number: &f32| bytes.extend(number.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

fn check(bytes: &[u8]) -> String {
    check_within(bytes, BYTES[0])
}

/// Checks a file of which a reader may hold so many bytes for each of its own.
pub(super) fn check_within(bytes: &[u8], per_byte: u64) -> String {
    let n_bytes = bytes.len() as u64;
    let (whole, allocated) = measured(|| read_bytes(bytes));
    // what is packed by gzip is up to 1032 times as long, and is unpacked by the megabyte
    let [times, more] = if bytes.starts_with(b"\x1f\x8b") { [1032, 4 << 20] } else { [1, 0] };
    assert!(allocated <= times * per_byte * n_bytes + BYTES[1] + more, "{allocated} bytes of memory for {n_bytes}");
    let mut random = Random::new(n_bytes);
    for size in [1, 2, 49, 1000] {
        assert_eq!(in_slices(bytes, || size), whole, "slices of {size}");
    }
    assert_eq!(in_slices(bytes, || random.below(200)), whole, "slices of any size");
    let contents = match whole {
        Ok(contents) => contents,
        Err(error) => {
            assert_error_is_good(&error, MAX_MESSAGE, false);
            return kind(&error);
        }
    };
    let n_facets: usize = contents.solids.iter().map(|solid| solid.facets.len()).sum();
    assert!(n_facets > 0 && n_facets as u64 == contents.n_facets && contents.n_bytes == n_bytes);
    for solid in &contents.solids {
        assert!(!solid.facets.is_empty());
        assert!(solid.facets.slice().as_flattened().as_flattened().iter().all(|number| number.is_finite()));
    }
    assert!(
        [contents.wrong_normals, contents.zero_normals, contents.zero_area].iter().all(|n| *n <= contents.n_facets)
    );
    assert!(contents.warnings.len() <= 17);
    for warning in &contents.warnings {
        assert!(warning.chars().count() <= MAX_MESSAGE && !warning.contains(char::is_control), "{warning:?}");
    }
    let again = read_bytes(&rewritten(&contents)).expect("the facets as a binary file");
    assert_eq!((again.format, again.zero_area), (Format::StlBinary, contents.zero_area));
    let facets: Vec<_> = contents.solids.iter().flat_map(|solid| solid.facets.slice().iter().copied()).collect();
    assert_eq!(*again.solids[0].facets.slice(), facets);
    format!(
        "{}: {} solids, {} facets, {} warnings, {:?}",
        contents.format.name(),
        contents.solids.len().ilog2(),
        n_facets.ilog2(),
        contents.warnings.len(),
        [contents.wrong_normals, contents.zero_normals, contents.zero_area, u64::from(contents.has_colours)]
            .map(|n| n > 0)
    )
}

/// Makes the count of a binary file, mostly, that of its length.
fn count_repaired(bytes: &mut Vec<u8>, random: &mut Random) {
    if bytes.len() < 84 || random.below(4) == 0 {
        return;
    }
    if random.below(3) > 0 {
        bytes.truncate(84 + (bytes.len() - 84) / 50 * 50);
    }
    let n = (bytes.len() - 84) / 50;
    let n = n.saturating_sub([0, 0, 0, 1, n / 2][random.below(5)]) as u32;
    bytes[80..84].copy_from_slice(&n.to_le_bytes());
}

#[test]
fn ascii_stl() {
    let fixtures = [
        "ascii_empty.stl",
        "ascii_missing_endsolid.stl",
        "ascii_nan_normal.stl",
        "ascii_quad_facet.stl",
        "ascii_zero_normals.stl",
    ];
    let target =
        Target { name: "stl_ascii", fixtures: &fixtures, dictionary: WORDS, max_bytes: 8 << 10, executions: 30_000 };
    target.fuzz(|_, _| (), check);
}

#[test]
fn binary_stl() {
    let fixtures = ["bin_count_too_big.stl", "bin_empty.stl", "bin_header_solid_cube.stl"];
    let target = Target {
        name: "stl_binary",
        fixtures: &fixtures,
        dictionary: &["COLOR=", "solid"],
        max_bytes: 16 << 10,
        executions: 30_000,
    };
    target.fuzz(count_repaired, check);
}

/// Beginnings of files of all kinds: which parser gets them, and what it says.
#[test]
fn any_stl() {
    let fixtures = ["ascii_empty.stl", "bin_empty.stl", "bin_count_too_big.stl", "ascii_missing_endsolid.stl"];
    let target = Target { name: "stl", fixtures: &fixtures, dictionary: WORDS, max_bytes: 3 << 10, executions: 30_000 };
    target.fuzz(|_, _| (), check);
}
