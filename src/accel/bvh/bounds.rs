//! Boxes as the builder likes them: upper planes negated, so that every union is one element-wise minimum.

use glam::Vec4;

/// Lanes 0–2 hold the lower corner, lanes 4–6 the negated upper corner; lanes 3 and 7 belong to the owner
/// and are not part of the box.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub struct Bounds(pub [f32; 8]);

impl Bounds {
    /// The box that holds nothing.
    pub const EMPTY: Bounds = Bounds([f32::INFINITY; 8]);

    /// The box around three corners, with two words of the owner's.
    #[inline(always)]
    pub fn of_triangle([a, b, c]: [[f32; 3]; 3], first: u32, second: u32) -> Bounds {
        let mut bounds = [0.0; 8];
        for k in 0..3 {
            bounds[k] = a[k].min(b[k]).min(c[k]);
            bounds[k + 4] = -a[k].max(b[k]).max(c[k]);
        }
        (bounds[3], bounds[7]) = (f32::from_bits(first), f32::from_bits(second));
        Bounds(bounds)
    }

    /// This box with other words.
    #[inline(always)]
    pub fn with_words(mut self, first: u32, second: u32) -> Bounds {
        (self.0[3], self.0[7]) = (f32::from_bits(first), f32::from_bits(second));
        self
    }

    /// The owner's two words.
    #[inline(always)]
    pub fn words(&self) -> (u32, u32) {
        (self.0[3].to_bits(), self.0[7].to_bits())
    }

    /// Smallest corner.
    #[inline(always)]
    pub fn lo(&self) -> [f32; 3] {
        [self.0[0], self.0[1], self.0[2]]
    }

    /// Largest corner.
    #[inline(always)]
    pub fn hi(&self) -> [f32; 3] {
        [-self.0[4], -self.0[5], -self.0[6]]
    }

    /// Grows to hold `other`. Minima are associative and commutative, so no order of the work shows.
    #[inline(always)]
    pub fn add(&mut self, other: &Bounds) {
        // glam's minimum, since of `if a < b { a } else { b }` the compiler makes a masked store where the
        // machine has one, and the next load of the same box has to wait for that.
        for half in [0, 4] {
            let (mine, theirs) = (&mut self.0[half..half + 4], &other.0[half..half + 4]);
            Vec4::from_slice(theirs).min(Vec4::from_slice(mine)).write_to_slice(mine);
        }
    }

    /// The smallest box around both.
    #[inline(always)]
    pub fn union(mut self, other: &Bounds) -> Bounds {
        self.add(other);
        self
    }

    /// Whether it and the extent of any box around such boxes are finite.
    pub fn is_in_range(&self) -> bool {
        self.lo().iter().chain(&self.hi()).all(|x| x.abs() <= f32::MAX / 4.0)
    }

    /// Lower plus upper corner: twice the middle (halving would change nothing but cost).
    #[inline(always)]
    pub fn middle2(&self) -> [f32; 4] {
        let b = &self.0;
        [b[0] - b[4], b[1] - b[5], b[2] - b[6], 0.0]
    }

    /// The box of one point.
    #[inline(always)]
    pub fn point([x, y, z, _]: [f32; 4]) -> Bounds {
        Bounds([x, y, z, 0.0, -x, -y, -z, 0.0])
    }

    /// This box, or the empty one; without a branch.
    #[inline(always)]
    pub fn or_empty(self, keep: bool) -> Bounds {
        Bounds(self.0.map(|x| if keep { x } else { f32::INFINITY }))
    }

    /// Moved outwards on all sides; the empty box stays empty.
    #[inline(always)]
    pub fn enlarged(self, by: f32) -> Bounds {
        Bounds(self.0.map(|x| x - by))
    }

    /// What of this box is in `other`, with the words of `other`'s owner.
    #[inline(always)]
    pub fn within(self, other: &Bounds) -> Bounds {
        let mut both = *other;
        for k in [0, 1, 2, 4, 5, 6] {
            both.0[k] = both.0[k].max(self.0[k]);
        }
        both
    }

    /// True when no point is inside.
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.extent().iter().any(|e| *e < 0.0)
    }

    /// Edge lengths; negative for the empty box.
    #[inline(always)]
    pub fn extent(&self) -> [f32; 3] {
        let b = &self.0;
        [-b[4] - b[0], -b[5] - b[1], -b[6] - b[2]]
    }

    /// Half the surface area; 0 for the empty box. In f64, where neither 1e18² nor 1e-40² leaves the range.
    #[inline(always)]
    pub fn half_area(&self) -> f64 {
        let [x, y, z] = self.extent().map(|e| e.max(0.0) as f64);
        x * (y + z) + y * z
    }
}
