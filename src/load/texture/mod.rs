//! Textures: from what an MTL or a scene file states to pictures on materials.
//!
//! Statements become [`MapSpec`]s of a [`MaterialSpec`](super::materials::MaterialSpec) while files are read ([`mtl`],
//! and the scene file's reader); when all materials are known, every picture is decoded once ([`pictures`]) and laid
//! on them ([`build`]). What cannot be shown is a warning, and a constant takes its place.

mod bare;
mod build;
mod mtl;
mod pictures;
mod plain;
mod source;

pub(crate) use build::{Job, build};
pub(crate) use mtl::{Search, of_mtl};
pub(crate) use pictures::MOST_BYTES;
pub(crate) use plain::of_picture;
pub(crate) use source::{Inside, Place, Source, Sources};

use super::materials::MaterialSpec;
use crate::bsdf::Parameter;
use crate::math::Rgb;
use crate::texture::Mapping;
use std::path::{Path, PathBuf};

/// A picture for one part of a material.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct MapSpec {
    /// What it changes.
    pub slot: Slot,
    /// Its files.
    pub source: Source,
    /// How it is laid over the surface.
    pub mapping: Mapping,
    /// What holds where the picture cannot be shown; `None`: what the material says without it.
    pub fallback: Option<Rgb>,
    /// Where it is stated.
    pub stated: Stated,
}

/// What a picture changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Slot {
    /// A number or colour, emission and opacity among them.
    Parameter(Parameter),
    /// A normal map with its strength.
    Normal(f32),
    /// A height map with its height in widths of the picture. `normals`: a picture that looks like normals is taken
    /// for such, the number of hundredths for its strength.
    Height { height: f32, normals: bool },
    /// Opacity by the alpha of the colour's picture, if that says anything.
    Alpha,
}

impl Slot {
    /// The key of the scene file that sets it.
    pub fn key(&self) -> &'static str {
        match self {
            Slot::Parameter(parameter) => parameter.key(),
            Slot::Normal(_) => "normal_map",
            Slot::Height { .. } => "bump",
            Slot::Alpha => Parameter::Opacity.key(),
        }
    }

    /// True for what turns the shading normal.
    pub fn is_relief(&self) -> bool {
        matches!(self, Slot::Normal(_) | Slot::Height { .. })
    }
}

/// Where a picture is stated, for findings.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Stated {
    /// The file that states it.
    pub file: PathBuf,
    /// Its line.
    pub line: u64,
    /// Whose it is: `material "wood": map_Kd`, `materials.wood.reflectance`.
    pub title: String,
}

/// A texture that a scene file states, for `drt check`.
#[derive(Clone, Debug)]
pub(crate) struct StatedTexture {
    /// The scene file.
    pub file: PathBuf,
    /// Its line.
    pub line: u64,
    /// The material's name.
    pub material: String,
    /// The material's key.
    pub key: &'static str,
    /// The pictures, there or not.
    pub source: Source,
}

impl StatedTexture {
    /// Those of `specs` that `file` states.
    pub fn of(specs: &[MaterialSpec], file: &Path) -> Vec<StatedTexture> {
        let own = specs.iter().flat_map(|spec| spec.maps.iter().map(move |map| (spec, map)));
        own.filter(|(_, map)| map.stated.file == file)
            .map(|(spec, map)| StatedTexture {
                file: file.to_path_buf(),
                line: map.stated.line,
                material: spec.name.clone(),
                key: map.slot.key(),
                source: map.source.clone(),
            })
            .collect()
    }
}
