//! What a group of lights can send to a point at most, roughly (Conty Estévez and Kulla 2018); the cosines of differences of
//! angles as in pbrt (4th ed., 12.6.3).

use super::Receiver;
use super::bounds::LightBounds;
use crate::math::Vec3;

/// A group of lights, ready to be weighed.
#[derive(Clone, Copy, Debug, Default)]
pub struct Importance {
    center: Vec3,
    radius_squared: f32,
    axis: Vec3,
    strength: f32,
    cos_normals: f32,
    cos_light: f32,
    two_sided: bool,
}

impl LightBounds {
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
            cos_light: self.cone.cos_light,
            two_sided: self.two_sided,
        }
    }
}

/// `N` groups of lights, lane beside lane.
#[derive(Clone, Debug)]
#[repr(C, align(32))]
pub struct Importances<const N: usize> {
    center: [[f32; N]; 3],
    radius_squared: [f32; N],
    axis: [[f32; N]; 3],
    /// Negative: two-sided.
    strength: [f32; N],
    cos_normals: [f32; N],
    cos_light: [f32; N],
}

impl<const N: usize> Importances<N> {
    /// Groups without strength.
    pub const NONE: Importances<N> = Importances {
        center: [[0.0; N]; 3],
        radius_squared: [0.0; N],
        axis: [[0.0; N]; 3],
        strength: [0.0; N],
        cos_normals: [0.0; N],
        cos_light: [0.0; N],
    };

    /// Sets one of them.
    pub fn set(&mut self, lane: usize, of: &Importance) {
        for k in 0..3 {
            (self.center[k][lane], self.axis[k][lane]) = (of.center[k], of.axis[k]);
        }
        self.radius_squared[lane] = of.radius_squared;
        self.strength[lane] = if of.two_sided { -of.strength } else { of.strength };
        (self.cos_normals[lane], self.cos_light[lane]) = (of.cos_normals, of.cos_light);
    }

    #[inline(always)]
    fn get(&self, lane: usize) -> Importance {
        let vector = |of: &[[f32; N]; 3]| Vec3::new(of[0][lane], of[1][lane], of[2][lane]);
        Importance {
            center: vector(&self.center),
            radius_squared: self.radius_squared[lane],
            axis: vector(&self.axis),
            strength: self.strength[lane].abs(),
            cos_normals: self.cos_normals[lane],
            cos_light: self.cos_light[lane],
            two_sided: self.strength[lane] < 0.0,
        }
    }

    /// [`Importance::at`] of each.
    #[inline(always)]
    pub fn at(&self, to: &Receiver) -> [f32; N] {
        let mut all = [0.0; N];
        // Two loops without a choice in them, which become vector instructions.
        match to.normal {
            Some(n) => {
                for (lane, importance) in all.iter_mut().enumerate() {
                    let (sent, sight) = self.get(lane).sent(to.p);
                    *importance = sent * sight.received(n);
                }
            }
            None => {
                for (lane, importance) in all.iter_mut().enumerate() {
                    *importance = self.get(lane).sent(to.p).0;
                }
            }
        }
        all
    }
}

/// How a group looks from a point.
#[derive(Clone, Copy)]
struct Sight {
    /// From its middle to the point, unit.
    w: Vec3,
    /// Of half the angle that it takes, where the point is not inside.
    sin_b: f32,
    cos_b: f32,
    inside: bool,
}

impl Sight {
    /// The cosine at a receiver with normal `n` of the smallest angle that the group's extent allows.
    #[inline(always)]
    fn received(&self, n: Vec3) -> f32 {
        let cos_i = (-self.w.dot(n)).clamp(-1.0, 1.0);
        let sin_i = (1.0 - cos_i * cos_i).sqrt();
        let cos = cos_minus(cos_i, sin_i, self.cos_b, self.sin_b).max(0.0);
        if self.inside { 1.0 } else { cos }
    }
}

impl Importance {
    /// About the irradiance at `to`: strength·cos θ′·cos θi′/d² with the smallest angles that the group's extent allows.
    /// Zero only where none of it can arrive.
    #[inline(always)]
    pub fn at(&self, to: &Receiver) -> f32 {
        let (sent, sight) = self.sent(to.p);
        sent * to.normal.map_or(1.0, |n| sight.received(n))
    }

    /// strength·cos θ′/d², and how the group looks from `p`.
    #[inline(always)]
    fn sent(&self, p: Vec3) -> (f32, Sight) {
        let away = p - self.center;
        let distance_squared = away.length_squared();
        // Within the group every angle is possible, and no distance is known but that it is smaller than the radius.
        let inside = distance_squared <= self.radius_squared;
        let clamped = distance_squared.max(self.radius_squared).max(f32::MIN_POSITIVE);
        let w = away * (1.0 / distance_squared.max(f32::MIN_POSITIVE).sqrt());
        let sin2_b = self.radius_squared / clamped;
        let (sin_b, cos_b) = (sin2_b.sqrt(), (1.0 - sin2_b).max(0.0).sqrt());

        let cos_w = self.axis.dot(w);
        let cos_w = if self.two_sided { cos_w.abs() } else { cos_w }.clamp(-1.0, 1.0);
        let sin_w = (1.0 - cos_w * cos_w).sqrt();
        let sin_normals = (1.0 - self.cos_normals * self.cos_normals).max(0.0).sqrt();
        // θ′ = θw − θnormals − θb, not below 0; beyond π it stands for "any".
        let cos_x = cos_minus(cos_w, sin_w, self.cos_normals, sin_normals);
        let sin_x = sin_minus(cos_w, sin_w, self.cos_normals, sin_normals);
        let cos = cos_minus(cos_x, sin_x, cos_b, sin_b);
        let cos = if inside { 1.0 } else { cos };
        let sent = self.strength * cos / clamped;
        (if cos > self.cos_light { sent } else { 0.0 }, Sight { w, sin_b, cos_b, inside })
    }
}

/// cos(max(0, a − b)) of two angles in [0, π].
#[inline(always)]
fn cos_minus(cos_a: f32, sin_a: f32, cos_b: f32, sin_b: f32) -> f32 {
    let cos = cos_a * cos_b + sin_a * sin_b;
    if cos_a > cos_b { 1.0 } else { cos }
}

/// sin(max(0, a − b)) of two angles in [0, π].
#[inline(always)]
fn sin_minus(cos_a: f32, sin_a: f32, cos_b: f32, sin_b: f32) -> f32 {
    let sin = sin_a * cos_b - cos_a * sin_b;
    if cos_a > cos_b { 0.0 } else { sin }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::bounds::Cone;
    use crate::light::bounds::tests::axis;
    use crate::math::Aabb;

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
