//! From linear values to 8-bit sRGB: exposure, tone map, transfer function, rounding.

use super::Options;
use crate::film::Image;
use crate::math::srgb::srgb_to_linear;

/// The curve that brings values above one into a display's range; applied to each colour channel by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum ToneMap {
    /// Values are clipped at one.
    #[default]
    None,
    /// `x/(1+x)` (Reinhard et al. 2002, eq. 3, without the key).
    Reinhard,
    /// Narkowicz' (2015) rational fit of the ACES film curve. A fit of the curve only, applied in Rec.709: not
    /// the ACES colour pipeline.
    Filmic,
}

impl ToneMap {
    /// Every curve with the name it has on the command line.
    pub const NAMES: [(&'static str, ToneMap); 3] =
        [("none", ToneMap::None), ("reinhard", ToneMap::Reinhard), ("filmic", ToneMap::Filmic)];

    /// The curve of that name.
    pub fn from_name(name: &str) -> Option<ToneMap> {
        Self::NAMES.iter().find(|(n, _)| *n == name).map(|(_, curve)| *curve)
    }

    /// Maps one linear value; NaN and negative values become 0, and no value leaves [0, 1].
    pub fn apply(self, x: f32) -> f32 {
        // Written so that NaN takes the second way. The upper bound keeps the quotients below from ∞/∞.
        let x = if x > 0.0 { x.min(1e9) } else { 0.0 };
        match self {
            ToneMap::None => x.min(1.0),
            ToneMap::Reinhard => x / (1.0 + x),
            ToneMap::Filmic => ((x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14)).min(1.0),
        }
    }
}

/// Rounds linear values to the nearest of the 256 sRGB codes.
///
/// The transfer function is monotonic, so a value's code is the number of code boundaries (k + ½)/255 it has
/// passed; comparing with the boundaries' linear values is exact and needs no power per pixel.
pub struct Quantizer {
    boundaries: [f32; 255],
}

impl Quantizer {
    /// The boundaries between neighbouring codes, in linear light.
    pub fn new() -> Quantizer {
        Quantizer { boundaries: std::array::from_fn(|k| srgb_to_linear((k as f64 + 0.5) / 255.0) as f32) }
    }

    /// The code of one linear value; NaN and negative values give 0, values above one 255.
    pub fn code(&self, linear: f32) -> u8 {
        self.boundaries.partition_point(|&boundary| boundary <= linear) as u8
    }
}

impl Default for Quantizer {
    fn default() -> Self {
        Quantizer::new()
    }
}

/// The picture's colours as interleaved 8-bit sRGB, row by row from the top.
pub(super) fn to_srgb8(image: &Image, options: &Options) -> Vec<u8> {
    let quantizer = Quantizer::new();
    let gain = libm::exp2f(options.exposure);
    let pixels = image.rgb_pixels();
    pixels.iter().flatten().map(|&value| quantizer.code(options.tone_map.apply(value * gain))).collect()
}
