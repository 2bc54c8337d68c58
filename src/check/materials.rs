//! Which materials and textures there are.

use crate::error::{Finding, Findings, Severity};
use crate::load::mtl::MtlMaterial;
use crate::load::object::Object;
use crate::load::open::Reach;
use crate::load::picture::texels::{Trouble, probe};
use crate::load::texture::{Source, Sources, StatedTexture};
use crate::math::Rgb;
use crate::scene::Scene;
use crate::shape::{FaceMaterials, Mesh};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// A material and its use.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialReport {
    /// The name; empty for faces without any.
    pub name: String,
    /// The scattering model's name in scene files.
    pub model: &'static str,
    /// Triangles that have it.
    pub triangles: u64,
    /// Whether it emits light.
    pub emits: bool,
    /// The library and line that define it; `None` where none does.
    pub defined: Option<(PathBuf, u64)>,
}

/// A texture that a library or a scene file states. It tells the file's name only where there is such a file: a
/// material library is a referenced file, and those are not quoted.
#[derive(Clone, Debug, PartialEq)]
pub struct TextureReport {
    /// The library or scene file.
    pub library: PathBuf,
    /// The material's name.
    pub material: String,
    /// The statement's line.
    pub line: u64,
    /// Its key word.
    pub key: String,
    /// The image, of a UDIM set its first one; `None` where it is missing.
    pub path: Option<PathBuf>,
    /// Width and height; `None` where it is no picture that can be read.
    pub size: Option<[u32; 2]>,
    /// How many pictures: 1, or the tiles of a UDIM set that are there.
    pub tiles: usize,
}

/// Triangles by material id, of all meshes together, each as often as it stands somewhere.
pub(super) fn uses<'m>(meshes: impl IntoIterator<Item = (&'m Mesh, u64)>, materials: usize) -> Vec<u64> {
    let mut uses = vec![0u64; materials];
    for (mesh, times) in meshes {
        let mut add = |id: u32, count: usize| {
            if let Some(slot) = uses.get_mut(id as usize) {
                *slot += count as u64 * times;
            }
        };
        match &mesh.materials {
            FaceMaterials::Uniform(id) => add(*id, mesh.indices.len()),
            FaceMaterials::PerFace(ids) => {
                ids.chunk_by(|a, b| a == b).for_each(|run| add(run.first().copied().unwrap_or(0), run.len()));
            }
        }
    }
    uses
}

/// The same for a scene: instances may have materials other than their meshes'.
pub(super) fn uses_in(scene: &Scene) -> Vec<u64> {
    let mut times = vec![0u64; scene.instances.meshes.len()];
    let mut others = vec![0u64; scene.materials.len()];
    for place in &scene.instances.places {
        let mesh = place.mesh as usize;
        match place.material.and_then(|id| others.get_mut(id as usize)) {
            Some(own) => *own += scene.instances.meshes.get(mesh).map_or(0, |m| m.indices.len() as u64),
            None => times.iter_mut().skip(mesh).take(1).for_each(|count| *count += 1),
        }
    }
    let at_rest = scene.meshes.iter().map(|mesh| (mesh.as_ref(), 1));
    let placed = scene.instances.meshes.iter().map(AsRef::as_ref).zip(times);
    let mut all = uses(at_rest.chain(placed), scene.materials.len());
    all.iter_mut().zip(others).for_each(|(sum, other)| *sum += other);
    all
}

/// The materials of a mesh file.
pub(super) fn of_object(object: &Object, uses: &[u64]) -> Vec<MaterialReport> {
    let mut reports: Vec<MaterialReport> = object
        .materials
        .iter()
        .zip(uses)
        .map(|(material, &triangles)| MaterialReport {
            name: material.name.clone(),
            model: material.model.name(),
            triangles,
            emits: material.emission != Rgb::ZERO,
            defined: None,
        })
        .collect();
    for (report, definition) in reports.iter_mut().zip(&object.definitions) {
        report.defined = definition.as_ref().map(place);
    }
    reports
}

