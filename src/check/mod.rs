//! What is in a file and what is wrong with it: the mesh doctor behind `drt check`.
//!
//! [`check`] reads a mesh or a scene as a render would, then looks at what came out: sizes, materials,
//! textures, and how the triangles hang together. What it notices joins the reader's own [`Findings`]. A finding
//! is an error when the file breaks its format's rules or nothing can be rendered; a warning when a picture will
//! probably not look as meant; a note when it is worth knowing (an open surface is legitimate).
//!
//! Topology is judged twice: by index, as the file says it, and after welding vertices at exactly the same
//! place, as the eye sees it. Findings are about the latter.
//!
//! Messages hold nothing that a referenced file says, only lines and key words.

#[cfg(feature = "tobj")]
pub mod against_tobj;
mod findings;
mod geometry;
mod materials;
mod mesh;
mod topology;
mod weld;

pub use materials::{MaterialReport, TextureReport};
pub use mesh::{Bounds, MeshReport, check_mesh, short};
pub use topology::Topology;

use crate::error::{Error, Finding, Findings, Result};
use crate::load::object::Object;
use crate::load::open::Reach;
use crate::load::texture::StatedTexture;
use crate::load::{self, Opening, Reading, obj::ReadOptions};
use std::path::{Path, PathBuf};

/// What is in a file and what is wrong with it.
#[derive(Clone, Debug)]
pub struct Report {
    /// The file.
    pub input: PathBuf,
    /// Triangles that would be rendered; a mesh that a scene places twice counts twice.
    pub triangles: u64,
    /// Vertices in memory, used or not.
    pub vertices: u64,
    /// Faces left out because something is wrong with them.
    pub skipped_faces: u64,
    /// The box around all triangles in the file's coordinates; `None` without triangles.
    pub bounds: Option<Bounds>,
    /// Triangles whose material emits light.
    pub emitting_triangles: u64,
    /// The mesh files, one entry a file.
    pub meshes: Vec<MeshReport>,
    /// Of a mesh: every name after `usemtl`, in the order they first appear, whether faces have it or a library
    /// defines it or not; the empty name is the material of faces before any `usemtl`. What a library defines and
    /// no `usemtl` names is not here, only counted ([`MeshReport::library_materials`]). Of a scene: its materials.
    pub materials: Vec<MaterialReport>,
    /// Every texture that the materials' libraries and the scene file state.
    pub textures: Vec<TextureReport>,
    /// What is wrong or worth knowing.
    pub findings: Findings,
}

impl Report {
    /// How many of the materials some triangle has.
    pub fn materials_in_use(&self) -> usize {
        self.materials.iter().filter(|m| m.triangles > 0).count()
    }
}

pub(crate) fn out_of_memory() -> Error {
    Error::new("not enough memory to check the mesh").advise("use a machine with more memory")
}

/// Checks the mesh (of any of the [`load::FORMATS`]; `-` is standard input) or scene file (`.toml`) `input`. `reach`: the
/// files that may be read. `progress` hears the share of the reading done (0 to 1); its `false` cancels with
/// [`load::cancelled`].
///
/// # Errors
/// What cannot be read at all; for scenes, everything that [`load::scene`] refuses.
pub fn check(
    input: &Path,
    opening: Opening,
    reach: &Reach,
    progress: &(dyn Fn(f64) -> bool + Sync),
) -> Result<Report> {
    if input != Path::new(load::STDIN) {
        load::open::open_regular(input)?;
    }
    match load::is_mesh(input, &opening)? {
        true => check_object(input, Job { opening, reach, progress }),
        false => check_scene(input, Job { opening: Opening { format: None, ..opening }, reach, progress }),
    }
}

/// How to read, and who hears of it.
#[derive(Clone, Copy)]
struct Job<'a> {
    opening: Opening,
    reach: &'a Reach,
    progress: &'a (dyn Fn(f64) -> bool + Sync),
}

