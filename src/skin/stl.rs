//! Writing a skin as binary STL, in the unit of the mesh.
//!
//! Skin, mesh -> bytes: 80 of header, a 32-bit count, 50 a triangle, little-endian. Equal mesh lines give equal f32, so
//! planes stay planes and the surface has no gaps, although corners lie on the edges of larger triangles (T-junctions).
//! Where a cell is smaller than a f32 resolves at its distance from the origin, lines fall together.

use std::io::Write;

use super::{Skin, SkinPart};
use crate::error::{Error, Result};
use crate::mesh::Mesh;

/// Writes the surface of one flag, or of all, one after the other; where two flags touch, their common faces then are
/// there twice, once from each side. Returns the number of bytes. Flushes at the end.
///
/// # Errors
/// - `job-value` where the skin has no such flag;
/// - `too-many-facets` where the triangles exceed the 32-bit count of the format;
/// - `io` where `out` fails.
pub fn write_stl(skin: &Skin, mesh: &Mesh, flag: Option<u8>, out: &mut dyn Write) -> Result<u64> {
    let parts: Vec<&SkinPart> = skin.parts.iter().filter(|part| flag.is_none_or(|flag| flag == part.flag)).collect();
    if let (Some(flag), true) = (flag, parts.is_empty()) {
        return Err(Error::new("job-value", format!("no cell of the skin has flag {flag}"), "name a flag of the mesh"));
    }
    let n_triangles: u64 = parts.iter().map(|part| 2 * part.n_quads() as u64).sum();
    let count = u32::try_from(n_triangles).map_err(|_| {
        let message = format!("{n_triangles} triangles are more than a binary STL can count");
        Error::new("too-many-facets", message, "write the flags one by one, or a coarser skin")
    })?;
    let failed = |error| Error::io("writing the surface as STL", error);
    // "solid" at the start would make some readers take the file for ASCII
    let mut header = format!("hexcast skin, step {}", skin.step).into_bytes();
    header.resize(80, b' ');
    header.extend(count.to_le_bytes());
    out.write_all(&header).map_err(failed)?;
    for part in parts {
        write_part(part, mesh, out).map_err(failed)?;
    }
    out.flush().map_err(failed)?;
    Ok(84 + 50 * n_triangles)
}

/// Writes the triangles of a flag, some thousands at once.
fn write_part(part: &SkinPart, mesh: &Mesh, out: &mut dyn Write) -> std::io::Result<()> {
    const AT_ONCE: usize = 4096;
    let mut bytes = Vec::with_capacity(50 * AT_ONCE);
    for (chunk, triangles) in part.indices.chunks(3 * AT_ONCE).enumerate() {
        bytes.clear();
        for (index, corners) in triangles.chunks_exact(3).enumerate() {
            let direction = part.direction((chunk * AT_ONCE + index) / 2);
            let mut normal = [0f32; 3];
            normal[direction / 2] = if direction % 2 == 1 { 1.0 } else { -1.0 };
            let mut push = |value: f32| bytes.extend(value.to_le_bytes());
            normal.into_iter().for_each(&mut push);
            for &corner in corners {
                for axis in 0..3 {
                    // positions are whole numbers of lines
                    let line = part.positions[3 * corner as usize + axis] as u32;
                    push(mesh.lines.line(axis, line) as f32);
                }
            }
            bytes.extend([0; 2]);
        }
        out.write_all(&bytes)?;
    }
    Ok(())
}
