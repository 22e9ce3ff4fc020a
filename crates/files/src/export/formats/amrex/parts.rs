//! What of each cell, face, edge and node of the box, and beyond it, is fluid; and the walls in cells.
//!
//! [`Boundary`] -> [`Part`], [`Wall`].
//!
//! # Theory
//! *Walls*: areas of faces close with the wall's area vector, by Gauss's theorem; the centre of a wall is that of its projection along the vector, of the same sums, with the volume. Both are exact for a flat wall.
//!
//! *Beyond the box* what is at its side goes on: a cell there has what the face at the side has, past an edge of the box what the edge has, past a corner what the node has.
//!
//! Source: AMReX, `AMReX_EB2_3D_C.cpp`: the sums of walls.

use super::boundary::{Boundary, Kind, LEAST, Node, ROUNDING};

/// What is fluid of a cell, face, edge or node: the fraction, and its centre in cells from the middle.
#[derive(Clone, Copy, Default)]
pub(super) struct Part {
    pub(super) of: f64,
    pub(super) centre: [f64; 3],
}

/// The wall in a cell: its area in those of a face, centre in cells from the middle, and normal out of the fluid.
pub(super) struct Wall {
    pub(super) area: f64,
    pub(super) centre: [f64; 3],
    pub(super) normal: [f64; 3],
}

