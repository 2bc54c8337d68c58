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
mod skin;
#[cfg(test)]
mod tests;

use super::format::{Format, Reading};
use super::input::{Input, Share};
use super::obj::builder::Builder;
use super::object::Object;
use crate::error::{Error, Finding, Findings, Result, Severity};
use accessor::Accessor;
use item::Item;
use material::Materials;
use nodes::Nodes;
use primitive::Primitive;
use skin::Skin;
use std::collections::HashMap;
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

/// Nodes that show a mesh again copy it. A file of a few bytes must not fill the memory with copies: no more vertices
/// than this, or than [`COPIES_A_BYTE`] for each byte of its buffers if that is more.
const MOST_COPIED: u64 = 1 << 26;

/// See [`MOST_COPIED`]: a vertex takes some twenty bytes, so that is hundreds of copies of everything.
const COPIES_A_BYTE: u64 = 32;

/// What to do about compressed geometry.
const DECODE_FIRST: &str = "decode it first, e.g. with gltf-transform copy IN.glb OUT.glb";

/// A document with its buffers.
pub(super) struct Document<'d> {
    root: Item<'d>,
    buffers: Vec<Arc<Vec<u8>>>,
    file: &'d Path,
}

impl Document<'_> {
    fn accessor(&self, index: usize) -> Result<Accessor> {
        Accessor::of(&self.root, &self.buffers, index)
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
    let document = Document { root: Item::root(&container.json, file), buffers, file };
    let nodes = Nodes::of(&document.root)?;
    let mut findings = Findings::default();
    let materials = Materials::of(&document, reading.reach, &mut findings)?;
    let mut builder = Builder::new(file, &reading.options, false, Share::Always(1.0));
    let mut meshes =
        Meshes { document: &document, materials: &materials, builder: &mut builder, left_out: 0 };
    meshes.add_all(&nodes, reading.options.max_elements)?;
    if meshes.left_out > 0 {
        let message =
            format!("{} primitives of points, lines or without positions are not rendered", meshes.left_out);
        findings.push(finding(file, "points-and-lines-ignored", Severity::Note, message));
    }
    let read = builder.finish(0, findings)?;
    let specs = read.material_names.iter().map(|name| materials.spec(name)).collect();
    let mut object = Object::of_mesh(read, specs);
    object.camera = lights::camera(&document.root, &nodes)?;
    object.lights = lights::lights(&document.root, &nodes)?;
    Ok(object)
}

fn finding(file: &Path, kind: &'static str, severity: Severity, message: String) -> Finding {
    Finding { file: file.to_path_buf(), line: 0, kind, message, severity }
}

fn check_version(root: &Item<'_>) -> Result<()> {
    let version = root.need("asset")?.text("version").unwrap_or_default();
    if !version.starts_with("2.") {
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
    builder: &'m mut Builder<'d>,
    left_out: u64,
}

impl Meshes<'_, '_> {
    fn add_all(&mut self, nodes: &Nodes<'_>, most: u64) -> Result<()> {
        let root = &self.document.root;
        let bytes: u64 = self.document.buffers.iter().map(|buffer| buffer.len() as u64).sum();
        let most = most.min(MOST_COPIED.max(bytes.saturating_mul(COPIES_A_BYTE)));
        let file = self.document.file;
        let mut total = 0u64;
        let mut count = |vertices: u64| {
            total = total.saturating_add(vertices);
            if total <= most {
                return Ok(());
            }
            let error = format!("its nodes show meshes again and again, with more than {most} vertices");
            Err(Error::new(error).at(file).advise("split it, or place its mesh in a scene file"))
        };
        let mut skins: HashMap<usize, Arc<Skin>> = HashMap::new();
        for placed in &nodes.placed {
            let Some(mesh) = placed.node.index("mesh")? else { continue };
            let mesh = root.at("meshes", mesh)?;
            let skin = match placed.node.index("skin")? {
                None => None,
                Some(index) => Some(match skins.get(&index) {
                    Some(skin) => skin.clone(),
                    None => {
                        let skin = Arc::new(Skin::of(self.document, nodes, index)?);
                        skins.insert(index, skin.clone());
                        skin
                    }
                }),
            };
            let copies = nodes::copies(root, &placed.node, &self.document.buffers)?;
            // Places take time as well, be there vertices or not.
            count(copies.len() as u64)?;
            let weights = if placed.node.get("weights").is_some() { &placed.node } else { &mesh };
            let weights: Vec<f64> = weights.list("weights").filter_map(|w| w.value.as_f64()).collect();
            for item in mesh.list("primitives") {
                let Some(primitive) = self.primitive(&item, &weights)? else {
                    self.left_out += 1;
                    continue;
                };
                count(primitive.size().saturating_mul(copies.len() as u64))?;
                for copy in &copies {
                    primitive.add(&(placed.matrix * *copy), skin.as_deref(), self.builder)?;
                }
            }
        }
        Ok(())
    }

    fn primitive(&mut self, item: &Item<'_>, weights: &[f64]) -> Result<Option<Primitive>> {
        let material = item.index("material")?;
        if let Some(index) = material {
            self.document.root.at("materials", index)?;
        }
        self.builder.material(&Materials::key(material))?;
        let (uv_set, uv_transform) = self.materials.coordinates(material);
        let primitive = Primitive::of(item, self.document, uv_set, uv_transform, weights)?;
        if item.extension("KHR_draco_mesh_compression").is_some() {
            return Err(item.error("is compressed with Draco").advise(DECODE_FIRST));
        }
        Ok(primitive)
    }
}
