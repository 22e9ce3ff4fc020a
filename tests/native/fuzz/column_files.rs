//! Column files: opening, the report, all runs, and flags.

use hexcast::columns::{Band, Columns, run, run_cell, run_flag};
use hexcast::control::Control;
use hexcast::lines::Lines;
use hexcast::mesh::{Mesh, Named};
use hexcast::report::ColumnsReport;
use hexcast::write::{Compress, Format, Options, write};
use hexcast::{Error, Result, column_file};
use hexcast_core::grid::rays::Rays;

use super::harness::Target;
use super::mutate::Random;
use super::{MAX_MESSAGE, assert_error_is_good, checksums, kind, measured};

/// Memory that is allowed for a file.
const MAX_BYTES: u64 = 1 << 25;
/// Bytes that reading all runs may take for each of a file whose pieces are not compressed, and besides.
const BYTES: [u64; 2] = [64, 256 << 10];
/// Most bytes for any other file: twice what is allowed, as a single ray may take 64 MiB.
const MAX_INFLATED: u64 = 128 << 20;
/// The most cells whose flags are expanded.
const MAX_CELLS: u64 = 1 << 17;

fn opened(bytes: &[u8]) -> Result<Mesh> {
    column_file::read(&mut &bytes[..], MAX_BYTES)
}

/// The cells of every flag, counted from the runs.
fn counted(columns: &Columns) -> Result<([u64; 256], u64)> {
    let (mut cells, mut n_runs, depth) = ([0; 256], 0, columns.rays().depth);
    columns.for_rays(0..columns.rays().n_rays(), |runs| {
        let (mut start, mut flag) = (0, 0);
        for &run in runs {
            assert!(run_flag(run) != flag && run_cell(run) < depth, "a run of flag {} after {flag}", run_flag(run));
            assert!(run_cell(run) > start || (start == 0 && flag == 0), "runs do not ascend");
            cells[usize::from(flag)] += u64::from(run_cell(run) - start);
            (start, flag) = (run_cell(run), run_flag(run));
        }
        cells[usize::from(flag)] += u64::from(depth - start);
        n_runs += runs.len() as u64;
    })?;
    Ok((cells, n_runs))
}

/// Reads a mesh in every way and compares.
fn assert_mesh_agrees(mesh: &Mesh) -> Result<()> {
    let columns = &mesh.columns();
    let (cells, n_runs) = counted(columns)?;
    assert_eq!(n_runs, columns.n_runs());
    assert!(cells == columns.cells_per_flag(), "the totals are not those of the runs");
    assert!(columns.odd_rays() <= columns.rays().n_rays());
    if mesh.n_cells() > MAX_CELLS {
        return Ok(());
    }
    let (mut flags, mut of_slabs) = (Vec::new(), [0; 256]);
    mesh.for_each_slab(1000, &Control::default(), |slab| {
        flags.extend_from_slice(slab);
        slab.iter().for_each(|&flag| of_slabs[usize::from(flag)] += 1);
        Ok(())
    })?;
    assert!(flags.len() as u64 == mesh.n_cells() && of_slabs == cells, "the flags are not those of the runs");
    let [nx, ny, nz] = mesh.dims();
    assert!(mesh.box_flags(&[0..nx, 0..ny, 0..nz])? == flags);
    assert_eq!(mesh.flag([nx - 1, ny - 1, nz - 1])?, flags[flags.len() - 1]);
    Ok(())
}

/// Writes a mesh that was read, and reads it again.
fn assert_reads_back(mesh: &Mesh) -> Result<()> {
    let again = opened(&written(mesh, Compress::None)?)?;
    assert!(again == *mesh && again.columns().cells_per_flag() == mesh.columns().cells_per_flag());
    assert_eq!(again.columns().odd_rays(), mesh.columns().odd_rays());
    assert_eq!(again.columns().n_crossings(), mesh.columns().n_crossings());
    Ok(())
}

fn written(mesh: &Mesh, compress: Compress) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    write(mesh, Format::Columns, &Options::default().with_compress(compress), &mut bytes, &Control::default())?;
    Ok(bytes)
}

