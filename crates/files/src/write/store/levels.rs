//! The coarser levels of a store: where they are, how many there are, and their meshes, one after the other.

use crate::shards::Shards;
use hexcast_core::base::control::Control;
use hexcast_core::base::error::{Error, Result};
use hexcast_core::grid::lines::Lines;
use hexcast_core::input::job::{Levels, ZarrJob};
use hexcast_core::set;
use hexcast_derived::mesh::Mesh;
use hexcast_derived::mesh::level::Pyramid;

/// Cells along an axis of which no coarser level is made.
const FEW: u32 = 64;

/// The path of the group of a level, with a slash at its end.
pub(crate) fn group_of(level: usize) -> String {
    if level == 0 { String::new() } else { format!("levels/{level}/") }
}

/// The groups that come with a level, those around it first.
pub(crate) fn new_groups(level: usize) -> Vec<String> {
    let around = (level == 1).then(|| "levels".to_string());
    around.into_iter().chain((level > 0).then(|| format!("levels/{level}"))).collect()
}

/// Shapes of the shards of all levels: those of the finest, as far as these have cells.
pub(crate) fn zarr_of_levels(zarr: &ZarrJob, Shards { shard, chunk }: Shards) -> ZarrJob {
    let shapes = ZarrJob::default();
    set!(ZarrJob { chunks: Some(chunk), shards: Some(shard), sparse: zarr.sparse, ..shapes })
}

/// Refuses coarser levels of a part: a cell of theirs may have cells of other parts, and which flags are rare only the whole mesh knows.
///
/// # Errors
/// `job-conflict`.
pub(crate) fn check_levels_of_part(zarr: &ZarrJob) -> Result<()> {
    if zarr.levels.is_none() {
        return Ok(());
    }
    let message = "zarr.levels is given with a part of the mesh: coarser levels are made of the whole mesh";
    Err(Error::new("job-conflict", message, "leave out zarr.levels (--zarr-levels), or mesh the whole in one run"))
}

/// Lines of the levels of a store: of its mesh alone, or also of coarser ones until no axis has more than 64 cells.
///
/// # Errors
/// None but for a defect: coarser lines are fewer.
pub(crate) fn levels(whole: &Lines, zarr: &ZarrJob) -> Result<Vec<Lines>> {
    let mut levels = vec![whole.clone()];
    while let (Some(last), true) = (levels.last(), zarr.levels.is_some())
        && last.dims().iter().any(|&n| n > FEW)
    {
        levels.push(last.doubled()?);
    }
    Ok(levels)
}

/// The coarser meshes of a mesh while they are made: one at a time, of the one before.
pub(crate) struct Coarser<'a> {
    fine: &'a Mesh,
    last: Option<Mesh>,
    pyramid: Option<Pyramid>,
    level: usize,
    n: usize,
}

impl<'a> Coarser<'a> {
    /// Those of a mesh up to so many levels, itself the first; none without a rule.
    pub(crate) fn new(fine: &'a Mesh, rule: Option<Levels>, n: usize) -> Coarser<'a> {
        let pyramid = rule.filter(|_| n > 1).map(|rule| Pyramid::of(fine, rule));
        Coarser { fine, last: None, pyramid, level: 0, n }
    }

    /// The next level and its mesh.
    ///
    /// # Errors
    /// `io` where the columns are in a store that fails; `cancelled`.
    pub(crate) async fn next(&mut self, control: &Control) -> Result<Option<(usize, &Mesh)>> {
        let Some(pyramid) = self.pyramid.as_ref().filter(|_| self.level + 1 < self.n) else { return Ok(None) };
        self.level += 1;
        let mesh = pyramid.next(self.last.as_ref().unwrap_or(self.fine), control).await?;
        Ok(Some((self.level, self.last.insert(mesh))))
    }
}
