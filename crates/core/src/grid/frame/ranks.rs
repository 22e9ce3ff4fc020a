//! The order in which geometries win.

use crate::input::geometry::{Geometry, Open};

/// Most ranks: a crossing has eight bits for one, and a run for its flag.
pub const MAX_RANKS: usize = 255;

/// Least and greatest coordinates of the facets of a geometry, in units; None without facets.
pub type Ends = Option<[[i32; 3]; 2]>;

/// Geometries in the order in which they win: position 0 loses against all others.
///
/// Sorted by priority, at equal priority by position in the job ("meshed in order": the later wins); once it is known what is closed, the rest
/// comes before it. Crossings know a geometry by
/// its rank, which is its position. Of more than [`MAX_RANKS`] geometries several have one rank: they are closed and have the same flag, and
/// their boxes lie apart, so that a ray has left one of them where it enters the next.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Ranks {
    /// Index in the job of the geometry at each position.
    pub geometry_at: Vec<usize>,
    /// Rank of the geometry at each position.
    pub rank_at: Vec<u8>,
    /// Property flag of each rank.
    pub flag_of_rank: Vec<u8>,
}

impl Ranks {
    /// Puts geometries in order. More than [`MAX_RANKS`] have no ranks until [`Ranks::share`] gives them some.
    pub fn new(geometries: &[Geometry]) -> Ranks {
        let mut geometry_at: Vec<usize> = (0..geometries.len()).collect();
        // stable: at equal priority the later wins
        geometry_at.sort_by_key(|&index| geometries[index].priority);
        Ranks::of(geometry_at, geometries)
    }

    /// Moves to each position the geometry that was at another.
    pub(crate) fn put_in_order(&mut self, positions: &[usize], geometries: &[Geometry]) {
        *self = Ranks::of(positions.iter().map(|&position| self.geometry_at[position]).collect(), geometries);
    }

    fn of(geometry_at: Vec<usize>, geometries: &[Geometry]) -> Ranks {
        if geometries.len() > MAX_RANKS {
            return Ranks { geometry_at, rank_at: Vec::new(), flag_of_rank: Vec::new() };
        }
        let flag_of_rank = geometry_at.iter().map(|&index| geometries[index].flag).collect();
        Ranks { geometry_at, rank_at: (0..geometries.len()).map(|at| at as u8).collect(), flag_of_rank }
    }

    /// One geometry with the flag 1.
    pub fn of_one() -> Ranks {
        Ranks { geometry_at: vec![0], rank_at: vec![0], flag_of_rank: vec![1] }
    }

    /// Whether the rank of each geometry is its position.
    pub fn are_positions(&self) -> bool {
        self.rank_at.len() == self.flag_of_rank.len()
    }

    /// Gives geometries that have no ranks the lowest that keep their order; `ends` and `is_closed` are known of each position. Fails with the position
    /// of the first geometry for which no rank is left.
    ///
    /// A rank is higher than those of all geometries below whose boxes meet its own and that have another flag, and differs from those that have the
    /// same. What is not closed, and cells along surfaces, may lie beyond
    /// their boxes: such a geometry shares its rank with none, and meets all.
    ///
    /// Cost: the square of their number, some nanoseconds a pair.
    pub(crate) fn share(
        &mut self,
        geometries: &[Geometry],
        ends: &[Ends],
        is_closed: impl Fn(usize) -> bool,
    ) -> Result<(), usize> {
        if self.rank_at.len() == geometries.len() {
            return Ok(());
        }
        let everywhere = Some([[i32::MIN; 3], [i32::MAX; 3]]);
        let (mut ranks, mut boxes): (Vec<usize>, Vec<Ends>) = (Vec::new(), Vec::new());
        // the flag of each rank that is shared
        let mut flags: Vec<Option<u8>> = Vec::new();
        for (position, &index) in self.geometry_at.iter().enumerate() {
            let geometry = &geometries[index];
            let is_shared = geometry.is_plain() && geometry.open != Open::Parity && is_closed(position);
            let own = if is_shared { ends[position] } else { everywhere };
            let (mut least, mut is_taken) = (0, [false; MAX_RANKS]);
            for (&rank, _) in ranks.iter().zip(&boxes).filter(|(_, other)| do_meet(own, **other)) {
                if self.flag_of_rank[rank] == geometry.flag {
                    is_taken[rank] = true;
                } else {
                    least = least.max(rank + 1);
                }
            }
            let is_free = |&rank: &usize| is_shared && flags[rank] == Some(geometry.flag) && !is_taken[rank];
            let found = (least..flags.len()).find(is_free);
            if found.is_none() && flags.len() == MAX_RANKS {
                return Err(position);
            }
            if found.is_none() {
                flags.push(is_shared.then_some(geometry.flag));
                self.flag_of_rank.push(geometry.flag);
            }
            ranks.push(found.unwrap_or(flags.len() - 1));
            boxes.push(own);
        }
        self.rank_at = ranks.iter().map(|&rank| rank as u8).collect();
        Ok(())
    }
}

/// Whether two boxes have points in common, or touch.
fn do_meet(one: Ends, other: Ends) -> bool {
    let (Some([low, high]), Some([other_low, other_high])) = (one, other) else { return false };
    (0..3).all(|axis| high[axis] >= other_low[axis] && other_high[axis] >= low[axis])
}
