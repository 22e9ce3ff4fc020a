//! A first mesh that nobody waits for: drivers on the processor compile a kernel when it first runs, which takes longer
//! than a mesh of 10^9 cells. So they do while the caller reads files.

use super::band::{Context, Forced, Worker};
use crate::cast::Cast;
use crate::error::Result;
use crate::frame::{Frame, Ranks};
use crate::job::Rule;
use crate::rays::Rays;

/// Sends the commands of two meshes of 8 x 8 rays and two facets to the device, with one layer and with two.
///
/// # Errors
/// `device-failed`, `device-lost`.
pub(crate) fn warm_up(context: Context) -> Result<()> {
    let frame = Frame {
        fraction_bits: 16,
        centres: None,
        dims: [8; 3],
        facets: [0, 4 << 16].map(|x| [[x, 0, 0], [x, 5 << 16, 1 << 16], [x, 1 << 16, 5 << 16]]).to_vec(),
        position_of_facet: vec![0; 2],
        ranks: Ranks::of_one(),
    };
    let rays = Rays::new(0, frame.dims);
    let cast = Cast { frame: &frame, rays: &rays, rule: Rule::Parity };
    for layers in [1, 2] {
        Worker::new(context, cast, Forced { layers: Some(layers), ..Forced::default() }).launch(0..8)?;
    }
    Ok(())
}
