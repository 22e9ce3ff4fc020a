//! What the report says of a window.

use super::prepare::Prepared;
use crate::meshing::report::{StaggeredReport, WindowReport, WindowSums};
use hexcast_core::base::error::Result;
use hexcast_core::cells::columns::Columns;
use hexcast_core::cells::fingerprint::flags_sum;
use hexcast_core::derived::staggered::Staggered;

/// Says which cells were meshed.
pub(super) fn window_report(
    [first, end]: [[u32; 3]; 2],
    prepared: &Prepared,
    (columns, staggered): (&Columns, Option<&Staggered>),
) -> Result<WindowReport> {
    let Prepared { whole, halo, .. } = prepared;
    let has_sum = *halo == 0 && !columns.is_spilled();
    let flags_sum = has_sum.then(|| flags_sum(columns, first, whole.dims())).transpose()?;
    let (of, origin, halo, shells) = (whole.dims(), whole.origin(), *halo, Vec::new());
    let staggered = staggered.map(|points| StaggeredReport::of_window(points, end, of)).transpose()?;
    let (volume_bounds, runs, without_cells) = (None, None, None);
    let (sums, without_halo) = (WindowSums::default(), None);
    Ok(WindowReport {
        first,
        end,
        of,
        origin,
        halo,
        flags_sum,
        sums,
        volume_bounds,
        runs,
        staggered,
        shells,
        without_cells,
        without_halo,
    })
}
