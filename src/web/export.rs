//! Files of exporters for JavaScript. An exporter writes from its first byte to its last; it rests before every slab, and goes on when what
//! it has written is taken. So the reader sets the pace, and memory holds what became of a slab.

use std::io::Write;
use std::rc::Rc;

use super::work::Work;
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

/// Refuses options that a format would silently ignore: whether compression, bits, text and flags are asked for. Formats without an
/// exporter look at the first two themselves.
pub(super) fn check_options(format: &str, exporter: Option<Exporter>, given: [bool; 4]) -> Result<()> {
    let is = |fits: fn(Exporter) -> bool| exporter.is_some_and(fits);
    // several files come as an archive, which is compressed
    let compresses = |exporter: Exporter| exporter.compresses() || exporter == Exporter::Foam;
    let known = [
        (exporter.is_none() || is(compresses), "compress", "cannot be compressed", "nrrd or foam"),
        (exporter.is_none(), "bits", "has no bit-packed variant", "raw or npy"),
        (is(Exporter::has_ascii), "ascii", "has no form in text besides a binary one", "foam or msh"),
        (
            is(Exporter::has_flags),
            "exportFlags",
            "does not hold the cells of some flags only",
            "foam, inp, msh, csx.xml, geometry.xml, vox or binvox",
        ),
    ];
    let wrong = known.iter().zip(given).find(|((fits, ..), given)| *given && !fits);
    wrong.map_or(Ok(()), |((_, option, why, others), _)| {
        let message = format!("{option} is given, and .{format} {why}");
        Err(Error::new("job-conflict", message, format!("leave it out, or write {others}")))
    })
}

/// An exporter at work.
pub(super) struct ExportWork {
    /// None at the end.
    work: Option<Work<()>>,
    made: Buffer,
    /// Slabs that were looked at, and all of them.
    n_slabs: [usize; 2],
}

impl ExportWork {
    /// Starts the file of an exporter. One that has several makes an archive of them, which is unpacked into the folder of a case.
    pub(super) fn new(mesh: Rc<Mesh>, exporter: Exporter, options: ExportOptions) -> Result<ExportWork> {
        let options = options.with_slab_bytes(SLAB_BYTES);
        exporter.check(&mesh, &options)?;
        check_plane(&mesh, exporter)?;
        let made = Buffer::default();
        let n_slabs = [0, mesh.slabs(SLAB_BYTES).count()];
        let mut out = made.clone();
        let work = Work::new(move |control| async move {
            let archive = (exporter == Exporter::Foam).then(|| Archive::new(options.compress, out.clone()));
            let mut files = WebFiles { made: out.clone(), archive };
            export_with_rests(&mesh, (exporter, "mesh.foam"), &options, &mut files, &control).await?;
            let end = files.archive.map_or(Ok(Vec::new()), Archive::finish)?;
            out.write_all(&end).map_err(|error| Error::io("writing the mesh", error))
        });
        Ok(ExportWork { work: Some(work), made, n_slabs })
    }

    /// The bytes of the next slab, possibly none; None at the end.
    ///
    /// # Errors
    /// Those of [`crate::export::export()`].
    pub(super) fn step(&mut self) -> Result<Option<Vec<u8>>> {
        let Some(work) = &mut self.work else { return Ok(None) };
        self.n_slabs[0] += 1;
        let step = work.step();
        if step != Ok(true) {
            self.work = None;
        }
        step?;
        Ok(Some(self.made.take()))
    }

    /// Share of the first pass over all cells, 0 to 1: what is written first may need all of it.
    pub(super) fn share(&self) -> f64 {
        let [done, all] = self.n_slabs;
        (done as f64 / all as f64).min(1.0)
    }
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
