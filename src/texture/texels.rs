//! A picture's texels, as compact as its file: 8-bit codes stay bytes until they are looked up.

use crate::error::{Error, Result};
use crate::math::digest::Digest;
use crate::math::srgb::srgb_to_linear;
use std::sync::LazyLock;

/// Texels row by row from the top left, channel by channel.
#[derive(Clone, Debug, PartialEq)]
pub enum Data {
    /// Codes from 0 to 255.
    U8(Vec<u8>),
    /// Codes from 0 to 65535.
    U16(Vec<u16>),
    /// Linear values.
    F32(Vec<f32>),
}

impl Data {
    fn len(&self) -> usize {
        match self {
            Data::U8(values) => values.len(),
            Data::U16(values) => values.len(),
            Data::F32(values) => values.len(),
        }
    }
}

/// A picture: grey, grey and alpha, RGB, or RGB and alpha.
#[derive(Clone, Debug, PartialEq)]
pub struct Texels {
    width: u32,
    height: u32,
    channels: usize,
    data: Data,
    has_alpha: bool,
}

impl Texels {
    /// `width`·`height` texels of 1 to 4 `channels`; the second of two and the fourth of four is alpha. Floats that
    /// are not finite become 0.
    ///
    /// # Errors
    /// A picture without texels; numbers that do not fit the data.
    pub fn new(width: u32, height: u32, channels: usize, mut data: Data) -> Result<Texels> {
        let needed = (width as usize).checked_mul(height as usize).and_then(|n| n.checked_mul(channels));
        if width == 0 || height == 0 || !(1..=4).contains(&channels) || needed != Some(data.len()) {
            return Err(Error::new("the picture's texels do not fit its size"));
        }
        if let Data::F32(values) = &mut data {
            values.iter_mut().filter(|v| !v.is_finite()).for_each(|v| *v = 0.0);
        }
        let mut texels = Texels { width, height, channels, data, has_alpha: false };
        texels.has_alpha = texels.alpha_varies();
        Ok(texels)
    }

