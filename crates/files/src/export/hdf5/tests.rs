//! What wasm writes as HDF5 is what native programs read: both forms of a file by a reader that neither of them has written.

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::path::PathBuf;

use rust_hdf5::{H5File, H5Type};

use super::{Shape, in_memory, on_disk};
use crate::export::Files;
use crate::write::Compress;
use hexcast_core::base::error::Result;

/// Files in a folder; those that are written from the first byte to the last are counted.
struct Folder {
    path: tempfile::TempDir,
    n_created: usize,
}

impl Files for Folder {
    fn create(&mut self, name: &str) -> Result<Box<dyn Write + '_>> {
        self.n_created += 1;
        let file = std::fs::File::create(self.path.path().join(name));
        Ok(Box::new(file.map_err(super::failed)?))
    }

    fn place(&mut self, name: &str) -> Result<PathBuf> {
        Ok(self.path.path().join(name))
    }
}

/// Makes a file with every type that exporters write, in either form.
macro_rules! make {
    ($form:ident, $files:expr, $name:expr, $compress:expr, $n_rows:expr) => {{
        let mut file = $form::File::create($files, $name, 0)?;
        file.text("flag 1", "Fuß <1> & \"2\"")?;
        file.text("unit", "mm")?;
        file.numbers("dx_dy_dz", &[0.1, 1e-300, -2.5])?;
        file.texts("material_keys", &["a", "", "sehr länger als ein Wort"])?;
        macro_rules! table {
            ($kind:ty, $table:expr, $rest:expr) => {{
                let dims = [&[$n_rows][..], $rest].concat();
                let row: usize = $rest.iter().product();
                let mut table =
                    $form::Table::<$kind>::new(&mut file, Shape { name: $table, dims: &dims, compress: $compress })?;
                // rows alone, and many at once
                for start in (0..$n_rows).step_by(7) {
                    let items: Vec<$kind> =
                        (start * row..($n_rows).min(start + 7) * row).map(|i| (i * i % 251) as $kind).collect();
                    table.push(&items)?;
                }
                table.finish(&mut file)?;
            }};
        }
        table!(f64, "points", &[3usize]);
        table!(u64, "cells", &[8usize]);
        table!(u8, "flag", &[0usize; 0]);
        table!(i16, "data", &[5usize, 77]);
        table!(i8, "directions", &[3usize]);
        table!(u32, "x", &[0usize; 0]);
        table!(i32, "facet", &[0usize; 0]);
        table!(f32, "q", &[0usize; 0]);
        file.finish($files)
    }};
}

type Shaped = BTreeMap<String, (Vec<usize>, Vec<f64>)>;

/// All datasets of numbers, and the attributes.
fn read(file: &H5File) -> (Shaped, BTreeMap<String, String>) {
    fn items<T: H5Type>(file: &H5File, name: &str) -> Vec<T> {
        file.dataset(name).unwrap().read_raw::<T>().unwrap()
    }
    let numbers = |name: &str| -> Vec<f64> {
        match name {
            "points" => items::<f64>(file, name),
            "cells" => items::<u64>(file, name).into_iter().map(|item| item as f64).collect(),
            "flag" => items::<u8>(file, name).into_iter().map(f64::from).collect(),
            "data" => items::<i16>(file, name).into_iter().map(f64::from).collect(),
            "directions" => items::<i8>(file, name).into_iter().map(f64::from).collect(),
            "x" => items::<u32>(file, name).into_iter().map(f64::from).collect(),
            "facet" => items::<i32>(file, name).into_iter().map(f64::from).collect(),
            "q" => items::<f32>(file, name).into_iter().map(f64::from).collect(),
            _ => panic!("{name}"),
        }
    };
    let names = file.dataset_names().into_iter().filter(|name| name != "material_keys");
    let tables = names.map(|name| (name.clone(), (file.dataset(&name).unwrap().shape(), numbers(&name)))).collect();
    let texts = ["flag 1", "unit"].map(|name| (name.to_string(), file.attr_string(name).unwrap()));
    (tables, texts.into())
}

