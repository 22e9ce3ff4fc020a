//! Where columns go besides memory.

use std::io;

/// A place for bytes outside memory, such as a file. Calls may come from several threads.
pub trait Store: Send + Sync {
    /// Appends bytes and returns the place of the first.
    ///
    /// # Errors
    /// Whatever the medium fails with.
    fn append(&self, bytes: &[u8]) -> io::Result<u64>;

    /// Reads the bytes at a place that was appended before.
    ///
    /// # Errors
    /// Whatever the medium fails with.
    fn read(&self, at: u64, bytes: &mut [u8]) -> io::Result<()>;

    /// Drops everything from a place on; the next append goes there.
    ///
    /// # Errors
    /// Whatever the medium fails with.
    fn truncate(&self, n_bytes: u64) -> io::Result<()>;
}

#[cfg(test)]
pub(crate) mod tests {
    use std::sync::Mutex;

    use super::*;

    /// A store for tests.
    #[derive(Default)]
    pub(crate) struct Memory(pub(crate) Mutex<Vec<u8>>);

    impl Store for Memory {
        fn append(&self, bytes: &[u8]) -> io::Result<u64> {
            let mut held = self.0.lock().unwrap();
            held.extend_from_slice(bytes);
            Ok((held.len() - bytes.len()) as u64)
        }

        fn read(&self, at: u64, bytes: &mut [u8]) -> io::Result<()> {
            let held = self.0.lock().unwrap();
            let found = held.get(at as usize..at as usize + bytes.len()).ok_or(io::ErrorKind::UnexpectedEof)?;
            bytes.copy_from_slice(found);
            Ok(())
        }

        fn truncate(&self, n_bytes: u64) -> io::Result<()> {
            self.0.lock().unwrap().truncate(n_bytes as usize);
            Ok(())
        }
    }
}
