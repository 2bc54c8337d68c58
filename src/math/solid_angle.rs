//! Directions uniform in the solid angle of a triangle or a rectangle: each shape's solid angle, whose inverse
//! is the density, and the sample stand side by side. A receiver sees such a light without the variation of
//! cos θ/d² that sampling by area leaves.

use super::Vec3;
use super::approx::{angle, asin, sin_cos_turn};
use std::f32::consts::{FRAC_1_PI, PI};

/// A triangle as the unit sphere around a point sees it.
#[derive(Clone, Copy, Debug)]
pub struct SphericalTriangle {
    /// Unit directions to the corners.
    corners: [Vec3; 3],
    /// |det(a, b, c)| of those directions.
    volume: f32,
    /// a·b, b·c, c·a.
    dots: [f32; 3],
    /// Solid angle, in [0, 2π].
    pub solid_angle: f32,
}

impl SphericalTriangle {
    /// The triangle whose corners lie at `corners` from the point. `None` when the point is a corner.
    ///
    /// tan(Ω/2) = |det(a, b, c)| / (1 + a·b + b·c + c·a) (Van Oosterom and Strackee 1983). The determinant comes from
    /// the edges, so that small triangles keep their digits.
    #[inline(always)]
    pub fn new(corners: [Vec3; 3]) -> Option<SphericalTriangle> {
        let [a, b, c] = corners;
        let inverse = corners.map(|v| 1.0 / v.length());
        if !inverse.iter().all(|i| i.is_finite()) {
            return None;
        }
        let volume = (a * inverse[0]).dot(((b - a) * inverse[1]).cross((c - a) * inverse[2])).abs();
        let [a, b, c] = [a * inverse[0], b * inverse[1], c * inverse[2]];
        let dots = [a.dot(b), b.dot(c), c.dot(a)];
        let solid_angle = 2.0 * angle(volume, 1.0 + dots[0] + dots[1] + dots[2]);
        Some(SphericalTriangle { corners: [a, b, c], volume, dots, solid_angle })
    }

    /// A direction of the triangle, uniform in solid angle: Arvo's (1995) two steps. The first number cuts off a
    /// triangle (a, b, c′) with its share of the solid angle, the second goes along the arc from b to c′.
    ///
    /// c′ is the reflection of a in a vector h = x·a + y·c of the plane of a and c. With h in the direction of a + c′ the
    /// formula above becomes y·det(a, b, c)·cos Ω′/2 = (x(1 + a·b) + y(a·c + b·c))·sin Ω′/2, linear in x : y; no inverse
    /// cosine loses digits, as in Arvo's own form.
    #[inline(always)]
    pub fn sample(&self, u: [f32; 2]) -> Vec3 {
        let [a, b, c] = self.corners;
        let [ab, bc, ca] = self.dots;
        let (s, co) = sin_cos_turn(u[0] * self.solid_angle * (0.25 * FRAC_1_PI));
        let h = a * (self.volume * co - (ca + bc) * s) + c * ((1.0 + ab) * s);
        let c = h * (2.0 * a.dot(h) / h.length_squared()) - a;
        let along = 1.0 - u[1] * (1.0 - b.dot(c));
        let across = (c - b * b.dot(c)).normalize_or_zero();
        b * along + across * (1.0 - along * along).max(0.0).sqrt()
    }
}

/// A rectangle with its own axes.
#[derive(Clone, Copy, Debug)]
pub struct Rectangle {
    /// A corner.
    pub corner: Vec3,
    /// The edges from there, perpendicular to each other.
    pub edges: [Vec3; 2],
    /// Unit edges and the unit normal, edge 0 × edge 1.
    pub axes: [Vec3; 3],
    /// The edges' lengths.
    pub lengths: [f32; 2],
}

impl Rectangle {
    /// A rectangle; `edges` must be perpendicular and not zero.
    pub fn new(corner: Vec3, edges: [Vec3; 2]) -> Rectangle {
        let [u, v] = edges;
        let axes = [u, v, u.cross(v)].map(|e| e.as_dvec3().normalize().as_vec3());
        Rectangle { corner, edges, axes, lengths: [u.length(), v.length()] }
    }

    /// The rectangle as the unit sphere around `p` sees it.
    #[inline(always)]
    pub fn seen_from(&self, p: Vec3) -> SphericalRectangle {
        SphericalRectangle::new(self, p)
    }
}

