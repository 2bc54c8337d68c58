//! glTF 2.0, as `.gltf` and `.glb`: meshes where the scene's nodes put them, their materials, the first camera, and
//! lights. Khronos Group, "glTF 2.0 Specification" (ISO/IEC 12113:2022).
//!
//! Skins and morph targets stand as the document leaves them; animations are left out.

mod accessor;
mod container;
mod item;
mod lights;
mod material;
mod nodes;
mod pictures;
mod primitive;
mod shared;
mod skin;
#[cfg(test)]
mod tests;

use super::format::{Format, Reading};
use super::input::{Input, Share};
use super::obj::builder::Builder;
use super::obj::{ObjFile, ReadOptions};
use super::object::{Object, Part};
use super::place::rename_materials;
use crate::error::{Finding, Findings, Result, Severity};
use crate::math::DMat4;
use accessor::Accessor;
use glam::DAffine3;
use item::Item;
use material::Materials;
use nodes::Nodes;
use primitive::Primitive;
use shared::{Room, Shown};
use std::collections::{BTreeMap, HashMap};
use std::path::Path;
use std::sync::Arc;

/// The format.
pub(super) const FORMAT: Format = Format {
    name: "gltf",
    meaning: "glTF 2.0, as .gltf with files beside it and as one .glb",
    extensions: &["gltf", "glb"],
    begins: |head| head.starts_with(container::MAGIC) || head.trim_ascii_start().starts_with(b"{"),
    // Buffers lie in files beside it, in any form.
    forecast: |_, _| None,
    read,
};

/// What a document may require. Of the others, `KHR_materials_*` change only how things look, and are left out, as are
/// pictures in formats that are not read.
const EXTENSIONS: [&str; 7] = [
    "KHR_lights_punctual",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
    "EXT_mesh_gpu_instancing",
    "KHR_texture_basisu",
    "EXT_texture_webp",
    "MSFT_texture_dds",
];

/// Nodes that show a mesh again copy it, or share it where that saves much. A file of a few bytes must not fill the memory
/// with copies: no more vertices than this, or than [`COPIES_A_BYTE`] for each byte of its buffers if that is more.
const MOST_COPIED: u64 = 1 << 26;

/// See [`MOST_COPIED`]: a vertex takes some twenty bytes, so that is hundreds of copies of everything.
const COPIES_A_BYTE: u64 = 32;

/// What to do about compressed geometry.
const DECODE_FIRST: &str = "decode it first, e.g. with gltf-transform copy IN.glb OUT.glb";

/// A document with its buffers.
pub(super) struct Document<'d> {
    root: Item<'d>,
    buffers: Vec<Arc<Vec<u8>>>,
    /// Bytes of the longest buffer.
    longest: usize,
    file: &'d Path,
}

impl Document<'_> {
    fn accessor(&self, index: usize) -> Result<Accessor> {
        Accessor::of(self, index)
    }
}

/// Reads a document.
///
/// # Errors
/// What is no glTF 2.0; extensions that it requires and that are not known; references that lead nowhere; no triangle.
fn read(input: Input<'_>, reading: &Reading<'_>) -> Result<Object> {
    let file = input.name;
    let mut container = container::Document::read(input, reading.options.progress)?;
    check_version(&Item::root(&container.json, file))?;
    let buffers = container.buffers(file, reading.reach)?;
    let longest = buffers.iter().map(|buffer| buffer.len()).max().unwrap_or(0);
    let document = Document { root: Item::root(&container.json, file), buffers, longest, file };
    let nodes = Nodes::of(&document.root)?;
    let mut findings = Findings::default();
    let materials = Materials::of(&document, reading.reach, &mut findings)?;
    let mut meshes = Meshes::new(&document, &materials, reading);
    meshes.add_all(&nodes)?;
    let left_out = meshes.left_out;
    if left_out > 0 {
        let message = format!("{left_out} primitives of points, lines or without positions are not rendered");
        findings.push(finding(file, "points-and-lines-ignored", Severity::Note, message));
    }
    let mut object = meshes.finish(findings)?;
    object.camera = lights::camera(&document.root, &nodes)?;
    object.lights = lights::lights(&document.root, &nodes)?;
    Ok(object)
}

fn finding(file: &Path, kind: &'static str, severity: Severity, message: String) -> Finding {
    Finding { file: file.to_path_buf(), line: 0, kind, message, severity }
}

fn check_version(root: &Item<'_>) -> Result<()> {
    let asset = root.need("asset")?;
    // What wants a later version than 2.0 says so by `minVersion`.
    let is_later = asset.text("minVersion").is_some_and(|least| least != "2.0");
    if is_later || !asset.text("version").unwrap_or_default().starts_with("2.") {
        return Err(root.error("is not version 2 of glTF").advise("convert it to glTF 2.0"));
    }
    for required in root.list("extensionsRequired") {
        let name = required.value.as_str().unwrap_or_default();
        if EXTENSIONS.contains(&name) || name.starts_with("KHR_materials_") {
            continue;
        }
        let known: String =
            name.chars().filter(|c| c.is_ascii_alphanumeric() || *c == '_').take(60).collect();
        let is_packed = ["KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression"];
        let advice = if is_packed.contains(&name) { DECODE_FIRST } else { "convert it to plain glTF 2.0" };
        return Err(root.error(&format!("requires {known}, which is not known here")).advise(advice));
    }
    Ok(())
}

