//! Every triangle near a ray, measured in f64: the judge's own way to find them, shared with no backend.
//!
//! Triangles are sorted along a Morton curve and cut into groups of 32 with a ball around each, and 64 groups into a
//! larger one; what the ray's line passes by more than the tolerance is left out. That is all there is to trust.

use crate::accel::brute::{Ray64, has_area};
use crate::accel::judge::{ACROSS, Seen};
use crate::math::{DVec3, Vec3};
use crate::shape::Mesh;
use rayon::prelude::*;
use std::sync::Arc;

/// Triangles in a ball, and in a large one.
const GROUPS: [usize; 2] = [32, 32 * 64];

/// A triangle that a ray passes within rounding.
#[derive(Clone, Copy, Debug)]
pub(super) struct Near {
    pub seen: Seen,
    pub mesh: u32,
    pub triangle: u32,
}

struct Triangle {
    corners: [Vec3; 3],
    mesh: u32,
    triangle: u32,
}

impl Triangle {
    fn corners(&self) -> [DVec3; 3] {
        self.corners.map(|p| p.as_dvec3())
    }
}

struct Ball {
    center: DVec3,
    radius: f64,
}

/// All triangles with area.
pub(super) struct Scan {
    triangles: Vec<Triangle>,
    /// Of the groups of both sizes.
    balls: [Vec<Ball>; 2],
    largest: f64,
}

impl Scan {
    pub fn new(meshes: &[Arc<Mesh>]) -> Scan {
        let mut triangles = Vec::new();
        for (id, mesh) in meshes.iter().enumerate() {
            let all = (0..mesh.indices.len()).map(|t| (t, mesh.triangle(t)));
            let with_area = all.filter(|(_, corners)| has_area(*corners));
            triangles.extend(with_area.map(|(t, corners)| Triangle {
                corners,
                mesh: id as u32,
                triangle: t as u32,
            }));
        }
        let corners = || triangles.iter().flat_map(|t| t.corners);
        let low = corners().fold(Vec3::INFINITY, Vec3::min);
        let high = corners().fold(Vec3::NEG_INFINITY, Vec3::max);
        let largest = f64::from(low.abs().max(high.abs()).max_element());
        triangles.par_sort_unstable_by_key(|t| (morton(middle(t), low, high), t.mesh, t.triangle));
        let balls = GROUPS.map(|size| triangles.par_chunks(size).map(ball).collect());
        Scan { triangles, balls, largest }
    }

    /// The triangles that the ray's line does not pass outside of by more than the tolerance, by distance; those that
    /// it runs along only where f64 can tell where.
    pub fn near(&self, ray: &Ray64) -> Vec<Near> {
        let see = |t: &Triangle| {
            let seen = Seen::of(ray, t.corners())?;
            (!seen.outside()).then_some(Near { seen, mesh: t.mesh, triangle: t.triangle })
        };
        let mut near: Vec<Near> = self.around(ray).flatten().filter_map(see).collect();
        near.sort_by(|a, b| {
            a.seen
                .measure
                .t
                .total_cmp(&b.seen.measure.t)
                .then((a.mesh, a.triangle).cmp(&(b.mesh, b.triangle)))
        });
        near
    }

    /// True when a triangle is met on the interval.
    pub fn any(&self, ray: &Ray64) -> bool {
        let meets = |t: &Triangle| {
            let m = Seen::of(ray, t.corners()).map(|seen| seen.measure);
            m.is_some_and(|m| m.inset >= 0.0 && ray.tmin <= m.t && m.t <= ray.tmax)
        };
        self.around(ray).flatten().any(meets)
    }

    /// The groups that the line comes near.
    fn around(&self, ray: &Ray64) -> impl Iterator<Item = &[Triangle]> {
        let largest = self.largest.max(ray.o.abs().max_element());
        // Twice the tolerance: f64's own rounding is far below that.
        let slack = 2.0 * ACROSS * f64::from(f32::EPSILON) * largest;
        let (o, d, length) = (ray.o, ray.d, ray.d.length());
        let is_near =
            move |ball: &Ball| (ball.center - o).cross(d).length() <= (ball.radius + slack) * length;
        let [small, large] = &self.balls;
        let per_large = GROUPS[1] / GROUPS[0];
        let triangles = self.triangles.chunks(GROUPS[1]).zip(small.chunks(per_large)).zip(large);
        triangles.filter(move |(_, ball)| is_near(ball)).flat_map(move |((part, balls), _)| {
            let groups = part.chunks(GROUPS[0]).zip(balls);
            groups.filter(move |(_, ball)| is_near(ball)).map(|(group, _)| group)
        })
    }

    /// The `most` triangles (mesh, triangle) whose middles are nearest to `point`.
    pub fn nearest_to(&self, point: DVec3, most: usize) -> Vec<[u32; 2]> {
        let mut all: Vec<(f64, [u32; 2])> = self
            .triangles
            .par_iter()
            .map(|t| (middle(t).as_dvec3().distance_squared(point), [t.mesh, t.triangle]))
            .collect();
        all.par_sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        all.truncate(most);
        all.into_iter().map(|(_, ids)| ids).collect()
    }
}

fn middle(t: &Triangle) -> Vec3 {
    let [a, b, c] = t.corners;
    a / 3.0 + b / 3.0 + c / 3.0
}

fn ball(group: &[Triangle]) -> Ball {
    let corners = || group.iter().flat_map(|t| t.corners());
    let (low, high) =
        corners().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
    let center = (low + high) * 0.5;
    Ball { center, radius: corners().map(|p| p.distance(center)).fold(0.0, f64::max) }
}

/// 16 bits of each coordinate, interleaved.
fn morton(p: Vec3, low: Vec3, high: Vec3) -> u64 {
    let cell = ((p - low) / (high - low).max(Vec3::splat(f32::MIN_POSITIVE)) * 65535.0)
        .clamp(Vec3::ZERO, Vec3::splat(65535.0));
    let spread = |x: f32| {
        let x = x as u64;
        (0..16).fold(0, |code, bit| code | (x >> bit & 1) << (3 * bit))
    };
    spread(cell.x) | spread(cell.y) << 1 | spread(cell.z) << 2
}