/// Checks a file on one thread, whose memory is measured.
fn check(bytes: &[u8]) -> String {
    let (mesh, allocated) = measured(|| -> Result<Mesh> {
        let mesh = opened(bytes)?;
        let report = serde_json::to_string(&ColumnsReport::new(&mesh)).expect("a report has a JSON form");
        assert!(report.len() <= 4 * bytes.len() + 50_000, "a report of {} bytes", report.len());
        mesh.columns().for_rays(0..mesh.columns().rays().n_rays(), |_| ())?;
        Ok(mesh)
    });
    // the byte that says how pieces are compressed, in a head without identity or with one
    let is_plain = [30, 62].iter().all(|&at| bytes.get(at) != Some(&1)) && bytes.get(29) != Some(&1);
    let most = if is_plain { BYTES[0] * bytes.len() as u64 + BYTES[1] } else { MAX_INFLATED };
    assert!(allocated <= most, "{allocated} bytes of memory for {}", bytes.len());
    let good = |error: &Error| {
        assert_error_is_good(error, MAX_MESSAGE, false);
        kind(error)
    };
    let mesh = match mesh {
        Ok(mesh) => mesh,
        Err(error) => return good(&error),
    };
    if let Err(error) = assert_mesh_agrees(&mesh).and_then(|()| assert_reads_back(&mesh)) {
        return format!("later {}", good(&error));
    }
    let runs = mesh.columns().n_runs();
    format!("axis {}, {} runs, {} names", mesh.columns().rays().axis, runs.max(1).ilog2(), mesh.names().len())
}

fn on_one_thread<T: Send>(run: impl FnOnce() -> T + Send) -> T {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    pool.install(run)
}

#[test]
fn column_file() {
    let repair = |bytes: &mut Vec<u8>, random: &mut Random| {
        if random.below(8) > 0 {
            checksums::repair(bytes, random);
        }
    };
    let target = Target {
        name: "columns",
        fixtures: &["columns.hxc"],
        dictionary: &["PIEC", "BAND", "ENDS", "HXC END\n", "\0\0\0\0", "\u{1}\0\0\0"],
        max_bytes: 6 << 10,
        executions: 80_000,
    };
    on_one_thread(|| target.fuzz(repair, check));
}

/// A mesh of some cells with random runs.
fn random_mesh(random: &mut Random) -> Mesh {
    let dims = [1 + random.below(6) as u32, 1 + random.below(6) as u32, 1 + random.below(300) as u32];
    let rays = Rays::new(random.below(3), dims);
    let (mut band, density) = (Band::default(), 1 + random.below(40));
    for _ in 0..rays.n_rays() {
        let mut last = 0;
        for cell in 0..rays.depth {
            let flag = if random.below(density) == 0 { random.below(4) as u8 } else { last };
            if flag != last {
                band.runs.push(run(cell, flag));
            }
            last = flag;
        }
        band.ends.push(band.runs.len() as u32);
    }
    (band.odd_rays, band.n_crossings) = (random.below(2) as u64, random.below(1000) as u64);
    let lines = Lines::new([0.5, -1e-7, 3e5], [0.1, 1.0, 7.5], dims).expect("lines");
    let names = if random.below(2) == 0 { vec![] } else { vec![Named::new(2, "Gehäuse \"1\"")] };
    let unit = (random.below(2) == 0).then(|| "mm".to_string());
    Mesh::new(lines, Columns::new(rays, vec![band]).unwrap(), names, unit).expect("a mesh")
}

/// A checksum or a fixed value covers every byte of a file that was written, so the format promises to refuse it: the head
/// and the end when it is opened, a piece when it is read. A CRC-32 notices every change within 32 consecutive bits.
#[test]
fn a_written_file_with_a_changed_byte_is_refused() {
    let n_rounds = std::env::var("HEXCAST_FUZZ_SECONDS").map_or(60, |_| 1000);
    let seed = std::env::var("HEXCAST_FUZZ_SEED").ok().and_then(|text| text.parse().ok()).unwrap_or(1);
    let mut random = Random::new(seed);
    on_one_thread(|| {
        for round in 0..n_rounds {
            let mesh = random_mesh(&mut random);
            let compress = if random.below(2) == 0 { Compress::None } else { Compress::Zlib(6) };
            let file = written(&mesh, compress).expect("a file");
            assert!(opened(&file).expect("it opens") == mesh, "seed {seed}, round {round}");
            assert_mesh_agrees(&opened(&file).expect("it opens")).expect("it reads");
            for _ in 0..40 {
                let (at, change) = (random.below(file.len()), 1 + random.below(255) as u8);
                let mut changed = file.clone();
                changed[at] ^= change;
                let outcome = opened(&changed).and_then(|mesh| counted(mesh.columns()));
                let error = outcome.err().unwrap_or_else(|| panic!("seed {seed}, round {round}: byte {at} ^ {change}"));
                assert!(["columns-corrupt", "columns-version"].contains(&error.code()), "{error}");
                assert_error_is_good(&error, MAX_MESSAGE, false);
            }
        }
    });
}
