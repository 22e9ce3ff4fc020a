//! The formats that exporters write: one file each, whose `FORMAT` says all of it, and one row each, from which [`Exporter`] is made.

use super::format::Format;

/// Makes an enumeration whose variants are formats, each with its file, and lists it.
macro_rules! formats {
    ($(#[$head:meta])* pub enum $name:ident { $($(#[$about:meta])* $variant:ident = $file:ident,)+ }) => {
        $(pub(super) mod $file;)+

        $(#[$head])*
        pub enum $name {
            $($(#[$about])* $variant,)+
        }

        impl $name {
            /// Every exporter, in the order of the documentation.
            pub const ALL: [$name; [$($name::$variant),+].len()] = [$($name::$variant),+];

            /// What each exporter is.
            pub(super) const fn format(self) -> &'static Format {
                match self {
                    $($name::$variant => &$file::FORMAT,)+
                }
            }
        }
    };
}

formats! {
    /// A program, or a format, that a mesh is written for.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    #[non_exhaustive]
    pub enum Exporter {
        /// OpenFOAM: a `polyMesh`.
        Foam = foam,
        /// AMReX: the embedded boundary of `BuildFromChkptFile`.
        Amrex = amrex,
        /// Abaqus and CalculiX: nodes, elements, sets and surfaces.
        Abaqus = abaqus,
        /// Gmsh: MSH 4.1.
        Gmsh = gmsh,
        /// XDMF and HDF5: hexahedra, for ParaView, meshio and dolfinx.
        Xdmf = xdmf,
        /// openEMS: lines, materials and boxes in the XML of CSXCAD.
        Csx = csx,
        /// gprMax 4: an array of materials in HDF5, with a list of them.
        Gprmax = gprmax,
        /// OpenMC: a lattice in `geometry.xml`.
        Openmc = openmc,
        /// Nearly raw raster data: the flags of equal cells as an image of three dimensions.
        Nrrd = nrrd,
        /// MagicaVoxel: coloured cubes.
        Vox = vox,
        /// glTF 2.0, binary: closed surfaces with names and colours.
        Glb = glb,
        /// STL: closed surfaces.
        Stl = stl,
        /// binvox: a cube of bits.
        Binvox = binvox,
    }
}

/// How many endings there are.
const N_ENDINGS: usize = {
    let (mut n, mut index) = (0, 0);
    while index < Exporter::ALL.len() {
        n += Exporter::ALL[index].format().endings.len();
        index += 1;
    }
    n
};

impl Exporter {
    /// How the path of an output ends that asks for each exporter, in the order of [`Exporter::ALL`].
    pub const ENDINGS: [(&str, Exporter); N_ENDINGS] = {
        let mut endings = [("", Exporter::Foam); N_ENDINGS];
        let (mut n, mut index) = (0, 0);
        while index < Exporter::ALL.len() {
            let (exporter, mut ending) = (Exporter::ALL[index], 0);
            while ending < exporter.format().endings.len() {
                endings[n] = (exporter.format().endings[ending], exporter);
                (n, ending) = (n + 1, ending + 1);
            }
            index += 1;
        }
        endings
    };
}
