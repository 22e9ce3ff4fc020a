//! Walks along rays from cell to cell, and along a link from crossing to crossing.

use super::Link;
use super::field::Field;
use super::sheared::Sheared;
use hexcast_core::base::error::Result;
use hexcast_core::base::sort::sort_by;
use hexcast_core::stages::crossings::Crossings;
use hexcast_core::stages::facet::Projected;
use hexcast_core::stages::inside::{Inside, Kind};

pub(super) struct Walk<'a> {
    pub(super) field: &'a Field<'a>,
    pub(super) sheared: &'a Sheared<'a>,
    pub(super) is_fluid: &'a [bool; 256],
    /// Of links along the rays, and against them.
    pub(super) directions: [u8; 2],
}

/// A crossing of a link: `below + rest / area` units above the centre of the lower cell.
#[derive(Clone, Copy)]
struct Hit {
    event: u32,
    facet: u32,
    below: i64,
    rest: i64,
    area: i64,
}

impl Hit {
    fn rank(&self) -> u8 {
        (self.event >> 1 & 0xff) as u8
    }

    fn cmp_place(&self, other: &Hit) -> std::cmp::Ordering {
        let product = |rest: i64, area: i64| i128::from(rest) * i128::from(area);
        self.below.cmp(&other.below).then_with(|| product(self.rest, other.area).cmp(&product(other.rest, self.area)))
    }

    /// Whether it lies before the middle of a link of so many units, as seen from either end.
    fn is_before_middle(&self, span: i64, is_backward: bool) -> bool {
        let area = i128::from(self.area);
        let twice = 2 * (i128::from(self.below) * area + i128::from(self.rest));
        let whole = i128::from(span) * area;
        if is_backward { twice > whole } else { twice < whole }
    }

    /// Fraction of a link of so many units up to here, from either end.
    fn q(&self, span: i64, is_backward: bool) -> f32 {
        let area = i128::from(self.area);
        let from_low = i128::from(self.below) * area + i128::from(self.rest);
        let whole = i128::from(span) * area;
        let fraction = if is_backward { whole - from_low } else { from_low };
        // both to f64, and the division: 2^-53 each; of 64 bits that is fast
        let number = |of: i128| i64::try_from(of).map_or(of as f64, |of| of as f64);
        ((number(fraction) / number(whole)) as f32).max(f32::MIN_POSITIVE)
    }
}

/// A crossing of the half of a link that lies before a periodic side, in the order from its cell to the side.
pub(super) struct HalfHit {
    /// Fraction of the link from its cell, and from the other end.
    pub(super) q: [f32; 2],
    pub(super) facet: i32,
    pub(super) geometry: i16,
    /// Flag behind it.
    pub(super) flag: u8,
}

/// What a ray meets between the centre of a cell and that of the next.
pub(super) struct Between<'w> {
    pub(super) across: [u32; 2],
    pub(super) above: u32,
    /// Crossings, and their facets in the sheared frame.
    pub(super) events: &'w [[u32; 2]],
    pub(super) before: &'w Inside,
    pub(super) after: &'w Inside,
    pub(super) starts: &'w [usize],
}

/// One of the two links between two neighbouring cells of a ray.
struct Ends {
    /// None where no link is wanted from there.
    from: Option<[u32; 3]>,
    flag: u8,
    to_flag: u8,
    is_backward: bool,
}

/// What is used again from link to link.
pub(super) struct Scratch {
    hits: Vec<Hit>,
    inside: Inside,
    /// Facets by the low bits of their index: rays beside each other meet the same.
    projected: Vec<Option<(u32, Projected)>>,
}

/// Facets that are kept: those of some rows of rays.
const KEPT: usize = 1024;

impl Scratch {
    pub(super) fn new(inside: &Inside) -> Scratch {
        Scratch { hits: Vec::new(), inside: inside.clone(), projected: vec![None; KEPT] }
    }
}

