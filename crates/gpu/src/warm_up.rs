//! A first mesh whose result nobody needs. Software drivers compile a kernel when it first runs, which takes longer than a
//! mesh of 10^9 cells; with this mesh they do so while the caller reads files.

use crate::band::{Context, Forced, Worker};
use hexcast_core::base::error::Result;
use hexcast_core::grid::frame::{Frame, Ranks};
use hexcast_core::grid::rays::Rays;
use hexcast_core::input::job::Rule;
use hexcast_core::stages::cast::Cast;

/// Sends the commands of a mesh of 8 x 8 rays and one facet to the device.
///
/// # Errors
/// `device-failed`, `device-lost`.
pub(crate) fn warm_up(context: Context) -> Result<()> {
    let frame = Frame {
        fraction_bits: 16,
        centres: None,
        dims: [8; 3],
        facets: vec![[[0, 0, 0], [0, 5 << 16, 1 << 16], [0, 1 << 16, 5 << 16]]],
        position_of_facet: vec![0],
        ranks: Ranks::of_one(),
    };
    let rays = Rays::new(0, frame.dims);
    let cast = Cast { frame: &frame, rays: &rays, rule: Rule::Parity };
    Worker::new(context, cast, Forced::default()).launch(0..8)?;
    Ok(())
}
