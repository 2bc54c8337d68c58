//! Digests of a scene's parts, by which a checkpoint knows the scene that it belongs to: all that a picture depends
//! on, and neither names nor paths nor times.
//!
//! Structures are taken apart without `..`, so that a new field cannot be forgotten here.

use super::Scene;
use crate::bsdf::{Map, Maps, Material};
use crate::light::{Environment, Light};
use crate::math::digest::Digest;
use crate::shape::{Attribute, FaceMaterials, Instances, Mesh};
use crate::texture::{Opacity, Relief, Texels};
use std::collections::HashMap;
use std::sync::Arc;

impl Scene {
    /// The digest of each part, with what the part is called; `None` when `stop` ended it.
    pub fn fingerprint(&self, stop: &dyn Fn() -> bool) -> Option<[(&'static str, String); 4]> {
        let Scene { origin, meshes, instances, materials, lights, camera } = self;
        let Instances { meshes: placed, places } = instances;
        let mut shapes = Digest::new();
        shapes.value(&digest_of_meshes(meshes, stop)?);
        shapes.value(&digest_of_meshes(placed, stop)?);
        shapes.value(places);
        let materials = digest_of_materials(materials, stop)?;
        let mut shining = Digest::new();
        for light in lights {
            if stop() {
                return None;
            }
            match light {
                Light::Environment(Environment::Panorama(map)) => map.digest(&mut shining),
                other => shining.value(other),
            }
        }
        let mut view = Digest::new();
        view.value(&(origin, camera));
        Some([
            ("meshes or instances", shapes.hex()),
            ("materials or textures", materials),
            ("lights", shining.hex()),
            ("camera", view.hex()),
        ])
    }
}

/// What is shared is looked at once; it is known by its place in memory.
fn once<T: ?Sized>(
    seen: &mut HashMap<*const T, [u8; 32]>,
    shared: &Arc<T>,
    digest: impl FnOnce(&T, &mut Digest),
) -> [u8; 32] {
    *seen.entry(Arc::as_ptr(shared)).or_insert_with(|| {
        let mut own = Digest::new();
        digest(shared, &mut own);
        own.finish()
    })
}

fn digest_of_meshes(meshes: &[Arc<Mesh>], stop: &dyn Fn() -> bool) -> Option<String> {
    let mut all = Digest::new();
    let mut seen = HashMap::new();
    for mesh in meshes {
        if stop() {
            return None;
        }
        all.bytes(&once(&mut seen, mesh, digest_mesh));
    }
    Some(all.hex())
}

fn digest_mesh(mesh: &Mesh, digest: &mut Digest) {
    let Mesh { positions, indices, normals, uvs, materials } = mesh;
    digest.floats(positions);
    digest.numbers(indices);
    digest_attribute(normals.as_ref(), digest);
    digest_attribute(uvs.as_ref(), digest);
    match materials {
        FaceMaterials::Uniform(id) => digest.value(id),
        FaceMaterials::PerFace(ids) => digest.values(ids, u32::to_le_bytes),
    }
}

fn digest_attribute<const N: usize>(attribute: Option<&Attribute<[f32; N]>>, digest: &mut Digest) {
    digest.value(&attribute.is_some());
    if let Some(Attribute { values, indices }) = attribute {
        digest.floats(values);
        digest.value(&indices.is_some());
        digest.numbers(indices.as_deref().unwrap_or_default());
    }
}

fn digest_of_materials(materials: &[Material], stop: &dyn Fn() -> bool) -> Option<String> {
    let mut all = Digest::new();
    let mut seen = HashMap::new();
    for material in materials {
        let Material { name: _, bsdf, emission, two_sided, maps, mix } = material;
        all.value(&(bsdf, emission, two_sided, mix));
        let Some(maps) = maps.as_deref() else { continue };
        let mut texels = |texels: &Arc<Texels>| {
            if stop() { [0; 32] } else { once(&mut seen, texels, |texels, digest| texels.digest(digest)) }
        };
        let Maps { parameters, emission, opacity, relief, grain } = maps;
        all.value(grain);
        for Map { parameter, texture } in parameters {
            all.value(parameter);
            texture.digest(&mut all, &mut texels);
        }
        if let Some(texture) = emission {
            all.value(&"emission");
            texture.digest(&mut all, &mut texels);
        }
        if let Some(Opacity { constant, texture }) = opacity {
            all.value(&("opacity", constant));
            if let Some(texture) = texture {
                texture.digest(&mut all, &mut texels);
            }
        }
        if let Some(Relief { map, shape }) = relief {
            all.value(&("relief", shape));
            map.digest(&mut all, &mut texels);
        }
    }
    (!stop()).then(|| all.hex())
}
