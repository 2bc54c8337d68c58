//! Materials with their pictures on.

use super::bare;
use super::pictures::{self, Means, Pictures};
use super::{MapSpec, Slot, Source};
use crate::bsdf::{Map, Maps, Material, Parameter, Scatter};
use crate::error::{Findings, Result};
use crate::load::materials::MaterialSpec;
use crate::load::open::Reach;
use crate::math::Rgb;
use crate::shape::Mesh;
use crate::texture::{Channel, Opacity, Relief, Shape, Texels, Texture, Tiles, Transfer};
use std::sync::Arc;

/// What building may take, and who hears of it.
pub(crate) struct Job<'a> {
    /// The files that may be read.
    pub reach: &'a Reach,
    /// Bytes of all textures together.
    pub most_bytes: u64,
    /// Its `false` cancels.
    pub progress: &'a (dyn Fn(f64) -> bool + Sync),
}

/// The materials that `specs` describe, with every picture that can be shown. Triangles of `meshes` without texture
/// coordinates get materials of their own, which have constants instead.
///
/// # Errors
/// Cancelled.
pub(crate) fn build(
    specs: &[MaterialSpec],
    meshes: &mut [Arc<Mesh>],
    job: &Job<'_>,
    findings: &mut Findings,
) -> Result<Vec<Material>> {
    let maps = specs.iter().flat_map(|spec| &spec.maps);
    let mut pictures = pictures::load(maps, job.reach, job.most_bytes, job.progress, findings)?;
    let mut materials: Vec<Material> = specs.iter().map(|spec| material(spec, Some(&mut pictures))).collect();
    bare::separate(specs, meshes, &mut materials, findings);
    Ok(materials)
}

/// The material that `spec` describes; without pictures, the constants in their place.
pub(super) fn material(spec: &MaterialSpec, mut pictures: Option<&mut Pictures>) -> Material {
    let (opacity, rotation) = (spec.opacity, spec.rotation);
    let mut material = spec.clone().build();
    let mut maps = Maps::default();
    if opacity < 1.0 {
        maps.opacity = Some(Opacity { constant: opacity, texture: None });
    }
    for spec in &spec.maps {
        let shown = pictures.as_deref_mut().and_then(|all| Some((texture(spec, all)?, &mut all.means)));
        match shown {
            Some((texture, means)) => lay(spec, texture, means, opacity, &mut maps, &mut material),
            None => do_without(spec, &mut material),
        }
    }
    let changed = |map: &Map| map.parameter == Parameter::Anisotropy;
    if material.bsdf.has_grain() || maps.parameters.iter().any(changed) {
        let turns = f64::from(rotation).to_radians();
        maps.grain = Some([libm::cos(turns), libm::sin(turns)].map(|x| x as f32));
    }
    if maps != Maps::default() {
        material.maps = Some(Arc::new(maps));
    }
    material
}

/// The picture or set of `spec`, as far as its files could be decoded.
fn texture(spec: &MapSpec, pictures: &mut Pictures) -> Option<Texture> {
    let Pictures { by_place, sets, .. } = pictures;
    match &spec.source {
        Source::One(place) => Some(Texture::new(by_place.get(place)?.clone(), spec.mapping)),
        Source::Tiles(files) => {
            let set = sets.entry(Arc::as_ptr(files)).or_insert_with(|| {
                let tiles = files.iter().filter_map(|(n, place)| Some((*n, by_place.get(place)?.clone())));
                Tiles::new(tiles.collect())
            });
            let absent = spec.fallback.unwrap_or(Rgb::ZERO);
            Some(Texture::tiles(set.clone()?, spec.mapping, absent))
        }
    }
}

/// Puts a picture where it belongs.
fn lay(
    spec: &MapSpec,
    texture: Texture,
    means: &mut Means,
    opacity: f32,
    maps: &mut Maps,
    material: &mut Material,
) {
    match spec.slot {
        Slot::Parameter(Parameter::Emission) => {
            // For choosing among lights; what a point emits is looked up.
            // Many materials may have one picture, and its mean takes a look at every texel.
            let mean = *means.entry(texture.mean_key()).or_insert_with(|| texture.texel_mean());
            material.emission = Parameter::Emission.clamp(texture.of_mean(mean));
            maps.emission = Some(texture);
        }
        Slot::Alpha if !texture.has_alpha() => {}
        Slot::Parameter(Parameter::Opacity) | Slot::Alpha => {
            let channel = if texture.has_alpha() { Channel::Alpha } else { Channel::Luminance };
            let texture = texture.with_channel(channel);
            maps.opacity = Some(Opacity { constant: opacity, texture: Some(texture) });
        }
        Slot::Parameter(parameter) => maps.parameters.push(Map { parameter, texture }),
        Slot::Normal(strength) => maps.relief = Some(Relief { map: texture, shape: Shape::Normal(strength) }),
        Slot::Height { height, normals } => {
            let shape = if normals && looks_like_normals(texture.texels()) {
                Shape::Normal(1.0f32.copysign(height))
            } else {
                Shape::Height(height)
            };
            maps.relief = Some(Relief { map: texture, shape });
        }
    }
}

/// A picture that could not be decoded leaves a constant behind.
fn do_without(spec: &MapSpec, material: &mut Material) {
    let (Slot::Parameter(parameter), Some(value)) = (spec.slot, spec.fallback) else { return };
    if parameter == Parameter::Emission {
        material.emission = value;
    } else {
        material.bsdf.set(parameter, value);
    }
}

/// Whether a picture holds normals: bluish on average, and nearly all texels unit vectors. Many exporters name normal
/// maps with `map_Bump`, which has no other word for them.
fn looks_like_normals(texels: &Texels) -> bool {
    let (mut count, mut unit, mut outwards) = (0u32, 0u32, 0.0f32);
    let [width, height] = texels.size().map(|n| n as usize);
    let step = (width * height / 4096).max(1);
    for [r, g, b, _] in texels.some_pixels(Transfer::Linear, step) {
        let [x, y, z] = [r, g, b].map(|c| 2.0 * c - 1.0);
        count += 1;
        // A light grey of a height map is a unit vector too, along the diagonal.
        let is_grey = (x - z).abs().max((y - z).abs()) < 0.1;
        unit += u32::from(!is_grey && ((x * x + y * y + z * z).sqrt() - 1.0).abs() < 0.15);
        outwards += z;
    }
    unit * 10 >= count * 9 && outwards > 0.5 * count as f32
}
