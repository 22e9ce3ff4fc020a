//! Files of exporters for JavaScript.

use std::cell::RefCell;
use std::io::Write;
use std::rc::Rc;
use std::sync::Arc;

use super::work::Resting;
use crate::meshing::measured::Measured;
use hexcast_core::base::error::{Error, Result};
use hexcast_derived::mesh::Mesh;
use hexcast_files::export::{ExportOptions, Exporter, Files, export_with_rests, write_arrays};
use hexcast_files::write::Compress;
use hexcast_files::write::archive::{Archive, Buffer};

/// Flags of a slab, or those of a plane where that has more: a cell becomes up to some hundred bytes.
const SLAB_BYTES: usize = 1 << 18;
/// Most bytes of cut cells while they are made.
const MAX_HELD: u64 = 3 << 29;
/// Most cells of a plane that is held whole: what becomes of one must fit the memory of wasm.
const MAX_PLANE: u64 = 1 << 22;

/// The exporter of a format by its name in JavaScript: the end of the names of its files.
pub(super) fn exporter_of(format: &str) -> Option<Exporter> {
    Exporter::ENDINGS.into_iter().find(|(ending, _)| ending.trim_start_matches('.') == format).map(|(_, of)| of)
}

/// Names in JavaScript of the exporters of a kind, for errors.
pub(super) fn names_of(is_kind: fn(Exporter) -> bool) -> String {
    let kind = Exporter::ENDINGS.iter().filter(|(ending, exporter)| !ending.contains('/') && is_kind(*exporter));
    let mut names: Vec<&str> = kind.map(|(ending, _)| ending.trim_start_matches('.')).collect();
    let last = names.pop().unwrap_or_default();
    format!("{} or {last}", names.join(", "))
}

/// Starts the file of an exporter. One that has several makes an archive of them, which is unpacked into the folder of a case.
pub(super) fn export_work(mesh: Rc<Mesh>, exporter: Exporter, options: ExportOptions) -> Result<Resting> {
    let options = options.with_slab_bytes(SLAB_BYTES);
    exporter.check(&mesh, &options)?;
    check_plane(&mesh, exporter)?;
    let (what, held) = exporter.held(&mesh);
    if held > MAX_HELD {
        let message = format!("{what} would take up to {held} bytes while they are made, and {MAX_HELD} are held here");
        return Err(Error::new("memory", message, "use larger cells, or mesh natively: hexcast mesh"));
    }
    let name = Exporter::ENDINGS
        .iter()
        .find(|(_, of)| *of == exporter)
        .map_or("mesh".into(), |(ending, _)| format!("mesh{ending}"));
    // datasets in it are compressed themselves
    let packed = if exporter == Exporter::Foam { options.compress } else { Compress::None };
    let has_several = exporter.file_names(&name).len() > 1;
    let lacks: Rc<RefCell<Vec<String>>> = Rc::default();
    let said = lacks.clone();
    let work = Resting::new(mesh.slabs(SLAB_BYTES).count(), move |mut out, control| async move {
        let archive = has_several.then(|| Archive::new(packed, out.clone()));
        let mut files = WebFiles { made: out.clone(), archive };
        *said.borrow_mut() = export_with_rests(&mesh, (exporter, &name), &options, &mut files, &control).await?;
        let end = files.archive.map_or(Ok(Vec::new()), Archive::finish)?;
        out.write_all(&end).map_err(|error| Error::io("writing the mesh", error))
    });
    Ok(work.with_lacks(lacks))
}

/// Starts what was measured as HDF5: `of` is `links` or `distance`.
pub(super) fn hdf5_work((mesh, measured): (Rc<Mesh>, Arc<Measured>), of: &str, compress: Compress) -> Result<Resting> {
    measured.arrays(&mesh, of)?;
    let of = of.to_string();
    Ok(Resting::new(1, move |made, control| async move {
        let mut file = WebFiles { made, archive: None };
        write_arrays(&measured.arrays(&mesh, &of)?, "measured.h5", compress, &mut file, &control)
    }))
}

/// Refuses planes that are too large, for exporters that hold them.
fn check_plane(mesh: &Mesh, exporter: Exporter) -> Result<()> {
    let Some(axis) = exporter.held_planes() else { return Ok(()) };
    let [one, other] = [1, 2].map(|after| u64::from(mesh.dims()[(axis + after) % 3]));
    let (axis, n_cells) = (["x", "y", "z"][axis], one * other);
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