/// A mesh file and what it shows of itself. `defined`: the materials that need no library.
fn read(
    file: &Path,
    job: Job<'_>,
    defined: &dyn Fn(&[u8]) -> bool,
) -> Result<(Object, MeshReport, Findings)> {
    let Job { opening, reach, progress } = job;
    let options = ReadOptions { progress, keep_empty: true, face_lines: true, ..ReadOptions::default() };
    let most_copied = u64::MAX;
    let mut object =
        load::read(file, &Reading { options, opening, reach, most_copied, defined, cache: None })?;
    let mut findings = std::mem::take(&mut object.findings);
    let going_on = || if progress(1.0) { Ok(()) } else { Err(load::cancelled()) };
    going_on()?;
    let lines = object.face_lines.as_deref().unwrap_or_default();
    let (mut mesh, own) =
        check_mesh(file, &object.mesh, object.origin, lines, object.counts).map_err(|e| e.at(file))?;
    going_on()?;
    mesh.libraries.clone_from(&object.libraries);
    mesh.library_materials = object.defined;
    findings.append(own);
    Ok((object, mesh, findings))
}

fn check_object(input: &Path, job: Job<'_>) -> Result<Report> {
    let (object, mesh, mut findings) = read(input, job, &|_| false)?;
    let uses = materials::uses([(&object.mesh, 1)], object.materials.len());
    let mut textures = materials::textures(&object.definitions, job.reach, &mut findings);
    let stated = StatedTexture::of(&object.materials, input);
    textures.append(&mut materials::textures_of_scene(&stated, job.reach));
    let materials = materials::of_object(&object, &uses);
    Ok(Report {
        input: input.to_path_buf(),
        triangles: mesh.triangles,
        vertices: mesh.vertices,
        skipped_faces: mesh.counts.skipped_faces,
        bounds: mesh.bounds,
        emitting_triangles: materials.iter().filter(|m| m.emits).map(|m| m.triangles).sum(),
        meshes: vec![mesh],
        materials,
        textures,
        findings,
    })
}

fn check_scene(input: &Path, job: Job<'_>) -> Result<Report> {
    let Job { opening, reach, progress } = job;
    let options = load::Options { progress, opening, reach: reach.clone(), ..load::Options::default() };
    let loaded = load::scene(input, options)?;
    let scene = &loaded.scene;
    let uses = materials::uses_in(scene);
    let bounds = scene.bounds();
    let placed = [bounds.min, bounds.max].map(|p| p.as_dvec3() + scene.origin);
    let mut report = Report {
        input: input.to_path_buf(),
        triangles: scene.placed_triangles(),
        vertices: scene.vertices(),
        skipped_faces: loaded.skipped_faces,
        bounds: (!bounds.is_empty()).then_some(Bounds { min: placed[0], max: placed[1] }),
        emitting_triangles: 0,
        meshes: Vec::new(),
        materials: materials::of_scene(scene, &uses),
        textures: materials::textures_of_scene(&loaded.textures, reach),
        findings: Findings::default(),
    };
    // The meshes' own findings come again, with lines, when their files are looked at one by one; but which
    // materials nobody defines only the scene knows.
    let is_of_scene = |f: &&Finding| f.file == input || f.kind == "material-unknown";
    let of_scene: Vec<Finding> = loaded.findings.kept().filter(is_of_scene).cloned().collect();
    of_scene.into_iter().for_each(|finding| report.findings.push(finding));
    let files: Vec<PathBuf> = loaded.files.iter().take(loaded.mesh_files).cloned().collect();
    drop(loaded);
    let mut places = materials::Places::default();
    for file in files {
        let (object, mesh, findings) = read(&file, job, &|_| true)?;
        report.findings.append(findings);
        let of_mtl = materials::textures(&object.definitions, reach, &mut report.findings);
        report.textures.extend(of_mtl);
        let stated = StatedTexture::of(&object.materials, &file);
        report.textures.extend(materials::textures_of_scene(&stated, reach));
        places.add(&object);
        report.meshes.push(mesh);
    }
    places.name(&mut report.materials);
    report.emitting_triangles = report.materials.iter().filter(|m| m.emits).map(|m| m.triangles).sum();
    Ok(report)
}

#[cfg(test)]
mod tests;
