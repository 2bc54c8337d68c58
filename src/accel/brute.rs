//! The f64 judge: every triangle tested, no tree, no shared code with any backend.
//!
//! A triangle is met by signed volumes relative to the ray's origin: U = d·(C×B), V = d·(A×C), W = d·(B×A) have
//! one sign when the line passes inside. Their signs are exact (`exact.rs`), so neighbours never disagree about a shared
//! edge, and with f64's 2⁻⁵³ the rest of the judge is some 10⁸ times sharper than what it judges.

mod edge_on;
mod exact;

pub use edge_on::Outline;
use exact::volume;

use super::{Checked, Coherence, Geometry, Hits, Intersector, LANES, MISS, Mask, Rays};
use crate::math::{DVec3, Vec3};
use crate::shape::Mesh;
use std::sync::Arc;

/// A ray in f64.
#[derive(Clone, Copy, Debug)]
pub struct Ray64 {
    /// Origin.
    pub o: DVec3,
    /// Direction, not necessarily unit.
    pub d: DVec3,
    /// Start of the interval, in multiples of `d`.
    pub tmin: f64,
    /// End of the interval.
    pub tmax: f64,
}

impl Ray64 {
    /// One lane of a chunk.
    pub fn of(rays: &Rays, lane: usize) -> Ray64 {
        Ray64 {
            o: rays.o(lane).as_dvec3(),
            d: rays.d(lane).as_dvec3(),
            tmin: rays.tmin[lane] as f64,
            tmax: rays.tmax[lane] as f64,
        }
    }
}

/// Where a ray's line meets a triangle's plane, seen from the triangle.
#[derive(Clone, Copy, Debug)]
pub struct Measure {
    /// Distance in multiples of the direction.
    pub t: f64,
    /// Barycentric weight of the second corner; outside 0 … 1 where the triangle is missed.
    pub u: f64,
    /// Barycentric weight of the third corner.
    pub v: f64,
    /// Least distance between the ray's line and the lines through the edges, in units of length, measured
    /// across the ray; negative outside the triangle, by as much as the worst edge is missed. What moving
    /// a vertex by δ can change it by, whatever the triangle's shape and the angle.
    pub inset: f64,
    /// |cosine| of the angle between the ray and the plane's normal.
    pub cos: f64,
}

impl Measure {
    /// Measures a triangle in f64; `None` when the line runs within the plane, or the triangle has no area.
    pub fn of(ray: &Ray64, corners: [DVec3; 3]) -> Option<Measure> {
        let [a, b, c] = corners.map(|p| p - ray.o);
        let volumes = [ray.d.dot(c.cross(b)), ray.d.dot(a.cross(c)), ray.d.dot(b.cross(a))];
        let n = (b - a).cross(c - a);
        Measure::with(ray, [a, b, c], volumes, ray.d.dot(n))
    }

    /// As [`Measure::of`], with the sides on which the edges are passed, and whether the line runs within the plane, beyond
    /// doubt; slower where they are in doubt.
    pub fn exactly(ray: &Ray64, corners: [DVec3; 3]) -> Option<Measure> {
        let [a, b, c] = corners;
        let facing = volume(ray.d, a, b, c);
        Measure::with(ray, corners.map(|p| p - ray.o), volumes(ray, corners), facing)
    }

    /// `corners`: from the ray's origin; `facing`: d·n.
    #[inline(always)]
    fn with(ray: &Ray64, corners: [DVec3; 3], volumes: [f64; 3], facing: f64) -> Option<Measure> {
        let [a, b, c] = corners;
        let n = (b - a).cross(c - a);
        let det: f64 = volumes.iter().sum();
        if det == 0.0 || facing == 0.0 {
            return None;
        }
        // Two lines with directions d and e, one through p: distance = |d·(p × e)| / |d × e|.
        let edges = [c - b, a - c, b - a];
        let mut inset = f64::INFINITY;
        for (volume, edge) in volumes.iter().zip(edges) {
            let across = ray.d.cross(edge).length();
            if across > 0.0 {
                inset = inset.min(volume * det.signum() / across);
            }
        }
        Some(Measure {
            t: a.dot(n) / facing,
            u: volumes[1] / det,
            v: volumes[2] / det,
            inset,
            cos: (facing / (n.length() * ray.d.length())).abs(),
        })
    }
}

/// U, V and W: of which edge the ray passes on which side.
#[inline]
fn volumes(ray: &Ray64, [a, b, c]: [DVec3; 3]) -> [f64; 3] {
    [volume(ray.d, ray.o, c, b), volume(ray.d, ray.o, a, c), volume(ray.d, ray.o, b, a)]
}

/// True when the triangle has area: f64 differences and products of f32 numbers, so that exactly collinear
/// or repeated corners give exactly 0 (as long as the coordinates' exponents are within 29 of each other). A corner that
/// is no number, or infinite, makes none.
pub fn has_area(corners: [Vec3; 3]) -> bool {
    let [a, b, c] = corners.map(|p| p.as_dvec3());
    let n = (b - a).cross(c - a);
    n != DVec3::ZERO && n.is_finite()
}

