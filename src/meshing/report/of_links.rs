//! What the report says of links from cells to surfaces.

use serde::Serialize;

use hexcast_core::base::parallel::*;
use hexcast_core::derived::links::{Link, Links};
use hexcast_core::input::job::Stencil;

/// Links from cells of the fluid to surfaces, counted.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct LinksReport {
    /// The directions.
    pub stencil: Stencil,
    /// Flags of the fluid.
    pub fluid: Vec<u8>,
    /// Number of links.
    pub links: u64,
    /// Cells of the fluid with at least one of them.
    pub cells: u64,
    /// Links whose other end is in the fluid, too: the wall between is thinner than the link.
    pub through_walls: u64,
    /// Links that no facet crosses, as the flag at their other end is not decided by rays: q is 1/2.
    pub without_facet: u64,
}

impl LinksReport {
    /// Counts links.
    pub fn new(links: &Links) -> LinksReport {
        let mut is_fluid = [false; 256];
        links.fluid.iter().for_each(|&flag| is_fluid[usize::from(flag)] = true);
        let of_plane = |all: &Vec<Link>| {
            [
                all.chunk_by(|one, other| one.cell == other.cell).count(),
                all.iter().filter(|link| is_fluid[usize::from(link.flag)]).count(),
                all.iter().filter(|link| link.facet < 0).count(),
            ]
        };
        let counts: Vec<[usize; 3]> = links.planes.par_iter().map(of_plane).collect();
        let [cells, through_walls, without_facet] = [0, 1, 2].map(|of| counts.iter().map(|some| some[of] as u64).sum());
        LinksReport {
            stencil: links.stencil,
            fluid: links.fluid.clone(),
            links: links.len() as u64,
            cells,
            through_walls,
            without_facet,
        }
    }
}
