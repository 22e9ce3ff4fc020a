//! A mesh for JavaScript: its cells, its surface, what was measured beside them, and what differs from another mesh.

use std::rc::Rc;
use std::sync::Arc;

use js_sys::Array;
use serde::Serialize;
use wasm_bindgen::prelude::*;

use super::border::{JsResult, js_error, json};
use super::file::{JsFile, JsFileStore};
use super::work::WebWork;
use crate::meshing::measured::Measured;
use crate::meshing::report::ColumnsReport;
use hexcast_core::base::control::Control;
use hexcast_core::base::error::Error;
use hexcast_core::cells::columns::BoxRuns;
use hexcast_core::cells::flags::CellBox;
use hexcast_core::grid::lines::Lines;
use hexcast_core::input::job::ZarrJob;
use hexcast_derived::difference::difference_with_rests;
use hexcast_derived::mesh::Mesh;
use hexcast_derived::skin::{skin, slice};
use hexcast_files::write::{self, column_file};

/// Most bytes for the index of an opened file and for what was read of it last.
const OPENED_BYTES: u64 = 1 << 30;

/// A finished mesh.
#[wasm_bindgen]
pub struct WebMesh {
    pub(super) mesh: Rc<Mesh>,
    pub(super) measured: Arc<Measured>,
    /// Shapes of the shards of a Zarr store.
    pub(super) zarr: ZarrJob,
    report: String,
}

impl WebMesh {
    pub(super) fn new(mesh: Mesh, (measured, zarr): (Arc<Measured>, ZarrJob), report: String) -> WebMesh {
        WebMesh { mesh: Rc::new(mesh), measured, zarr, report }
    }
}

/// An array of what was measured, as `www/core/arrays.js` reads it.
#[derive(Serialize)]
struct Described<'a> {
    name: &'a str,
    kind: &'a str,
}

pub(super) fn cell_box(numbers: &[u32]) -> JsResult<CellBox> {
    match *numbers {
        [x0, y0, z0, x1, y1, z1] => Ok([x0..x1, y0..y1, z0..z1]),
        _ => Err(js_error(Error::new("job-value", "a box is two corners of three numbers each", ""))),
    }
}

#[wasm_bindgen]
impl WebMesh {
    /// Opens a column file of so many bytes, which stays where it is.
    pub fn open(file: JsFile, n_bytes: f64) -> JsResult<WebMesh> {
        let store = Arc::new(JsFileStore::new(file));
        let mesh = column_file::open(store, n_bytes as u64, OPENED_BYTES).map_err(js_error)?;
        let report = json(&ColumnsReport::new(&mesh));
        Ok(WebMesh::new(mesh, Default::default(), report))
    }

    /// The report as JSON.
    pub fn report(&self) -> String {
        self.report.clone()
    }

    /// Axis of the rays.
    #[wasm_bindgen(js_name = rayAxis)]
    pub fn ray_axis(&self) -> u32 {
        self.mesh.columns().rays().axis as u32
    }

    /// Number of runs and bytes of the columns.
    #[wasm_bindgen(js_name = columnFacts)]
    pub fn column_facts(&self) -> Vec<f64> {
        vec![self.mesh.columns().n_runs() as f64, self.mesh.columns().n_bytes() as f64]
    }

    /// Packed runs of a ray: first cell << 8 | flag.
    pub fn ray(&self, i: u32, j: u32) -> JsResult<Vec<u32>> {
        let rays = &self.mesh.columns().rays();
        if i >= rays.counts[0] || j >= rays.counts[1] {
            let message = format!("ray ({i}, {j}) is not one of {} x {}", rays.counts[0], rays.counts[1]);
            return Err(js_error(Error::new("job-value", message, "")));
        }
        let ray = self.mesh.columns().ray(u64::from(i) + u64::from(rays.counts[0]) * u64::from(j));
        Ok(ray.map_err(js_error)?.into_owned())
    }

    /// Packed runs of consecutive rays, as of [`WebMesh::ray`], each ray's behind their number.
    pub fn rays(&self, first: f64, n_rays: u32) -> JsResult<Vec<u32>> {
        let mut packed = Vec::new();
        for ray in first as u64..first as u64 + u64::from(n_rays) {
            let runs = self.mesh.columns().ray(ray).map_err(js_error)?;
            packed.push(runs.len() as u32);
            packed.extend_from_slice(&runs);
        }
        Ok(packed)
    }

    /// Flag of one cell.
    pub fn flag(&self, x: u32, y: u32, z: u32) -> JsResult<u8> {
        self.mesh.flag([x, y, z]).map_err(js_error)
    }

    /// Flags of a box, first and end on x, y, z; x fastest.
    #[wasm_bindgen(js_name = box)]
    pub fn box_flags(&self, corners: &[u32]) -> JsResult<Vec<u8>> {
        self.mesh.box_flags(&cell_box(corners)?).map_err(js_error)
    }

