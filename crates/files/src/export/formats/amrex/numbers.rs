//! The arrays of an embedded boundary as `VisMF` has them: of each grid a line of text, and its numbers, x fastest, component by component.

use super::boundary::Boundary;
use super::grid::{GHOSTS, Grid};
use crate::export::output::{Files, Out};
use hexcast_core::base::control::Control;
use hexcast_core::base::error::Result;

/// What AMReX calls f64 with the least byte first.
const NUMBERS: &str = "((8, (64 11 52 0 1 12 0 1023)),(8, (8 7 6 5 4 3 2 1)))";

/// An array; those of faces and edges have an axis.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Array {
    Volume,
    Centre,
    WallArea,
    WallCentre,
    WallNormal,
    LevelSet,
    Area(usize),
    FaceCentre(usize),
    EdgeCentre(usize),
}

impl Array {
    pub(super) const ALL: [Array; 15] = [
        Array::Volume,
        Array::Centre,
        Array::WallArea,
        Array::WallCentre,
        Array::WallNormal,
        Array::LevelSet,
        Array::Area(0),
        Array::Area(1),
        Array::Area(2),
        Array::FaceCentre(0),
        Array::FaceCentre(1),
        Array::FaceCentre(2),
        Array::EdgeCentre(0),
        Array::EdgeCentre(1),
        Array::EdgeCentre(2),
    ];

    fn name(self) -> String {
        let of_axis = |name: &str, axis: usize| format!("{name}_{}", ["x", "y", "z"][axis]);
        match self {
            Array::Volume => "volfrac".into(),
            Array::Centre => "centroid".into(),
            Array::WallArea => "bndryarea".into(),
            Array::WallCentre => "bndrycent".into(),
            Array::WallNormal => "bndrynorm".into(),
            Array::LevelSet => "levelset".into(),
            Array::Area(axis) => of_axis("areafrac", axis),
            Array::FaceCentre(axis) => of_axis("facecent", axis),
            Array::EdgeCentre(axis) => of_axis("edgecent", axis),
        }
    }

    pub(super) fn head_of(self, folder: &str) -> String {
        format!("{folder}/Level_0/{}_H", self.name())
    }

    pub(super) fn data_of(self, folder: &str) -> String {
        format!("{folder}/Level_0/{}_D_00000", self.name())
    }

    /// Along which axes its places are nodes.
    fn is_nodal(self) -> [bool; 3] {
        [0, 1, 2].map(|axis| match self {
            Array::LevelSet => true,
            Array::Area(across) | Array::FaceCentre(across) => axis == across,
            Array::EdgeCentre(along) => axis != along,
            _ => false,
        })
    }

    fn n_components(self) -> usize {
        match self {
            Array::Centre | Array::WallCentre | Array::WallNormal => 3,
            Array::FaceCentre(_) => 2,
            _ => 1,
        }
    }

    /// The numbers at a place; those that there are no components of are 0.
    fn at(self, boundary: &Boundary, at: [i32; 3]) -> [f64; 3] {
        let one = |number: f64| [number, 0.0, 0.0];
        match self {
            Array::Volume => one(boundary.part(self.is_nodal(), at).of),
            Array::Centre => boundary.part(self.is_nodal(), at).centre,
            Array::WallArea => one(boundary.wall(at).area),
            Array::WallCentre => boundary.wall(at).centre,
            Array::WallNormal => boundary.wall(at).normal,
            Array::LevelSet => one(boundary.level(at)),
            Array::Area(_) => one(boundary.part(self.is_nodal(), at).of),
            Array::FaceCentre(axis) => {
                let [x, y, z] = boundary.part(self.is_nodal(), at).centre;
                [[y, z, 0.0], [x, z, 0.0], [x, y, 0.0]][axis]
            }
            Array::EdgeCentre(axis) => {
                let part = boundary.part(self.is_nodal(), at);
                one(match boundary.ends_in_fluid(axis, at) {
                    [true, true] => 1.0,
                    [false, false] => -1.0,
                    _ => part.centre[axis],
                })
            }
        }
    }
}

/// Writes a list of grids as AMReX does.
pub(super) fn list(out: &mut Out<'_>, grids: &[Grid], is_nodal: [bool; 3]) -> Result<()> {
    out.text(format_args!("({} 0\n", grids.len()))?;
    grids.iter().try_for_each(|grid| out.text(format_args!("{}\n", grid.text(is_nodal))))?;
    out.put(b")\n")
}

/// Writes an array: its numbers, then its head, which has their places and ends.
pub(super) async fn write(
    boundary: &Boundary<'_>,
    grids: &[Grid],
    (array, folder): (Array, &str),
    files: &mut dyn Files,
    control: &Control,
) -> Result<()> {
    let (is_nodal, n) = (array.is_nodal(), array.n_components());
    let (mut starts, mut lows, mut highs) = (Vec::new(), Vec::new(), Vec::new());
    let mut out = Out::create(files, &array.data_of(folder))?;
    let mut start = 0;
    for grid in grids {
        control.rest().await?;
        let grown = grid.grown(GHOSTS);
        let end = [0, 1, 2].map(|axis| grown.high[axis] + i32::from(is_nodal[axis]));
        let mut numbers = [const { Vec::new() }; 3];
        for z in grown.low[2]..=end[2] {
            for y in grown.low[1]..=end[1] {
                for x in grown.low[0]..=end[0] {
                    let found = array.at(boundary, [x, y, z]);
                    numbers.iter_mut().zip(found).for_each(|(list, number)| list.push(number));
                }
            }
        }
        let head = format!("FAB {NUMBERS}{} {n}\n", grown.text(is_nodal));
        out.put(head.as_bytes())?;
        starts.push(start);
        start += (head.len() + 8 * n * numbers[0].len()) as u64;
        let ends = |pick: fn(f64, f64) -> f64| -> Vec<f64> {
            numbers[..n].iter().map(|list| list.iter().copied().reduce(pick).unwrap_or(0.0)).collect()
        };
        lows.push(ends(f64::min));
        highs.push(ends(f64::max));
        for number in numbers[..n].iter().flatten() {
            out.put(&number.to_le_bytes())?;
        }
    }
    out.finish()?;
    let mut out = Out::create(files, &array.head_of(folder))?;
    // of version 1, in several files, as it says
    out.text(format_args!("1\n1\n{n}\n{GHOSTS}\n"))?;
    list(&mut out, grids, is_nodal)?;
    out.text(format_args!("{}\n", grids.len()))?;
    let file = array.name();
    starts.iter().try_for_each(|start| out.text(format_args!("FabOnDisk: {file}_D_00000 {start}\n")))?;
    for ends in [&lows, &highs] {
        out.text(format_args!("\n{},{n}\n", grids.len()))?;
        for of_grid in ends {
            of_grid.iter().try_for_each(|number| out.text(format_args!("{number:e},")))?;
            out.put(b"\n")?;
        }
    }
    out.finish()
}
