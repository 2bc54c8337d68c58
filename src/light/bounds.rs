//! What a group of lights can send to a point at most, roughly: their place, their directions and their strength.
//!
//! Conty Estévez and Kulla 2018, "Importance Sampling of Many Lights with Adaptive Tree Splitting"; the cosines of
//! differences of angles as in pbrt (4th ed., 12.6.3).

use super::Receiver;
use crate::math::{Aabb, Vec3};

/// The directions of a group of lights: normals within a cone around `axis`, and light up to an angle from those.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// Unit axis.
    pub axis: Vec3,
    /// Cosine of the angle within which the normals lie.
    pub cos_normals: f32,
    /// Cosine of the angle from its normal up to which a light shines, at most π/2.
    pub cos_light: f32,
}

impl Cone {
    /// Every direction.
    pub const ALL: Cone = Cone { axis: Vec3::Z, cos_normals: -1.0, cos_light: 0.0 };

    /// A cone that holds both.
    pub fn union(&self, other: &Cone) -> Cone {
        let cos_light = self.cos_light.min(other.cos_light);
        let angle = |c: &Cone| libm::acosf(c.cos_normals.clamp(-1.0, 1.0));
        let (a, b) = (angle(self), angle(other));
        let between = libm::acosf(self.axis.dot(other.axis).clamp(-1.0, 1.0));
        let pi = std::f32::consts::PI;
        if (between + b).min(pi) <= a {
            return Cone { cos_light, ..*self };
        }
        if (between + a).min(pi) <= b {
            return Cone { cos_light, ..*other };
        }
        // A little wider than it must be, so that rounding leaves no normal out.
        let half = 0.5 * (a + between + b) + 1e-4;
        let across = (other.axis - self.axis * self.axis.dot(other.axis)).try_normalize();
        let Some(across) = across.filter(|_| half < pi) else { return Cone { cos_light, ..Cone::ALL } };
        let turn = half - a;
        let axis = (self.axis * libm::cosf(turn) + across * libm::sinf(turn)).normalize();
        Cone { axis, cos_normals: libm::cosf(half), cos_light }
    }
}

/// A group of lights.
#[derive(Clone, Copy, Debug)]
pub struct LightBounds {
    /// The smallest box around them.
    pub bounds: Aabb,
    /// Their directions.
    pub cone: Cone,
    /// True when one of them shines to both sides of its normal.
    pub two_sided: bool,
    /// W/sr that they send along their normals, in luminance.
    pub strength: f32,
}

impl LightBounds {
    /// Both groups together.
    pub fn union(&self, other: &LightBounds) -> LightBounds {
        LightBounds {
            bounds: self.bounds.union(other.bounds),
            cone: self.cone.union(&other.cone),
            two_sided: self.two_sided | other.two_sided,
            strength: self.strength + other.strength,
        }
    }

    /// What [`Importance`] needs of it.
    pub fn importance(&self) -> Importance {
        let center = self.bounds.center();
        let radius = 0.5 * self.bounds.extent().length();
        Importance {
            center,
            radius_squared: radius * radius,
            axis: self.cone.axis,
            strength: self.strength,
            cos_normals: self.cone.cos_normals,
            sin_normals: (1.0 - self.cone.cos_normals * self.cone.cos_normals).max(0.0).sqrt(),
            cos_light: self.cone.cos_light,
            two_sided: self.two_sided,
        }
    }
}

/// A group of lights, ready to be weighed.
#[derive(Clone, Copy, Debug, Default)]
pub struct Importance {
    center: Vec3,
    radius_squared: f32,
    axis: Vec3,
    strength: f32,
    cos_normals: f32,
    sin_normals: f32,
    cos_light: f32,
    two_sided: bool,
}

