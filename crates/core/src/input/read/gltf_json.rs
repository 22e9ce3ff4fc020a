//! The description of a GLB: what of glTF 2.0's JSON places surfaces.

use serde::Deserialize;
use serde::de::IgnoredAny;

use crate::base::error::Error;

/// The error of a GLB that is not as it must be.
pub(super) fn wrong(what: &str) -> Error {
    Error::new("file-syntax", format!("GLB: {what}"), "export the model again, or as STL")
}

/// The error of an index that names nothing.
pub(super) fn missing(what: &str, index: usize, n: usize) -> Error {
    wrong(&format!("there is no {what} {index}, counted from 0, of {n}"))
}

/// Most bytes that a description takes once it is read: an object or a value of a list begins with a sign of its own, and lists that grow are
/// there twice.
pub(super) fn most_bytes(json: &str) -> u64 {
    let sizes =
        [size_of::<Node>(), size_of::<Mesh>(), size_of::<Primitive>(), size_of::<Accessor>(), size_of::<View>()];
    let of_object = sizes.into_iter().max().unwrap_or(0) as u64;
    let of_byte = |byte: u8| match byte {
        b'{' => 3 * of_object,
        b',' | b'[' => 3 * size_of::<String>() as u64,
        _ => 1,
    };
    json.bytes().map(of_byte).sum()
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
#[derive(Default)]
pub(super) struct Root {
    pub(super) scene: Option<usize>,
    pub(super) scenes: Vec<Scene>,
    pub(super) nodes: Vec<Node>,
    pub(super) meshes: Vec<Mesh>,
    pub(super) accessors: Vec<Accessor>,
    pub(super) buffer_views: Vec<View>,
    pub(super) buffers: Vec<Buffer>,
    pub(super) extensions_required: Vec<String>,
    pub(super) extensions_used: Vec<String>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub(super) struct Scene {
    pub(super) nodes: Vec<usize>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub(super) struct Node {
    pub(super) name: String,
    pub(super) mesh: Option<usize>,
    pub(super) children: Vec<usize>,
    pub(super) matrix: Option<[f64; 16]>,
    pub(super) translation: Option<[f64; 3]>,
    pub(super) rotation: Option<[f64; 4]>,
    pub(super) scale: Option<[f64; 3]>,
    pub(super) skin: Option<usize>,
    pub(super) weights: Option<Vec<f64>>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub(super) struct Mesh {
    pub(super) name: String,
    pub(super) primitives: Vec<Primitive>,
    /// How far each morph target moves corners, unless a node says.
    pub(super) weights: Vec<f64>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub(super) struct Primitive {
    pub(super) attributes: Attributes,
    pub(super) indices: Option<usize>,
    pub(super) mode: Option<u32>,
    /// Morph targets: by what they move corners.
    pub(super) targets: Vec<Attributes>,
}

#[derive(Deserialize, Default)]
#[serde(default, rename_all = "UPPERCASE")]
pub(super) struct Attributes {
    pub(super) position: Option<usize>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Accessor {
    pub(super) buffer_view: Option<usize>,
    #[serde(default)]
    pub(super) byte_offset: u64,
    pub(super) component_type: u32,
    #[serde(default)]
    pub(super) normalized: bool,
    pub(super) count: u64,
    pub(super) r#type: String,
    pub(super) sparse: Option<Sparse>,
}

#[derive(Deserialize)]
pub(super) struct Sparse {
    pub(super) count: u64,
    pub(super) indices: Part,
    pub(super) values: Part,
}

/// Where the indices or values of a sparse accessor are.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Part {
    pub(super) buffer_view: usize,
    #[serde(default)]
    pub(super) byte_offset: u64,
    pub(super) component_type: Option<u32>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct View {
    pub(super) buffer: usize,
    #[serde(default)]
    pub(super) byte_offset: u64,
    pub(super) byte_length: u64,
    pub(super) byte_stride: Option<u64>,
}

#[derive(Deserialize)]
pub(super) struct Buffer {
    pub(super) uri: Option<IgnoredAny>,
}
