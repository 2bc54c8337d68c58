//! What the film's layers keep of a first hit.

use crate::bsdf::Scatter;
use crate::film::FirstHit;
use crate::integrator::{Context, Vertex};
use crate::light::Sphere;
use crate::math::{Rgb, Vec2, Vec3};

/// What the film's layers keep of a first hit.
pub fn first_hit(cx: &Context<'_>, v: &Vertex) -> FirstHit {
    let material = &cx.materials[v.part as usize];
    let mut bsdf = material.bsdf.clone();
    if let Some(maps) = &material.maps {
        maps.each(v.surface.uv, |parameter, value| {
            bsdf.set(parameter, value);
        });
    }
    FirstHit {
        depth: v.t,
        normal: v.frame.n,
        albedo: bsdf.albedo(),
        position: v.surface.p,
        uv: v.surface.uv,
        ids: [v.ids[0], v.ids[1], v.material],
    }
}

/// A lamp is no mesh: it has no ids.
pub fn first_hit_of_lamp(lamp: &Sphere, o: Vec3, d: Vec3, t: f32) -> FirstHit {
    let position = o + d * t;
    let normal = (position - lamp.center).normalize_or_zero();
    FirstHit { depth: t, normal, albedo: Rgb::ZERO, position, uv: Vec2::ZERO, ids: [u32::MAX; 3] }
}
