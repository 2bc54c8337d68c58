//! Emissive triangles, and the rectangles that two of them make: points on them by solid angle where they are near, by
//! area where they are far.

use super::bounds::{Cone, LightBounds};
use super::{LightSample, reach};
use crate::math::ray::{Ray, leave};
use crate::math::solid_angle::{Rectangle, SphericalRectangle, SphericalTriangle};
use crate::math::{Aabb, Rgb, Vec3, warp};
use crate::shape::surface::ROUNDING;
use crate::shape::{Mesh, Surface};

/// A light made of triangles.
#[derive(Clone, Copy, Debug)]
pub enum Patch {
    /// One triangle.
    Triangle {
        /// Its corners.
        corners: [Vec3; 3],
        /// Unit normal, on the side the winding says.
        ng: Vec3,
    },
    /// Two triangles of a mesh that share a diagonal.
    Rectangle(Rectangle),
}

/// A point on a patch.
#[derive(Clone, Copy, Debug)]
pub struct PatchPoint {
    /// The point.
    pub p: Vec3,
    /// Every component of `p` is within this of the true point.
    pub error: f32,
    /// Unit normal.
    pub ng: Vec3,
    /// Density per solid angle, where the point was chosen by it.
    pub by_solid_angle: Option<f32>,
}

/// By solid angle up to this distance, squared, in squares of the patch's longest extent. Farther away cos θ/d² varies
/// little over the patch, and the density by area costs next to nothing: in the Cornell box 4 takes 6 % of the error away
/// and costs 8 % more time, 2 takes 1 % away at no cost.
const NEAR: f32 = 2.0;
/// Smaller solid angles are left to sampling by area: they come from grazing views, where their digits are few.
const SMALLEST: [f32; 2] = [1e-4, 5e-3];

impl Patch {
    /// Triangle `t` of a mesh, or the rectangle that it makes with its successor.
    pub fn new(mesh: &Mesh, t: usize, with_next: bool) -> Option<Patch> {
        if with_next {
            return rectangle(mesh, t).map(Patch::Rectangle);
        }
        let corners = mesh.triangle(t);
        let [a, b, c] = corners.map(|p| p.as_dvec3());
        let ng = (b - a).cross(c - a).try_normalize()?.as_vec3();
        Some(Patch::Triangle { corners, ng })
    }

    /// Area in m².
    pub fn area(&self) -> f64 {
        match self {
            Patch::Triangle { corners, .. } => {
                let [a, b, c] = corners.map(|p| p.as_dvec3());
                0.5 * (b - a).cross(c - a).length()
            }
            Patch::Rectangle(r) => f64::from(r.lengths[0]) * f64::from(r.lengths[1]),
        }
    }

    /// Where it is and where it shines; `radiance`: its luminance.
    pub fn bounds(&self, radiance: f32, two_sided: bool) -> LightBounds {
        let (bounds, axis) = match self {
            Patch::Triangle { corners, ng } => (corners.iter().fold(Aabb::EMPTY, |b, p| b.grow(*p)), *ng),
            Patch::Rectangle(Rectangle { corner, edges: [u, v], axes, .. }) => {
                let corners = [*corner, *corner + *u, *corner + *v, *corner + *u + *v];
                (corners.iter().fold(Aabb::EMPTY, |b, p| b.grow(*p)), axes[2])
            }
        };
        let cone = Cone { axis, cos_normals: 1.0, cos_light: 0.0 };
        LightBounds { bounds, cone, two_sided, strength: (f64::from(radiance) * self.area()) as f32 }
    }

    /// A point of it for a receiver at `from`.
    #[inline(always)]
    pub fn sample(&self, from: Vec3, u: [f32; 2]) -> PatchPoint {
        match self {
            Patch::Triangle { corners, ng } => sample_triangle(corners, *ng, from, u),
            Patch::Rectangle(r) => sample_rectangle::<false>(r, from, u),
        }
    }

    /// The density with which [`Patch::sample`] would have chosen a point at `distance_squared` from `from`, whose normal
    /// is seen there under the cosine `cos`.
    #[inline(always)]
    pub fn pdf(&self, from: Vec3, distance_squared: f32, cos: f32) -> f32 {
        let solid_angle = match self {
            Patch::Triangle { corners, .. } => near_triangle(corners, from).map(|seen| seen.solid_angle),
            Patch::Rectangle(r) => near_rectangle(r, from).map(|seen| seen.solid_angle),
        };
        solid_angle.map_or_else(|| self.pdf_by_area(distance_squared, cos), |s| 1.0 / s)
    }

    /// d²/(A·cos θ).
    #[inline(always)]
    pub fn pdf_by_area(&self, distance_squared: f32, cos: f32) -> f32 {
        distance_squared / (self.sampled_area() * cos)
    }

