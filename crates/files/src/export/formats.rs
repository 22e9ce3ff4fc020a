//! The formats that exporters write: one file each, whose `FORMAT` says all of it.

pub(super) mod abaqus;
pub(super) mod binvox;
pub(super) mod csx;
pub(super) mod foam;
pub(super) mod gmsh;
pub(super) mod gprmax;
pub(super) mod nrrd;
pub(super) mod openmc;
pub(super) mod vox;
pub(super) mod xdmf;
