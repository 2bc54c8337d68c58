//! Coordinates far from the origin lose their last digits in f32; they are moved near it, in f64.
//!
//! A mesh is far when its centre is more than [`FAR`] times its extent away on some axis. That is early: f32 then
//! still has 23 of its 24 bits for the shape. But rays start and meet surfaces by roundings of the coordinates, and
//! between the fine triangles of a scan every one of them counts. The origin taken is the centre rounded to a multiple
//! of a power of two P ≥ (2·[`FAR`] + 1) times the extent. So what is moved is still no further than P/2
//! from the origin, about as far as what is never moved; and a mesh that is *not* far, shifted by a
//! multiple of its P, is moved back by just that shift: it comes out bit for bit as it was.

use super::block::exact;
use crate::math::DVec3;
use rayon::prelude::*;

/// See the module.
pub(super) const FAR: f64 = 0.5;

/// The smallest and largest coordinates; inverted when there are none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    pub low: DVec3,
    pub high: DVec3,
}

impl Bounds {
    pub const EMPTY: Bounds = Bounds { low: DVec3::INFINITY, high: DVec3::NEG_INFINITY };

    pub fn union(self, other: Bounds) -> Bounds {
        Bounds { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    fn grow(self, point: DVec3) -> Bounds {
        Bounds { low: self.low.min(point), high: self.high.max(point) }
    }

    fn center(self) -> DVec3 {
        self.low * 0.5 + self.high * 0.5
    }

    fn extent(self) -> f64 {
        (self.high - self.low).max_element()
    }

    fn is_empty(self) -> bool {
        self.low.x > self.high.x
    }
}

/// Where the mesh's own origin is to be; zero unless the mesh is far away. `rounded` are the bounds of the
/// positions as f32, which settle the question for nearly every mesh.
pub(super) fn choose_origin(
    rounded: Bounds,
    triangles: &[[u32; 3]],
    positions: &[[f32; 3]],
    residuals: &[[i32; 3]],
) -> DVec3 {
    // Half the limit leaves room for what f32 rounds away (2⁻²⁴ of the distance).
    if rounded.is_empty() || rounded.center().abs().max_element() <= 0.5 * FAR * rounded.extent() {
        return DVec3::ZERO;
    }
    let corner = |i: u32| {
        let position = positions.get(i as usize).copied().unwrap_or_default();
        DVec3::from_array(exact(position, residuals.get(i as usize).copied().unwrap_or_default()))
    };
    let bounds = triangles
        .par_iter()
        .fold(|| Bounds::EMPTY, |b, t| t.iter().fold(b, |b, &i| b.grow(corner(i))))
        .reduce(|| Bounds::EMPTY, Bounds::union);
    origin_of(bounds)
}

fn origin_of(bounds: Bounds) -> DVec3 {
    let (center, extent) = (bounds.center(), bounds.extent());
    if extent <= 0.0 || center.abs().max_element() <= FAR * extent {
        return DVec3::ZERO;
    }
    let step = power_of_two_above((2.0 * FAR + 1.0) * extent);
    (center / step).round() * step
}

/// The smallest power of two that is not below a positive normal number.
fn power_of_two_above(x: f64) -> f64 {
    let floor = f64::from_bits(x.to_bits() & !((1 << 52) - 1));
    if floor < x { 2.0 * floor } else { floor }
}

/// Replaces the positions by those relative to `origin`, rounded once.
pub(super) fn recenter(positions: &mut [[f32; 3]], residuals: &[[i32; 3]], origin: DVec3) {
    positions.par_iter_mut().zip(residuals).for_each(|(position, &residual)| {
        let moved = DVec3::from_array(exact(*position, residual)) - origin;
        *position = moved.as_vec3().to_array();
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    fn origin(low: f64, high: f64) -> f64 {
        origin_of(Bounds { low: DVec3::new(low, 0.0, 0.0), high: DVec3::new(high, 1.0, 1.0) }).x
    }

    #[test]
    fn only_far_meshes_are_moved() {
        assert_eq!(origin(-1.0, 0.0), 0.0);
        assert_eq!(origin(0.0, 1.0), 0.0);
        assert_eq!(origin(0.25, 1.25), 0.0, "nearer to 0 than to the first multiple of 2");
        assert_eq!(origin(16.5, 17.5), 18.0);
        assert_eq!(origin(1e6, 1e6 + 1.0), 1e6);
        assert_eq!(origin(1e6 + 0.25, 1e6 + 1.25), 1e6);
        assert_eq!(origin(1e6 + 1.0, 1e6 + 2.0), 1e6 + 2.0);
        assert_eq!(origin(0.5, 0.5), 0.0, "the other axes have extent 1");
    }

    #[test]
    fn powers_of_two() {
        assert_eq!(power_of_two_above(1.0), 1.0);
        assert_eq!(power_of_two_above(33.0), 64.0);
        assert_eq!(power_of_two_above(0.3), 0.5);
        assert_eq!(power_of_two_above(64.0f64.next_up()), 128.0);
    }
}
