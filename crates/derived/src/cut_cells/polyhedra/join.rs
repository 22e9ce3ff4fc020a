//! Small bodies are joined with what is behind their largest face, and the rest gets its numbers; where that makes cells of a wrong shape, others are joined.
//!
//! Bodies, faces -> [`Polyhedra`]. Bodies are looked at in their order, until none is small that has another beside it. Those without a volume, as where a body lies in lines of the mesh, are left out: what is beside
//! them ends there. Faces within a cell vanish, those of a cell that lead to the same become one
//! (`merge.rs`), and points that no face has then are left out.
//!
//! Where cells are wrong (`quality.rs`), one body of each takes the next of its ways: faces that are not merged, the second or third of its neighbours, to be by itself. That is tried some times,
//! and the mesh with the fewest wrong cells is taken.

use std::collections::{HashMap, HashSet};

use super::build::{Build, NONE};
use super::closed::{Behind, Counts, Face, Polyhedra};
use super::{merge, planar, quality};
use hexcast_core::base::control::Control;
use hexcast_core::base::error::Result;

/// A body of less of its cell is joined with another.
pub const LEAST: f64 = 0.3;

/// A body of less of its cell has no volume.
const NOTHING: f64 = 1e-9;
/// Meshes that are made at most where cells are wrong.
const TRIALS: usize = 40;
/// As many in a row that have no fewer wrong cells are the last.
const PATIENCE: usize = 12;
/// Cosines of the angle between faces that become one: on the surface, and between cells.
const TURNED: f64 = 0.5;
const FLAT: f64 = 1.0 - 1e-9;

/// What becomes of a body.
#[derive(Clone, Copy, Default)]
struct Way {
    /// Which of its neighbours it is joined with, by the areas of the faces to them; None for none.
    joins: Option<usize>,
    /// Whether the faces of its cell stay as they are.
    stays: bool,
}

impl Way {
    /// A number of ways of a body, in turn.
    fn new(number: usize, is_small: bool) -> Way {
        let way = |joins: Option<usize>, stays: bool| Way { joins, stays };
        let ways = if is_small {
            [
                way(Some(0), false),
                way(Some(0), true),
                way(Some(1), false),
                way(None, false),
                way(Some(2), false),
                way(None, true),
            ]
        } else {
            [
                way(None, false),
                way(None, true),
                way(Some(0), false),
                way(Some(1), false),
                way(Some(2), false),
                way(Some(0), true),
            ]
        };
        ways[number % ways.len()]
    }
}

/// Bodies that are one cell: each names another of the same, the first itself.
struct Groups(Vec<u32>);

impl Groups {
    fn of(&mut self, body: u32) -> u32 {
        let mut body = body;
        while self.0[body as usize] != body {
            self.0[body as usize] = self.0[self.0[body as usize] as usize];
            body = self.0[body as usize];
        }
        body
    }
}

/// How often bodies took the next of their ways, by cell and by their place in it.
pub(super) type Ways = HashMap<(u64, u32), usize>;

/// A mesh, and the cells of the lines with bodies in its wrong cells.
pub(super) struct Trial {
    pub(super) found: Polyhedra,
    pub(super) cells: Vec<[u32; 3]>,
    pub(super) ways: Ways,
}

