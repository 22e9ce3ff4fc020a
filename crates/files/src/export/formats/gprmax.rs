//! gprMax 4: the cells of some flags as an array of materials.
//!
//! Three files: `NAME.in` has the size of the domain and of the cells, in metres, and reads the geometry; it is to be included in the user's
//! (`#include_file: NAME.in`), which has time, sources and receivers. `NAME_geo.h5` has for each cell the place of its material, 16 bits, x
//! slowest, and -1 where the flag is not kept: gprMax leaves what is there, free space. `NAME_materials.json` has the materials by their keys,
//! `NAME` being the stem of the output in letters, digits and `_`. The box begins at (0, 0, 0), as gprMax has it.
//!
//! Faces of plates are `#plate` of gprMax's own `pec`, behind the cells, so that they win.
//!
//! Interfaces are averaged (`y`): else a cell that is written after its neighbour takes the edges of a conductor beside it. gprMax compares the
//! sizes of cells in both files with `==`, so both are written to the last digit.
//! Source: gprMax 4.0.1, `GeometryObjectsRead` and `material_database`. Cost: some planes of flags across x, and the same as 16 bits.

use serde_json::{Map, Value, json};

use crate::export::{
    decimal,
    electric::{Electric, substances},
    format::Format,
    hdf5::{File, Shape, Table},
    limits::equal_cells,
    names::{names, plain, said},
    output::{Export, Files, Out},
    plates::{self, check_conductors},
    unit::metres,
};
use hexcast_core::base::error::{Error, Result};
use hexcast_derived::mesh::Named;

pub(in crate::export) static FORMAT: Format = Format {
    program: "gprMax 4",
    about: "an array of materials",
    on_disk: "to be included in an input file, with NAME_geo.h5 and NAME_materials.json",
    compresses: true,
    has_plates: true,
    unit: Some((WHAT, "metres")),
    file_names: |name| file_names(name).to_vec(),
    check_lines: |lines| equal_cells(lines, WHAT).map(|_| ()),
    check_materials,
    check_mesh: |mesh, options, keeps| check_conductors(mesh, options, keeps, WHAT),
    held_planes: None,
    ..Format::new(&[".in"], |job, name, files| Box::pin(write(job, name, files)))
};

const WHAT: &str = "gprMax";

fn file_names(name: &str) -> [String; 3] {
    let stem = stem(name);
    [name.to_string(), format!("{stem}_geo.h5"), format!("{stem}_materials.json")]
}

/// The name of an output without its ending, as gprMax takes it for names of materials and files.
fn stem(name: &str) -> String {
    plain(name.rsplit_once('.').map_or(name, |(stem, _)| stem))
}

fn check_materials(names: &[Named], flags: &[u8]) -> Result<()> {
    for (flag, Electric { eps_r, mu_r, pec, .. }) in substances(names, flags, WHAT)? {
        if !pec && eps_r.min(mu_r) < 1.0 {
            let message =
                format!("{} has eps_r {eps_r} and mu_r {mu_r}, and gprMax takes numbers from 1 on", said(names, flag));
            return Err(Error::new("job-value", message, "give it a material that gprMax can compute"));
        }
    }
    Ok(())
}

