//! The case table: which models, on how many cells.

use std::error::Error;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use hexcast::job::AxisChoice;

use crate::spheres::{spheres, write_stl};

/// Where a model comes from.
#[derive(Debug, Clone, Copy)]
enum Origin {
    /// Made by the bench.
    Spheres,
    /// A file of the repository, from its root.
    Fixture(&'static str),
    /// A file of the folder that the caller names; left out where it is missing.
    Model(&'static str),
}

/// A model and the numbers of cells along its longest axis to mesh it with.
struct Row {
    name: &'static str,
    origin: Origin,
    cells: &'static [u32],
}

/// Models 1, 3 and 4 are those of the paper's Table 1, as near as free models come.
const TABLE: &[Row] = &[
    Row { name: "spheres", origin: Origin::Spheres, cells: &[512, 1024] },
    Row { name: "spot", origin: Origin::Fixture("tests/fixtures/spot.stl"), cells: &[512] },
    Row { name: "hubble", origin: Origin::Model("hubble_hst.stl"), cells: &[1024] },
    Row { name: "house", origin: Origin::Model("house.stl"), cells: &[1024] },
    Row { name: "jet", origin: Origin::Model("jet_saab_viggen.stl"), cells: &[1024] },
    Row { name: "bunny", origin: Origin::Model("stanford_bunny.stl"), cells: &[1024] },
];

/// One thing to measure.
#[derive(Debug, Clone)]
pub(crate) struct Case {
    /// Name of the model.
    pub(crate) name: String,
    /// Its file.
    pub(crate) file: PathBuf,
    /// Cells along the longest axis.
    pub(crate) cells: u32,
    /// Along which axis the rays run.
    pub(crate) axis: AxisChoice,
}

/// Lists the cases whose models are there; made models go to `scratch`.
pub(crate) fn cases(scratch: &Path, models: Option<&Path>) -> Result<Vec<Case>, Box<dyn Error>> {
    let mut cases = Vec::new();
    for row in TABLE {
        let file = match row.origin {
            Origin::Spheres => write_spheres(&scratch.join("spheres.stl"))?,
            Origin::Fixture(path) => Path::new(env!("CARGO_MANIFEST_DIR")).join(path),
            Origin::Model(name) => match models.map(|folder| folder.join(name)) {
                Some(path) if path.is_file() => path,
                _ => continue,
            },
        };
        cases.extend(row.cells.iter().map(|&cells| Case {
            name: row.name.into(),
            file: file.clone(),
            cells,
            axis: AxisChoice::Auto,
        }));
    }
    Ok(cases)
}

/// Writes model 4 of the paper.
pub(crate) fn write_spheres(path: &Path) -> Result<PathBuf, Box<dyn Error>> {
    write_stl(&spheres(), &mut BufWriter::new(File::create(path)?))?;
    Ok(path.to_path_buf())
}
