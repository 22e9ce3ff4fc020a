//! Sources: the files of a job, read, become its geometries.
//!
//! A job, one read file for each of its entries -> geometries in meshing order. All solids of a file are one
//! geometry, unless the job takes one solid or splits them.

use crate::error::{Error, Result};
use crate::geometry::{Fill, Geometry, SharedFacets};
use crate::job::{GeometryJob, Job};
use crate::read::{Contents, Solid};

/// A file that was read.
#[derive(Debug, Clone, PartialEq)]
pub struct Source {
    /// Its name as the job has it.
    pub file: String,
    /// What it held.
    pub contents: Contents,
    /// SHA-256 of its bytes, in hexadecimal.
    pub sha256: String,
}

/// Makes the geometries of a job from its files: `sources[i]` is the file of `job.geometries[i]`.
///
/// A geometry without a flag gets its position in the resulting list, from 1; without a name, that of its solid or file.
///
/// # Errors
/// `job-value`: a solid that the file does not have, or a flag past 255; `too-many-geometries`.
pub fn geometries(job: &Job, sources: Vec<Source>) -> Result<Vec<Geometry>> {
    let mut geometries = Vec::new();
    for (entry, source) in job.geometries.iter().zip(sources) {
        for (index, Part { name, facets, pieces_in_file }) in
            parts(entry, source.contents.solids)?.into_iter().enumerate()
        {
            let flag = match entry.flag {
                Some(first) => usize::from(first) + index,
                None => geometries.len() + 1,
            };
            let Ok(flag) = u8::try_from(flag) else {
                let message = format!("geometry \"{name}\" would get flag {flag}: flags are 1 to 255");
                return Err(Error::new("job-value", message, "give flags, or join geometries of the same substance"));
            };
            let mut geometry = Geometry::new(name, flag, facets);
            geometry.pieces_in_file = pieces_in_file;
            geometry.has_default_flag = entry.flag.is_none();
            geometry.priority = entry.priority;
            geometry.open = entry.open.unwrap_or(job.open);
            geometry.shell = entry.shell;
            geometry.invert = entry.invert;
            geometry.fill = match entry.fill.unwrap_or(job.fill) {
                Fill::Centre if entry.shell => Fill::Separating,
                fill => fill,
            };
            geometry.world_from_file = entry.world_from_file();
            geometries.push(geometry);
        }
    }
    if geometries.len() > 255 {
        let message = format!("the files hold {} geometries: at most 255 fit", geometries.len());
        return Err(Error::new("too-many-geometries", message, "join solids of the same substance"));
    }
    Ok(geometries)
}

/// Named facets that an entry of the job takes from its file, and where they are in it.
struct Part {
    name: String,
    facets: SharedFacets,
    pieces_in_file: Vec<[u64; 2]>,
}

fn parts(entry: &GeometryJob, solids: Vec<Solid>) -> Result<Vec<Part>> {
    let stem = stem(&entry.file);
    let ends = solids.iter().scan(0, |end, solid| {
        *end += solid.facets.len() as u64;
        Some(*end)
    });
    let starts: Vec<u64> = [0].into_iter().chain(ends).collect();
    if entry.split {
        let named = solids.into_iter().enumerate().map(|(index, solid)| {
            let name = if solid.name.is_empty() { format!("{stem}:{}", index + 1) } else { solid.name };
            Part { name, facets: solid.facets, pieces_in_file: vec![[0, starts[index]]] }
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
        return Ok(vec![Part { name, facets: taken, pieces_in_file }]);
    }
    let name = entry.name.clone().unwrap_or(stem);
    Ok(vec![Part { name, facets: joined(solids), pieces_in_file: Vec::new() }])
}

fn joined(solids: impl IntoIterator<Item = Solid>) -> SharedFacets {
    SharedFacets::join(&solids.into_iter().map(|solid| solid.facets).collect::<Vec<_>>())
}

/// Name of a file without folder and extension.
fn stem(file: &str) -> String {
    let name = file.rsplit(['/', '\\']).next().unwrap_or_default();
    match name.rsplit_once('.') {
        Some((stem, _)) if !stem.is_empty() => stem.to_string(),
        _ => name.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read::read_bytes;

    const TWO: &str = "solid lid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n\
                       solid\nfacet normal 0 0 1\nouter loop\nvertex 5 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n";

    fn made(entries: Vec<GeometryJob>) -> Result<Vec<Geometry>> {
        let source = |entry: &GeometryJob| Source {
            file: entry.file.clone(),
            contents: read_bytes(TWO.as_bytes()).unwrap(),
            sha256: String::new(),
        };
        let sources = entries.iter().map(source).collect();
        geometries(&Job { geometries: entries, ..Job::default() }, sources)
    }

    #[test]
    fn solids_are_joined_picked_or_split() {
        let whole = GeometryJob::new("parts/case.stl");
        let lid = GeometryJob { solid: Some("lid".into()), flag: Some(9), ..whole.clone() };
        let split = GeometryJob { split: true, priority: 3, ..whole.clone() };
        let made = made(vec![whole, lid, split]).unwrap();
        let facts: Vec<_> = made.iter().map(|g| (g.name.as_str(), g.flag, g.priority, g.facets.len())).collect();
        assert_eq!(facts, [("case", 1, 0, 2), ("case:lid", 9, 0, 1), ("lid", 3, 3, 1), ("case:2", 4, 3, 1)]);
        assert_eq!(made.iter().map(|geometry| geometry.facet_in_file(0)).collect::<Vec<_>>(), [0, 0, 0, 1]);
        assert_eq!(made[0].facet_in_file(1), 1);
    }

    #[test]
    fn a_solid_that_is_not_there_and_flags_past_255_are_named() {
        let missing = GeometryJob { solid: Some("box".into()), ..GeometryJob::new("a.stl") };
        assert!(made(vec![missing]).unwrap_err().to_string().contains("\"box\"; it has: lid, "));
        let high = GeometryJob { split: true, flag: Some(255), ..GeometryJob::new("a.stl") };
        assert_eq!(made(vec![high]).unwrap_err().code(), "job-value");
    }
}
