//! Sources: the files of a job, read, become its geometries.
//!
//! A job, one read file for each of its entries -> geometries in meshing order. All solids of a file are one
//! geometry, unless the job takes one solid or splits them.

use std::io::{ErrorKind, Read};
use std::sync::Arc;

use crate::base::checksum::FileHash;
use crate::base::control::{Control, at_once};
use crate::base::error::{Error, Result};
use crate::base::finding::{Finding, Remedy};
use crate::base::length::Length;
use crate::base::parallel::beside;
use crate::input::geometry::{Facet, Fill, Geometry, SharedFacets};
use crate::input::job::{GeometryJob, Job};
use crate::input::read::{Contents, Format, ReadAt, Reader, Solid};
use crate::input::surface::doubled_area_vector;
use hexcast_job::input::choices::check_n_geometries;

/// Bytes that are read at a time.
const CHUNK_BYTES: usize = 1 << 20;

/// A file that was read, or facets that were in memory.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Source {
    /// Its name as the job has it.
    pub file: String,
    /// What it held.
    pub contents: Contents,
    /// BLAKE3 of its bytes, in hexadecimal, as `b3sum` prints it; None where they were not hashed.
    pub blake3: Option<String>,
}

impl Source {
    /// Takes what was read, with the hash of the bytes if the caller has made one.
    pub fn new(file: impl Into<String>, contents: Contents, blake3: Option<String>) -> Source {
        Source { file: file.into(), contents, blake3 }
    }

    /// Reads a file of `n_bytes` bytes in chunks, and hashes them at the same time.
    ///
    /// # Errors
    /// Those of [`Reader::push`] and [`Reader::finish`]; `io` where `input` fails; `cancelled`, looked at before every chunk. All but
    /// `cancelled` name the file.
    pub fn read(file: impl Into<String>, n_bytes: u64, input: &mut dyn Read, control: &Control) -> Result<Source> {
        let reader = Reader::within(n_bytes, &control.memory);
        Source::read_with(reader, file.into(), input, control)
    }

    /// The same of a file that can be read again, so that its facets need not be in memory: see [`Reader::again`].
    ///
    /// # Errors
    /// Those of [`Source::read`].
    pub fn read_again(
        file: impl Into<String>,
        n_bytes: u64,
        (input, again): (&mut dyn Read, Arc<dyn ReadAt>),
        control: &Control,
    ) -> Result<Source> {
        let file = file.into();
        let reader = Reader::within(n_bytes, &control.memory).again(&file, again);
        Source::read_with(reader, file, input, control)
    }

    fn read_with(mut reader: Reader, file: String, input: &mut dyn Read, control: &Control) -> Result<Source> {
        let mut hash = FileHash::default();
        let mut next_chunk = |chunk: &mut Vec<u8>| -> Result<usize> {
            control.check()?;
            loop {
                match input.read(chunk) {
                    Ok(n) => return Ok(n),
                    Err(error) if error.kind() == ErrorKind::Interrupted => {}
                    Err(error) => return Err(Error::io(format!("reading {file}"), error)),
                }
            }
        };
        let [mut chunk, mut next] = [vec![0; CHUNK_BYTES], vec![0; CHUNK_BYTES]];
        let mut n = next_chunk(&mut chunk)?;
        while n > 0 {
            let take_and_go_on = || {
                reader.push(&chunk[..n]).map_err(|error| error.at(&file))?;
                next_chunk(&mut next)
            };
            n = beside(|| hash.update(&chunk[..n]), take_and_go_on)?;
            std::mem::swap(&mut chunk, &mut next);
        }
        let contents = reader.finish().map_err(|error| error.at(&file))?;
        Ok(Source::new(file, contents, Some(hash.finish())))
    }

    /// Takes facets that are in memory; `file` names them. They are not hashed.
    ///
    /// # Errors
    /// `stl-empty` where there is no facet; `stl-not-finite` where a coordinate is NaN or infinite.
    pub fn from_facets(file: impl Into<String>, facets: Vec<Facet>) -> Result<Source> {
        let file = file.into();
        if facets.is_empty() {
            return Err(Error::new("stl-empty", format!("{file}: there are no facets"), "give at least one"));
        }
        let zero_area = facets.iter().filter(|facet| doubled_area_vector(facet) == [0.0; 3]).count() as u64;
        let facets = SharedFacets::from(facets);
        facets.check_finite(&file)?;
        let (n_facets, n_bytes) = (facets.len() as u64, 36 * facets.len() as u64);
        let contents = Contents {
            format: Format::Facets,
            n_facets,
            n_bytes,
            unit: None,
            solids: vec![Solid { name: String::new(), facets }],
            wrong_normals: 0,
            zero_normals: 0,
            zero_area,
            has_colours: false,
            conversion: None,
            warnings: Vec::new(),
        };
        Ok(Source::new(file, contents, None))
    }
}

