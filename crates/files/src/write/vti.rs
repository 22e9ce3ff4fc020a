//! `.vti` and `.vtr`: VTK image data, or a rectilinear grid, an XML head and the flags appended as raw bytes or zlib blocks.
//!
//! Cells are VTK cells, nodes VTK points: the extent counts mesh lines, `0 nx 0 ny 0 nz`, from the origin in steps of the spacing; `.vtr` lists them in
//! its head, in digits that read back to the same f64. The
//! cell array is `flag` (UInt8, x fastest); the field data carry `unit`, `flag_values`, `flag_names` and, of
//! jobs with materials, `flag_materials` as JSON.
//! `header_type` is UInt64, so that nothing ends at 4 GiB.
//!
//! Compressed, the sizes of all blocks precede the first block. The blocks are made once, in parallel, and cached while
//! they fit `block_cache_bytes`; those beyond, if any, are made a second time when their turn comes. Flags of fine
//! meshes compress fiftyfold and more, so that the second time is for 1e10 cells and up, and memory is bounded for all.
//! Cost: two slabs, the cached blocks, and 8 bytes a block of 1 MiB.
//!
//! Source: the VTK XML formats, `vtkXMLDataReader` and `vtkZLibDataCompressor`.

use std::fmt::Write;

use hexcast_core::base::control::Control;
use hexcast_core::base::error::Result;
use hexcast_core::base::zlib::Blocks;
use hexcast_core::grid::lines::{AXES, Lines};
use hexcast_derived::mesh::Mesh;

use super::cells::Cells;
use super::{Compress, Format, Sink};

const BLOCK_BYTES: usize = 1 << 20;
const FOOT: &[u8] = b"\n  </AppendedData>\n</VTKFile>\n";

/// Writes a compressed file.
pub(super) async fn write(
    cells: &Cells<'_>,
    (format, level): (Format, u8),
    sink: &mut Sink<'_>,
    control: &Control,
) -> Result<()> {
    let table = BlockTable::new(cells, level, control).await?;
    sink.put(head(cells, format).as_bytes())?;
    sink.put(&table.numbers(n_bytes(cells)))?;
    sink.put(&table.cached)?;
    #[cfg(not(target_arch = "wasm32"))]
    table.write_others(cells, level, sink, control).await?;
    sink.put(FOOT)
}

/// Everything before and after the numbers of an uncompressed file.
pub(super) fn head_and_tail(cells: &Cells, format: Format) -> (Vec<u8>, Vec<u8>) {
    let mut before = head(cells, format).into_bytes();
    before.extend(n_bytes(cells).to_le_bytes());
    (before, FOOT.to_vec())
}

/// Bytes of the numbers; a mesh for whose cells 64 bits are too few is never made.
fn n_bytes(cells: &Cells) -> u64 {
    cells.n_bytes().unwrap_or(u64::MAX)
}

/// The sizes of all compressed blocks, and the first of the blocks themselves.
struct BlockTable {
    sizes: Vec<u64>,
    cached: Vec<u8>,
    n_cached: usize,
}

impl BlockTable {
    async fn new(cells: &Cells<'_>, level: u8, control: &Control) -> Result<BlockTable> {
        let mut table = BlockTable { sizes: Vec::new(), cached: Vec::new(), n_cached: 0 };
        let mut blocks = Blocks::new(BLOCK_BYTES, level);
        // in wasm all: there nobody waits for a second time
        let most = if cfg!(target_arch = "wasm32") { usize::MAX } else { cells.options.block_cache_bytes };
        let mut push = |bytes: &[u8]| {
            blocks.push(bytes)?.iter().for_each(|block| table.add(block, most));
            Ok(())
        };
        cells.each(control, &mut push).await?;
        blocks.finish()?.iter().for_each(|block| table.add(block, most));
        Ok(table)
    }

    fn add(&mut self, block: &[u8], block_cache_bytes: usize) {
        if self.n_cached == self.sizes.len() && self.cached.len() + block.len() <= block_cache_bytes {
            self.cached.extend_from_slice(block);
            self.n_cached += 1;
        }
        self.sizes.push(block.len() as u64);
    }

    /// Everything before the first block.
    fn numbers(&self, n_bytes: u64) -> Vec<u8> {
        let partial = n_bytes % BLOCK_BYTES as u64;
        let counts = [self.sizes.len() as u64, BLOCK_BYTES as u64, partial];
        counts.iter().chain(&self.sizes).flat_map(|number| number.to_le_bytes()).collect()
    }

