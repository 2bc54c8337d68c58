//! Groups of lights: their place, their directions and their strength (Conty Estévez and Kulla 2018, "Importance Sampling of
//! Many Lights with Adaptive Tree Splitting").

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
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// Directions all around; the same each time.
    pub fn axis(i: u32) -> Vec3 {
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
}