/// Makes the geometries of a job from its files: `sources[i]` is the file of `job.geometries[i]`.
///
/// A geometry without a flag gets its position in the resulting list, from 1; without a name, that of its solid or file.
///
/// # Errors
/// `job-conflict`: another number of sources than of entries; those of [`Geometry::new`]; `job-value`: a solid that the file does not have, or a flag past 255;
/// `too-many-geometries`; `io` where facets stay in their file, and that cannot be read again.
pub fn geometries(job: &Job, sources: Vec<Source>) -> Result<Vec<Geometry>> {
    let (n_wanted, n_found) = (job.geometries.len(), sources.len());
    if n_wanted != n_found {
        let message = format!("the job has {n_wanted} geometries, but there are {n_found} sources");
        return Err(Error::new("job-conflict", message, "give the source of each geometry, in their order"));
    }
    let mut geometries = Vec::new();
    for ((position, entry), source) in job.geometries.iter().enumerate().zip(sources) {
        for (index, Part { name, facets, pieces_in_file, solids }) in
            parts((entry, job.splits(entry)), source.contents.solids)?.into_iter().enumerate()
        {
            let flag = match entry.flag {
                Some(first) if entry.same_flag => usize::from(first),
                Some(first) => usize::from(first) + index,
                None => geometries.len() + 1,
            };
            let Ok(flag) = u8::try_from(flag) else {
                let message = format!("geometry \"{name}\" would get flag {flag}: flags are 1 to 255");
                return Err(Error::new(
                    "job-value",
                    message,
                    "give flags; those of the solids of a file can be the same (same_flag)",
                ));
            };
            let mut geometry = Geometry::new(name, flag, facets)?;
            (geometry.entry, geometry.pieces_in_file, geometry.solids) = (position, pieces_in_file, solids);
            geometry.has_default_flag = entry.flag.is_none();
            geometry.priority = entry.priority;
            geometry.open = entry.open.unwrap_or(job.open);
            geometry.shell = entry.shell;
            geometry.invert = entry.invert || job.invert;
            geometry.sizing = entry.sizing();
            geometry.material = entry.material;
            geometry.fill = match entry.fill.unwrap_or(job.fill) {
                Fill::Centre if entry.shell => Fill::Separating,
                fill => fill,
            };
            geometry.world_from_file = entry.world_from_file();
            if geometry.facets.stay_in_file() {
                // what stays in its file is measured once, here, where it can fail
                at_once(geometry.measured(&Control::default()))?;
            }
            geometries.push(geometry);
        }
    }
    check_n_geometries(geometries.len(), "the files hold")?;
    Ok(geometries)
}

/// The unit of a mesh, and findings about files that are in another: that of the job; where it gives none, that of the files which say
/// one (3MF, GLB) and are not scaled, if they agree. Nothing is scaled for it.
pub fn unit(job: &Job, sources: &[Source]) -> (Option<String>, Vec<Finding>) {
    let entries = job.geometries.iter().enumerate().zip(sources).filter(|((_, entry), _)| entry.scale.is_none());
    let said = entries.filter_map(|((entry, _), source)| Some((entry, &source.file[..], source.contents.unit?)));
    let said: Vec<(usize, &str, &str)> = said.collect();
    let Some((_, first, unit)) = said.first().copied() else { return (job.unit.clone(), Vec::new()) };
    let (wanted, whose) = match &job.unit {
        Some(unit) => (&unit[..], "the job".to_string()),
        None => (unit, first.to_string()),
    };
    // a word that nobody knows may mean any unit
    let length = Length::of_name(wanted);
    let others = said.iter().filter(|(.., unit)| length.is_some() && Length::of_name(unit) != length);
    let finding = |&(entry, file, unit): &(usize, &str, &str)| {
        let sentence =
            format!("{file} is in {unit}, {whose} in {wanted}: numbers are taken as they are; give the file a scale");
        let scale = length.zip(Length::of_name(unit)).map(|(length, of_file)| of_file.metres(1.0) / length.metres(1.0));
        let scaled = scale
            .map(|scale| Remedy::of_entry(format!("Scale {file} by {scale}"), (entry, file), "scale", scale.into()));
        Finding::new("unit-differs", sentence).with_count("entry", entry as u64).with_remedy(scaled)
    };
    let findings: Vec<Finding> = others.map(finding).collect();
    let unit = if job.unit.is_none() && !findings.is_empty() { None } else { Some(wanted.to_string()) };
    (unit, findings)
}