impl Walk<'_> {
    /// Calls `visit` with what lies between every two cells of consecutive rays, where a ray meets a surface there.
    fn for_each(
        &self,
        crossings: &Crossings,
        mut visit: impl FnMut(Between<'_>, &mut Scratch) -> Result<()>,
    ) -> Result<()> {
        let mut events = Vec::new();
        let kinds = self.field.kinds;
        let mut inside = Inside::new(kinds, self.field.rule);
        let mut before = inside.clone();
        let mut scratch = Scratch::new(&inside);
        let starts = self.starts();
        let n_across = u64::from(self.sheared.rays.counts[0]);
        for (ray, ends) in (crossings.first_ray..).zip(crossings.offsets.windows(2)) {
            let of_ray = ends[0] as usize..ends[1] as usize;
            if of_ray.is_empty() {
                continue;
            }
            events.clear();
            events.extend(of_ray.map(|at| [crossings.events[at], crossings.facets[at]]));
            events.sort_unstable();
            inside.begin(kinds);
            let across = [(ray % n_across) as u32, (ray / n_across) as u32];
            for of_link in events.chunk_by(|one, other| one[0] >> 9 == other[0] >> 9) {
                before.clone_from(&inside);
                for [event, _] in of_link {
                    if self.kind(*event) != Kind::Apart {
                        inside.pass(*event, false);
                    }
                }
                let above = of_link[0][0] >> 9;
                let (before, after, starts) = (&before, &inside, &starts[..]);
                visit(Between { across, above, events: of_link, before, after, starts }, &mut scratch)?;
            }
        }
        Ok(())
    }

    /// The first facet of each position in the box's own frame.
    pub(super) fn starts(&self) -> Vec<usize> {
        let frame = self.field.frame;
        (0..frame.ranks.rank_at.len()).map(|position| frame.range_at(position).start).collect()
    }

    pub(super) fn kind(&self, event: u32) -> Kind {
        self.field.kinds[(event >> 1 & 0xff) as usize]
    }

    /// The links between a cell of a ray and the next: along the ray, and against it.
    pub(super) fn links_between(
        &self,
        between: Between<'_>,
        scratch: &mut Scratch,
        links: &mut [Vec<Link>; 2],
    ) -> Result<()> {
        let Between { across, above, before, after, starts, .. } = between;
        if above == 0 || above >= self.sheared.rays.depth {
            return Ok(());
        }
        let cells = [above - 1, above].map(|along| self.sheared.cell(across, along));
        let [Some(low), Some(high)] = cells else { return Ok(()) };
        let (of_low, of_high) = (self.field.window.place(low), self.field.window.place(high));
        if of_low.is_none() && of_high.is_none() {
            return Ok(());
        }
        let flag_of_rank = &self.field.frame.ranks.flag_of_rank;
        let flag = |inside: &Inside, cell: [u32; 3]| match self.field.is_plain {
            true => Ok(inside.flag(flag_of_rank)),
            false => self.field.flag(cell),
        };
        let (low_flag, high_flag) = (flag(before, low)?, flag(after, high)?);
        let is_fluid = |flag: u8| self.is_fluid[usize::from(flag)];
        // a single crossing between two cells of the fluid is that of a surface inside of it, or of a sheet
        if !is_fluid(low_flag) && !is_fluid(high_flag) {
            return Ok(());
        }
        self.put_hits(&between, scratch);
        let Scratch { hits, inside, .. } = scratch;
        let along = Ends { from: of_low, flag: low_flag, to_flag: high_flag, is_backward: false };
        let against = Ends { from: of_high, flag: high_flag, to_flag: low_flag, is_backward: true };
        for (ends, start) in [(along, before), (against, after)] {
            let Some(cell) = ends.from.filter(|_| is_fluid(ends.flag)) else { continue };
            if ends.is_backward {
                hits.reverse();
            }
            inside.clone_from(start);
            let Some(hit) = self.wall(&ends, inside, hits) else { continue };
            let (facet, geometry) = self.field.facet_of_geometry(self.sheared.index(hit.facet), starts);
            links[usize::from(ends.is_backward)].push(Link {
                cell,
                q: hit.q(self.span(above), ends.is_backward),
                facet,
                geometry,
                direction: self.directions[usize::from(ends.is_backward)],
                flag: ends.to_flag,
            });
        }
        Ok(())
    }

    /// The crossings between two cells, in the order of their places.
    fn put_hits(&self, between: &Between<'_>, scratch: &mut Scratch) {
        let Scratch { hits, projected, .. } = scratch;
        hits.clear();
        hits.extend(between.events.iter().map(|event| self.hit(*event, between.across, between.above - 1, projected)));
        sort_by(hits, |one, other| one.cmp_place(other).then(one.facet.cmp(&other.facet)).is_lt());
    }

    /// The halves of links on consecutive rays that lead from a cell to a side: of those cells for which `half_of` says so, by the two cells of the
    /// link, the key of the half and whether its cell is the second. The key and the crossings of each.
    pub(super) fn halves(
        &self,
        crossings: &Crossings,
        half_of: impl Fn([[u32; 3]; 2]) -> Option<(u64, [u32; 3], bool)>,
    ) -> Result<Vec<(u64, Vec<HalfHit>)>> {
        let mut halves = Vec::new();
        self.for_each(crossings, |between, scratch| {
            let Between { across, above, before, after, starts, .. } = between;
            if above == 0 || above >= self.sheared.rays.depth {
                return Ok(());
            }
            let cells = [above - 1, above].map(|along| self.sheared.cell(across, along));
            let [Some(low), Some(high)] = cells else { return Ok(()) };
            let Some((key, cell, is_backward)) = half_of([low, high]) else { return Ok(()) };
            self.put_hits(&between, scratch);
            let Scratch { hits, inside, .. } = scratch;
            inside.clone_from(if is_backward { after } else { before });
            let flag_of_rank = &self.field.frame.ranks.flag_of_rank;
            let flag = if self.field.is_plain { inside.flag(flag_of_rank) } else { self.field.flag(cell)? };
            if is_backward {
                hits.reverse();
            }
            let span = self.span(above);
            hits.retain(|hit| hit.is_before_middle(span, is_backward));
            self.field.begin(inside, flag);
            let mut of_half = Vec::with_capacity(hits.len());
            for at_once in hits.chunk_by(|one, other| one.cmp_place(other).is_eq()) {
                let hit = self.pass(at_once, inside, is_backward);
                let (facet, geometry) = self.field.facet_of_geometry(self.sheared.index(hit.facet), starts);
                let q = [hit.q(span, is_backward), hit.q(span, !is_backward)];
                of_half.push(HalfHit { q, facet, geometry, flag: inside.flag(flag_of_rank) });
            }
            halves.push((key, of_half));
            Ok(())
        })?;
        Ok(halves)
    }

    /// Passes crossings at one place, and returns that of the geometry which begins there, else of that which ends.
    fn pass<'h>(&self, at_once: &'h [Hit], inside: &mut Inside, is_backward: bool) -> &'h Hit {
        let held_by = inside.winner();
        for hit in at_once {
            if self.kind(hit.event) == Kind::Apart {
                inside.flip(hit.rank().into());
            } else {
                inside.pass(hit.event, is_backward);
            }
        }
        let of = |rank: Option<u8>| at_once.iter().find(|hit| Some(hit.rank()) == rank);
        of(inside.winner()).or_else(|| of(held_by)).unwrap_or(&at_once[0])
    }

    /// Units from the centre of a cell to that of the one before.
    fn span(&self, above: u32) -> i64 {
        let (frame, axis) = (&self.sheared.frame, self.sheared.rays.axis);
        i64::from(frame.centre(axis, above)) - i64::from(frame.centre(axis, above - 1))
    }

    fn hit(&self, [event, facet]: [u32; 2], across: [u32; 2], low: u32, kept: &mut [Option<(u32, Projected)>]) -> Hit {
        let (frame, rays) = (&*self.sheared.frame, &self.sheared.rays);
        let kept = &mut kept[facet as usize % KEPT];
        if kept.is_none_or(|(of, _)| of != facet) {
            *kept = Projected::new(&frame.facets[facet as usize], frame, rays).map(|projected| (facet, projected));
        }
        let Some((_, projected)) = kept else { unreachable!("facet {facet} has no crossing") };
        let area = i128::from(projected.area);
        let height = projected.height_at(across, frame, rays) - i128::from(frame.centre(rays.axis, low)) * area;
        // the crossing is less than a cell above the centre: so is its height, over the area, as a rule in 64 bits
        let (below, rest) = match i64::try_from(height) {
            Ok(height) => (height.div_euclid(projected.area), height.rem_euclid(projected.area)),
            Err(_) => (height.div_euclid(area) as i64, height.rem_euclid(area) as i64),
        };
        Hit { event, facet, below, rest, area: projected.area }
    }

    /// The first crossing, in the order of a walk, behind which the flag is none of the fluid.
    fn wall<'h>(&self, ends: &Ends, inside: &mut Inside, hits: &'h [Hit]) -> Option<&'h Hit> {
        let flag_of_rank = &self.field.frame.ranks.flag_of_rank;
        self.field.begin(inside, ends.flag);
        for at_once in hits.chunk_by(|one, other| one.cmp_place(other).is_eq()) {
            let hit = self.pass(at_once, inside, ends.is_backward);
            if !self.is_fluid[usize::from(inside.flag(flag_of_rank))] {
                return Some(hit);
            }
        }
        None
    }
}
