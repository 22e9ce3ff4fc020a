//! A Zarr store as output: a folder of its own, put in place at the end, or a store that several processes fill.

use std::path::{Path, PathBuf};

use hexcast::files::WrittenFolder;
use hexcast::files::place::{folder_of, refused, target_of};
use hexcast::pipeline::Prepared;
use hexcast::shards::Shards;
use hexcast::write::zarr::{self, Place, check_levels_of_part};
use hexcast::write::{Format, Options};
use hexcast::{Error, Result};
use indicatif::ProgressBar;

use crate::files::{
    disk::Planned,
    ledger,
    output::{Asked, Meshed, Output, Written},
    output_file::OutputFile,
    place_of_store::{self, is_s3},
    store::Shared,
    temporary,
};

/// The new folder: inside the temporary one, which only its owner may open.
const NEW: &str = "new";

/// A store being written.
pub(crate) struct ZarrOutput {
    output: ledger::Output,
    store: Store,
    options: Options,
    /// Whether the mesh is a part of what the store holds.
    is_part: bool,
    numbers: Numbers,
}

/// What a store has of each cell.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Numbers {
    Flags,
    /// The fraction that is not background.
    Fractions,
    /// The distance of the nearest surface.
    Distances,
}

enum Store {
    /// The whole mesh, in a temporary folder until all is written; then that is known, too.
    Whole(temporary::Folder, Option<WrittenFolder>),
    /// A part of a mesh, or a whole one in a bucket, where nothing can be renamed: shards get their names one by one.
    Shared(Shared),
}

/// Whether the name of an output asks for a Zarr folder.
pub(crate) fn is_zarr(path: &Path) -> bool {
    Format::of_name(&path.to_string_lossy()) == Ok(Format::Zarr)
}

/// Refuses a path that is neither free nor a Zarr folder; returns it without the links at its end.
fn check_replaceable(path: &Path) -> Result<PathBuf> {
    // another process may have begun the store a moment ago
    let is_ours = |entry: std::io::Result<std::fs::DirEntry>| {
        entry.is_ok_and(|entry| entry.file_name().to_string_lossy().starts_with(temporary::PREFIX))
    };
    let is_begun = || std::fs::read_dir(path).is_ok_and(|mut entries| entries.all(is_ours));
    if path.exists() && !path.join("zarr.json").is_file() && !is_begun() {
        return Err(Error::new("io", format!("{} exists and is not a Zarr folder", path.display()), "name another"));
    }
    target_of(path)
}

impl ZarrOutput {
    /// Opens one for flags.
    pub(crate) fn open(path: &Path, options: Options, is_part: bool) -> Result<ZarrOutput> {
        let target = if is_s3(path) { path.to_path_buf() } else { check_replaceable(path)? };
        let (output, store);
        if is_part || is_s3(path) {
            output = ledger::Output::file_of(path, target)?;
            store = Store::Shared(Shared::new(place_of_store::open(&output.target)?));
        } else {
            output = ledger::Output::folder(path, target)?;
            let parent = folder_of(&output.target);
            let folder = temporary::Folder::beside(&output.target, parent);
            store = Store::Whole(folder.map_err(|error| refused(path, parent, &error))?, None);
        }
        Ok(ZarrOutput { output, store, options, is_part, numbers: Numbers::Flags })
    }

    /// Opens one for other numbers than flags.
    pub(crate) fn of_numbers(path: &Path, options: Options, numbers: Numbers) -> Result<ZarrOutput> {
        if is_s3(path) {
            let named = if numbers == Numbers::Distances { "distances" } else { "fractions of cells" };
            let message = format!("{}: {named} are not written to a bucket", path.display());
            return Err(Error::new("job-value", message, "write a folder, and copy it"));
        }
        Ok(ZarrOutput { numbers, ..ZarrOutput::open(path, options, false)? })
    }
}

impl Output for ZarrOutput {
    fn check(&self, asked: &Asked) -> Result<Option<Planned>> {
        let Prepared { whole, names, unit, .. } = asked.prepared;
        let lines = if self.is_part { whole } else { &asked.lines };
        Shards::new(lines.dims(), &self.options.zarr)?;
        if self.is_part {
            check_levels_of_part(&self.options.zarr)?;
        }
        // closed gaps add a name
        if let (Store::Shared(values), None) = (&self.store, asked.job.close_gaps) {
            let metadata = zarr::metadata(lines, names, unit.as_deref(), &self.options)?;
            values.has("zarr.json", &metadata).map_err(|error| error.at(self.output.path.display()))?;
        }
        Ok(None)
    }

    fn write(&mut self, meshed: &Meshed, written: &mut Written) -> Result<()> {
        let options = &self.options;
        let &Meshed { mesh, facts, control, progress, .. } = meshed;
        let bar = match self.numbers {
            Numbers::Flags => progress.bytes("write", Some(mesh.n_cells())),
            _ => ProgressBar::hidden(),
        };
        let advance = |n_cells| bar.inc(n_cells);
        let fractions = facts.and_then(|facts| facts.fractions.as_ref());
        let distance = facts.and_then(|facts| facts.distance.as_ref());
        let part =
            facts.filter(|_| self.is_part).and_then(|facts| Some((facts.whole.clone(), facts.window.as_ref()?.first)));
        let (whole, first) = part.unwrap_or_else(|| (mesh.lines().clone(), [0; 3]));
        let place = Place::new(whole, first);
        let write = |set: &zarr::Set| match (self.numbers, fractions, distance) {
            (Numbers::Fractions, Some(fractions), _) => zarr::write_solid(mesh, fractions, options, set, control),
            (Numbers::Distances, _, Some(distance)) => zarr::write_distance(mesh, distance, options, set, control),
            (Numbers::Flags, ..) => zarr::write_part(mesh, &place, options, set, control, advance),
            _ => Ok(()),
        };
        let done = match &mut self.store {
            Store::Shared(values) => write(&|key, value| values.set(key, value)).map(|()| values.n_bytes()),
            Store::Whole(temporary, whole) => {
                let folder = whole.insert(WrittenFolder::new(temporary.path(NEW)));
                write(&|key, value| folder.put(key, value)).map(|()| folder.n_bytes())
            }
        };
        bar.finish_and_clear();
        let path = &self.output.path;
        let n_bytes = done.map_err(|error| error.at(path.display()))?;
        written.files.push(OutputFile { path: path.clone(), n_bytes });
        Ok(())
    }

    /// Puts a folder in its place, if all that was written to it is there; one that was there goes only now. Of a store that others fill, too,
    /// all is in its place.
    fn finish(self: Box<Self>) -> Result<()> {
        let Store::Whole(temporary, written) = &self.store else { return Ok(()) };
        let (path, target) = (self.output.path.display(), &self.output.target);
        let verified = written.as_ref().map_or(Ok(()), WrittenFolder::verify);
        verified.map_err(|error| error.at(&path))?;
        temporary.take_old(target).map_err(|error| Error::io(format!("writing {path}"), error))?;
        self.output.put_path(&temporary.path(NEW))
    }
}