/// Named facets that an entry of the job takes from its file, and where they are in it.
struct Part {
    name: String,
    facets: SharedFacets,
    pieces_in_file: Vec<[u64; 2]>,
    solids: Vec<(u64, String)>,
}

fn parts((entry, is_split): (&GeometryJob, bool), solids: Vec<Solid>) -> Result<Vec<Part>> {
    let stem = stem(&entry.file);
    let ends = solids.iter().scan(0, |end, solid| {
        *end += solid.facets.len() as u64;
        Some(*end)
    });
    let starts: Vec<u64> = [0].into_iter().chain(ends).collect();
    if is_split {
        let named = solids.into_iter().enumerate().map(|(index, solid)| {
            let name = if solid.name.is_empty() { format!("{stem}:{}", index + 1) } else { solid.name };
            Part { name, facets: solid.facets, pieces_in_file: vec![[0, starts[index]]], solids: Vec::new() }
        });
        return Ok(named.collect());
    }
    if let Some(wanted) = &entry.solid {
        let names: Vec<String> = solids.iter().map(|solid| solid.name.clone()).collect();
        let mut pieces_in_file = Vec::new();
        let mut n_taken = 0;
        for (solid, start) in solids.iter().zip(starts).filter(|(solid, _)| solid.name == *wanted) {
            pieces_in_file.push([n_taken, start]);
            n_taken += solid.facets.len() as u64;
        }
        let taken = joined(solids.into_iter().filter(|solid| solid.name == *wanted));
        if taken.is_empty() {
            let missing = format!("{}: there is no solid \"{wanted}\"", entry.file);
            if names.iter().all(String::is_empty) {
                let message = format!("{missing}; its {} have no names", names.len());
                return Err(Error::new(
                    "job-value",
                    message,
                    "leave out solid: binary files hold one, and not every ASCII file names its own",
                ));
            }
            return Err(Error::new(
                "job-value",
                format!("{missing}; it has: {}", names.join(", ")),
                "name one of these",
            ));
        }
        let name = entry.name.clone().unwrap_or_else(|| format!("{stem}:{wanted}"));
        return Ok(vec![Part { name, facets: taken, pieces_in_file, solids: Vec::new() }]);
    }
    let name = entry.name.clone().unwrap_or(stem);
    let named = match solids.len() {
        0 | 1 => Vec::new(),
        _ => starts.into_iter().zip(&solids).map(|(start, solid)| (start, solid.name.clone())).collect(),
    };
    Ok(vec![Part { name, facets: joined(solids), pieces_in_file: Vec::new(), solids: named }])
}

fn joined(solids: impl IntoIterator<Item = Solid>) -> SharedFacets {
    SharedFacets::join(&solids.into_iter().map(|solid| solid.facets).collect::<Vec<_>>())
}

