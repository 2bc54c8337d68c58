//! Only the intersector: rays against triangles, without a scene, a camera or a light.
//!
//! `cargo run --release --example trace [-- embree | bvh]`
//!
//! Embree and our own BVH are built over the same hills and asked for the same rays through the same three calls:
//! [`Backend::build`], [`Intersector::closest`], [`Intersector::occluded`].

use drt::accel::{Backend, BuildOptions, Coherence, Hit, Hits, Intersector, LANES, Mask, Rays};
use drt::error::Result;
use drt::math::Vec3;
use drt::shape::Mesh;
use std::sync::Arc;

fn main() -> Result<()> {
    let backends = match std::env::args().nth(1) {
        Some(name) => vec![Backend::from_name(&name)?],
        None => Backend::ALL.to_vec(),
    };
    // Meshes are shared, not copied: Embree reads their buffers in place.
    let meshes = [Arc::new(hills(200))];
    for backend in backends {
        let accel = backend.build(&meshes, &BuildOptions::default())?;
        let kib = accel.bytes() >> 10;
        println!("{} ({}): {} triangles, {kib} KiB", backend.name(), accel.isa(), meshes[0].indices.len());
        for (lane, (hit, is_lit)) in trace(&*accel, &fan(), SUN).into_iter().enumerate() {
            match hit {
                Some(Hit { t, u, v, triangle, .. }) => {
                    let sun = if is_lit { "in the sun" } else { "in the shade" };
                    println!(
                        "  ray {lane:2}: triangle {triangle:5} at t = {t:.4}, u = {u:.3}, v = {v:.3}, {sun}"
                    );
                }
                None => println!("  ray {lane:2}: the sky"),
            }
        }
    }
    Ok(())
}

/// The way to the sun.
const SUN: Vec3 = Vec3::new(0.3, 0.2, 0.4);

/// What each ray of a chunk hits, and whether the sun shines there.
fn trace(accel: &dyn Intersector, rays: &Rays, sun: Vec3) -> Vec<(Option<Hit>, bool)> {
    // `check` keeps NaN and the like from the backend; the mask says which lanes are rays at all.
    let mut hits = Hits::default();
    accel.closest(rays.check(Mask::MAX), Coherence::Coherent, &mut hits);

    // The second chunk starts where the first one ended. Lanes without a hit stay switched off.
    let (mut shadows, mut active) = (Rays::default(), 0);
    for lane in 0..LANES {
        if let Some(hit) = hits.get(lane) {
            // A little less far than the hit: a ray must not meet the triangle that it starts from.
            let point = rays.o(lane) + rays.d(lane) * (hit.t * 0.9999);
            shadows.set(lane, point, sun, 0.0, f32::INFINITY);
            active |= 1 << lane;
        }
    }
    let blocked = accel.occluded(shadows.check(active), Coherence::Incoherent);
    (0..LANES).map(|lane| (hits.get(lane), active & !blocked & 1 << lane != 0)).collect()
}

/// Sixteen rays from one point, the lowest down to the hills and the highest into the sky.
fn fan() -> Rays {
    let mut rays = Rays::default();
    for lane in 0..LANES {
        let slope = 0.1 - 0.06 * lane as f32;
        rays.set(lane, Vec3::new(-1.2, 0.5, 0.053), Vec3::new(1.0, slope, 0.0), 0.0, f32::INFINITY);
    }
    rays
}

/// A square of `side`×`side` cells with hills on it.
fn hills(side: u32) -> Mesh {
    let height = |x: f32, z: f32| 0.15 * (9.0 * x).sin() * (7.0 * z).cos();
    let at = |i: u32| 2.0 * i as f32 / side as f32 - 1.0;
    let row = |j: u32| (0..=side).map(move |i| [at(i), height(at(i), at(j)), at(j)]);
    let cell = |i: u32, j: u32| {
        let a = j * (side + 1) + i;
        let (b, c, d) = (a + 1, a + side + 1, a + side + 2);
        [[a, c, b], [b, c, d]]
    };
    let positions = (0..=side).flat_map(row).collect();
    let indices = (0..side).flat_map(|j| (0..side).flat_map(move |i| cell(i, j))).collect();
    Mesh::new(positions, indices)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The example shows what it says: sky, sun and shade, on every backend the same, and on the hills.
    #[test]
    fn backends_see_the_same_hills() -> Result<()> {
        let meshes = [Arc::new(hills(200))];
        for backend in Backend::ALL {
            let accel = backend.build(&meshes, &BuildOptions::default())?;
            let seen = trace(&*accel, &fan(), SUN);
            let count = |is: fn(&(Option<Hit>, bool)) -> bool| seen.iter().filter(|s| is(s)).count();
            assert_eq!(count(|s| s.0.is_none()), 5, "{}: {seen:?}", backend.name());
            assert_eq!(count(|s| s.1), 6, "{}: {seen:?}", backend.name());
            for (lane, (hit, _)) in seen.into_iter().enumerate() {
                let rays = fan();
                let (o, d) = (rays.o(lane), rays.d(lane));
                assert_eq!(hit.map(|h| h.triangle), accel.closest_one(o, d, 0.0, 9.0).map(|h| h.triangle));
                if let Some(Hit { t, u, v, triangle, .. }) = hit {
                    let [a, b, c] = meshes[0].triangle(triangle as usize);
                    let point = a * (1.0 - u - v) + b * u + c * v;
                    assert!((o + d * t).distance(point) < 1e-5, "{}: {hit:?}", backend.name());
                }
            }
        }
        Ok(())
    }
}
