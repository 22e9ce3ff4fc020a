//! openEMS: the cells of some flags as boxes in the XML of CSXCAD (`.csx.xml`).
//!
//! One file: a `ContinuousStructure` with the lines of the mesh as `RectilinearGrid`, in the unit of the mesh (`DeltaUnit`), and a property for
//! each kept flag, `Metal` for perfect conductors and `Material` for others, with its cells as boxes. Boundaries, excitations and probes are the
//! user's. Corners of boxes are written as the lines are ([`decimal`](crate::export::decimal)), so that they meet each other and what a user adds.
//! Faces of plates are boxes without thickness.
//!
//! Boxes of different flags share faces, and an edge of the grid on such a face has the property of the higher priority: that of conductors.
//! Source: CSXCAD, `CSProperties` and `CSPrimBox`. Cost: the memory of [`boxes`](crate::export::boxes); the flags are expanded once for each flag.

use crate::export::{
    boxes::for_each_box,
    decimal,
    electric::{Electric, electric, substances},
    format::Format,
    names::names,
    output::{Export, Files, Out},
    plates::{self, check_conductors},
    unit::metres,
    xml::Xml,
};
use hexcast_core::base::error::Result;

pub(in crate::export) static FORMAT: Format = Format {
    program: "openEMS",
    about: "lines, materials and boxes",
    has_plates: true,
    unit: Some((WHAT, "metres")),
    check_materials: |names, flags| substances(names, flags, WHAT).map(|_| ()),
    check_mesh: |mesh, options, keeps| check_conductors(mesh, options, keeps, WHAT),
    ..Format::new(&[".csx.xml"], |job, name, files| Box::pin(write(job, name, files)))
};

const WHAT: &str = "openEMS";
/// Priorities of boxes: what a user adds may be below, between or above.
const MATERIAL_PRIORITY: &str = "10";
const METAL_PRIORITY: &str = "20";

async fn write(job: &Export<'_>, name: &str, files: &mut dyn Files) -> Result<()> {
    let mesh = job.mesh;
    let keeps = job.options.selection(mesh, true)?;
    let unit = metres(mesh.unit(), WHAT)?;
    let lines = [0, 1, 2]
        .map(|axis| decimal::lines(mesh.lines(), axis).iter().map(|line| format!("{line:?}")).collect::<Vec<_>>());
    let names = names(mesh, 60, &[]);
    let mut out = Out::create(files, name)?;
    let mut xml = Xml::new(&mut out.file)?;
    xml.open("ContinuousStructure", &[("CoordSystem", "0")])?;
    xml.open("RectilinearGrid", &[("DeltaUnit", &format!("{:?}", unit.metres(1.0))), ("CoordSystem", "0")])?;
    for (element, lines) in ["XLines", "YLines", "ZLines"].into_iter().zip(&lines) {
        xml.text(element, &[("Qty", &lines.len().to_string())], &lines.join(","))?;
    }
    xml.close("RectilinearGrid")?;
    let background = electric(mesh.names(), 0).filter(|background| !background.pec && !keeps[0]);
    let background =
        numbers(background.unwrap_or(Electric { eps_r: 1.0, mu_r: 1.0, sigma: 0.0, pec: false, density: None }));
    xml.empty("BackgroundMaterial", &background.each_ref().map(|(key, value)| (*key, value.as_str()))[..4])?;
    xml.empty("ParameterSet", &[])?;
    xml.open("Properties", &[])?;
    let cells = mesh.columns().cells_per_flag();
    let mut flags = [job.options.exported(mesh), plates::flags(mesh, job.options, WHAT)?].concat();
    flags.sort_unstable();
    flags.dedup();
    for (id, (flag, electric)) in substances(mesh.names(), &flags, WHAT)?.into_iter().enumerate() {
        let (kind, priority) = if electric.pec { ("Metal", METAL_PRIORITY) } else { ("Material", MATERIAL_PRIORITY) };
        xml.open(kind, &[("ID", &id.to_string()), ("Name", &names[usize::from(flag)])])?;
        if !electric.pec {
            let values = numbers(electric);
            xml.empty("Property", &values.each_ref().map(|(key, value)| (*key, value.as_str())))?;
        }
        xml.open("Primitives", &[])?;
        let mut put = |corners: [[u32; 3]; 2]| {
            xml.open("Box", &[("Priority", priority)])?;
            for (element, [x, y, z]) in ["P1", "P2"].into_iter().zip(corners) {
                let at = [(0, x), (1, y), (2, z)].map(|(axis, line): (usize, u32)| &*lines[axis][line as usize]);
                xml.empty(element, &[("X", at[0]), ("Y", at[1]), ("Z", at[2])])?;
            }
            xml.close("Box")
        };
        if cells[usize::from(flag)] > 0 {
            for_each_box(job, flag, &mut put).await?;
        }
        plates::rectangles(mesh, flag).into_iter().try_for_each(put)?;
        xml.close("Primitives")?;
        xml.close(kind)?;
    }
    xml.close("Properties")?;
    xml.close("ContinuousStructure")?;
    out.finish()
}

/// The numbers of a substance as attributes; the magnetic conductivity is 0. The density is the last.
fn numbers(electric: Electric) -> [(&'static str, String); 5] {
    let Electric { eps_r, mu_r, sigma, density, .. } = electric;
    [("Epsilon", eps_r), ("Mue", mu_r), ("Kappa", sigma), ("Sigma", 0.0), ("Density", density.unwrap_or(0.0))]
        .map(|(key, value)| (key, format!("{value:?}")))
}
