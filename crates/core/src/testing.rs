//! What tests of several crates use: meshes whose every cell is known, and schemas that are held to files.

use serde_json::Value;

use crate::cells::columns::{Band, Columns, Named, run};
use crate::derived::fractions::Fractions;
use crate::derived::links::{Link, Links};
use crate::derived::mesh::Mesh;
use crate::grid::lines::Lines;
use crate::grid::rays::Rays;
use crate::input::job::Stencil;

/// The runs of cells with these flags, one band for all rays.
pub fn band_of(rays: &Rays, flag_of: impl Fn([u32; 3]) -> u8) -> Band {
    let mut band = Band::default();
    for j in 0..rays.counts[1] {
        for i in 0..rays.counts[0] {
            let mut last = 0;
            for along in 0..rays.depth {
                let mut cell = [along; 3];
                (cell[rays.across[0]], cell[rays.across[1]]) = (i, j);
                let flag = flag_of(cell);
                if flag != last {
                    band.runs.push(run(along, flag));
                }
                last = flag;
            }
            band.ends.push(band.runs.len() as u32);
        }
    }
    band
}

/// A mesh whose flags follow a fixed pattern of `n_flags` flags, the same for every ray axis.
pub fn pattern(axis: usize, dims: [u32; 3], n_flags: u32) -> Mesh {
    let rays = Rays::new(axis, dims);
    let band = band_of(&rays, |cell| pattern_flag(cell, n_flags));
    let band = Band { odd_rays: 2, n_crossings: 1234567, ..band };
    let lines = Lines::new([-1.5, 0.1, 1e-7], [0.5, 0.25, 1.0 / 3.0], dims).unwrap();
    let names = [(1, "copper"), (7, "Gehäuse <A&B> \"1\"")];
    let names = names.map(|(flag, name)| Named::new(flag, name)).to_vec();
    Mesh::new(lines, Columns::new(rays, vec![band]).unwrap(), names, Some("mm".into())).unwrap()
}

/// The flag that [`pattern`] gives a cell.
pub fn pattern_flag([x, y, z]: [u32; 3], n_flags: u32) -> u8 {
    let mixed = (x / 3 * 5 + y / 2 * 3 + z / 2 * 7) % 11;
    if mixed < 6 { 0 } else { (1 + mixed % n_flags) as u8 }
}

/// All flags of a [`pattern`], x fastest, straight from the formula.
pub fn pattern_flags([nx, ny, nz]: [u32; 3], n_flags: u32) -> Vec<u8> {
    let cell = |index: u32| [index % nx, index / nx % ny, index / (nx * ny)];
    (0..nx * ny * nz).map(|index| pattern_flag(cell(index), n_flags)).collect()
}

/// The parts of a mesh, which a test may change one by one.
pub struct Parts<'a> {
    /// The lines.
    pub lines: &'a mut Lines,
    /// The runs.
    pub columns: &'a mut Columns,
    /// The names of flags.
    pub names: &'a mut Vec<Named>,
    /// The unit.
    pub unit: &'a mut Option<String>,
}

/// The parts of a mesh, to change them.
pub fn parts(Mesh { lines, columns, names, unit, .. }: &mut Mesh) -> Parts<'_> {
    Parts { lines, columns, names, unit }
}

/// Links by the plane of their cells, of a box.
pub fn links_of(dims: [u32; 3], fluid: Vec<u8>, planes: Vec<Vec<Link>>) -> Links {
    Links { stencil: Stencil::default(), fluid, dims, origin: [0; 3], planes }
}

/// Fractions of a box without cells that are cut, and without a volume of any flag.
pub fn no_fractions(dims: [u32; 3]) -> Fractions {
    Fractions {
        origin: [0; 3],
        halo: 0,
        rays: 4,
        dims,
        parts: Vec::new(),
        planes_of_part: 1,
        volumes: vec![0.0; 256],
        areas: None,
        totals: Default::default(),
        has_faces: false,
    }
}

/// Makes plain text of links to Rust's documentation, in the descriptions of a schema.
pub fn in_plain_text(schema: &mut Value) {
    match schema {
        Value::Object(of) => {
            if let Some(Value::String(text)) = of.get_mut("description") {
                *text = text.replace("[`", "`").replace("`]", "`").replace('\n', " ");
            }
            of.values_mut().for_each(in_plain_text);
        }
        Value::Array(list) => list.iter_mut().for_each(in_plain_text),
        _ => {}
    }
}

/// Holds a schema in `docs/` to that of the types, or writes it where that is asked for.
pub fn assert_schema_is_committed(file: &str, schema: &Value, test: &str) {
    let text = format!("{schema:#}\n");
    if std::env::var_os("HEXCAST_BLESS").is_some() {
        assert!(std::env::var_os("CI").is_none(), "the schema is written by people, who read the difference");
        std::fs::write(file, &text).unwrap();
    }
    let committed = std::fs::read_to_string(file).unwrap_or_default();
    assert_eq!(committed, text, "run HEXCAST_BLESS=1 cargo test --workspace --lib {test}, and read the difference");
}
