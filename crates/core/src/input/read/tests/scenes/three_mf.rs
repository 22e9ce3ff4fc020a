//! 3MF.

use std::io::Write;

use flate2::Compression;
use flate2::write::DeflateEncoder;
use rawzip::{CompressionMethod, ZipArchiveWriter};

use super::*;

/// A 3MF of these files; the second is packed.
fn package(files: &[(&str, &str)]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut archive = ZipArchiveWriter::new(&mut bytes);
    for (number, (name, text)) in files.iter().enumerate() {
        let method = if number == 1 { CompressionMethod::DEFLATE } else { CompressionMethod::STORE };
        let (mut entry, config) = archive.new_file(name).compression_method(method).start().unwrap();
        let descriptor = if number == 1 {
            let mut writer = config.wrap(DeflateEncoder::new(&mut entry, Compression::default()));
            writer.write_all(text.as_bytes()).unwrap();
            let (encoder, descriptor) = writer.finish().unwrap();
            encoder.finish().unwrap();
            descriptor
        } else {
            let mut writer = config.wrap(&mut entry);
            writer.write_all(text.as_bytes()).unwrap();
            writer.finish().unwrap().1
        };
        entry.finish(descriptor).unwrap();
    }
    archive.finish().unwrap();
    bytes
}

const RELATIONS: &str = "<Relationships><Relationship Id='r1' Target='/3D/here.model' \
    Type='http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel'/></Relationships>";

fn object(id: u32, about: &str) -> String {
    let corners: String = CORNERS.iter().map(|[x, y, z]| format!("<vertex x='{x}' y='{y}' z='{z}'/>")).collect();
    let facets: String = INDICES.iter().map(|[a, b, c]| format!("<triangle v1='{a}' v2='{b}' v3='{c}'/>")).collect();
    format!(
        "<object id='{id}' {about}><mesh><vertices>{corners}</vertices><triangles>{facets}</triangles></mesh></object>"
    )
}

fn model(about: &str, objects: &str, items: &str) -> String {
    format!("<?xml version='1.0'?><model {about}><resources>{objects}</resources><build>{items}</build></model>")
}

fn three_mf(about: &str, objects: &str, items: &str) -> Vec<u8> {
    package(&[("_rels/.rels", RELATIONS), ("3D/here.model", &model(about, objects, items))])
}

#[test]
fn the_build_of_a_3mf_places_objects() {
    let parts = "<object id='5'><components><component objectid='1' transform='0 2 0 -1 0 0 0 0 1 10 0 0'/>\
        <component objectid='1'/></components></object>";
    let objects = object(1, "name='a &amp; b' type='model'") + parts;
    let items = "<item objectid='1'/><item objectid='5' transform='-1 0 0 0 1 0 0 0 1 0 0 5'/>";
    let bytes = three_mf("unit='inch'", &objects, items);
    assert_eq!(read_bytes(&bytes).unwrap().unit, Some("in"));
    let turned = |of: Vec<[[f32; 3]; 3]>| of.into_iter().map(|[a, b, c]| [a, c, b]).collect::<Vec<_>>();
    let placed = turned(moved(|[x, y, z]| [-(10.0 - y), 2.0 * x, z + 5.0]));
    let plain = turned(moved(|[x, y, z]| [0.0 - x, y, z + 5.0]));
    assert_eq!(facets_of(&bytes), [("a & b".to_string(), moved(|at| at)), (String::new(), [placed, plain].concat())]);
    // neither a smaller copy is mirrored nor one that is flat
    for [x, y, z] in [[0.5f32, 0.5, 0.5], [1.0, 1.0, 0.0]] {
        let item = format!("<item objectid='1' transform='{x} 0 0 0 {y} 0 0 0 {z} 0 0 0'/>");
        let small = moved(|at| [at[0] * x, at[1] * y, at[2] * z]);
        assert_eq!(facets_of(&three_mf("", &object(1, ""), &item))[0].1, small);
    }
    // objects without a mesh, before others and last
    let hollow = "<object id='7'/>".to_string() + &object(1, "") + "<object id='8'/>";
    let items = "<item objectid='7'/><item objectid='8'/><item objectid='1'/>";
    assert_eq!(facets_of(&three_mf("", &hollow, items)), [(String::new(), moved(|at| at))]);
    // other relations do not name the model, wherever they stand
    let others = RELATIONS.replace(
        "<Relationships>",
        "<Relationships><Relationship Target='/a.png' Type='http://thumbnail'/>\
         <Other Target='/b.png' Type='http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel'/>",
    );
    let files = [("_rels/.rels", &others[..]), ("3D/here.model", &model("", &object(1, ""), "<item objectid='1'/>"))];
    assert_eq!(facets_of(&package(&files)), [(String::new(), moved(|at| at))]);
}

#[test]
fn objects_may_be_nested_a_hundred_deep() {
    let nested = |n: u32| {
        let around =
            |id: u32| format!("<object id='{id}'><components><component objectid='{}'/></components></object>", id - 1);
        let objects = object(1, "") + &(2..=n).map(around).collect::<String>();
        three_mf("", &objects, &format!("<item objectid='{n}'/>"))
    };
    assert_eq!(facets_of(&nested(101))[0].1, moved(|at| at));
    assert_eq!(message(&nested(102)), "3MF: objects are nested more than 100 deep at object 1");
}

