//! Files become plain data.
//!
//! Readers are lenient: what is wrong with a file is skipped or replaced and reported as
//! [`crate::error::Findings`] by file and line; only what makes the whole file useless is an error.
//! Scene files are strict: an unknown key is an error.
//!
//! [`scene`] reads a scene file or a bare mesh. A bare mesh is a scene file with one mesh, so every key can
//! be set for it too; what it lacks (camera, sky, clay) comes from [`auto`].

mod assemble;
pub mod auto;
pub mod cache;
mod classic;
mod format;
mod framing;
mod gltf;
mod input;
pub(crate) mod materials;
pub mod mtl;
pub mod obj;
pub(crate) mod object;
pub mod open;
pub mod picture;
mod place;
mod ply;
mod scene_file;
pub mod sky;
mod stl;
pub(crate) mod texture;
pub mod unpack;
mod wavefront;
mod words;

pub use format::{FORMATS, Format, Opening};
pub(crate) use format::{Reading, is_mesh, read};
pub use input::STDIN;
pub use scene_file::Override;

use crate::error::{Error, Findings, Result};
use crate::memory;
use crate::scene::{Scene, Settings};
use auto::{Up, View};
use open::Reach;
use sky::SkySource;
use std::path::{Path, PathBuf};

/// What the command line adds to a file.
pub struct Options<'a> {
    /// Keys of the scene file set from outside; later ones win.
    pub overrides: Vec<Override>,
    /// The axis that points up; +y by default.
    pub up: Option<Up>,
    /// Where an automatic camera stands.
    pub view: Option<View>,
    /// Puts a ground under the scene, as the last mesh.
    pub ground: bool,
    /// A sky instead of the file's environment.
    pub sky: Option<SkySource>,
    /// Which files the input may name; those that the options name themselves are read wherever they are.
    pub reach: Reach,
    /// Bytes that all textures together may take in memory; pictures beyond it are left out with a warning.
    pub max_texture_bytes: u64,
    /// How the input is opened, if it is a mesh.
    pub opening: Opening,
    /// Where meshes that were read before are kept.
    pub cache: Option<&'a cache::Cache>,
    /// Told now and then the share done (0 to 1); `false` cancels the reading, which then fails with
    /// [`cancelled`].
    pub progress: &'a (dyn Fn(f64) -> bool + Sync),
    /// Says how much memory is left before meshes are read; by default, [`memory::left`].
    pub memory: picture::Memory,
}

impl Default for Options<'_> {
    fn default() -> Self {
        Options {
            overrides: Vec::new(),
            up: None,
            view: None,
            ground: false,
            sky: None,
            reach: Reach::Anywhere,
            max_texture_bytes: texture::MOST_BYTES,
            opening: Opening::default(),
            cache: None,
            progress: &|_| true,
            memory: memory::left,
        }
    }
}

/// A scene, how to render it, and what was noticed on the way.
#[derive(Debug)]
pub struct Loaded {
    /// The scene.
    pub scene: Scene,
    /// How to render it.
    pub settings: Settings,
    /// What was skipped or replaced.
    pub findings: Findings,
    /// Faces left out because something is wrong with them.
    pub skipped_faces: u64,
    /// Triangles as the files say, before those without area and copies were dropped; a ground and lamps count.
    pub triangles: u64,
    /// The mesh files, material libraries and skies that were read.
    pub files: Vec<PathBuf>,
    /// How many of `files` are mesh files; they come first.
    pub mesh_files: usize,
    /// The textures that the scene file states itself.
    pub(crate) textures: Vec<texture::StatedTexture>,
}

/// The error of a reading that its progress callback cancelled.
pub fn cancelled() -> Error {
    Error::new("reading the scene was cancelled")
}

/// Reads the scene file (`.toml`) or bare mesh (of one of the [`FORMATS`]; `-` is standard input) `input`.
///
/// Everything that the scene file says is checked before the first mesh is read.
///
/// # Errors
/// The first wrong key or value, by file, line and column, or by flag with the blame on the usage; what makes
/// a mesh file useless; coordinates beyond 1e18.
pub fn scene(input: &Path, mut options: Options<'_>) -> Result<Loaded> {
    if input != Path::new(STDIN) {
        open::open_regular(input)?;
    }
    let is_bare = is_mesh(input, &options.opening)?;
    let mut tree = if is_bare { scene_file::tree_of_mesh(input) } else { scene_file::tree_of(input)? };
    for change in std::mem::take(&mut options.overrides) {
        change.apply(&mut tree)?;
    }
    let folder = match input.parent() {
        Some(folder) if !is_bare => folder,
        _ => Path::new(""),
    };
    let home = scene_file::Home { folder, reach: &options.reach };
    let size = if is_bare { auto::SIZE } else { Settings::default().size };
    let mut plan = scene_file::read(&tree, input, &home, Settings { size, ..Settings::default() })?;
    if let (true, Some(mesh)) = (is_bare, plan.meshes.first_mut()) {
        // The tree holds text; a path need not be any.
        mesh.file = input.to_path_buf();
    }
    if !is_bare {
        options.opening.format = None;
    }
    if plan.meshes.is_empty() && plan.lights.is_empty() {
        return Err(Error::new("the scene has no mesh and no light")
            .at(input)
            .advise("add a [[mesh]] with file = \"….obj\""));
    }
    let usual_sky = assemble::apply_look(&mut plan, is_bare, &options)?;
    assemble::assemble(plan, input, &options, usual_sky)
}