/// A rectangle as the unit sphere around a point sees it, after Ureña, Fajardo and King 2013, "An Area-Preserving
/// Parametrization for Spherical Rectangles".
#[derive(Clone, Copy, Debug)]
pub struct SphericalRectangle {
    /// Borders in the rectangle's axes, seen from the point.
    x: [f32; 2],
    y: [f32; 2],
    lengths: [f32; 2],
    /// Distance of the point from the plane.
    z: f32,
    /// The paper's b₀ and b₁: z components of the normals of the planes through the point and the two edges along x.
    b: [f32; 2],
    /// The paper's k less π.
    start: f32,
    /// Solid angle.
    pub solid_angle: f32,
}

impl SphericalRectangle {
    /// The paper's internal angles are γᵢ = arccos(−nᵢ·nᵢ₊₁) = π/2 + arcsin(nᵢ·nᵢ₊₁), so that S = Σγᵢ − 2π is the sum of
    /// the four arcsines: no 2π takes the digits of a small rectangle away. nᵢ·nᵢ₊₁ is the product of two z components.
    #[inline(always)]
    fn new(r: &Rectangle, p: Vec3) -> SphericalRectangle {
        let d = r.corner - p;
        let (x0, y0, z) = (d.dot(r.axes[0]), d.dot(r.axes[1]), d.dot(r.axes[2]).abs());
        let (x1, y1) = (x0 + r.lengths[0], y0 + r.lengths[1]);
        let z2 = z * z;
        let share = |t: f32| t / (t * t + z2).sqrt().max(f32::MIN_POSITIVE);
        let n = [-share(y0), share(x1), share(y1), -share(x0)];
        let arcs = [asin(n[0] * n[1]), asin(n[1] * n[2]), asin(n[2] * n[3]), asin(n[3] * n[0])];
        SphericalRectangle {
            x: [x0, x1],
            y: [y0, y1],
            lengths: r.lengths,
            z,
            b: [n[0], n[2]],
            start: -(arcs[2] + arcs[3]),
            solid_angle: (arcs[0] + arcs[1]) + (arcs[2] + arcs[3]),
        }
    }

