//! Jobs made key by key: what is not set keeps its default. The keys are those of the job file.

use super::{
    Axis, AxisChoice, BackendChoice, BackgroundJob, ByteSize, Fill, FractionsJob, GeometryJob, GradedJob, HaloEdge,
    Job, LinesJob, LinksJob, Open, Padding, PartJob, PerAxis, Rule, ZarrJob,
};
use crate::input::geometry::Material;

impl Job {
    /// A job of geometries, without settings.
    pub fn new(geometries: Vec<GeometryJob>) -> Job {
        Job { geometries, ..Job::default() }
    }

    /// Says what the cells of no geometry are.
    pub fn with_background(self, background: BackgroundJob) -> Job {
        Job { background: Some(background), ..self }
    }

    /// Sets the two corners of the box, x0 y0 z0 x1 y1 z1.
    pub fn with_domain(self, domain: [f64; 6]) -> Job {
        Job { domain: Some(domain), ..self }
    }

    /// Puts space around the domain, or around the box of the geometries.
    pub fn with_padding(self, padding: Padding) -> Job {
        Job { padding: Some(padding), ..self }
    }

    /// Asks for cubic cells, so many along the longest axis.
    pub fn with_cells(self, cells: u32) -> Job {
        Job { cells: Some(cells), ..self }
    }

    /// Asks for exactly so many cells on x, y and z.
    pub fn with_dims(self, dims: [u32; 3]) -> Job {
        Job { dims: Some(dims), ..self }
    }

    /// Sets the cell size on all axes or each.
    pub fn with_cell_size(self, cell_size: PerAxis<f64>) -> Job {
        Job { cell_size: Some(cell_size), ..self }
    }

    /// Asks for the largest size per axis, at most this, that puts the ends of all bounding boxes on mesh lines.
    pub fn with_max_cell_size(self, max_cell_size: f64) -> Job {
        Job { max_cell_size: Some(max_cell_size), ..self }
    }

    /// Sets all lines of each axis, in place of sizes and domain.
    pub fn with_lines(self, lines: LinesJob) -> Job {
        Job { lines: Some(lines), ..self }
    }

    /// Generates lines: on every end of every geometry's box, close where geometries are small, far elsewhere.
    pub fn with_graded(self, graded: GradedJob) -> Job {
        Job { graded: Some(graded), ..self }
    }

    /// Says how far from a mesh line, in cells, `max_cell_size` lets an end lie.
    pub fn with_tolerance(self, tolerance: f64) -> Job {
        Job { tolerance: Some(tolerance), ..self }
    }

    /// Refuses meshes of more cells.
    pub fn with_max_cells(self, max_cells: u64) -> Job {
        Job { max_cells: Some(max_cells), ..self }
    }

    /// Meshes only some cells of the box, i0 j0 k0 i1 j1 k1, the end exclusive.
    pub fn with_window(self, window: [u32; 6]) -> Job {
        Job { window: Some(window), ..self }
    }

    /// Meshes only one of the windows that the box is divided into.
    pub fn with_part(self, part: PartJob) -> Job {
        Job { part: Some(part), ..self }
    }

    /// Meshes so many cells around the window or part with it.
    pub fn with_halo(self, halo: u32) -> Job {
        Job { halo: Some(halo), ..self }
    }

    /// Says what the halo has beyond the box.
    pub fn with_halo_edge(self, halo_edge: HaloEdge) -> Job {
        Job { halo_edge: Some(halo_edge), ..self }
    }

    /// Sets the shapes of the chunks and shards of a Zarr store.
    pub fn with_zarr(self, zarr: ZarrJob) -> Job {
        Job { zarr: Some(zarr), ..self }
    }

    /// Says what is inside a surface.
    pub fn with_rule(self, rule: Rule) -> Job {
        Job { rule, ..self }
    }

    /// Says how cells are decided where a surface is not closed.
    pub fn with_open(self, open: Open) -> Job {
        Job { open, ..self }
    }

    /// Says which cells geometries have besides those whose centres lie inside.
    pub fn with_fill(self, fill: Fill) -> Job {
        Job { fill, ..self }
    }

    /// Makes every solid of every file a geometry of its own.
    pub fn with_split(self, split: bool) -> Job {
        Job { split, ..self }
    }

    /// Gives every geometry the cells outside of it.
    pub fn with_invert(self, invert: bool) -> Job {
        Job { invert, ..self }
    }

    /// Whether every solid of a geometry's file is one of its own.
    pub(crate) fn splits(&self, geometry: &GeometryJob) -> bool {
        self.split || geometry.split
    }

    /// Closes openings of fewer cells.
    pub fn with_close_gaps(self, close_gaps: u32) -> Job {
        Job { close_gaps: Some(close_gaps), ..self }
    }

    /// Sets the flag of the cells that this adds.
    pub fn with_gap_flag(self, gap_flag: u8) -> Job {
        Job { gap_flag: Some(gap_flag), ..self }
    }

    /// Looks for thin walls, for cells that two geometries claim, and for gaps, or does not.
    pub fn with_certify(self, certify: bool) -> Job {
        Job { certify, ..self }
    }

    /// Leaves out the checks that are made of every mesh, or does not.
    pub fn with_quick(self, quick: bool) -> Job {
        Job { quick, ..self }
    }

    /// Measures the links from cells of a fluid to surfaces.
    pub fn with_links(self, links: LinksJob) -> Job {
        Job { links: Some(links), ..self }
    }

    /// Measures the fraction of each flag in the cells that surfaces cut.
    pub fn with_fractions(self, fractions: FractionsJob) -> Job {
        Job { fractions: Some(fractions), ..self }
    }

