//! The place of an output: where its path leads, through links, whether it may be written there, and which files an exporter writes there.

use std::fs::Metadata;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use hexcast_core::base::error::{Error, Result};
#[cfg(feature = "export")]
use hexcast_files::export::Exporter;

/// Links that the system follows in one path.
const MAX_LINKS: usize = 40;

/// The path of an output without the links at its end: a link stays, and what it leads to is written, there or not.
///
/// # Errors
/// `io` where the links form a circle, or lead to a file by the number under which a process has it open.
pub fn target_of(path: &Path) -> Result<PathBuf> {
    let mut target = path.to_path_buf();
    for _ in 0..MAX_LINKS {
        // links to what a process has open, as /dev/stdout is: another file of that name would not be what is open
        if target.starts_with("/proc") {
            return Err(if path.exists() { not_a_file(path) } else { not_in_proc(path) });
        }
        // fails for what is not a link and for what is not there
        let Ok(next) = std::fs::read_link(&target) else { return Ok(target) };
        target = folder_of(&target).join(next);
    }
    let message = format!(
        "{} cannot be written: it is a symbolic link that leads through more than {MAX_LINKS} others, or through links in a circle",
        path.display()
    );
    Err(Error::new("io", message, "name the file itself"))
}

/// The folder of a path.
pub fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// What the system knows a file by: device and inode.
#[doc(hidden)]
pub type Id = (u64, u64);

/// By what the system knows a file, where it says.
#[cfg(unix)]
#[doc(hidden)]
pub fn id_of(metadata: &Metadata) -> Option<Id> {
    use std::os::unix::fs::MetadataExt;
    Some((metadata.dev(), metadata.ino()))
}

/// By what the system knows a file: others than Unix do not say.
#[cfg(not(unix))]
#[doc(hidden)]
pub fn id_of(_: &Metadata) -> Option<Id> {
    None
}

/// Refuses what exists and is neither a file nor a folder: a pipe, a device, a socket.
///
/// # Errors
/// `io`.
pub fn check_kind(path: &Path) -> Result<()> {
    match path.metadata() {
        Ok(metadata) if !metadata.is_file() && !metadata.is_dir() => Err(not_a_file(path)),
        _ => Ok(()),
    }
}

fn not_in_proc(path: &Path) -> Error {
    let message = format!(
        "{} cannot be written: /proc has what the system says of its processes, and no other files",
        path.display()
    );
    Error::new("io", message, "name a file in another folder")
}

/// The error of a path that is taken by something else than a file.
pub fn not_a_file(path: &Path) -> Error {
    let message = format!("{} exists and is not a file: it is left as it is", path.display());
    Error::new("io", message, "move what has this name, or name another output")
}

/// The error of a folder in which no file can be made; it does not name the temporary file.
pub fn refused(path: &Path, folder: &Path, error: &std::io::Error) -> Error {
    let (name, folder) = (path.display(), folder.display());
    match error.kind() {
        ErrorKind::NotFound => {
            let message = format!("{name} cannot be written: there is no folder {folder}");
            Error::new("io", message, "make the folder first, or name another")
        }
        kind => {
            let message = format!("{name} cannot be written: the folder {folder} says \"{kind}\"");
            Error::new("io", message, "make sure that the folder is yours and has room")
        }
    }
}

/// The files of an exporter: the folder in which their names begin, and the names.
#[cfg(feature = "export")]
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct ExportPlace {
    /// The folder, which must be there.
    pub folder: PathBuf,
    /// The name of the output in it, which [`export()`](hexcast_files::export::export) takes.
    pub name: String,
    /// The files in it; those of a case of OpenFOAM and of AMReX are in folders that need not be there.
    pub files: Vec<String>,
}

#[cfg(feature = "export")]
impl ExportPlace {
    /// Finds where an exporter writes what `path` asks for, and whether it may.
    ///
    /// # Errors
    /// Those of [`target_of`]; `io` where something else has the place of a file, or files of another mesh would stay beside the new ones.
    pub fn of(path: &Path, exporter: Exporter) -> Result<ExportPlace> {
        // a link to a case is replaced: what it leads to may have a name that tells nothing
        let target = if exporter == Exporter::Foam { path.to_path_buf() } else { target_of(path)? };
        let name = target.file_name().unwrap_or_default().to_string_lossy().into_owned();
        // the folders that a mesh has in a case of OpenFOAM need not be there
        let is_within = |file: &String| exporter == Exporter::Foam && file.starts_with(&format!("{name}/"));
        let folder = match exporter.file_names(&name).iter().all(is_within) {
            true => folder_of(folder_of(&target)).to_path_buf(),
            false => folder_of(&target).to_path_buf(),
        };
        let name = target.strip_prefix(&folder).unwrap_or(&target).to_string_lossy().replace('\\', "/");
        let files = exporter.file_names(&name);
        check_files(path, &folder, &files)?;
        Ok(ExportPlace { folder, name, files })
    }
}

/// Refuses places that something else has, and folders in which files of another mesh would stay.
#[cfg(feature = "export")]
fn check_files(path: &Path, folder: &Path, names: &[String]) -> Result<()> {
    for name in names {
        let place = folder.join(name);
        if place.is_dir() {
            return Err(Error::new("io", format!("{} is a folder", place.display()), "name a file in it"));
        }
        check_kind(&place)?;
        let inner = folder_of(&place);
        if inner == folder || !inner.is_dir() {
            continue;
        }
        let entries = std::fs::read_dir(inner).map_err(|error| refused(path, inner, &error))?;
        for entry in entries.flatten().map(|entry| entry.path()) {
            // a folder of the mesh's own is one of the entries
            if names.iter().all(|name| !folder.join(name).starts_with(&entry)) {
                let message = format!("{} is in the folder of the new mesh, and belongs to another", entry.display());
                return Err(Error::new(
                    "io",
                    message,
                    "move or remove it: what is read with the new mesh must be made for it",
                ));
            }
        }
    }
    Ok(())
}