impl Build<'_> {
    /// Makes all cells, and joins small bodies in given ways.
    ///
    /// # Errors
    /// `export-too-large`; `cancelled`.
    pub(super) async fn made(mut self, ways: &Ways, control: &Control) -> Result<Trial> {
        self.add_all(control).await?;
        let of =
            |(cell, place): &(u64, u32)| Some(self.first[*cell as usize]).filter(|&at| at != NONE).map(|at| at + place);
        let ways = ways.iter().filter_map(|(body, n)| of(body).map(|body| (body, *n))).collect();
        Ok(self.tried(&self.volumes(), &ways).0)
    }

    /// The mesh in which some bodies go other ways than the first, of each body its cell, and wrong cells, in order: those that have bodies which are seen whole.
    fn tried(&self, volumes: &[f64], ways: &HashMap<u32, usize>) -> (Trial, Vec<u32>, Vec<u32>) {
        let (found, cell_of) = self.trial(volumes, ways);
        let mut wrong = quality::wrong(&found);
        let core = self.bodies.iter().zip(&cell_of).filter(|(body, _)| self.is_core(body)).map(|(_, cell)| *cell);
        let core: HashSet<u32> = core.collect();
        wrong.retain(|cell| core.contains(cell));
        let counts = Counts { wrong: wrong.len() as u32, ..found.counts };
        let is_wrong: HashSet<u32> = wrong.iter().copied().collect();
        let bodies = self.bodies.iter().zip(&cell_of).filter(|(_, cell)| is_wrong.contains(cell));
        let cells = bodies.map(|(body, _)| body.cell).collect();
        let key = |body: u32| {
            let cell = self.index(self.bodies[body as usize].cell);
            (cell as u64, body - self.first[cell])
        };
        let ways = ways.iter().map(|(body, n)| (key(*body), *n)).collect();
        (Trial { found: Polyhedra { counts, ..found }, cells, ways }, cell_of, wrong)
    }

    /// Joins small bodies, in ways that make few cells wrong.
    ///
    /// # Errors
    /// `cancelled`.
    pub(super) async fn joined(&self, control: &Control) -> Result<Trial> {
        let volumes = self.volumes();
        let mut ways: HashMap<u32, usize> = HashMap::new();
        let (mut best, mut since): (Option<Trial>, usize) = (None, 0);
        for trial in 0..TRIALS {
            control.rest().await?;
            let (tried, cell_of, wrong) = self.tried(&volumes, &ways);
            since += 1;
            if best.as_ref().is_none_or(|best| wrong.len() < best.found.counts.wrong as usize) {
                (best, since) = (Some(tried), 0);
            }
            if wrong.is_empty() || since >= PATIENCE {
                break;
            }
            // one body of each wrong cell, another each time
            let mut of_cells: HashMap<u32, Vec<u32>> = wrong.iter().map(|&cell| (cell, Vec::new())).collect();
            for (body, cell) in (0..).zip(&cell_of) {
                if let Some(bodies) = of_cells.get_mut(cell).filter(|_| self.is_cut(body)) {
                    bodies.push(body);
                }
            }
            for bodies in of_cells.values().filter(|bodies| !bodies.is_empty()) {
                *ways.entry(bodies[trial % bodies.len()]).or_default() += 1;
            }
        }
        Ok(best.unwrap_or_else(|| self.tried(&volumes, &HashMap::new()).0))
    }

    /// Whether a body is that of a cell of the outline.
    fn is_cut(&self, body: u32) -> bool {
        self.cut[self.index(self.bodies[body as usize].cell)] != NONE
    }

    /// The mesh in which some bodies go other ways than the first; and of each body its cell.
    fn trial(&self, volumes: &[f64], ways: &HashMap<u32, usize>) -> (Polyhedra, Vec<u32>) {
        let mut volumes = volumes.to_vec();
        let way_of = |body: u32, volumes: &[f64]| {
            Way::new(ways.get(&body).copied().unwrap_or(0), volumes[body as usize] < LEAST)
        };
        let own = volumes.clone();
        let mut counts = Counts::default();
        let mut groups = Groups((0..self.bodies.len() as u32).collect());
        let has_volume = |body: u32| own[body as usize] > NOTHING;
        let is_joined = |body: u32| has_volume(body) && way_of(body, &own).joins.is_some();
        let mut faces_of = self.faces_of(is_joined, has_volume);
        let mut left: Vec<u32> = faces_of.keys().copied().collect();
        left.sort_unstable();
        while !left.is_empty() {
            let mut again = Vec::new();
            for &body in &left {
                // what was joined to a larger one is not looked at again
                let is_asked = ways.contains_key(&body) && volumes[body as usize] == own[body as usize];
                if groups.of(body) != body || volumes[body as usize] >= LEAST && !is_asked {
                    continue;
                }
                let rank = way_of(body, &own).joins.unwrap_or(0);
                let Some(other) = self.behind(body, rank, &faces_of, &mut groups) else { continue };
                counts.joined += 1;
                let more = faces_of.remove(&body).unwrap_or_default();
                groups.0[body as usize] = other;
                volumes[other as usize] += volumes[body as usize];
                if let Some(all) = faces_of.get_mut(&other) {
                    all.extend(more);
                    again.push(other);
                }
            }
            again.sort_unstable();
            again.dedup();
            left = again;
        }
        let mut stays: HashSet<u32> =
            ways.keys().filter(|&&body| way_of(body, &own).stays).map(|&body| groups.of(body)).collect();
        let (found, cell_of) = self.numbered(&volumes, (&mut groups, &stays), counts);
        // merged faces may have taken the volume of a flat cell
        let (of_cells, mut whole) = (found.volumes(), vec![0.0; found.n_cells as usize]);
        for (body, &cell) in (0..).zip(&cell_of).filter(|(_, cell)| **cell != NONE) {
            whole[cell as usize] += own[body as usize] * self.cell_volume(body);
        }
        let has_lost = |cell: u32| cell != NONE && of_cells[cell as usize].0 < 0.5 * whole[cell as usize];
        let flat: Vec<u32> = (0..).zip(&cell_of).filter(|(_, cell)| has_lost(**cell)).map(|(body, _)| body).collect();
        if flat.is_empty() {
            return (found, cell_of);
        }
        stays.extend(flat.into_iter().map(|body| groups.of(body)));
        self.numbered(&volumes, (&mut groups, &stays), counts)
    }

    fn cell_volume(&self, body: u32) -> f64 {
        (0..3).map(|axis| self.size(self.bodies[body as usize].cell, axis)).product()
    }

    /// The volume of each body, in cells.
    fn volumes(&self) -> Vec<f64> {
        let mut volumes = vec![0.0; self.bodies.len()];
        for face in &self.faces {
            let corners = &self.corners[face.start as usize..][..face.n as usize];
            let mut add = |body: u32, sign: f64| {
                let low = self.bodies[body as usize].cell;
                let tip = [0, 1, 2].map(|axis| self.lines[axis][low[axis] as usize]);
                let (volume, _) = planar::cone(corners.iter().map(|&at| self.points[at as usize]), tip);
                volumes[body as usize] += sign * volume;
            };
            add(face.owner, 1.0);
            if let Behind::Cell(other) = face.behind {
                add(other, -1.0);
            }
        }
        (0..).zip(&mut volumes).for_each(|(body, volume)| *volume /= self.cell_volume(body));
        volumes
    }

    /// The faces to others, which have a volume, of all bodies that are joined.
    fn faces_of(&self, is_joined: impl Fn(u32) -> bool, has_volume: impl Fn(u32) -> bool) -> HashMap<u32, Vec<u32>> {
        let joined = (0..self.bodies.len() as u32).filter(|&body| is_joined(body));
        let mut faces_of: HashMap<u32, Vec<u32>> = joined.map(|body| (body, Vec::new())).collect();
        for (index, face) in (0..).zip(&self.faces) {
            let Behind::Cell(other) = face.behind else { continue };
            if !has_volume(face.owner) || !has_volume(other) {
                continue;
            }
            for body in [face.owner, other] {
                if let Some(all) = faces_of.get_mut(&body) {
                    all.push(index);
                }
            }
        }
        faces_of
    }

    /// What is behind the largest face of a body, or behind the next ones, as far as it has some: of its faces to each other one the sum counts.
    fn behind(&self, body: u32, rank: usize, faces_of: &HashMap<u32, Vec<u32>>, groups: &mut Groups) -> Option<u32> {
        let mut areas: Vec<(u32, f64)> = Vec::new();
        for &index in faces_of.get(&body)? {
            let face = &self.faces[index as usize];
            let Behind::Cell(other) = face.behind else { continue };
            let [one, other] = [face.owner, other].map(|of| groups.of(of));
            if one == other {
                continue;
            }
            let other = if one == body { other } else { one };
            let corners = &self.corners[face.start as usize..][..face.n as usize];
            let (_, area) = planar::cone(corners.iter().map(|&at| self.points[at as usize]), [0.0; 3]);
            let area = planar::dot(area, area).sqrt();
            match areas.iter_mut().find(|(known, _)| *known == other) {
                Some((_, sum)) => *sum += area,
                None => areas.push((other, area)),
            }
        }
        areas.sort_unstable_by(|one, other| other.1.total_cmp(&one.1).then(one.0.cmp(&other.0)));
        areas.get(rank.min(areas.len().saturating_sub(1))).map(|(other, _)| *other)
    }

    /// Gives cells, faces and points their numbers.
    fn numbered(
        &self,
        volumes: &[f64],
        (groups, stays): (&mut Groups, &HashSet<u32>),
        mut counts: Counts,
    ) -> (Polyhedra, Vec<u32>) {
        let mut numbers = vec![NONE; volumes.len()];
        let (mut n_cells, mut as_they_are) = (0, Vec::new());
        for body in 0..volumes.len() as u32 {
            let group = groups.of(body) as usize;
            if volumes[group] <= NOTHING {
                counts.empty += u32::from(group == body as usize);
            } else if numbers[group] == NONE {
                numbers[group] = n_cells;
                // what is that small may be a loop over a loop, which would become one over itself
                as_they_are.push(stays.contains(&(group as u32)) || volumes[group] < LEAST);
                n_cells += 1;
            }
        }
        let cell_of: Vec<u32> = (0..volumes.len() as u32).map(|body| numbers[groups.of(body) as usize]).collect();
        let kept = self.kept(&cell_of);
        let (mut corners, mut points) = (Vec::with_capacity(self.corners.len()), Vec::with_capacity(self.points.len()));
        let mut place_of = vec![NONE; self.points.len()];
        let mut faces = Vec::with_capacity(kept.len());
        for same in kept.chunk_by(|(one, _), (other, _)| lead_to_same(one, other)) {
            let face = same[0].0;
            let rings = same.iter().map(|(face, is_turned)| {
                let mut ring = self.corners[face.start as usize..][..face.n as usize].to_vec();
                if *is_turned {
                    ring.reverse();
                }
                ring
            });
            let least = if matches!(face.behind, Behind::Surface(..)) { TURNED } else { FLAT };
            let is_merged = same.len() > 1 && !as_they_are[face.owner as usize];
            let rings = if is_merged { merge::merged(rings, &self.points, least) } else { rings.collect() };
            for ring in rings {
                let (start, n) = (corners.len() as u32, ring.len() as u32);
                for at in ring {
                    let place = &mut place_of[at as usize];
                    if *place == NONE {
                        *place = points.len() as u32;
                        points.push(self.points[at as usize]);
                    }
                    corners.push(*place);
                }
                faces.push(Face { start, n, ..face });
            }
        }
        (Polyhedra { points, faces, corners, n_cells, counts }, cell_of)
    }

    /// The faces between cells and around them, in order, and whether their corners are to be turned.
    fn kept(&self, cell_of: &[u32]) -> Vec<(Face, bool)> {
        let mut kept: Vec<(Face, bool)> = Vec::with_capacity(self.faces.len());
        // what is behind the surface of bodies that are left out
        let is_surface = |face: &&Face| matches!(face.behind, Behind::Surface(..) | Behind::Side(..));
        let left_out = self.faces.iter().filter(|face| cell_of[face.owner as usize] == NONE);
        let walls: HashMap<u32, Behind> = left_out.filter(is_surface).map(|face| (face.owner, face.behind)).collect();
        for &face in &self.faces {
            let owner = cell_of[face.owner as usize];
            let behind = match face.behind {
                Behind::Cell(other) if cell_of[other as usize] == NONE => {
                    walls.get(&other).copied().unwrap_or(Behind::Surface(0, 0))
                }
                Behind::Cell(other) => Behind::Cell(cell_of[other as usize]),
                behind => behind,
            };
            match behind {
                Behind::Cell(other) if owner == NONE => {
                    let behind = walls.get(&face.owner).copied().unwrap_or(Behind::Surface(0, 0));
                    kept.push((Face { owner: other, behind, ..face }, true));
                }
                _ if owner == NONE => {}
                Behind::Cell(other) if other == owner => {}
                Behind::Cell(other) if other < owner => {
                    kept.push((Face { owner: other, behind: Behind::Cell(owner), ..face }, true));
                }
                _ => kept.push((Face { owner, behind, ..face }, false)),
            }
        }
        kept.sort_by_key(|(face, _)| match face.behind {
            Behind::Cell(other) => (0, face.owner, other, 0, 0),
            Behind::Side(side, _) => (1, face.owner, side.into(), 0, 0),
            Behind::Surface(flag, wall) => (1, face.owner, NONE, flag, wall),
        });
        kept
    }
}

/// Whether two faces are of one cell and lead to the same.
fn lead_to_same(one: &Face, other: &Face) -> bool {
    let is_same = match (one.behind, other.behind) {
        (Behind::Side(one, _), Behind::Side(other, _)) => one == other,
        (one, other) => one == other,
    };
    one.owner == other.owner && is_same
}
