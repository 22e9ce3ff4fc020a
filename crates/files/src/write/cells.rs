//! What a file holds of its cells, one number each: their flags, in the order, by the map or as the bits of the options, the fraction
//! that is not background, or the distance to the nearest surface, which nodes can have, too.
//!
//! Cells -> bytes in file order, with a rest before every slab: natively all at once, in wasm whenever the reader wants more. Cost: two slabs
//! of memory.

use super::measured::distance;
use super::{Format, Options, npy, ordered, raw, solid};
use hexcast_core::base::control::Control;
use hexcast_core::base::error::{Error, Result};
use hexcast_core::cells::flags::slabs_of_box;
use hexcast_derived::distance::Distance;
use hexcast_derived::fractions::Fractions;
use hexcast_derived::mesh::Mesh;

/// The cells of a mesh as a file has them.
#[derive(Clone, Copy)]
pub struct Cells<'a> {
    pub(super) mesh: &'a Mesh,
    pub(super) options: &'a Options,
    pub(super) numbers: Numbers<'a>,
}

/// The numbers.
#[derive(Clone, Copy)]
pub(super) enum Numbers<'a> {
    Flags,
    /// The fraction that is not background.
    Solid(&'a Fractions),
    Distance(&'a Distance),
}

impl<'a> Cells<'a> {
    /// The flags of a mesh.
    pub fn flags(mesh: &'a Mesh, options: &'a Options) -> Cells<'a> {
        Cells { mesh, options, numbers: Numbers::Flags }
    }

    /// The fraction of every cell that is not background.
    ///
    /// # Errors
    /// `job-conflict` where mesh and fractions are not of the same box, or the mesh has a halo.
    pub fn solid(mesh: &'a Mesh, fractions: &'a Fractions, options: &'a Options) -> Result<Cells<'a>> {
        solid::check_dims(mesh, fractions)?;
        Ok(Cells { mesh, options, numbers: Numbers::Solid(fractions) })
    }

    /// The signed distance of every cell or node.
    ///
    /// # Errors
    /// `job-conflict` where mesh and distances are not of the same box.
    pub fn distance(mesh: &'a Mesh, distance: &'a Distance, options: &'a Options) -> Result<Cells<'a>> {
        distance::check_dims(mesh, distance)?;
        Ok(Cells { mesh, options, numbers: Numbers::Distance(distance) })
    }

    /// What the numbers are, in words.
    pub(super) fn named(&self) -> &'static str {
        match self.numbers {
            Numbers::Flags => "the mesh",
            Numbers::Solid(_) => "the fractions",
            Numbers::Distance(_) => "the distances",
        }
    }

    /// The name of the numbers, and their type as VTK names it.
    pub(super) fn kind(&self) -> (&'static str, &'static str) {
        match self.numbers {
            Numbers::Flags => ("flag", "UInt8"),
            Numbers::Solid(_) => ("solid", "Float32"),
            Numbers::Distance(_) => ("distance", "Float64"),
        }
    }

    /// Whether the numbers are those of nodes.
    pub(super) fn are_of_nodes(&self) -> bool {
        matches!(self.numbers, Numbers::Distance(distance) if distance.of_nodes)
    }

    /// Number of their bytes; None where it would not fit 64 bits.
    pub(super) fn n_bytes(&self) -> Option<u64> {
        match self.numbers {
            Numbers::Flags => raw::n_bytes(self.mesh.dims(), self.options.bits),
            Numbers::Solid(_) => self.mesh.n_cells().checked_mul(4),
            Numbers::Distance(distance) => distance.dims().iter().try_fold(8u64, |n, of| n.checked_mul((*of).into())),
        }
    }

    /// Numbers that are made at a time.
    pub fn n_of_slab(&self) -> usize {
        let n_bytes = match self.numbers {
            Numbers::Flags => 1,
            Numbers::Solid(_) => 4,
            Numbers::Distance(_) => 8,
        };
        self.options.slab_bytes / n_bytes
    }

    /// Everything before the numbers of `.npy`.
    pub(super) fn npy_header(&self) -> Vec<u8> {
        let header = |kind: &str, [nx, ny, nz]: [u32; 3]| npy::header_of(kind, &format!("({nz}, {ny}, {nx})"));
        match self.numbers {
            Numbers::Flags => npy::header(self.mesh.dims(), self.options),
            Numbers::Solid(_) => header("<f4", self.mesh.dims()),
            Numbers::Distance(distance) => header("<f8", distance.dims()),
        }
    }

    /// Refuses a format that does not hold these numbers.
    pub(super) fn check_format(&self, format: Format) -> Result<()> {
        if matches!(self.numbers, Numbers::Flags) {
            return Ok(());
        }
        if matches!(format, Format::Vti | Format::Vtr | Format::Npy | Format::ZarrZip) {
            return Ok(());
        }
        let message = format!(".{} does not hold {} of cells", format.extension(), self.named());
        Err(Error::new("job-conflict", message, "use .vti, .vtr, .npy or .zarr.zip"))
    }

    /// Hands over the bytes of all numbers in order.
    ///
    /// # Errors
    /// `io` where columns are in a store that fails; `cancelled`; whatever `consume` returns.
    pub(super) async fn each(&self, control: &Control, consume: &mut dyn FnMut(&[u8]) -> Result<()>) -> Result<()> {
        let Cells { mesh, options, numbers } = self;
        let fractions = match numbers {
            Numbers::Flags if options.bits => {
                return mesh.for_each_slab_of_bits_with_rests(options.slab_bytes, control, consume).await;
            }
            Numbers::Flags => return ordered::for_each_slab(mesh, options, control, consume).await,
            Numbers::Distance(distance) => {
                let [nx, ny, nz] = distance.dims();
                for slab in slabs_of_box(&[0..nx, 0..ny, 0..nz], self.n_of_slab()) {
                    control.rest().await?;
                    consume(&distance::bytes(distance, &slab)?)?;
                }
                return Ok(());
            }
            Numbers::Solid(fractions) => fractions,
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
