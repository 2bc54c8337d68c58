//! A chunk of rays, prepared once: for the slab test and for the sheared frame of the triangle test.

use super::node::{margin, max, min};
use crate::accel::{LANES, Mask, Rays};

/// Below this magnitude a direction's component is not inverted.
const SMALLEST_INVERTED: f32 = 1e-20;

/// Prepared rays, structure of arrays. A direction is scaled by a power of two so that its largest component lies in
/// [1, 2): exact, keeps every later quantity in range whatever the direction's length, and undone on the way out
/// ([`Prepared::up`]); inside, every t is scaled.
#[derive(Clone)]
#[repr(C, align(64))]
pub struct Prepared {
    /// (o + e)/d, e the [`margin`] with the direction's sign: near planes are met at plane/d less this. Moved so, every
    /// box is enlarged.
    pub near_start: [[f32; LANES]; 3],
    /// (o − e)/d, the same for far planes.
    pub far_start: [[f32; LANES]; 3],
    /// 1/d; a component below 1e-20 counts as ±1e-20. Such a ray stays within its slab's margin (≥ 2⁻²⁰·W) over every
    /// distance t ≤ 2·W that matters, and 2⁻²⁰·W·1e20 is far beyond that t. And o/d stays finite for every |o| < 3e18.
    pub inverse: [[f32; LANES]; 3],
    /// Scaled directions.
    pub direction: [[f32; LANES]; 3],
    /// Largest absolute coordinates of the origins.
    pub reach: [f32; LANES],
    /// Origins in the order of the frame's axes.
    pub origin: [[f32; LANES]; 3],
    /// d_x/d_z and d_y/d_z: the shear that turns the direction into the z axis.
    pub shear: [[f32; LANES]; 2],
    /// Turns a sheared z into a distance: 1/d_z, of the scaled direction.
    pub inverse_z: [f64; LANES],
    /// Starts of the intervals, scaled; not negative, nor −0.
    pub tmin: [f32; LANES],
    /// Ends of the intervals, scaled; finite.
    pub tmax: [f32; LANES],
    /// Power of two by which the direction was scaled, and a scaled distance is to get the caller's.
    pub up: [f64; LANES],
    /// The axes that become x, y and z of the frame; z is where the direction is largest.
    pub axes: [[u32; LANES]; 3],
    /// Per axis, which side of a box is met first: 0 the lower plane, 1 the upper.
    pub near_side: [[u32; LANES]; 3],
    /// Rays that can hit anything.
    pub live: Mask,
}

/// `x`, `y` or `z`, without a branch.
#[inline(always)]
pub fn pick<T: Copy>(axis: u32, [x, y, z]: [T; 3]) -> T {
    let other = if axis == 1 { y } else { z };
    if axis == 0 { x } else { other }
}

impl Prepared {
    /// Prepares the lanes of `active`; their numbers are finite. Of the rays without a direction or with an empty
    /// interval, none is [`Prepared::live`]. Loops over all lanes without a branch, so that they are vectorised.
    #[inline(always)]
    pub fn new(rays: &Rays, active: Mask) -> Prepared {
        let zero = [0.0f32; LANES];
        let mut p = Prepared {
            near_start: [zero; 3],
            far_start: [zero; 3],
            inverse: [zero; 3],
            direction: [zero; 3],
            reach: zero,
            origin: [zero; 3],
            shear: [zero; 2],
            inverse_z: [0.0; LANES],
            tmin: zero,
            tmax: zero,
            up: [0.0; LANES],
            axes: [[0; LANES]; 3],
            near_side: [[0; LANES]; 3],
            live: 0,
        };
        let mut all_sound = [0u32; LANES];
        for (i, sound) in all_sound.iter_mut().enumerate() {
            let o = [rays.ox[i], rays.oy[i], rays.oz[i]];
            let d = [rays.dx[i], rays.dy[i], rays.dz[i]];
            let [ax, ay, az] = d.map(f32::abs);
            let x_or_y = if ay >= ax { 1 } else { 0 };
            let kz = if (az >= ax) & (az >= ay) { 2 } else { x_or_y };
            let kx = if kz == 2 { 0 } else { kz + 1 };
            let ky = if kx == 2 { 0 } else { kx + 1 };
            let largest = pick(kz, [ax, ay, az]);
            // Written so that an interval with a NaN would be refused as well.
            *sound = ((largest > 0.0) & (rays.tmin[i] <= rays.tmax[i])) as u32;
            // 2^-exponent(largest); f64 because 2^149, for denormal directions, exceeds f32.
            let exponent = ((largest as f64).to_bits() >> 52) & 0x7ff;
            let up = f64::from_bits((2046 - exponent.min(2046)) << 52);
            let scale = f64::from_bits(exponent << 52);
            let d = d.map(|x| (x as f64 * up) as f32);
            p.reach[i] = max(max(o[0].abs(), o[1].abs()), o[2].abs());
            let e = margin(p.reach[i]);
            for k in 0..3 {
                let outwards = e.copysign(d[k]);
                p.direction[k][i] = d[k];
                p.near_side[k][i] = d[k].to_bits() >> 31;
                let inverse = 1.0 / max(d[k].abs(), SMALLEST_INVERTED).copysign(d[k]);
                p.near_start[k][i] = (o[k] + outwards) * inverse;
                p.far_start[k][i] = (o[k] - outwards) * inverse;
                p.inverse[k][i] = inverse;
            }
            let along = pick(kz, d);
            (p.axes[0][i], p.axes[1][i], p.axes[2][i]) = (kx, ky, kz);
            (p.origin[0][i], p.origin[1][i], p.origin[2][i]) = (pick(kx, o), pick(ky, o), pick(kz, o));
            (p.shear[0][i], p.shear[1][i]) = (pick(kx, d) / along, pick(ky, d) / along);
            p.inverse_z[i] = 1.0 / along as f64;
            p.tmin[i] = max((rays.tmin[i] as f64 * scale) as f32, 0.0);
            // An unrepresentable distance would come out as infinity, so it counts as out of reach.
            let end = min(rays.tmax[i], f32::MAX) as f64 * scale;
            p.tmax[i] = if end < f32::MAX as f64 { end as f32 } else { f32::MAX };
            p.up[i] = up;
        }
        for (i, sound) in all_sound.iter().enumerate() {
            p.live |= (*sound as Mask) << i;
        }
        p.live &= active;
        p
    }
}
