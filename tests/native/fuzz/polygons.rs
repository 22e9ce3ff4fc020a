//! OBJ, OFF and PLY: files of polygons, as text and as bytes.

use super::harness::Target;
use super::stl::check_within;

/// Bytes that a reader may hold for each of the file: a polygon of PLY has 36 for each index of one byte, three times that while the
/// list grows and the old one is copied, and the file itself is held.
const BYTES: u64 = 116;

const WORDS: &[&str] = &[
    "v 0 0 0\n",
    "v 1 2 -3e1\n",
    "f 1 2 3\n",
    "f 1 2 3 4\n",
    "f -1 -2 -3\n",
    "f 1/2/3 2//1 3\n",
    "g a\n",
    "o b\n",
    "\\\n",
    "#",
    "OFF\n",
    "COFF",
    "BINARY",
    "4 4 6\n",
    "3 0 1 2\n",
    "ply\n",
    "format ascii 1.0\n",
    "format binary_little_endian 1.0\n",
    "format binary_big_endian 1.0\n",
    "element vertex 3\n",
    "element face 4000000000\n",
    "property float x\n",
    "property double y\n",
    "property list uchar int vertex_indices\n",
    "property list uint uchar vertex_index\n",
    "end_header\n",
    "\n",
    "\r\n",
    "nan",
    "1e39",
    "\u{1b}[2J",
    "4294967296",
];

#[test]
fn files_of_polygons() {
    let target = Target { name: "polygons", fixtures: &[], dictionary: WORDS, max_bytes: 4 << 10, executions: 30_000 };
    target.fuzz(|_, _| (), |bytes| check_within(bytes, BYTES));
}
