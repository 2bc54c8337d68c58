//! Warps from the unit square to the shapes that are sampled: for each the sample, its density and the
//! inverse stand side by side. `u` is in [0, 1)².

use super::approx::sin_cos_turn;
use super::{Vec2, Vec3};
use std::f32::consts::{FRAC_1_PI, PI};

/// A point of the unit disk, area-preserving and of low distortion (Shirley and Chiu 1997).
#[inline(always)]
pub fn disk(u: [f32; 2]) -> Vec2 {
    let (a, b) = (2.0 * u[0] - 1.0, 2.0 * u[1] - 1.0);
    let wide = a.abs() > b.abs();
    let (r, other) = if wide { (a, b) } else { (b, a) };
    // An eighth of a turn over the square's half side; at the centre any angle will do.
    let eighth = if r == 0.0 { 0.0 } else { 0.125 * (other / r) };
    let (s, c) = sin_cos_turn(eighth + 0.25);
    // With the angle shifted by a quarter turn: cos(x) = sin(x+¼), sin(x) = −cos(x+¼).
    let (cos, sin) = (s, -c);
    if wide { Vec2::new(r * cos, r * sin) } else { Vec2::new(r * sin, r * cos) }
}

/// Density of [`disk`] per area.
pub const DISK_PDF: f32 = FRAC_1_PI;

/// The `u` that [`disk`] maps to `p`.
pub fn disk_inverse(p: Vec2) -> [f32; 2] {
    let wide = p.x.abs() > p.y.abs();
    let (main, other) = if wide { (p.x, p.y) } else { (p.y, p.x) };
    let r = p.length().copysign(main);
    let across = r * libm::atanf(if main == 0.0 { 0.0 } else { other / main }) * (4.0 / PI);
    let (a, b) = if wide { (r, across) } else { (across, r) };
    [0.5 * (a + 1.0), 0.5 * (b + 1.0)]
}

/// A direction of the hemisphere around z with density cos θ/π (Malley's method).
#[inline(always)]
pub fn cosine_hemisphere(u: [f32; 2]) -> Vec3 {
    let p = disk(u);
    // On the disk's rim 1 − r² rounds to 0 as often as to what it is, half a rounding of 1 at the least. A direction
    // in the surface itself would end a path that loses no light.
    Vec3::new(p.x, p.y, (1.0 - p.length_squared()).max(0.25 * f32::EPSILON).sqrt())
}

/// Density of [`cosine_hemisphere`] per solid angle.
#[inline(always)]
pub fn cosine_hemisphere_pdf(cos_theta: f32) -> f32 {
    cos_theta.max(0.0) * FRAC_1_PI
}

/// The `u` that [`cosine_hemisphere`] maps to `w`.
pub fn cosine_hemisphere_inverse(w: Vec3) -> [f32; 2] {
    disk_inverse(Vec2::new(w.x, w.y))
}

/// A direction of the sphere, uniform.
#[inline(always)]
pub fn sphere(u: [f32; 2]) -> Vec3 {
    let z = 1.0 - 2.0 * u[0];
    let r = (1.0 - z * z).max(0.0).sqrt();
    let (s, c) = sin_cos_turn(u[1]);
    Vec3::new(r * c, r * s, z)
}

/// Density of [`sphere`] per solid angle.
pub const SPHERE_PDF: f32 = 0.25 * FRAC_1_PI;

/// The `u` that [`sphere`] maps to `w`.
pub fn sphere_inverse(w: Vec3) -> [f32; 2] {
    let turn = libm::atan2f(w.y, w.x) / (2.0 * PI);
    [0.5 * (1.0 - w.z), if turn < 0.0 { turn + 1.0 } else { turn }]
}

/// Barycentric weights of a triangle's second and third corner, uniform by area (Heitz 2019, "A
/// Low-Distortion Map Between Triangle and Square").
#[inline(always)]
pub fn triangle(u: [f32; 2]) -> [f32; 2] {
    if u[1] > u[0] {
        let b = 0.5 * u[0];
        [b, u[1] - b]
    } else {
        let b = 0.5 * u[1];
        [u[0] - b, b]
    }
}

/// The `u` that [`triangle`] maps to the weights `b`.
pub fn triangle_inverse(b: [f32; 2]) -> [f32; 2] {
    if b[1] > b[0] { [2.0 * b[0], b[1] + b[0]] } else { [b[0] + b[1], 2.0 * b[1]] }
}

/// A direction within a cap of the unit sphere around z, `height` = 1 − cos of its half angle, uniform; the density is
/// 1/(2π·`height`). The height, and not the cosine, keeps the digits of narrow ones.
#[inline(always)]
pub fn cap(u: [f32; 2], height: f32) -> Vec3 {
    let h = u[0] * height;
    let r = (h * (2.0 - h)).sqrt();
    let (s, c) = sin_cos_turn(u[1]);
    Vec3::new(r * c, r * s, 1.0 - h)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid() -> impl Iterator<Item = [f32; 2]> {
        (0..64).flat_map(|i| (0..64).map(move |j| [(i as f32 + 0.5) / 64.0, (j as f32 + 0.31) / 64.0]))
    }

    fn close(a: [f32; 2], b: [f32; 2]) -> bool {
        (a[0] - b[0]).abs() < 2e-4 && (a[1] - b[1]).abs() < 2e-4
    }

    #[test]
    fn inverses_undo_the_warps() {
        for u in grid() {
            assert!(close(disk_inverse(disk(u)), u), "disk {u:?}");
            assert!(close(cosine_hemisphere_inverse(cosine_hemisphere(u)), u), "hemisphere {u:?}");
            assert!(close(sphere_inverse(sphere(u)), u), "sphere {u:?}");
            assert!(close(triangle_inverse(triangle(u)), u), "triangle {u:?}");
        }
    }

    /// Equal areas of the square must carry the probability that the density says: the moments of the
    /// warped grid against closed forms.
    #[test]
    fn moments_match_the_densities() {
        let mean = |f: &dyn Fn([f32; 2]) -> f32| grid().map(|u| f64::from(f(u))).sum::<f64>() / 4096.0;
        // ∫cos²/π over the hemisphere = 2/3; E[x²] there = 1/4.
        assert!((mean(&|u| cosine_hemisphere(u).z) - 2.0 / 3.0).abs() < 2e-3);
        assert!((mean(&|u| cosine_hemisphere(u).x.powi(2)) - 0.25).abs() < 2e-3);
        assert!((mean(&|u| disk(u).y.powi(2)) - 0.25).abs() < 2e-3);
        assert!((mean(&|u| sphere(u).x.powi(2)) - 1.0 / 3.0).abs() < 2e-3);
        assert!((mean(&|u| triangle(u)[0]) - 1.0 / 3.0).abs() < 2e-3);
        assert!((mean(&|u| triangle(u)[0] * triangle(u)[1]) - 1.0 / 12.0).abs() < 2e-3);
        assert!((mean(&|u| cap(u, 0.5).z) - 0.75).abs() < 2e-3);
    }
}
