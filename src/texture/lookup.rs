//! From a place in the unit square to a filtered texel.

use super::texels::{Decoder, Texels};
use crate::error::{Result, lookup as find_word};

/// What happens between the centres of texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Filter {
    /// The four nearest texels, by distance.
    Bilinear,
    /// The texel that the point is in.
    Nearest,
}

impl Filter {
    /// Name, meaning, value; the first is the default.
    pub const TABLE: &'static [(&'static str, &'static str, Filter)] = &[
        ("bilinear", "the four nearest texels, by distance", Filter::Bilinear),
        ("nearest", "the texel that the point is in", Filter::Nearest),
    ];

    /// The filter of that name.
    pub fn from_name(word: &str) -> Result<Filter> {
        find_word("texture filter", word, Self::TABLE)
    }
}

/// What happens outside the unit square.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Wrap {
    /// The picture again.
    Repeat,
    /// Its border.
    Clamp,
    /// The picture again, every other one turned over.
    Mirror,
}

impl Wrap {
    /// Name, meaning, value; the first is the default.
    pub const TABLE: &'static [(&'static str, &'static str, Wrap)] = &[
        ("repeat", "the picture again and again", Wrap::Repeat),
        ("clamp", "the picture's border goes on", Wrap::Clamp),
        ("mirror", "the picture again, every other one turned over", Wrap::Mirror),
    ];

    /// The mode of that name.
    pub fn from_name(word: &str) -> Result<Wrap> {
        find_word("texture wrap", word, Self::TABLE)
    }

    /// `x`, in pictures, brought near the first one; exact in f32 as long as the fraction is. What is not finite
    /// becomes 0.
    #[inline]
    fn fold(self, x: f32) -> f32 {
        let folded = match self {
            Wrap::Repeat => x - x.floor(),
            Wrap::Clamp => x.clamp(-1.0, 2.0),
            Wrap::Mirror => x - 2.0 * (0.5 * x).floor(),
        };
        if folded.is_finite() { folded } else { 0.0 }
    }

    /// The texel among `n` that stands at place `i`, −1 to 3n.
    #[inline]
    fn index(self, i: i32, n: i32) -> usize {
        let place = match self {
            Wrap::Repeat => i.rem_euclid(n),
            Wrap::Clamp => i.clamp(0, n - 1),
            Wrap::Mirror => {
                let i = i.rem_euclid(2 * n);
                if i < n { i } else { 2 * n - 1 - i }
            }
        };
        place as usize
    }
}

/// Linear RGB and alpha at `u`, `v`, counted from the bottom left corner.
pub(super) fn lookup(
    texels: &Texels,
    decoder: &Decoder,
    filter: Filter,
    wrap: Wrap,
    [u, v]: [f32; 2],
) -> [f32; 4] {
    let [width, height] = texels.size();
    // Pictures have at most 2²⁸ texels, so sizes fit.
    let (columns, rows) = (width as i32, height as i32);
    let (x, y) = (wrap.fold(u) * width as f32, wrap.fold(v) * height as f32);
    let at = |x: i32, y: i32| {
        // Stored from the top, counted from the bottom.
        let row = height as usize - 1 - wrap.index(y, rows);
        texels.get(row * width as usize + wrap.index(x, columns), decoder)
    };
    match filter {
        Filter::Nearest => at(x.floor() as i32, y.floor() as i32),
        Filter::Bilinear => {
            let (x, y) = (x - 0.5, y - 0.5);
            let (left, low) = (x.floor(), y.floor());
            let (s, t) = (x - left, y - low);
            let (left, low) = (left as i32, low as i32);
            let row = |y: i32| mix(at(left, y), at(left + 1, y), s);
            mix(row(low), row(low + 1), t)
        }
    }
}

/// a + (b − a)·t: exact where both are equal.
#[inline]
fn mix(a: [f32; 4], b: [f32; 4], t: f32) -> [f32; 4] {
    std::array::from_fn(|i| a[i] + (b[i] - a[i]) * t)
}
