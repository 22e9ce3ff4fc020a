//! Points: the flags at places that are no centres of cells.
//!
//! A frame of all facets, and points in its units -> the flag of each.
//!
//! # Theory
//! A point is decided as a cell whose centre it is. Of closed geometries the crossings below it along one axis decide, all in integers. Of one
//! that is open the rays along all three axes decide where they are even and agree; elsewhere the policy of the geometry does: the winding
//! number, or the vote of the rays. See [`crate::open_surfaces::open`]. Of several geometries that hold the point the highest rank wins.
//!
//! # Practice
//! Cells along surfaces (`fill`) are a matter of cells: a point belongs to the inside alone, and a shell holds no point.
//! Cost: 40 to 80 bytes a facet, three times that where a geometry is open; a point 0.1 to 1 microseconds, and where an open geometry leaves it in
//! doubt some 20 ns for each triangle that closes its large holes.

use crate::base::control::Control;
use crate::base::error::{Error, Result};
use crate::base::memory::Memory;
use crate::base::parallel::*;
use crate::grid::closed::Closed;
use crate::grid::frame::{Frame, SnappedFacet};
use crate::grid::lines::Lines;
use crate::input::geometry::{Fill, Geometry, Open};
use crate::input::job::Rule;
use crate::open_surfaces::open::{CapAngles, OpenPart};
use crate::open_surfaces::overlay::{Apart, split};
use crate::stages::inside::{Inside, Kind, is_inside};
use crate::stages::pillars::Pillars;

/// Points that a core decides between two looks for a cancel, and triangles of caps that it looks at for these.
const AT_ONCE: usize = 1 << 12;
const TRIANGLES_AT_ONCE: usize = 1 << 22;
/// Bytes of a facet in its pillars, at most.
const PILLAR_BYTES: u64 = 80;
/// Most distance from the first centre that is told apart: far beyond all facets, which lie within 2^26 units.
const FARTHEST: f64 = (1 << 28) as f64;

/// Geometries that can be asked for the flags at points.
pub struct PointBodies {
    pillars: Pillars,
    /// Of each facet of the pillars.
    rank_of_facet: Vec<u8>,
    /// How each rank is decided.
    kinds: Vec<Kind>,
    open: Vec<OpenBody>,
    flag_of_rank: Vec<u8>,
    rule: Rule,
}

/// A geometry that is not closed.
struct OpenBody {
    rank: u8,
    invert: bool,
    policy: Open,
    along: [Pillars; 3],
    /// What closes its holes.
    closing: Pillars,
    angles: CapAngles,
}

impl PointBodies {
    /// Takes the facets of geometries, of which `closed` is known by position.
    ///
    /// # Errors
    /// `surface-open` where a geometry is open that must not be, or that whole rays of a mesh would decide ([`Open::Parity`]); `memory`; `cancelled`.
    pub async fn new(
        frame: Frame,
        closed: &[Closed],
        rule: Rule,
        (lines, geometries): (&Lines, &[Geometry]),
        (memory, control): (&Memory, &Control),
    ) -> Result<PointBodies> {
        // a shell has no inside, and cells along surfaces are none of it
        let insides: Vec<Geometry> =
            geometries.iter().map(|of| Geometry { fill: Fill::Centre, ..of.clone() }).collect();
        let is_shell = |position: usize| geometries[frame.ranks.geometry_at[position]].shell;
        let is_shell: Vec<bool> = (0..closed.len()).map(is_shell).collect();
        let frame = if is_shell.contains(&true) { frame.with_some(|position| !is_shell[position]) } else { frame };
        let mut n_pillars = 1;
        for (position, &index) in frame.ranks.geometry_at.iter().enumerate() {
            let is_open = !is_shell[position] && !closed[position].by(rule);
            if is_open && geometries[index].open == Open::Parity {
                let message = format!(
                    "geometry \"{}\" is not closed, and open = \"parity\" decides cells by whole rays of the mesh, not points",
                    geometries[index].name
                );
                let hint = "let open = \"winding\" (--open winding) decide it, or close it";
                return Err(Error::new("surface-open", message, hint));
            }
            n_pillars = if is_open { 4 } else { n_pillars };
        }
        memory.take(n_pillars * PILLAR_BYTES * frame.facets.len() as u64, "the facets over and under points")?.keep();
        let flag_of_rank = frame.ranks.flag_of_rank.clone();
        let (frame, parts) = split(frame, closed, (rule, false), (lines, &insides), control).await?;
        let mut kinds = vec![Kind::Cast; flag_of_rank.len()];
        let mut rank_of_facet: Vec<u8> = (0..frame.facets.len()).map(|facet| frame.rank_of_facet(facet)).collect();
        let (mut facets, mut open) = (frame.facets, Vec::new());
        for part in parts {
            let (rank, invert) = (part.rank(), part.inverts());
            match part.into_apart() {
                Apart::Open(part) => {
                    kinds[usize::from(rank)] = Kind::Apart;
                    open.push(OpenBody::new((rank, invert), part, frame.fraction_bits, lines));
                }
                Apart::Inverted(own) => {
                    kinds[usize::from(rank)] = Kind::Inverted;
                    rank_of_facet.extend(vec![rank; own.len()]);
                    facets.extend(own);
                }
                // no geometry has any: all have the fill of centres
                Apart::Along => {}
            }
            control.rest().await?;
        }
        let pillars = Pillars::new(2, &facets);
        Ok(PointBodies { pillars, rank_of_facet, kinds, open, flag_of_rank, rule })
    }

