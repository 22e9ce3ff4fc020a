//! Where a Zarr store is: in a folder, or in a bucket of S3 or of a service with its interface.

use std::io::ErrorKind;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use hexcast::files::place::folder_of;
use hexcast::{Error, Result};

#[cfg(feature = "s3")]
use crate::files::s3::Bucket;
use crate::files::{ledger::Output, store::Store};

/// What the name of a store in a bucket begins with.
const S3: &str = "s3://";

/// Whether a name is that of a store in a bucket.
pub(crate) fn is_s3(path: &Path) -> bool {
    path.to_string_lossy().starts_with(S3)
}

/// Opens a store, which may not be there yet.
pub(crate) fn open(path: &Path) -> Result<Arc<dyn Store>> {
    if is_s3(path) { bucket(path) } else { Ok(Arc::new(Folder { root: path.into() })) }
}

#[cfg(feature = "s3")]
fn bucket(path: &Path) -> Result<Arc<dyn Store>> {
    Ok(Arc::new(Bucket::open(&path.to_string_lossy())?))
}

#[cfg(not(feature = "s3"))]
fn bucket(path: &Path) -> Result<Arc<dyn Store>> {
    let message = format!("{}: this hexcast was built without S3", path.display());
    Err(Error::new("io", message, "build it with --features s3, or write to a folder"))
}

/// A folder of files.
struct Folder {
    root: PathBuf,
}

impl Store for Folder {
    fn get(&self, key: &str) -> Result<Option<Vec<u8>>> {
        match std::fs::read(self.root.join(key)) {
            Ok(value) => Ok(Some(value)),
            // a file in place of the folder has no keys
            Err(error) if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => Ok(None),
            Err(error) => Err(Error::io(format!("reading {key}"), error)),
        }
    }

    fn put(&self, key: &str, value: &[u8]) -> Result<()> {
        let path = self.root.join(key);
        let output = Output::file_of(&path, path.clone())?;
        let write = || {
            std::fs::create_dir_all(folder_of(&path))?;
            let mut file = output.temporary_file()?;
            file.write_all(value)?;
            Ok(file)
        };
        output.put_file(write().map_err(|error| Error::io(format!("writing {key}"), error))?)
    }

    fn keys(&self, prefix: &str) -> Result<Vec<String>> {
        let (mut keys, mut folders) = (Vec::new(), vec![prefix.trim_end_matches('/').to_string()]);
        while let Some(folder) = folders.pop() {
            let entries = match std::fs::read_dir(self.root.join(&folder)) {
                Ok(entries) => entries,
                Err(error) if error.kind() == ErrorKind::NotFound => continue,
                Err(error) => return Err(Error::io(format!("reading {folder}"), error)),
            };
            for entry in entries {
                let entry = entry.map_err(|error| Error::io(format!("reading {folder}"), error))?;
                let key = format!("{folder}/{}", entry.file_name().to_string_lossy());
                let is_folder = entry.file_type().is_ok_and(|kind| kind.is_dir());
                if is_folder { &mut folders } else { &mut keys }.push(key);
            }
        }
        Ok(keys)
    }
}
