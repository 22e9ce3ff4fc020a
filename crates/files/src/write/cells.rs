//! What a file holds of its cells, one number each: their flags, in the order, by the map or as the bits of the options, or the fraction
//! that is not background.
//!
//! Cells -> bytes in file order, with a rest before every slab: natively all at once, in wasm whenever the reader wants more. Cost: two slabs
//! of memory.

use super::{Options, ordered, raw, solid};
use hexcast_core::base::control::Control;
use hexcast_core::base::error::Result;
use hexcast_derived::fractions::Fractions;
use hexcast_derived::mesh::Mesh;

/// The cells of a mesh as a file has them.
#[derive(Clone, Copy)]
pub struct Cells<'a> {
    pub(super) mesh: &'a Mesh,
    pub(super) options: &'a Options,
    /// Whose fractions the numbers are; flags where there are none.
    pub(super) fractions: Option<&'a Fractions>,
}

impl<'a> Cells<'a> {
    /// The flags of a mesh.
    pub fn flags(mesh: &'a Mesh, options: &'a Options) -> Cells<'a> {
        Cells { mesh, options, fractions: None }
    }

    /// The fraction of every cell that is not background.
    ///
    /// # Errors
    /// `job-conflict` where mesh and fractions are not of the same box, or the mesh has a halo.
    pub fn solid(mesh: &'a Mesh, fractions: &'a Fractions, options: &'a Options) -> Result<Cells<'a>> {
        solid::check_dims(mesh, fractions)?;
        Ok(Cells { mesh, options, fractions: Some(fractions) })
    }

    /// The name of the numbers, and their type as VTK names it.
    pub(super) fn kind(&self) -> (&'static str, &'static str) {
        if self.fractions.is_some() { ("solid", "Float32") } else { ("flag", "UInt8") }
    }

    /// Number of their bytes; None where it would not fit 64 bits.
    pub(super) fn n_bytes(&self) -> Option<u64> {
        match self.fractions {
            Some(_) => self.mesh.n_cells().checked_mul(4),
            None => raw::n_bytes(self.mesh.dims(), self.options.bits),
        }
    }

    /// Numbers that are made at a time.
    pub fn n_of_slab(&self) -> usize {
        // a fraction has four bytes
        if self.fractions.is_some() { self.options.slab_bytes / 4 } else { self.options.slab_bytes }
    }

    /// Hands over the bytes of all numbers in order.
    ///
    /// # Errors
    /// `io` where columns are in a store that fails; `cancelled`; whatever `consume` returns.
    pub(super) async fn each(&self, control: &Control, consume: &mut dyn FnMut(&[u8]) -> Result<()>) -> Result<()> {
        let Cells { mesh, options, fractions } = self;
        let Some(fractions) = fractions else {
            return match options.bits {
                true => mesh.for_each_slab_of_bits_with_rests(options.slab_bytes, control, consume).await,
                false => ordered::for_each_slab(mesh, options, control, consume).await,
            };
        };
        let mut cell = 0;
        let mut put = |flags: &[u8]| {
            let bytes = solid::bytes(flags, cell, fractions);
            cell += flags.len() as u64;
            consume(&bytes)
        };
        mesh.for_each_slab_with_rests(self.n_of_slab(), control, &mut put).await
    }
}
