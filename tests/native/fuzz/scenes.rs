//! GLB and 3MF: files that place meshes.

use super::harness::Target;
use super::stl::check_within;

/// Bytes that a reader may hold for each of the file: an accessor of one byte an index has 36 for it, three times that while the list grows;
/// a file of a 3MF is up to 1032 times as long as packed, and its elements are longer than what is kept of them.
const BYTES: u64 = 40_000;

const WORDS: &[&str] = &[
    "glTF",
    "JSON",
    "BIN\0",
    "\"mesh\":0",
    "\"children\":[0]",
    "\"nodes\":[0,1]",
    "\"matrix\":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]",
    "\"count\":4294967295",
    "\"count\":0",
    "\"byteStride\":4",
    "\"byteOffset\":18446744073709551615",
    "\"mode\":5",
    "\"sparse\":{\"count\":1,\"indices\":{\"bufferView\":0,\"componentType\":5121},\"values\":{\"bufferView\":0}}",
    "5120",
    "5125",
    "VEC3",
    "SCALAR",
    "PK\u{3}\u{4}",
    "PK\u{1}\u{2}",
    "PK\u{5}\u{6}",
    "3D/3dmodel.model",
    "_rels/.rels",
    "<object id='1'>",
    "<item objectid='1'/>",
    "<component objectid='1'/>",
    "unit='inch'",
    "requiredextensions='p'",
    "transform='1 0 0 0 1 0 0 0 1 0 0 0'",
    "&amp;",
    "&#27;",
    "1e39",
    "nan",
];

#[test]
fn files_of_scenes() {
    let target = Target { name: "scenes", fixtures: &[], dictionary: WORDS, max_bytes: 4 << 10, executions: 30_000 };
    target.fuzz(|_, _| (), |bytes| check_within(bytes, BYTES));
}
