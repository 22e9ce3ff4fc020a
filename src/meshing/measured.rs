//! What a mesh has beside its cells, and the arrays that hold it.
//!
//! Facts of a mesh -> [`Measured`] -> arrays, the same as those of the archives that are written.

use crate::meshing::report::MeshFacts;
use hexcast_core::base::error::{Error, Result};
use hexcast_derived::cut_cells::conformal::Conformal;
use hexcast_derived::cut_cells::tensors::Tensors;
use hexcast_derived::distance::Distance;
use hexcast_derived::fractions::Fractions;
use hexcast_derived::links::Links;
use hexcast_derived::mesh::Mesh;
use hexcast_derived::staggered::Staggered;
use hexcast_files::write::{Array, conformal, distance, fractions, links, staggered, tensors};

/// What a mesh has beside its cells, where its job asked for it.
#[derive(Debug, Default)]
#[non_exhaustive]
pub struct Measured {
    /// The links to surfaces.
    pub links: Option<Links>,
    /// The fractions of flags in cut cells.
    pub fractions: Option<Fractions>,
    /// The points of a staggered grid.
    pub staggered: Option<Staggered>,
    /// The edges and faces outside metal.
    pub conformal: Option<Conformal>,
    /// The signed distances of cells or nodes.
    pub distance: Option<Distance>,
    /// The smoothed permittivity.
    pub tensors: Option<Tensors>,
    /// The cells that rays do not decide: flag 1.
    pub doubt: Option<Mesh>,
}

impl Measured {
    /// Takes it out of the facts, which keep what a report says of it.
    pub fn take(facts: &mut MeshFacts) -> Measured {
        let MeshFacts { links, fractions, staggered, conformal, tensors, distance, doubt, .. } = facts;
        Measured {
            links: links.take(),
            fractions: fractions.take(),
            staggered: staggered.take(),
            conformal: conformal.take(),
            distance: distance.take(),
            tensors: tensors.take(),
            doubt: doubt.take(),
        }
    }

    /// The links.
    ///
    /// # Errors
    /// `job-conflict` where the mesh has none.
    pub fn links(&self) -> Result<&Links> {
        self.links.as_ref().ok_or_else(|| missing("links"))
    }

    /// The fractions.
    ///
    /// # Errors
    /// `job-conflict` where the mesh has none.
    pub fn fractions(&self) -> Result<&Fractions> {
        self.fractions.as_ref().ok_or_else(|| missing("fractions"))
    }

    /// The distances.
    ///
    /// # Errors
    /// `job-conflict` where the mesh has none.
    pub fn distance(&self) -> Result<&Distance> {
        self.distance.as_ref().ok_or_else(|| missing("distance"))
    }

    /// The arrays of `links`, `fractions`, `staggered`, `conformal`, `tensors` or `distance`: those of the `.npz` that is written.
    ///
    /// # Errors
    /// `job-conflict` where the mesh has none of these; `job-value` for another name.
    pub fn arrays<'a>(&'a self, mesh: &'a Mesh, of: &str) -> Result<Vec<Array<'a>>> {
        Ok(match of {
            "links" => links::arrays(self.links()?),
            "fractions" => fractions::arrays(self.fractions()?),
            "staggered" => staggered::arrays(self.staggered.as_ref().ok_or_else(|| missing(of))?, mesh),
            "conformal" => conformal::arrays(self.conformal.as_ref().ok_or_else(|| missing(of))?, mesh),
            "distance" => distance::arrays(self.distance()?, mesh),
            "tensors" => tensors::arrays(self.tensors.as_ref().ok_or_else(|| missing(of))?, mesh),
            _ => {
                let message = format!("\"{of}\" is nothing that a mesh has arrays of");
                return Err(Error::new(
                    "job-value",
                    message,
                    "name links, fractions, staggered, conformal, tensors or distance",
                ));
            }
        })
    }
}

fn missing(of: &str) -> Error {
    Error::new("job-conflict", format!("the mesh has no {of}"), format!("ask for them with the key {of} of the job"))
}
