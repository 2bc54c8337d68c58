//! A hit becomes a point on a surface, in one place for integrators and lights.

use super::Mesh;
use crate::math::{Frame, Vec2, Vec3};

/// A point on a triangle, seen from a direction.
#[derive(Clone, Copy, Debug)]
pub struct Surface {
    /// The point, in scene coordinates (metres).
    pub p: Vec3,
    /// Every component of `p` is within this of the true point.
    pub error: f32,
    /// Unit geometric normal on the side the winding says (counter-clockwise).
    pub ng: Vec3,
    /// Unit shading normal, in the hemisphere of `ng`.
    pub ns: Vec3,
    /// Texture coordinates; the barycentrics where the mesh has none.
    pub uv: Vec2,
}

/// The error of a point relative to the coordinates it is made of. Three products and two sums on rounded
/// weights would need 14 units of roundoff (Higham 2002, 3.1). But a ray that leaves the point must also be
/// farther from the neighbouring triangles of a crease than a backend's own rounding of a distance, measured
/// up to 5.8·ε·W with Embree (ε = 2⁻²³, W the largest coordinate); nearer ones it can take for behind it,
/// and then the ray leaks into the body. Sixteen ε hold both with a margin.
pub(crate) const ROUNDING: f32 = 16.0 * f32::EPSILON;

impl Surface {
    /// The point with barycentric weights `u` (second corner) and `v` (third corner) on a triangle, faceted and
    /// without texture coordinates: all that emission and visibility need.
    #[inline(always)]
    pub fn faceted(mesh: &Mesh, triangle: u32, u: f32, v: f32) -> Surface {
        let corners = mesh.triangle(triangle as usize);
        let (p, error, uv) = place(corners, u, v);
        let [a, b, c] = corners;
        let ng = geometric_normal(a, b, c);
        Surface { p, error, ng, ns: ng, uv }
    }

    /// The same with the mesh's shading normal and texture coordinates, where it has some.
    #[inline(always)]
    pub fn new(mesh: &Mesh, triangle: u32, u: f32, v: f32) -> Surface {
        let mut surface = Surface::faceted(mesh, triangle, u, v);
        let corners = mesh.indices[triangle as usize];
        let w = 1.0 - u - v;
        if let Some(n) = mesh.normals.as_ref().and_then(|n| n.corners(triangle as usize, corners)) {
            surface.ns = shading_normal(n.map(Vec3::from), w, u, v, surface.ng);
        }
        if let Some([a, b, c]) = mesh.uvs.as_ref().and_then(|t| t.corners(triangle as usize, corners)) {
            surface.uv = Vec2::from(a) * w + Vec2::from(b) * u + Vec2::from(c) * v;
        }
        surface
    }

    /// The frame that BSDFs work in: around the shading normal, on the side that `wo` is on.
    ///
    /// Near silhouettes an interpolated normal can point away from the viewer although the triangle faces
    /// it, which would shade black; it is then bent just far enough to see `wo` at grazing angle.
    #[inline(always)]
    pub fn frame_towards(&self, wo: Vec3) -> Frame {
        let side = 1.0f32.copysign(self.ng.dot(wo));
        let ns = self.ns * side;
        let cos = ns.dot(wo);
        const GRAZING: f32 = 1e-3;
        let bent = (ns + wo * (GRAZING - cos)).normalize_or(self.ng * side);
        Frame::new(if cos >= GRAZING { ns } else { bent })
    }
}

/// The unit normal of a triangle. Edges of tiny triangles are scaled up first where their product would
/// leave the range of f32.
#[inline(always)]
pub fn geometric_normal(a: Vec3, b: Vec3, c: Vec3) -> Vec3 {
    match plain_normal(a, b, c) {
        (n, true) => n,
        _ => geometric_normal_f64(a, b, c),
    }
}

/// The normal without regard to the range of f32, and whether it kept to it.
#[inline(always)]
pub(super) fn plain_normal(a: Vec3, b: Vec3, c: Vec3) -> (Vec3, bool) {
    let n = (b - a).cross(c - a);
    let length_squared = n.length_squared();
    (n * (1.0 / length_squared.sqrt()), (length_squared > 1e-30) & (length_squared < 1e30))
}

/// The point with weights `u` and `v`, its error and the weights, all within the triangle.
#[inline(always)]
pub(super) fn place([a, b, c]: [Vec3; 3], u: f32, v: f32) -> (Vec3, f32, Vec2) {
    // A backend's rounding can put the weights a little outside of a small triangle; beyond a concave edge
    // that point would lie below the neighbour's surface.
    let (u, v) = (u.max(0.0), v.max(0.0));
    let scale = 1.0 / (u + v).max(1.0);
    let (u, v) = (u * scale, v * scale);
    let w = (1.0 - u - v).max(0.0);
    let p = a * w + b * u + c * v;
    let size = (a * w).abs() + (b * u).abs() + (c * v).abs();
    (p, ROUNDING * size.max_element(), Vec2::new(u, v))
}

#[cold]
pub(super) fn geometric_normal_f64(a: Vec3, b: Vec3, c: Vec3) -> Vec3 {
    let n = (b.as_dvec3() - a.as_dvec3()).cross(c.as_dvec3() - a.as_dvec3());
    let scale = n.abs().max_element();
    if scale > 0.0 && scale.is_finite() { (n / scale).normalize().as_vec3() } else { Vec3::Z }
}

/// The interpolated normal, turned to the side of `ng`: files with flipped normals shade like the others.
#[inline(always)]
pub(super) fn shading_normal(n: [Vec3; 3], w: f32, u: f32, v: f32, ng: Vec3) -> Vec3 {
    let n = n[0] * w + n[1] * u + n[2] * v;
    let length_squared = n.length_squared();
    if length_squared > 1e-20 && length_squared < 1e20 {
        let n = n * (1.0 / length_squared.sqrt());
        if n.dot(ng) < 0.0 { -n } else { n }
    } else {
        ng
    }
}
