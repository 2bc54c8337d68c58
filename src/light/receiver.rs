//! Where light arrives: what the choice among lights may depend on.

use crate::math::Vec3;

/// A point that light samples start from.
#[derive(Clone, Copy, Debug)]
pub struct Receiver {
    /// The point, in scene coordinates.
    pub p: Vec3,
    /// The unit normal of the side that light can come from; `None`: from all around.
    pub normal: Option<Vec3>,
}

impl Receiver {
    /// In place of a packed normal: light can come from all around.
    pub const ALL_AROUND: u32 = u32::MAX;

    /// The receiver at `p` with a normal that [`Receiver::pack`] packed. A ray carries those 32 bits, so that the
    /// density at its end is asked of the same receiver, bit for bit, as the light sample at its start was.
    #[inline(always)]
    pub fn new(p: Vec3, packed: u32) -> Receiver {
        Receiver { p, normal: (packed != Receiver::ALL_AROUND).then(|| unpack(packed)) }
    }

    /// A unit normal on an octahedron unfolded to a square (Meyer et al. 2010), 16 bits a side, off by at most 1e-4.
    #[inline(always)]
    pub fn pack(n: Vec3) -> u32 {
        let (mut x, mut y) = (n.x, n.y);
        let scale = 1.0 / (n.x.abs() + n.y.abs() + n.z.abs());
        (x, y) = (x * scale, y * scale);
        if n.z < 0.0 {
            (x, y) = ((1.0 - y.abs()).copysign(x), (1.0 - x.abs()).copysign(y));
        }
        let code = |t: f32| ((t.clamp(-1.0, 1.0) + 1.0) * HALF + 0.5) as u32;
        code(x) << 16 | code(y)
    }
}

/// Steps from the middle of the square to its border.
const HALF: f32 = 32_767.0;

#[inline(always)]
fn unpack(packed: u32) -> Vec3 {
    let number = |code: u32| (code as f32 - HALF) / HALF;
    let (x, y) = (number(packed >> 16), number(packed & 0xffff));
    let z = 1.0 - x.abs() - y.abs();
    let fold = (-z).max(0.0);
    Vec3::new(x - fold.copysign(x), y - fold.copysign(y), z).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::warp;

    #[test]
    fn packed_normals_stay_what_they_were() {
        for i in 0..10_000 {
            let n = warp::sphere([(i as f32 + 0.5) / 10_000.0, (i as f32 * 0.618_034).fract()]);
            let back = Receiver::new(Vec3::ZERO, Receiver::pack(n)).normal.unwrap();
            assert!((back - n).length() < 1e-4, "{n} {back}");
        }
        for n in [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z] {
            assert_eq!(Receiver::new(Vec3::ZERO, Receiver::pack(n)).normal, Some(n));
        }
        assert_eq!(Receiver::new(Vec3::ZERO, Receiver::ALL_AROUND).normal, None);
    }
}
