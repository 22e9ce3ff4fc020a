//! Columns that spilled are a column file.

use std::sync::Arc;

use hexcast_core::cells::columns::{ColumnsBuilder, MemoryStore};

use super::*;

#[test]
fn columns_that_spilled_are_read_as_a_column_file() {
    // rows of many rays, and a band of more rays than a piece has
    for (axis, dims, rows) in [(0, [12, 5, 7], 2), (1, [5, 12, 7], 1), (2, [5, 7, 12], 3), (2, [256, 264, 9], 264)] {
        let mesh = pattern(axis, dims, 3);
        let rays = *mesh.columns().rays();
        let head = head(&mesh, false);
        let store = Arc::new(MemoryStore::default());
        let mut builder = ColumnsBuilder::new(rays, 0, Some((head.encode().unwrap(), store.clone())));
        bands(&mesh, rows * rays.counts[0] as usize).into_iter().for_each(|band| builder.push(vec![band]).unwrap());
        let columns = builder.finish().unwrap();
        assert!(columns.is_spilled());
        let file = store.bytes().clone();
        let read = read(&mut &file[..], u64::MAX).unwrap();
        let counts = |columns: &Columns| [columns.n_runs(), columns.n_crossings(), columns.odd_rays()];
        assert_eq!((counts(read.columns()), counts(&columns)), (counts(mesh.columns()), counts(mesh.columns())));
        assert_eq!((read.columns(), &columns), (mesh.columns(), mesh.columns()));
        assert_eq!((read.lines(), read.names(), read.unit()), (mesh.lines(), mesh.names(), mesh.unit()));
    }
}
