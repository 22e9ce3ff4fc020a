//! STL files for the check: the facets of each solid, read with nothing of the mesher's reader.

use hexcast::{Error, Result};

/// The name of a solid and its facets; binary files have one, without a name.
pub(super) type Solid = (String, Vec<[[f32; 3]; 3]>);

/// Reads a binary or ASCII STL; solids without facets are left out.
pub(super) fn solids(file: &str) -> Result<Vec<Solid>> {
    let bytes = std::fs::read(file).map_err(|error| Error::io(format!("reading {file}"), error))?;
    let announced = bytes.get(80..84).map(|count| u32::from_le_bytes([count[0], count[1], count[2], count[3]]));
    let needed = announced.map(|n| 84 + 50 * u64::from(n));
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&bytes).trim_ascii_start();
    let is_ascii =
        needed != Some(bytes.len() as u64) && text.get(..5).is_some_and(|w| w.eq_ignore_ascii_case(b"solid"));
    let mut solids = match (is_ascii, announced) {
        (true, _) => ascii(text).map_err(|what| not_read(file, &what))?,
        (_, Some(n)) if needed <= Some(bytes.len() as u64) => vec![(String::new(), binary(&bytes[84..], n))],
        _ => return Err(not_read(file, &format!("{} bytes that are no whole STL", bytes.len()))),
    };
    solids.retain(|(_, facets)| !facets.is_empty());
    let mut numbers = solids.iter().flat_map(|(_, facets)| facets.as_flattened().as_flattened());
    if solids.is_empty() || numbers.any(|number| !number.is_finite()) {
        return Err(not_read(file, "no facet, or a corner that is not three finite numbers"));
    }
    Ok(solids)
}

fn not_read(file: &str, what: &str) -> Error {
    let hint = "give the file that was meshed; if it was, export it again as binary STL and mesh that";
    Error::new("stl-not-stl", format!("{file}: {what}"), hint)
}

fn binary(records: &[u8], n_facets: u32) -> Vec<[[f32; 3]; 3]> {
    let number = |record: &[u8], index: usize| {
        let at = 12 + 4 * index;
        f32::from_le_bytes([record[at], record[at + 1], record[at + 2], record[at + 3]])
    };
    let facet = |record: &[u8]| [0, 3, 6].map(|first| [0, 1, 2].map(|axis| number(record, first + axis)));
    records.chunks_exact(50).take(n_facets as usize).map(facet).collect()
}

fn ascii(text: &[u8]) -> std::result::Result<Vec<Solid>, String> {
    let mut solids: Vec<Solid> = Vec::new();
    let mut corners = Vec::new();
    for line in text.split(|byte| matches!(byte, b'\n' | b'\r')) {
        let line = String::from_utf8_lossy(line.trim_ascii());
        let (word, rest) = line.split_once(|c: char| c.is_ascii_whitespace()).unwrap_or((&line, ""));
        match word.to_ascii_lowercase().as_str() {
            "solid" => solids.push((rest.trim_ascii().to_string(), Vec::new())),
            "vertex" => {
                let numbers: Vec<f32> = rest.split_ascii_whitespace().filter_map(|word| word.parse().ok()).collect();
                corners.push(<[f32; 3]>::try_from(numbers).map_err(|_| format!("\"{line}\" is not three numbers"))?);
            }
            "endfacet" => {
                let facet = std::mem::take(&mut corners).try_into();
                let facet = facet.map_err(|list: Vec<_>| format!("a facet of {} corners", list.len()))?;
                solids.last_mut().ok_or("a facet before the first solid")?.1.push(facet);
            }
            _ => {}
        }
    }
    Ok(solids)
}