impl Importance {
    /// About the irradiance at `to`: strength·cos θ′·cos θi′/d² with the smallest angles that the group's extent allows.
    /// Zero only where none of it can arrive.
    #[inline(always)]
    pub fn at(&self, to: &Receiver) -> f32 {
        let away = to.p - self.center;
        let distance_squared = away.length_squared();
        // Within the group every angle is possible, and no distance is known but that it is smaller than the radius.
        let inside = distance_squared <= self.radius_squared;
        let clamped = distance_squared.max(self.radius_squared).max(f32::MIN_POSITIVE);
        let w = away * (1.0 / distance_squared.max(f32::MIN_POSITIVE).sqrt());
        let sin2_b = if inside { 1.0 } else { self.radius_squared / clamped };
        let (sin_b, cos_b) = (sin2_b.sqrt(), if inside { -1.0 } else { (1.0 - sin2_b).sqrt() });

        let cos_w = self.axis.dot(w);
        let cos_w = if self.two_sided { cos_w.abs() } else { cos_w }.clamp(-1.0, 1.0);
        let sin_w = (1.0 - cos_w * cos_w).sqrt();
        // θ′ = θw − θnormals − θb, not below 0; beyond π it stands for "any".
        let cos_x = cos_minus(cos_w, sin_w, self.cos_normals, self.sin_normals);
        let sin_x = sin_minus(cos_w, sin_w, self.cos_normals, self.sin_normals);
        let cos = if inside { 1.0 } else { cos_minus(cos_x, sin_x, cos_b, sin_b) };
        if cos <= self.cos_light {
            return 0.0;
        }
        let mut importance = self.strength * cos / clamped;
        if let Some(n) = to.normal
            && !inside
        {
            let cos_i = (-w.dot(n)).clamp(-1.0, 1.0);
            let sin_i = (1.0 - cos_i * cos_i).sqrt();
            importance *= cos_minus(cos_i, sin_i, cos_b, sin_b).max(0.0);
        }
        importance
    }
}

/// cos(max(0, a − b)) of two angles in [0, π].
#[inline(always)]
fn cos_minus(cos_a: f32, sin_a: f32, cos_b: f32, sin_b: f32) -> f32 {
    if cos_a > cos_b { 1.0 } else { cos_a * cos_b + sin_a * sin_b }
}

/// sin(max(0, a − b)) of two angles in [0, π].
#[inline(always)]
fn sin_minus(cos_a: f32, sin_a: f32, cos_b: f32, sin_b: f32) -> f32 {
    if cos_a > cos_b { 0.0 } else { sin_a * cos_b - cos_a * sin_b }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(i: u32) -> Vec3 {
        let f = |k: u32| {
            ((i.wrapping_mul(0x9e37_79b9).wrapping_add(k.wrapping_mul(0x85eb_ca6b)) >> 8) % 2001) as f32
        };
        Vec3::new(f(1) - 1000.0, f(2) - 1000.0, f(3) - 1000.5).normalize()
    }

    #[test]
    fn unions_of_cones_hold_both() {
        for i in 0..3000u32 {
            let cone = |k: u32| Cone {
                axis: axis(i * 2 + k),
                cos_normals: 1.0 - ((i * 7 + k * 13) % 40) as f32 / 20.0,
                cos_light: 0.0,
            };
            let (a, b) = (cone(0), cone(1));
            let u = a.union(&b);
            for part in [a, b] {
                // The part's direction that is farthest from the union's axis.
                let far = libm::acosf(u.axis.dot(part.axis).clamp(-1.0, 1.0)) + libm::acosf(part.cos_normals);
                assert!(
                    far.min(std::f32::consts::PI) <= libm::acosf(u.cos_normals) + 1e-3,
                    "{a:?} {b:?} {u:?}"
                );
            }
        }
    }

    /// A group is never weighed 0 where one of its members would not be.
    #[test]
    fn groups_matter_where_their_members_do() {
        for i in 0..20_000u32 {
            let member = |k: u32| LightBounds {
                bounds: Aabb::EMPTY.grow(axis(5 * i + k)).grow(axis(5 * i + k) + 0.3 * axis(i + 77)),
                cone: Cone { axis: axis(3 * i + k + 9), cos_normals: 1.0, cos_light: 0.0 },
                two_sided: (i + k).is_multiple_of(3),
                strength: 1.0,
            };
            let (a, b) = (member(0), member(1));
            let group = a.union(&b).importance();
            let normal = if i % 2 == 0 { Receiver::pack(axis(i + 500)) } else { Receiver::ALL_AROUND };
            let to = Receiver::new(1.5 * axis(i + 123), normal);
            if a.importance().at(&to) > 1e-4 || b.importance().at(&to) > 1e-4 {
                assert!(group.at(&to) > 0.0, "{i}");
            }
        }
    }
}
