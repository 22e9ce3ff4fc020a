//! GLB, the binary form of glTF 2.0: triangles of the meshes that the nodes of a scene place, in metres.
//!
//! A node with a mesh becomes a solid of its name; a mesh that several nodes place is there several times. Corners are placed in f64 and
//! rounded once; y is up, as in the file, for nothing is turned. Morph targets move corners by their default weights. A mesh with a skin is where
//! it was modelled: its node does not place it. Lines, points and poses of skins are passed over, with a warning. What is packed (Draco, meshopt),
//! what lies in other files, and extensions that a reader must know are refused. Source: glTF 2.0, revision 2.0.1, of Khronos.
//!
//! Our own reader: the crate `gltf` panics where a file's numbers are wrong (an accessor of no element, strides below the size of an
//! element), and its model of all of glTF takes as much of the wasm as all other readers together.

use std::fmt::Display;

use glam::{DAffine3, DMat4, DQuat, DVec3};

use super::contents::{Contents, Format};
use super::elements::Bytes;
use super::gltf_json::{self, Node, Primitive, Root, missing, wrong};
use super::polygons::Polygons;
use super::text::shown;
use crate::base::error::{Error, Result};
use crate::base::memory::{List, Memory};

/// Beginnings of the names of extensions that leave surfaces as they are, and of the one that stores corners as small integers.
const HARMLESS: [&str; 6] =
    ["KHR_materials_", "KHR_texture_", "EXT_texture_", "KHR_lights_", "KHR_xmp", "KHR_mesh_quantization"];

pub(super) fn read(file: &[u8], n_bytes: u64, memory: &Memory) -> Result<Contents> {
    let (json, binary) = chunks(file)?;
    let is_not = |error: &dyn Display| {
        wrong(&format!("its description is not that of glTF: {}", shown(&error.to_string(), 150)))
    };
    // as text, like a job: serde_json would be compiled a second time for bytes
    let json = str::from_utf8(json).map_err(|error| is_not(&error))?;
    let _room = memory.take(gltf_json::most_bytes(json), "the nodes and accessors of its description")?;
    let root: Root = serde_json::from_str(json).map_err(|error| is_not(&error))?;
    if let Some(name) =
        root.extensions_required.iter().find(|name| !HARMLESS.iter().any(|known| name.starts_with(known)))
    {
        let message = format!("GLB: the file needs the extension {}, which cannot be read", shown(name, 60));
        return Err(Error::new(
            "file-syntax",
            message,
            "export the model without compression and extensions, or as STL",
        ));
    }
    let uses = |name: &str| root.extensions_used.iter().any(|used| used == name);
    if uses("EXT_mesh_gpu_instancing") {
        let message =
            "GLB: meshes are placed many times by the extension EXT_mesh_gpu_instancing, which cannot be read";
        return Err(Error::new("file-syntax", message, "export the model without instancing, or as STL"));
    }
    let bytes = Bytes { root: &root, binary, memory };
    let mut model = Model {
        root: &root,
        bytes,
        polygons: Polygons::within(memory),
        is_placed: vec![false; root.nodes.len()],
        passed_over: [0; 2],
    };
    for node in roots(&root)? {
        model.place(node, DAffine3::IDENTITY, 0)?;
    }
    let [n_other, n_skins] = model.passed_over;
    let mut polygons = model.polygons;
    for (n, what) in [
        (n_other, "primitives of lines or points are ignored"),
        (
            n_skins,
            "nodes have a skin; they are read in the pose and at the place in which they were modelled, so that place and size may be off",
        ),
    ] {
        if n > 0 {
            polygons.warnings.push(format!("{n} {what}"));
        }
    }
    if uses("KHR_node_visibility") {
        polygons.warnings.push("nodes may be hidden (KHR_node_visibility); they are read all the same".into());
    }
    Ok(Contents { unit: Some("m"), ..polygons.finish(Format::Glb, n_bytes)? })
}

/// The description and the binary chunk of a file; what follows these is passed over.
fn chunks(file: &[u8]) -> Result<(&[u8], &[u8])> {
    let word = |at: usize| file.get(at..at + 4).and_then(<[u8]>::first_chunk).map(|word| u32::from_le_bytes(*word));
    if word(4) != Some(2) {
        return Err(wrong(&format!("its version is {}, and only 2 can be read", word(4).unwrap_or(0))));
    }
    let (mut at, mut found) = (12, [None, None]);
    while let (Some(length), Some(kind)) = (word(at), word(at + 4)) {
        let content = (at + 8).checked_add(length as usize).and_then(|end| file.get(at + 8..end));
        let content = content.ok_or_else(|| {
            wrong(&format!("a chunk of {length} bytes begins at byte {at}, and the file has {}", file.len()))
        })?;
        match kind {
            0x4e4f_534a if found[0].is_none() => found[0] = Some(content),
            0x004e_4942 if found[1].is_none() => found[1] = Some(content),
            _ => {}
        }
        at += 8 + content.len();
    }
    let json = found[0].ok_or_else(|| wrong("it has no description (a chunk \"JSON\")"))?;
    Ok((json, found[1].unwrap_or_default()))
}

/// The nodes at the top of the scene; of a file without scenes those that are in no other.
fn roots(root: &Root) -> Result<Vec<usize>> {
    let scene = root.scene.unwrap_or(0);
    match root.scenes.get(scene) {
        Some(scene) => Ok(scene.nodes.clone()),
        None if root.scenes.is_empty() => {
            let mut is_child = vec![false; root.nodes.len()];
            for &child in root.nodes.iter().flat_map(|node| &node.children) {
                *is_child.get_mut(child).ok_or_else(|| missing("node", child, root.nodes.len()))? = true;
            }
            Ok((0..is_child.len()).filter(|&node| !is_child[node]).collect())
        }
        None => Err(missing("scene", scene, root.scenes.len())),
    }
}

