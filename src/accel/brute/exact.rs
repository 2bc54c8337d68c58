//! On which side of an edge a ray passes, beyond doubt.
//!
//! The side is the sign of d·((p−o)×(q−o)). In f64 that is right unless the volume is smaller than its own rounding
//! ([`volume`] says when), which f32 coordinates of very different magnitudes bring about: f64 loses what a
//! difference of 1e8 and 1e-9 leaves. Then it is computed without any rounding, as d·(p×q) − d·(p×o) − d·(o×q)
//! (o×o = 0): eighteen products of three f32 numbers, each the sum of two f64 numbers, summed up exactly as an
//! expansion (J. R. Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates", 1997,
//! sections 2.2–2.4). No such product leaves the range of f64. The crate `robust` has that paper's predicates, but they
//! want four points, and o + d is none that f64 can hold.

use crate::math::DVec3;

/// Shewchuk's bound for an orientation of four points, (7 + 56ε)ε with ε = 2⁻⁵³, times the sum of magnitudes: this
/// volume has the same operations, but for the direction's differences.
const BOUND: f64 = 7.0 * 1.110_223_024_625_157e-16 * (1.0 + 1e-14);

/// d·((p−o)×(q−o)), the sign of which is right, 0 included, where all numbers are f32's.
#[inline]
pub fn volume(d: DVec3, o: DVec3, p: DVec3, q: DVec3) -> f64 {
    let (a, b) = (p - o, q - o);
    let rough = d.dot(a.cross(b));
    let (x, y) = (a.abs(), b.abs());
    let magnitude =
        d.abs().dot(DVec3::new(x.y * y.z + x.z * y.y, x.z * y.x + x.x * y.z, x.x * y.y + x.y * y.x));
    // Where no product is left, none was lost: a difference of two f32 numbers is 0 where they are equal only.
    if rough.abs() > BOUND * magnitude || magnitude == 0.0 || ![d, o, p, q].into_iter().all(is_f32) {
        return rough;
    }
    exact(d, o, p, q)
}

fn is_f32(p: DVec3) -> bool {
    p.as_vec3().as_dvec3() == p
}

/// The volume to one rounding, from its exact value.
#[cold]
fn exact(d: DVec3, o: DVec3, p: DVec3, q: DVec3) -> f64 {
    let mut sum = Expansion::default();
    for (a, b, sign) in [(p, q, 1.0), (p, o, -1.0), (o, q, -1.0)] {
        for k in 0..3 {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            // Products of two f32 numbers are exact in f64.
            sum.add_product(sign * d[k], a[i] * b[j]);
            sum.add_product(-sign * d[k], a[j] * b[i]);
        }
    }
    sum.value()
}

/// A sum of numbers that do not overlap, by magnitude: their exact sum, and the last one has its sign.
struct Expansion {
    parts: [f64; 36],
    len: usize,
}

impl Default for Expansion {
    fn default() -> Self {
        Expansion { parts: [0.0; 36], len: 0 }
    }
}

impl Expansion {
    /// Adds a·b, of 24 and 48 bits: with b in two halves of 26 and 22 bits, both products are exact.
    fn add_product(&mut self, a: f64, b: f64) {
        let high = f64::from_bits(b.to_bits() & !((1 << 27) - 1));
        self.add(a * (b - high));
        self.add(a * high);
    }

    /// Shewchuk's Grow-Expansion without zeros. Thirty-six additions fill the array at most.
    fn add(&mut self, x: f64) {
        if x == 0.0 {
            return;
        }
        let (mut carry, mut kept) = (x, 0);
        for i in 0..self.len {
            let (sum, rest) = two_sum(carry, self.parts[i]);
            carry = sum;
            if rest != 0.0 {
                self.parts[kept] = rest;
                kept += 1;
            }
        }
        if carry != 0.0 {
            self.parts[kept] = carry;
            kept += 1;
        }
        self.len = kept;
    }

    fn value(&self) -> f64 {
        self.parts[..self.len].iter().sum()
    }
}

