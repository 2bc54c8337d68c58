//! The crate `bvh`: a binary tree with one triangle a leaf. (Its SIMD needs a nightly compiler.)
//!
//! Its own triangle test culls back faces and refuses determinants below f32's epsilon, which loses the triangles
//! of a large mesh altogether; the one here is the same without the two, as its documentation suggests.

use super::singles::{Single, Singles, on_threads, triangles};
use crate::contest::Contestant;
use crate::scenes::Scene;
use bvh::aabb::{Aabb, Bounded, IntersectsAabb};
use bvh::bounding_hierarchy::{BHShape, BoundingHierarchy};
use bvh::bvh::{Bvh, BvhNode};
use bvh::ray::Ray;
use drt::accel::Rays;
use drt::math::Vec3;
use nalgebra::{Point3, Vector3};

/// The one tree.
pub fn contestants() -> [Contestant; 1] {
    [Contestant::new("bvh crate", |scene: &Scene, threads| {
        Singles(on_threads(threads, || {
            let mut triangles: Vec<Triangle> = triangles(scene).zip(0..).map(Triangle::new).collect();
            let tree = Bvh::build_par(&mut triangles);
            let is_deep = depth(&tree) >= ITERATORS_STACK;
            Tree { tree, triangles, is_deep }
        }))
    })]
}

struct Tree {
    tree: Bvh<f32, 3>,
    triangles: Vec<Triangle>,
    /// Too deep for the fast iterator.
    is_deep: bool,
}

/// The crate's unordered iterator panics in deeper trees.
const ITERATORS_STACK: usize = 32;

/// Levels of nodes.
fn depth(tree: &Bvh<f32, 3>) -> usize {
    let (mut deepest, mut todo) = (0, vec![(0, 1)]);
    while let Some((index, level)) = todo.pop() {
        deepest = level.max(deepest);
        if let Some(&BvhNode::Node { child_l_index, child_r_index, .. }) = tree.nodes.get(index) {
            todo.extend([(child_l_index, level + 1), (child_r_index, level + 1)]);
        }
    }
    deepest
}

struct Triangle {
    corners: [Point3<f32>; 3],
    id: u32,
    node: usize,
}

impl Triangle {
    fn new((corners, id): ([Vec3; 3], u32)) -> Self {
        Triangle { corners: corners.map(|p| Point3::new(p.x, p.y, p.z)), id, node: 0 }
    }

    /// Möller and Trumbore's distance.
    fn distance(&self, ray: &Ray<f32, 3>) -> Option<f32> {
        let [a, b, c] = &self.corners;
        let (ab, ac) = (b - a, c - a);
        let u_vec = ray.direction.cross(&ac);
        let inverse = 1.0 / ab.dot(&u_vec);
        let from_a = ray.origin - a;
        let u = from_a.dot(&u_vec) * inverse;
        let v_vec = from_a.cross(&ab);
        let v = ray.direction.dot(&v_vec) * inverse;
        (u >= 0.0 && v >= 0.0 && u + v <= 1.0).then(|| ac.dot(&v_vec) * inverse)
    }
}

impl Bounded<f32, 3> for Triangle {
    fn aabb(&self) -> Aabb<f32, 3> {
        let [a, b, c] = &self.corners;
        Aabb::with_bounds(a.inf(b).inf(c), a.sup(b).sup(c))
    }
}

impl BHShape<f32, 3> for Triangle {
    fn set_bh_node_index(&mut self, index: usize) {
        self.node = index;
    }

    fn bh_node_index(&self) -> usize {
        self.node
    }
}

/// The crate's rays are infinite, but its traversal takes anything that meets boxes.
struct Ending<'a> {
    ray: &'a Ray<f32, 3>,
    end: f32,
}

impl IntersectsAabb<f32, 3> for Ending<'_> {
    #[inline(always)]
    fn intersects_aabb(&self, aabb: &Aabb<f32, 3>) -> bool {
        self.ray.intersection_slice_for_aabb(aabb).is_some_and(|(enter, _)| enter <= self.end)
    }
}

impl Single for Tree {
    type Ray = (Ray<f32, 3>, f32);

    fn ray(rays: &Rays, lane: usize) -> Self::Ray {
        let (o, d) = (rays.o(lane), rays.d(lane));
        (Ray::new(Point3::new(o.x, o.y, o.z), Vector3::new(d.x, d.y, d.z)), rays.tmax[lane])
    }

    /// From near to far: twice as fast as its unordered iterator with a shrinking ray.
    #[inline(always)]
    fn closest(&self, (ray, tmax): &Self::Ray) -> Option<(f32, u32)> {
        let mut best = None;
        let mut end = *tmax;
        for triangle in self.tree.nearest_traverse_iterator(ray, &self.triangles) {
            // Boxes come in the order in which they are entered.
            if ray.intersection_slice_for_aabb(&triangle.aabb()).is_none_or(|(enter, _)| enter > end) {
                break;
            }
            if let Some(t) = triangle.distance(ray).filter(|&t| t >= 0.0 && t < end) {
                end = t;
                best = Some((t, triangle.id));
            }
        }
        best
    }

    #[inline(always)]
    fn any_hit(&self, ray: &Self::Ray) -> bool {
        if self.is_deep {
            return self.closest(ray).is_some();
        }
        let (ray, end) = ray;
        let hit = |t: &Triangle| t.distance(ray).is_some_and(|t| t >= 0.0 && t <= *end);
        self.tree.traverse_iterator(&Ending { ray, end: *end }, &self.triangles).any(hit)
    }

    fn bytes(&self) -> usize {
        size_of_val(&self.tree.nodes[..]) + size_of_val(&self.triangles[..])
    }
}