/// Everything that nodes show.
struct Meshes<'m, 'd> {
    document: &'m Document<'d>,
    materials: &'m Materials,
    reading: &'m Reading<'m>,
    /// What stands once, or is copied to its places.
    whole: Builder<'m>,
    /// What is kept once, and its places.
    parts: Vec<(ObjFile, Vec<DMat4>)>,
    left_out: u64,
}

impl<'m, 'd> Meshes<'m, 'd> {
    fn new(document: &'m Document<'d>, materials: &'m Materials, reading: &'m Reading<'m>) -> Self {
        let whole = Builder::new(document.file, &reading.options, false, Share::Always(1.0));
        Meshes { document, materials, reading, whole, parts: Vec::new(), left_out: 0 }
    }

    fn add_all(&mut self, nodes: &Nodes<'d>) -> Result<()> {
        let bytes: u64 = self.document.buffers.iter().map(|buffer| buffer.len() as u64).sum();
        let most = self.reading.options.max_elements;
        let most = most.min(MOST_COPIED.max(bytes.saturating_mul(COPIES_A_BYTE)));
        let mut room = Room { taken: 0, most, file: self.document.file };
        let all = Shown::all(self.document, nodes, &mut room)?;
        let mut shared = Shown::shared(&all, self.document, self.reading.most_copied);
        let mut firsts = BTreeMap::new();
        for shown in &all {
            if let Some(places) = shown.joins(&mut shared) {
                places.extend(&shown.places);
                firsts.entry(shown.mesh).or_insert(shown);
                continue;
            }
            let further = (shown.places.len() as u64).saturating_sub(1);
            for (material, primitive) in self.primitives(shown, &mut room)? {
                room.take(primitive.size().saturating_mul(further))?;
                self.whole.material(&material)?;
                for place in &shown.places {
                    primitive.add(place, shown.skin.as_deref(), &mut self.whole)?;
                }
            }
        }
        for ((_, shown), (_, mut places)) in firsts.into_iter().zip(shared) {
            let primitives = self.primitives(shown, &mut room)?;
            // A file is a mesh, and has parts besides; so one place is a copy where there is nothing else.
            if self.whole.counts()[0] == 0
                && let Some(place) = places.pop()
            {
                for (material, primitive) in &primitives {
                    room.take(primitive.size())?;
                    self.whole.material(material)?;
                    primitive.add(&place, None, &mut self.whole)?;
                }
            }
            let options = ReadOptions { keep_empty: true, ..self.reading.options };
            let mut builder = Builder::new(self.document.file, &options, false, Share::Always(1.0));
            for (material, primitive) in primitives {
                builder.material(&material)?;
                primitive.add(&DMat4::IDENTITY, None, &mut builder)?;
            }
            self.parts.push((builder.finish(0, Findings::default())?, places));
        }
        Ok(())
    }

    /// The primitives of a mesh, each with the name of its material; takes room for one place.
    fn primitives(&mut self, shown: &Shown<'d>, room: &mut Room<'_>) -> Result<Vec<(Vec<u8>, Primitive)>> {
        let weights: Vec<f64> = shown.weights.list("weights").filter_map(|w| w.value.as_f64()).collect();
        let mut all = Vec::new();
        for item in shown.item.list("primitives") {
            let material = item.index("material")?;
            if let Some(index) = material {
                self.document.root.at("materials", index)?;
            }
            let (uv_set, uv_transform) = self.materials.coordinates(material);
            let primitive = Primitive::of(&item, self.document, uv_set, uv_transform, &weights)?;
            if item.extension("KHR_draco_mesh_compression").is_some() {
                return Err(item.error("is compressed with Draco").advise(DECODE_FIRST));
            }
            match primitive {
                Some(primitive) => {
                    room.take(primitive.size())?;
                    all.push((Materials::key(material), primitive));
                }
                None => self.left_out += 1,
            }
        }
        Ok(all)
    }

    /// The mesh and the parts, with their materials.
    fn finish(self, findings: Findings) -> Result<Object> {
        let mut whole = self.whole.finish(0, findings)?;
        let mut names = std::mem::take(&mut whole.material_names);
        let mut known: HashMap<Vec<u8>, u32> = names.iter().cloned().zip(0..).collect();
        let mut parts = Vec::new();
        for (read, places) in self.parts.into_iter().filter(|(read, _)| !read.mesh.indices.is_empty()) {
            let id = |name: Vec<u8>| {
                *known.entry(name).or_insert_with_key(|name| {
                    names.push(name.clone());
                    (names.len() - 1) as u32
                })
            };
            let ids: Vec<u32> = read.material_names.into_iter().map(id).collect();
            let mut mesh = read.mesh;
            rename_materials(&mut mesh, &ids);
            whole.findings.append(read.findings);
            whole.counts.triangles += read.counts.triangles * places.len() as u64;
            let places = places.iter().map(|place| DAffine3::from_mat4(*place)).collect();
            parts.push(Part { mesh, origin: read.origin, places });
        }
        let specs = names.iter().map(|name| self.materials.spec(name)).collect();
        Ok(Object { parts, ..Object::of_mesh(whole, specs) })
    }
}
