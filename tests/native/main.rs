//! The integration tests of the native library and command line, in one binary.

mod formats;
