//! STL files for the check: the facets of each solid, read with nothing of the mesher's reader.

use hexcast::{Error, Result};

/// The name of a solid and its facets; binary files have one, without a name.
pub(super) type Solid = (String, Vec<[[f32; 3]; 3]>);

/// Reads a binary or ASCII STL; solids without facets are left out.
pub(super) fn solids(file: &str) -> Result<Vec<Solid>> {
    let bytes = std::fs::read(file).map_err(|error| Error::io(format!("reading {file}"), error))?;
    let count = bytes.get(80..).and_then(<[u8]>::first_chunk).map_or(u32::MAX, |count| u32::from_le_bytes(*count));
    let n_bytes = 84 + 50 * u64::from(count);
    let is_other = [&b"glTF"[..], b"PK", b"\x1f\x8b", b"ply"].iter().any(|magic| bytes.starts_with(magic));
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&bytes).trim_ascii_start();
    let says_solid = text.get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    let read = match n_bytes.cmp(&(bytes.len() as u64)) {
        std::cmp::Ordering::Equal => Ok(binary(&bytes[84..])),
        _ if says_solid => ascii(text),
        _ if is_other => Err(format!("{} bytes that are no STL", bytes.len())),
        std::cmp::Ordering::Less => Ok(binary(&bytes[84..n_bytes as usize])),
        std::cmp::Ordering::Greater => Err(format!("{} bytes that are not a complete STL", bytes.len())),
    };
    let checked = read.and_then(|mut solids| {
        solids.retain(|(_, facets)| !facets.is_empty());
        let mut numbers = solids.iter().flat_map(|(_, facets)| facets.as_flattened().as_flattened());
        let is_sound = !solids.is_empty() && numbers.all(|number| number.is_finite());
        if is_sound { Ok(solids) } else { Err("no facet, or a corner that is not three finite numbers".into()) }
    });
    let hint = "give the file that was meshed; if it was, export it again as binary STL and mesh that";
    checked.map_err(|what| Error::new("stl-not-stl", format!("{file}: {what}"), hint))
}

fn binary(records: &[u8]) -> Vec<Solid> {
    let number = |of: &[u8], at| of[at..].first_chunk().map_or(f32::NAN, |bytes| f32::from_le_bytes(*bytes));
    let facet = |of: &[u8]| [12, 24, 36].map(|at| [at, at + 4, at + 8].map(|at| number(of, at)));
    vec![(String::new(), records.chunks_exact(50).map(facet).collect())]
}

fn ascii(text: &[u8]) -> std::result::Result<Vec<Solid>, String> {
    let (mut solids, mut corners) = (Vec::<Solid>::new(), Vec::new());
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
