//! What tests of several crates use: meshes whose every cell is known.

use hexcast_core::cells::columns::{Columns, Named};
use hexcast_core::grid::lines::Lines;
use hexcast_core::grid::rays::Rays;
use hexcast_core::input::job::Stencil;
pub use hexcast_core::testing::pattern_flag;
use hexcast_core::testing::{band_of, pattern_columns};

use crate::fractions::Fractions;
use crate::links::{Link, Links};
use crate::mesh::Mesh;

/// A mesh whose flags follow a fixed pattern of `n_flags` flags, the same for every ray axis.
pub fn pattern(axis: usize, dims: [u32; 3], n_flags: u32) -> Mesh {
    let lines = Lines::new([-1.5, 0.1, 1e-7], [0.5, 0.25, 1.0 / 3.0], dims).unwrap();
    let names = [(1, "copper"), (7, "Gehäuse <A&B> \"1\"")];
    let names = names.map(|(flag, name)| Named::new(flag, name)).to_vec();
    Mesh::new(lines, pattern_columns(axis, dims, n_flags), names, Some("mm".into())).unwrap()
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
        has_edges: false,
        has_centroids: false,
        sampled_cells: 0,
    }
}

/// A mesh with rays along `axis` whose cells have the flags of a function; lines are sums of powers of two.
pub fn mesh_of(axis: usize, dims: [u32; 3], flag_of: impl Fn([u32; 3]) -> u8) -> Mesh {
    let rays = Rays::new(axis, dims);
    let band = band_of(&rays, flag_of);
    let lines = Lines::new([-1.5, 0.25, 8.0], [0.5, 0.25, 0.125], dims).unwrap();
    Mesh::new(lines, Columns::new(rays, vec![band]).unwrap(), Vec::new(), None).unwrap()
}
