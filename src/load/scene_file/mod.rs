//! Scene files: TOML text becomes a [`Plan`], everything checked that can be checked before a mesh is read.
//!
//! Text → tree with origins ([`tree`]) → values from the command line put in ([`overrides`]) → typed
//! reading, one file a section, where an unknown key is an error with its line, column and a suggestion.

mod camera;
mod daylight;
mod film;
mod light;
mod material;
mod mesh;
mod overrides;
mod reader;
mod render;
#[cfg(test)]
mod tests;
mod texture;
mod transform;
mod tree;

pub use overrides::Override;

pub(crate) use light::LightPlan;
pub(crate) use material::MaterialPatch;
pub(crate) use mesh::{MOST_PLACES, MeshPlan};
pub(crate) use reader::Field;
pub(crate) use tree::Entries;

use super::framing::CameraPlan;
use super::open::Reach;
use crate::camera::Projection;
use crate::error::{Error, Findings, Result};
use crate::scene::{Quantity, Settings};
use reader::Section;
use std::collections::BTreeMap;
use std::io::Read;
use std::path::Path;
use std::sync::Arc;
use tree::{Entry, Node, Value};

/// Larger scene files are taken for something else.
const LARGEST_FILE: u64 = 64 << 20;

/// A scene as its file says it.
pub(crate) struct Plan<'t> {
    pub settings: Settings,
    /// What was noticed while reading.
    pub findings: Findings,
    pub camera: CameraPlan,
    pub meshes: Vec<MeshPlan<'t>>,
    pub materials: BTreeMap<String, MaterialPatch<'t>>,
    pub lights: Vec<LightPlan>,
}

/// Reads a scene file into a tree.
///
/// # Errors
/// The file cannot be read, or is no TOML.
pub(crate) fn tree_of(file: &Path) -> Result<Entries> {
    let (handle, _) = super::open::open_regular(file)?;
    let mut bytes = Vec::new();
    handle.take(LARGEST_FILE + 1).read_to_end(&mut bytes).map_err(|e| Error::io("read", file, &e))?;
    if bytes.len() as u64 > LARGEST_FILE {
        return Err(Error::new("too large for a scene file (limit 64 MiB)").at(file));
    }
    let text = std::str::from_utf8(&bytes).map_err(|e| {
        let before = bytes.get(..e.valid_up_to()).unwrap_or_default();
        let line = before.iter().filter(|b| **b == b'\n').count() as u64 + 1;
        Error::new("not UTF-8").at(file).line(line).advise("scene files are TOML, in UTF-8")
    })?;
    tree::parse(text, file)
}

/// The tree of a scene that is one mesh.
pub(crate) fn tree_of_mesh(file: &Path) -> Entries {
    let flag: Arc<str> = "INPUT".into();
    let entry =
        |value| Entry { key_origin: tree::Origin::Flag(flag.clone()), node: Node::from_flag(value, &flag) };
    let path = entry(Value::Text(file.to_string_lossy().into_owned()));
    let mesh = Value::Table(Entries::from([("file".to_string(), path)]));
    Entries::from([("mesh".to_string(), entry(Value::List(vec![Node::from_flag(mesh, &flag)])))])
}

/// Where a scene's files are.
pub(crate) struct Home<'a> {
    /// The folder that relative paths start in.
    pub folder: &'a Path,
    /// The files that may be read.
    pub reach: &'a Reach,
}

/// Reads every section. Its files are in `home`; `settings` are the defaults.
///
/// # Errors
/// The first wrong value or unknown key, by line and column or by flag.
pub(crate) fn read<'t>(
    tree: &'t Entries,
    file: &'t Path,
    home: &Home<'_>,
    mut settings: Settings,
) -> Result<Plan<'t>> {
    let mut top = Section::top(tree, file);
    let rule = top.read("film", |f| film::read(f.section()?, &mut settings))?.flatten();
    let spp = top.read("render", |f| render::read(f.section()?, &mut settings))?.flatten();
    let mut findings = Findings::default();
    if let Some(rule) = &rule
        && let Some(finding) = film::settle_grid(rule, spp.as_ref(), file, &mut settings)?
    {
        findings.push(finding);
    }
    let camera = top.read("camera", |f| camera::read(f.section()?))?.unwrap_or_default();
    if camera.projection == Projection::Panorama && settings.quantity == Quantity::Flux {
        return Err(Error::new("film.quantity = \"flux\" needs an image plane, and a panorama has none")
            .at(file)
            .advise("leave it out, or choose another camera"));
    }
    let groups = top.read("groups", |f| mesh::read_groups(&f, home.folder))?.unwrap_or_default();
    let meshes = top.read("mesh", |f| mesh::read_all(&f, home.folder, &groups))?.unwrap_or_default();
    let materials = top.read("materials", |f| material::read_all(&f, home))?.unwrap_or_default();
    let lights = top.read("light", |f| light::read_all(&f, home))?.unwrap_or_default();
    top.finish()?;
    Ok(Plan { settings, findings, camera, meshes, materials, lights })
}
