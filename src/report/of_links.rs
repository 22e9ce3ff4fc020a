//! What the report says of links from cells to surfaces.

use serde::Serialize;

use crate::job::Stencil;
use crate::links::Links;

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
        let all = &links.links;
        let is_in_fluid = |flag: u8| links.fluid.contains(&flag);
        LinksReport {
            stencil: links.stencil,
            fluid: links.fluid.clone(),
            links: all.len() as u64,
            cells: all.chunk_by(|one, other| one.cell == other.cell).count() as u64,
            through_walls: all.iter().filter(|link| is_in_fluid(link.flag)).count() as u64,
            without_facet: all.iter().filter(|link| link.facet < 0).count() as u64,
        }
    }
}
