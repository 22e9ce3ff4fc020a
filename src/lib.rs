#![doc = include_str!("../docs/rust.md")]
// what is public names stages that errors come from
#![allow(rustdoc::private_intra_doc_links)]

#[doc(hidden)]
pub mod meshing {
    pub mod converge;
    pub mod estimate;
    #[cfg(not(target_arch = "wasm32"))]
    pub mod files;
    #[cfg(not(target_arch = "wasm32"))]
    pub mod machine;
    pub mod measured;
    #[cfg(not(target_arch = "wasm32"))]
    pub mod mesher;
    pub mod parts;
    pub mod pipeline;
    pub mod refine;
    pub mod report;
    pub mod scene;
}
#[cfg(all(feature = "web", target_arch = "wasm32"))]
pub mod web;

#[doc(inline)]
pub use hexcast_core::{
    Control, Error, GeometryJob, Job, Result, Source, columns, control, error, finding, geometry, job, length, lines,
    memory, read, sources, surface,
};
#[doc(inline)]
pub use hexcast_derived::cut_cells::conformal;
#[doc(inline)]
pub use hexcast_derived::cut_cells::tensors;
/// # Example
/// ```
/// # use hexcast::{Control, GeometryJob, Job, Mesher, MesherOptions, Source, job::BackendChoice, pipeline::MeshOptions};
/// use hexcast::difference::difference;
///
/// # let [o, x, y, z] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// # let source = Source::from_facets("body", vec![[o, y, x], [o, x, z], [o, z, y], [x, y, z]])?;
/// # let mut mesher = Mesher::new(MesherOptions::default().with_backend(BackendChoice::Cpu))?;
/// # let mut mesh_of = |flag| {
/// #     let mut job = Job::new(vec![GeometryJob::new("body")]);
/// #     (job.cells, job.geometries[0].flag) = (Some(20), Some(flag));
/// #     mesher.mesh_sources(&job, vec![source.clone()], &MeshOptions::default(), &Control::default())
/// # };
/// # let ((before, _), (after, _)) = (mesh_of(1)?, mesh_of(3)?);
/// let found = difference(&before, &after, u64::MAX, &Control::default())?;
/// assert!(found.cells > 1000);
/// // all of them had flag 1, and have flag 3
/// assert_eq!((found.pairs.len(), found.pairs[0].one, found.pairs[0].other), (1, 1, 3));
/// assert_eq!(found.mask.flag(found.pairs[0].first)?, 1);
/// # Ok::<(), hexcast::Error>(())
/// ```
#[doc(inline)]
pub use hexcast_derived::difference;
#[doc(inline)]
pub use hexcast_derived::mesh::{self, Mesh};
pub use hexcast_derived::{cut, distance, fractions, gaps, leak, links, skin, staggered, walls};
#[cfg(feature = "export")]
#[doc(inline)]
pub use hexcast_files::export;
/// # Example
/// ```
/// # use hexcast::{Control, GeometryJob, Job, Mesher, MesherOptions, Source, job::BackendChoice, pipeline::MeshOptions};
/// use hexcast::picture::{Look, Place, Slices, View, slices, view};
///
/// # let [o, x, y, z] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// # let source = Source::from_facets("body", vec![[o, y, x], [o, x, z], [o, z, y], [x, y, z]])?;
/// # let mut job = Job::new(vec![GeometryJob::new("body")]);
/// # job.cells = Some(20);
/// # let mut mesher = Mesher::new(MesherOptions::default().with_backend(BackendChoice::Cpu))?;
/// # let (mesh, _) = mesher.mesh_sources(&job, vec![source], &MeshOptions::default(), &Control::default())?;
/// // two planes across z, with a legend below
/// let planes = Slices::at(&mesh, &[2], &[Place::Percent(25.0), Place::Coordinate(0.5)])?;
/// let picture = slices(&mesh, &planes.with_look(Look::default().with_size(300)), &Control::default())?;
/// let png: Vec<u8> = picture.png()?;
///
/// let from_above = View::default().with_direction([30.0, 60.0]);
/// let seen = view(&mesh, &from_above, &Control::default())?;
/// assert_eq!(seen.width(), 1000 + 2 * 12);
/// # assert_eq!(&png[1..4], b"PNG");
/// # Ok::<(), hexcast::Error>(())
/// ```
#[cfg(feature = "pictures")]
#[doc(inline)]
pub use hexcast_files::picture;
#[doc(inline)]
pub use hexcast_files::write::column_file;
#[doc(inline)]
pub use hexcast_files::{shards, write};
#[cfg(feature = "gpu")]
#[doc(inline)]
pub use hexcast_gpu as gpu;
pub use meshing::measured::{self, Measured};
#[cfg(not(target_arch = "wasm32"))]
pub use meshing::mesher::{self, Mesher, MesherOptions};
#[doc(inline)]
pub use meshing::pipeline::points;
pub use meshing::scene::{self, Scene};
pub use meshing::{converge, estimate, parts, pipeline, refine, report};
#[cfg(not(target_arch = "wasm32"))]
pub use meshing::{files, machine};
