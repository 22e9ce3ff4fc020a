use super::*;

/// The file with new bytes at an offset in its end, and the checksum of the end corrected.
fn forged_end(file: &[u8], at: usize, new: &[u8]) -> Vec<u8> {
    let mut file = file.to_vec();
    let tail = file.len() - 16;
    let end = u64::from_le_bytes(file[tail..tail + 8].try_into().unwrap()) as usize;
    file[end + at..end + at + new.len()].copy_from_slice(new);
    let sum = crc32(&file[end..tail - 4]);
    file[tail - 4..tail].copy_from_slice(&sum);
    file
}

#[test]
fn an_end_that_lies_is_an_error() {
    let mesh = mesh_of([3, 1, 300], [vec![run(5, 2), run(200, 0)], vec![], vec![run(4, 3)]].into_iter());
    let file = bytes(&mesh, false);
    assert!(opened(&forged_end(&file, 0, b"")).is_ok());
    let lies: &[(&str, usize, &[u8])] = &[
        ("no pieces", 4, &[0]),
        ("two pieces", 4, &[2]),
        ("2^63 pieces", 11, &[0x80]),
        ("a piece in the head", 12, &[0x59]),
        ("a piece in the end", 12, &[0x90]),
        ("a first ray", 20, &[1]),
        ("more runs than cells", 28, &[0xff; 8]),
        ("more odd rays than rays", 36, &[4]),
        ("three flags", 52, &[3]),
        ("flag 0", 56, &[0]),
        ("flags that do not ascend", 56, &[4]),
        ("more cells than there are", 57, &[0, 4]),
        ("2^64 - 1 cells", 57, &[0xff; 8]),
    ];
    for (name, at, new) in lies {
        assert_eq!(code(&forged_end(&file, *at, new)), "columns-corrupt", "{name}");
    }
}

#[test]
fn files_that_were_written_before_can_be_read() {
    let cases = [
        (&include_bytes!("../../../../../../tests/fixtures/columns.hxc")[..], [7, 12, 12], Some("mm")),
        (&include_bytes!("../../../../../../tests/fixtures/columns_zlib.hxc")[..], [300, 300, 8], None),
    ];
    let hashes = [
        "0fa867ea2335e2158b2be003c2b8be1d7c8df723bafa773c7645187c369b2a85",
        "5e88f34ed199c47e0cd2c66b045cc53d922838583a2de47903c4356d37502972",
    ];
    for ((file, dims, unit), hash) in cases.into_iter().zip(hashes) {
        let mesh = opened(file).unwrap();
        assert_eq!((mesh.dims(), mesh.unit()), (dims, unit));
        assert_eq!(mesh.flags_sha256(&Control::default()).unwrap(), hash);
        assert!(mesh.columns().n_crossings() > 0);
        let again = opened(&bytes(&mesh, true)).unwrap();
        assert_eq!(again, mesh);
        let counts = |mesh: &Mesh| [mesh.columns().n_runs(), mesh.columns().odd_rays(), mesh.columns().n_crossings()];
        assert_eq!(counts(&again), counts(&mesh));
        assert_eq!(again.columns().cells_per_flag(), mesh.columns().cells_per_flag());
        for n in 0..file.len() {
            assert_eq!(code(&file[..n]), "columns-corrupt");
        }
    }
}
