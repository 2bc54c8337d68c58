//! The lights of a plan in their places.

use super::Palette;
use crate::light::{Directional, Environment, Light, Point, Sphere, Spot};
use crate::load::materials::MaterialSpec;
use crate::load::scene_file::LightPlan;
use crate::math::{DMat4, DVec3, Rgb};
use crate::scene::Scene;
use crate::shape::{FaceMaterials, Mesh};

/// The lights of a plan's entry, in scene coordinates: `up` and `forward` are the camera's. A flat lamp is none, but a
/// mesh ([`lamp`]).
pub fn place_light(light: &LightPlan, origin: DVec3, up: DVec3, forward: DVec3) -> Vec<Light> {
    if let LightPlan::SunSky(daylight) = light {
        return daylight.lights();
    }
    let one = match light {
        LightPlan::Constant(radiance) => Some(Light::Environment(Environment::Constant(*radiance))),
        LightPlan::Sky { sky, up: own, scale } => {
            let environment = sky.environment(own.unwrap_or(up), forward);
            environment.map(|environment| Light::Environment(environment.scaled(*scale)))
        }
        // A map's zenith is +y unless the file says otherwise: it is no matter of the camera.
        LightPlan::Picture { picture, scale, rotate, up } => {
            picture.light(*scale, *rotate, up.unwrap_or(DVec3::Y))
        }
        LightPlan::Spot { position, direction, cos_outer, cos_inner, intensity } => Some(Light::Spot(Spot {
            position: (*position - origin).as_vec3(),
            direction: direction.as_vec3(),
            intensity: *intensity,
            cos_outer: *cos_outer as f32,
            cos_inner: *cos_inner as f32,
        })),
        LightPlan::Point { position, intensity } => {
            Some(Light::Point(Point { position: (*position - origin).as_vec3(), intensity: *intensity }))
        }
        LightPlan::Directional { direction, irradiance } => {
            Some(Light::Directional(Directional { direction: direction.as_vec3(), irradiance: *irradiance }))
        }
        LightPlan::Sphere { center, radius, radiance } => Some(Light::Sphere(Sphere {
            center: (*center - origin).as_vec3(),
            radius: *radius as f32,
            radiance: *radiance,
        })),
        LightPlan::Rectangle { .. } | LightPlan::SunSky(_) => None,
    };
    one.into_iter().collect()
}

/// The mesh of a flat lamp: black, shining from the side of edge_u × edge_v or from both.
pub fn lamp(light: &LightPlan, origin: DVec3, palette: &mut Palette<'_>) -> Option<Mesh> {
    let LightPlan::Rectangle { corner, edges: [u, v], radiance, two_sided } = light else { return None };
    let corner = *corner - origin;
    let corners = [corner, corner + *u, corner + *u + *v, corner + *v];
    let mut mesh = Mesh::new(corners.map(|p| p.as_vec3().to_array()).to_vec(), vec![[0, 1, 2], [0, 2, 3]]);
    let black = MaterialSpec::diffuse("lamp", Rgb::ZERO);
    let id = palette.add(MaterialSpec { emission: *radiance, two_sided: *two_sided, ..black });
    mesh.materials = FaceMaterials::Uniform(id);
    Some(mesh)
}

/// The light of a mesh file where the mesh is placed. Its strength stays.
pub fn moved(light: &LightPlan, place: DMat4) -> LightPlan {
    let mut light = light.clone();
    match &mut light {
        LightPlan::Point { position, .. } => *position = place.transform_point3(*position),
        LightPlan::Directional { direction, .. } => {
            *direction = place.transform_vector3(*direction).normalize_or(*direction);
        }
        LightPlan::Spot { position, direction, .. } => {
            *position = place.transform_point3(*position);
            *direction = place.transform_vector3(*direction).normalize_or(*direction);
        }
        // No format brings others.
        _ => {}
    }
    light
}

/// No light, or only lights of radiance zero.
pub fn is_dark(scene: &Scene) -> bool {
    let dark = |light: &Light| match light {
        Light::Environment(environment) => environment.is_black(),
        Light::Directional(d) => d.irradiance == Rgb::ZERO,
        Light::Sphere(s) => s.radiance == Rgb::ZERO,
        Light::Sun(s) => s.radiance == Rgb::ZERO,
        Light::Spot(s) => s.intensity == Rgb::ZERO,
        Light::Point(point) => point.intensity == Rgb::ZERO,
    };
    scene.lights.iter().all(dark) && scene.materials.iter().all(|m| m.emission == Rgb::ZERO)
}
