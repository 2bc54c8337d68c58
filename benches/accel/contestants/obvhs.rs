//! The crate `obvhs`: its compressed eight-wide tree and its binary tree, medium preset, with the triangles that it
//! recommends for the CPU, in the order of its leaves. Its SIMD is chosen at compile time.

use super::singles::{Single, Singles, on_threads, triangles};
use crate::contest::Contestant;
use crate::scenes::Scene;
use drt::accel::Rays;
use glam::Vec3A;
use obvhs::BvhBuildParams;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::builder::build_cwbvh_from_tris;
use obvhs::ray::{Ray, RayHit};
use obvhs::rt_triangle::RtTriangle;
use obvhs::triangle::Triangle;
use std::time::Duration;

/// Both trees.
pub fn contestants() -> [Contestant; 2] {
    let medium = BvhBuildParams::medium_build();
    [
        Contestant::new("obvhs cwbvh", move |scene: &Scene, threads| {
            Singles(on_threads(threads, || {
                let triangles = list(scene);
                let tree = build_cwbvh_from_tris(&triangles, medium, &mut Duration::default());
                let triangles = in_order(&triangles, &tree.primitive_indices);
                Wide { tree, triangles }
            }))
        }),
        Contestant::new("obvhs bvh2", move |scene: &Scene, threads| {
            Singles(on_threads(threads, || {
                let triangles = list(scene);
                let tree = build_bvh2_from_tris(&triangles, medium, &mut Duration::default());
                let triangles = in_order(&triangles, &tree.primitive_indices);
                Binary { tree, triangles }
            }))
        }),
    ]
}

struct Wide {
    tree: CwBvh,
    triangles: Vec<RtTriangle>,
}

struct Binary {
    tree: Bvh2,
    triangles: Vec<RtTriangle>,
}

fn list(scene: &Scene) -> Vec<Triangle> {
    triangles(scene).map(|t| t.map(Vec3A::from)).map(|[v0, v1, v2]| Triangle { v0, v1, v2 }).collect()
}

fn in_order(triangles: &[Triangle], order: &[u32]) -> Vec<RtTriangle> {
    order.iter().map(|&i| RtTriangle::from(&triangles[i as usize])).collect()
}

/// Both trees have the same functions, without a common trait.
macro_rules! single {
    ($tree:ty) => {
        impl Single for $tree {
            type Ray = Ray;

            fn ray(rays: &Rays, lane: usize) -> Ray {
                Ray::new(rays.o(lane).into(), rays.d(lane).into(), rays.tmin[lane], rays.tmax[lane])
            }

            #[inline(always)]
            fn closest(&self, ray: &Ray) -> Option<(f32, u32)> {
                let mut hit = RayHit::none();
                self.tree.ray_traverse(*ray, &mut hit, |ray, i| self.triangles[i].intersect(ray));
                (hit.t < f32::INFINITY)
                    .then(|| (hit.t, self.tree.primitive_indices[hit.primitive_id as usize]))
            }

            #[inline(always)]
            fn any_hit(&self, ray: &Ray) -> bool {
                !self.tree.ray_traverse_miss(*ray, |ray, i| self.triangles[i].intersect(ray))
            }

            fn bytes(&self) -> usize {
                size_of_val(&self.tree.nodes[..])
                    + size_of_val(&self.tree.primitive_indices[..])
                    + size_of_val(&self.triangles[..])
            }
        }
    };
}

single!(Wide);
single!(Binary);
