//! The fractions of cells that surfaces cut, as `.npz`. `docs/fractions.md` describes it.

use std::io;

use crate::write::Compress;
use crate::write::archive::{Array, write_named};
use hexcast_core::base::error::Result;
use hexcast_derived::fractions::{CutSurface, Fraction, Fractions, Part};

/// Writes a NumPy archive of the arrays `cell`, `flag` and `fraction`, an entry for each fraction, and `dims`; `faces`, `edges`, `centroid`, `face_centroid`
/// and those of the surfaces where they were asked for. Returns the number of bytes.
///
/// # Errors
/// `io` where `out` fails.
pub fn write_fractions(fractions: &Fractions, compress: Compress, out: &mut dyn io::Write) -> Result<u64> {
    write_named(&arrays(fractions), "the fractions", compress, out)
}

/// The arrays of the archive.
pub fn arrays(of: &Fractions) -> Vec<Array<'_>> {
    let fraction = |named, put| Array::of_parts(named, &of.parts, |part: &Part| &part.fractions, put);
    let surface = |named, put| Array::of_parts(named, &of.parts, |part: &Part| &part.surfaces, put);
    let mut arrays = vec![
        Array::of_list(("dims", "<u4"), &of.dims, |n, out| out.extend(n.to_le_bytes())),
        Array::of_list(("origin", "<i4"), &of.origin, |n, out| out.extend(n.to_le_bytes())),
        fraction(("cell", "<u8"), |one: &Fraction, out: &mut Vec<u8>| out.extend(one.cell.to_le_bytes())),
        fraction(("flag", "|u1"), |one, out| out.push(one.flag)),
        fraction(("fraction", "<f4"), |one, out| out.extend(one.fraction.to_le_bytes())),
    ];
    let parts = &of.parts;
    if of.has_faces {
        let faces = Array::of_parts(("faces", "<f4"), parts, |part: &Part| &part.faces, |faces, out| put(faces, out));
        arrays.push(faces.with_rows(6));
    }
    if of.has_edges {
        let edges = Array::of_parts(("edges", "<f4"), parts, |part: &Part| &part.edges, |edges, out| put(edges, out));
        arrays.push(edges.with_rows(12));
    }
    if of.has_centroids {
        let centroid =
            Array::of_parts(("centroid", "<f4"), parts, |part: &Part| &part.centroids, |centre, out| put(centre, out));
        arrays.push(centroid.with_rows(3));
    }
    if of.has_centroids && of.has_faces {
        let face_centroid = Array::of_parts(
            ("face_centroid", "<f4"),
            parts,
            |part: &Part| &part.face_centroids,
            |centres, out| put(centres.as_flattened(), out),
        );
        arrays.push(face_centroid.with_rows(6).with_rows(2));
    }
    if of.areas.is_some() {
        arrays.extend([
            surface(("surface_cell", "<u8"), |one: &CutSurface, out: &mut Vec<u8>| out.extend(one.cell.to_le_bytes())),
            surface(("surface_geometry", "<i2"), |one, out| out.extend(one.geometry.to_le_bytes())),
            surface(("surface_area", "<f4"), |one, out| out.extend(one.area.to_le_bytes())),
            surface(("surface_point", "<f4"), |one, out| put(&one.point, out)).with_rows(3),
            surface(("surface_normal", "<f4"), |one, out| put(&one.normal, out)).with_rows(3),
        ]);
    }
    arrays
}

fn put(numbers: &[f32], out: &mut Vec<u8>) {
    numbers.iter().for_each(|number| out.extend(number.to_le_bytes()));
}