/// Knuth's sum: the rounded one, and what rounding left out.
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let b_seen = sum - a;
    (sum, (a - (sum - b_seen)) + (b - b_seen))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::brute::{Brute, Ray64};
    use crate::math::Vec3;
    use crate::shape::Mesh;
    use std::sync::Arc;

    fn rough(d: DVec3, o: DVec3, p: DVec3, q: DVec3) -> f64 {
        d.dot((p - o).cross(q - o))
    }

    /// The volume's sign from whole numbers: all coordinates are multiples of 2⁻²⁰, below 2²⁰.
    fn whole(d: DVec3, o: DVec3, p: DVec3, q: DVec3) -> i128 {
        let [d, o, p, q] = [d, o, p, q].map(|v| v.to_array().map(|x| (x * 1048576.0) as i128));
        let (a, b) = ([0, 1, 2].map(|k| p[k] - o[k]), [0, 1, 2].map(|k| q[k] - o[k]));
        let part = |k: usize| a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
        (0..3).map(|k| d[k] * part(k)).sum::<i128>().signum()
    }

    /// Coordinates of few, very different magnitudes: rays through edges, and past them by less than f64 can tell.
    #[test]
    fn sides_are_those_of_whole_numbers() {
        let mut random = crate::quadrature::numbers(5, 0);
        let mut coordinate = || {
            let k = (random() * 11.0) as i32 - 5;
            f64::from(k.signum())
                * [0.0, 1.0 / 1048576.0, 1.0 / 1024.0, 1.0, 1024.0, 524288.0][k.unsigned_abs() as usize]
        };
        let mut point = || DVec3::from_array([0; 3].map(|_| coordinate()));
        let sign = |x: f64| if x == 0.0 { 0 } else { x.signum() as i128 };
        let (mut wrong, mut zeros) = (0, 0);
        for _ in 0..200_000 {
            let (d, o, p, q) = (point(), point(), point(), point());
            let expected = whole(d, o, p, q);
            wrong += usize::from(sign(rough(d, o, p, q)) != expected);
            zeros += usize::from(expected == 0);
            assert_eq!(sign(volume(d, o, p, q)), expected, "{d} {o} {p} {q}");
            assert_eq!(volume(d, o, q, p), -volume(d, o, p, q));
        }
        // It is no test of f64's failures if f64 does not fail.
        assert!(wrong > 20 && zeros > 100, "{wrong} {zeros}");
    }

    /// Both triangles have the edge p q, which the ray passes by less than what differences of coordinates keep: f64
    /// takes it to go through the edge, and gives the first triangle where it meets the second.
    #[test]
    fn a_ray_past_an_edge_meets_the_triangle_on_its_side() {
        let (big, tiny) = (1e12f32, 1e-12f32);
        let d = DVec3::new(1.0, 1.0, 0.0);
        let [p, q] = [[big, big, -big], [big, big, big]];
        let corners = vec![p, q, [2.0 * big, 0.0, 0.0], [0.0, 2.0 * big, 0.0]];
        for (side, expected) in [(1.0, 0), (-1.0, 1)] {
            let o = DVec3::new(side * f64::from(tiny), 0.0, 0.0);
            let [p, q] = [p, q].map(|p| Vec3::from(p).as_dvec3());
            assert_eq!(rough(d, o, p, q), 0.0);
            assert_eq!(volume(d, o, p, q), side * 2.0 * f64::from(big) * f64::from(tiny));
            for (order, id) in [([[0, 1, 2], [0, 1, 3]], expected), ([[0, 1, 3], [0, 1, 2]], 1 - expected)] {
                let brute = Brute::new(&[Arc::new(Mesh::new(corners.clone(), order.to_vec()))]);
                let ray = Ray64 { o, d, tmin: 0.0, tmax: f64::INFINITY };
                let met: Vec<u32> = brute.all(&ray).map(|met| met.triangle).collect();
                assert_eq!(met, [id], "{side}");
            }
        }
    }

    /// Through the plane of a triangle: f64's normal and its product with the direction are not 0.
    #[test]
    fn rays_in_a_plane_meet_nothing() {
        let [a, b, c] =
            [[0.1f32, 0.7, 0.3], [1e6, 0.1, 0.9], [0.3, 1e-3, 7e3]].map(|p| Vec3::from(p).as_dvec3());
        let ray = Ray64 { o: a, d: b, tmin: 0.0, tmax: 1.0 };
        assert_eq!(volume(ray.d, DVec3::ZERO, a * 0.0, c), 0.0);
        assert_eq!(volume(b, DVec3::ZERO, b, c), 0.0);
        assert_eq!(volume(b, b, c, b), 0.0);
    }
}
