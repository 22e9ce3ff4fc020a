//! What was measured beside the cells, and the arrays of the archives that hold it.

use crate::error::{Error, Result};
use crate::fractions::Fractions;
use crate::links::Links;
use crate::mesh::Mesh;
use crate::report::MeshFacts;
use crate::staggered::Staggered;
use crate::write::Options;
use crate::write::archive::Array;
use crate::write::{fractions, links, npz, staggered};

/// What a mesh has beside its cells, where its job asked for it.
#[derive(Default)]
pub(super) struct Measured {
    links: Option<Links>,
    fractions: Option<Fractions>,
    staggered: Option<Staggered>,
}

impl Measured {
    /// Takes it out of the facts, which keep what a report says of it.
    pub(super) fn take(facts: &mut MeshFacts) -> Measured {
        let MeshFacts { links, fractions, staggered, .. } = facts;
        Measured { links: links.take(), fractions: fractions.take(), staggered: staggered.take() }
    }

    /// The links.
    ///
    /// # Errors
    /// `job-conflict` where the mesh has none.
    pub(super) fn links(&self) -> Result<&Links> {
        self.links.as_ref().ok_or_else(|| missing("links"))
    }

    /// The fractions.
    ///
    /// # Errors
    /// `job-conflict` where the mesh has none.
    pub(super) fn fractions(&self) -> Result<&Fractions> {
        self.fractions.as_ref().ok_or_else(|| missing("fractions"))
    }

    /// The arrays of an archive: of `links`, `fractions`, `staggered`, or else of the mesh, as the options ask for it.
    ///
    /// # Errors
    /// `job-conflict` where the mesh has none of these.
    pub(super) fn arrays<'a>(&'a self, mesh: &'a Mesh, of: &str, options: Options) -> Result<Vec<Array<'a>>> {
        Ok(match of {
            "links" => links::arrays(self.links()?),
            "fractions" => fractions::arrays(self.fractions()?),
            "staggered" => staggered::arrays(self.staggered.as_ref().ok_or_else(|| missing(of))?, mesh),
            _ => npz::arrays(mesh, options),
        })
    }
}

fn missing(of: &str) -> Error {
    Error::new("job-conflict", format!("the mesh has no {of}"), format!("ask for them with the key {of} of the job"))
}