    /// Says along which axes the box continues with itself.
    pub fn with_periodic(self, periodic: Vec<Axis>) -> Job {
        Job { periodic, ..self }
    }

    /// Finds the flags at the points of a staggered grid, or does not.
    pub fn with_staggered(self, staggered: bool) -> Job {
        Job { staggered, ..self }
    }

    /// Says which flags are perfect conductors, all edges of whose cells conduct on the staggered grid.
    pub fn with_conductors(self, conductors: Vec<u8>) -> Job {
        Job { conductors, ..self }
    }

    /// Calls walls of fewer cells thin.
    pub fn with_thin_cells(self, thin_cells: u32) -> Job {
        Job { thin_cells: Some(thin_cells), ..self }
    }

    /// Chooses who meshes.
    pub fn with_backend(self, backend: BackendChoice) -> Job {
        Job { backend, ..self }
    }

    /// Chooses along which axis the rays run.
    pub fn with_axis(self, axis: AxisChoice) -> Job {
        Job { axis, ..self }
    }

    /// Limits the memory.
    pub fn with_max_memory(self, max_memory: ByteSize) -> Job {
        Job { max_memory: Some(max_memory), ..self }
    }

    /// Names the unit of lengths.
    pub fn with_unit(self, unit: impl Into<String>) -> Job {
        Job { unit: Some(unit.into()), ..self }
    }
}

impl GeometryJob {
    /// Takes only the solid of this name.
    pub fn with_solid(self, solid: impl Into<String>) -> GeometryJob {
        GeometryJob { solid: Some(solid.into()), ..self }
    }

    /// Makes every solid of the file a geometry of its own, or does not.
    pub fn with_split(self, split: bool) -> GeometryJob {
        GeometryJob { split, ..self }
    }

    /// Gives every solid the flag, with [`GeometryJob::with_split`] and [`GeometryJob::with_flag`].
    pub fn with_same_flag(self, same_flag: bool) -> GeometryJob {
        GeometryJob { same_flag, ..self }
    }

    /// Sets the name in reports and outputs.
    pub fn with_name(self, name: impl Into<String>) -> GeometryJob {
        GeometryJob { name: Some(name.into()), ..self }
    }

    /// Sets the flag, 1 to 255.
    pub fn with_flag(self, flag: u8) -> GeometryJob {
        GeometryJob { flag: Some(flag), ..self }
    }

    /// Sets the priority: where geometries overlap the higher wins.
    pub fn with_priority(self, priority: i32) -> GeometryJob {
        GeometryJob { priority, ..self }
    }

    /// Says how cells are decided where its surface is not closed.
    pub fn with_open(self, open: Open) -> GeometryJob {
        GeometryJob { open: Some(open), ..self }
    }

    /// Says which cells along its surface it has as well.
    pub fn with_fill(self, fill: Fill) -> GeometryJob {
        GeometryJob { fill: Some(fill), ..self }
    }

    /// Keeps only the cells along its surface, or does not.
    pub fn with_shell(self, shell: bool) -> GeometryJob {
        GeometryJob { shell, ..self }
    }

    /// Takes the cells outside of it, or does not.
    pub fn with_invert(self, invert: bool) -> GeometryJob {
        GeometryJob { invert, ..self }
    }

    /// Scales it, before it is rotated.
    pub fn with_scale(self, scale: PerAxis<f64>) -> GeometryJob {
        GeometryJob { scale: Some(scale), ..self }
    }

    /// Rotates it about x, y and z, in degrees, before it is moved.
    pub fn with_rotate(self, rotate: [f64; 3]) -> GeometryJob {
        GeometryJob { rotate: Some(rotate), ..self }
    }

    /// Sets the point about which it rotates, where it is once scaled.
    pub fn with_about(self, about: [f64; 3]) -> GeometryJob {
        GeometryJob { about: Some(about), ..self }
    }

    /// Moves it.
    pub fn with_translate(self, translate: [f64; 3]) -> GeometryJob {
        GeometryJob { translate: Some(translate), ..self }
    }

    /// Sets the largest size of a cell across it, where lines are generated.
    pub fn with_max_size(self, max_size: f64) -> GeometryJob {
        GeometryJob { max_size: Some(max_size), ..self }
    }

    /// Sets the fewest cells across it along every axis, where lines are generated.
    pub fn with_min_cells(self, min_cells: u32) -> GeometryJob {
        GeometryJob { min_cells: Some(min_cells), ..self }
    }

    /// Says whether it is metal, beside whose edges lines are generated.
    pub fn with_metal(self, metal: bool) -> GeometryJob {
        GeometryJob { metal, ..self }
    }

    /// Says what it is made of.
    pub fn with_material(self, material: Material) -> GeometryJob {
        GeometryJob { material, ..self }
    }
}

impl ZarrJob {
    /// Sets the cells of a chunk on x, y, z.
    pub fn with_chunks(self, chunks: [u32; 3]) -> ZarrJob {
        ZarrJob { chunks: Some(chunks), ..self }
    }

    /// Sets the cells of a shard on x, y, z: multiples of those of a chunk.
    pub fn with_shards(self, shards: [u32; 3]) -> ZarrJob {
        ZarrJob { shards: Some(shards), ..self }
    }

    /// Limits the cells of a shard, as a size.
    pub fn with_shard_bytes(self, shard_bytes: ByteSize) -> ZarrJob {
        ZarrJob { shard_bytes: Some(shard_bytes), ..self }
    }
}