    /// A point of the rectangle, uniform in solid angle, in shares of its edges.
    #[inline(always)]
    pub fn sample(&self, u: [f32; 2]) -> [f32; 2] {
        let [b0, b1] = self.b;
        // The paper's angle is π more: cosine and sine change their signs, and near π sine keeps its digits.
        let turn = u[0] * self.solid_angle + self.start;
        let (s, c) = sin_cos_turn(turn.abs() * (0.5 / PI));
        let s = s.copysign(turn);
        let f = if s == 0.0 { f32::INFINITY } else { (c * b0 + b1) / s };
        let cu = (1.0 / (f * f + b0 * b0).sqrt()).copysign(f).clamp(-1.0, 1.0);
        // Not `clamp`, which panics where the borders are none, so that no loop over it becomes vector instructions.
        let x = (cu * self.z / (1.0 - cu * cu).max(1e-12).sqrt()).max(self.x[0]).min(self.x[1]);
        let d = (x * x + self.z * self.z).sqrt();
        let height = |y: f32| y / (d * d + y * y).sqrt();
        let (h0, h1) = (height(self.y[0]), height(self.y[1]));
        let h = h0 + u[1] * (h1 - h0);
        let y = if h * h < 1.0 - 1e-6 { h * d / (1.0 - h * h).sqrt() } else { self.y[1] };
        let share = |t: f32, from: f32, length: f32| ((t - from) / length).clamp(0.0, 1.0);
        [share(x, self.x[0], self.lengths[0]), share(y, self.y[0], self.lengths[1])]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::DVec3;

    /// ∫cos/d² over the patch spanned by `e`, by midpoints in f64; half of it for a triangle.
    fn solid_angle(corner: Vec3, e: [Vec3; 2], triangle: bool) -> f64 {
        let n = 600;
        let normal = e[0].as_dvec3().cross(e[1].as_dvec3());
        let mut sum = 0.0;
        for i in 0..n {
            for j in 0..n {
                let (mut a, mut b) =
                    ((f64::from(i) + 0.5) / f64::from(n), (f64::from(j) + 0.5) / f64::from(n));
                if triangle && a + b > 1.0 {
                    (a, b) = (1.0 - a, 1.0 - b);
                }
                let p = corner.as_dvec3() + e[0].as_dvec3() * a + e[1].as_dvec3() * b;
                sum += normal.dot(p).abs() / p.length().powi(3);
            }
        }
        sum / f64::from(n * n) * if triangle { 0.5 } else { 1.0 }
    }

    /// Corners relative to the receiver and edges: above, beside, far, near and large.
    fn cases() -> Vec<(Vec3, [Vec3; 2])> {
        let v = Vec3::new;
        vec![
            (v(-0.5, -0.5, 1.0), [v(1.0, 0.0, 0.0), v(0.0, 1.0, 0.0)]),
            (v(2.0, 0.3, 1.0), [v(1.0, 0.0, 0.0), v(0.0, 1.5, 0.0)]),
            (v(-7.0, 3.0, 1.0), [v(0.0, 0.6, 0.8), v(0.5, 0.0, 0.0)]),
            (v(-3.0, -4.0, 0.3), [v(5.0, 0.0, 0.0), v(0.0, 7.0, 0.0)]),
            (v(0.0, 0.0, 1.0), [v(0.0, 2.0, 0.0), v(0.1, 0.0, 0.0)]),
        ]
    }

    #[test]
    fn solid_angles_are_their_integrals() {
        for (corner, e) in cases() {
            let rectangle = Rectangle::new(corner, e).seen_from(Vec3::ZERO).solid_angle;
            let exact = solid_angle(corner, e, false);
            assert!((f64::from(rectangle) / exact - 1.0).abs() < 2e-4, "{corner}: {rectangle} {exact}");
            let triangle =
                SphericalTriangle::new([corner, corner + e[0], corner + e[1]]).unwrap().solid_angle;
            let exact = solid_angle(corner, e, true);
            assert!((f64::from(triangle) / exact - 1.0).abs() < 2e-3, "{corner}: {triangle} {exact}");
        }
        // An eighth of the sphere, and a triangle around the point: half of it.
        let axes = [Vec3::X, Vec3::Y, Vec3::Z];
        let eighth = SphericalTriangle::new(axes).unwrap().solid_angle;
        assert!((eighth - 0.5 * PI).abs() < 1e-6, "{eighth}");
        assert!(SphericalTriangle::new([Vec3::ZERO, Vec3::X, Vec3::Y]).is_none());
    }

    /// The mean of a linear function of the direction over uniform directions is its integral over Ω; the cases'
    /// integrals come from midpoints over the area.
    #[test]
    fn samples_are_uniform_in_solid_angle() {
        for (corner, e) in cases() {
            for is_triangle in [false, true] {
                let (mut exact, mut weight) = (DVec3::ZERO, 0.0);
                let normal = e[0].as_dvec3().cross(e[1].as_dvec3());
                let n = 400;
                for i in 0..n * n {
                    let mut s = [(i % n) as f64 + 0.5, (i / n) as f64 + 0.5].map(|x| x / n as f64);
                    if is_triangle && s[0] + s[1] > 1.0 {
                        s = [1.0 - s[0], 1.0 - s[1]];
                    }
                    let p = corner.as_dvec3() + e[0].as_dvec3() * s[0] + e[1].as_dvec3() * s[1];
                    let w = normal.dot(p).abs() / p.length().powi(3);
                    exact += p.normalize() * w;
                    weight += w;
                }
                exact /= weight;
                let rectangle = Rectangle::new(corner, e).seen_from(Vec3::ZERO);
                let triangle = SphericalTriangle::new([corner, corner + e[0], corner + e[1]]).unwrap();
                let mut mean = DVec3::ZERO;
                for i in 0..128 * 128 {
                    let u = [((i % 128) as f32 + 0.5) / 128.0, ((i / 128) as f32 + 0.5) / 128.0];
                    let d = if is_triangle {
                        triangle.sample(u)
                    } else {
                        let [a, b] = rectangle.sample(u);
                        (corner + e[0] * a + e[1] * b).normalize()
                    };
                    assert!((d.length() - 1.0).abs() < 1e-5, "{d}");
                    mean += d.as_dvec3() / (128.0 * 128.0);
                }
                assert!((mean - exact).length() < 5e-4, "{corner} {is_triangle}: {mean} {exact}");
            }
        }
    }
}