impl Boundary<'_> {
    /// What is fluid of the place that is a node along some axes, and spans a cell along the others.
    pub(super) fn part(&self, is_nodal: [bool; 3], mut at: [i32; 3]) -> Part {
        let mut spans = is_nodal.map(|is| !is);
        for axis in 0..3 {
            let n = self.dims[axis];
            spans[axis] &= (0..n).contains(&at[axis]);
            at[axis] = at[axis].clamp(0, n);
        }
        match spans {
            [true, true, true] => self.cell(at),
            [false, true, true] => self.face(0, at),
            [true, false, true] => self.face(1, at),
            [true, true, false] => self.face(2, at),
            [true, false, false] => self.edge(0, at),
            [false, true, false] => self.edge(1, at),
            [false, false, true] => self.edge(2, at),
            [false, false, false] => Part { of: f64::from(self.is_fluid(at)), centre: [0.0; 3] },
        }
    }

    /// The wall in a cell: of no area, where there is none.
    pub(super) fn wall(&self, at: [i32; 3]) -> Wall {
        let faces = [0, 1, 2].map(|axis| {
            let is_nodal = [0, 1, 2].map(|other| other == axis);
            [0, 1].map(|side| self.part(is_nodal, [0, 1, 2].map(|other| at[other] + i32::from(other == axis) * side)))
        });
        let vector = faces.map(|[low, high]| low.of - high.of);
        let length = norm(vector);
        if length < ROUNDING {
            return Wall { area: 0.0, centre: [-1.0; 3], normal: [0.0; 3] };
        }
        let volume = self.part([false; 3], at).of;
        let centre = [0, 1, 2].map(|axis| {
            let moment = |across: usize| match faces[across] {
                [low, high] if across == axis => volume - 0.5 * (low.of + high.of),
                [low, high] => low.of * low.centre[axis] - high.of * high.centre[axis],
            };
            let sum: f64 = (0..3).map(|across| moment(across) * vector[across]).sum();
            (sum / (length * length)).clamp(-0.5, 0.5)
        });
        let [dx, dy, dz] = self.size;
        let of_faces = [dy * dz, dx * dz, dx * dy];
        let across = [0, 1, 2].map(|axis| vector[axis] * of_faces[axis]);
        let normal = across.map(|of| of / norm(across));
        let area = norm(across) / norm([0, 1, 2].map(|axis| normal[axis] * of_faces[axis]));
        Wall { area, centre, normal }
    }

    /// The level set at a node: negative in the fluid; as large as the way along a line to the wall, at most a cell.
    pub(super) fn level(&self, at: [i32; 3]) -> f64 {
        let at = [0, 1, 2].map(|axis| at[axis].clamp(0, self.dims[axis]));
        let node = self.node(at);
        if node == Node::Shut {
            return 0.0;
        }
        let smallest = self.size.into_iter().fold(f64::INFINITY, f64::min);
        let mut way = smallest;
        for axis in 0..3 {
            for step in [-1, 0] {
                let mut low = at;
                low[axis] += step;
                if (0..self.dims[axis]).contains(&low[axis]) && self.ends_in_fluid(axis, low).iter().any(|is| !is) {
                    let of = self.edge(axis, low).of;
                    way = way.min(self.size[axis] * if node == Node::Fluid { of } else { 1.0 - of });
                }
            }
        }
        // a node in the fluid is below 0
        let way = way.max(smallest * LEAST);
        if node == Node::Fluid { -way } else { way }
    }

    /// Whether both ends of an edge are in the fluid.
    pub(super) fn ends_in_fluid(&self, along: usize, at: [i32; 3]) -> [bool; 2] {
        [0, 1].map(|end| {
            let place = |axis: usize| at[axis] + i32::from(axis == along) * end;
            self.is_fluid([0, 1, 2].map(|axis| place(axis).clamp(0, self.dims[axis])))
        })
    }

    fn cell(&self, at: [i32; 3]) -> Part {
        let index = self.index(at);
        match (self.kinds[index], self.listed(index)) {
            (Kind::Covered, _) => Part::default(),
            (Kind::Cut, Some(listed)) => {
                let centre = self.outline.parts[listed].centre.map(|of| of - 0.5);
                Part { of: self.outline.parts[listed].fraction, centre }
            }
            _ => Part { of: 1.0, centre: [0.0; 3] },
        }
    }

    /// A face across an axis, which counts nodes of that axis.
    pub(super) fn face(&self, across: usize, at: [i32; 3]) -> Part {
        let behind = |side: i32| [0, 1, 2].map(|axis| at[axis] - i32::from(axis == across) * (1 - side));
        let cells = [0, 1].map(|side| {
            let place = behind(side);
            (0..self.dims[across]).contains(&place[across]).then(|| self.index(place))
        });
        let is = |kind: Kind| cells.iter().flatten().any(|&cell| self.kinds[cell] == kind);
        let mut others = (0..3).filter(|&axis| axis != across);
        let axes = [others.next().unwrap_or(0), others.next().unwrap_or(0)];
        let n_fluid = (0..4).filter(|corner| {
            let step = |axis: usize| {
                i32::from(axes[0] == axis && corner & 1 == 1) + i32::from(axes[1] == axis && corner & 2 == 2)
            };
            self.is_fluid([0, 1, 2].map(|axis| at[axis] + step(axis)))
        });
        let whole = Part { of: 1.0, centre: [0.0; 3] };
        match n_fluid.count() {
            0 => return Part::default(),
            _ if is(Kind::Covered) => return Part::default(),
            4 => return whole,
            _ if is(Kind::Whole) => return whole,
            _ => {}
        }
        for (side, cell) in cells.into_iter().enumerate() {
            if let Some(listed) = cell.and_then(|cell| self.listed(cell)) {
                let (face, part) = (2 * across + 1 - side, &self.outline.parts[listed]);
                let mut centre = [0.0; 3];
                axes.iter().zip(part.face_centres[face]).for_each(|(&axis, of)| centre[axis] = of - 0.5);
                return match part.areas[face] {
                    area if area < ROUNDING => Part::default(),
                    area if area > 1.0 - ROUNDING => whole,
                    of => Part { of, centre },
                };
            }
        }
        whole
    }

    /// An edge along an axis, which counts nodes of the others.
    fn edge(&self, along: usize, at: [i32; 3]) -> Part {
        let length = match self.ends_in_fluid(along, at) {
            [true, true] => return Part { of: 1.0, centre: [0.0; 3] },
            [false, false] => return Part::default(),
            [is_low, _] => (is_low, self.length(along, at)),
        };
        let mut centre = [0.0; 3];
        let (is_low, of) = length;
        centre[along] = if is_low { 0.5 * of - 0.5 } else { 0.5 - 0.5 * of };
        Part { of, centre }
    }

    /// The length of an edge in the fluid, as a cut cell at it has it; else all.
    fn length(&self, along: usize, at: [i32; 3]) -> f64 {
        let mut others = (0..3).filter(|&axis| axis != along);
        let axes = [others.next().unwrap_or(0), others.next().unwrap_or(0)];
        for place in 0..4usize {
            let mut cell = at;
            axes.iter().enumerate().for_each(|(bit, &axis)| cell[axis] -= (place >> bit & 1) as i32);
            if (0..3).all(|axis| (0..self.dims[axis]).contains(&cell[axis]))
                && let Some(listed) = self.listed(self.index(cell))
            {
                return self.outline.parts[listed].lengths[4 * along + place];
            }
        }
        1.0
    }
}

fn norm(of: [f64; 3]) -> f64 {
    of.iter().map(|of| of * of).sum::<f64>().sqrt()
}

