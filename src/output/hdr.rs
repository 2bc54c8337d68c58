//! Radiance RGBE (Ward, "Real pixels", Graphics Gems II, 1991): linear, relative precision of about 1/256.

use super::Options;
use crate::error::Result;
use crate::film::Image;

/// Below this the format's exponent would fall under its range; such values are stored as zero, as in Ward's code.
const SMALLEST: f32 = 1e-32;

/// The largest value the format holds: mantissa 255/256 at exponent 127.
const LARGEST: f64 = 255.0 / 256.0 * (1u128 << 127) as f64;

/// Widths that the run-length scheme can name; others are stored flat.
const RUN_LENGTH_WIDTHS: std::ops::RangeInclusive<u32> = 8..=32767;

pub(super) fn encode(image: &Image, _options: &Options) -> Result<Vec<u8>> {
    let mut bytes = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {} +X {}\n", image.height, image.width)
        .into_bytes();
    let pixels: Vec<[u8; 4]> = image.rgb_pixels().into_iter().map(rgbe).collect();
    for row in pixels.chunks(image.width as usize) {
        if RUN_LENGTH_WIDTHS.contains(&image.width) {
            let [.., high, low] = image.width.to_be_bytes();
            bytes.extend([2, 2, high, low]);
            for component in 0..4 {
                let plane: Vec<u8> = row.iter().map(|p| p[component]).collect();
                run_length(&plane, &mut bytes);
            }
        } else {
            bytes.extend(row.iter().flatten());
        }
    }
    Ok(bytes)
}

/// Three mantissas of eight bits over the largest component's exponent, rounded to nearest (Ward truncates and
/// adds ½ when reading; readers today do not). NaN and negative components become 0, infinite ones the largest.
fn rgbe(rgb: [f32; 3]) -> [u8; 4] {
    let rgb = rgb.map(|v| f64::from(v.max(0.0)).min(LARGEST));
    let largest = rgb[0].max(rgb[1]).max(rgb[2]);
    if largest < f64::from(SMALLEST) {
        return [0; 4];
    }
    // largest = m·2^exponent with m in [½, 1).
    let mut exponent = ((largest.to_bits() >> 52) & 0x7ff) as i32 - 1022;
    if (largest * power_of_two(8 - exponent)).round() > 255.0 {
        exponent += 1;
    }
    let mantissa = |v: f64| (v * power_of_two(8 - exponent)).round() as u8;
    [mantissa(rgb[0]), mantissa(rgb[1]), mantissa(rgb[2]), (exponent + 128) as u8]
}

/// 2^n, exactly, for |n| < 1000.
fn power_of_two(n: i32) -> f64 {
    f64::from_bits(((n + 1023) as u64) << 52)
}

/// Radiance's scan line coding: a count above 128 repeats the next byte count − 128 times, another count is
/// followed by that many bytes.
fn run_length(plane: &[u8], out: &mut Vec<u8>) {
    const SHORTEST_RUN: usize = 4;
    let mut rest = plane;
    let mut literal_start = plane;
    let mut literal_len = 0;
    while let Some(&value) = rest.first() {
        let run = rest.iter().take(127).take_while(|&&v| v == value).count();
        let taken = if run >= SHORTEST_RUN {
            flush_literals(&literal_start[..literal_len], out);
            out.extend([128 + run as u8, value]);
            literal_start = &rest[run..];
            literal_len = 0;
            run
        } else {
            literal_len += run;
            run
        };
        rest = &rest[taken..];
    }
    flush_literals(&literal_start[..literal_len], out);
}

fn flush_literals(literals: &[u8], out: &mut Vec<u8>) {
    for part in literals.chunks(128) {
        out.push(part.len() as u8);
        out.extend(part);
    }
}