/// Name of a file without folder and extension.
fn stem(file: &str) -> String {
    let name = file.rsplit(['/', '\\']).next().unwrap_or_default();
    let name = name.strip_suffix(".gz").filter(|name| name.contains('.')).unwrap_or(name);
    match name.rsplit_once('.') {
        Some((stem, _)) if !stem.is_empty() => stem.to_string(),
        _ => name.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::read::read_bytes;
    use crate::set;

    const TWO: &str = "solid lid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n\
                       solid\nfacet normal 0 0 1\nouter loop\nvertex 5 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n";

    fn made(entries: Vec<GeometryJob>) -> Result<Vec<Geometry>> {
        let source = |entry: &GeometryJob| Source::new(entry.file.clone(), read_bytes(TWO.as_bytes()).unwrap(), None);
        let sources = entries.iter().map(source).collect();
        geometries(&set!(Job { geometries: entries, ..Job::default() }), sources)
    }

    #[test]
    fn solids_are_joined_picked_or_split() {
        let whole = GeometryJob::new("parts/case.stl");
        let lid = set!(GeometryJob { solid: Some("lid".into()), flag: Some(9), ..whole.clone() });
        let split = set!(GeometryJob { split: true, priority: 3, ..whole.clone() });
        let made = made(vec![whole, lid, split]).unwrap();
        let facts: Vec<_> = made.iter().map(|g| (g.name.as_str(), g.flag, g.priority, g.facets.len())).collect();
        assert_eq!(facts, [("case", 1, 0, 2), ("case:lid", 9, 0, 1), ("lid", 3, 3, 1), ("case:2", 4, 3, 1)]);
        assert_eq!(made.iter().map(|geometry| geometry.facet_in_file(0)).collect::<Vec<_>>(), [0, 0, 0, 1]);
        assert_eq!(made[0].facet_in_file(1), 1);
    }

    #[test]
    fn a_file_is_read_and_hashed_in_chunks_and_errors_name_it() {
        let read = |mut bytes: &[u8], control: &Control| Source::read("a.stl", TWO.len() as u64, &mut bytes, control);
        let source = read(TWO.as_bytes(), &Control::default()).unwrap();
        assert_eq!((source.file.as_str(), source.contents), ("a.stl", read_bytes(TWO.as_bytes()).unwrap()));
        assert_eq!(source.blake3, Some(blake3::hash(TWO.as_bytes()).to_string()));
        let error = read(&TWO.as_bytes()[..100], &Control::default()).unwrap_err();
        assert!(error.code() == "io" && error.to_string().starts_with("a.stl: "), "{error}");
        let control = Control::default();
        control.cancel.cancel();
        assert_eq!(read(TWO.as_bytes(), &control), Err(Error::Cancelled));
    }

    /// Gives some bytes at a time, and is interrupted now and then.
    struct Hesitant<'a>(&'a [u8], usize);

    impl Read for Hesitant<'_> {
        fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
            self.1 += 1;
            let n = buffer.len().min(700_001);
            if self.1.is_multiple_of(3) { Err(ErrorKind::Interrupted.into()) } else { self.0.read(&mut buffer[..n]) }
        }
    }

    #[test]
    fn a_file_of_many_chunks_is_hashed_in_their_order() {
        let facets = (0..60_000u16).map(|n| [[0.0, 0.0, f32::from(n)], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        let mut bytes = [&[0; 80][..], &60_000u32.to_le_bytes()].concat();
        for facet in facets {
            let numbers =
                [[0.0; 3]].iter().chain(&facet).flatten().flat_map(|c: &f32| c.to_le_bytes()).collect::<Vec<_>>();
            bytes.extend([&numbers[..], &[0; 2]].concat());
        }
        let n_bytes = bytes.len() as u64;
        let source = Source::read("a.stl", n_bytes, &mut Hesitant(&bytes, 0), &Control::default()).unwrap();
        assert_eq!(source.contents, read_bytes(&bytes).unwrap());
        assert_eq!(source.blake3, Some(blake3::hash(&bytes).to_string()));
    }

    #[test]
    fn facets_in_memory_are_a_source_like_those_of_a_file() {
        let facet = |z: f32| [[0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]];
        let flat = [[0.0; 3], [1.0; 3], [2.0; 3]];
        let facets = vec![facet(0.0), facet(1.5), flat];
        let source = Source::from_facets("part", facets).unwrap();
        assert_eq!((source.contents.n_facets, source.contents.zero_area, source.contents.n_bytes), (3, 1, 108));
        assert_eq!(source.blake3, None);
        let made =
            geometries(&set!(Job { geometries: vec![GeometryJob::new("part")], ..Job::default() }), vec![source])
                .unwrap();
        assert_eq!((made[0].name.as_str(), &made[0].facets.slice()[1]), ("part", &facet(1.5)));
        assert_eq!(Source::from_facets("part", vec![]).unwrap_err().code(), "stl-empty");
        let error = Source::from_facets("part", vec![facet(0.0), facet(f32::NAN)]).unwrap_err();
        assert_eq!((error.code(), error.to_string().as_str()), ("stl-not-finite", "part: number 2 of facet 1 is NaN"));
    }

    #[test]
    fn a_solid_that_is_not_there_and_flags_past_255_are_named() {
        let missing = set!(GeometryJob { solid: Some("box".into()), ..GeometryJob::new("a.stl") });
        assert!(made(vec![missing]).unwrap_err().to_string().contains("\"box\"; it has: lid, "));
        let high = set!(GeometryJob { split: true, flag: Some(255), ..GeometryJob::new("a.stl") });
        assert_eq!(made(vec![high]).unwrap_err().code(), "job-value");
    }
}