fn place(definition: &MtlMaterial) -> (PathBuf, u64) {
    (definition.library.clone(), definition.line)
}

/// The materials of a scene.
pub(super) fn of_scene(scene: &Scene, uses: &[u64]) -> Vec<MaterialReport> {
    let report = |(material, &triangles): (&crate::bsdf::Material, &u64)| MaterialReport {
        name: material.name.clone(),
        model: if material.mix.is_some() { crate::bsdf::Mix::NAME.0 } else { material.bsdf.name() },
        triangles,
        emits: material.emission != Rgb::ZERO,
        defined: None,
    };
    scene.materials.iter().zip(uses).map(report).collect()
}

/// Where mesh files' libraries define materials, by name; of several definitions the first.
#[derive(Default)]
pub(super) struct Places(HashMap<String, (PathBuf, u64)>);

impl Places {
    /// Adds what the libraries of `object` define.
    pub fn add(&mut self, object: &Object) {
        for (material, definition) in object.materials.iter().zip(&object.definitions) {
            if let Some(definition) = definition {
                self.0.entry(material.name.clone()).or_insert_with(|| place(definition));
            }
        }
    }

    /// Says it of a scene's materials.
    pub fn name(&self, materials: &mut [MaterialReport]) {
        for report in materials {
            report.defined = self.0.get(&report.name).cloned();
        }
    }
}

/// Every texture of `definitions`; one that is there and cannot be shown is a finding. (That one is missing, the
/// reader says.)
pub(super) fn textures(
    definitions: &[Option<MtlMaterial>],
    reach: &Reach,
    findings: &mut Findings,
) -> Vec<TextureReport> {
    let mut sources = Sources::new(reach);
    let mut reports = Vec::new();
    for material in definitions.iter().flatten() {
        let folder = material.library.parent().unwrap_or(Path::new(""));
        for (key, texture) in material.textures() {
            let name = texture.value.file.as_os_str().as_encoded_bytes();
            let source = sources.find(folder, name).map(|found| found.0);
            let (file, line) = (material.library.clone(), texture.line);
            let size = source.as_ref().and_then(|source| {
                let trouble = match size_of(source, reach) {
                    Ok(size) => return Some(size),
                    Err(trouble) => trouble,
                };
                let message = format!("{}: {key}: the file {}", material.title(), trouble.message());
                let (kind, severity) = (trouble.kind(), Severity::Warning);
                findings.push(Finding { file: file.clone(), line, kind, message, severity });
                None
            });
            reports.push(TextureReport {
                library: file,
                material: String::from_utf8_lossy(&material.name).into_owned(),
                line,
                key: key.to_string(),
                tiles: source.as_ref().map_or(0, |source| source.places().count()),
                path: source
                    .and_then(|source| source.places().next().and_then(|place| place.path().cloned())),
                size,
            });
        }
    }
    reports
}

/// The size of the first picture, or what is wrong with one of them.
fn size_of(source: &Source, reach: &Reach) -> Result<[u32; 2], Trouble> {
    let sizes: Result<Vec<[u32; 2]>, Trouble> =
        source.places().map(|place| probe(place, reach).map(|probe| probe.size)).collect();
    sizes?.first().copied().ok_or(Trouble::Empty)
}

/// The textures that a scene file states itself. What is wrong with them, the reading of the scene says.
pub(super) fn textures_of_scene(stated: &[StatedTexture], reach: &Reach) -> Vec<TextureReport> {
    let report = |stated: &StatedTexture| TextureReport {
        library: stated.file.clone(),
        material: stated.material.clone(),
        line: stated.line,
        key: stated.key.to_string(),
        tiles: stated.source.places().filter(|place| place.exists()).count(),
        path: stated.source.places().filter(|place| place.exists()).find_map(|place| place.path().cloned()),
        size: size_of(&stated.source, reach).ok(),
    };
    stated.iter().map(report).collect()
}