#[test]
fn objects_may_lie_in_other_files_of_the_archive() {
    let first = model(
        "xmlns:p='http://schemas.microsoft.com/3dmanufacturing/production/2015/06' requiredextensions='p'",
        "<object id='9' name='whole'><components><component p:path='/3D/Objects/One &amp; only.model' objectid='1'/></components></object>",
        "<item objectid='9'/><item p:path='/3D/Objects/One.model' objectid='1' printable='0'/>",
    );
    let files = [
        ("_rels/.rels", RELATIONS),
        ("3D/here.model", &first[..]),
        ("3D/Objects/One & only.model", &model("", &object(1, ""), "")),
        ("3D/Objects/One.model", &model("", &object(1, ""), "")),
    ];
    let contents = read_bytes(&package(&files)).unwrap();
    assert_eq!((contents.solids[0].name.as_str(), contents.n_facets), ("whole", 4));
    let left_out =
        "1 of 2 items are left out, for they are not to be printed (printable=\"0\"), the first of the object \"\"";
    assert_eq!(contents.warnings, [left_out]);
    let inches = model("unit='inch'", &object(1, ""), "");
    let unlike = package(&[files[0], files[1], files[2], ("3D/Objects/One.model", &inches)]);
    assert!(message(&unlike).contains("is in mm and 3d/objects/one.model in in"), "{}", message(&unlike));
}

#[test]
fn what_is_wrong_with_a_3mf_is_said() {
    let item = "<item objectid='1'/>";
    let support = object(1, "type='support'") + &object(2, "");
    let contents = read_bytes(&three_mf("", &support, "<item objectid='1'/><item objectid='2'/>")).unwrap();
    assert_eq!(
        (contents.n_facets, &contents.warnings[..]),
        (
            4,
            &["1 supports and modifiers (objects of type support, solidsupport or other) are left out".to_string()][..]
        )
    );
    let modifier = object(1, "type='other'")
        + "<object id='2'><components><component objectid='1'/><component objectid='3'/></components></object>"
        + &object(3, "");
    let contents = read_bytes(&three_mf("", &modifier, "<item objectid='2'/>")).unwrap();
    assert_eq!((contents.n_facets, contents.warnings.len()), (4, 1));
    // 2^59 placings of nothing, in a few kilobytes
    let twice = |id: u32| {
        format!(
            "<object id='{id}'><components><component objectid='{0}'/><component objectid='{0}'/></components></object>",
            id - 1
        )
    };
    let doubled = object(1, "type='support'") + &(2..=60).map(twice).collect::<String>();
    let slices = object(1, "").replace("<object", "<object s:meshresolution='lowres'");
    let around = "<object id='1'><components><component objectid='1'/></components></object>";
    let beams = object(1, "").replace("</mesh>", "<b:beamlattice minlength='1'/></mesh>");
    let cases = [
        (three_mf("unit='ell'", &object(1, ""), item), "\"ell\" is not one of its units"),
        (three_mf("", &object(1, ""), ""), "its build has no item"),
        (three_mf("", "", item), "3d/here.model has no object 1"),
        (three_mf("", around, item), "objects are nested more than 100 deep"),
        (three_mf("", &beams, item), "it has a beam lattice"),
        (three_mf("", &slices, item), "an object is made of slices"),
        (three_mf("", &doubled, "<item objectid='60'/>"), "536870912 corners and facets in all, copies among them"),
        (
            three_mf("xmlns:sc='http://x/securecontent/2019/04' requiredextensions='sc'", "", ""),
            "needs the extension sc (http://x/securecontent/2019/04)",
        ),
        (three_mf("", &object(1, "").replace("v3='3'", "v3='4'"), item), "there is no corner 4 of 4, counted from 0"),
        (three_mf("", &object(1, "").replace("x='1'", "x='one'"), item), "an element \"vertex\" has no number \"x\""),
        (
            three_mf("", &object(1, ""), "<item objectid='1' transform='1 0 0'/>"),
            "transform=\"1 0 0\" is not 12 numbers",
        ),
        (package(&[("a.txt", "text"), ("b.txt", "text")]), "a ZIP archive of 2 files without a 3MF model"),
        (
            package(&[("_rels/.rels", RELATIONS), ("3D/here.model", "<model><resources></build></model>")]),
            "3d/here.model: ",
        ),
        (package(&[("_rels/.rels", RELATIONS), ("3D/here.model", "<svg/>")]), "the first element is not \"model\""),
    ];
    for (bytes, expected) in cases {
        let found = message(&bytes);
        assert!(found.contains(expected), "{expected}: {found}");
    }
    let whole = three_mf("", &object(1, ""), item);
    assert!(message(&whole[..whole.len() - 30]).contains("the ZIP archive is damaged"));
    // a byte of the packed model
    let mut damaged = whole.clone();
    let mut places = (0..whole.len() - 13).filter(|&at| &whole[at..at + 13] == b"3D/here.model");
    damaged[places.nth(1).unwrap() + 60] ^= 0x40;
    assert!(message(&damaged).starts_with("3d/here.model: 3MF: "), "{}", message(&damaged));
}

#[test]
fn items_that_are_not_to_be_printed_are_named() {
    let objects = object(1, "name='kept'") + &object(2, "name='spare'");
    for no in ["0", "false"] {
        let items = format!("<item objectid='1' printable='1'/><item objectid='2' printable='{no}'/>");
        let contents = read_bytes(&three_mf("", &objects, &items)).unwrap();
        assert_eq!((contents.solids.len(), &contents.solids[0].name[..]), (1, "kept"));
        assert!(contents.warnings.len() == 1 && contents.warnings[0].ends_with("the first of the object \"spare\""));
        let none = format!("<item objectid='2' printable='{no}'/>");
        assert_eq!(
            message(&three_mf("", &objects, &none)),
            "3MF: none of its 1 items is to be printed (printable=\"0\")"
        );
    }
}
