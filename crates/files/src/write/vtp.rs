//! VTK polygonal data (`.vtp`), for ParaView: the paths of a leak as lines.
//!
//! Leak -> text. The cell array `part` says what is what: 0 a vertex in the middle of the narrowest place, 1 the shortest path, 2
//! the way of the largest cube that passes. Where there is no path the file has no cells. Coordinates are those of the mesh,
//! in the fewest digits that parse back to the same f64.
//! Source: VTK file formats, <https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html#polydata>.

use std::fmt::Write;

use hexcast_derived::leak::Leak;

/// A point or a line of the file.
struct Part<'a> {
    number: u32,
    points: &'a [[f64; 3]],
}

/// Writes the paths of a leak and its narrowest place.
pub fn leak_vtp(leak: &Leak) -> String {
    let narrowest = leak.narrowest.as_ref();
    let vertices: Vec<Part> =
        narrowest.iter().map(|of| Part { number: 0, points: std::slice::from_ref(&of.centre) }).collect();
    let shortest = leak.path.iter().map(|path| Part { number: 1, points: &path.points });
    let lines: Vec<Part> = shortest.chain(narrowest.map(|of| Part { number: 2, points: &of.way })).collect();
    let parts = || vertices.iter().chain(&lines);
    let points: Vec<String> = parts().flat_map(|part| part.points).map(point).collect();
    let numbers: Vec<String> = parts().map(|part| part.number.to_string()).collect();
    let n_vertex_points: usize = vertices.iter().map(|part| part.points.len()).sum();
    let counts =
        [("Points", points.len()), ("Verts", vertices.len()), ("Lines", lines.len()), ("Strips", 0), ("Polys", 0)];
    let counts = counts.map(|(name, n)| format!("NumberOf{name}=\"{n}\"")).join(" ");
    [
        "<?xml version=\"1.0\"?>\n".into(),
        "<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n".into(),
        format!("  <PolyData>\n    <Piece {counts}>\n"),
        section("CellData Scalars=\"part\"", &[array("type=\"Int32\" Name=\"part\"", &numbers)]),
        section("Points", &[array("type=\"Float64\" Name=\"points\" NumberOfComponents=\"3\"", &points)]),
        cells("Verts", &vertices, 0),
        cells("Lines", &lines, n_vertex_points),
        "    </Piece>\n  </PolyData>\n</VTKFile>\n".into(),
    ]
    .concat()
}

/// The points of each part, counted from `first`, and where they end.
fn cells(name: &str, parts: &[Part], first: usize) -> String {
    let ends: Vec<usize> = parts
        .iter()
        .scan(0, |end, part| {
            *end += part.points.len();
            Some(*end)
        })
        .collect();
    let of_parts = 0..ends.last().copied().unwrap_or(0);
    let connectivity: Vec<String> = of_parts.map(|point| (first + point).to_string()).collect();
    let ends: Vec<String> = ends.iter().map(usize::to_string).collect();
    section(
        name,
        &[
            array("type=\"Int64\" Name=\"connectivity\"", &connectivity),
            array("type=\"Int64\" Name=\"offsets\"", &ends),
        ],
    )
}

fn section(start: &str, arrays: &[String]) -> String {
    let name = start.split(' ').next().unwrap_or_default();
    format!("      <{start}>\n{}      </{name}>\n", arrays.concat())
}

fn array(attributes: &str, values: &[String]) -> String {
    let mut text = format!("        <DataArray {attributes} format=\"ascii\">\n");
    for value in values {
        let _ = writeln!(text, "          {value}"); // writing to a String cannot fail
    }
    text + "        </DataArray>\n"
}

fn point([x, y, z]: &[f64; 3]) -> String {
    format!("{x:?} {y:?} {z:?}")
}
