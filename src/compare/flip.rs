//! FLIP, the difference that a viewer notices when two pictures are shown in turn at the same place.
//!
//! LDR-FLIP: Andersson et al., "FLIP: A Difference Evaluator for Alternating Images", HPG 2020. HDR-FLIP: Andersson
//! et al., "Visualizing Errors in Rendered High Dynamic Range Images", Eurographics 2021. Constants and equations
//! are the papers', for their viewing conditions: 0.7 m from a display 0.7 m wide with 3840 pixels.

use super::filters::{Horizontal, Vertical, convolve, gaussian_kernel};
use rayon::prelude::*;

/// Which FLIP.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// For colours made for a display; values are clipped to [0, 1].
    Ldr,
    /// For linear colours of any size: the greatest LDR-FLIP over a range of exposures.
    Hdr,
}

impl Kind {
    /// `LDR` or `HDR`.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Ldr => "LDR",
            Kind::Hdr => "HDR",
        }
    }
}

type Colour = [f32; 3];

/// 0.7 m · (3840 px / 0.7 m) · π/180.
const PIXELS_PER_DEGREE: f64 = 3840.0 * std::f64::consts::PI / 180.0;

/// Exponents of the colour and feature differences, q_c and q_f.
const COLOUR_EXPONENT: f32 = 0.7;
const FEATURE_EXPONENT: f32 = 0.5;

/// p_c and p_t: differences up to p_c of the greatest are spread over [0, p_t], those above over the rest.
const KNEE_FROM: f32 = 0.4;
const KNEE_TO: f32 = 0.95;

/// Width of the edges and points that are looked for, in degrees.
const FEATURE_WIDTH: f64 = 0.082;

/// White of D65 as XYZ, the sum of the columns of [`linear_to_xyz`].
const WHITE: Colour = [0.950_428_54, 1.0, 1.088_900_4];

/// FLIP of every pixel of `test` against `reference` (linear colours, rows of `width` pixels).
pub fn map(test: &[Colour], reference: &[Colour], width: usize, kind: Kind) -> Vec<f32> {
    match kind {
        Kind::Ldr => {
            let clip =
                |pixels: &[Colour]| pixels.iter().map(|p| p.map(|v| v.clamp(0.0, 1.0))).collect::<Vec<_>>();
            ldr_map(&clip(test), &clip(reference), width)
        }
        Kind::Hdr => {
            let mut greatest = vec![0.0_f32; test.len()];
            for exposure in exposures(reference) {
                let gain = libm::exp2f(exposure);
                let show =
                    |pixels: &[Colour]| pixels.iter().map(|p| p.map(|v| aces(v * gain))).collect::<Vec<_>>();
                let here = ldr_map(&show(test), &show(reference), width);
                greatest.iter_mut().zip(here).for_each(|(most, value)| *most = most.max(value));
            }
            greatest
        }
    }
}

/// Narkowicz' fit of the ACES curve with its exposure of 0.6 included, clipped to [0, 1]: the 2021 paper's choice.
const ACES: [f64; 6] = [0.6 * 0.6 * 2.51, 0.6 * 0.03, 0.0, 0.6 * 0.6 * 2.43, 0.6 * 0.59, 0.14];

fn aces(x: f32) -> f32 {
    let k = ACES.map(|k| k as f32);
    // The bounds keep negative values and ∞/∞ out.
    let x = x.clamp(0.0, 1e9);
    ((k[0] * x * x + k[1] * x + k[2]) / (k[3] * x * x + k[4] * x + k[5])).clamp(0.0, 1.0)
}

/// The exposures in EV: from where the brightest pixel of the reference comes to 85 % of white to where the median
/// does (2021, section 3.2), in steps of at most about one.
fn exposures(reference: &[Colour]) -> Vec<f32> {
    let mut luminances: Vec<f32> = reference.iter().map(luminance).collect();
    let middle = luminances.len() / 2;
    luminances.sort_unstable_by(f32::total_cmp);
    let median = luminances.get(middle).copied().unwrap_or(0.0);
    let brightest = luminances.last().copied().unwrap_or(0.0);
    if brightest <= 0.0 {
        return vec![0.0];
    }
    // A mostly black reference has no median to expose for; the authors' program takes the same stand-in.
    let dark = median.max(f32::EPSILON).min(brightest);

    // Where the curve takes the value 0.85: the greater root of the quadratic.
    let [a, b, c] = [0, 1, 2].map(|i| 0.85 * ACES[i + 3] - ACES[i]);
    let x = -0.5 * b / a + (0.25 * b * b / (a * a) - c / a).sqrt();
    let start = libm::log2(x / f64::from(brightest));
    let stop = libm::log2(x / f64::from(dark));
    let count = (stop - start).ceil().max(2.0);
    (0..count as u32).map(|i| (start + (stop - start) * f64::from(i) / (count - 1.0)) as f32).collect()
}

