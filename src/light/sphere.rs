//! The spherical lamp: an exact sphere, not a mesh of facets. It is seen, black and blocking.

use crate::accel::{Checked, Hits, LANES, Mask};
use crate::math::{DVec3, Frame, Rgb, Vec3, warp};
use std::f32::consts::TAU;

/// A sphere that sends the same radiance from every point of its outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Its centre, in scene coordinates.
    pub center: Vec3,
    /// Metres; > 0.
    pub radius: f32,
    /// Radiance.
    pub radiance: Rgb,
}

impl Sphere {
    /// Distance to the first crossing of the surface on `tmin ≤ t ≤ tmax`, in f64: a scene has few such
    /// lamps, and a tangent ray leaves no digits to waste (Haines et al. 2019, "Precision Improvements for
    /// Ray/Sphere Intersection").
    pub fn intersect(&self, o: Vec3, d: Vec3, tmin: f32, tmax: f32) -> Option<f32> {
        let (o, d, center) = (o.as_dvec3(), d.as_dvec3(), self.center.as_dvec3());
        let r2 = f64::from(self.radius).powi(2);
        let a = d.length_squared();
        if a <= 0.0 {
            return None;
        }
        let f: DVec3 = o - center;
        let b = -f.dot(d);
        let nearest = f + d * (b / a);
        let discriminant = r2 - nearest.length_squared();
        if discriminant < 0.0 {
            return None;
        }
        let q = b + b.signum() * (a * discriminant).sqrt();
        let (t0, t1) = ((f.length_squared() - r2) / q, q / a);
        let (near, far) = (t0.min(t1), t0.max(t1));
        let inside = |t: f64| t >= f64::from(tmin) && t <= f64::from(tmax);
        [near, far].into_iter().find(|t| inside(*t)).map(|t| t as f32)
    }

    /// The cosine of the half angle under which the sphere is seen from `p`; `None` from inside.
    #[inline]
    fn cos_max(&self, p: Vec3) -> Option<f32> {
        let distance2 = (self.center - p).length_squared();
        let r2 = self.radius * self.radius;
        (distance2 > r2).then(|| (1.0 - r2 / distance2).max(0.0).sqrt())
    }

    /// Density per solid angle with which [`Sphere::sample`] chooses a direction that meets the sphere.
    #[inline]
    pub fn pdf(&self, p: Vec3) -> f32 {
        self.cos_max(p).map_or(0.0, |cos| 1.0 / (TAU * self.height(p, cos)))
    }

    /// 1 − cos θ = sin²θ/(1 + cos θ), which keeps its digits for far and small spheres.
    #[inline]
    fn height(&self, p: Vec3, cos: f32) -> f32 {
        let sin2 = self.radius * self.radius / (self.center - p).length_squared();
        sin2 / (1.0 + cos)
    }

    /// A direction from `p` to the sphere, uniform in solid angle, with its density and the distance to the
    /// surface. `None` from inside.
    #[inline]
    pub fn sample(&self, p: Vec3, u: [f32; 2]) -> Option<(Vec3, f32, f32)> {
        let cos_max = self.cos_max(p)?;
        let (axis, height) = ((self.center - p).normalize(), self.height(p, cos_max));
        let wi = Frame::new(axis).to_world(warp::cap(u, height));
        // A direction at the rim can miss by rounding; the nearest point is the tangent's then.
        let tangent = (self.center - p).length() * cos_max;
        let t = self.intersect(p, wi, 0.0, f32::INFINITY).unwrap_or(tangent);
        Some((wi, 1.0 / (TAU * height), t))
    }
}

/// In [`Hits::mesh`]: this bit and the lamp's index, where a ray ends on a spherical lamp.
pub const SPHERE: u32 = 1 << 31;

/// Replaces hits by nearer ones on `spheres`.
pub fn closest(spheres: &[Sphere], rays: Checked<'_>, hits: &mut Hits) {
    let r = rays.rays();
    for lane in (0..LANES).filter(|lane| rays.active() >> lane & 1 == 1) {
        for (i, sphere) in spheres.iter().enumerate() {
            let tmax = hits.t[lane].min(r.tmax[lane]);
            if let Some(t) = sphere.intersect(r.o(lane), r.d(lane), r.tmin[lane], tmax) {
                (hits.t[lane], hits.mesh[lane]) = (t, SPHERE | i as u32);
            }
        }
    }
}

/// The active lanes that `spheres` block.
pub fn occluded(spheres: &[Sphere], rays: Checked<'_>) -> Mask {
    let r = rays.rays();
    let blocked = |lane: usize| {
        spheres.iter().any(|s| s.intersect(r.o(lane), r.d(lane), r.tmin[lane], r.tmax[lane]).is_some())
    };
    (0..LANES)
        .filter(|lane| rays.active() >> lane & 1 == 1 && blocked(*lane))
        .fold(0, |mask, lane| mask | 1 << lane)
}

#[cfg(test)]
mod tests {
    use super::*;

    const BALL: Sphere = Sphere { center: Vec3::new(1.0, 2.0, 3.0), radius: 0.5, radiance: Rgb::ONE };

    #[test]
    fn crossings_are_where_they_should_be() {
        let o = Vec3::new(1.0, 2.0, 0.0);
        assert_eq!(BALL.intersect(o, Vec3::Z, 0.0, 10.0), Some(2.5));
        assert_eq!(BALL.intersect(o, Vec3::Z * 2.0, 0.0, 10.0), Some(1.25));
        assert_eq!(BALL.intersect(o, Vec3::Z, 2.6, 10.0), Some(3.5));
        assert_eq!(BALL.intersect(o, Vec3::Z, 0.0, 2.4), None);
        assert_eq!(BALL.intersect(o, -Vec3::Z, 0.0, 10.0), None);
        assert_eq!(BALL.intersect(BALL.center, Vec3::X, 0.0, 10.0), Some(0.5));
    }

    /// Every sampled direction meets the sphere, and 1/pdf is its solid angle, near and far.
    #[test]
    fn samples_fill_the_solid_angle() {
        for distance in [0.51f32, 1.0, 100.0, 1e5] {
            let p = BALL.center - Vec3::X * distance;
            let sin = f64::from(BALL.radius) / f64::from(distance);
            let exact = std::f64::consts::TAU * sin * sin / (1.0 + (1.0 - sin * sin).sqrt());
            assert!((1.0 / f64::from(BALL.pdf(p)) / exact - 1.0).abs() < 1e-3, "{distance}");
            for i in 0..100 {
                let u = [(i as f32 + 0.5) / 100.0, (i as f32 * 0.618).fract()];
                let (wi, pdf, t) = BALL.sample(p, u).unwrap();
                assert_eq!(pdf, BALL.pdf(p));
                assert!(
                    (((p + wi * t) - BALL.center).length() - 0.5).abs() < 1e-3 * distance,
                    "{distance} {u:?}"
                );
            }
        }
        assert_eq!(BALL.sample(BALL.center, [0.5; 2]), None);
    }
}
