use std::collections::BTreeMap;
use std::sync::Arc;

use super::super::stored;
use super::*;
use crate::testing::{mesh_of, pattern};
use hexcast_core::base::control::at_once;
use hexcast_core::cells::columns::MemoryStore;
use hexcast_core::grid::lines::Lines;

const SHAPES: [[u32; 3]; 5] = [[25, 27, 22], [64, 7, 150], [1, 5, 2], [3, 1, 9], [130, 4, 4]];

/// Flags without any order in boxes of a few cells, and single cells of a rare one.
fn noise([x, y, z]: [u32; 3]) -> u8 {
    let mixed = |[x, y, z]: [u32; 3]| {
        (x.wrapping_mul(73_856_093) ^ y.wrapping_mul(19_349_663) ^ z.wrapping_mul(83_492_791))
            .wrapping_mul(2_654_435_761)
            >> 24
    };
    if mixed([x, y, z]) < 3 {
        return 9;
    }
    let of_box = mixed([x / 5, y / 3, z / 2]);
    if of_box < 120 || mixed([z, x, y]) < 20 { 0 } else { 1 + (of_box % 4) as u8 }
}

fn all_cells([nx, ny, nz]: [u32; 3]) -> impl Iterator<Item = [u32; 3]> {
    (0..nz).flat_map(move |z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])))
}

/// Cells by flag in each cell of twice the size, of the cells that have any.
fn counted(mesh: &Mesh) -> BTreeMap<[u32; 3], [u32; 256]> {
    let mut counts: BTreeMap<[u32; 3], [u32; 256]> = BTreeMap::new();
    for cell in all_cells(mesh.dims()) {
        counts.entry(cell.map(|c| c / 2)).or_insert([0; 256])[usize::from(mesh.flag(cell).unwrap())] += 1;
    }
    counts
}

/// A flag by its definition; `n_of` are the cells of each flag in the mesh of level 0.
fn by_definition(rule: Levels, counts: &[u32; 256], n_of: &[u64; 256]) -> u8 {
    let rarest =
        |flags: &mut dyn Iterator<Item = u8>| flags.min_by_key(|&flag| (n_of[usize::from(flag)], flag)).unwrap_or(0);
    match rule {
        Levels::Any => rarest(&mut (1..=255).filter(|&flag| counts[usize::from(flag)] > 0)),
        _ => {
            let most = *counts.iter().max().unwrap();
            rarest(&mut (1..=255).filter(|&flag| counts[usize::from(flag)] == most))
        }
    }
}

#[test]
fn every_cell_of_every_level_is_that_of_the_definition() {
    for (axis, dims) in (0..3).flat_map(|axis| SHAPES.map(|dims| (axis, dims))) {
        for rule in [Levels::Any, Levels::Majority] {
            let mut mesh = mesh_of(axis, dims, noise);
            let n_of = mesh.columns.cells_per_flag();
            let pyramid = Pyramid::of(&mesh, rule);
            while mesh.dims() != [1; 3] {
                let expected = counted(&mesh);
                let coarser = at_once(pyramid.next(&mesh, &Control::default())).unwrap();
                assert_eq!(coarser.dims(), mesh.dims().map(|n| n.div_ceil(2)));
                assert_eq!(coarser.columns.rays().axis, axis);
                assert_eq!(expected.len() as u64, coarser.n_cells());
                for (cell, counts) in expected {
                    let (flag, expected) = (coarser.flag(cell).unwrap(), by_definition(rule, &counts, &n_of));
                    assert_eq!(flag, expected, "{cell:?} of {:?}, axis {axis}, {rule:?}", coarser.dims());
                }
                mesh = coarser;
            }
        }
    }
}

#[test]
fn columns_in_a_store_and_any_number_of_threads_make_the_same_levels() {
    let mesh = stored::mesh(u64::MAX, None);
    let stored = stored::mesh(20_000, Some(Arc::new(MemoryStore::default())));
    assert!(stored.columns.is_spilled());
    for rule in [Levels::Any, Levels::Majority] {
        let coarser = |mesh: &Mesh, threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| at_once(Pyramid::of(mesh, rule).next(mesh, &Control::default())).unwrap())
        };
        let expected = coarser(&mesh, 1);
        assert!(expected == coarser(&stored, 2) && expected == coarser(&mesh, 3));
    }
}

#[test]
fn lines_are_every_second_one_and_names_stay() {
    let mesh = pattern(0, [5, 4, 3], 2);
    let coarser = at_once(Pyramid::of(&mesh, Levels::Any).next(&mesh, &Control::default())).unwrap();
    assert_eq!((coarser.names(), coarser.unit()), (mesh.names(), mesh.unit()));
    let [fine, coarse] = [&mesh, &coarser].map(|mesh| mesh.lines().list(0));
    assert_eq!(coarse, [fine[0], fine[2], fine[4], fine[4] + 2.0 * (fine[1] - fine[0])]);
    let graded = Lines::from_lists([vec![0.0, 1.0, 3.0, 4.0], vec![0.0, 2.0], vec![-1.0, 0.0, 0.5]]).unwrap();
    let doubled = graded.doubled().unwrap();
    assert_eq!([0, 1, 2].map(|axis| doubled.list(axis)), [vec![0.0, 3.0, 4.0], vec![0.0, 2.0], vec![-1.0, 0.5]]);
    let cancelled = Control::default();
    cancelled.cancel.cancel();
    assert_eq!(at_once(Pyramid::of(&mesh, Levels::Any).next(&mesh, &cancelled)).unwrap_err().code(), "cancelled");
}