    /// Runs of the rays through a box, cut to it and counted from its first cell: the first run of each ray, the number of runs, then
    /// the packed runs.
    #[wasm_bindgen(js_name = boxRuns)]
    pub fn box_runs(&self, corners: &[u32]) -> JsResult<Vec<u32>> {
        let BoxRuns { mut offsets, runs } = self.mesh.box_runs(&cell_box(corners)?).map_err(js_error)?;
        offsets.extend(runs);
        Ok(offsets)
    }

    /// Boxes of all slabs, six numbers each.
    pub fn slabs(&self, max_bytes: f64) -> Vec<u32> {
        let slabs = self.mesh.slabs(max_bytes as usize);
        slabs.flat_map(|[x, y, z]| [x.start, y.start, z.start, x.end, y.end, z.end]).collect()
    }

    /// A plane of flags, headed by width, height and cells a pixel, each four bytes, little-endian.
    pub fn slice(&self, axis: u32, index: u32, max_pixels: u32) -> JsResult<Vec<u8>> {
        let axis = axis as usize;
        if axis > 2 || index >= self.mesh.dims()[axis] {
            return Err(js_error(Error::new("job-value", format!("there is no plane {index} across axis {axis}"), "")));
        }
        let plane = slice(&self.mesh, axis, index, [max_pixels.max(1); 2]).map_err(js_error)?;
        let head = [plane.width, plane.height, plane.step].map(u32::to_le_bytes);
        Ok([head.as_flattened(), &plane.flags].concat())
    }

    /// The stair-step surface.
    pub fn skin(&self, max_quads: f64) -> JsResult<WebSkin> {
        let skin = skin(&self.mesh, max_quads as usize, None, &Control::default()).map_err(js_error)?;
        Ok(WebSkin { skin, lines: self.mesh.lines().clone() })
    }

    /// Names and types of the arrays of `links`, `fractions`, `staggered`, `conformal`, `tensors` or `distance`, as JSON.
    #[wasm_bindgen(js_name = arraysOf)]
    pub fn arrays_of(&self, of: &str) -> JsResult<String> {
        let arrays = self.measured.arrays(&self.mesh, of).map_err(js_error)?;
        let described: Vec<Described> =
            arrays.iter().map(|of| Described { name: of.name(), kind: of.kind() }).collect();
        Ok(json(&described))
    }

    /// The bytes of one of these arrays, in their order.
    #[wasm_bindgen(js_name = arrayOf)]
    pub fn array_of(&self, of: &str, index: usize) -> JsResult<Vec<u8>> {
        let arrays = self.measured.arrays(&self.mesh, of).map_err(js_error)?;
        arrays.get(index).map_or(Ok(Vec::new()), write::Array::bytes).map_err(js_error)
    }

    /// Compares it with another mesh; the mask takes at most so many bytes. Makes two values: what `hexcast diff --json` prints, and the
    /// mask, a `WebMesh`.
    #[wasm_bindgen(js_name = differenceFrom)]
    pub fn difference_from(&self, other: &WebMesh, max_bytes: f64) -> WebWork {
        let (one, other) = (self.mesh.clone(), other.mesh.clone());
        WebWork::new(move |control| async move {
            let found = difference_with_rests(&one, &other, max_bytes as u64, &control).await?;
            let (facts, report) = (json(&found), json(&ColumnsReport::new(&found.mask)));
            let mask = WebMesh::new(found.mask, Default::default(), report);
            Ok(Array::of2(&facts.into(), &mask.into()).into())
        })
    }
}

/// A stair-step surface.
#[wasm_bindgen]
pub struct WebSkin {
    skin: hexcast_derived::skin::Skin,
    lines: Lines,
}

#[wasm_bindgen]
impl WebSkin {
    /// Cells a drawn cell.
    pub fn step(&self) -> u32 {
        self.skin.step
    }

    /// Flags of the parts.
    pub fn flags(&self) -> Vec<u8> {
        self.skin.parts.iter().map(|part| part.flag).collect()
    }

    /// Corners of a part's quads in world lengths from the mesh's origin, three numbers a vertex.
    pub fn positions(&self, part: usize) -> Vec<f32> {
        let positions = self.skin.parts[part].positions.iter().enumerate();
        let place = |axis: usize, cells: f64| match self.lines.spacing() {
            Some(spacing) => cells * spacing[axis],
            None => self.lines.at(axis, cells) - self.lines.origin()[axis],
        };
        positions.map(|(index, &cells)| place(index % 3, cells.into()) as f32).collect()
    }

    /// Indices of a part, three a triangle.
    pub fn indices(&self, part: usize) -> Vec<u32> {
        self.skin.parts[part].indices.clone()
    }
}
