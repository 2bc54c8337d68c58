//! Where paths begin: the ray through a pixel, and what the film's layers keep of its hit.

use crate::bsdf::Scatter;
use crate::film::FirstHit;
use crate::film::rule::{Numbers, PixelPoint};
use crate::integrator::{Context, Dimensions, Vertex};
use crate::light::Sphere;
use crate::math::ray::Ray;
use crate::math::{Rgb, Vec2, Vec3};
use crate::sampler::Key;

/// When a sample is taken: 0 as the shutter opens, before 1 when it closes.
#[inline(always)]
pub fn time(cx: &Context<'_>, key: Key) -> f32 {
    if cx.moves { cx.sampler.d1(key, cx.dimensions.time) } else { 0.0 }
}

/// The ray through a point of pixel (`x`, `y`) that the pixel rule chose, and its weight.
#[inline(always)]
pub fn camera_ray(cx: &Context<'_>, x: u32, y: u32, key: Key, time: f32) -> (Ray, f32) {
    let numbers = match cx.pixel.numbers() {
        Numbers::Sampler => cx.sampler.d2(key, Dimensions::PIXEL),
        Numbers::Random => cx.random.d2(key, Dimensions::PIXEL),
        Numbers::None => [0.5; 2],
    };
    let PixelPoint { offset: [u, v], weight } = cx.pixel.point(key.index, numbers);
    let lens = if cx.camera.has_lens() { cx.sampler.d2(key, Dimensions::LENS) } else { [0.5; 2] };
    // In f64: at 100,000 pixels a side f32 leaves 1/128 of a pixel.
    let place =
        |i: u32, offset: f32, n: u32| ((f64::from(i) + 0.5 + f64::from(offset)) / f64::from(n)) as f32;
    let ray = cx.camera.ray(place(x, u, cx.size[0]), place(y, v, cx.size[1]), lens, time);
    (Ray { o: ray.o, d: ray.d, tmax: f32::INFINITY }, weight)
}

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
