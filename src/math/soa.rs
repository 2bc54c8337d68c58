//! Vectors of several lanes, structure of arrays.
//!
//! Plain scalar code in a loop over all lanes, from such arrays into such arrays, without calls that are not
//! inlined, becomes vector instructions of whatever width [`isa`](super::isa) compiles it for, with the bits of
//! the scalar code. Branches are fine; ends of the loop and panics are not.

use super::Vec3;

/// `N` vectors.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Vec3s<const N: usize> {
    /// Every x.
    pub x: [f32; N],
    /// Every y.
    pub y: [f32; N],
    /// Every z.
    pub z: [f32; N],
}

impl<const N: usize> Vec3s<N> {
    /// All zero.
    pub const ZERO: Vec3s<N> = Vec3s { x: [0.0; N], y: [0.0; N], z: [0.0; N] };

    /// One lane.
    #[inline(always)]
    pub fn get(&self, lane: usize) -> Vec3 {
        Vec3::new(self.x[lane], self.y[lane], self.z[lane])
    }

    /// Sets one lane.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, v: Vec3) {
        (self.x[lane], self.y[lane], self.z[lane]) = (v.x, v.y, v.z);
    }
}

/// The lanes, lane 0 the lowest bit, of which `is` holds.
#[inline(always)]
pub fn lanes_where<const N: usize>(is: impl Fn(usize) -> bool) -> u16 {
    let mut of = [false; N];
    for (lane, of) in of.iter_mut().enumerate() {
        *of = is(lane);
    }
    mask(&of)
}

/// The lanes, lane 0 the lowest bit, of which `of` says so.
#[inline(always)]
pub fn mask<const N: usize>(of: &[bool; N]) -> u16 {
    const { assert!(N <= 16) };
    let mut mask = 0;
    for (lane, is_set) in of.iter().enumerate() {
        mask |= u16::from(*is_set) << lane;
    }
    mask
}
