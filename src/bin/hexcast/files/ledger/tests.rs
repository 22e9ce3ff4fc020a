use std::fs::{hard_link, write};
use std::os::unix::fs::symlink;

use super::*;

fn entry(path: &Path, used: Use) -> Entry {
    Entry { path: path.into(), place: place_of(path), id: path.metadata().ok().as_ref().and_then(id_of), used }
}

#[test]
fn every_name_of_a_file_is_that_file() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::create_dir(at("inner")).unwrap();
    write(at("model.stl"), "model").unwrap();
    hard_link(at("model.stl"), at("hard.stl")).unwrap();
    symlink("model.stl", at("soft.stl")).unwrap();
    symlink(folder.path(), at("inner/back")).unwrap();
    let names = ["model.stl", "./model.stl", "inner/../model.stl", "hard.stl", "soft.stl", "inner/back/hard.stl"];
    for one in names {
        for other in names {
            for (first, second) in [(Use::Read, Use::Write), (Use::Write, Use::Read), (Use::Write, Use::Write)] {
                let mut ledger = Ledger::default();
                ledger.enter(entry(&at(one), first)).unwrap();
                let error = ledger.enter(entry(&at(other), second)).unwrap_err();
                assert_eq!(error.code(), "job-conflict", "{one} {first:?}, {other} {second:?}");
            }
            let mut ledger = Ledger::default();
            assert_eq!([one, other].map(|name| ledger.enter(entry(&at(name), Use::Read))), [Ok(0), Ok(0)]);
        }
        let mut ledger = Ledger::default();
        ledger.enter(entry(&at(one), Use::Read)).unwrap();
        ledger.enter(entry(&at("other.stl"), Use::Write)).unwrap();
        assert!(ledger.enter(entry(folder.path(), Use::Replace)).unwrap_err().to_string().contains("is replaced"));
    }
}

#[test]
fn outputs_that_are_not_there_yet_are_known_by_where_they_will_be() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    symlink(folder.path(), at("back")).unwrap();
    let mut ledger = Ledger::default();
    ledger.enter(entry(&at("new.raw"), Use::Write)).unwrap();
    assert!(ledger.enter(entry(&at("back/new.raw"), Use::Write)).unwrap_err().to_string().contains("written twice"));
    assert!(ledger.enter(entry(&at("back/new.raw"), Use::Read)).unwrap_err().to_string().contains("an input too"));
    ledger.enter(entry(&at("new.zarr"), Use::Replace)).unwrap();
    assert!(ledger.enter(entry(&at("back/new.zarr/report.json"), Use::Write)).is_err());
    assert!(ledger.enter(entry(&at("new.zarr.zip"), Use::Write)).is_ok());
}

#[test]
fn a_name_is_looked_at_again_before_a_file_gets_it() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    write(at("model.stl"), "model").unwrap();
    let mut ledger = Ledger::default();
    ledger.enter(entry(&at("model.stl"), Use::Read)).unwrap();
    let [one, other] = ["one.raw", "other.raw"].map(|name| ledger.enter(entry(&at(name), Use::Write)).unwrap());
    // somebody makes a link while the mesh is made
    hard_link(at("model.stl"), at("one.raw")).unwrap();
    assert!(ledger.check_again(one).unwrap_err().to_string().contains("an input too"));
    std::fs::remove_file(at("one.raw")).unwrap();
    assert_eq!(ledger.check_again(one), Ok(()));
    write(at("one.raw"), "cells").unwrap();
    ledger.note(one);
    symlink("one.raw", at("other.raw")).unwrap();
    assert!(ledger.check_again(other).unwrap_err().to_string().contains("written twice"));
    assert_eq!(ledger.check_again(one), Ok(()));
}
