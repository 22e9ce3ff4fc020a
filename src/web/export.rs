//! Files of exporters for JavaScript.

use std::io::Write;
use std::rc::Rc;

use super::resting::Resting;
use crate::error::{Error, Result};
use crate::export::{ExportOptions, Exporter, Files, export_with_rests};
use crate::mesh::Mesh;
use crate::write::archive::{Archive, Buffer};

/// Flags of a slab, or those of a plane where that has more: a cell becomes up to some hundred bytes.
const SLAB_BYTES: usize = 1 << 18;
/// Most cells of a plane that is held whole: what becomes of one must fit the memory of wasm.
const MAX_PLANE: u64 = 1 << 22;

/// The exporter of a format by its name in JavaScript: the end of the names of its files.
pub(super) fn exporter_of(format: &str) -> Option<Exporter> {
    Exporter::ENDINGS.into_iter().find(|(ending, _)| ending.trim_start_matches('.') == format).map(|(_, of)| of)
}

/// Starts the file of an exporter. One that has several makes an archive of them, which is unpacked into the folder of a case.
pub(super) fn export_work(mesh: Rc<Mesh>, exporter: Exporter, options: ExportOptions) -> Result<Resting> {
    let options = options.with_slab_bytes(SLAB_BYTES);
    exporter.check(&mesh, &options)?;
    check_plane(&mesh, exporter)?;
    Ok(Resting::new(mesh.slabs(SLAB_BYTES).count(), |mut out, control| async move {
        let archive = (exporter == Exporter::Foam).then(|| Archive::new(options.compress, out.clone()));
        let mut files = WebFiles { made: out.clone(), archive };
        export_with_rests(&mesh, (exporter, "mesh.foam"), &options, &mut files, &control).await?;
        let end = files.archive.map_or(Ok(Vec::new()), Archive::finish)?;
        out.write_all(&end).map_err(|error| Error::io("writing the mesh", error))
    }))
}

/// Refuses planes that are too large, for exporters that hold them.
fn check_plane(mesh: &Mesh, exporter: Exporter) -> Result<()> {
    let [nx, ny, nz] = mesh.dims().map(u64::from);
    let (axis, n_cells) = match exporter {
        Exporter::Nrrd | Exporter::Vox => return Ok(()),
        Exporter::Binvox => ("x", ny * nz),
        _ => ("z", nx * ny),
    };
    if n_cells > MAX_PLANE {
        let message =
            format!("a plane across {axis} has {n_cells} cells, and exporters hold planes of up to {MAX_PLANE} here");
        return Err(Error::new("memory", message, "save the mesh as .hxc, and convert it natively: hexcast convert"));
    }
    Ok(())
}

/// The files of an exporter, as they are or in an archive.
struct WebFiles {
    made: Buffer,
    archive: Option<Archive>,
}

impl Files for WebFiles {
    fn create(&mut self, name: &str) -> Result<Box<dyn Write + '_>> {
        match &mut self.archive {
            Some(archive) => Ok(Box::new(archive.file(name)?)),
            None => Ok(Box::new(self.made.clone())),
        }
    }
}
