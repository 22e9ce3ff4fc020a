//! A store for columns outside memory.

use std::io;

/// Bytes outside memory, such as a file. Calls may come from several threads.
pub trait Store: Send + Sync {
    /// Appends bytes and returns the offset of the first.
    ///
    /// # Errors
    /// The error of the medium.
    fn append(&self, bytes: &[u8]) -> io::Result<u64>;

    /// Reads bytes that were appended before, from an offset on.
    ///
    /// # Errors
    /// The error of the medium.
    fn read(&self, at: u64, bytes: &mut [u8]) -> io::Result<()>;

    /// Drops all bytes from an offset on; the next append starts there.
    ///
    /// # Errors
    /// The error of the medium.
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
