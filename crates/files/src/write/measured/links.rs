//! The links of cells to surfaces: `.npz`, or records of 24 bytes in `.links`. `docs/links.md` describes both.

use std::io;

use crate::write::archive::Array;
use crate::write::{Compress, Sink, archive};
use hexcast_core::base::control::{Control, at_once};
use hexcast_core::base::error::{Error, Result};
use hexcast_derived::links::{Link, Links};

/// What is written, for errors.
const WHAT: &str = "the links";
/// First bytes of `.links`.
const MAGIC: &[u8; 8] = b"HEXLINKS";
/// Bytes of a record.
const RECORD: usize = 24;

/// A format of links.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum LinksFormat {
    /// NumPy archive: an array for each property of a link.
    Npz,
    /// A head, and a record of 24 bytes for each link.
    Records,
}

impl LinksFormat {
    /// Finds the format by the extension of a file name, upper or lower case.
    ///
    /// # Errors
    /// `job-value` where the extension is neither `.npz` nor `.links`.
    pub fn of_name(name: &str) -> Result<LinksFormat> {
        let extension = name.rsplit_once('.').map_or("", |(_, extension)| extension).to_ascii_lowercase();
        match &extension[..] {
            "npz" => Ok(LinksFormat::Npz),
            "links" => Ok(LinksFormat::Records),
            _ => {
                let message = format!("{name}: no format of links has the extension \"{extension}\"");
                Err(Error::new("job-value", message, "use .npz, .h5 or .links"))
            }
        }
    }
}

/// Writes links; only `.npz` can be compressed. Returns the number of bytes.
///
/// # Errors
/// `io` where `out` fails.
pub fn write_links(links: &Links, format: LinksFormat, compress: Compress, out: &mut dyn io::Write) -> Result<u64> {
    match format {
        LinksFormat::Npz => archive::write_named(&arrays(links), WHAT, compress, out),
        LinksFormat::Records => at_once(write_records(links, out, &Control::default())),
    }
}

/// Writes the head, then the records of each plane of cells, with a rest before each. Returns the number of bytes.
///
/// # Errors
/// `io` where `out` fails; `cancelled`.
pub async fn write_records(links: &Links, out: &mut dyn io::Write, control: &Control) -> Result<u64> {
    let mut sink = Sink::new(out, WHAT);
    sink.put(&head(links))?;
    for plane in &links.planes {
        control.rest().await?;
        let mut records = Vec::with_capacity(RECORD * plane.len());
        plane.iter().for_each(|link| records.extend_from_slice(&record(link)));
        sink.put(&records)?;
    }
    sink.finish()
}

/// The arrays of `.npz`.
pub fn arrays(of: &Links) -> Vec<Array<'_>> {
    let directions = of.stencil.directions();
    let n_directions = directions.len() as u64;
    let steps = move |_| Ok(directions.as_flattened().iter().map(|&step| step as u8).collect());
    let link = |named, put| Array::of_parts(named, &of.planes, |links: &Vec<Link>| links, put);
    vec![
        Array::new(("directions", "|i1"), &[n_directions, 3], 1, steps),
        Array::of_list(("dims", "<u4"), &of.dims, |n, out| out.extend(n.to_le_bytes())),
        Array::of_list(("origin", "<i4"), &of.origin, |n, out| out.extend(n.to_le_bytes())),
        Array::of_list(("fluid", "|u1"), &of.fluid, |flag, out| out.push(*flag)),
        link(("x", "<u4"), |link: &Link, out: &mut Vec<u8>| out.extend(link.cell[0].to_le_bytes())),
        link(("y", "<u4"), |link, out| out.extend(link.cell[1].to_le_bytes())),
        link(("z", "<u4"), |link, out| out.extend(link.cell[2].to_le_bytes())),
        link(("direction", "|u1"), |link, out| out.push(link.direction)),
        link(("q", "<f4"), |link, out| out.extend(link.q.to_le_bytes())),
        link(("facet", "<i4"), |link, out| out.extend(link.facet.to_le_bytes())),
        link(("geometry", "<i2"), |link, out| out.extend(link.geometry.to_le_bytes())),
        link(("flag", "|u1"), |link, out| out.push(link.flag)),
    ]
}

/// Bytes of `.links`.
#[cfg(target_arch = "wasm32")]
pub fn n_bytes(links: &Links) -> u64 {
    (head(links).len() + RECORD * links.len()) as u64
}

/// Magic, version, number of directions, dims, number of links; of a window its origin; then the directions, padded to a multiple of 8 bytes.
fn head(links: &Links) -> Vec<u8> {
    let directions = links.stencil.directions();
    let [nx, ny, nz] = links.dims;
    let is_of_window = links.origin != [0; 3];
    let version = if is_of_window { 2 } else { 1 };
    let mut head = MAGIC.to_vec();
    let numbers = [version, directions.len() as u32, nx, ny, nz, 0];
    numbers.into_iter().for_each(|number: u32| head.extend(number.to_le_bytes()));
    head.extend((links.len() as u64).to_le_bytes());
    if is_of_window {
        let [x, y, z] = links.origin;
        [x, y, z, 0].into_iter().for_each(|number| head.extend(number.to_le_bytes()));
    }
    head.extend(directions.as_flattened().iter().map(|&step| step as u8));
    head.resize(head.len().next_multiple_of(8), 0);
    head
}

fn record(link: &Link) -> [u8; RECORD] {
    let mut record = [0; RECORD];
    for (axis, at) in link.cell.iter().enumerate() {
        record[4 * axis..4 * axis + 4].copy_from_slice(&at.to_le_bytes());
    }
    record[12..16].copy_from_slice(&link.q.to_le_bytes());
    record[16..20].copy_from_slice(&link.facet.to_le_bytes());
    record[20..22].copy_from_slice(&link.geometry.to_le_bytes());
    (record[22], record[23]) = (link.direction, link.flag);
    record
}