    /// The area as densities see it.
    #[inline(always)]
    pub(super) fn sampled_area(&self) -> f32 {
        match self {
            Patch::Triangle { corners, .. } => area(corners),
            Patch::Rectangle(r) => r.lengths[0] * r.lengths[1],
        }
    }
}

/// The area of a triangle as densities see it.
#[inline(always)]
pub(super) fn area([a, b, c]: &[Vec3; 3]) -> f32 {
    0.5 * (*b - *a).cross(*c - *a).length()
}

/// The sample that `point` of a patch with that area is for a receiver at `from`; `radiance`, and whether both sides
/// send it. `chance`: of this patch among the lights.
#[inline(always)]
pub(super) fn light_sample(
    from: &Surface,
    point: &PatchPoint,
    radiance: (Rgb, bool),
    area: f32,
    chance: f32,
) -> Option<LightSample> {
    let (sample, arrives) = light_sample_if(from, point, radiance, area, chance);
    arrives.then_some(sample)
}

/// [`light_sample`] without a branch: the sample, of use if the second is true.
#[inline(always)]
pub(super) fn light_sample_if(
    from: &Surface,
    point: &PatchPoint,
    (radiance, two_sided): (Rgb, bool),
    area: f32,
    chance: f32,
) -> (LightSample, bool) {
    let to = point.p - from.p;
    let distance_squared = to.length_squared();
    let wi = to * (1.0 / distance_squared.sqrt());
    let cos = point.ng.dot(wi);
    let pdf = chance * point.by_solid_angle.unwrap_or_else(|| distance_squared / (area * cos.abs()));
    let arrives = (distance_squared > 0.0)
        & (radiance != Rgb::ZERO)
        & (two_sided | (cos < 0.0))
        & (pdf > 0.0)
        & pdf.is_finite();
    let start = leave(from.p, from.error, from.ng, wi);
    let end = leave(point.p, point.error, point.ng, -wi);
    let shadow = Ray { o: start, d: end - start, tmax: reach::ALMOST };
    (LightSample { wi, radiance_over_pdf: radiance / pdf, pdf, shadow }, arrives)
}

/// A point of a triangle for a receiver at `from`.
#[inline(always)]
fn sample_triangle(corners: &[Vec3; 3], ng: Vec3, from: Vec3, u: [f32; 2]) -> PatchPoint {
    let (b, by_solid_angle) = choose(corners, from, u);
    let w = 1.0 - b[0] - b[1];
    let p = corners[0] * w + corners[1] * b[0] + corners[2] * b[1];
    let size = corners[0].abs().max(corners[1].abs()).max(corners[2].abs());
    PatchPoint { p, error: ROUNDING * size.max_element(), ng, by_solid_angle }
}

/// The weights of the second and third corner at such a point, and its density per solid angle where it was chosen by it.
#[inline(always)]
pub(super) fn choose(corners: &[Vec3; 3], from: Vec3, u: [f32; 2]) -> ([f32; 2], Option<f32>) {
    match near_triangle(corners, from) {
        Some(seen) => (weights(corners, from, seen.sample(u)), Some(1.0 / seen.solid_angle)),
        None => (warp::triangle(u), None),
    }
}

/// The same of a rectangle. `EAGER`: without a branch.
#[inline(always)]
pub(super) fn sample_rectangle<const EAGER: bool>(r: &Rectangle, from: Vec3, u: [f32; 2]) -> PatchPoint {
    let close = is_close(r, from);
    let (mut at, mut by_solid_angle) = (u, None);
    if EAGER || close {
        let seen = r.seen_from(from);
        let near = close & (seen.solid_angle > SMALLEST[1]);
        let [a, b] = seen.sample(u);
        at = if near { [a, b] } else { u };
        by_solid_angle = near.then_some(1.0 / seen.solid_angle);
    }
    let (along, across) = (r.edges[0] * at[0], r.edges[1] * at[1]);
    let size = r.corner.abs() + along.abs() + across.abs();
    let error = ROUNDING * size.max_element();
    PatchPoint { p: r.corner + along + across, error, ng: r.axes[2], by_solid_angle }
}