fn luminance(p: &Colour) -> f32 {
    0.2126 * p[0] + 0.7152 * p[1] + 0.0722 * p[2]
}

/// LDR-FLIP of linear colours in [0, 1].
fn ldr_map(test: &[Colour], reference: &[Colour], width: usize) -> Vec<f32> {
    let [test, reference] =
        [test, reference].map(|pixels| pixels.par_iter().map(opponent).collect::<Vec<_>>());
    let [seen_test, seen_reference] = [&test, &reference].map(|pixels| perceived(pixels, width));
    let [features_test, features_reference] = [&test, &reference].map(|pixels| features(pixels, width));
    let greatest = greatest_colour_difference();

    let colours = seen_test.par_iter().zip(&seen_reference);
    let features = features_test.par_iter().zip(&features_reference);
    colours
        .zip(features)
        .map(|((a, b), (f, g))| {
            let colour = spread(libm::powf(hyab(a, b), COLOUR_EXPONENT), greatest);
            let feature = (f[0] - g[0]).abs().max((f[1] - g[1]).abs());
            let feature = libm::powf(feature * std::f32::consts::FRAC_1_SQRT_2, FEATURE_EXPONENT);
            // A difference in structure makes the difference in colour more visible (2020, eq. 9).
            libm::powf(colour, 1.0 - feature.min(1.0))
        })
        .collect()
}

/// Linear Rec.709 to XYZ.
fn linear_to_xyz(c: &Colour) -> Colour {
    [
        0.412_386_56 * c[0] + 0.357_591_5 * c[1] + 0.180_450_49 * c[2],
        0.212_636_82 * c[0] + 0.715_183 * c[1] + 0.072_180_2 * c[2],
        0.019_330_62 * c[0] + 0.119_197_16 * c[1] + 0.950_372_6 * c[2],
    ]
}

/// XYZ to linear Rec.709.
fn xyz_to_linear(c: &Colour) -> Colour {
    [
        3.241_003_2 * c[0] - 1.537_399 * c[1] - 0.498_615_9 * c[2],
        -0.969_224_3 * c[0] + 1.875_93 * c[1] + 0.041_554_226 * c[2],
        0.055_639_423 * c[0] - 0.204_011_2 * c[1] + 1.057_149 * c[2],
    ]
}

/// Linear Rec.709 to YCxCz, the opponent space that the eye's contrast sensitivity is measured in.
fn opponent(c: &Colour) -> Colour {
    let xyz = linear_to_xyz(c);
    let [x, y, z] = [0, 1, 2].map(|i| xyz[i] / WHITE[i]);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// YCxCz to linear Rec.709.
fn opponent_to_linear(c: &Colour) -> Colour {
    let y = (c[0] + 16.0) / 116.0;
    xyz_to_linear(&[(y + c[1] / 500.0) * WHITE[0], y * WHITE[1], (y - c[2] / 200.0) * WHITE[2]])
}

/// L*a*b* with a and b weighted by the lightness: saturation is less visible in the dark (Hunt's effect).
fn hunt_lab(c: &Colour) -> Colour {
    const DELTA: f32 = 6.0 / 29.0;
    let f = |t: f32| {
        if t > DELTA * DELTA * DELTA { libm::cbrtf(t) } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 }
    };
    let xyz = linear_to_xyz(c);
    let [x, y, z] = [0, 1, 2].map(|i| f(xyz[i] / WHITE[i]));
    let lightness = 116.0 * y - 16.0;
    [lightness, 0.01 * lightness * 500.0 * (x - y), 0.01 * lightness * 200.0 * (y - z)]
}

/// Distance for large differences (Abasi et al. 2020): city block in lightness, Euclidean in chroma.
fn hyab(a: &Colour, b: &Colour) -> f32 {
    let [l, x, y] = [0, 1, 2].map(|i| a[i] - b[i]);
    l.abs() + (x * x + y * y).sqrt()
}

/// The greatest difference of two colours of a display, green and blue, to the power q_c.
fn greatest_colour_difference() -> f32 {
    libm::powf(hyab(&hunt_lab(&[0.0, 1.0, 0.0]), &hunt_lab(&[0.0, 0.0, 1.0])), COLOUR_EXPONENT)
}

/// 2020, eq. 6: most of [0, 1] is given to the differences that occur.
fn spread(difference: f32, greatest: f32) -> f32 {
    let knee = KNEE_FROM * greatest;
    if difference < knee {
        KNEE_TO / knee * difference
    } else {
        KNEE_TO + (difference - knee) / (greatest - knee) * (1.0 - KNEE_TO)
    }
}