async fn write(job: &Export<'_>, name: &str, files: &mut dyn Files) -> Result<()> {
    let [input, geometry, database] = file_names(name);
    let of_plates = plates::flags(job.mesh, job.options, WHAT)?;
    // gprMax reads no list without a material
    let mut flags = [job.options.exported(job.mesh), of_plates.clone()].concat();
    flags.sort_unstable();
    flags.dedup();
    let flags = substances(job.mesh.names(), &flags, WHAT)?;
    let names = names(job.mesh, 60, &[]);
    let id = format!("{}_materials", stem(name));
    let unit = metres(job.mesh.unit(), WHAT)?;
    let sizes = equal_cells(job.mesh.lines(), WHAT)?;
    let sizes = [0, 1, 2].map(|axis| unit.metres(decimal::size(job.mesh.lines(), axis, sizes[axis])));
    let dims = job.mesh.dims();
    let [x, y, z] = [0, 1, 2].map(|axis| sizes[axis] * f64::from(dims[axis]));
    let [dx, dy, dz] = sizes;
    let mut out = Out::create(files, &input)?;
    out.text(format_args!(
        "#domain: {x:?} {y:?} {z:?}\n#dx_dy_dz: {dx:?} {dy:?} {dz:?}\n#geometry_objects_read: 0 0 0 {geometry} {id} y\n"
    ))?;
    for flag in of_plates {
        for corners in plates::rectangles(job.mesh, flag) {
            let at = corners.map(|lines| [0, 1, 2].map(|axis| sizes[axis] * f64::from(lines[axis])));
            let [[x0, y0, z0], [x1, y1, z1]] = at;
            out.text(format_args!("#plate: {x0:?} {y0:?} {z0:?} {x1:?} {y1:?} {z1:?} pec\n"))?;
        }
    }
    out.finish()?;

    let mut file = File::create(files, &geometry, 2 * dims.map(u64::from).iter().product::<u64>())?;
    file.numbers("dx_dy_dz", &sizes)?;
    file.text("MaterialDatabase", &id)?;
    file.text("Title", &format!("hexcast {}", env!("CARGO_PKG_VERSION")))?;
    let keys: Vec<&str> = flags.iter().map(|(flag, _)| names[usize::from(*flag)].as_str()).collect();
    file.texts("material_keys", &keys)?;
    let mut places = [-1i16; 256];
    (0i16..).zip(&flags).for_each(|(place, (flag, _))| places[usize::from(*flag)] = place);
    cells(job, &mut file, &places).await?;
    file.finish(files)?;

    let materials: Map<String, Value> = flags
        .iter()
        .map(|(flag, electric)| (names[usize::from(*flag)].clone(), material(&names[usize::from(*flag)], electric)))
        .collect();
    let text = json!({
        "schema": "gprMax-material-database",
        "schema_version": 1,
        "database": { "id": id, "name": id, "version": "1.0.0", "description": "by hexcast" },
        "materials": materials,
    });
    let mut out = Out::create(files, &database)?;
    out.text(format_args!("{text:#}\n"))?;
    out.finish()
}

/// Writes the places of the materials of all cells, some planes across x at a time.
async fn cells(job: &Export<'_>, file: &mut File, places: &[i16; 256]) -> Result<()> {
    let [nx, ny, nz] = job.mesh.dims();
    let shape = [nx, ny, nz].map(|n| n as usize);
    let plane = shape[1] * shape[2];
    let mut table = Table::new(file, Shape { name: "data", dims: &shape, compress: job.options.compress })?;
    // flags, and numbers of 16 bits twice
    let step = (job.options.slab_bytes / (5 * plane)).clamp(1, shape[0]) as u32;
    for start in (0..nx).step_by(step as usize) {
        job.control.rest().await?;
        let end = start.saturating_add(step).min(nx);
        let n = (end - start) as usize;
        let flags = job.mesh.box_flags(&[start..end, 0..ny, 0..nz])?;
        let mut numbers = vec![0i16; flags.len()];
        for x in 0..n {
            for y in 0..shape[1] {
                for z in 0..shape[2] {
                    numbers[z + shape[2] * (y + shape[1] * x)] = places[usize::from(flags[x + n * (y + shape[1] * z)])];
                }
            }
        }
        table.push(&numbers)?;
    }
    job.control.check()?;
    table.finish(file)
}

/// A material as gprMax's database has it.
fn material(name: &str, electric: &Electric) -> Value {
    let mut material = if electric.pec {
        json!({ "name": name, "model": "builtin", "builtin": "pec" })
    } else {
        json!({ "name": name, "model": "constant", "base": {
            "relative_permittivity": electric.eps_r,
            "electric_conductivity_s_per_m": electric.sigma,
            "relative_permeability": electric.mu_r,
            "magnetic_conductivity_s_per_m": 0.0,
        } })
    };
    if let Some(density) = electric.density {
        material["mass_density_kg_per_m3"] = density.into();
    }
    material
}