    /// Width and height.
    #[inline]
    pub fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }

    /// Adds all of it to `digest`.
    pub fn digest(&self, digest: &mut Digest) {
        let Texels { width, height, channels, data, has_alpha: _ } = self;
        digest.value(&(width, height, channels));
        match data {
            Data::U8(values) => {
                digest.value(&"u8");
                digest.bytes(values);
            }
            Data::U16(values) => {
                digest.value(&"u16");
                digest.values(values, u16::to_le_bytes);
            }
            Data::F32(values) => {
                digest.value(&"f32");
                digest.values(values, f32::to_le_bytes);
            }
        }
    }

    /// How texels are stored.
    pub(super) fn data(&self) -> &Data {
        &self.data
    }

    /// Bytes of memory.
    pub fn bytes(&self) -> u64 {
        let each = match &self.data {
            Data::U8(_) => 1,
            Data::U16(_) => 2,
            Data::F32(_) => 4,
        };
        self.data.len() as u64 * each
    }

    /// True when there is an alpha channel that says something: one that is the same everywhere is an exporter's
    /// habit, whatever its value.
    pub fn has_alpha(&self) -> bool {
        self.has_alpha
    }

    fn alpha_varies(&self) -> bool {
        fn varies<T: PartialEq>(values: &[T], channels: usize) -> bool {
            let mut alpha = values.iter().skip(channels - 1).step_by(channels);
            let first = alpha.next();
            alpha.any(|value| Some(value) != first)
        }
        self.channels.is_multiple_of(2)
            && match &self.data {
                Data::U8(values) => varies(values, self.channels),
                Data::U16(values) => varies(values, self.channels),
                Data::F32(values) => varies(values, self.channels),
            }
    }

    /// Every texel as linear RGB and alpha, row by row from the top left.
    pub fn pixels(&self, transfer: Transfer) -> impl Iterator<Item = [f32; 4]> + '_ {
        let decoder = Decoder::new(transfer, self);
        (0..self.width as usize * self.height as usize).map(move |i| self.get(i, &decoder))
    }

    /// Every `step`-th of them.
    pub fn some_pixels(&self, transfer: Transfer, step: usize) -> impl Iterator<Item = [f32; 4]> + '_ {
        let decoder = Decoder::new(transfer, self);
        let all = 0..self.width as usize * self.height as usize;
        all.step_by(step.max(1)).map(move |i| self.get(i, &decoder))
    }

    /// The value that means "no tilt" in a normal map: the middle code, so that a flat map is exactly flat.
    pub(super) fn middle(&self) -> f32 {
        match &self.data {
            Data::U8(_) => 128.0 / 255.0,
            Data::U16(_) => 32768.0 / 65535.0,
            Data::F32(_) => 0.5,
        }
    }

    /// Texel `i`, counted row by row, as linear RGB and alpha.
    #[inline(always)]
    pub(super) fn get(&self, i: usize, decoder: &Decoder) -> [f32; 4] {
        let at = i * self.channels;
        match &self.data {
            Data::U8(values) => {
                let code = |c: usize| usize::from(values[at + c]);
                self.assemble(|c| decoder.color8[code(c)], |c| code(c) as f32 * (1.0 / 255.0))
            }
            Data::U16(values) => {
                let code = |c: usize| usize::from(values[at + c]);
                self.assemble(|c| decoder.color16[code(c)], |c| code(c) as f32 * (1.0 / 65535.0))
            }
            Data::F32(values) => self.assemble(|c| values[at + c], |c| values[at + c]),
        }
    }

    #[inline(always)]
    fn assemble(&self, color: impl Fn(usize) -> f32, alpha: impl Fn(usize) -> f32) -> [f32; 4] {
        if self.channels <= 2 {
            let grey = color(0);
            [grey, grey, grey, if self.channels == 2 { alpha(1) } else { 1.0 }]
        } else {
            [color(0), color(1), color(2), if self.channels == 4 { alpha(3) } else { 1.0 }]
        }
    }
}

/// What codes mean. Floats are linear either way.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Transfer {
    /// Colours made for a display.
    Srgb,
    /// Data: shares of the largest code.
    Linear,
}

/// Codes to values by table.
#[derive(Clone, Copy, Debug)]
pub(super) struct Decoder {
    color8: &'static [f32],
    color16: &'static [f32],
}

impl Decoder {
    /// The tables that looking up in `texels` needs.
    pub fn new(transfer: Transfer, texels: &Texels) -> Decoder {
        fn table(codes: u32, value: impl Fn(f64) -> f64) -> Vec<f32> {
            (0..codes).map(|c| value(f64::from(c) / f64::from(codes - 1)) as f32).collect()
        }
        static LINEAR8: LazyLock<Vec<f32>> = LazyLock::new(|| table(1 << 8, |c| c));
        static SRGB8: LazyLock<Vec<f32>> = LazyLock::new(|| table(1 << 8, srgb_to_linear));
        static LINEAR16: LazyLock<Vec<f32>> = LazyLock::new(|| table(1 << 16, |c| c));
        static SRGB16: LazyLock<Vec<f32>> = LazyLock::new(|| table(1 << 16, srgb_to_linear));
        let (color8, color16): (&[f32], &[f32]) = match (transfer, &texels.data) {
            (Transfer::Srgb, Data::U8(_)) => (&SRGB8, &[]),
            (Transfer::Linear, Data::U8(_)) => (&LINEAR8, &[]),
            (Transfer::Srgb, Data::U16(_)) => (&[], &SRGB16),
            (Transfer::Linear, Data::U16(_)) => (&[], &LINEAR16),
            (_, Data::F32(_)) => (&[], &[]),
        };
        Decoder { color8, color16 }
    }
}