struct Model<'a> {
    root: &'a Root,
    bytes: Bytes<'a>,
    polygons: Polygons,
    is_placed: Vec<bool>,
    /// Primitives that are no triangles, skins.
    passed_over: [u64; 2],
}

/// Nodes within nodes, at most; more than modellers make, and fewer than the stack holds.
const MAX_DEPTH: u32 = 500;

impl Model<'_> {
    /// Adds the meshes of a node and of those in it.
    fn place(&mut self, index: usize, around: DAffine3, depth: u32) -> Result<()> {
        let node = self.root.nodes.get(index).ok_or_else(|| missing("node", index, self.root.nodes.len()))?;
        if std::mem::replace(&mut self.is_placed[index], true) {
            return Err(wrong(&format!("node {index} is in the scene twice")));
        }
        if depth > MAX_DEPTH {
            return Err(wrong(&format!("nodes are nested more than {MAX_DEPTH} deep")));
        }
        let world = around * local(node);
        if let Some(mesh) = node.mesh {
            let mesh = self.root.meshes.get(mesh).ok_or_else(|| missing("mesh", mesh, self.root.meshes.len()))?;
            self.polygons.new_solid(if node.name.is_empty() { &mesh.name } else { &node.name })?;
            self.passed_over[1] += u64::from(node.skin.is_some());
            // the node of a mesh with a skin does not place it; its joints would
            let world = if node.skin.is_some() { DAffine3::IDENTITY } else { world };
            let weights = node.weights.as_ref().unwrap_or(&mesh.weights);
            for (number, primitive) in mesh.primitives.iter().enumerate() {
                let place = || format!("node {index} ({}), primitive {number}", shown(&node.name, 60));
                self.primitive(primitive, weights, &world).map_err(|error| error.at(place()))?;
            }
        }
        node.children.iter().try_for_each(|&child| self.place(child, world, depth + 1))
    }

    fn primitive(&mut self, primitive: &Primitive, weights: &[f64], world: &DAffine3) -> Result<()> {
        let mode = primitive.mode.unwrap_or(4);
        let Some(positions) = primitive.attributes.position.filter(|_| (4..=6).contains(&mode)) else {
            self.passed_over[0] += 1;
            return Ok(());
        };
        let corners = self.morphed(positions, primitive, weights)?;
        self.polygons.corners.clear();
        for (index, &corner) in corners.iter().enumerate() {
            let corner = world.transform_point3(corner).to_array().map(|number| number as f32);
            self.polygons.corner(corner, || format!("corner {index}, counted from 0"))?;
        }
        let n = self.polygons.corners.len();
        self.polygons.count_copied(n)?;
        let indices = match primitive.indices {
            Some(indices) => self.bytes.indices(indices)?,
            None => {
                let mut all = List::new(self.bytes.memory, "the corners of a primitive");
                (0..n as u32).try_for_each(|index| all.push(index))?;
                all
            }
        };
        if let Some(index) = indices.iter().find(|&&index| index as usize >= n) {
            return Err(wrong(&format!("a triangle has corner {index}, counted from 0, of {n}")));
        }
        if mode == 4 && !indices.len().is_multiple_of(3) {
            return Err(wrong(&format!("{} indices are not three a triangle", indices.len())));
        }
        self.polygons.count_copied(indices.len())?;
        let n_triangles = if mode == 4 { indices.len() / 3 } else { indices.len().saturating_sub(2) };
        let is_mirrored = world.matrix3.determinant() < 0.0;
        for t in 0..n_triangles {
            let mut corners = match mode {
                4 => [3 * t, 3 * t + 1, 3 * t + 2],
                // every other triangle of a strip is turned
                5 if t % 2 == 1 => [t, t + 2, t + 1],
                5 => [t, t + 1, t + 2],
                _ => [t + 1, t + 2, 0],
            };
            if is_mirrored {
                corners.swap(1, 2);
            }
            self.polygons
                .polygon(&corners.map(|at| indices[at] as usize), || format!("triangle {t}, counted from 0"))?;
        }
        Ok(())
    }

    /// The corners of a primitive, moved by its morph targets, each by so much of it as its weight says.
    fn morphed(&mut self, positions: usize, primitive: &Primitive, weights: &[f64]) -> Result<List<DVec3>> {
        let mut corners = self.bytes.corners(positions)?;
        let (n, n_targets) = (corners.len(), primitive.targets.len());
        if !weights.is_empty() && weights.len() != n_targets {
            return Err(wrong(&format!("there are {} weights for {n_targets} morph targets", weights.len())));
        }
        for (number, (target, weight)) in primitive.targets.iter().zip(weights).enumerate() {
            let Some(moves) = target.position.filter(|_| *weight != 0.0) else { continue };
            self.polygons.count_copied(n)?;
            let moves = self.bytes.corners(moves)?;
            if moves.len() != n {
                return Err(wrong(&format!("morph target {number} moves {} corners of {n}", moves.len())));
            }
            corners.iter_mut().zip(moves.iter()).for_each(|(corner, by)| *corner += *weight * *by);
        }
        Ok(corners)
    }
}

fn local(node: &Node) -> DAffine3 {
    if let Some(matrix) = &node.matrix {
        return DAffine3::from_mat4(DMat4::from_cols_array(matrix));
    }
    let rotation = node.rotation.map_or(DQuat::IDENTITY, |turn| DQuat::from_array(turn).normalize());
    let scale = node.scale.map_or(DVec3::ONE, DVec3::from);
    DAffine3::from_scale_rotation_translation(scale, rotation, node.translation.unwrap_or_default().into())
}