    /// Writes the blocks that are not cached, which are made a second time.
    #[cfg(not(target_arch = "wasm32"))]
    async fn write_others(&self, cells: &Cells<'_>, level: u8, sink: &mut Sink<'_>, control: &Control) -> Result<()> {
        if self.n_cached == self.sizes.len() {
            return Ok(());
        }
        let mut sizes = self.sizes[self.n_cached..].iter();
        let mut put = |block: &[u8]| match sizes.next() {
            Some(&size) if size == block.len() as u64 => sink.put(block),
            _ => {
                let message = "a block compressed to another size the second time";
                Err(hexcast_core::base::error::Error::new("io", message, "write without compression"))
            }
        };
        let mut to_skip = self.n_cached as u64 * BLOCK_BYTES as u64;
        let mut blocks = Blocks::new(BLOCK_BYTES, level);
        let mut push = |bytes: &[u8]| {
            let skipped = to_skip.min(bytes.len() as u64);
            to_skip -= skipped;
            blocks.push(&bytes[skipped as usize..])?.iter().try_for_each(|block| put(block))
        };
        cells.each(control, &mut push).await?;
        blocks.finish()?.iter().try_for_each(|block| put(block))
    }
}

/// Everything before the appended data.
fn head(cells: &Cells, format: Format) -> String {
    let Cells { mesh, options, .. } = cells;
    let (name, type_name) = cells.kind();
    let of = if cells.are_of_nodes() { "PointData" } else { "CellData" };
    let [nx, ny, nz] = mesh.dims();
    let extent = format!("0 {nx} 0 {ny} 0 {nz}");
    let compressor = match options.compress {
        Compress::None => "",
        Compress::Zlib(_) => " compressor=\"vtkZLibDataCompressor\"",
    };
    let (kind, place, coordinates) = match format {
        Format::Vtr => ("RectilinearGrid", String::new(), coordinates(mesh.lines())),
        _ => {
            let [origin, spacing] = [mesh.lines().origin(), mesh.lines().smallest()].map(three);
            ("ImageData", format!(" Origin=\"{origin}\" Spacing=\"{spacing}\""), String::new())
        }
    };
    format!(
        r#"<?xml version="1.0"?>
<VTKFile type="{kind}" version="1.0" byte_order="LittleEndian" header_type="UInt64"{compressor}>
  <{kind} WholeExtent="{extent}"{place}>
{field_data}    <Piece Extent="{extent}">
      <{of} Scalars="{name}">
        <DataArray type="{type_name}" Name="{name}" format="appended" offset="0"/>
      </{of}>
{coordinates}    </Piece>
  </{kind}>
  <AppendedData encoding="raw">
   _"#,
        field_data = field_data(mesh),
    )
}

/// The lines of each axis.
fn coordinates(lines: &Lines) -> String {
    let mut text = String::from("      <Coordinates>\n");
    for (axis, name) in AXES.into_iter().enumerate() {
        let numbers: Vec<String> = lines.list(axis).iter().map(|line| format!("{line:?}")).collect();
        // writing to a String cannot fail
        let _ = writeln!(
            text,
            r#"        <DataArray type="Float64" Name="{name}" format="ascii">{}</DataArray>"#,
            numbers.join(" ")
        );
    }
    text + "      </Coordinates>\n"
}

/// Three numbers that parse back to the same f64.
fn three(numbers: [f64; 3]) -> String {
    let [x, y, z] = numbers;
    format!("{x:?} {y:?} {z:?}")
}

fn field_data(mesh: &Mesh) -> String {
    let mut arrays = String::new();
    if let Some(unit) = mesh.unit() {
        arrays += &strings("unit", [unit].into_iter());
    }
    if !mesh.names().is_empty() {
        let values: Vec<String> = mesh.names().iter().map(|named| named.flag.to_string()).collect();
        let (n, values) = (values.len(), values.join(" "));
        // writing to a String cannot fail
        let _ = writeln!(
            arrays,
            r#"      <DataArray type="UInt8" Name="flag_values" NumberOfTuples="{n}" format="ascii">{values}</DataArray>"#
        );
        arrays += &strings("flag_names", mesh.names().iter().map(|named| named.name.as_str()));
        let materials: Vec<_> = mesh.names().iter().map(|named| named.material.json()).collect();
        if materials.iter().any(Option::is_some) {
            arrays += &strings("flag_materials", materials.iter().map(|json| json.as_deref().unwrap_or("{}")));
        }
    }
    if arrays.is_empty() { arrays } else { format!("    <FieldData>\n{arrays}    </FieldData>\n") }
}

/// An array of strings the way VTK spells it: the UTF-8 bytes as decimal numbers, each string ended by 0. Names need no
/// escaping that way.
fn strings<'a>(name: &str, values: impl Iterator<Item = &'a str>) -> String {
    let mut n = 0;
    let mut numbers = String::new();
    for value in values {
        n += 1;
        // a 0 inside a name would end it early
        value.bytes().filter(|&byte| byte != 0).chain([0]).for_each(|byte| {
            let _ = write!(numbers, "{byte} ");
        });
    }
    let numbers = numbers.trim_end();
    format!(
        "      <DataArray type=\"String\" Name=\"{name}\" NumberOfTuples=\"{n}\" format=\"ascii\">{numbers}</DataArray>\n"
    )
}