/// What the eye sees of a picture from its distance, as Hunt-adjusted L*a*b*: YCxCz blurred by the contrast
/// sensitivity functions. Those are Gaussians, a√(π/b) exp(−π²d²/b) at d degrees; blue–yellow has two (2020, table 1).
fn perceived(pixels: &[Colour], width: usize) -> Vec<Colour> {
    const WEIGHTS: [f64; 4] = [1.0, 1.0, 34.1, 13.5];
    const WIDTHS: [f64; 4] = [0.0047, 0.0053, 0.04, 0.025];
    let pi = std::f64::consts::PI;
    let radius = (3.0 * (0.04 / (2.0 * pi * pi)).sqrt() * PIXELS_PER_DEGREE).ceil() as usize;
    // Two-dimensional Gaussians separate; each is normalized by itself, and the two of Cz are weighted with what
    // their unnormalized sums would have been.
    let kernels =
        WIDTHS.map(|b| gaussian_kernel(radius, pi * pi / (b * PIXELS_PER_DEGREE * PIXELS_PER_DEGREE)));
    let volume = |i: usize| {
        let sum: f64 = kernels[i].iter().sum();
        WEIGHTS[i] * (pi / WIDTHS[i]).sqrt() * sum * sum
    };
    let first_share = (volume(2) / (volume(2) + volume(3))) as f32;
    let kernel: Vec<[f32; 4]> = (0..=2 * radius)
        .map(|k| [0, 1, 2, 3].map(|i| (kernels[i][k] / kernels[i].iter().sum::<f64>()) as f32))
        .collect();

    let lanes: Vec<[f32; 4]> = pixels.iter().map(|p| [p[0], p[1], p[2], p[2]]).collect();
    let multiply =
        |sum: [f32; 4], value: &[f32; 4], k: &[f32; 4]| [0, 1, 2, 3].map(|i| sum[i] + value[i] * k[i]);
    let blurred = convolve::<Horizontal, _, _, _>(&lanes, width, &kernel, multiply);
    let blurred = convolve::<Vertical, _, _, _>(&blurred, width, &kernel, multiply);
    blurred
        .par_iter()
        .map(|p| {
            let cz = first_share * p[2] + (1.0 - first_share) * p[3];
            hunt_lab(&opponent_to_linear(&[p[0], p[1], cz]).map(|v| v.clamp(0.0, 1.0)))
        })
        .collect()
}

/// Strength of edges and of points at every pixel (2020, section 4.2): the lengths of the first and the second
/// derivatives of a Gaussian applied to the lightness.
fn features(pixels: &[Colour], width: usize) -> Vec<[f32; 2]> {
    let deviation = 0.5 * FEATURE_WIDTH * PIXELS_PER_DEGREE;
    let radius = (3.0 * deviation).ceil() as usize;
    let smooth = gaussian_kernel(radius, 0.5 / (deviation * deviation));
    let offset = |k: usize| k as f64 - radius as f64;
    let edge: Vec<f64> = smooth.iter().enumerate().map(|(k, g)| -offset(k) * g).collect();
    let point: Vec<f64> = smooth
        .iter()
        .enumerate()
        .map(|(k, g)| (offset(k) * offset(k) / (deviation * deviation) - 1.0) * g)
        .collect();
    let [smooth, edge, point] = [smooth, edge, point].map(|kernel| balanced(&kernel));
    let kernel: Vec<[f32; 3]> = (0..=2 * radius).map(|k| [smooth[k], edge[k], point[k]]).collect();

    let lightness: Vec<f32> = pixels.iter().map(|p| (p[0] + 16.0) / 116.0).collect();
    let rows = convolve::<Horizontal, _, _, _>(&lightness, width, &kernel, |sum: [f32; 3], value, k| {
        [0, 1, 2].map(|i| sum[i] + value * k[i])
    });
    // Edge and point, each across and along.
    let both = convolve::<Vertical, _, _, _>(&rows, width, &kernel, |sum: [f32; 4], value, k| {
        [
            sum[0] + value[1] * k[0],
            sum[1] + value[0] * k[1],
            sum[2] + value[2] * k[0],
            sum[3] + value[0] * k[2],
        ]
    });
    both.iter().map(|[ex, ey, px, py]| [(ex * ex + ey * ey).sqrt(), (px * px + py * py).sqrt()]).collect()
}

/// Scales a kernel's positive weights to the sum 1 and its negative ones to −1.
fn balanced(kernel: &[f64]) -> Vec<f32> {
    let positive: f64 = kernel.iter().filter(|w| **w > 0.0).sum();
    let negative: f64 = -kernel.iter().filter(|w| **w < 0.0).sum::<f64>();
    kernel
        .iter()
        .map(|&w| {
            (if w > 0.0 {
                w / positive
            } else if w < 0.0 {
                w / negative
            } else {
                0.0
            }) as f32
        })
        .collect()
}
