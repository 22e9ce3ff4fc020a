//! Bit-packed flags: eight cells a byte, for meshes with a single flag; [`flags`](hexcast_core::cells::flags) makes them.
//!
//! A bit is 1 where the flag is not 0. Each row along x begins with a new byte, its first cell in the lowest bit, and bits past its end
//! are 0: cell (x, y, z) of nx x ny x nz cells is bit `x % 8` of byte `x / 8 + ceil(nx / 8) * (y + ny * z)`.

use hexcast_core::base::error::{Error, Result};
use hexcast_derived::mesh::Mesh;

/// Refuses meshes with several flags, which a bit a cell cannot distinguish.
///
/// # Errors
/// `job-conflict` where more than one flag besides the background is in use.
pub fn check(mesh: &Mesh) -> Result<()> {
    let cells = mesh.columns().cells_per_flag();
    let used: Vec<usize> = (1..cells.len()).filter(|&flag| cells[flag] > 0).collect();
    if used.len() > 1 {
        let message = format!("bits hold one flag, and the mesh has {}: {used:?}", used.len());
        return Err(Error::new("job-conflict", message, "write bytes, or give all geometries the same flag"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use hexcast_derived::testing::pattern;

    #[test]
    fn several_flags_are_refused_by_name() {
        assert!(check(&pattern(0, [9, 5, 7], 1)).is_ok());
        let error = check(&pattern(0, [9, 5, 7], 3)).unwrap_err();
        assert_eq!(error.code(), "job-conflict");
        assert!(error.to_string().contains("[1, 2, 3]"), "{error}");
    }
}
