//! Orthonormal frames around a normal.

use super::Vec3;

/// A right-handed orthonormal frame; local directions have z along the normal.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// Local x.
    pub s: Vec3,
    /// Local y.
    pub t: Vec3,
    /// Local z, the normal.
    pub n: Vec3,
}

impl Frame {
    /// The branchless frame of Duff et al. 2017, "Building an Orthonormal Basis, Revisited"; `n` is unit.
    #[inline(always)]
    pub fn new(n: Vec3) -> Frame {
        let sign = 1.0f32.copysign(n.z);
        let a = -1.0 / (sign + n.z);
        let b = n.x * n.y * a;
        Frame {
            s: Vec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x),
            t: Vec3::new(b, sign + n.y * n.y * a, -n.y),
            n,
        }
    }

    /// The frame with local x along `s`, which is unit and at right angles to the unit normal `n`.
    #[inline(always)]
    pub fn with_x(s: Vec3, n: Vec3) -> Frame {
        Frame { s, t: n.cross(s), n }
    }

    /// World to local.
    #[inline(always)]
    pub fn to_local(&self, v: Vec3) -> Vec3 {
        Vec3::new(v.dot(self.s), v.dot(self.t), v.dot(self.n))
    }

    /// Local to world.
    #[inline(always)]
    pub fn to_world(&self, v: Vec3) -> Vec3 {
        self.s * v.x + self.t * v.y + self.n * v.z
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_orthonormal_right_handed_and_invert() {
        for i in 0..2000 {
            let z = 1.0 - 2.0 * (i as f32 + 0.5) / 2000.0;
            let (s, c) = super::super::approx::sin_cos_turn((i as f32 * 0.618_034).fract());
            let r = (1.0 - z * z).max(0.0).sqrt();
            for n in [Vec3::new(r * c, r * s, z), Vec3::new(0.0, 0.0, z.signum())] {
                let f = Frame::new(n);
                assert!((f.s.cross(f.t) - n).length() < 1e-6, "{n}");
                assert!(f.s.dot(n).abs() < 1e-6 && (f.s.length() - 1.0).abs() < 1e-6);
                let v = Vec3::new(0.3, -0.5, 0.7);
                assert!((f.to_local(f.to_world(v)) - v).length() < 1e-6);
            }
        }
    }
}
