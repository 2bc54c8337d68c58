//! One ray, prepared once: for the slab test and for the sheared frame of the triangle test.

use super::node::margin;

/// The part of a ray that [`super::node::Node::enter`] reads.
#[derive(Clone, Copy, Debug)]
pub struct SlabRay {
    /// Per axis, which side of a box is met first: 0 the lower plane, 1 the upper.
    pub near_side: [usize; 3],
    /// Origins against which near planes are measured: moved so that every box is enlarged, see [`margin`].
    pub near_origin: [f32; 3],
    /// Origins against which far planes are measured.
    pub far_origin: [f32; 3],
    /// 1/d, finite: a component too small to be inverted counts as ±1e-37. Such a ray stays within its slab's
    /// margin (≥ 2⁻²⁰·W) over every distance t ≤ 2·W that matters, and 2⁻²⁰·W·1e37 is far beyond that t.
    pub inverse: [f32; 3],
}

/// A ray whose direction is scaled by a power of two so that its largest component lies in [1, 2). The
/// scaling is exact, keeps every later quantity in range whatever the direction's length, and is undone on
/// the way out ([`Ray::unscale`]); inside, every t is scaled.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// For boxes.
    pub slab: SlabRay,
    /// The axes that become x, y and z of the sheared frame; z is where the direction is largest.
    pub axes: [usize; 3],
    /// Origin in the order of `axes`.
    pub origin: [f32; 3],
    /// d_x/d_z and d_y/d_z: the shear that turns the direction into the z axis.
    pub shear: [f32; 2],
    /// Turns a sheared z into a distance: 1/d_z, of the scaled direction.
    pub inverse_z: f64,
    /// Start of the interval, scaled.
    pub tmin: f32,
    /// End of the interval, scaled; finite.
    pub tmax: f32,
    scale: f64,
}

/// Below this magnitude a direction's component is not inverted.
const SMALLEST_INVERTED: f32 = 1e-37;

impl Ray {
    /// Prepares a ray of finite numbers. `None` when it can hit nothing: no direction, or an empty interval.
    #[inline(always)]
    pub fn new(o: [f32; 3], d: [f32; 3], tmin: f32, tmax: f32) -> Option<Ray> {
        let [ax, ay, az] = d.map(f32::abs);
        let kz = if az >= ax && az >= ay {
            2
        } else if ay >= ax {
            1
        } else {
            0
        };
        let largest = d[kz].abs();
        // Written so that an interval with a NaN would be refused as well.
        if !(largest > 0.0 && tmin <= tmax) {
            return None;
        }
        // 2^-exponent(largest); f64 because 2^149, for denormal directions, exceeds f32.
        let exponent = (largest as f64).to_bits() >> 52 & 0x7ff;
        let up = f64::from_bits((2046 - exponent) << 52);
        let scale = f64::from_bits(exponent << 52);
        let d = d.map(|x| (x as f64 * up) as f32);

        let (kx, ky) = ((kz + 1) % 3, (kz + 2) % 3);
        let e = margin(o[0].abs().max(o[1].abs()).max(o[2].abs()));
        let mut slab = SlabRay { near_side: [0; 3], near_origin: o, far_origin: o, inverse: [0.0; 3] };
        for k in 0..3 {
            let backwards = d[k].is_sign_negative();
            let outwards = if backwards { -e } else { e };
            slab.near_side[k] = backwards as usize;
            slab.near_origin[k] = o[k] + outwards;
            slab.far_origin[k] = o[k] - outwards;
            slab.inverse[k] = 1.0 / d[k].abs().max(SMALLEST_INVERTED).copysign(d[k]);
        }
        Some(Ray {
            slab,
            axes: [kx, ky, kz],
            origin: [o[kx], o[ky], o[kz]],
            shear: [d[kx] / d[kz], d[ky] / d[kz]],
            inverse_z: 1.0 / d[kz] as f64,
            tmin: (tmin as f64 * scale) as f32,
            // An unrepresentable distance would come out as infinity, so it counts as out of reach.
            tmax: (tmax.min(f32::MAX) as f64 * scale).min(f32::MAX as f64) as f32,
            scale: up,
        })
    }

    /// A scaled distance in multiples of the caller's direction.
    #[inline(always)]
    pub fn unscale(&self, t: f32) -> f32 {
        (t as f64 * self.scale) as f32
    }
}