    /// The flags at points, given in units of the snap; in any order, which is that of the flags.
    ///
    /// # Errors
    /// `cancelled`.
    pub async fn flags(&self, points: &[[i32; 3]], control: &Control) -> Result<Vec<u8>> {
        let mut flags = vec![0; points.len()];
        let n_triangles: usize = self.open.iter().map(|body| body.angles.n_triangles()).sum();
        let of_core = (TRIANGLES_AT_ONCE / (1 + n_triangles)).clamp(1, AT_ONCE);
        let n_at_once = of_core * 4 * current_num_threads();
        for (points, flags) in points.chunks(n_at_once).zip(flags.chunks_mut(n_at_once)) {
            let mut pairs: Vec<(&[[i32; 3]], &mut [u8])> =
                points.chunks(of_core).zip(flags.chunks_mut(of_core)).collect();
            on_all_cores(|| {
                pairs.par_iter_mut().for_each(|(points, flags)| {
                    let mut inside = Inside::new(&self.kinds, self.rule);
                    for (point, flag) in points.iter().zip(flags.iter_mut()) {
                        *flag = self.flag(*point, &mut inside);
                    }
                })
            });
            control.rest().await?;
        }
        Ok(flags)
    }

    fn flag(&self, point: [i32; 3], inside: &mut Inside) -> u8 {
        inside.begin(&self.kinds);
        self.pillars.crossings(point, |of| {
            if of.is_below {
                inside.pass(u32::from(self.rank_of_facet[of.facet as usize]) << 1 | u32::from(of.exits), false);
            }
        });
        for body in &self.open {
            if body.holds(point, self.rule) != body.invert {
                inside.flip(usize::from(body.rank));
            }
        }
        inside.flag(&self.flag_of_rank)
    }
}

/// What the ray along an axis says of a point.
#[derive(Clone, Copy)]
struct Said {
    inside: bool,
    /// Whether the whole ray does not leave what it enters.
    odd: bool,
}

impl OpenBody {
    fn new((rank, invert): (u8, bool), part: OpenPart, fraction_bits: u32, lines: &Lines) -> OpenBody {
        let OpenPart { policy, facets, patches, caps, .. } = part;
        let along = [0, 1, 2].map(|axis| Pillars::new(axis, &facets));
        let angles = CapAngles::new(&caps, fraction_bits, lines.smallest());
        let closing: Vec<SnappedFacet> = [patches, caps].concat();
        OpenBody { rank, invert, policy, along, closing: Pillars::new(2, &closing), angles }
    }

    fn holds(&self, point: [i32; 3], rule: Rule) -> bool {
        let said = [0, 1, 2].map(|axis| self.said(axis, point, rule));
        if said.iter().all(|one| !one.odd && one.inside == said[0].inside) {
            return said[0].inside;
        }
        if self.policy == Open::Vote {
            // the majority of the even rays
            let n_inside = said.iter().filter(|one| one.inside && !one.odd).count();
            let n_outside = said.iter().filter(|one| !one.inside && !one.odd).count();
            return n_inside > n_outside;
        }
        let mut winding = 0;
        for pillars in [&self.along[2], &self.closing] {
            pillars.crossings(point, |of| {
                winding += if of.is_below { 1 - 2 * i32::from(of.exits) } else { 0 };
            });
        }
        is_inside(rule, winding + self.angles.shift_at(point))
    }

    fn said(&self, axis: usize, point: [i32; 3], rule: Rule) -> Said {
        let (mut below, mut all) = (0, 0);
        self.along[axis].crossings(point, |of| {
            let by = match rule {
                Rule::Parity => 1,
                Rule::Nonzero => 1 - 2 * i32::from(of.exits),
            };
            all += by;
            below += if of.is_below { by } else { 0 };
        });
        Said { inside: is_inside(rule, below), odd: is_inside(rule, all) }
    }
}

/// A coordinate in units of the snap that is beyond all facets where the number is.
pub fn within_reach(units: f64) -> f64 {
    units.clamp(-FARTHEST, FARTHEST)
}