/// The triangle as `from` sees it, where it is sampled by solid angle.
#[inline(always)]
fn near_triangle(corners: &[Vec3; 3], from: Vec3) -> Option<SphericalTriangle> {
    let [a, b, c] = *corners;
    let middle = (a + b + c) * (1.0 / 3.0);
    let longest = (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
    if (middle - from).length_squared() > NEAR * longest {
        return None;
    }
    SphericalTriangle::new([a - from, b - from, c - from]).filter(|seen| seen.solid_angle > SMALLEST[0])
}

/// The rectangle as `from` sees it, where it is sampled by solid angle.
#[inline(always)]
fn near_rectangle(r: &Rectangle, from: Vec3) -> Option<SphericalRectangle> {
    is_close(r, from).then(|| r.seen_from(from)).filter(|seen| seen.solid_angle > SMALLEST[1])
}

/// Whether the rectangle may be sampled by solid angle.
#[inline(always)]
fn is_close(r: &Rectangle, from: Vec3) -> bool {
    let middle = r.corner + (r.edges[0] + r.edges[1]) * 0.5;
    let diagonal = r.lengths[0] * r.lengths[0] + r.lengths[1] * r.lengths[1];
    (middle - from).length_squared() <= NEAR * diagonal
}

/// Barycentric weights of the second and third corner where a ray from `o` along `d` meets the triangle (Möller and
/// Trumbore 1997), within it whatever rounding does.
#[inline(always)]
fn weights([a, b, c]: &[Vec3; 3], o: Vec3, d: Vec3) -> [f32; 2] {
    let (e1, e2) = (*b - *a, *c - *a);
    let s1 = d.cross(e2);
    let divisor = s1.dot(e1);
    if divisor == 0.0 {
        return [1.0 / 3.0; 2];
    }
    let s = o - *a;
    let (u, v) = (s.dot(s1) / divisor, d.dot(s.cross(e1)) / divisor);
    let (u, v) = (u.clamp(0.0, 1.0), v.clamp(0.0, 1.0));
    let scale = 1.0 / (u + v).max(1.0);
    [u * scale, v * scale]
}

/// Sides and angles of a rectangle may be off by this share, what rounding leaves of a turned one.
const SQUARE: f32 = 1e-5;

/// The rectangle that triangle `t` and the next one make: they share two corners, wind alike, and the other two corners
/// make right angles.
fn rectangle(mesh: &Mesh, t: usize) -> Option<Rectangle> {
    let (first, second) = (mesh.triangle(t), mesh.triangle(t + 1));
    let alone = |own: &[Vec3; 3], other: &[Vec3; 3]| {
        let mut lonely = (0..3).filter(|i| !other.contains(&own[*i]));
        let i = lonely.next()?;
        lonely.next().is_none().then_some(i)
    };
    let (i, j) = (alone(&first, &second)?, alone(&second, &first)?);
    let corner = first[i];
    let edges = [first[(i + 1) % 3] - corner, first[(i + 2) % 3] - corner];
    let opposite = second[j];
    // Wound alike, the shared edge runs the other way.
    if second[(j + 1) % 3] != first[(i + 2) % 3] {
        return None;
    }
    let size = edges[0].length().max(edges[1].length());
    let is_parallelogram = (corner + edges[0] + edges[1] - opposite).length() <= SQUARE * size;
    let is_square = edges[0].dot(edges[1]).abs() <= SQUARE * edges[0].length() * edges[1].length();
    let has_area = edges[0].cross(edges[1]).length_squared() > 0.0;
    (is_parallelogram && is_square && has_area).then(|| Rectangle::new(corner, edges))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quad(points: [[f32; 3]; 4], indices: [[u32; 3]; 2]) -> Mesh {
        Mesh::new(points.to_vec(), indices.to_vec())
    }

    const SQUARE_POINTS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0], [0.0, 1.0, 0.0]];

    #[test]
    fn two_triangles_make_a_rectangle_when_they_do() {
        for indices in
            [[[0, 1, 2], [0, 2, 3]], [[1, 2, 0], [3, 0, 2]], [[0, 1, 3], [1, 2, 3]], [[2, 0, 1], [2, 3, 0]]]
        {
            let r = rectangle(&quad(SQUARE_POINTS, indices), 0).unwrap();
            assert!((r.axes[2] - Vec3::Z).length() < 1e-6, "{indices:?}");
            assert_eq!(r.lengths[0] * r.lengths[1], 2.0);
        }
        let not = |points, indices| assert!(rectangle(&quad(points, indices), 0).is_none(), "{indices:?}");
        not(SQUARE_POINTS, [[0, 1, 2], [0, 3, 2]]); // wound against each other
        not(SQUARE_POINTS, [[0, 1, 2], [0, 1, 2]]);
        let mut points = SQUARE_POINTS;
        points[3] = [0.0, 1.01, 0.0];
        not(points, [[0, 1, 2], [0, 2, 3]]);
        points[3] = [0.0, 1.0, 0.01];
        not(points, [[0, 1, 2], [0, 2, 3]]);
        let sheared = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.5, 1.0, 0.0], [0.5, 1.0, 0.0]];
        not(sheared, [[0, 1, 2], [0, 2, 3]]);
    }
}