/// A triangle that was met.
#[derive(Clone, Copy, Debug)]
pub struct Met {
    /// Distance.
    pub t: f64,
    /// Barycentric weight of the second corner.
    pub u: f64,
    /// Barycentric weight of the third corner.
    pub v: f64,
    /// Mesh.
    pub mesh: u32,
    /// Triangle.
    pub triangle: u32,
}

/// All triangles with area, one after the other.
pub struct Brute {
    triangles: Vec<([DVec3; 3], u32, u32)>,
}

impl Brute {
    /// Collects the triangles.
    pub fn new(meshes: &[Arc<Mesh>]) -> Brute {
        let mut triangles = Vec::new();
        for (id, mesh) in meshes.iter().enumerate() {
            for triangle in 0..mesh.indices.len() {
                let corners = mesh.triangle(triangle);
                if has_area(corners) {
                    triangles.push((corners.map(|p| p.as_dvec3()), id as u32, triangle as u32));
                }
            }
        }
        Brute { triangles }
    }

    /// Collects those of instances as well, where they stand at a time of the shutter (0 to 1), to f64's rounding.
    pub fn of(geometry: &Geometry<'_>, time: f32) -> Brute {
        let mut brute = Brute::new(geometry.meshes);
        let [open, close] = geometry.shutter;
        let seconds = open + (close - open) * f64::from(time);
        for (i, place) in geometry.instances.places.iter().enumerate() {
            let there = place.transform(seconds);
            let mesh = &geometry.instances.meshes[place.mesh as usize];
            let id = (geometry.meshes.len() + i) as u32;
            for triangle in (0..mesh.indices.len()).filter(|t| has_area(mesh.triangle(*t))) {
                let corners = mesh.triangle(triangle).map(|p| there.transform_point3(p.as_dvec3()));
                brute.triangles.push((corners, id, triangle as u32));
            }
        }
        brute
    }

    /// Every triangle met on the ray's interval, in the order of ids.
    pub fn all<'a>(&'a self, ray: &'a Ray64) -> impl Iterator<Item = Met> + 'a {
        self.triangles.iter().filter_map(|(corners, mesh, triangle)| {
            let (t, u, v) = meet(ray, *corners)?;
            (ray.tmin <= t && t <= ray.tmax).then_some(Met { t, u, v, mesh: *mesh, triangle: *triangle })
        })
    }

    /// The closest; of equally close ones the one with the lowest ids.
    pub fn nearest(&self, ray: &Ray64) -> Option<Met> {
        self.all(ray).reduce(|best, met| if met.t < best.t { met } else { best })
    }

    /// True when anything is met.
    pub fn any(&self, ray: &Ray64) -> bool {
        self.all(ray).next().is_some()
    }

    /// The triangles that come within `slack` (length) of the ray with `lo ≤ t ≤ hi`: near-ties and near-misses.
    pub fn hits_within(&self, ray: &Ray64, lo: f64, hi: f64, slack: f64) -> Vec<(Measure, u32, u32)> {
        let near = |(corners, mesh, triangle): &([DVec3; 3], u32, u32)| {
            let m = Measure::exactly(ray, *corners)?;
            (m.inset >= -slack && lo <= m.t && m.t <= hi).then_some((m, *mesh, *triangle))
        };
        self.triangles.iter().filter_map(near).collect()
    }
}

/// t, u and v where the ray's line meets the triangle, edges included.
#[inline]
fn meet(ray: &Ray64, corners: [DVec3; 3]) -> Option<(f64, f64, f64)> {
    let [u, v, w] = volumes(ray, corners);
    if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
        return None;
    }
    let [a, b, c] = corners;
    let det = u + v + w;
    let n = (b - a).cross(c - a);
    let facing = volume(ray.d, a, b, c);
    (det != 0.0 && facing != 0.0).then(|| ((a - ray.o).dot(n) / facing, v / det, w / det))
}

impl Intersector for Brute {
    fn closest(&self, rays: Checked<'_>, _: Coherence, hits: &mut Hits) {
        for lane in (0..LANES).filter(|&lane| rays.active() >> lane & 1 == 1) {
            let (t, u, v, mesh, triangle) = match self.nearest(&Ray64::of(rays.rays(), lane)) {
                Some(met) => (met.t as f32, met.u as f32, met.v as f32, met.mesh, met.triangle),
                None => (f32::INFINITY, 0.0, 0.0, MISS, MISS),
            };
            (hits.t[lane], hits.u[lane], hits.v[lane]) = (t, u, v);
            (hits.mesh[lane], hits.triangle[lane]) = (mesh, triangle);
        }
    }

    fn occluded(&self, rays: Checked<'_>, _: Coherence) -> Mask {
        let blocked =
            |lane: &usize| rays.active() >> lane & 1 == 1 && self.any(&Ray64::of(rays.rays(), *lane));
        (0..LANES).filter(blocked).fold(0, |mask, lane| mask | 1 << lane)
    }

    fn bytes(&self) -> usize {
        size_of_val(&self.triangles[..])
    }

    fn isa(&self) -> &str {
        "f64"
    }
}