fn both(compress: Compress, n_rows: usize) -> Result<()> {
    let mut files = Folder { path: tempfile::tempdir().map_err(super::failed)?, n_created: 0 };
    make!(on_disk, &mut files, "disk.h5", compress, n_rows)?;
    assert_eq!(files.n_created, 0);
    make!(in_memory, &mut files, "held.h5", compress, n_rows)?;
    assert_eq!(files.n_created, 1);
    let [disk, held] = ["disk.h5", "held.h5"].map(|name| H5File::open(files.path.path().join(name)).unwrap());
    let (tables, texts) = read(&disk);
    assert_eq!(tables.len(), 8);
    assert_eq!(tables["data"].0, [n_rows, 5, 77]);
    assert_eq!(tables["data"].1.len(), n_rows * 5 * 77);
    let expected: Vec<f64> = (0..n_rows * 8).map(|i| (i * i % 251) as f64).collect();
    assert_eq!(tables["cells"].1, expected);
    assert_eq!(texts["flag 1"], "Fuß <1> & \"2\"");
    assert_eq!(read(&held), (tables, texts));
    for file in [&disk, &held] {
        let keys = file.dataset("material_keys").unwrap().read_vlen_strings().unwrap();
        assert_eq!(keys, ["a", "", "sehr länger als ein Wort"]);
    }
    Ok(())
}

#[test]
fn both_forms_hold_the_same() {
    // one chunk, several of some tables, and no row
    for n_rows in [1, 30, 20_000, 0] {
        for compress in [Compress::None, Compress::Zlib(1), Compress::Zlib(9)] {
            both(compress, n_rows).unwrap();
        }
    }
}

#[test]
fn a_file_that_would_not_fit_the_memory_is_refused_with_numbers() {
    let mut files = Folder { path: tempfile::tempdir().unwrap(), n_created: 0 };
    assert!(in_memory::File::create(&mut files, "a.h5", 1 << 28).is_ok());
    let error = in_memory::File::create(&mut files, "a.h5", (1 << 28) + 1).map(|_| ()).unwrap_err();
    assert_eq!(error.code(), "memory");
    let text = error.to_string();
    assert!(text.contains("a.h5 has 268435457 bytes") && text.contains("up to 268435456"), "{text}");
}

#[test]
fn a_writer_that_fails_is_an_error() {
    struct Full;
    impl Write for Full {
        fn write(&mut self, _: &[u8]) -> io::Result<usize> {
            Err(io::Error::from(io::ErrorKind::StorageFull))
        }
        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }
    impl Files for Full {
        fn create(&mut self, _: &str) -> Result<Box<dyn Write + '_>> {
            Ok(Box::new(Full))
        }
        fn place(&mut self, _: &str) -> Result<PathBuf> {
            unreachable!("it is held")
        }
    }
    fn made() -> Result<()> {
        make!(in_memory, &mut Full, "a.h5", Compress::None, 3000usize)
    }
    assert_eq!(made().unwrap_err().code(), "io");
}

#[test]
fn chunks_are_whole_rows_of_the_last_axes() {
    let chunk = |dims: &[usize], n_bytes| Shape { name: "", dims, compress: Compress::None }.chunk(n_bytes);
    assert_eq!(chunk(&[1_000_000, 8], 8), [8192, 8]);
    assert_eq!(chunk(&[10], 8), [10]);
    assert_eq!(chunk(&[0], 8), [1]);
    assert_eq!(chunk(&[40, 50, 60], 2), [40, 50, 60]);
    assert_eq!(chunk(&[400, 500, 600], 2), [1, 436, 600]);
    assert_eq!(chunk(&[4, 5, 1_000_000], 2), [1, 1, 1 << 18]);
}
